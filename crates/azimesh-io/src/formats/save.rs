//! Writes a file completely or not at all: it is staged under a temporary name and renamed when it is complete.

use super::inputs::refuse_guarded;
use super::out::Out;
use super::sink::{Sink, name_of};
use super::staged::{Commit, Temporary, folder_of, sync_folder};
use crate::mesh::NumbersApart;
use azimesh_core::error::{Error, ErrorKind, Result, option};
use azimesh_core::ranks::hash::HashedBytes;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Size of the write buffer and of the largest single write, in bytes: in writes of 4 MB and more Linux was measured
/// to stall for a third of a second now and then.
pub(super) const PIECE: usize = 1 << 20;

/// Renames files to their final names; returns the folder that is to be synced after that.
type GiveNames = Box<dyn FnOnce() -> Result<Option<PathBuf>> + Send>;

/// Staged files: complete, but still under temporary names. They are removed when this is dropped.
#[must_use]
pub struct Staged(GiveNames);

impl Staged {
    /// `give` renames the files and returns their folder if that is to be synced; dropping it removes them.
    pub fn new(give: impl FnOnce() -> Result<Option<PathBuf>> + Send + 'static) -> Self {
        Self(Box::new(give))
    }

    /// Several staged outputs as one, in order.
    pub fn all(files: Vec<Self>) -> Self {
        Self::new(|| Self::keep_all(files).map(|()| None))
    }

    /// Renames the files to their final names.
    pub fn keep(self) -> Result<()> {
        Self::keep_all([self])
    }

    /// Renames the files of several outputs, in order.
    pub fn keep_all(files: impl IntoIterator<Item = Self>) -> Result<()> {
        let mut folders = BTreeSet::new();
        let mut give = |file: Self| {
            folders.extend((file.0)()?);
            Ok(())
        };
        let given = files.into_iter().try_for_each(&mut give);
        let sync =
            |folder: &PathBuf| sync_folder(folder).map_err(|error| Error::io(folder, &error));
        given.and(folders.iter().try_for_each(sync))
    }
}

/// Writes text to `path`, completely or not at all.
pub fn save_text(text: &str, path: &Path, commit: Commit) -> Result<()> {
    stage_bytes(text.as_bytes(), path, commit)?.keep()
}

/// Stages a file with these bytes.
pub fn stage_bytes(bytes: &[u8], path: &Path, commit: Commit) -> Result<Staged> {
    let write = |out: &mut dyn Out| {
        let written = out.write_all(bytes);
        written.map_err(|error| Error::io(path, &error))
    };
    stage_whole(path, commit, write).map(|((), file)| file)
}

/// Stages a file that `write` fills. Where `path` is standard output, a device or a pipe, it is written to directly.
pub(super) fn stage_whole<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&mut dyn Out) -> Result<T>,
) -> Result<(T, Staged)> {
    let target = match Sink::of(path, commit)? {
        Sink::Stream(stream) => {
            let out = BufWriter::with_capacity(PIECE, Pieces(stream));
            let written = fill(out, name_of(path), write)?;
            return Ok((written, Staged::new(|| Ok(None))));
        }
        Sink::File(target) => target,
    };
    let (file, temporary) =
        Temporary::file_for(&target).map_err(|error| Error::io(path, &error))?;
    let out = StagedFile {
        out: BufWriter::with_capacity(PIECE, Pieces(file)),
        path: temporary.path(),
    };
    let written = fill(out, path, write)?;
    Ok((written, staged(temporary, path, target, commit)))
}

/// Lets `write` fill a staged file, whose path it is given. Where `path` is standard output, a device or a pipe, the
/// file is copied to it and removed.
pub(super) fn stage_file<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&Path) -> Result<T>,
) -> Result<(T, Staged)> {
    let (target, stream) = match Sink::of(path, commit)? {
        Sink::Stream(stream) => (std::env::temp_dir().join("azimesh"), Some(stream)),
        Sink::File(target) => (target, None),
    };
    let told = if stream.is_some() { &target } else { path };
    let (_, temporary) = Temporary::file_for(&target).map_err(|error| Error::io(told, &error))?;
    let written = write(temporary.path()).map_err(|mut error| {
        // The user knows `path`, not the temporary file.
        error.path = error.path.filter(|path| path != temporary.path());
        match (&stream, error.kind) {
            (Some(_), ErrorKind::System) => error.file(temporary.path()),
            _ => error.file(name_of(path)),
        }
    })?;
    let Some(mut stream) = stream else {
        return Ok((written, staged(temporary, path, target, commit)));
    };
    let mut file = File::open(temporary.path()).map_err(|error| Error::io(&target, &error))?;
    let copied = io::copy(&mut file, &mut Pieces(&mut *stream));
    let copied = copied.and_then(|_| stream.flush());
    copied.map_err(|error| Error::io(name_of(path), &error))?;
    Ok((written, Staged::new(|| Ok(None))))
}

/// A complete file that is to be renamed to `target`, which the user knows as `path`.
fn staged(mut temporary: Temporary, path: &Path, target: PathBuf, commit: Commit) -> Staged {
    temporary.set_complete(&target, commit);
    let path = path.to_path_buf();
    Staged::new(move || {
        let named = temporary.commit(&target, commit);
        named.map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => exists(&path),
            _ => Error::io(&path, &error),
        })?;
        Ok(commit.sync.then(|| folder_of(&target).to_path_buf()))
    })
}

impl Commit {
    /// Refuses an existing file, or a symbolic link to a file that does not exist, unless it is to be replaced.
    /// Standard output, devices and pipes are accepted. A guarded input is refused always.
    pub fn check(self, path: &Path) -> Result<()> {
        if path.as_os_str() == "-" {
            return Ok(());
        }
        refuse_guarded(path)?;
        if self.replace {
            return Ok(());
        }
        match std::fs::metadata(path) {
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

fn fill<T>(
    mut out: impl Out,
    path: &Path,
    write: impl FnOnce(&mut dyn Out) -> Result<T>,
) -> Result<T> {
    let written = write(&mut out).map_err(|error| error.file(path))?;
    out.flush().map_err(|error| Error::io(path, &error))?;
    Ok(written)
}

/// A file under a temporary name.
struct StagedFile<'a> {
    out: BufWriter<Pieces<File>>,
    path: &'a Path,
}

impl Out for StagedFile<'_> {
    fn apart(&mut self, numbers: &NumbersApart, hash_from: u64) -> Result<Vec<HashedBytes>> {
        let failed = |error: io::Error| Error::system(error.to_string());
        self.out.flush().map_err(failed)?;
        let at = self.out.get_mut().0.stream_position().map_err(failed)?;
        let to = Some((self.path, at));
        let told = numbers.by.write(to, &numbers.numbers, hash_from)?;
        let end = SeekFrom::Start(at + numbers.n_bytes);
        self.out.get_mut().0.seek(end).map_err(failed)?;
        Ok(told)
    }
}

impl Write for StagedFile<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Writes at most [`PIECE`] bytes at a time.
pub(super) struct Pieces<W>(pub W);

impl<W: Write> Write for Pieces<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(&bytes[..bytes.len().min(PIECE)])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let failed = stage_whole(&path, Commit::REPLACE, |out| -> Result<()> {
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
            assert!(refused.message.contains("symbolic link"), "{refused}");
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
        assert!(refused.message.contains("longer"), "{refused}");
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
