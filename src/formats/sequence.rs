//! A whole sequence of meshes in one file.

use super::{Notes, WriteOptions};
use crate::error::Result;
use crate::mesh::MeshView;
use std::path::Path;

/// A file that takes one mesh after another.
///
/// It stands under its name once the first mesh is committed, and whatever happens to the program
/// after that, it holds the meshes that were committed before.
pub trait SequenceFile: Send {
    /// Appends a mesh with the nodes, cells and arrays of the first, whose positions and values may
    /// differ; gives the hash of the bytes that were added to the file. It is in the file from the next
    /// [`SequenceFile::commit`] on.
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash>;

    /// Makes the mesh that was appended last one of the file, before another is appended.
    fn commit(&mut self) -> Result<()>;

    /// Appends and commits.
    fn push(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        let hash = self.append(time, mesh)?;
        self.commit()?;
        Ok(hash)
    }

    /// What of the first mesh the format cannot hold.
    fn notes(&self) -> &Notes;

    /// Bytes of the file up to the end of the mesh appended last.
    fn n_bytes(&self) -> u64;

    /// After the last mesh of a file that was there before: leaves out what comes after that. Tells
    /// whether there was something.
    fn end(&mut self) -> Result<bool>;

    /// Whether all that was appended so far was in the file before ([`Begin::Resume`]).
    fn is_resuming(&self) -> bool;
}

/// What each mesh of a sequence has of its own.
#[derive(Debug, Clone, Copy)]
pub struct StepSize {
    /// Nodes.
    pub n_nodes: u64,
    /// Whether all of them lie in the plane z = 0, at every step.
    pub is_plane: bool,
    /// Bytes of a coordinate.
    pub number: u64,
    /// Arrays of three components of 8 bytes at the nodes.
    pub n_vectors: u64,
    /// Arrays at the cells that change, and the bytes that they have together for one cell.
    pub at_cells: (u64, u64),
    /// Cells, and those of the mesh's own dimension.
    pub n_cells: (u64, u64),
    /// Arrays that stay the same.
    pub n_still: u64,
    /// Steps of the sequence.
    pub n_steps: u64,
}

/// Bytes that a mesh of a sequence adds to the file of all, at the most.
#[derive(Debug, Clone, Copy, Default)]
pub struct StepBytes {
    /// Its coordinates.
    pub coordinates: u64,
    /// Its arrays.
    pub arrays: u64,
    /// What says where those are.
    pub rest: u64,
}

/// What becomes of a file that has the name of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// It is replaced when the first mesh is whole.
    Create,
    /// Meshes that it holds already are compared with it, not written; from the first byte that is
    /// another it is written over. It holds the meshes before that at every moment.
    Resume,
    /// It is there, empty, and is filled as it is: who made it gives it its name when all is done.
    Fill,
}

/// Starts a file of a sequence. With `sync` each mesh is on the disk when it is committed.
pub type CreateSequence =
    fn(&Path, &WriteOptions, Begin, sync: bool) -> Result<Box<dyn SequenceFile>>;
