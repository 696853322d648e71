//! A dataset of a sequence that grows with the steps at which it changes.

use super::super::hdf5::{Chunks, Element, Payload, Rows, Stored};
use super::blocks::{Block, shape};
use super::write::Grid;

/// A dataset to which a step adds rows, unless it has those of the step before.
pub(super) struct Series {
    pub group: &'static str,
    pub name: String,
    pub element: Element,
    pub n_rows: u64,
    pub n_components: u64,
    /// Rows of a chunk, and chunks of a step.
    pub chunk_rows: u64,
    pub n_chunks: u64,
    pub n_pieces: u64,
    pub chunks: Chunks,
    pub last: Option<blake3::Hash>,
    /// The whole dataset as long as all steps have the rows of the first.
    pub object: Option<Stored>,
    /// The first row of each step.
    pub offsets: Rows,
    /// Of an array of the mesh as a whole, its components and rows at each step.
    pub sizes: Rows,
}

impl Series {
    pub fn new(block: &Block, chunk_limit: u64) -> Self {
        let column = &block.column;
        let (n_rows, n_components) = (column.n_tuples as u64, column.n_components as u64);
        let element = Element::from(column.element);
        let n_chunks = (n_rows * n_components * element.size()).div_ceil(chunk_limit);
        let n_chunks = n_chunks.max(1);
        Self {
            group: block.group,
            name: column.name.to_owned(),
            element,
            n_rows,
            n_components,
            chunk_rows: n_rows.div_ceil(n_chunks),
            n_chunks,
            n_pieces: 0,
            chunks: Chunks::new(shape(1, n_components).len()),
            last: None,
            object: None,
            offsets: Rows::new(Element::I64, &[]),
            sizes: Rows::new(Element::I64, &[2]),
        }
    }

    /// Rows from one piece to the next.
    pub fn stride(&self) -> u64 {
        self.chunk_rows * self.n_chunks
    }

    pub fn row(&self) -> u64 {
        self.n_components * self.element.size()
    }

    /// Bytes that fill up the last chunk of a piece.
    pub fn padding(&self) -> u64 {
        (self.stride() - self.n_rows) * self.row()
    }

    /// Adds the rows of a step.
    pub fn add(&mut self, stored: Stored) {
        let chunk_bytes = self.chunk_rows * self.row();
        for i in 0..self.n_chunks {
            self.chunks.push(stored.past(i * chunk_bytes));
        }
        self.n_pieces += 1;
    }

    /// Adds the dataset to the file as it is now.
    pub fn add_to<'a>(&'a self, grid: &mut Grid<'a>) {
        let parent = grid.group(self.group);
        if let Some(object) = self.object {
            grid.tree.object(parent, &self.name, object);
            return;
        }
        let shape = shape(self.n_pieces * self.stride(), self.n_components);
        let data = Payload::Chunks {
            rows: self.chunk_rows,
            chunks: &self.chunks,
        };
        let tree = &mut grid.tree;
        tree.dataset(parent, &self.name, self.element, &shape, data);
    }
}
