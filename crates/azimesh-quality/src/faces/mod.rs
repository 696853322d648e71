//! Finite-volume metrics of faces as OpenFOAM's checkMesh defines them: non-orthogonality, skewness,
//! volume ratio of neighbours, interpolation weight. Edges are the faces of a plane mesh.

mod block;
mod centres;
mod geometry;
mod per_cell;
mod solids;
#[cfg(test)]
mod tests;
mod walk;

use super::reference::Reference;
use super::summary::Extreme;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{Adjacency, Mesh};
use block::Measured;
use centres::Centres;
use geometry::Centre;
pub use per_cell::per_cell;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Quality of the faces between the volume cells of a mesh. `None` where there are none. An extreme
/// names the face's owner, the first of its cells.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaceSummary {
    /// Faces between two cells.
    pub n_inner: usize,
    /// Faces of one cell.
    pub n_outer: usize,
    /// Largest angle between the normal of a face and the line between the centres of its cells, in
    /// degrees.
    pub max_non_orthogonality: Option<Extreme>,
    /// The angle whose cosine is the mean cosine, as checkMesh has it, in degrees.
    pub mean_non_orthogonality: Option<f64>,
    /// Largest skewness of any face, outer ones included.
    pub max_face_skewness: Option<Extreme>,
    /// Smallest ratio of smaller to larger volume of two neighbours; negative where a cell is.
    pub min_volume_ratio: Option<Extreme>,
    /// Smallest interpolation weight, 0.5 at best.
    pub min_face_weight: Option<Extreme>,
}

impl FaceSummary {
    /// Names and values for lists of results.
    pub fn columns(&self) -> [(&'static str, Option<f64>); 5] {
        let value = |extreme: Option<Extreme>| extreme.map(|e| e.value);
        [
            ("max_non_orthogonality", value(self.max_non_orthogonality)),
            ("mean_non_orthogonality", self.mean_non_orthogonality),
            ("max_face_skewness", value(self.max_face_skewness)),
            ("min_volume_ratio", value(self.min_volume_ratio)),
            ("min_face_weight", value(self.min_face_weight)),
        ]
    }
}

/// Memory for centres of cells that is used again at the next step: fresh memory costs as much time as the centres.
#[derive(Debug, Default)]
pub struct Workspace(Mutex<Vec<Centre>>);

impl Workspace {
    fn take(&self) -> Vec<Centre> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn keep(&self, centres: Vec<Centre>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = centres;
    }
}

/// Bytes of the centres of cells while faces are evaluated.
pub(super) fn step_bytes(mesh: &Mesh) -> usize {
    let stored = mesh
        .volume_runs()
        .filter(|run| !centres::is_simplex(run.kind));
    32 * stored.map(|run| run.n_cells()).sum::<usize>()
}

/// Quality of the faces of `mesh` with its nodes at `points`.
///
/// Two parallel passes: centres of cells that are no simplices (32 bytes each, which `workspace` keeps), then faces. Sums are
/// folded over fixed chunks in order, so the result is the same on any number of threads.
///
/// # Panics
/// When `points` has fewer nodes than the mesh, or `reference` or `adjacency` is of a mesh with other
/// cells.
pub fn assess(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
    adjacency: &Adjacency,
    workspace: &Workspace,
) -> FaceSummary {
    let centres = Centres::new(mesh, points, reference, workspace.take());
    let own = adjacency.own_chunks();
    let parts = parallel::map(own.len(), &|i| {
        let mut part = FaceTotals::default();
        walk::faces_of(&centres, adjacency, own.start + i, &mut part);
        part.numbered(mesh.own_offset())
    });
    let own = ([adjacency.n_inner(), adjacency.n_outer()], parts);
    let whole = (mesh.ranks()).ordered_fold(
        FaceTotals::default(),
        own,
        |whole, ([inner, outer], parts)| {
            whole.n_inner += inner;
            whole.n_outer += outer;
            for part in &parts {
                whole.append(part);
            }
        },
    );
    workspace.keep(centres.stored);
    whole.finish()
}

/// Sums and extremes over the faces of a chunk.
#[derive(Default, Serialize, Deserialize)]
struct FaceTotals {
    n_inner: usize,
    n_outer: usize,
    cosine_sum: f64,
    min_cosine: Least,
    max_skewness: Least,
    min_volume_ratio: Least,
    min_weight: Least,
}

/// A least value and the cell that has it; of several the one with the lowest index.
#[derive(Default, Clone, Copy, Serialize, Deserialize)]
struct Least(Option<(f64, u32)>);

impl Least {
    #[inline]
    fn include(&mut self, value: f64, cell: u32) {
        let is_less = match self.0 {
            None => !value.is_nan(),
            Some((least, first)) => value < least || value == least && cell < first,
        };
        if is_less {
            self.0 = Some((value, cell));
        }
    }

