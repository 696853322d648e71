//! Smallest, mean and largest value of every metric of a mesh, found in one pass over its cells.

use super::Extreme;
use super::detail::{self, N_DETAILS};
use super::reference::Reference;
use super::validity::CurvedMaps;
use super::visit::CHUNK;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::Mesh;
use serde::{Deserialize, Serialize};

/// Names of the metrics that the summary has as well, before the further ones.
const FIRST: [&str; 4] = ["volume", "scaled_jacobian", "edge_ratio", "equiangle_skew"];

const N_METRICS: usize = FIRST.len() + N_DETAILS;

/// One metric over the volume cells that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistic {
    /// Name of the metric, as `scaled_jacobian`.
    pub name: &'static str,
    /// Number of cells that have it.
    pub n_cells: usize,
    /// Smallest value; of several cells with it the first. `None` where no cell has the metric.
    pub min: Option<Extreme>,
    /// Mean over the cells where it is finite.
    pub mean: Option<f64>,
    /// Largest value; of several cells with it the first.
    pub max: Option<Extreme>,
}

/// Every metric, with the nodes at `points`, relative to `reference`.
///
/// One parallel pass; sums are folded over fixed chunks of cells in order.
///
/// # Panics
/// When `points` has fewer nodes than the mesh, or `reference` is of a mesh with fewer cells.
pub fn statistics(mesh: &Mesh, points: &[Vector], reference: &Reference) -> Vec<Statistic> {
    let offset = mesh.own_offset();
    let curved = CurvedMaps::new(mesh);
    let chunks = parallel::map_blocks_in(mesh.own_cells(), CHUNK, &|range| {
        let mut tallies = [Tally::EMPTY; N_METRICS];
        detail::each(
            mesh,
            points,
            reference,
            &curved,
            range,
            |cell, metrics, detail| {
                let sign = reference.sign(cell);
                let first = [
                    metrics.volume(sign),
                    metrics.scaled_jacobian(sign),
                    metrics.edge_ratio_squared().sqrt(),
                    metrics.angles.skew().unwrap_or(f64::NAN),
                ];
                let values = first.into_iter().chain(detail.values());
                for (tally, value) in tallies.iter_mut().zip(values) {
                    tally.add(value, cell + offset);
                }
            },
        );
        tallies
    });
    let nothing = vec![Tally::EMPTY; N_METRICS];
    let whole = mesh.ranks().ordered_fold(nothing, chunks, |whole, chunks| {
        for chunk in &chunks {
            for (tally, next) in whole.iter_mut().zip(chunk) {
                tally.append(next);
            }
        }
    });
    let further = detail::NAMES.iter().map(|(name, _)| *name);
    let names = FIRST.into_iter().chain(further).zip(&whole);
    // Other ranks may have curved cells.
    let is_had = |(name, tally): &(&str, &Tally)| {
        tally.n_cells > 0 || !detail::CURVED.iter().any(|curved| curved.0 == *name)
    };
    names
        .filter(is_had)
        .map(|(name, tally)| tally.finish(name))
        .collect()
}

/// Sum of one metric of some cells.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Tally {
    n_cells: usize,
    n_finite: usize,
    sum: f64,
    min: Extreme,
    max: Extreme,
}

impl Tally {
    const EMPTY: Self = Self {
        n_cells: 0,
        n_finite: 0,
        sum: 0.0,
        min: Extreme {
            value: f64::INFINITY,
            cell: usize::MAX,
        },
        max: Extreme {
            value: f64::NEG_INFINITY,
            cell: usize::MAX,
        },
    };

    #[inline]
    fn add(&mut self, value: f64, cell: usize) {
        if value.is_nan() {
            return;
        }
        self.n_cells += 1;
        if value.is_finite() {
            self.n_finite += 1;
            self.sum += value;
        }
        self.widen(Extreme { value, cell }, Extreme { value, cell });
    }

    /// Cells come in order, so the first of equal values stays; an infinite one is taken once.
    #[inline]
    fn widen(&mut self, low: Extreme, high: Extreme) {
        if low.value < self.min.value || self.min.cell == usize::MAX {
            self.min = low;
        }
        if high.value > self.max.value || self.max.cell == usize::MAX {
            self.max = high;
        }
    }

    fn append(&mut self, next: &Self) {
        if next.n_cells > 0 {
            self.n_cells += next.n_cells;
            self.n_finite += next.n_finite;
            self.sum += next.sum;
            self.widen(next.min, next.max);
        }
    }

    fn finish(&self, name: &'static str) -> Statistic {
        let known = self.n_cells > 0;
        Statistic {
            name,
            n_cells: self.n_cells,
            min: known.then_some(self.min),
            mean: (self.n_finite > 0).then(|| self.sum / self.n_finite as f64),
            max: known.then_some(self.max),
        }
    }
}
