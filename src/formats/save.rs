//! Writing a mesh file whole or not at all: into a file beside it, which then takes its name.

use super::{Format, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes gathered before the system is asked to write, and the most that it is asked for at once:
/// Linux was measured to stall for a third of a second now and then in writes of 4 MB and more.
const PIECE: usize = 1 << 20;

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
    if path.as_os_str() == "-" && !format.companions(mesh, path).is_empty() {
        return Err(Error::input(format!(
            "{} keeps names and conditions of tags in a file beside it, for which standard output \
             has no place; write to a file",
            format.name()
        )));
    }
    let notes = write_whole(path, |out| format.write(mesh, out, options))?;
    write_companions(mesh, path, format)?;
    Ok(notes)
}

/// Writes the small files that belong beside a mesh written to `path`.
pub fn write_companions(mesh: &Mesh, path: &Path, format: &dyn Format) -> Result<()> {
    for (companion, content) in format.companions(mesh, path) {
        write_whole(&companion, |out| {
            out.write_all(&content)
                .map_err(|error| Error::io(&companion, &error))
        })?;
    }
    Ok(())
}

/// Writes text to `path` in the same way.
pub fn save_text(text: &str, path: &Path) -> Result<()> {
    write_whole(path, |out| {
        out.write_all(text.as_bytes())
            .map_err(|error| Error::io(path, &error))
    })
}

/// Fills a file through `write`, whole or not at all, as [`save`] does.
pub fn write_whole<T>(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
    if path.as_os_str() == "-" {
        let stdout = UntilClosed::new(io::stdout().lock());
        return fill(stdout, Path::new("<stdout>"), write);
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => {
            return Err(Error::input("this is a folder, not a file").file(path));
        }
        Ok(found) if !found.is_file() => {
            let device = OpenOptions::new()
                .write(true)
                .open(&target)
                .map_err(|error| Error::io(path, &error))?;
            return fill(device, path, write);
        }
        _ => {}
    }
    let (file, temporary) = create_beside(&target).map_err(|error| Error::io(path, &error))?;
    fill(file, path, write)
        .and_then(|written| {
            fs::rename(&temporary, &target).map_err(|error| Error::io(path, &error))?;
            Ok(written)
        })
        .inspect_err(|_| {
            // The first error is the one to report.
            let _ = fs::remove_file(&temporary);
        })
}

/// A file that takes its name when its first part is complete, and grows in place after that.
pub(super) struct Emerging {
    file: Pieces<File>,
    path: PathBuf,
    /// Its name until then.
    temporary: Option<PathBuf>,
    /// Bytes read back.
    piece: Vec<u8>,
}

impl Emerging {
    /// A new file beside `path`, empty.
    pub fn create(path: &Path) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let (file, temporary) = create_beside(&target).map_err(|error| Error::io(path, &error))?;
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
        let (mut file, temporary) = create_beside(&self.path)?;
        self.temporary = Some(temporary);
        self.file.0.seek(SeekFrom::Start(0))?;
        io::copy(&mut (&mut self.file.0).take(n_bytes), &mut file)?;
        self.file = Pieces(file);
        Ok(())
    }

    /// Gives it its name, unless it has it.
    pub fn appear(&mut self) -> io::Result<()> {
        if let Some(temporary) = &self.temporary {
            fs::rename(temporary, &self.path)?;
            self.temporary = None;
        }
        Ok(())
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

impl Drop for Emerging {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            // Whatever went wrong is told already.
            let _ = fs::remove_file(temporary);
        }
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

/// A pipe whose reader may leave early, as `head` does: what comes after is dropped quietly.
struct UntilClosed<W> {
    pipe: W,
    is_closed: bool,
}

impl<W: Write> UntilClosed<W> {
    fn new(pipe: W) -> Self {
        Self {
            pipe,
            is_closed: false,
        }
    }
}

impl<W: Write> Write for UntilClosed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_closed {
            return Ok(bytes.len());
        }
        match self.pipe.write(bytes) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => {
                self.is_closed = true;
                Ok(bytes.len())
            }
            written => written,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.pipe.flush() {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            flushed => flushed,
        }
    }
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

/// A new file in the folder of `target`, under a name that nothing has.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    let name = target.file_name().ok_or(ErrorKind::InvalidInput)?;
    let mut attempt = 0u32;
    loop {
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{attempt}.part", std::process::id()));
        let path = target.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, path)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists && attempt < 1000 => {
                attempt += 1;
            }
            Err(error) => return Err(error),
        }
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
