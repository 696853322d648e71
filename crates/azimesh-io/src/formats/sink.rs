//! Output targets: files, standard output, devices and pipes.

use super::staged::Commit;
use azimesh_core::error::{Error, Result};
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The target of an output.
pub(super) enum Sink {
    /// Standard output, a device or a pipe.
    Stream(Box<dyn Write>),
    /// A file, new or to be replaced; links are followed.
    File(PathBuf),
}

impl Sink {
    /// The target at this path; a device or a pipe is opened. An existing file that must not be replaced is refused.
    pub fn of(path: &Path, commit: Commit) -> Result<Self> {
        if path.as_os_str() == "-" {
            return Ok(Self::Stream(Box::new(UntilClosed::new(
                io::stdout().lock(),
            ))));
        }
        commit.check(path)?;
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        match fs::metadata(&target) {
            Ok(found) if found.is_dir() => {
                Err(Error::input("this is a folder, not a file").file(path))
            }
            Ok(found) if !found.is_file() => {
                let device = OpenOptions::new().write(true).open(&target);
                let device = device.map_err(|error| Error::io(path, &error))?;
                Ok(Self::Stream(Box::new(device)))
            }
            Err(error) if error.kind() == ErrorKind::InvalidFilename => {
                Err(Error::io(path, &error))
            }
            _ => Ok(Self::File(target)),
        }
    }
}

/// Refuses a pipe or a device under the name of a file that is to be written, but that the user has not named: a pipe
/// blocks until a program reads from it.
pub fn refuse_special(path: &Path) -> Result<()> {
    let is_special = |found: fs::Metadata| !found.is_file() && !found.is_dir();
    match fs::metadata(path).is_ok_and(is_special) {
        false => Ok(()),
        true => Err(Error::input(
            "a file of this name is needed here, but this is a pipe or a device; remove it",
        )
        .file(path)),
    }
}

/// The name of an output in messages.
pub(super) fn name_of(path: &Path) -> &Path {
    match path.as_os_str() == "-" {
        true => Path::new("<stdout>"),
        false => path,
    }
}

/// A pipe whose reader may close it early, as `head` does: what is written after that is discarded.
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
