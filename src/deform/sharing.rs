//! Who shares the work on a mesh, of which this process may hold the outline alone.

use super::first_cells::Edge;
use super::mesh_file::MeshFile;
use super::team::Team;
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::mesh::{Doubled, Mesh};
use std::sync::Arc;

/// Who shares the work.
pub enum Sharing {
    /// Nobody.
    Alone,
    /// Nobody, and the rest of the mesh is in a file: it is looked at, and does not move.
    File(Arc<MeshFile>),
    /// The ranks, of which this process is the first.
    Ranks(Arc<Team>),
}

impl Sharing {
    /// The ranks, where they share it.
    pub(crate) fn team(&self) -> Option<&Arc<Team>> {
        match self {
            Self::Ranks(team) => Some(team),
            _ => None,
        }
    }

    /// The same, where cells get copies of nodes: `mesh` has them, or is the outline of what has them.
    ///
    /// # Errors
    /// Where ranks cannot read their parts once more.
    pub(super) fn doubled(self, doubled: Doubled, mesh: &mut Mesh) -> Result<Self> {
        let file = match &self {
            Self::Alone => return Ok(self),
            Self::Ranks(team) => {
                team.double(doubled)?;
                return Ok(self);
            }
            Self::File(file) => file.doubled(doubled),
        };
        if let Some(outline) = &mut mesh.outline {
            outline.by = file.clone();
        }
        Ok(Self::File(file))
    }

    /// Who looks at all cells where this process has the outline.
    pub(crate) fn holder(&self) -> Option<&dyn Holder> {
        match self {
            Self::Alone => None,
            Self::File(file) => Some(&**file),
            Self::Ranks(team) => Some(&**team),
        }
    }
}

/// Looks at all cells of a mesh of which the outline alone is here.
pub(crate) trait Holder: Send + Sync {
    /// The shortest edge that leaves the wall at each of these nodes, which are ascending, and where it ends.
    fn edges_off_walls(&self, nodes: &[u32]) -> Result<(Vec<Edge>, Vec<Vector>)>;

    /// Those of some boundary faces of an outline, ascending, that are a side of no cell.
    fn faces_on_no_cell(&self, outline: &Mesh, faces: &[u32]) -> Result<Vec<u32>>;
}
