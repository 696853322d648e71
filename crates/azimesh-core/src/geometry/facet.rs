//! The points of facets closest to the origin, for some facets side by side.

use super::vector::{Vector, add, dot, scale, sub};

/// Barycentric weights of the point of a triangle closest to the origin. A triangle whose last two
/// corners coincide is an edge.
///
/// Free of branches, so that a loop over facets becomes vector instructions: the regions are tried in turn, and the
/// first that holds the origin is taken last.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5: the Voronoi regions of
/// corners and edges.
#[inline(always)]
fn closest_weights([a, b, c]: &[Vector; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (sub(*b, *a), sub(*c, *a), scale(*a, -1.0));
    let (bp, cp) = (scale(*b, -1.0), scale(*c, -1.0));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    let (vc, vb, va) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
    let total = va + vb + vc;
    let (v, w) = (ratio(vb, total), ratio(vc, total));
    let inside = [1.0 - v - w, v, w];
    let t = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
    let is_on_bc = (va <= 0.0) & (d4 - d3 >= 0.0) & (d5 - d6 >= 0.0);
    let weights = choose(is_on_bc, [0.0, 1.0 - t, t], inside);
    let t = ratio(d2, d2 - d6);
    let is_on_ac = (vb <= 0.0) & (d2 >= 0.0) & (d6 <= 0.0);
    let weights = choose(is_on_ac, [1.0 - t, 0.0, t], weights);
    let weights = choose((d6 >= 0.0) & (d5 <= d6), [0.0, 0.0, 1.0], weights);
    let t = ratio(d1, d1 - d3);
    let is_on_ab = (vc <= 0.0) & (d1 >= 0.0) & (d3 <= 0.0);
    let weights = choose(is_on_ab, [1.0 - t, t, 0.0], weights);
    let weights = choose((d3 >= 0.0) & (d4 <= d3), [0.0, 1.0, 0.0], weights);
    let weights = choose((d1 <= 0.0) & (d2 <= 0.0), [1.0, 0.0, 0.0], weights);
    let t = ratio(d1, dot(ab, ab));
    let t = if t > 0.0 { t } else { 0.0 };
    let t = if t < 1.0 { t } else { 1.0 };
    let is_edge = (b[0] == c[0]) & (b[1] == c[1]) & (b[2] == c[2]);
    choose(is_edge, [1.0 - t, t, 0.0], weights)
}

/// `a` if it is so, else `b`.
#[inline(always)]
fn choose(is_so: bool, a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        if is_so { a[0] } else { b[0] },
        if is_so { a[1] } else { b[1] },
        if is_so { a[2] } else { b[2] },
    ]
}

/// `a / b`, zero for a degenerate facet.
#[inline(always)]
fn ratio(a: f64, b: f64) -> f64 {
    let quotient = a / b;
    if b > 0.0 { quotient } else { 0.0 }
}

/// Facets of a pack.
pub const PACK: usize = 8;

/// Some facets side by side: their corners, one column a coordinate. Not numbers where there is no facet.
#[derive(Debug, Clone, Copy)]
pub struct FacetPack {
    corners: [[[f64; PACK]; 3]; 3],
}

impl Default for FacetPack {
    fn default() -> Self {
        Self {
            corners: [[[f64::NAN; PACK]; 3]; 3],
        }
    }
}

/// The closest points of the facets of a pack.
#[derive(Debug, Clone, Copy, Default)]
pub struct ClosestPoints {
    /// Barycentric weights, by corner.
    pub weights: [[f64; PACK]; 3],
    /// Squares of the distances.
    pub distances_squared: [f64; PACK],
}

impl FacetPack {
    /// Of at most [`PACK`] facets.
    pub fn new<'a>(facets: impl IntoIterator<Item = &'a [u32; 3]>, points: &[Vector]) -> Self {
        let mut pack = Self::default();
        for (lane, facet) in facets.into_iter().take(PACK).enumerate() {
            for k in 0..3 {
                for axis in 0..3 {
                    pack.corners[k][axis][lane] = points[facet[k] as usize][axis];
                }
            }
        }
        pack
    }

    /// The points that are closest to `point`.
    #[inline(always)]
    pub fn closest(&self, point: &Vector) -> ClosestPoints {
        let mut found = ClosestPoints::default();
        for lane in 0..PACK {
            let mut corners = [[0.0; 3]; 3];
            for k in 0..3 {
                for axis in 0..3 {
                    corners[k][axis] = self.corners[k][axis][lane] - point[axis];
                }
            }
            let weights = closest_weights(&corners);
            let away = add(
                add(scale(corners[0], weights[0]), scale(corners[1], weights[1])),
                scale(corners[2], weights[2]),
            );
            found.distances_squared[lane] = dot(away, away);
            for k in 0..3 {
                found.weights[k][lane] = weights[k];
            }
        }
        found
    }
}
