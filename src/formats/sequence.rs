//! A whole sequence of meshes in one file.

use super::WriteOptions;
use crate::error::Result;
use crate::mesh::Mesh;
use std::path::Path;

/// A file that takes one mesh after another.
///
/// It stands under its name once the first mesh is whole, and whatever happens to the program
/// after that, it holds the meshes that were appended before.
pub trait SequenceFile: Send {
    /// Appends a mesh with the nodes, cells and arrays of the first, whose positions and values may
    /// differ; gives the hash of the bytes that were added to the file.
    fn append(&mut self, time: f64, mesh: &Mesh) -> Result<blake3::Hash>;

    /// A sentence for each thing of the first mesh that the format cannot hold.
    fn notes(&self) -> &[String];
}

/// Starts a file of a sequence; one that has the name is replaced when the first mesh is whole.
pub type CreateSequence = fn(&Path, &WriteOptions) -> Result<Box<dyn SequenceFile>>;
