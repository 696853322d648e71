//! The exact surface: carries what the base points leave at the surface into the volume, fading out.
//!
//! ```text
//! M(x) += e(c(x)) psi(q / rho),   psi = wendland-c2
//! ```
//!
//! `c(x)` is the closest point of the surface, `e` the mode residual interpolated linearly there,
//! `q` the distance; `rho` is 30 times the largest residual, at most half the local gap to another
//! surface. The residual is in the span of the modes, so this is done once for all steps. Not the
//! nearest node: on sheared cells that leaves a nearly folded first cell.
//!
//! Source: T. C. S. Rendall and C. B. Allen, Int. J. Numer. Meth. Engng 81, 2010, for the idea.

use super::field::Field;
use super::kernel::Kernel;
use crate::geometry::closest::{ClosestSurface, Foot};
use crate::geometry::{curve, vector::Vector};
use rayon::prelude::*;

/// `rho` in units of the largest residual.
pub const REACH: f64 = 30.0;
/// Nodes that one task works on, and tasks whose results are added to the field while the next find
/// theirs.
const BLOCK: usize = 2048;
const BLOCKS: usize = 256;

/// A surface with residuals at its nodes.
pub struct Correction<'a> {
    surface: ClosestSurface<'a>,
    residuals: &'a [f64],
    n_modes: usize,
    /// `rho` at each surface node.
    reach: Vec<f64>,
    largest_reach: f64,
    /// Smallest gap between two surfaces that was found within twice the reach.
    pub narrowest_gap: Option<Gap>,
}

/// A place where two surfaces come close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Surface node, by its position among the surface nodes.
    pub node: usize,
    /// Distance to the other surface, in mesh units.
    pub width: f64,
}

impl<'a> Correction<'a> {
    /// The surface of `facets` (triangles, or edges with the second corner repeated) between
    /// `points`, with residuals (N_s, r) that reach `error` at most.
    pub fn new(
        points: &'a [Vector],
        facets: &[[u32; 3]],
        residuals: &'a [f64],
        n_modes: usize,
        error: f64,
    ) -> Self {
        let surface = ClosestSurface::new(points, facets);
        let rho = REACH * error;
        let gaps = gaps(&surface, points.len(), 2.0 * rho);
        let reach: Vec<f64> = gaps.iter().map(|gap| rho.min(0.5 * gap)).collect();
        let narrowest = gaps.iter().enumerate().filter(|(_, gap)| gap.is_finite());
        Self {
            narrowest_gap: narrowest
                .map(|(node, &width)| Gap { node, width })
                .min_by(|a, b| a.width.total_cmp(&b.width)),
            largest_reach: reach.iter().copied().fold(0.0, f64::max),
            surface,
            residuals,
            n_modes,
            reach,
        }
    }

    /// Adds the correction to the field at `points`. Nodes are taken along a space-filling curve, so
    /// that those which ask one after another have their feet near each other. `12 N` bytes on the
    /// way for the `N` nodes in the surface's box.
    pub fn add_to(&self, field: &mut Field, points: &[Vector]) {
        if self.n_modes == 0 || self.largest_reach == 0.0 {
            return;
        }
        let Field { nodes, values, .. } = field;
        let nodes = nodes.as_deref();
        let place = |row: usize| points[nodes.map_or(row, |nodes| nodes[row] as usize)];
        let within = self.surface.bounds().grown(self.largest_reach);
        let order = curve::rough_order(values.len() / self.n_modes, place, &within);
        let mut found: Vec<Near> = Vec::new();
        for blocks in order.chunks(BLOCK * BLOCKS) {
            let blocks = blocks.par_chunks(BLOCK);
            let next = || blocks.map(|rows| self.near(rows, place)).collect();
            (_, found) = rayon::join(|| self.add(&found, values), next);
        }
        self.add(&found, values);
    }

    fn add(&self, found: &[Near], values: &mut [f64]) {
        for (row, added) in found.iter().flat_map(|near| near.rows(self.n_modes)) {
            let values = &mut values[row as usize * self.n_modes..][..self.n_modes];
            for (value, added) in values.iter_mut().zip(added) {
                *value += added;
            }
        }
    }

    /// What is added at those of the rows that are in reach.
    fn near(&self, rows: &[u32], place: impl Fn(usize) -> Vector) -> Near {
        let points: Vec<Vector> = rows.iter().map(|&row| place(row as usize)).collect();
        let mut near = Near::default();
        let mut add = |i: usize, foot: &Foot| {
            let reach = interpolate(foot, |node| self.reach[node]);
            if reach > 0.0 {
                let fade = Kernel::WendlandC2.value(foot.distance_squared.sqrt() / reach);
                near.rows.push(rows[i]);
                near.added.extend((0..self.n_modes).map(|mode| {
                    fade * interpolate(foot, |node| self.residuals[node * self.n_modes + mode])
                }));
            }
        };
        self.surface
            .nearest_each(&points, self.largest_reach, &mut add);
        near
    }
}

/// What is added to some rows of a field.
#[derive(Default)]
struct Near {
    rows: Vec<u32>,
    added: Vec<f64>,
}

impl Near {
    fn rows(&self, n_modes: usize) -> impl Iterator<Item = (u32, &[f64])> {
        let added = self.added.chunks_exact(n_modes);
        self.rows.iter().copied().zip(added)
    }
}

fn interpolate(foot: &Foot, value: impl Fn(usize) -> f64) -> f64 {
    let corners = foot.corners.iter().zip(foot.weights);
    corners
        .map(|(&node, weight)| weight * value(node as usize))
        .sum()
}

/// Distance from each surface node to the nearest facet of another connected surface; infinite where
/// that is beyond `limit`.
fn gaps(surface: &ClosestSurface<'_>, n_points: usize, limit: f64) -> Vec<f64> {
    let gap = |node: usize| {
        let foot = surface.nearest_apart(node, limit);
        foot.map_or(f64::INFINITY, |foot| foot.distance_squared.sqrt())
    };
    (0..n_points).into_par_iter().map(gap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_residual_is_whole_at_the_surface_and_gone_at_rho() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let residuals = [0.01, 0.03];
        let correction = Correction::new(&points, &[[0, 1, 1]], &residuals, 1, 0.03);
        let volume = [[0.5, 0.0, 0.0], [0.5, 0.45, 0.0], [0.5, 0.91, 0.0]];
        let mut field = Field {
            nodes: None,
            n_modes: 1,
            values: vec![0.0; 3],
        };
        correction.add_to(&mut field, &volume);
        assert!((field.values[0] - 0.02).abs() < 1e-15);
        assert!((field.values[1] - 0.02 * Kernel::WendlandC2.value(0.5)).abs() < 1e-15);
        assert_eq!(field.values[2], 0.0);
    }

    #[test]
    fn a_near_surface_halves_the_reach_to_half_the_gap() {
        let points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.2, 0.0],
            [1.0, 0.2, 0.0],
        ];
        let residuals = [0.03, 0.03, 0.0, 0.0];
        let facets = [[0, 1, 1], [2, 3, 3]];
        let correction = Correction::new(&points, &facets, &residuals, 1, 0.03);
        let gap = correction.narrowest_gap.expect("there is one");
        assert!((gap.width - 0.2).abs() < 1e-15);
        let mut field = Field {
            nodes: None,
            n_modes: 1,
            values: vec![0.0],
        };
        correction.add_to(&mut field, &[[0.5, 0.1, 0.0]]);
        assert_eq!(field.values[0], 0.0);
    }
}
