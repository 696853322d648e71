//! A growing file: staged until its first step is complete, then extended in place.

use super::save::PIECE;
use super::staged::{Commit, Temporary, folder_of, sync_folder};
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The hash so far of the kinds and the nodes of all cells, which must be the same at every step.
pub(super) fn hasher_of_cells(mesh: &MeshView) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    for run in mesh.cells.runs() {
        let run = [run.kind as usize, run.n_nodes, run.n_cells()];
        hasher.update(bytemuck::cast_slice(&run));
    }
    // Nodes on several ranks belong to the same mesh at every step.
    if mesh.by_ranks.is_none() {
        hasher.update_rayon(bytemuck::cast_slice(mesh.cells.connectivity()));
    }
    hasher.update_rayon(bytemuck::cast_slice(mesh.cells.face_streams()));
    hasher
}

/// A file that gets its name when its first step is complete, and is extended in place after that.
pub(super) struct GrowingFile {
    file: File,
    path: PathBuf,
    /// The staged file, until the file has its name.
    temporary: Option<Temporary>,
    /// Bytes to be written, or bytes that are read back. Bytes that are left when it is dropped are not written.
    buffer: Vec<u8>,
    /// True if each step is synced to the disk.
    sync: bool,
}

impl GrowingFile {
    /// A new, empty file, which is to get the name `path`.
    pub fn create(path: &Path, sync: bool) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let staged = Temporary::file_for(&target);
        let (file, temporary) = staged.map_err(|error| Error::io(path, &error))?;
        Ok(Self::new(file, target, Some(temporary), sync))
    }

    /// The existing file of this name.
    pub fn reopen(path: &Path, sync: bool) -> Result<Self> {
        let failed = |error: io::Error| Error::io(path, &error);
        let opened = OpenOptions::new().read(true).write(true).open(path);
        let file = opened.map_err(failed)?;
        let path = fs::canonicalize(path).map_err(failed)?;
        Ok(Self::new(file, path, None, sync))
    }

    fn new(file: File, path: PathBuf, temporary: Option<Temporary>, sync: bool) -> Self {
        Self {
            file,
            path,
            temporary,
            buffer: Vec::new(),
            sync,
        }
    }

    /// The present path of the file.
    pub fn path(&self) -> &Path {
        let staged = self.temporary.as_ref().map(Temporary::path);
        staged.unwrap_or(&self.path)
    }

    /// Tests if the file has `n` bytes from offset `at` on, and `accept` accepts each piece of them. The buffer must be
    /// empty.
    pub fn has(
        &mut self,
        at: u64,
        n: u64,
        accept: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<bool> {
        self.seek(at)?;
        let mut left = n;
        while left > 0 {
            self.buffer.clear();
            let mut part = (&mut self.file).take(left.min(PIECE as u64));
            part.read_to_end(&mut self.buffer)?;
            if self.buffer.is_empty() || !accept(&self.buffer) {
                break;
            }
            left -= self.buffer.len() as u64;
        }
        self.buffer.clear();
        Ok(left == 0)
    }

    /// Checks if the file has these bytes at offset `at`, as [`GrowingFile::has`] does.
    pub fn has_bytes(&mut self, at: u64, mut bytes: &[u8]) -> io::Result<bool> {
        self.has(at, bytes.len() as u64, &mut |piece| {
            let (wanted, rest) = bytes.split_at(piece.len());
            bytes = rest;
            piece == wanted
        })
    }

    /// True if the file ends at this offset or before it.
    pub fn ends_at(&self, at: u64) -> io::Result<bool> {
        Ok(self.file.metadata()?.len() <= at)
    }

    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.buffer.len() + bytes.len() > PIECE {
            self.flush()?;
        }
        if bytes.len() < PIECE {
            self.buffer.extend(bytes);
            return Ok(());
        }
        let mut pieces = bytes.chunks(PIECE);
        pieces.try_for_each(|piece| self.file.write_all(piece))
    }

    /// Writes the bytes that wait.
    pub fn flush(&mut self) -> io::Result<()> {
        self.file.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    /// Moves to offset `at`.
    pub fn seek(&mut self, at: u64) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(at)).map(|_| ())
    }

    /// Truncates the file at `at`; `superblock` makes the rest a valid file. Without one the file begins again in a staged
    /// copy of its first bytes, which replaces this file with [`GrowingFile::commit`].
    pub fn truncate(&mut self, at: u64, superblock: Option<&[u8]>) -> io::Result<()> {
        self.seek(0)?;
        if let Some(superblock) = superblock {
            self.file.write_all(superblock)?;
            // The disk may store later writes before earlier ones.
            self.sync()?;
            self.file.set_len(at)?;
        } else {
            let (mut file, temporary) = Temporary::file_for(&self.path)?;
            self.temporary = Some(temporary);
            io::copy(&mut (&mut self.file).take(at), &mut file)?;
            self.file = file;
        }
        self.seek(at)
    }

    /// Makes `superblock` the first bytes of the file, once all others are on the disk, and gives the file its name, unless
    /// it has it. Moves to offset `at`.
    pub fn commit(&mut self, superblock: &[u8], at: u64) -> io::Result<()> {
        self.sync()?;
        self.seek(0)?;
        self.file.write_all(superblock)?;
        self.seek(at)?;
        self.sync()?;
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

    /// Syncs to the disk what was written, if `sync` is set. A staged file need not be synced yet.
    fn sync(&mut self) -> io::Result<()> {
        if self.sync && self.temporary.is_none() {
            self.file.sync_data()?;
        }
        Ok(())
    }
}
