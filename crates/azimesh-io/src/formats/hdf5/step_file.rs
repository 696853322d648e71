//! An HDF5 file that grows in place and is valid after each step.
//!
//! Nothing that was written is overwritten. A step appends its values, then the headers of what is
//! new and of the groups on the way there, and at last replaces the 48 bytes of the superblock, which lie in one
//! page, by ones that point to the new headers. Until then, and after the program
//! was killed at any moment, readers see the steps before.
//!
//! A file of an earlier run is resumed: the bytes of the same steps are compared with those in the file, which gives
//! their addresses and hashes again. From the first byte that differs, or from its end on, the file is written.

use super::address::{NOWHERE, Storage, Stored};
use super::header::{self, SUPERBLOCK};
use super::index::Chunks;
use super::links::Links;
use super::rows::Rows;
use super::tree::{Payload, Tree};
use super::write::{ALIGNMENT, Counted, failed, headers, stored_bytes, write_data, write_values};
use crate::formats::Begin;
use crate::formats::column::Data;
use crate::formats::growing::GrowingFile;
use crate::mesh::NumbersApart;
use azimesh_core::error::Result;
use azimesh_core::ranks::hash::TreeHasher;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

/// Bytes gathered before they are handed on.
const BUFFER: usize = 1 << 20;

/// An HDF5 file that grows step by step.
pub(in crate::formats) struct StepFile {
    out: Counted<Buffered>,
    hasher: TreeHasher,
    /// Whether all bytes so far equal those of an earlier run.
    is_resuming: bool,
    /// The superblock of the last step that was committed, and where that ends.
    finished: Option<(Vec<u8>, u64)>,
    /// Superblock and end of the step that is finished and not committed.
    pending: Option<(Vec<u8>, u64)>,
}

/// Gathers bytes before they are handed on; those that are left when it is dropped are not.
struct Buffered {
    file: GrowingFile,
    bytes: Vec<u8>,
}

impl Write for Buffered {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.bytes.len() + bytes.len() > BUFFER {
            self.flush()?;
        }
        match bytes.len() < BUFFER {
            true => self.bytes.extend(bytes),
            false => self.file.write_all(bytes)?,
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.write_all(&self.bytes)?;
        self.bytes.clear();
        Ok(())
    }
}

impl StepFile {
    /// A new file, which gets its name with the first [`StepFile::commit`], or an existing one, which is resumed or
    /// filled. With `sync` each step is on the disk when it is committed.
    pub fn create(path: &Path, begin: Begin, sync: bool) -> Result<Self> {
        match begin {
            Begin::Resume if path.is_file() => {
                let mut growing = Self::at(SUPERBLOCK as u64, GrowingFile::reopen(path, sync)?);
                growing.is_resuming = true;
                Ok(growing)
            }
            Begin::Resume | Begin::Create => Self::start(GrowingFile::create(path, sync)?),
            Begin::Fill => Self::start(GrowingFile::reopen(path, sync)?),
        }
    }

    /// Starts in an empty file. It is no HDF5 file before the first [`StepFile::commit`].
    fn start(file: GrowingFile) -> Result<Self> {
        let mut growing = Self::at(0, file);
        growing.out.write(&[0; SUPERBLOCK])?;
        Ok(growing)
    }

    fn at(at: u64, file: GrowingFile) -> Self {
        Self {
            out: Counted {
                out: Buffered {
                    file,
                    bytes: Vec::new(),
                },
                at,
            },
            hasher: TreeHasher::default(),
            is_resuming: false,
            finished: None,
            pending: None,
        }
    }

    /// Bytes up to the end of what was appended last.
    pub fn n_bytes(&self) -> u64 {
        self.out.at
    }

    /// Whether all bytes so far were there already.
    pub fn is_resuming(&self) -> bool {
        self.is_resuming
    }

    /// Appends values, for a dataset of this step or of later ones ([`Payload::Stored`], [`Payload::Chunks`]).
    pub fn store(&mut self, data: &Data) -> Result<Stored> {
        let address = self.align_to(ALIGNMENT)?;
        match data {
            Data::Remote(numbers) => self.append_remote(numbers)?,
            data => write_data(data, address, &mut |bytes| self.append(bytes))?,
        }
        Ok(Stored { address })
    }

