//! A dataset that gets one more row with each step: a time, a name, a number of a row.
//!
//! Rows that are constant or grow by a constant are written ahead of the steps that need them. Others are in chunks,
//! and each step rewrites the last one.

use super::header::size;
use super::index::Chunks;
use super::tree::{NOWHERE, Storage, Stored};
use crate::formats::vtk::number::{Element, Number};
use azimesh_core::error::Result;

/// Bytes of the smallest chunk.
const SMALLEST: usize = 512;
/// The fewest rows that are extrapolated.
const FEWEST: usize = 64;

/// The rows, all of one length.
pub(in crate::formats) struct Rows {
    pub(super) element: Element,
    /// Sizes of a row; none where it is one value.
    row: Vec<u64>,
    row_bytes: usize,
    bytes: Vec<u8>,
    /// True if all rows so far follow from the first two.
    goes_on: bool,
    /// The rows in one piece, and how many are in the file.
    piece: (Stored, usize),
    /// Rows of a chunk; 0 as long as there are none.
    chunk_rows: usize,
    chunks: Chunks,
}

impl Rows {
    /// No row yet. A row consists of some numbers of 8 bytes.
    pub fn new(element: Element, row: &[u64]) -> Self {
        let row_bytes = (row.iter().product::<u64>() * size(element)) as usize;
        assert!(row_bytes.is_multiple_of(8), "rows must be of 8-byte words");
        Self {
            element,
            row: row.to_vec(),
            row_bytes,
            bytes: Vec::new(),
            goes_on: true,
            piece: (Stored { address: NOWHERE }, 0),
            chunk_rows: 0,
            chunks: Chunks::new(1 + row.len()),
        }
    }

    /// Adds a row.
    pub fn push<T: Number>(&mut self, row: &[T]) {
        let row: &[u8] = bytemuck::cast_slice(row);
        assert_eq!(row.len(), self.row_bytes, "rows must be of one length");
        self.goes_on &= self.n_rows() < 2 || self.extrapolated(1) == row;
        self.bytes.extend(row);
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.bytes.len() / self.row_bytes
    }

    /// Sizes of the dataset.
    pub(super) fn shape(&self) -> Vec<u64> {
        let n = self.n_rows() as u64;
        std::iter::once(n).chain(self.row.iter().copied()).collect()
    }

    /// Position of its rows, once they are in the file.
    pub(super) fn place(&self) -> Storage {
        match self.chunks.stored {
            Some(index) if self.chunk_rows < self.n_rows() => Storage::Chunked {
                rows: self.chunk_rows as u64,
                index,
            },
            _ => Storage::Contiguous(self.piece.0.address),
        }
    }

    /// Puts rows into the file that are not there yet: `put` gives an address to bytes.
    pub(super) fn store(&mut self, mut put: impl FnMut(&[u8]) -> Result<u64>) -> Result<()> {
        let n = self.n_rows();
        if self.goes_on {
            if self.piece.1 < n {
                let n_ahead = match n {
                    0 | 1 => n,
                    _ => (2 * n).next_power_of_two().max(FEWEST),
                };
                let bytes = [&self.bytes[..], &self.extrapolated(n_ahead - n)].concat();
                let address = put(&bytes)?;
                self.piece = (Stored { address }, n_ahead);
            }
            return Ok(());
        }
        let rows = chunk_rows(n, self.row_bytes);
        if rows != self.chunk_rows {
            self.chunk_rows = rows;
            self.chunks = Chunks::new(1 + self.row.len());
        }
        // The last chunk of the step before may have been none that is full.
        let chunk_bytes = rows * self.row_bytes;
        let first = self.chunks.len().saturating_sub(1);
        for (number, chunk) in self.bytes.chunks(chunk_bytes).enumerate().skip(first) {
            let mut chunk = chunk.to_vec();
            chunk.resize(chunk_bytes, 0);
            let address = put(&chunk)?;
            self.piece = (Stored { address }, 0);
            self.chunks.truncate(number);
            self.chunks.push(Stored { address });
        }
        if n > rows {
            self.chunks.store(put)?;
        }
        Ok(())
    }

    /// The next rows, where they go on as the last two do.
    fn extrapolated(&self, n: usize) -> Vec<u8> {
        let words = |row: usize| -> Vec<u64> {
            let row = &self.bytes[row * self.row_bytes..][..self.row_bytes];
            let words = row.as_chunks::<8>().0.iter();
            words.map(|word| u64::from_ne_bytes(*word)).collect()
        };
        if n == 0 {
            return Vec::new();
        }
        let last = words(self.n_rows() - 1);
        let before = words(self.n_rows().saturating_sub(2));
        let row = |ahead: u64| {
            let pairs = last.iter().zip(&before);
            pairs.map(move |(last, before)| {
                last.wrapping_add(last.wrapping_sub(*before).wrapping_mul(ahead))
            })
        };
        let words: Vec<u64> = (1..=n as u64).flat_map(row).collect();
        bytemuck::cast_slice(&words).to_vec()
    }
}

/// Rows of a chunk: so many that the chunk and the list of all chunks take about as many bytes.
fn chunk_rows(n_rows: usize, row_bytes: usize) -> usize {
    let mut rows = SMALLEST / row_bytes;
    while rows * rows * row_bytes < 8 * n_rows {
        rows *= 2;
    }
    rows
}
