//! A file that takes its name when its first part is whole, and grows in place after that.

use super::hidden::{Commit, Hidden, folder_of, sync_folder};
use super::save::{PIECE, Pieces};
use crate::error::{Error, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file that takes its name when its first part is complete, and grows in place after that.
pub(super) struct Emerging {
    file: Pieces<File>,
    path: PathBuf,
    /// Its name until then.
    temporary: Option<Hidden>,
    /// Bytes read back.
    piece: Vec<u8>,
    /// Whether what is written is put on the disk before work goes on.
    sync: bool,
}

impl Emerging {
    /// A new file beside `path`, empty.
    pub fn create(path: &Path, sync: bool) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let (file, temporary) = Hidden::beside(&target).map_err(|error| Error::io(path, &error))?;
        Ok(Self {
            file: Pieces(file),
            path: target,
            temporary: Some(temporary),
            piece: Vec::new(),
            sync,
        })
    }

    /// The file of this name, with what is in it.
    pub fn reopen(path: &Path, sync: bool) -> Result<Self> {
        let opened = OpenOptions::new().read(true).write(true).open(path);
        Ok(Self {
            file: Pieces(opened.map_err(|error| Error::io(path, &error))?),
            path: fs::canonicalize(path).map_err(|error| Error::io(path, &error))?,
            temporary: None,
            piece: Vec::new(),
            sync,
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

    /// Puts what is written on the disk, if that is wanted. A file without a name is worth nothing yet.
    pub fn sync(&mut self) -> io::Result<()> {
        match self.sync && self.temporary.is_none() {
            true => self.file.0.sync_data(),
            false => Ok(()),
        }
    }

    /// Gives it its name, unless it has it.
    pub fn appear(&mut self) -> io::Result<()> {
        let Some(hidden) = self.temporary.take() else {
            return Ok(());
        };
        let (replace, sync) = (true, self.sync);
        hidden.take_name(&self.path, Commit { replace, sync })?;
        match sync {
            true => sync_folder(folder_of(&self.path)),
            false => Ok(()),
        }
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
