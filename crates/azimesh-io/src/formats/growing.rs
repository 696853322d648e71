//! A growing file: staged until its first step is complete, then extended in place.

use super::save::{PIECE, Pieces};
use super::staged::{Commit, Temporary, folder_of, sync_folder};
use azimesh_core::error::{Error, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file that gets its name when its first step is complete, and is extended in place after that.
pub(super) struct GrowingFile {
    file: Pieces<File>,
    path: PathBuf,
    /// The staged file, until the file has its name.
    temporary: Option<Temporary>,
    /// Buffer for bytes that are read back.
    piece: Vec<u8>,
    /// Whether each step is synced to the disk.
    sync: bool,
}

impl GrowingFile {
    /// A new, empty file, which is to get the name `path`.
    pub fn create(path: &Path, sync: bool) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let (file, temporary) =
            Temporary::file_for(&target).map_err(|error| Error::io(path, &error))?;
        Ok(Self {
            file: Pieces(file),
            path: target,
            temporary: Some(temporary),
            piece: Vec::new(),
            sync,
        })
    }

    /// Where the file is at present.
    pub fn path(&self) -> &Path {
        let staged = self.temporary.as_ref().map(Temporary::path);
        staged.unwrap_or(&self.path)
    }

    /// The existing file of this name.
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

    /// How many of these bytes, from the first on, the file has already at offset `at`.
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

    /// Passes so many bytes from offset `at` on; returns whether it has as many.
    pub fn pass(&mut self, at: u64, n: u64, take: &mut dyn FnMut(&[u8])) -> io::Result<bool> {
        self.file.0.seek(SeekFrom::Start(at))?;
        let mut left = n;
        while left > 0 {
            self.piece.clear();
            let mut part = (&mut self.file.0).take(left.min(PIECE as u64));
            if part.read_to_end(&mut self.piece)? == 0 {
                return Ok(false);
            }
            take(&self.piece);
            left -= self.piece.len() as u64;
        }
        Ok(true)
    }

    /// True if the file ends at this offset or before it.
    pub fn ends_at(&self, at: u64) -> io::Result<bool> {
        Ok(self.file.0.metadata()?.len() <= at)
    }

    /// Truncates the file at `at`; `superblock` makes the rest a valid file. Without one the file begins again in a staged
    /// copy of its first bytes, which replaces this file with [`GrowingFile::commit`].
    pub fn truncate(&mut self, at: u64, superblock: Option<&[u8]>) -> io::Result<()> {
        self.seek(SeekFrom::Start(0))?;
        if let Some(superblock) = superblock {
            self.write_all(superblock)?;
            // The disk may store later writes before earlier ones.
            self.sync()?;
            self.file.0.set_len(at)?;
        } else {
            let (mut file, temporary) = Temporary::file_for(&self.path)?;
            self.temporary = Some(temporary);
            io::copy(&mut (&mut self.file.0).take(at), &mut file)?;
            self.file = Pieces(file);
        }
        self.seek(SeekFrom::Start(at)).map(|_| ())
    }

    /// Syncs to the disk what was written, if `sync` is set. A staged file need not be synced yet.
    pub fn sync(&mut self) -> io::Result<()> {
        if self.sync && self.temporary.is_none() {
            self.file.0.sync_data()?;
        }
        Ok(())
    }

    /// Gives the file its name, unless it has it.
    pub fn commit(&mut self) -> io::Result<()> {
        let Some(temporary) = self.temporary.take() else {
            return Ok(());
        };
        let (replace, sync) = (true, self.sync);
        temporary.commit(&self.path, Commit { replace, sync })?;
        if sync {
            sync_folder(folder_of(&self.path))?;
        }
        Ok(())
    }
}

impl Write for GrowingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for GrowingFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.0.seek(to)
    }
}
