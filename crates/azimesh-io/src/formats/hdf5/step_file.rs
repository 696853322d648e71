//! An HDF5 file that grows in place and is valid after each step.
//!
//! Nothing that was written is overwritten. A step appends its values, then the headers of what is
//! new and of the groups on the way there, and at last replaces the 48 bytes of the superblock, which are in one
//! page, by ones that point to the new headers. Until then, and after the program
//! was killed at any moment, readers see the steps before.
//!
//! A file of an earlier run is resumed: the values of the same steps are compared with those in the file, which gives
//! their addresses and hashes again. From the first that differ, or from its end on, the file is written.

use super::header::{self, SUPERBLOCK};
use super::index::Chunks;
use super::messages::Links;
use super::rows::Rows;
use super::tree::{Id, NOWHERE, Payload, Storage, Stored, Tree};
use super::write::{ALIGNMENT, failed, headers, stored_bytes, write_data};
use crate::formats::Begin;
use crate::formats::column::Data;
use crate::formats::growing::GrowingFile;
use crate::mesh::NumbersApart;
use azimesh_core::error::Result;
use azimesh_core::ranks::hash::TreeHasher;
use std::path::Path;

/// An HDF5 file that grows step by step.
pub(in crate::formats) struct StepFile {
    file: GrowingFile,
    /// Bytes up to the end of what was appended last.
    at: u64,
    hasher: TreeHasher,
    /// True if all bytes so far equal an earlier run.
    is_resuming: bool,
    /// The superblock of the last step that was committed, and the end of that step.
    finished: Option<(Vec<u8>, u64)>,
    /// Superblock and end of the step that is finished and not committed.
    pending: Option<(Vec<u8>, u64)>,
}

impl StepFile {
    /// A new file, which gets its name with the first [`StepFile::commit`], or an existing one, which is resumed or
    /// filled. With `sync` each step is on the disk when it is committed.
    pub fn create(path: &Path, begin: Begin, sync: bool) -> Result<Self> {
        let is_resuming = begin == Begin::Resume && path.is_file();
        let mut new = Self {
            file: if is_resuming || begin == Begin::Fill {
                GrowingFile::reopen(path, sync)?
            } else {
                GrowingFile::create(path, sync)?
            },
            at: SUPERBLOCK as u64,
            hasher: TreeHasher::default(),
            is_resuming,
            finished: None,
            pending: None,
        };
        if !is_resuming {
            // It is no HDF5 file before the first commit.
            new.file.write(&[0; SUPERBLOCK]).map_err(failed)?;
        }
        Ok(new)
    }

    /// Bytes up to the end of what was appended last.
    pub fn n_bytes(&self) -> u64 {
        self.at
    }

    /// Checks if all bytes so far were there already.
    pub fn is_resuming(&self) -> bool {
        self.is_resuming
    }

    /// Appends values, for a dataset of this step or of later ones ([`Payload::Stored`], [`Payload::Chunks`]).
    pub fn store(&mut self, data: &Data) -> Result<Stored> {
        self.store_at(ALIGNMENT, data)
    }

    fn store_at(&mut self, alignment: u64, data: &Data) -> Result<Stored> {
        let address = self.align_to(alignment)?;
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
        let mut addresses = vec![NOWHERE; tree.nodes.len()];
        self.store_nodes(tree, &tree.below(Tree::ROOT), &mut addresses)
    }

    /// Appends the children of a group and all below them, except one, and adds them to the children of a group of later
    /// steps.
    pub fn store_children(
        &mut self,
        tree: &Tree,
        of: Id,
        except: Option<Id>,
        links: &mut Links,
    ) -> Result<()> {
        let mut addresses = vec![NOWHERE; tree.nodes.len()];
        let children = &tree.nodes[of.0].children;
        for (name, child) in children.iter().filter(|(_, id)| Some(*id) != except) {
            let nodes = tree.below(*child);
            links.add(name, self.store_nodes(tree, &nodes, &mut addresses)?)?;
        }
        Ok(())
    }

    fn store_nodes(
        &mut self,
        tree: &Tree,
        nodes: &[usize],
        addresses: &mut [u64],
    ) -> Result<Stored> {
        let places: Result<Vec<Storage>> = nodes.iter().map(|i| self.storage(tree, *i)).collect();
        let nodes = nodes.iter().copied().zip(places?);
        let address = headers(tree, nodes, addresses, |header| self.put(&header))?;
        Ok(Stored { address })
    }

    /// Appends what is not in the file yet of a list of children ([`Tree::links`]).
    pub fn store_links(&mut self, links: &mut Links) -> Result<()> {
        links.store(|bytes| self.put(bytes))
    }

