//! Writes a file completely or not at all: it is staged under a temporary name and renamed when it is complete.

use super::inputs::refuse_guarded;
use super::moves::{Move, make_all};
use super::output_set::StagedFolder;
use super::staged::{Commit, Temporary, folder_of, sync_file, sync_folder};
use crate::mesh::NumbersApart;
use azimesh_core::error::{Error, ErrorKind, Result, option};
use azimesh_core::ranks::hash::HashedBytes;
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, StdoutLock, Write};
use std::path::{Path, PathBuf};

/// Size of the write buffer and of the largest single write, in bytes: in writes of 4 MB and more Linux was measured
/// to stall for a third of a second now and then.
pub(super) const PIECE: usize = 1 << 20;

/// Staged files: complete, but still under temporary names. They are removed when this is dropped.
#[must_use]
pub struct Staged(Vec<Part>);

/// A part of an output, until it has its name.
enum Part {
    File {
        temporary: Temporary,
        target: PathBuf,
        commit: Commit,
    },
    Folder(StagedFolder),
    /// Called once files and folders have their names.
    Act(Box<dyn FnOnce() -> Result<()> + Send>),
}

impl Staged {
    /// Nothing but a call once files that it is kept with have their names.
    pub fn act(act: impl FnOnce() -> Result<()> + Send + 'static) -> Self {
        Self(vec![Part::Act(Box::new(act))])
    }

    /// The files of a staged folder.
    pub(super) fn folder(folder: StagedFolder) -> Self {
        Self(vec![Part::Folder(folder)])
    }

    /// Several staged outputs as one, in order.
    pub fn all(files: Vec<Self>) -> Self {
        Self(files.into_iter().flat_map(|one| one.0).collect())
    }

    /// Renames the files to their final names: all of them, or none after an error. A signal that ends the program waits.
    pub fn keep(self) -> Result<()> {
        let mut moves = Vec::new();
        let mut folders = BTreeSet::new();
        for part in &self.0 {
            match part {
                Part::File {
                    temporary,
                    target,
                    commit,
                } => {
                    if commit.sync {
                        let synced = sync_file(temporary.path());
                        synced.map_err(|error| Error::io(target, &error))?;
                        folders.insert(folder_of(target).to_path_buf());
                    }
                    moves.push(Move {
                        from: temporary.path().to_path_buf(),
                        to: target.clone(),
                        replace: commit.replace,
                        sync: commit.sync,
                    });
                }
                Part::Folder(folder) => {
                    moves.extend(folder.moves()?);
                    folders.extend(folder.synced());
                }
                Part::Act(_) => {}
            }
        }
        make_all(moves)?;
        let sync =
            |folder: &PathBuf| sync_folder(folder).map_err(|error| Error::io(folder, &error));
        folders.iter().try_for_each(sync)?;
        self.0.into_iter().try_for_each(|part| match part {
            Part::Act(act) => act(),
            Part::File { .. } | Part::Folder(_) => Ok(()),
        })
    }
}

/// Writes text to `path`, completely or not at all.
pub fn save_text(text: &str, path: &Path, commit: Commit) -> Result<()> {
    stage_bytes(text.as_bytes(), path, commit)?.keep()
}

/// Stages a file with these bytes.
pub fn stage_bytes(bytes: &[u8], path: &Path, commit: Commit) -> Result<Staged> {
    let staged = stage_file(path, commit, |out| {
        let written = out.write_all(bytes);
        written.map_err(|error| Error::io(path, &error))
    })?;
    Ok(staged.1)
}

/// Stages a file that `write` fills. Where `path` is standard output, a device or a pipe, it is written to directly.
pub(super) fn stage_file<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&mut dyn Out) -> Result<T>,
) -> Result<(T, Staged)> {
    if let Some(stream) = stream(path, commit)? {
        let standard = (path.as_os_str() == "-").then(|| Path::new("<stdout>"));
        let written = fill(stream, None, standard.unwrap_or(path), write)?;
        return Ok((written, Staged(Vec::new())));
    }
    // Links are followed.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let failed = |error: io::Error| Error::io(path, &error);
    let (file, mut temporary) = Temporary::file_for(&target).map_err(failed)?;
    let copy = file.try_clone().map_err(failed)?;
    let written = fill(Box::new(file), Some((copy, temporary.path())), path, write)?;
    temporary.close();
    let staged = Part::File {
        temporary,
        target,
        commit,
    };
    Ok((written, Staged(vec![staged])))
}

/// Stages a file as [`stage_file`] does; `write` is given its path. What goes to standard output, a device or a pipe is
/// copied from a temporary file.
pub(super) fn stage_path<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&Path) -> Result<T>,
) -> Result<(T, Staged)> {
    let write = |temporary: &Path| {
        write(temporary).map_err(|mut error| {
            // The user knows `path`, not the temporary file.
            error.path = error.path.filter(|path| path != temporary);
            error
        })
    };
    stage_file(path, commit, |out| {
        if let Some(staged) = out.path().map(Path::to_path_buf) {
            return write(&staged);
        }
        let target = std::env::temp_dir().join("azimesh");
        let failed = |error: io::Error| Error::io(&target, &error);
        let (mut file, temporary) = Temporary::file_for(&target).map_err(failed)?;
        let written = write(temporary.path()).map_err(|error| match error.kind {
            ErrorKind::System => error.file(temporary.path()),
            _ => error,
        })?;
        io::copy(&mut file, out).map_err(|error| Error::io(Path::new(""), &error))?;
        Ok(written)
    })
}

