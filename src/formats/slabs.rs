//! Mesh files of which some nodes and some cells can be read without the rest, so that each of several ranks reads its own.

use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::mesh::Cells;
use std::ops::Range;

/// A mesh in a file, of which each slab of nodes or cells can be read alone. Nodes and cells have the numbers that they
/// have in the mesh that [`Format::read`](super::Format::read) gives.
pub trait Slabs: Send + Sync {
    /// How many nodes the mesh has.
    fn n_nodes(&self) -> usize;
    /// How many cells it has, boundary faces among them.
    fn n_cells(&self) -> usize;
    /// [`Mesh::space`](crate::mesh::Mesh::space) of the mesh.
    fn space(&self) -> Option<u8> {
        None
    }
    /// The coordinates of some nodes.
    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>>;
    /// Some cells, in memory of about their size; each of their nodes is one of the mesh.
    fn cells(&self, cells: Range<usize>) -> Result<Cells>;
}

/// A file opened by slabs, or why it has to be read as a whole: in words that complete "read whole by one rank: ...".
pub type Opened<'a> = std::result::Result<Box<dyn Slabs + 'a>, String>;
