//! A file that grows in place and is whole after each step.
//!
//! Nothing that was written is written over. A step appends its values, then those headers of the
//! tree that are not in the file yet, and at last replaces the 48 bytes of the superblock, which lie in one
//! page, by ones that point to the new headers. Whoever opens the file before that sees the steps
//! before; so does whoever opens it after the program was killed at any moment.
//!
//! A file that an earlier run began is retraced: the bytes that the same steps give are compared with
//! those that are there, so that all that is to be known of them (addresses, hashes) is known again.
//! From the first byte that is another, or from its end on, the file is written.

use super::element::Element;
use super::header::{self, NOWHERE, Place, SUPERBLOCK};
use super::tree::{Data, Sink, Tree};
use super::write::{ALIGNMENT, Counted, failed, headers, stored_bytes, write_values};
use crate::error::Result;
use crate::formats::Begin;
use crate::formats::save::Emerging;
use std::collections::BTreeMap;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Bytes gathered before they are handed on.
const BUFFER: usize = 1 << 20;

/// What a growing file is written to.
pub(in crate::formats) trait Grows: Write + Seek {
    /// Called when all that was written makes a whole file.
    fn is_whole(&mut self) -> std::io::Result<()> {
        Ok(())
    }

    /// How many of these bytes are there already, from `at` on.
    fn matching(&mut self, _at: u64, _bytes: &[u8]) -> std::io::Result<usize> {
        Ok(0)
    }

    /// Whether nothing comes after so many bytes.
    fn ends_at(&self, _at: u64) -> std::io::Result<bool> {
        Ok(true)
    }

    /// Leaves out what comes after `at`; `superblock` makes what is left a whole file. Without one
    /// the file begins again, with the same first bytes.
    fn part(&mut self, _at: u64, _superblock: Option<&[u8]>) -> std::io::Result<()> {
        Ok(())
    }
}

impl Grows for Emerging {
    fn is_whole(&mut self) -> std::io::Result<()> {
        self.appear()
    }

    fn matching(&mut self, at: u64, bytes: &[u8]) -> std::io::Result<usize> {
        Emerging::matching(self, at, bytes)
    }

    fn ends_at(&self, at: u64) -> std::io::Result<bool> {
        Ok(self.n_bytes()? <= at)
    }

    fn part(&mut self, at: u64, superblock: Option<&[u8]>) -> std::io::Result<()> {
        match superblock {
            Some(superblock) => {
                self.seek(SeekFrom::Start(0))?;
                self.write_all(superblock)?;
                self.cut(at)?;
            }
            None => self.move_aside(at)?,
        }
        self.seek(SeekFrom::Start(at)).map(|_| ())
    }
}

/// A file under work.
pub(in crate::formats) struct Growing<F: Grows = Emerging> {
    out: Counted<BufWriter<F>>,
    hasher: blake3::Hasher,
    headers: Known,
    /// Whether bytes are compared with those of an earlier run.
    is_retracing: bool,
    /// The superblock of the last finished step.
    superblock: Option<Vec<u8>>,
}

/// Headers in the file: hash and how many of the same tree came before it -> address.
type Known = BTreeMap<([u8; 32], usize), u64>;

/// Values in a growing file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) struct Stored {
    address: u64,
}

impl Stored {
    /// The values past so many bytes.
    pub fn past(self, n_bytes: u64) -> Self {
        Self {
            address: self.address + n_bytes,
        }
    }
}

impl Growing {
    /// A new file, which takes its name with the first [`Growing::finish_step`]; or one that is
    /// there and is retraced.
    pub fn create(path: &Path, begin: Begin) -> Result<Self> {
        match begin {
            Begin::Retrace if path.is_file() => Ok(Self::retrace(Emerging::reopen(path)?)),
            _ => Self::start(Emerging::create(path)?),
        }
    }
}

impl<F: Grows> Growing<F> {
    /// Starts in an empty file. It is no HDF5 file before the first [`Growing::finish_step`].
    pub fn start(file: F) -> Result<Self> {
        let mut growing = Self::at(0, file);
        growing.out.write(&[0; SUPERBLOCK])?;
        Ok(growing)
    }

    /// Starts in a file with something in it, behind the superblock.
    pub fn retrace(file: F) -> Self {
        Self {
            is_retracing: true,
            ..Self::at(SUPERBLOCK as u64, file)
        }
    }

    fn at(at: u64, file: F) -> Self {
        Self {
            out: Counted {
                out: BufWriter::with_capacity(BUFFER, file),
                at,
            },
            hasher: blake3::Hasher::new(),
            headers: Known::new(),
            is_retracing: false,
            superblock: None,
        }
    }

    /// Bytes up to the end of what was appended last.
    pub fn n_bytes(&self) -> u64 {
        self.out.at
    }

