//! Writing a mesh file whole or not at all: into a file beside it, which then takes its name.

use super::hidden::{Commit, Hidden, folder_of, sync_folder};
use super::output_set::stage_folder;
use super::sink::{Sink, name_of};
use super::{Begin, Format, Notes, OutputSet, SequenceFile, WriteOptions};
use crate::error::{Error, ErrorKind, Result, option};
use crate::mesh::MeshView;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Bytes gathered before the system is asked to write, and the most that it is asked for at once:
/// Linux was measured to stall for a third of a second now and then in writes of 4 MB and more.
pub(super) const PIECE: usize = 1 << 20;

/// Gives files their names; tells the folder that is to be synced then.
type GiveNames = Box<dyn FnOnce() -> Result<Option<PathBuf>> + Send>;

/// Files that are whole and have not their names yet. Dropped, it removes them.
#[must_use]
pub struct Waiting(GiveNames);

impl Waiting {
    /// What gives files their names and tells the folder of them, if that is to be synced; dropped, it removes
    /// them.
    pub(crate) fn new(give: impl FnOnce() -> Result<Option<PathBuf>> + Send + 'static) -> Self {
        Self(Box::new(give))
    }

    /// Several as one, in order.
    pub(super) fn all(files: Vec<Self>) -> Self {
        Self::new(|| Self::keep_all(files).map(|()| None))
    }

    /// Gives them their names.
    pub fn keep(self) -> Result<()> {
        Self::keep_all([self])
    }

    /// Gives all of several their names, in order.
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

/// Writes `mesh` to `path`; returns a note for each thing that the format cannot hold.
///
/// The bytes go to hidden files in the same folder, which are renamed once all are complete and
/// removed when anything fails. `-` is standard output. A device or a pipe, which cannot be
/// replaced, is written to directly; a symbolic link is followed.
pub fn save(
    mesh: &MeshView,
    path: &Path,
    format: &dyn Format,
    options: &WriteOptions,
    commit: Commit,
) -> Result<Notes> {
    let (notes, files) = stage(mesh, path, format, options, commit)?;
    files.keep()?;
    Ok(notes)
}

/// Does what [`save`] does, but leaves the files under hidden names.
pub fn stage(
    mesh: &MeshView,
    path: &Path,
    format: &dyn Format,
    options: &WriteOptions,
    commit: Commit,
) -> Result<(Notes, Waiting)> {
    let mut out = OutputSet::new(path, commit);
    let notes = format.write(mesh, &mut out, options)?;
    Ok((notes, out.finish().files))
}

/// Writes text to `path` in the same way.
pub fn save_text(text: &str, path: &Path, commit: Commit) -> Result<()> {
    stage_bytes(text.as_bytes(), path, commit)?.keep()
}

/// Writes bytes under a hidden name.
pub fn stage_bytes(bytes: &[u8], path: &Path, commit: Commit) -> Result<Waiting> {
    let write = |out: &mut dyn Write| {
        let written = out.write_all(bytes);
        written.map_err(|error| Error::io(path, &error))
    };
    stage_whole(path, commit, write).map(|((), file)| file)
}

/// Fills a file through `write` under a hidden name.
pub(super) fn stage_whole<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&mut dyn Write) -> Result<T>,
) -> Result<(T, Waiting)> {
    let target = match Sink::of(path, commit)? {
        Sink::Stream(stream) => {
            let written = fill(stream, name_of(path), write)?;
            return Ok((written, Waiting::new(|| Ok(None))));
        }
        Sink::File(target) => target,
    };
    let (file, hidden) = Hidden::beside(&target).map_err(|error| Error::io(path, &error))?;
    let written = fill(file, path, write)?;
    Ok((written, waiting(hidden, path, target, commit)))
}