/// Writes the file at this path, which is in a staged folder.
pub(super) fn fill_file<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Out) -> Result<T>,
) -> Result<T> {
    let failed = |error: io::Error| Error::io(path, &error);
    let file = File::create(path).map_err(failed)?;
    let copy = file.try_clone().map_err(failed)?;
    fill(Box::new(file), Some((copy, path)), path, write)
}

fn fill<'a, T>(
    out: Box<dyn Write + 'a>,
    file: Option<(File, &'a Path)>,
    path: &Path,
    write: impl FnOnce(&mut dyn Out) -> Result<T>,
) -> Result<T> {
    let out = BufWriter::with_capacity(PIECE, out);
    let mut filled = Filled { out, file };
    let written = write(&mut filled).map_err(|error| error.file(path))?;
    filled.flush().map_err(|error| Error::io(path, &error))?;
    Ok(written)
}

/// Standard output, or an opened device or pipe; `None` where the path names a file, new or to be replaced. Refuses
/// an existing file that must not be replaced.
fn stream(path: &Path, commit: Commit) -> Result<Option<Box<dyn Write>>> {
    if path.as_os_str() == "-" {
        return Ok(Some(Box::new(UntilClosed(io::stdout().lock()))));
    }
    commit.check(path)?;
    let failed = |error: io::Error| Error::io(path, &error);
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(Error::input("this is a folder, not a file").file(path)),
        Ok(found) if !found.is_file() => {
            let device = OpenOptions::new().write(true).open(path).map_err(failed)?;
            Ok(Some(Box::new(device)))
        }
        Err(error) if error.kind() == io::ErrorKind::InvalidFilename => Err(failed(error)),
        _ => Ok(None),
    }
}

impl Commit {
    /// Refuses an existing file, or a symbolic link to a file that does not exist, unless it is to be replaced.
    /// Standard output, devices and pipes are accepted. A guarded input is refused always.
    pub fn check(self, path: &Path) -> Result<()> {
        refuse_guarded(path)?;
        if path.as_os_str() == "-" {
            return Ok(());
        }
        match fs::metadata(path) {
            _ if self.replace => Ok(()),
            Ok(found) if found.is_file() => Err(exists(path)),
            Err(_) if path.is_symlink() => Err(Error::input(format!(
                "is a symbolic link to a file that does not exist; {} replaces it",
                option("force")
            ))
            .file(path)),
            _ => Ok(()),
        }
    }
}

pub(super) fn exists(path: &Path) -> Error {
    Error::input(format!("exists already; {} replaces it", option("force"))).file(path)
}

/// Checks if a path leads to a device or a pipe.
pub(super) fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// Refuses a pipe or a device under the name of a file that is to be written, but that the user has not named: a pipe
/// blocks until a program reads from it.
pub fn refuse_special(path: &Path) -> Result<()> {
    if !is_special(path) {
        return Ok(());
    }
    let message = "a file of this name is needed here, but this is a pipe or a device; remove it";
    Err(Error::input(message).file(path))
}

/// Takes the bytes of a file front to back; some of them may be written by other ranks.
pub trait Out: Write {
    /// Has other ranks write the next bytes. Gives their hashes of these bytes, from byte `hash_from` on.
    ///
    /// # Errors
    /// If this is not a file: ranks can open only files.
    fn apart(&mut self, _numbers: &NumbersApart, _hash_from: u64) -> Result<Vec<HashedBytes>> {
        Err(no_file())
    }

    /// The path of the file, where it is one.
    fn path(&self) -> Option<&Path> {
        None
    }
}

fn no_file() -> Error {
    Error::system("what other ranks have is written to files only")
}

impl Out for Vec<u8> {}

/// Written by no rank.
impl Out for io::Sink {
    fn apart(&mut self, _: &NumbersApart, _: u64) -> Result<Vec<HashedBytes>> {
        Ok(Vec::new())
    }
}

impl Out for BufWriter<&mut dyn Out> {
    fn apart(&mut self, numbers: &NumbersApart, hash_from: u64) -> Result<Vec<HashedBytes>> {
        self.flush()
            .map_err(|error| Error::system(error.to_string()))?;
        self.get_mut().apart(numbers, hash_from)
    }
}

/// A file or a stream that is filled.
struct Filled<'a> {
    out: BufWriter<Box<dyn Write + 'a>>,
    file: Option<(File, &'a Path)>,
}

