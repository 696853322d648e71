//! The index of the chunks of a growing dataset: a B-tree; a step rewrites only the path to its last leaf.
//!
//! Format: B-tree version 2, records of type 10 (chunks without filters). Chunks come in order, so
//! that all nodes but the last of each level are alike: with M(k) the most records of a node of level
//! k (0: leaves), S(0) = 1 and S(k + 1) = S(k) M(k), record i of level k belongs to chunk
//!
//! ```text
//! (i + 1) S(k) - 1
//! ```
//!
//! and node j has the records j M(k) to (j + 1) M(k) - 2; the one after them is record j of the next
//! level. The last node has up to M(k).

use super::messages::with_checksum;
use super::tree::{NOWHERE, Stored};
use azimesh_core::error::Result;
use std::ops::Range;

/// Bytes of a node.
const NODE: usize = 512;
/// Signature, version, type and checksum of a node.
const AROUND: usize = 10;
/// Bytes of an address, and of the number of records of a child.
const POINTER: usize = 8 + 1;
/// Version of the format; type of the records.
const KIND: [u8; 2] = [0, 10];
/// Percent full at which a writer would split and merge nodes.
const SPLIT_MERGE: [u8; 2] = [100, 40];

/// Chunks of a dataset, in order.
pub(in crate::formats) struct Chunks {
    /// Indices of the dataset; chunks follow one another along the first.
    rank: usize,
    addresses: Vec<u64>,
    /// Levels of the tree so far, leaves first.
    levels: Vec<Level>,
    /// The index of all chunks, once it is in the file.
    pub(super) stored: Option<Stored>,
}

/// A level of the tree.
struct Level {
    /// Chunks from one node to the next: S(k + 1).
    span: usize,
    /// Chunks from one record to the next: S(k).
    stride: usize,
    /// The most records that a node of this level and those below it can have.
    most: usize,
    /// Full nodes in the file.
    full: Vec<u64>,
}

impl Level {
    /// Records from one node to the next: M(k); the last of them is on a higher level.
    fn width(&self) -> usize {
        self.span / self.stride
    }
}

/// The last node of a level.
struct Last {
    address: u64,
    n_records: usize,
}

impl Chunks {
    /// None yet, of a dataset with so many indices.
    pub fn new(rank: usize) -> Self {
        Self {
            rank,
            addresses: Vec::new(),
            levels: Vec::new(),
            stored: None,
        }
    }

    /// Adds the next chunk.
    pub fn push(&mut self, chunk: Stored) {
        self.addresses.push(chunk.address);
        self.stored = None;
    }

    /// Keeps the first `n` chunks, if there are more.
    pub(super) fn truncate(&mut self, n: usize) {
        self.addresses.truncate(n);
    }

    /// Number of chunks.
    pub fn len(&self) -> usize {
        self.addresses.len()
    }

    /// Puts what is missing of the index into the file: `put` gives an address to bytes.
    pub(super) fn store(&mut self, mut put: impl FnMut(&[u8]) -> Result<u64>) -> Result<()> {
        let n = self.addresses.len();
        if self.stored.is_some() || n == 0 {
            return Ok(());
        }
        let (mut n_records, mut below) = (n, None);
        for depth in 0.. {
            if self.levels.len() == depth {
                self.levels.push(self.level(depth));
            }
            let width = self.levels[depth].width();
            let n_full = (n_records - 1) / width;
            for node in self.levels[depth].full.len()..n_full {
                let records = node * width..(node + 1) * width - 1;
                let address = put(&self.node(depth, records, below.as_ref()))?;
                self.levels[depth].full.push(address);
            }
            let records = n_full * width..n_records;
            let last = Last {
                n_records: records.len(),
                address: put(&self.node(depth, records, below.as_ref()))?,
            };
            if n_full == 0 {
                let address = put(&self.header(depth, &last))?;
                self.stored = Some(Stored { address });
                break;
            }
            (n_records, below) = (n_full, Some(last));
        }
        Ok(())
    }

    /// Bytes of a record: an address, and the number of a chunk along each index.
    fn record(&self) -> usize {
        8 + 8 * self.rank
    }

    fn level(&self, depth: usize) -> Level {
        let Some(below) = depth.checked_sub(1).map(|below| &self.levels[below]) else {
            let most = (NODE - AROUND) / self.record();
            return Level {
                span: most,
                stride: 1,
                most,
                full: Vec::new(),
            };
        };
        let pointer = POINTER + self.total_width(depth - 1);
        let most = (NODE - AROUND - pointer) / (self.record() + pointer);
        Level {
            span: below.span * most,
            stride: below.span,
            most: (most + 1) * below.most + most,
            full: Vec::new(),
        }
    }

    /// Bytes of the number of all records at and below a node; leaves need none.
    fn total_width(&self, depth: usize) -> usize {
        match depth {
            0 => 0,
            _ => self.levels[depth].most.ilog2() as usize / 8 + 1,
        }
    }

    /// The node of a level with these of the level's records.
    fn node(&self, depth: usize, records: Range<usize>, below: Option<&Last>) -> Vec<u8> {
        let stride = self.levels[depth].stride;
        let signature = if depth == 0 { b"BTLF" } else { b"BTIN" };
        let mut bytes = [&signature[..], &KIND].concat();
        for record in records.clone() {
            let chunk = (record + 1) * stride - 1;
            bytes.extend(self.addresses[chunk].to_le_bytes());
            bytes.extend((chunk as u64).to_le_bytes());
            bytes.resize(bytes.len() + 8 * (self.rank - 1), 0);
        }
        if depth > 0 {
            for child in records.start..=records.end {
                self.point_to(child, depth - 1, below, &mut bytes);
            }
        }
        let mut bytes = with_checksum(bytes);
        bytes.resize(NODE, 0);
        bytes
    }

    /// Adds what a node knows of its child.
    fn point_to(&self, child: usize, depth: usize, last: Option<&Last>, bytes: &mut Vec<u8>) {
        let level = &self.levels[depth];
        let (address, n_records, total) = match (level.full.get(child), last) {
            (None, Some(last)) => {
                let total = self.addresses.len() - child * level.span;
                (last.address, last.n_records, total)
            }
            (full, _) => {
                let address = full.copied().unwrap_or(NOWHERE);
                (address, level.width() - 1, level.span - 1)
            }
        };
        bytes.extend(address.to_le_bytes());
        bytes.push(n_records as u8);
        bytes.extend(&(total as u64).to_le_bytes()[..self.total_width(depth)]);
    }

    fn header(&self, depth: usize, root: &Last) -> Vec<u8> {
        let mut header = [&b"BTHD"[..], &KIND].concat();
        header.extend((NODE as u32).to_le_bytes());
        header.extend((self.record() as u16).to_le_bytes());
        header.extend((depth as u16).to_le_bytes());
        header.extend(SPLIT_MERGE);
        header.extend(root.address.to_le_bytes());
        header.extend((root.n_records as u16).to_le_bytes());
        header.extend((self.addresses.len() as u64).to_le_bytes());
        with_checksum(header)
    }
}

/// The end of the layout message of a dataset with an index of this kind.
pub(super) fn layout_of(index: Stored) -> Vec<u8> {
    const KIND_OF_INDEX: u8 = 5;
    let mut message = vec![KIND_OF_INDEX];
    message.extend((NODE as u32).to_le_bytes());
    message.extend(SPLIT_MERGE);
    message.extend(index.address.to_le_bytes());
    message
}
