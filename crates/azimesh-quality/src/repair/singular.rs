//! Singular values of small matrices: `J = U diag(s) V^T` with rotations `U`, `V`, the last value having the sign of
//! the determinant.
//!
//! Source: one-sided Jacobi rotations, M. R. Hestenes, Inversion of matrices by biorthogonalization, J. SIAM 6, 1958.

use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};

/// A 3x3 matrix by columns.
pub(super) type Columns = [Vector; 3];

/// Sweeps over the pairs of columns at most; four leave a relative error of about 1e-9 at worst.
const SWEEPS: usize = 4;
/// Two columns are orthogonal where the square of the cosine between them is no more than this.
const ORTHOGONAL: f64 = 1e-18;

/// The decomposition of a matrix.
pub(super) struct Singular {
    /// Left vectors, by columns.
    pub u: Columns,
    /// Values; the last one signed.
    pub s: Vector,
    /// Right vectors, by columns.
    pub v: Columns,
}

/// Decomposes a matrix of full size.
#[inline(always)]
pub(super) fn decompose(j: &Columns) -> Singular {
    let mut a = *j;
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        let mut turned = rotate(&mut a, &mut v, 0, 1);
        turned |= rotate(&mut a, &mut v, 0, 2);
        turned |= rotate(&mut a, &mut v, 1, 2);
        if !turned {
            break;
        }
    }
    for (p, q) in [(0, 1), (0, 2), (1, 2)] {
        if dot(a[q], a[q]) > dot(a[p], a[p]) {
            exchange(&mut a, &mut v, p, q);
        }
    }
    let s0 = norm(a[0]);
    let u0 = scale(a[0], 1.0 / s0.max(f64::MIN_POSITIVE));
    let rest = sub(a[1], scale(u0, dot(u0, a[1])));
    let length = norm(rest);
    let u1 = if length > 1e-150 {
        scale(rest, 1.0 / length)
    } else {
        across(u0)
    };
    let u2 = cross(u0, u1);
    Singular {
        s: [s0, dot(u1, a[1]), dot(u2, a[2])],
        u: [u0, u1, u2],
        v,
    }
}

/// Decomposes a matrix of a plane: its last row and column are the identity's.
#[inline(always)]
pub(super) fn decompose_plane(j: &Columns) -> Singular {
    let mut a = *j;
    let up = [0.0, 0.0, 1.0];
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], up];
    for _ in 0..2 {
        rotate(&mut a, &mut v, 0, 1);
    }
    if dot(a[1], a[1]) > dot(a[0], a[0]) {
        exchange(&mut a, &mut v, 0, 1);
    }
    let s0 = norm(a[0]);
    let u0 = if s0 > 1e-150 {
        scale(a[0], 1.0 / s0)
    } else {
        [1.0, 0.0, 0.0]
    };
    let u1 = cross(up, u0);
    Singular {
        s: [s0, dot(u1, a[1]), 1.0],
        u: [u0, u1, up],
        v,
    }
}

/// Makes two columns orthogonal; whether they were not.
#[inline(always)]
fn rotate(a: &mut Columns, v: &mut Columns, p: usize, q: usize) -> bool {
    let (alpha, beta, gamma) = (dot(a[p], a[p]), dot(a[q], a[q]), dot(a[p], a[q]));
    if gamma * gamma <= ORTHOGONAL * alpha * beta {
        return false;
    }
    let zeta = (beta - alpha) / (2.0 * gamma);
    let t = 1.0_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = c * t;
    turn(a, p, q, c, s);
    turn(v, p, q, c, s);
    true
}

#[inline(always)]
fn turn(a: &mut Columns, p: usize, q: usize, c: f64, s: f64) {
    let (x, y) = (a[p], a[q]);
    a[p] = sub(scale(x, c), scale(y, s));
    a[q] = add(scale(x, s), scale(y, c));
}

#[inline(always)]
fn exchange(a: &mut Columns, v: &mut Columns, p: usize, q: usize) {
    (a[p], a[q]) = (a[q], scale(a[p], -1.0));
    (v[p], v[q]) = (v[q], scale(v[p], -1.0));
}

