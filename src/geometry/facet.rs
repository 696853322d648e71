//! The point of one facet closest to the origin.

use super::vector::{Vector, dot, scale, sub};

/// Barycentric weights of the point of a triangle closest to the origin. A triangle whose last two
/// corners coincide is an edge.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5: the Voronoi regions of
/// corners and edges are tried in turn.
#[inline(always)]
pub fn closest_weights([a, b, c]: &[Vector; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (sub(*b, *a), sub(*c, *a), scale(*a, -1.0));
    if b == c {
        let square = dot(ab, ab);
        let t = if square > 0.0 {
            dot(ap, ab) / square
        } else {
            0.0
        };
        let t = t.clamp(0.0, 1.0);
        return [1.0 - t, t, 0.0];
    }
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = scale(*b, -1.0);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = ratio(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = scale(*c, -1.0);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = ratio(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let total = va + vb + vc;
    let (v, w) = (ratio(vb, total), ratio(vc, total));
    [1.0 - v - w, v, w]
}

/// `a / b`, zero for a degenerate facet.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
