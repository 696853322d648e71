//! Hexahedra: the Bernstein coefficients of the Jacobian of the trilinear map.
//!
//! ```text
//! det J = sum_ijk c_ijk B_i(x) B_j(y) B_k(z),  B of degree 2
//! ```
//!
//! It is between the least and the largest coefficient, and at the corners it has the corner coefficients.
//! Subdivision by de Casteljau brings both together.
//!
//! Source: A. Johnen, J.-C. Weill, J.-F. Remacle, Robust and efficient validation of the linear hexahedral element,
//! Procedia Engineering 203, 2017.

use super::Proof;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, sub};

/// Subdivisions of a hexahedron at most.
const DEPTH: u32 = 6;
/// Rounding of a coefficient, as a part of the product of the longest edges.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The coefficients, `[i][j][k]`.
type Coefficients = [[[f64; 3]; 3]; 3];

/// Proves or refutes a hexahedron whose positive orientation is `sign`.
pub fn hexahedron(p: &[Vector; 8], sign: f64) -> Proof {
    let (mut c, size) = coefficients(p);
    for value in c.as_flattened_mut().as_flattened_mut() {
        *value *= sign;
    }
    let bound = ROUNDING * size;
    if corners(&c)
        .iter()
        .any(|value| value.is_nan() || *value <= 0.0)
    {
        return Proof::Corner;
    }
    decide(&c, bound, DEPTH)
}

fn decide(c: &Coefficients, bound: f64, depth: u32) -> Proof {
    let all = c.as_flattened().as_flattened();
    if all.iter().all(|value| *value > bound) {
        return Proof::Valid;
    }
    if corners(c).iter().any(|value| *value < -bound) {
        return Proof::Inside;
    }
    if depth == 0 || corners(c).iter().any(|value| *value <= bound) {
        return Proof::Unproven;
    }
    let mut worst = Proof::Valid;
    for child in children(c) {
        match decide(&child, bound, depth - 1) {
            Proof::Inside => return Proof::Inside,
            Proof::Unproven => worst = Proof::Unproven,
            Proof::Valid | Proof::Corner => {}
        }
    }
    worst
}

/// The values at the eight corners.
fn corners(c: &Coefficients) -> [f64; 8] {
    std::array::from_fn(|n| c[2 * (n & 1)][n & 2][(n & 4) / 2])
}

/// The coefficients of a hexahedron, and the product of its longest edges along each axis.
fn coefficients(p: &[Vector; 8]) -> (Coefficients, f64) {
    // Corner (x, y, z) in VTK's order.
    let corner = |x: usize, y: usize, z: usize| p[[[0, 3], [1, 2]][x][y] + 4 * z];
    let x: [[Vector; 2]; 2] = [0, 1].map(|y| [0, 1].map(|z| sub(corner(1, y, z), corner(0, y, z))));
    let y: [[Vector; 2]; 2] = [0, 1].map(|x| [0, 1].map(|z| sub(corner(x, 1, z), corner(x, 0, z))));
    let z: [[Vector; 2]; 2] = [0, 1].map(|x| [0, 1].map(|y| sub(corner(x, y, 1), corner(x, y, 0))));
    const SHARES: [f64; 3] = [1.0, 0.5, 1.0];
    let mut c = [[[0.0; 3]; 3]; 3];
    for (xy, zy) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        for (zx, yz) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            // `y` at (xy, zy), `z` at (zx, yz), with every `x` at (b, c).
            let normal = cross(y[xy][zy], z[zx][yz]);
            let i = xy + zx;
            for b in 0..2 {
                for a in 0..2 {
                    let (j, k) = (b + yz, a + zy);
                    c[i][j][k] += SHARES[i] * SHARES[j] * SHARES[k] * dot(x[b][a], normal);
                }
            }
        }
    }
    let longest = |edges: &[[Vector; 2]; 2]| {
        let lengths = edges.as_flattened().iter().map(|edge| norm(*edge));
        lengths.fold(0.0, f64::max)
    };
    (c, longest(&x) * longest(&y) * longest(&z))
}

/// The coefficients on the eight halves of halves of halves.
fn children(c: &Coefficients) -> [Coefficients; 8] {
    let [low, high] = halves(c, 0);
    let mut all = [[[[0.0; 3]; 3]; 3]; 8];
    let mut at = 0;
    for part in [low, high] {
        for part in halves(&part, 1) {
            for part in halves(&part, 2) {
                all[at] = part;
                at += 1;
            }
        }
    }
    all
}

/// The coefficients on the two halves along an axis.
fn halves(c: &Coefficients, axis: usize) -> [Coefficients; 2] {
    let at = |m: usize, i: usize, j: usize| match axis {
        0 => [m, i, j],
        1 => [i, m, j],
        _ => [i, j, m],
    };
    let mut parts = [[[[0.0; 3]; 3]; 3]; 2];
    for i in 0..3 {
        for j in 0..3 {
            let value = |m: usize| {
                let [a, b, d] = at(m, i, j);
                c[a][b][d]
            };
            let (first, last) = (0.5 * (value(0) + value(1)), 0.5 * (value(1) + value(2)));
            let middle = 0.5 * (first + last);
            for (part, values) in [[value(0), first, middle], [middle, last, value(2)]]
                .iter()
                .enumerate()
            {
                for m in 0..3 {
                    let [a, b, d] = at(m, i, j);
                    parts[part][a][b][d] = values[m];
                }
            }
        }
    }
    parts
}