impl Out for Filled<'_> {
    fn apart(&mut self, numbers: &NumbersApart, hash_from: u64) -> Result<Vec<HashedBytes>> {
        let Some((file, path)) = &mut self.file else {
            return Err(no_file());
        };
        let failed = |error: io::Error| Error::system(error.to_string());
        self.out.flush().map_err(failed)?;
        let at = file.stream_position().map_err(failed)?;
        let hashed = (numbers.by).write(Some((path, at)), &numbers.numbers, hash_from)?;
        let end = SeekFrom::Start(at + numbers.n_bytes);
        file.seek(end).map_err(failed)?;
        Ok(hashed)
    }

    fn path(&self) -> Option<&Path> {
        self.file.as_ref().map(|(_, path)| *path)
    }
}

impl Write for Filled<'_> {
    /// Writes at most [`PIECE`] bytes at a time.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(&bytes[..bytes.len().min(PIECE)])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Standard output, whose reader may close it early, as `head` does: what is written after that is discarded.
struct UntilClosed(StdoutLock<'static>);

fn unless_closed<T>(written: io::Result<T>, closed: T) -> io::Result<T> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(closed),
        written => written,
    }
}

impl Write for UntilClosed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        unless_closed(self.0.write(bytes), bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        unless_closed(self.0.flush(), ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("the folder is there");
        let name = |entry: io::Result<fs::DirEntry>| entry.expect("it can be listed").file_name();
        let mut names: Vec<String> = entries
            .map(|entry| name(entry).to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.txt");
        save_text("old", &path, Commit::REPLACE).expect("it can be written");
        let failed = stage_file(&path, Commit::REPLACE, |out| -> Result<()> {
            out.write_all(b"half").expect("it is buffered");
            Err(Error::system("disk full"))
        });
        let message = failed.err().expect("it failed").to_string();
        assert!(message.ends_with("mesh.txt: disk full"), "{message}");
        assert_eq!(fs::read_to_string(&path).expect("it is kept"), "old");
        assert_eq!(names(folder.path()), ["mesh.txt"]);
    }

    #[test]
    fn a_missing_folder_is_wrong_input() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = save_text("x", &folder.path().join("no/mesh.txt"), Commit::REPLACE)
            .expect_err("no folder");
        assert_eq!(error.kind, azimesh_core::error::ErrorKind::Input);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_a_device() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.txt");
        let link = folder.path().join("link.txt");
        save_text("old", &path, Commit::REPLACE).expect("it can be written");
        std::os::unix::fs::symlink(&path, &link).expect("links are known");
        save_text("new", &link, Commit::REPLACE).expect("it can be written");
        assert!(
            fs::symlink_metadata(&link)
                .expect("it is there")
                .is_symlink()
        );
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "new");
        save_text("x", Path::new("/dev/null"), Commit::REPLACE).expect("it takes everything");
        assert!(!fs::metadata("/dev/null").expect("it is there").is_file());
    }

    #[cfg(unix)]
    #[test]
    fn what_has_a_name_stays_without_force_and_gives_its_permissions_with_it() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.txt");
        save_text("old", &path, Commit::with_force(false)).expect("the name is free");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("it is ours");
        let refused = save_text("new", &path, Commit::with_force(false)).expect_err("it is taken");
        assert_eq!(refused.kind, ErrorKind::Input);
        save_text("new", &path, Commit::with_force(true)).expect("it is replaced");
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "new");
        let mode = fs::metadata(&path)
            .expect("it is there")
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o640);
        for (link, leads_to) in [("dangling", "nowhere"), ("loop", "loop")] {
            let link = folder.path().join(link);
            symlink(leads_to, &link).expect("links are known");
            let refused = save_text("x", &link, Commit::with_force(false)).expect_err("a link");
            assert_says(&refused.message, "symbolic link");
            assert!(link.is_symlink());
            save_text("x", &link, Commit::with_force(true)).expect("it is replaced");
            assert_eq!(fs::read_to_string(&link).expect("it is there"), "x");
        }
    }

    #[test]
    fn a_name_may_be_as_long_as_the_file_system_allows() {
        let folder = tempfile::tempdir().expect("a folder");
        let named = |n: usize| folder.path().join("m".repeat(n));
        save_text("x", &named(255), Commit::REPLACE).expect("it fits");
        let refused = save_text("x", &named(256), Commit::REPLACE).expect_err("too long");
        assert_eq!(refused.kind, ErrorKind::Input);
        assert_says(&refused.message, "longer");
        assert_eq!(names(folder.path()).len(), 1);
    }

    #[test]
    fn of_several_that_want_a_new_name_one_gets_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.txt");
        let stage = |text: &str| stage_bytes(text.as_bytes(), &path, Commit::with_force(false));
        let staged = ["first", "second"].map(|text| stage(text).expect("the name is free"));
        let [first, second] = staged.map(Staged::keep);
        first.expect("the name was free");
        let refused = second.expect_err("it is taken");
        assert_eq!(
            (refused.kind, refused.message.as_str()),
            (ErrorKind::Input, "exists already; `force` replaces it")
        );
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "first");
        assert_eq!(names(folder.path()), ["mesh.txt"]);
    }
}
