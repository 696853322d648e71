//! Who has the mesh of which this process holds the outline alone.

use super::first_cells::Edge;
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::mesh::Mesh;

/// Has the whole mesh, or can read it.
pub(crate) trait Holder: Send + Sync {
    /// The whole mesh.
    ///
    /// # Errors
    /// Where it cannot be read again.
    fn whole(&self) -> Result<Mesh>;

    /// The hash of the file that the mesh is in.
    fn hash_of_file(&self) -> Result<blake3::Hash>;

    /// The shortest edge that leaves the wall at each of these nodes, which are ascending, and where it ends.
    fn edges_off_walls(&self, nodes: &[u32]) -> Result<(Vec<Edge>, Vec<Vector>)>;

    /// Those of some boundary faces of an outline, ascending, that are a side of no cell.
    fn faces_on_no_cell(&self, outline: &Mesh, faces: &[u32]) -> Result<Vec<u32>>;
}
