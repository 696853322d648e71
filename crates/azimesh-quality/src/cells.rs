//! Metrics of every cell, for cell arrays and lists of the worst.

use super::reference::Reference;
use super::validity;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel::{self, block};
use azimesh_io::mesh::{DataArray, Mesh, Values};

/// One value a cell of the mesh, in cell order. Boundary faces, and cells whose kind does not have
/// the metric, hold NaN.
#[derive(Debug, Clone)]
pub struct CellMetrics {
    /// Volume, or area in 2D; positive for a cell that is oriented as in the reference.
    pub volume: Vec<f64>,
    /// Scaled Jacobian.
    pub scaled_jacobian: Vec<f64>,
    /// Ratio of longest to shortest edge.
    pub edge_ratio: Vec<f64>,
    /// Equiangle skew.
    pub skew: Vec<f64>,
    /// True if the cell is inverted, by the rule of [`super::Summary::inverted`].
    pub inverted: Vec<bool>,
}

impl CellMetrics {
    /// As cell arrays `Volume`, `ScaledJacobian`, `EdgeRatio`, `EquiangleSkew`, `Inverted`.
    pub fn into_arrays(self) -> Vec<DataArray> {
        let inverted = self.inverted.into_iter().map(u8::from).collect();
        vec![
            DataArray::scalar("Volume", Values::F64(self.volume)),
            DataArray::scalar("ScaledJacobian", Values::F64(self.scaled_jacobian)),
            DataArray::scalar("EdgeRatio", Values::F64(self.edge_ratio)),
            DataArray::scalar("EquiangleSkew", Values::F64(self.skew)),
            DataArray::scalar("Inverted", Values::U8(inverted)),
        ]
    }
}

/// Metrics of every cell of `mesh` with its nodes at `points`, relative to `reference`.
///
/// # Panics
/// When `points` has fewer nodes than the mesh, or `reference` is of a mesh with fewer cells.
pub fn per_cell(mesh: &Mesh, points: &[Vector], reference: &Reference) -> CellMetrics {
    let n_cells = mesh.cells.len();
    let nothing = vec![f64::NAN; n_cells];
    let mut all = CellMetrics {
        volume: nothing.clone(),
        scaled_jacobian: nothing.clone(),
        edge_ratio: nothing.clone(),
        skew: nothing,
        inverted: vec![false; n_cells],
    };
    let columns = (all.volume.chunks_mut(CHUNK))
        .zip(all.scaled_jacobian.chunks_mut(CHUNK))
        .zip(all.edge_ratio.chunks_mut(CHUNK))
        .zip(all.skew.chunks_mut(CHUNK))
        .zip(all.inverted.chunks_mut(CHUNK));
    parallel::for_items(columns, &|chunk, columns| {
        let ((((volume, scaled), edge_ratio), skew), inverted) = columns;
        let range = block(n_cells, CHUNK, chunk);
        let first = range.start;
        visit::volume_cells(mesh, points, reference.facing(), range, |start, block| {
            for i in 0..block.n {
                let metrics = block.get(i);
                let (cell, at) = (start + i, start + i - first);
                let sign = reference.sign(cell);
                volume[at] = metrics.volume(sign);
                scaled[at] = metrics.scaled_jacobian(sign);
                edge_ratio[at] = metrics.edge_ratio_squared().sqrt();
                skew[at] = metrics.angles.skew().unwrap_or(f64::NAN);
                inverted[at] = reference.is_inverted(cell, &metrics);
            }
        });
    });
    for cell in validity::assess(mesh, points, reference, 0..mesh.cells.len()).inside {
        all.inverted[cell as usize] = true;
    }
    all
}

/// The scaled Jacobian of every evaluated cell; NaN for others, and where it is not defined.
pub fn scaled_jacobians(mesh: &Mesh, points: &[Vector], reference: &Reference) -> Vec<f64> {
    let mut all = vec![f64::NAN; mesh.cells.len()];
    parallel::for_items(all.chunks_mut(CHUNK), &|chunk, values: &mut [f64]| {
        let range = block(mesh.cells.len(), CHUNK, chunk);
        let first = range.start;
        visit::volume_cells(mesh, points, reference.facing(), range, |start, block| {
            for i in (0..block.n).filter(|i| reference.is_valid(start + i)) {
                let sign = reference.sign(start + i);
                values[start + i - first] = block.get(i).scaled_jacobian(sign);
            }
        });
    });
    all
}
