//! The exact surface: adds the residuals of the base points at the surface to the nodes near it, fading out.
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
use super::images::{Continued, Images};
use super::kernel::Kernel;
use azimesh_core::geometry::closest::{ClosestPoint, ClosestSurface};
use azimesh_core::geometry::{Bounds, curve, vector::Vector};
use azimesh_core::parallel::{self, SMALL_BLOCK, collect_in_blocks};
use azimesh_core::ranks::raw;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::Range;

/// `rho` in units of the largest residual.
pub const FADE_RADIUS_PER_ERROR: f64 = 30.0;
/// Nodes that one task works on, and tasks whose results are added to the field while the next find
/// theirs.
const BLOCK: usize = 2048;
const BLOCKS: usize = 256;
/// Relative margin of the fade radius in a search for nodes near the surface, so that round-off excludes no node.
const MARGIN: f64 = 1e-9;

/// A surface with residuals at its nodes.
pub struct Correction<'a> {
    fading: Fading<'a>,
    residuals: Cow<'a, [f64]>,
    n_modes: usize,
}

/// A surface with the distance over which residuals at its nodes fade out.
pub struct Fading<'a> {
    surface: ClosestSurface<'a>,
    /// `rho` at each surface node.
    pub fade_radius: Vec<f64>,
    /// The largest of them.
    pub largest_fade_radius: f64,
    /// Smallest gap between two surfaces within twice the fade radius.
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

/// Shares of the residuals at three surface nodes that are added at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Faded {
    /// The point, by its position.
    pub point: u32,
    /// Surface nodes of the facet that is closest.
    pub corners: [u32; 3],
    /// `psi(q / rho)` times the barycentric weights of the foot.
    pub weights: [f64; 3],
}

impl<'a> Fading<'a> {
    /// The surface of `facets` (triangles, or edges with the second corner repeated) between `points`.
    /// The `fade_radius` of each is lowered to half the gap to the nearest facet of a surface that is not
    /// connected to its own.
    pub fn new(
        points: impl Into<Cow<'a, [Vector]>>,
        facets: &[[u32; 3]],
        mut fade_radius: Vec<f64>,
    ) -> Self {
        let surface = ClosestSurface::new(points, facets);
        let gaps = gaps(&surface, &fade_radius);
        for (fade_radius, gap) in fade_radius.iter_mut().zip(&gaps) {
            *fade_radius = fade_radius.min(0.5 * gap);
        }
        let narrowest = gaps.iter().enumerate().filter(|(_, gap)| gap.is_finite());
        Self {
            narrowest_gap: narrowest
                .map(|(node, &width)| Gap { node, width })
                .min_by(|a, b| a.width.total_cmp(&b.width)),
            largest_fade_radius: fade_radius.iter().copied().fold(0.0, f64::max),
            surface,
            fade_radius,
        }
    }

    /// [`Fading::new`] for a surface with those of its periodic images that are near the nodes in a box, and this continued
    /// surface. Images have the fade radius of the points that they are images of. They reach to twice the largest one, where
    /// the widest gap that matters ends.
    pub fn continued(
        images: &Images,
        points: &'a [Vector],
        facets: &'a [[u32; 3]],
        region: &Bounds,
        fade_radius: &[f64],
    ) -> (Self, Continued<'a>) {
        let largest = fade_radius.iter().copied().fold(0.0, f64::max);
        let all = images.within(points, facets, &region.grown(2.0 * largest));
        let n = all.points.len();
        let radii = (0..n).map(|at| fade_radius[all.source(at)]).collect();
        let mut fading = Self::new(all.points.clone(), &all.facets, radii);
        for at in points.len()..n {
            fading.fade_radius[at] = fading.fade_radius[all.source(at)];
        }
        (fading, all)
    }

    /// Returns the part of the residuals that is added at the `points` within the fade radius, in the order of a space-filling
    /// curve. Needs `12 N` bytes temporarily for the `N` points in the surface's box.
    pub fn faded(&self, points: &[Vector]) -> Vec<Faded> {
        let order = self.order(points.len(), |row| points[row]);
        parallel::concat_blocks(order.len(), BLOCK, &|rows| {
            let mut found = Vec::new();
            self.near(
                &order[rows],
                |row| points[row],
                |point, foot, fade| {
                    found.push(Faded {
                        point,
                        corners: foot.corners,
                        weights: foot.weights.map(|weight| fade * weight),
                    });
                },
            );
            found
        })
    }