    /// Includes `sign` times the values of some cells, which are ascending; `extreme` is the value where that is least.
    #[inline]
    fn include_all(&mut self, sign: f64, extreme: f64, values: &[f64], cells: &[u32]) {
        let may_be_less = self.0.is_none_or(|(least, _)| sign * extreme <= least);
        if may_be_less && let Some(i) = values.iter().position(|&value| value == extreme) {
            self.include(sign * extreme, cells[i]);
        }
    }

    fn merge(&mut self, other: Self) {
        if let Some((value, cell)) = other.0 {
            self.include(value, cell);
        }
    }

    fn as_extreme(self, value: impl Fn(f64) -> f64) -> Option<Extreme> {
        self.0.map(|(least, cell)| Extreme {
            value: value(least),
            cell: cell as usize,
        })
    }
}

impl walk::Sink for FaceTotals {
    fn inner(&mut self, faces: &Measured<'_>) {
        let all = &faces.extremes;
        self.cosine_sum += all.cosine_sum;
        let owners = faces.cells[0];
        self.min_cosine
            .include_all(1.0, all.least_cosine, faces.cosine, owners);
        self.max_skewness
            .include_all(-1.0, all.most_skewness, faces.skewness, owners);
        self.min_volume_ratio
            .include_all(1.0, all.least_volume_ratio, faces.volume_ratio, owners);
        self.min_weight
            .include_all(1.0, all.least_weight, faces.weight, owners);
    }

    fn outer(&mut self, cell: usize, skewness: f64) {
        self.max_skewness.include(-skewness, cell as u32);
    }
}

impl FaceTotals {
    /// With the numbers of cells increased.
    fn numbered(mut self, by: usize) -> Self {
        let all = [
            &mut self.min_cosine,
            &mut self.max_skewness,
            &mut self.min_volume_ratio,
            &mut self.min_weight,
        ];
        for (_, cell) in all.into_iter().filter_map(|least| least.0.as_mut()) {
            *cell += by as u32;
        }
        self
    }

    fn append(&mut self, next: &Self) {
        self.cosine_sum += next.cosine_sum;
        self.min_cosine.merge(next.min_cosine);
        self.max_skewness.merge(next.max_skewness);
        self.min_volume_ratio.merge(next.min_volume_ratio);
        self.min_weight.merge(next.min_weight);
    }

    fn finish(self) -> FaceSummary {
        let n_inner = self.n_inner;
        FaceSummary {
            n_inner,
            n_outer: self.n_outer,
            max_non_orthogonality: self.min_cosine.as_extreme(angle_deg),
            mean_non_orthogonality: (n_inner > 0)
                .then(|| angle_deg(self.cosine_sum / n_inner as f64)),
            max_face_skewness: self.max_skewness.as_extreme(|x| -x),
            min_volume_ratio: self.min_volume_ratio.as_extreme(|x| x),
            min_face_weight: self.min_weight.as_extreme(|x| x),
        }
    }
}

fn angle_deg(cosine: f64) -> f64 {
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}
