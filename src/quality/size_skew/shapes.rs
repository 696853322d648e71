//! Knupp's corner measures for each kind of cell.
//!
//! At corner `k` of a cell the edges to its neighbours are the columns of the Jacobian matrix `A_k`;
//! `alpha_k = det A_k` and `lambda_ij` are the entries of `A_k^T A_k`.
//!
//! Source: P. M. Knupp, Algebraic mesh quality metrics for unstructured initial meshes, Finite Elements
//! in Analysis and Design 39, 2003. Pyramids and wedges, which it does not have, follow from the same
//! matrices.

use super::super::span::{greater, lesser};
use crate::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};

/// Sums and extremes over the corners of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corners {
    /// Sum of all `alpha_k`.
    pub sum: f64,
    /// Smallest and largest `alpha_k`.
    pub low: f64,
    pub high: f64,
    /// `f_skew` where all `alpha_k` have one sign.
    pub skew: f64,
}

/// A kind of cell with `N` corners. `facing` is the positive side of a plane cell.
pub(super) trait Shape<const N: usize> {
    /// Free of branches, or the loop over cells stays scalar.
    fn corners(p: &[Vector; N], facing: Vector) -> Corners;
}

pub(super) struct Triangle;
pub(super) struct Quadrilateral;
pub(super) struct Tetrahedron;
pub(super) struct Pyramid;
pub(super) struct Wedge;
pub(super) struct Hexahedron;

/// Simplices have one measure at all corners: `sqrt(3) alpha / (lambda_11 + lambda_22 - lambda_12)`.
impl Shape<3> for Triangle {
    #[inline(always)]
    fn corners(p: &[Vector; 3], facing: Vector) -> Corners {
        let [u, v] = [sub(p[1], p[0]), sub(p[2], p[0])];
        let normal = cross(u, v);
        let alpha = norm(normal).copysign(dot(normal, facing));
        let lengths = dot(u, u) + dot(v, v) - dot(u, v);
        single(alpha, 3f64.sqrt() * alpha.abs() / lengths)
    }
}

/// `3 (sqrt(2) alpha)^(2/3) / (3/2 (lambda_11 + lambda_22 + lambda_33) - lambda_12 - lambda_23 - lambda_31)`.
impl Shape<4> for Tetrahedron {
    #[inline(always)]
    fn corners(p: &[Vector; 4], _facing: Vector) -> Corners {
        let [u, v, w] = [sub(p[1], p[0]), sub(p[2], p[0]), sub(p[3], p[0])];
        let alpha = dot(u, cross(v, w));
        let squares = dot(u, u) + dot(v, v) + dot(w, w);
        let products = dot(u, v) + dot(v, w) + dot(w, u);
        let skew = 3.0 * cube_root(2.0 * alpha * alpha) / (1.5 * squares - products);
        single(alpha, skew)
    }
}

#[inline(always)]
fn single(alpha: f64, skew: f64) -> Corners {
    Corners {
        sum: alpha,
        low: alpha,
        high: alpha,
        skew,
    }
}

/// Corners one after another; `f_skew` is their number over the sum of what each adds.
struct Sum {
    all: Corners,
    n: f64,
}

impl Sum {
    #[inline(always)]
    fn new() -> Self {
        let all = Corners {
            sum: 0.0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            skew: 0.0,
        };
        Self { all, n: 0.0 }
    }

    #[inline(always)]
    fn add(&mut self, alpha: f64, badness: f64) {
        self.all.sum += alpha;
        self.all.low = lesser(alpha, self.all.low);
        self.all.high = greater(alpha, self.all.high);
        self.all.skew += badness;
        self.n += 1.0;
    }

    #[inline(always)]
    fn done(self) -> Corners {
        Corners {
            skew: self.n / self.all.skew,
            ..self.all
        }
    }
}

/// `4 / sum sqrt(lambda_11 lambda_22) / alpha_k`.
impl Shape<4> for Quadrilateral {
    #[inline(always)]
    fn corners(p: &[Vector; 4], facing: Vector) -> Corners {
        let across = cross(sub(p[2], p[0]), sub(p[3], p[1]));
        // Unit normal of the cell, toward the positive side.
        let size = (1.0 / norm(across)).copysign(dot(across, facing));
        let normal = scale(across, size);
        let mut sum = Sum::new();
        for k in 0..4 {
            let [u, v] = [sub(p[(k + 1) % 4], p[k]), sub(p[(k + 3) % 4], p[k])];
            let alpha = dot(cross(u, v), normal);
            sum.add(alpha, (dot(u, u) * dot(v, v)).sqrt() / alpha.abs());
        }
        sum.done()
    }
}

