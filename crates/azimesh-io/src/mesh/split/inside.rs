//! A point on the inner side of all planes of a cell, or lines of a polygon.

use azimesh_core::geometry::vector::{Vector, add, dot, scale, sub};

/// A plane: a point on it, and its unit normal to the inner side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub at: Vector,
    pub inward: Vector,
}

/// Distances from the planes that are tried, in parts of the size, the largest first.
const DEPTHS: [f64; 7] = [0.2, 0.1, 0.05, 0.02, 0.005, 1e-3, 1e-4];
/// Moves onto one plane for each of them.
const MOST_MOVES: usize = 300;
/// Round-off of a distance, in parts of the size.
const ROUND_OFF: f64 = 1e-12;

/// Distance to the nearest of the planes, negative beyond it; and which it is.
fn depth(planes: &[Plane], x: Vector) -> (f64, usize) {
    let of = |plane: &Plane| dot(plane.inward, sub(x, plane.at));
    let mut least = (f64::INFINITY, 0);
    for (i, plane) in planes.iter().enumerate() {
        let depth = of(plane);
        if depth < least.0 {
            least = (depth, i);
        }
    }
    least
}

/// A point on the inner side of all planes, and whether there is one: the first of `candidates` that is, else
/// one found by moving onto the plane that is missed most (Agmon, Motzkin and Schoenberg, 1954), for ever
/// smaller distances from the planes. The first candidate where nothing is found.
///
/// `size` is the size of the cell. O(planes) per move.
pub(super) fn inner_point(planes: &[Plane], candidates: &[Vector], size: f64) -> (Vector, bool) {
    let is_inside = |x: &Vector| depth(planes, *x).0 > ROUND_OFF * size;
    if let Some(found) = candidates.iter().find(|x| is_inside(x)) {
        return (*found, true);
    }
    for part in DEPTHS {
        let wanted = part * size;
        let mut x = candidates[0];
        for _ in 0..MOST_MOVES {
            let (least, at) = depth(planes, x);
            if least >= 0.5 * wanted && is_inside(&x) {
                return (x, true);
            }
            x = add(x, scale(planes[at].inward, wanted - least));
        }
    }
    (candidates[0], false)
}
