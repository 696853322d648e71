//! Writing a mesh file whole or not at all: into a file beside it, which then takes its name.

use super::hidden::Hidden;
use super::sink::{Sink, name_of};
use super::{Format, WriteOptions};
use crate::error::{Error, Kind, Result};
use crate::mesh::Mesh;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes gathered before the system is asked to write, and the most that it is asked for at once:
/// Linux was measured to stall for a third of a second now and then in writes of 4 MB and more.
const PIECE: usize = 1 << 20;

/// Files that are whole and have not their names yet. Dropped, it removes them.
#[must_use]
pub struct Waiting(Box<dyn FnOnce() -> Result<()>>);

impl Waiting {
    /// What gives files their names; dropped, it removes them.
    pub(super) fn new(give_names: impl FnOnce() -> Result<()> + 'static) -> Self {
        Self(Box::new(give_names))
    }

    /// Gives them their names.
    pub fn keep(self) -> Result<()> {
        (self.0)()
    }
}

/// Writes `mesh` to `path`; returns a sentence for each thing that the format cannot hold.
///
/// The bytes go to a hidden file in the same folder, which is renamed once it is complete and
/// removed when anything fails. `-` is standard output. A device or a pipe, which cannot be
/// replaced, is written to directly; a symbolic link is followed.
pub fn save(
    mesh: &Mesh,
    path: &Path,
    format: &dyn Format,
    options: &WriteOptions,
) -> Result<Vec<String>> {
    let (notes, files) = stage(mesh, path, format, options)?;
    files.into_iter().try_for_each(Waiting::keep)?;
    Ok(notes)
}

/// Does what [`save`] does, but leaves the mesh and the files beside it under hidden names.
pub fn stage(
    mesh: &Mesh,
    path: &Path,
    format: &dyn Format,
    options: &WriteOptions,
) -> Result<(Vec<String>, Vec<Waiting>)> {
    if path.as_os_str() == "-" && !format.companions(mesh, path).is_empty() {
        return Err(Error::input(format!(
            "{} keeps names and conditions of tags in a file beside it, for which standard output \
             has no place; write to a file",
            format.name()
        )));
    }
    let (notes, file) = stage_whole(path, |out| format.write(mesh, out, options))?;
    let mut files = vec![file];
    for (companion, content) in format.companions(mesh, path) {
        files.push(stage_bytes(&content, &companion)?);
    }
    Ok((notes, files))
}

/// Writes the small files that belong beside a mesh written to `path`.
pub fn write_companions(mesh: &Mesh, path: &Path, format: &dyn Format) -> Result<()> {
    for (companion, content) in format.companions(mesh, path) {
        stage_bytes(&content, &companion)?.keep()?;
    }
    Ok(())
}

/// Writes text to `path` in the same way.
pub fn save_text(text: &str, path: &Path) -> Result<()> {
    stage_bytes(text.as_bytes(), path)?.keep()
}

/// Writes bytes under a hidden name.
pub fn stage_bytes(bytes: &[u8], path: &Path) -> Result<Waiting> {
    let write = |out: &mut dyn Write| {
        let written = out.write_all(bytes);
        written.map_err(|error| Error::io(path, &error))
    };
    stage_whole(path, write).map(|((), file)| file)
}

/// Fills a file through `write`, whole or not at all, as [`save`] does.
pub fn write_whole<T>(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
    let (written, file) = stage_whole(path, write)?;
    file.keep()?;
    Ok(written)
}

fn stage_whole<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T>,
) -> Result<(T, Waiting)> {
    let target = match Sink::of(path)? {
        Sink::Stream(stream) => {
            let written = fill(stream, name_of(path), write)?;
            return Ok((written, Waiting::new(|| Ok(()))));
        }
        Sink::File(target) => target,
    };
    let path = path.to_path_buf();
    let (file, hidden) = Hidden::beside(&target).map_err(|error| Error::io(&path, &error))?;
    let written = fill(file, &path, write)?;
    hidden.is_whole(&target);
    let name = move || {
        hidden
            .take_name(&target)
            .map_err(|error| Error::io(&path, &error))
    };
    Ok((written, Waiting::new(name)))
}

/// Lets `write` make a file, of a name that it is given, which then takes the name `path`. Where that
/// is standard output, a device or a pipe, the file is copied to it and removed.
pub fn write_file<T>(path: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    let (target, mut stream) = match Sink::of(path)? {
        Sink::Stream(stream) => (std::env::temp_dir().join("azimesh"), Some(stream)),
        Sink::File(target) => (target, None),
    };
    let name = name_of(path);
    let of_target = |error: &io::Error| match &stream {
        Some(_) => Error::io(&target, error),
        None => Error::io(path, error),
    };
    let (_, hidden) = Hidden::beside(&target).map_err(|error| of_target(&error))?;
    let written = write(hidden.path()).map_err(|mut error| {
        // Who asked for `path` knows nothing of the hidden file.
        error.path = error.path.filter(|path| path != hidden.path());
        match (&stream, error.kind) {
            (Some(_), Kind::System) => error.file(hidden.path()),
            _ => error.file(name),
        }
    })?;
    match &mut stream {
        None => hidden
            .take_name(&target)
            .map_err(|error| Error::io(path, &error))?,
        Some(stream) => {
            let mut file = File::open(hidden.path()).map_err(|error| Error::io(&target, &error))?;
            let copied = io::copy(&mut file, &mut Pieces(&mut *stream));
            let copied = copied.and_then(|_| stream.flush());
            copied.map_err(|error| Error::io(name, &error))?;
        }
    }
    Ok(written)
}