/// Where the base meets the sides: `4 / sum |S_k|^2 / (3 det(S_k)^(2/3))`, `S_k = A_k W^-1`, `W` that
/// of the pyramid whose edges are all equal.
///
/// ```text
/// det S = sqrt(2) alpha,   |S|^2 = |e_1|^2 + |e_2|^2 + |2 e_3 - e_1 - e_2|^2 / 2
/// ```
impl Shape<5> for Pyramid {
    #[inline(always)]
    fn corners(p: &[Vector; 5], _facing: Vector) -> Corners {
        let mut sum = Sum::new();
        for k in 0..4 {
            let [u, v] = [sub(p[(k + 1) % 4], p[k]), sub(p[(k + 3) % 4], p[k])];
            let w = sub(p[4], p[k]);
            let alpha = dot(u, cross(v, w));
            let leaning = sub(scale(w, 2.0), add(u, v));
            let squares = dot(u, u) + dot(v, v) + 0.5 * dot(leaning, leaning);
            sum.add(alpha, squares / (3.0 * cube_root(2.0 * alpha * alpha)));
        }
        sum.done()
    }
}

/// As a hexahedron, beside a right prism on an equilateral triangle:
/// `6 / sum (3/4 lambda_11 lambda_22 lambda_33 / alpha_k^2)^(1/3)`.
impl Shape<6> for Wedge {
    #[inline(always)]
    fn corners(p: &[Vector; 6], _facing: Vector) -> Corners {
        let mut sum = Sum::new();
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let up = sub(p[k + 3], p[k]);
            sum.add_solid([sub(p[a], p[k]), sub(p[b], p[k]), up], 0.75);
            let above = [sub(p[a + 3], p[k + 3]), sub(p[b + 3], p[k + 3]), up];
            sum.add_solid(above, 0.75);
        }
        sum.done()
    }
}

/// `8 / sum (lambda_11 lambda_22 lambda_33 / alpha_k^2)^(1/3)`.
impl Shape<8> for Hexahedron {
    #[inline(always)]
    fn corners(p: &[Vector; 8], _facing: Vector) -> Corners {
        let mut sum = Sum::new();
        for k in 0..4 {
            let (a, b) = ((k + 1) % 4, (k + 3) % 4);
            let up = sub(p[k + 4], p[k]);
            sum.add_solid([sub(p[a], p[k]), sub(p[b], p[k]), up], 1.0);
            let above = [sub(p[a + 4], p[k + 4]), sub(p[b + 4], p[k + 4]), up];
            sum.add_solid(above, 1.0);
        }
        sum.done()
    }
}

impl Sum {
    #[inline(always)]
    fn add_solid(&mut self, [u, v, w]: [Vector; 3], ideal: f64) {
        let alpha = dot(u, cross(v, w));
        let lengths = dot(u, u) * dot(v, v) * dot(w, w);
        self.add(alpha, cube_root(ideal * lengths / (alpha * alpha)));
    }
}

/// Cube root of a number that is not negative, to a few units in the last place and without branches;
/// of no meaning below 1e-290 and for what is not finite.
///
/// The exponent is divided by three, then three of Halley's steps, each of which triples the digits.
#[inline(always)]
fn cube_root(x: f64) -> f64 {
    let high = (x.to_bits() >> 32) as u32;
    let mut t = f64::from_bits(u64::from(high / 3 + 715_094_163) << 32);
    for _ in 0..3 {
        let cube = t * t * t;
        t *= (cube + 2.0 * x) / (2.0 * cube + x);
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_right_to_the_last_places() {
        for i in -280..280 {
            for factor in [1.0, 1.7, 3.3, 9.99] {
                let x = factor * 10f64.powi(i);
                let root = cube_root(x);
                assert!((root / x.cbrt() - 1.0).abs() < 1e-15, "{x}");
            }
        }
    }
}
