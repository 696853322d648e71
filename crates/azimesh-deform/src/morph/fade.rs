//! The fade radius of a morph's surface correction. It follows from the geometry only, so it is the same for all
//! displacements.

use super::surface::MorphSurface;
use azimesh_core::geometry::vector::{Vector, dot, sub};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::parallel::{SMALL_BLOCK, collect_in_blocks};
use azimesh_rbf::correct::{Faded, Fading};
use azimesh_rbf::images::Images;

/// The fade radius as a multiple of the distance between base points.
const FADE_RADIUS_PER_SPACING: f64 = 1.0;

/// The fade radius at every surface point, and the part of the residuals that is added at each node.
pub struct FadeRows {
    /// `rho` at each surface point, in mesh units.
    pub fade_radius: Vec<f64>,
    /// Nodes within the fade radius, ascending, that are not on the surface themselves. Their corners are surface points, then
    /// points of periodic images.
    pub rows: Vec<Faded>,
    /// The point that each point of an image is of, and its map.
    pub added: Vec<(u32, Transform)>,
}

/// Computes the fade radius at every surface point: the distance of the third nearest base point in the plane, or the
/// fourth nearest in space, as a measure of their spacing; at most half the gap to another surface. `base` are the base
/// points and their images; `skipped` are nodes that are set directly.
///
/// Points at rest that no base point influences have no residual and no fade radius.
pub fn fade_rows(
    surface: &MorphSurface,
    images: &Images,
    base: &[Vector],
    radius: f64,
    nodes: &[Vector],
    skipped: &[bool],
) -> FadeRows {
    let places = &surface.points.points;
    let nearest = if surface.in_plane { 3 } else { 4 };
    let is_moving = surface.is_moving();
    let fade_radius = collect_in_blocks(places.len(), SMALL_BLOCK, |at| {
        let apart = apart(&places[at], base, nearest);
        if is_moving[at] || apart.nearest < radius {
            FADE_RADIUS_PER_SPACING * apart.among
        } else {
            0.0
        }
    });
    let (region, facets) = (Bounds::around(nodes), &surface.points.facets);
    let (mut fading, all) = Fading::continued(images, places, facets, &region, &fade_radius);
    let mut rows = fading.faded(nodes);
    rows.retain(|row| !skipped[row.point as usize]);
    rows.sort_unstable_by_key(|row| row.point);
    rows.shrink_to_fit();
    fading.fade_radius.truncate(places.len());
    FadeRows {
        fade_radius: fading.fade_radius,
        rows,
        added: all.added,
    }
}

/// Distances of base points from a point.
struct Apart {
    nearest: f64,
    /// Distance of the n-th nearest, or of the farthest if there are fewer.
    among: f64,
}

fn apart(point: &Vector, base: &[Vector], n: usize) -> Apart {
    const MOST: usize = 4;
    let mut least = [f64::INFINITY; MOST];
    for b in base {
        let away = sub(*b, *point);
        let mut squared = dot(away, away);
        if squared >= least[n - 1] {
            continue;
        }
        for place in &mut least[..n] {
            if squared < *place {
                std::mem::swap(&mut squared, place);
            }
        }
    }
    let finite = least[..n].iter().filter(|squared| squared.is_finite());
    Apart {
        nearest: least[0].sqrt(),
        among: finite.copied().fold(0.0, f64::max).sqrt(),
    }
}