/// A file that takes its name when its first part is complete, and grows in place after that.
pub(super) struct Emerging {
    file: Pieces<File>,
    path: PathBuf,
    /// Its name until then.
    temporary: Option<Hidden>,
    /// Bytes read back.
    piece: Vec<u8>,
}

impl Emerging {
    /// A new file beside `path`, empty.
    pub fn create(path: &Path) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let (file, temporary) = Hidden::beside(&target).map_err(|error| Error::io(path, &error))?;
        Ok(Self {
            file: Pieces(file),
            path: target,
            temporary: Some(temporary),
            piece: Vec::new(),
        })
    }

    /// The file of this name, with what is in it.
    pub fn reopen(path: &Path) -> Result<Self> {
        let opened = OpenOptions::new().read(true).write(true).open(path);
        Ok(Self {
            file: Pieces(opened.map_err(|error| Error::io(path, &error))?),
            path: fs::canonicalize(path).map_err(|error| Error::io(path, &error))?,
            temporary: None,
            piece: Vec::new(),
        })
    }

    /// How many of these bytes are in the file from `at` on.
    pub fn matching(&mut self, at: u64, bytes: &[u8]) -> io::Result<usize> {
        self.file.0.seek(SeekFrom::Start(at))?;
        let mut n = 0;
        for wanted in bytes.chunks(PIECE) {
            self.piece.clear();
            let mut part = (&mut self.file.0).take(wanted.len() as u64);
            part.read_to_end(&mut self.piece)?;
            if self.piece != wanted {
                let pairs = self.piece.iter().zip(wanted);
                return Ok(n + pairs.take_while(|(a, b)| a == b).count());
            }
            n += wanted.len();
        }
        Ok(n)
    }

    /// Its length in bytes.
    pub fn n_bytes(&self) -> io::Result<u64> {
        Ok(self.file.0.metadata()?.len())
    }

    /// Leaves out what comes after so many bytes.
    pub fn cut(&mut self, n_bytes: u64) -> io::Result<()> {
        self.file.0.set_len(n_bytes)
    }

    /// Goes on in a new file beside, which has the first `n_bytes` of this one and takes its place
    /// with [`Emerging::appear`].
    pub fn move_aside(&mut self, n_bytes: u64) -> io::Result<()> {
        let (mut file, temporary) = Hidden::beside(&self.path)?;
        self.temporary = Some(temporary);
        self.file.0.seek(SeekFrom::Start(0))?;
        io::copy(&mut (&mut self.file.0).take(n_bytes), &mut file)?;
        self.file = Pieces(file);
        Ok(())
    }

    /// Gives it its name, unless it has it.
    pub fn appear(&mut self) -> io::Result<()> {
        self.temporary
            .take()
            .map_or(Ok(()), |hidden| hidden.take_name(&self.path))
    }
}

impl Write for Emerging {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Emerging {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.0.seek(to)
    }
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
struct Pieces<W>(W);

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
        save_text("old", &path).expect("it can be written");
        let failed: Result<()> = write_whole(&path, |out| {
            out.write_all(b"half").expect("it is buffered");
            Err(Error::system("disk full"))
        });
        let message = failed.expect_err("it failed").to_string();
        assert!(message.ends_with("mesh.txt: disk full"), "{message}");
        assert_eq!(fs::read_to_string(&path).expect("it is kept"), "old");
        assert_eq!(names(folder.path()), ["mesh.txt"]);
    }

    #[test]
    fn a_missing_folder_is_wrong_input() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = save_text("x", &folder.path().join("no/mesh.txt")).expect_err("no folder");
        assert_eq!(error.kind, crate::error::Kind::Input);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_a_device() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.txt");
        let link = folder.path().join("link.txt");
        save_text("old", &path).expect("it can be written");
        std::os::unix::fs::symlink(&path, &link).expect("links are known");
        save_text("new", &link).expect("it can be written");
        assert!(
            fs::symlink_metadata(&link)
                .expect("it is there")
                .is_symlink()
        );
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "new");
        save_text("x", Path::new("/dev/null")).expect("it takes everything");
        assert!(!fs::metadata("/dev/null").expect("it is there").is_file());
    }
}