    /// Returns the points in the box of the surface, grown by the fade radius, along a space-filling curve: consecutive points
    /// have their closest points near each other.
    fn order(&self, n_points: usize, place: impl Fn(usize) -> Vector + Sync) -> Vec<u32> {
        if self.largest_fade_radius == 0.0 {
            return Vec::new();
        }
        let within = self.surface.bounds().grown(self.largest_fade_radius);
        curve::rough_order(n_points, place, &within)
    }

    /// Calls `found(row, foot, psi(q / rho))` for each of the rows that is within the fade radius.
    fn near(
        &self,
        rows: &[u32],
        place: impl Fn(usize) -> Vector,
        mut found: impl FnMut(u32, &ClosestPoint, f64),
    ) {
        let points: Vec<Vector> = rows.iter().map(|&row| place(row as usize)).collect();
        let mut each = |i: usize, foot: &ClosestPoint| {
            let fade_radius = interpolate(foot, |node| self.fade_radius[node]);
            if fade_radius > 0.0 {
                let fade = Kernel::WendlandC2.value(foot.distance_squared.sqrt() / fade_radius);
                found(rows[i], foot, fade);
            }
        };
        self.surface
            .nearest_each(&points, self.largest_fade_radius, &mut each);
    }
}

impl<'a> Correction<'a> {
    /// The surface of `facets` (triangles, or edges with the second corner repeated) between
    /// `points`, with residuals (N_s, r) of at most `error`.
    pub fn new(
        points: &'a [Vector],
        facets: &[[u32; 3]],
        residuals: &'a [f64],
        n_modes: usize,
        error: f64,
    ) -> Self {
        let fade_radius = vec![FADE_RADIUS_PER_ERROR * error; points.len()];
        Self::fading(Fading::new(points, facets, fade_radius), residuals, n_modes)
    }

    /// Residuals (N_s, r) at the nodes of a surface where they fade out.
    pub fn fading(
        fading: Fading<'a>,
        residuals: impl Into<Cow<'a, [f64]>>,
        n_modes: usize,
    ) -> Self {
        Self {
            fading,
            residuals: residuals.into(),
            n_modes,
        }
    }

    /// Returns the smallest gap between two surfaces within twice the fade radius.
    pub fn narrowest_gap(&self) -> Option<Gap> {
        self.fading.narrowest_gap
    }

    /// Adds the correction to the field at `points`. Needs `12 N` bytes temporarily for the `N` nodes in the surface's box.
    pub fn add_to(&self, field: &mut Field, points: &[Vector]) {
        let Field { nodes, values, .. } = field;
        let nodes = nodes.as_deref();
        let place = |row: usize| points[nodes.map_or(row, |nodes| nodes[row] as usize)];
        let n_rows = nodes.map_or(points.len(), <[u32]>::len);
        self.add_at(n_rows, place, values, |row| row);
    }

    /// Adds the correction at the position `place(row)` of each row to the row `target(row)` of `values`.
    pub fn add_at(
        &self,
        n_rows: usize,
        place: impl Fn(usize) -> Vector + Sync,
        values: &mut [f64],
        target: impl Fn(u32) -> u32,
    ) {
        if self.n_modes == 0 {
            return;
        }
        let mut add = |found: &[Added]| {
            for added in found {
                added.add_to(values, self.n_modes, &target);
            }
        };
        let order = self.fading.order(n_rows, &place);
        let mut found: Vec<Added> = Vec::new();
        for order in order.chunks(BLOCK * BLOCKS) {
            let mut next = Vec::new();
            let near = |rows: Range<usize>| self.near(&order[rows], &place);
            parallel::with(&mut || add(&found), &mut || {
                next = parallel::map_blocks(order.len(), BLOCK, &near);
            });
            found = next;
        }
        add(&found);
    }

    /// Checks if a point of the box may be within the fade radius. False is certain, true is not.
    pub fn may_reach(&self, block: &Bounds) -> bool {
        let Fading {
            surface,
            largest_fade_radius: limit,
            ..
        } = &self.fading;
        let is_any = self.n_modes > 0 && *limit > 0.0;
        is_any && surface.may_be_within(limit * (1.0 + MARGIN), block)
    }

    /// Number of modes of the residuals.
    pub fn n_modes(&self) -> usize {
        self.n_modes
    }