    /// Appends bytes right behind the values stored last.
    pub fn continue_with(&mut self, bytes: &[u8]) -> Result<()> {
        self.append(bytes)
    }

    /// Appends the root of a tree and all below it, for a group of this step or of later ones
    /// ([`Links::add`], [`Tree::object`]).
    pub fn store_object(&mut self, tree: &Tree) -> Result<Stored> {
        let nodes = 0..tree.nodes.len();
        let places: Result<Vec<Storage>> = nodes.map(|i| self.storage(tree, i)).collect();
        let places = places?;
        let address = headers(tree, &places, |header| self.put(&header))?;
        Ok(Stored { address })
    }

    /// Appends what is not in the file yet of a list of children ([`Tree::links`]).
    pub fn store_links(&mut self, links: &mut Links) -> Result<()> {
        links.store(|bytes| self.put(bytes))
    }

    /// Appends what is not in the file yet of a dataset of one row a step ([`Tree::rows`]).
    pub fn store_rows(&mut self, rows: &mut Rows) -> Result<()> {
        rows.store(|bytes| self.put(bytes))
    }

    /// Appends what is not in the file yet of the index of a dataset ([`Payload::Chunks`]).
    pub fn store_index(&mut self, chunks: &mut Chunks) -> Result<()> {
        chunks.store(|bytes| self.put(bytes))
    }

    /// Appends `tree`, which is the content of the file from the next [`StepFile::commit`] on; gives the
    /// hash of the bytes appended since the last time. Values of the tree that were not stored before are
    /// appended now and belong to this step alone.
    pub fn finish_step(&mut self, tree: &Tree) -> Result<blake3::Hash> {
        let root = self.store_object(tree)?;
        let superblock = header::superblock(root.address, self.out.at);
        self.out.out.flush().map_err(failed)?;
        self.pending = Some((superblock, self.out.at));
        let hash = self.hasher.finalize();
        self.hasher = TreeHasher::default();
        Ok(hash)
    }

    /// Makes the finished step the content of the file, once all that it points to is on the disk.
    pub fn commit(&mut self) -> Result<()> {
        let Some((superblock, at)) = self.pending.take() else {
            return Ok(());
        };
        let file = &mut self.out.out.file;
        let goes_on = self.is_resuming && !file.ends_at(at).map_err(failed)?;
        if !goes_on {
            file.sync().map_err(failed)?;
            file.seek(SeekFrom::Start(0)).map_err(failed)?;
            file.write_all(&superblock).map_err(failed)?;
            file.seek(SeekFrom::Start(at)).map_err(failed)?;
            file.sync().map_err(failed)?;
            file.commit().map_err(failed)?;
        }
        self.finished = Some((superblock, at));
        Ok(())
    }

    /// Ends a resumed file after its last step: truncates it there and repairs the superblock. Returns whether anything
    /// was repaired.
    pub fn end(&mut self) -> Result<bool> {
        let Some((superblock, end)) = self.finished.as_ref().filter(|_| self.is_resuming) else {
            return Ok(false);
        };
        let file = &mut self.out.out.file;
        let n_same = file.matching(0, superblock).map_err(failed)?;
        let is_whole = n_same == superblock.len() && file.ends_at(*end).map_err(failed)?;
        if !is_whole {
            file.truncate(*end, Some(superblock)).map_err(failed)?;
        }
        Ok(!is_whole)
    }

