//! The worst cells of a mesh, without a list of all cells.

use super::reference::Reference;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::Mesh;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// A cell that may be among the worst.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Index of the cell among all cells of the mesh.
    pub cell: usize,
    /// Its scaled Jacobian; NaN where its kind has none.
    pub scaled_jacobian: f64,
    /// Its volume, or area in 2D.
    pub volume: f64,
}

impl Candidate {
    /// Orders worse cells first: by the scaled Jacobian, then cells without one by their volume; equal ones compare as equal.
    pub fn rank(&self, other: &Self) -> Ordering {
        let (a, b) = (self.scaled_jacobian, other.scaled_jacobian);
        let by_jacobian = a.is_nan().cmp(&b.is_nan()).then(a.total_cmp(&b));
        by_jacobian.then(self.volume.total_cmp(&other.volume))
    }
}

/// Returns the `n` worst volume cells, the worst first; ties are resolved by the lowest index. For a part of a mesh it
/// returns the worst cells of the whole, by their numbers there.
///
/// One parallel pass that keeps at most `n` cells of each chunk.
///
/// # Panics
/// When `points` has fewer nodes than the mesh, or `reference` is of a mesh with fewer cells.
pub fn worst(mesh: &Mesh, points: &[Vector], reference: &Reference, n: usize) -> Vec<Candidate> {
    if n == 0 {
        return Vec::new();
    }
    let offset = mesh.own_offset();
    let found = parallel::map_blocks_in(mesh.own_cells(), CHUNK, &|range| {
        let mut found = Vec::new();
        visit::volume_cells(mesh, points, reference.facing(), range, |first, block| {
            for i in 0..block.n {
                let (cell, metrics) = (first + i, block.get(i));
                let sign = reference.sign(cell);
                found.push(Candidate {
                    cell: cell + offset,
                    scaled_jacobian: metrics.scaled_jacobian(sign),
                    volume: metrics.volume(sign),
                });
            }
        });
        keep(&mut found, n);
        found
    });
    let mut found = found.concat();
    keep(&mut found, n);
    let mut found = mesh.ranks().allgather(found).concat();
    keep(&mut found, n);
    found
}

/// Sorts, and drops all but the `n` worst.
fn keep(found: &mut Vec<Candidate>, n: usize) {
    let order = |a: &Candidate, b: &Candidate| a.rank(b).then(a.cell.cmp(&b.cell));
    if n < found.len() {
        found.select_nth_unstable_by(n, order);
        found.truncate(n);
    }
    found.sort_unstable_by(order);
}