/// A direction across another one.
fn across(u: Vector) -> Vector {
    let axis = if u[0].abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let rest = sub(axis, scale(u, dot(u, axis)));
    scale(rest, 1.0 / norm(rest).max(f64::MIN_POSITIVE))
}

/// A symmetric matrix with its negative eigenvalues made zero; by rows.
#[inline(always)]
pub(super) fn positive_part(a: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let d1 = a[0][0] * a[1][1] - a[0][1] * a[0][1];
    let d2 = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[1][2])
        - a[0][1] * (a[0][1] * a[2][2] - a[1][2] * a[0][2])
        + a[0][2] * (a[0][1] * a[1][2] - a[1][1] * a[0][2]);
    if a[0][0] > 0.0 && d1 > 0.0 && d2 > 0.0 {
        return *a;
    }
    let mut m = *a;
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            annihilate(&mut m, &mut v, p, q);
        }
    }
    let mut positive = [[0.0; 3]; 3];
    for k in 0..3 {
        let value = m[k][k].max(0.0);
        for i in 0..3 {
            for j in 0..3 {
                positive[i][j] += value * v[i][k] * v[j][k];
            }
        }
    }
    positive
}

/// A rotation of Jacobi's method for a symmetric matrix; `v` collects the eigenvectors as columns.
#[inline(always)]
fn annihilate(m: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if m[p][q] == 0.0 {
        return;
    }
    let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
    let t = 1.0_f64.copysign(theta) / (theta.abs() + (1.0 + theta * theta).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = c * t;
    for k in 0..3 {
        let (x, y) = (m[k][p], m[k][q]);
        (m[k][p], m[k][q]) = (c * x - s * y, s * x + c * y);
    }
    for k in 0..3 {
        let (x, y) = (m[p][k], m[q][k]);
        (m[p][k], m[q][k]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (v[k][p], v[k][q]);
        (v[k][p], v[k][q]) = (c * x - s * y, s * x + c * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn product(found: &Singular) -> Columns {
        std::array::from_fn(|column| {
            let terms = (0..3).map(|k| scale(found.u[k], found.s[k] * found.v[k][column]));
            terms.fold([0.0; 3], add)
        })
    }

    proptest! {
        #[test]
        fn a_decomposition_gives_the_matrix_back(entries in prop::array::uniform9(-2.0f64..2.0), thin in -8i32..1) {
            let thin = 10f64.powi(thin);
            let j = [0, 3, 6].map(|k| [entries[k], entries[k + 1], thin * entries[k + 2]]);
            let found = decompose(&j);
            let back = product(&found);
            for (a, b) in j.as_flattened().iter().zip(back.as_flattened()) {
                prop_assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
            let determinant = dot(j[0], cross(j[1], j[2]));
            let values = found.s.iter().product::<f64>();
            prop_assert!((values - determinant).abs() < 1e-6 * found.s[0].powi(3).max(1e-3));
            prop_assert!(dot(found.u[0], cross(found.u[1], found.u[2])) > 0.99);
            prop_assert!(dot(found.v[0], cross(found.v[1], found.v[2])) > 0.99);
        }

        #[test]
        fn a_matrix_of_a_plane_comes_back(entries in prop::array::uniform4(-2.0f64..2.0)) {
            let [a, b, c, d] = entries;
            let j = [[a, b, 0.0], [c, d, 0.0], [0.0, 0.0, 1.0]];
            let found = decompose_plane(&j);
            for (a, b) in j.as_flattened().iter().zip(product(&found).as_flattened()) {
                prop_assert!((a - b).abs() < 1e-9, "{a} {b}");
            }
            prop_assert!((found.s[0] * found.s[1] - (a * d - b * c)).abs() < 1e-9);
        }

        #[test]
        fn the_positive_part_has_no_negative_direction(e in prop::array::uniform6(-2.0f64..2.0), x in prop::array::uniform3(-1.0f64..1.0)) {
            let a = [[e[0], e[1], e[2]], [e[1], e[3], e[4]], [e[2], e[4], e[5]]];
            let part = positive_part(&a);
            let form = |m: &[[f64; 3]; 3]| -> f64 { (0..3).map(|i| x[i] * dot(m[i], x)).sum() };
            prop_assert!(form(&part) > -1e-12);
            prop_assert!(form(&part) >= form(&a) - 1e-12);
        }
    }
}