    /// The bytes of the file, as far as they were handed on.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> Vec<u8> {
        std::fs::read(self.out.out.file.path()).expect("it can be read")
    }

    /// Appends what a node has that is not stored yet.
    fn storage(&mut self, tree: &Tree, node: usize) -> Result<Storage> {
        let Some(dataset) = &tree.nodes[node].dataset else {
            return Ok(Storage::Contiguous(NOWHERE));
        };
        match &dataset.data {
            _ if stored_bytes(dataset) == 0 => Ok(Storage::Contiguous(NOWHERE)),
            Payload::Stored(stored) => Ok(Storage::Contiguous(stored.address)),
            Payload::Chunks { rows, chunks } => Ok(Storage::Chunked {
                rows: *rows,
                index: chunks.stored.expect("its index was stored before"),
            }),
            Payload::Rows(rows) => Ok(rows.place()),
            _ => {
                let alignment = stored_bytes(dataset)
                    .min(ALIGNMENT)
                    .next_power_of_two()
                    .max(8);
                let address = self.align_to(alignment)?;
                if let Payload::New(Data::Remote(numbers)) = &dataset.data {
                    self.append_remote(numbers)?;
                    return Ok(Storage::Contiguous(address));
                }
                write_values(dataset, address, &mut |bytes| self.append(bytes))?;
                Ok(Storage::Contiguous(address))
            }
        }
    }

    /// Appends bytes that only this file knows: headers, indices, short datasets.
    fn put(&mut self, bytes: &[u8]) -> Result<u64> {
        let address = self.align_to(8)?;
        self.append(bytes)?;
        Ok(address)
    }

    fn align_to(&mut self, alignment: u64) -> Result<u64> {
        let address = self.out.at.next_multiple_of(alignment);
        let zeros = [0; ALIGNMENT as usize];
        self.append(&zeros[..(address - self.out.at) as usize])?;
        Ok(address)
    }

    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.hasher.update(bytes);
        let known = match self.is_resuming {
            true => self.matching(bytes).map_err(failed)?,
            false => 0,
        };
        self.out.write(&bytes[known..])
    }

    fn append_remote(&mut self, numbers: &NumbersApart) -> Result<()> {
        if self.is_resuming && self.has_remote(numbers)? {
            return Ok(());
        }
        self.out.out.flush().map_err(failed)?;
        let file = &mut self.out.out.file;
        let to = Some((file.path(), self.out.at));
        let told = (numbers.by).write(to, &numbers.numbers, self.hasher.n_bytes())?;
        told.iter().for_each(|part| self.hasher.take(part));
        self.out.at += numbers.n_bytes;
        file.seek(SeekFrom::Start(self.out.at)).map_err(failed)?;
        Ok(())
    }

    /// Skips the bytes that the file has already; writing begins with the first that differs.
    fn matching(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let file = &mut self.out.out.file;
        let n = file.matching(self.out.at, bytes)?;
        self.out.at += n as u64;
        if n < bytes.len() {
            self.leave_file()?;
        }
        Ok(n)
    }

    /// Skips numbers that others have where they are in the file already, as their hash tells; else writing begins with them.
    fn has_remote(&mut self, numbers: &NumbersApart) -> Result<bool> {
        let (mut found, mut wanted) = (self.hasher.clone(), self.hasher.clone());
        let (file, n) = (&mut self.out.out.file, numbers.n_bytes);
        let is_there = file.pass(self.out.at, n, &mut |bytes| found.update(bytes));
        if is_there.map_err(failed)? {
            let told = (numbers.by).write(None, &numbers.numbers, wanted.n_bytes())?;
            told.iter().for_each(|part| wanted.take(part));
            if found.finalize() == wanted.finalize() {
                self.hasher = wanted;
                self.out.at += n;
                return Ok(true);
            }
        }
        self.leave_file().map_err(failed)?;
        Ok(false)
    }

    /// Writes from here on: the file has other bytes, or ends.
    fn leave_file(&mut self) -> std::io::Result<()> {
        self.is_resuming = false;
        let finished = self.finished.as_ref();
        let superblock = finished.map(|(superblock, _)| &superblock[..]);
        self.out.out.file.truncate(self.out.at, superblock)
    }
}

impl Drop for StepFile {
    /// Removes a step that failed, so that a full disk has space again for other files.
    fn drop(&mut self) {
        if let Some((superblock, end)) = &self.finished
            && !self.is_resuming
            && self.out.at > *end
        {
            // The error was reported already, and the step is not part of the file either way.
            let _ = self.out.out.file.truncate(*end, Some(superblock));
        }
    }
}