    /// Appends what is not in the file yet of a dataset of one row per step ([`Tree::rows`]).
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
        self.file.flush().map_err(failed)?;
        self.pending = Some((header::superblock(root.address, self.at), self.at));
        Ok(std::mem::take(&mut self.hasher).finalize())
    }

    /// Makes the finished step the content of the file, once all that it points to is on the disk.
    pub fn commit(&mut self) -> Result<()> {
        let Some((superblock, at)) = self.pending.take() else {
            return Ok(());
        };
        let goes_on = self.is_resuming && !self.file.ends_at(at).map_err(failed)?;
        if !goes_on {
            self.file.commit(&superblock, at).map_err(failed)?;
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
        let file = &mut self.file;
        let is_same = file.has_bytes(0, superblock).map_err(failed)?;
        let is_whole = is_same && file.ends_at(*end).map_err(failed)?;
        if !is_whole {
            file.truncate(*end, Some(superblock)).map_err(failed)?;
        }
        Ok(!is_whole)
    }

    /// The bytes of the file, as far as they were handed on.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> Vec<u8> {
        std::fs::read(self.file.path()).expect("it can be read")
    }

    /// Appends the parts of a node that are not stored yet.
    fn storage(&mut self, tree: &Tree, node: usize) -> Result<Storage> {
        let Some(dataset) = &tree.nodes[node].dataset else {
            return Ok(Storage::Contiguous(NOWHERE));
        };
        let n_bytes = stored_bytes(dataset);
        match &dataset.data {
            _ if n_bytes == 0 => Ok(Storage::Contiguous(NOWHERE)),
            Payload::Stored(stored) => Ok(Storage::Contiguous(stored.address)),
            Payload::Chunks { rows, chunks } => Ok(Storage::Chunked {
                rows: *rows,
                index: chunks.stored.expect("its index was stored before"),
            }),
            Payload::Rows(rows) => Ok(rows.place()),
            Payload::New(data) => {
                let alignment = n_bytes.min(ALIGNMENT).next_power_of_two().max(8);
                let address = self.store_at(alignment, data)?.address;
                let found = self.at - address;
                assert_eq!(found, n_bytes, "values must fit element and shape");
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
        let address = self.at.next_multiple_of(alignment);
        let zeros = [0; ALIGNMENT as usize];
        self.append(&zeros[..(address - self.at) as usize])?;
        Ok(address)
    }

    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.hasher.update(bytes);
        if self.is_resuming && !self.file.has_bytes(self.at, bytes).map_err(failed)? {
            self.leave_file()?;
        }
        if !self.is_resuming {
            self.file.write(bytes).map_err(failed)?;
        }
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn append_remote(&mut self, numbers: &NumbersApart) -> Result<()> {
        let end = self.at + numbers.n_bytes;
        if self.is_resuming {
            let start = self.hasher.clone();
            let mut found = start.clone();
            let mut take = |bytes: &[u8]| {
                found.update(bytes);
                true
            };
            let is_there = self.file.has(self.at, numbers.n_bytes, &mut take);
            if is_there.map_err(failed)? {
                self.take_remote(false, numbers)?;
                if found.finalize() == self.hasher.finalize() {
                    self.at = end;
                    return Ok(());
                }
            }
            self.hasher = start;
            self.leave_file()?;
        }
        self.file.flush().map_err(failed)?;
        self.take_remote(true, numbers)?;
        self.at = end;
        self.file.seek(end).map_err(failed)
    }

    /// Has the other ranks hash numbers, and write them if asked, and takes their hashes.
    fn take_remote(&mut self, write: bool, numbers: &NumbersApart) -> Result<()> {
        let to = write.then(|| (self.file.path(), self.at));
        let parts = (numbers.by).write(to, &numbers.numbers, self.hasher.n_bytes())?;
        parts.iter().for_each(|part| self.hasher.take(part));
        Ok(())
    }

    /// Writes from here on: the file has other bytes, or ends.
    fn leave_file(&mut self) -> Result<()> {
        self.is_resuming = false;
        let finished = self.finished.as_ref();
        let superblock = finished.map(|(superblock, _)| &superblock[..]);
        self.file.truncate(self.at, superblock).map_err(failed)
    }
}

impl Drop for StepFile {
    /// Removes a step that failed, so that a full disk has space again for other files.
    fn drop(&mut self) {
        if let Some((superblock, end)) = &self.finished
            && !self.is_resuming
            && self.at > *end
        {
            // The error was reported already, and the step is not part of the file either way.
            let _ = self.file.truncate(*end, Some(superblock));
        }
    }
}
