//! The interface of formats that keep a whole sequence of meshes in one file or folder.

use super::{Notes, WriteOptions};
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use std::path::Path;

/// A file to which meshes are appended one after another.
///
/// It has its name once the first mesh is committed. If the program ends after that, for whatever reason, the file
/// is valid and holds the meshes that were committed.
pub trait SequenceFile: Send {
    /// Appends a mesh with the same cells and arrays as the first; positions and values may differ. Returns the hash
    /// of the bytes added to the file. The mesh is part of the file from the next [`SequenceFile::commit`] on.
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash>;

    /// Makes the mesh that was appended last a part of the file. Must be called before another is appended.
    fn commit(&mut self) -> Result<()>;

    /// Appends and commits.
    fn push(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        let hash = self.append(time, mesh)?;
        self.commit()?;
        Ok(hash)
    }

    /// Notes on what the format cannot hold of the first mesh.
    fn notes(&self) -> &Notes;

    /// Bytes of the file up to the end of the mesh appended last.
    fn n_bytes(&self) -> u64;

    /// Ends a resumed file ([`Begin::Resume`]) with the mesh appended last: removes what comes after it. Returns
    /// whether there was anything.
    fn end(&mut self) -> Result<bool>;

    /// Whether all meshes appended so far were in the file before ([`Begin::Resume`]).
    fn is_resuming(&self) -> bool;
}

/// The sizes that each mesh of a sequence adds to its file.
#[derive(Debug, Clone, Copy)]
pub struct StepSize {
    /// Number of nodes.
    pub n_nodes: u64,
    /// Whether all of them lie in the plane z = 0, at every step.
    pub is_plane: bool,
    /// Bytes of a coordinate.
    pub number: u64,
    /// Number of node arrays of three components of 8 bytes.
    pub n_vectors: u64,
    /// Number of cell arrays that change, and their bytes per cell together.
    pub at_cells: (u64, u64),
    /// Number of cells, and of those with the dimension of the mesh.
    pub n_cells: (u64, u64),
    /// Number of arrays that do not change.
    pub n_still: u64,
    /// Number of steps of the sequence.
    pub n_steps: u64,
}

/// Upper bounds of the bytes that a mesh adds to the file of a sequence.
#[derive(Debug, Clone, Copy, Default)]
pub struct StepBytes {
    /// Its coordinates.
    pub coordinates: u64,
    /// Its arrays.
    pub arrays: u64,
    /// The metadata that locates them.
    pub rest: u64,
}

/// What happens to an existing file of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// It is replaced when the first mesh is complete.
    Create,
    /// It is resumed: appended meshes that it holds already are compared, not written. From the first byte that
    /// differs on it is overwritten; the meshes before that byte stay readable at every moment.
    Resume,
    /// It is an empty staged file, which is filled in place; the caller commits it.
    Fill,
}

/// Opens a file of a sequence. With `sync` each mesh is synced to the disk when it is committed.
pub type CreateSequence =
    fn(&Path, &WriteOptions, Begin, sync: bool) -> Result<Box<dyn SequenceFile>>;
