//! Who shares the work on a mesh, of which this process may hold the outline alone, and where that is not enough.

use super::first_cells::Edge;
use super::mesh_file::MeshFile;
use super::slabs::{Joined, OneSlab};
use super::team::Team;
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::mesh::{Doubled, Mesh};
use crate::motion::{QualityOutput, Schedule};
use std::sync::Arc;

/// Who shares the work.
#[derive(Default, Clone)]
pub enum Sharing {
    /// Nobody.
    #[default]
    Alone,
    /// Nobody, and the rest of the mesh is in a file: it is looked at, and does not move.
    File(Arc<MeshFile>),
    /// The ranks, of which this process is the first.
    Ranks(Arc<Team>),
    /// Processes that work on other slabs; this one works on a slab.
    Slab(Arc<OneSlab>),
    /// Processes that have worked on slabs; this one joins these.
    Joined(Arc<Joined>),
}

impl Sharing {
    /// The ranks, where they share it.
    pub(crate) fn team(&self) -> Option<&Arc<Team>> {
        match self {
            Self::Ranks(team) => Some(team),
            _ => None,
        }
    }

    /// The slab that this process works on, where it does.
    pub(crate) fn slab(&self) -> Option<&OneSlab> {
        match self {
            Self::Slab(slab) => Some(slab),
            _ => None,
        }
    }

    /// The same, where cells get copies of nodes: `mesh` has them, or is the outline of what has them.
    ///
    /// # Errors
    /// Where ranks cannot read their parts once more.
    pub(super) fn doubled(self, doubled: Doubled, mesh: &mut Mesh) -> Result<Self> {
        if let Self::Ranks(team) = &self {
            team.double(doubled)?;
            return Ok(self);
        }
        let Some(outline) = &mut mesh.outline else {
            return Ok(self);
        };
        let double = |file: &Arc<MeshFile>| {
            let file = file.doubled(doubled);
            outline.by = file.clone();
            file
        };
        Ok(match &self {
            Self::File(file) => Self::File(double(file)),
            Self::Slab(slab) => {
                let slab = slab.of_file(double);
                mesh.forget_arrays();
                Self::Slab(Arc::new(slab))
            }
            Self::Joined(joined) => Self::Joined(Arc::new(joined.of_file(double))),
            Self::Alone | Self::Ranks(_) => self,
        })
    }

    /// The slabs that this process joins, where it does.
    pub(crate) fn joined(&self) -> Option<&Arc<Joined>> {
        match self {
            Self::Joined(joined) => Some(joined),
            _ => None,
        }
    }

    /// Who has the whole mesh where this process has the outline.
    pub(crate) fn holder(&self) -> Option<&dyn Holder> {
        let by = |file| file as &dyn Holder;
        match self {
            Self::Alone => None,
            Self::File(file) => Some(&**file),
            Self::Ranks(team) => Some(&**team),
            Self::Slab(slab) => slab.file.as_deref().map(by),
            Self::Joined(joined) => joined.file.as_deref().map(by),
        }
    }
}

/// Why an outline is not enough for the steps of a schedule.
pub(crate) fn run_needs_whole(schedule: &Schedule) -> Option<&'static str> {
    let output = &schedule.output;
    let makes_arrays = output.quality == QualityOutput::Cells;
    makes_arrays.then_some("it makes arrays of all cells (quality = \"cells\")")
}

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
