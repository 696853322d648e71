//! Wedges: between its triangles the Jacobian is linear across and quadratic along the upright edges, so that three
//! quadratics decide.

use super::Proof;
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};

/// Rounding of a coefficient, as a part of the product of the longest edges.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Proves or refutes a wedge whose positive orientation is `sign`.
pub fn wedge(p: &[Vector; 6], sign: f64) -> Proof {
    let (b1, b2) = (sub(p[1], p[0]), sub(p[2], p[0]));
    let (t1, t2) = (sub(p[4], p[3]), sub(p[5], p[3]));
    let up = [sub(p[3], p[0]), sub(p[4], p[1]), sub(p[5], p[2])];
    let normals = [
        cross(b1, b2),
        scale(add(cross(b1, t2), cross(t1, b2)), 0.5),
        cross(t1, t2),
    ];
    let longest = |edges: &[Vector]| edges.iter().map(|edge| norm(*edge)).fold(0.0, f64::max);
    let across = longest(&[b1, b2, t1, t2, sub(b2, b1), sub(t2, t1)]);
    let bound = ROUNDING * across * across * longest(&up);
    let mut worst = Proof::Valid;
    for up in up {
        let [c0, c1, c2] = normals.map(|normal| sign * dot(normal, up));
        if c0.is_nan() || c2.is_nan() || c0 <= 0.0 || c2 <= 0.0 {
            return Proof::Corner;
        }
        // The least of c0 (1-t)^2 + 2 c1 t (1-t) + c2 t^2 is positive where c1 > -sqrt(c0 c2).
        let margin = c1 + (c0 * c2).sqrt();
        if margin < -bound {
            worst = Proof::Inside;
        } else if (margin <= bound || c0.min(c2) <= bound) && c1 <= 0.0 && worst == Proof::Valid {
            worst = Proof::Unproven;
        }
    }
    worst
}