    /// Finds the correction at each of `points` that is within the fade radius.
    pub fn at(&self, points: &[Vector]) -> Added {
        let order = self.fading.order(points.len(), |at| points[at]);
        let blocks = parallel::map_blocks(order.len(), BLOCK, &|rows| {
            self.near(&order[rows], |at| points[at])
        });
        let mut all = Added::default();
        for of_block in blocks {
            all.rows.extend(of_block.rows);
            all.added.extend(of_block.added);
        }
        all
    }

    /// The values added at the rows within the fade radius.
    fn near(&self, rows: &[u32], place: impl Fn(usize) -> Vector) -> Added {
        let mut near = Added::default();
        self.fading.near(rows, place, |row, foot, fade| {
            near.rows.push(row);
            near.added.extend((0..self.n_modes).map(|mode| {
                fade * interpolate(foot, |node| self.residuals[node * self.n_modes + mode])
            }));
        });
        near
    }
}

/// The correction at some rows of a field, none of them twice.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Added {
    #[serde(with = "raw")]
    rows: Vec<u32>,
    #[serde(with = "raw")]
    added: Vec<f64>,
}

impl Added {
    /// Adds it to the values of a field, in the row that `row` gives for each.
    pub fn add_to(&self, values: &mut [f64], n_modes: usize, row: impl Fn(u32) -> u32) {
        let added = self.added.chunks_exact(n_modes.max(1));
        for (&at, added) in self.rows.iter().zip(added) {
            let values = &mut values[row(at) as usize * n_modes..][..n_modes];
            for (value, added) in values.iter_mut().zip(added) {
                *value += added;
            }
        }
    }
}

fn interpolate(foot: &ClosestPoint, value: impl Fn(usize) -> f64) -> f64 {
    let corners = foot.corners.iter().zip(foot.weights);
    corners
        .map(|(&node, weight)| weight * value(node as usize))
        .sum()
}

/// Distance from each surface node to the nearest facet of another connected surface; infinite where
/// that is beyond twice its fade radius.
fn gaps(surface: &ClosestSurface<'_>, fade_radius: &[f64]) -> Vec<f64> {
    collect_in_blocks(fade_radius.len(), SMALL_BLOCK, |node| {
        let foot = surface.nearest_apart(node, 2.0 * fade_radius[node]);
        foot.map_or(f64::INFINITY, |foot| foot.distance_squared.sqrt())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::Transform;
    use std::sync::Arc;

    #[test]
    fn gaps_to_periodic_images_limit_the_fade_radius() {
        let points = [0.1, 0.2, 0.65, 0.7].map(|x| [x, 0.0, 0.0]);
        let facets = [[0, 1, 1], [2, 3, 3]];
        let along = |x: f64| Transform {
            translation: [x, 0.0, 0.0],
            ..Transform::IDENTITY
        };
        let images = Images {
            maps: Arc::new(vec![along(1.0), along(-1.0)]),
            leaders: vec![0, 1, 2, 3],
        };
        let region = Bounds::around(&[[0.0; 3], [1.0, 0.0, 0.0]]);
        let (fading, all) = Fading::continued(&images, &points, &facets, &region, &[0.25; 4]);
        // Between the first and the last point the way over the side is 0.4 long, the other gap 0.45.
        let expected = [0.2, 0.225, 0.225, 0.2];
        assert_eq!(all.points.len(), 8);
        for (at, found) in fading.fade_radius.iter().enumerate() {
            assert!(
                (found - expected[all.source(at)]).abs() < 1e-15,
                "{at}: {found}"
            );
        }
    }

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
    fn a_box_within_the_fade_radius_may_be_reached() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let residuals = [0.01, 0.03];
        let correction = Correction::new(&points, &[[0, 1, 1]], &residuals, 1, 0.03);
        let at = |y: f64| Bounds::around(&[[0.4, y, 0.0], [0.6, y + 1.0, 0.0]]);
        assert!(correction.may_reach(&at(0.899)));
        assert!(!correction.may_reach(&at(0.901)));
    }

    #[test]
    fn a_near_surface_lowers_the_fade_radius_to_half_the_gap() {
        let points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.2, 0.0],
            [1.0, 0.2, 0.0],
        ];
        let residuals = [0.03, 0.03, 0.0, 0.0];
        let facets = [[0, 1, 1], [2, 3, 3]];
        let correction = Correction::new(&points, &facets, &residuals, 1, 0.03);
        let gap = correction.narrowest_gap().expect("there is one");
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