/// Lets `write` fill the file or folder of a whole sequence, which then waits for the name `path`. Where that is
/// standard output, a device or a pipe, a file is copied to it and removed.
pub fn stage_sequence<T>(
    path: &Path,
    format: &dyn Format,
    options: &WriteOptions,
    commit: Commit,
    write: impl FnOnce(&mut dyn SequenceFile) -> Result<T>,
) -> Result<(T, Waiting)> {
    let create = format
        .sequence()
        .ok_or_else(|| Error::input(format!("{} keeps no sequence", format.title())).file(path))?;
    let fill = |hidden: &Path| write(&mut *create(hidden, options, Begin::Fill, false)?);
    match format.is_folder() {
        true => stage_folder(path, commit, fill),
        false => stage_file(path, commit, fill),
    }
}

/// Lets `write` fill a file, of a name that it is given, which then waits for the name `path`. Where that
/// is standard output, a device or a pipe, the file is copied to it and removed.
fn stage_file<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&Path) -> Result<T>,
) -> Result<(T, Waiting)> {
    let (target, stream) = match Sink::of(path, commit)? {
        Sink::Stream(stream) => (std::env::temp_dir().join("azimesh"), Some(stream)),
        Sink::File(target) => (target, None),
    };
    let told = if stream.is_some() { &target } else { path };
    let (_, hidden) = Hidden::beside(&target).map_err(|error| Error::io(told, &error))?;
    let written = write(hidden.path()).map_err(|mut error| {
        // Who asked for `path` knows nothing of the hidden file.
        error.path = error.path.filter(|path| path != hidden.path());
        match (&stream, error.kind) {
            (Some(_), ErrorKind::System) => error.file(hidden.path()),
            _ => error.file(name_of(path)),
        }
    })?;
    let Some(mut stream) = stream else {
        return Ok((written, waiting(hidden, path, target, commit)));
    };
    let mut file = File::open(hidden.path()).map_err(|error| Error::io(&target, &error))?;
    let copied = io::copy(&mut file, &mut Pieces(&mut *stream));
    let copied = copied.and_then(|_| stream.flush());
    copied.map_err(|error| Error::io(name_of(path), &error))?;
    Ok((written, Waiting::new(|| Ok(None))))
}

/// A whole file that waits for the name `target`, which the user knows as `path`.
fn waiting(mut hidden: Hidden, path: &Path, target: PathBuf, commit: Commit) -> Waiting {
    hidden.is_whole(&target, commit);
    let path = path.to_path_buf();
    Waiting::new(move || {
        let named = hidden.take_name(&target, commit);
        named.map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => exists(&path),
            _ => Error::io(&path, &error),
        })?;
        Ok(commit.sync.then(|| folder_of(&target).to_path_buf()))
    })
}

impl Commit {
    /// Refuses a name that a file has already, or a symbolic link that leads to none, unless it is to be
    /// replaced. Standard output, devices and pipes are written to.
    pub fn check(self, path: &Path) -> Result<()> {
        if self.replace || path.as_os_str() == "-" {
            return Ok(());
        }
        match std::fs::metadata(path) {
            Ok(found) if found.is_file() => Err(exists(path)),
            Err(_) if path.is_symlink() => Err(Error::input(format!(
                "is a symbolic link that leads to no file; {} replaces it",
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
    sink: impl Write,
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T>,
) -> Result<T> {
    let mut out = BufWriter::with_capacity(PIECE, Pieces(sink));
    let written = write(&mut out).map_err(|error| error.file(path))?;
    out.flush().map_err(|error| Error::io(path, &error))?;
    Ok(written)
}

/// Hands on at most a piece at a time.
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
        assert_eq!(error.kind, crate::error::ErrorKind::Input);
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
        let [first, second] = staged.map(Waiting::keep);
        first.expect("the name was free");
        let refused = second.expect_err("it is taken");
        assert_eq!(
            (refused.kind, refused.message.as_str()),
            (ErrorKind::Input, "exists already; --force replaces it")
        );
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "first");
        assert_eq!(names(folder.path()), ["mesh.txt"]);
    }
}