    /// Whether all bytes so far were there already.
    pub fn is_retracing(&self) -> bool {
        self.is_retracing
    }

    /// Appends values, for a dataset of this step or of later ones ([`Data::Stored`],
    /// [`Data::Chunks`]).
    pub fn store(&mut self, make: impl FnOnce(Sink) -> Result<()>) -> Result<Stored> {
        let address = self.align()?;
        make(&mut |bytes| self.append(bytes))?;
        Ok(Stored { address })
    }

    /// Appends bytes right behind the values stored last.
    pub fn continue_with(&mut self, bytes: &[u8]) -> Result<()> {
        self.append(bytes)
    }

    /// Appends strings, for a dataset of [`Element::String`].
    pub fn store_strings(&mut self, strings: &[String]) -> Result<Stored> {
        let at = self.align()? + strings.len() as u64 * Element::String.size();
        let (heap, references) = header::heap(at, strings);
        let stored = self.store(|sink| sink(&references))?;
        self.append(&heap)?;
        Ok(stored)
    }

    /// Makes `tree` the content of the file; gives the hash of the bytes appended since the last
    /// time. Values of the tree that were not stored before are appended now and belong to this
    /// step alone.
    pub fn finish_step(&mut self, tree: &Tree) -> Result<blake3::Hash> {
        let places: Result<Vec<Place>> =
            (0..tree.nodes.len()).map(|i| self.place(tree, i)).collect();
        let places = places?;
        let mut alike = BTreeMap::new();
        let root = headers(tree, &places, |header| self.header(&header, &mut alike))?;
        let superblock = header::superblock(root, self.out.at);
        self.out.out.flush().map_err(failed)?;
        let at = self.out.at;
        let file = self.out.out.get_mut();
        let goes_on = self.is_retracing && !file.ends_at(at).map_err(failed)?;
        if !goes_on {
            file.seek(SeekFrom::Start(0)).map_err(failed)?;
            file.write_all(&superblock).map_err(failed)?;
            file.seek(SeekFrom::Start(at)).map_err(failed)?;
            file.is_whole().map_err(failed)?;
        }
        self.superblock = Some(superblock);
        let hash = self.hasher.finalize();
        self.hasher.reset();
        Ok(hash)
    }

    /// The file itself, as far as it was handed on.
    #[cfg(test)]
    pub(super) fn file(&self) -> &F {
        self.out.out.get_ref()
    }

    /// Appends what a node has that is not stored yet.
    fn place(&mut self, tree: &Tree, node: usize) -> Result<Place> {
        let Some(dataset) = &tree.nodes[node].dataset else {
            return Ok(Place::Contiguous(NOWHERE));
        };
        match &dataset.data {
            _ if stored_bytes(dataset) == 0 => Ok(Place::Contiguous(NOWHERE)),
            Data::Stored(stored) => Ok(Place::Contiguous(stored.address)),
            Data::Chunks { rows, pieces } => {
                let addresses: Vec<u64> = pieces.iter().map(|piece| piece.address).collect();
                let index = self.align()?;
                self.append(&header::fixed_array(index, &addresses))?;
                Ok(Place::Chunked { rows: *rows, index })
            }
            _ => {
                let address = self.align()?;
                write_values(dataset, address, &mut |bytes| self.append(bytes))?;
                Ok(Place::Contiguous(address))
            }
        }
    }

    /// The address of a header, which is appended unless it is in the file. No two nodes of a tree
    /// get the same one.
    fn header(&mut self, header: &[u8], alike: &mut BTreeMap<[u8; 32], usize>) -> Result<u64> {
        let hash = *blake3::hash(header).as_bytes();
        let before = alike.entry(hash).or_insert(0);
        let key = (hash, *before);
        *before += 1;
        if let Some(address) = self.headers.get(&key) {
            return Ok(*address);
        }
        let address = self.align()?;
        self.append(header)?;
        self.headers.insert(key, address);
        Ok(address)
    }

    fn align(&mut self) -> Result<u64> {
        let address = self.out.at.next_multiple_of(ALIGNMENT);
        let zeros = [0; ALIGNMENT as usize];
        self.append(&zeros[..(address - self.out.at) as usize])?;
        Ok(address)
    }

    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        self.hasher.update(bytes);
        let known = match self.is_retracing {
            true => self.matching(bytes).map_err(failed)?,
            false => 0,
        };
        self.out.write(&bytes[known..])
    }

    /// Passes over those of the bytes that are there; writing begins with the first that is not.
    fn matching(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let file = self.out.out.get_mut();
        let n = file.matching(self.out.at, bytes)?;
        self.out.at += n as u64;
        if n < bytes.len() {
            self.is_retracing = false;
            file.part(self.out.at, self.superblock.as_deref())?;
        }
        Ok(n)
    }
}
