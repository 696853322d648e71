//! The interpolant: weighted base points, and an optional linear polynomial.
//!
//! ```text
//! s(x) = sum_j phi(|x - b_j| / R) w_j + P(x) beta,   P(x) = (1, x, y, z)
//! ```

use super::Basis;
use super::evaluate::WeightedBase;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, scale, sub};
use azimesh_core::parallel;
use azimesh_core::ranks::raw;
use serde::{Deserialize, Serialize};

/// Terms of a linear polynomial.
pub const LINEAR: usize = 4;

/// Base points and their weights, `r` columns: a function that can be evaluated anywhere.
///
/// [`through`](Self::through) makes one from points and values. Beyond the support radius of all base points
/// it is zero, or its polynomial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interpolant {
    /// Kernel and support radius.
    pub basis: Basis,
    /// Base points (n), then their periodic images, if any.
    #[serde(with = "raw")]
    pub points: Vec<Vector>,
    /// Weights (n, r), by rows.
    #[serde(with = "raw")]
    pub weights: Vec<f64>,
    /// Number of columns, r.
    pub n_columns: usize,
    /// The polynomial that is added to the kernels.
    pub polynomial: Option<Polynomial>,
}

/// A linear polynomial of each column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Polynomial {
    /// Centre and scale of its terms.
    pub frame: PolynomialFrame,
    /// `beta (4, r)`, by rows.
    pub coefficients: Vec<f64>,
}

/// Centre and scale that make the terms of a polynomial of order one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PolynomialFrame {
    centre: Vector,
    size: f64,
}

impl PolynomialFrame {
    /// The frame of a set of points.
    pub fn around(points: &[Vector]) -> Self {
        let bounds = Bounds::around(points);
        let size = 0.5 * bounds.diagonal();
        Self {
            centre: std::array::from_fn(|i| 0.5 * (bounds.low[i] + bounds.high[i])),
            size: if size > 0.0 { size } else { 1.0 },
        }
    }

    /// `P(x)` in this frame.
    #[inline]
    pub fn terms(&self, x: &Vector) -> [f64; LINEAR] {
        let [x, y, z] = scale(sub(*x, self.centre), 1.0 / self.size);
        [1.0, x, y, z]
    }
}

impl Interpolant {
    /// Evaluates the interpolant at `points (N)`: values (N, r), by rows. `N n` kernel evaluations.
    pub fn at(&self, points: &[Vector]) -> Vec<f64> {
        let mut values = vec![0.0; points.len() * self.n_columns];
        self.add_at(points, &mut values);
        values
    }

    /// Adds the interpolant at `points (N)` to `out (N, r)`, by rows. `N n` kernel evaluations.
    pub fn add_at(&self, points: &[Vector], out: &mut [f64]) {
        WeightedBase {
            basis: self.basis,
            points: &self.points,
            weights: &self.weights,
            n_columns: self.n_columns,
        }
        .add_at(points, out);
        if let Some(polynomial) = &self.polynomial {
            polynomial.add_at(points, out, self.n_columns);
        }
    }

    /// Changes the sign of every weight, for residuals.
    pub fn negated(&self) -> Self {
        let negated = |values: &[f64]| values.iter().map(|v| -v).collect();
        Self {
            basis: self.basis,
            points: self.points.clone(),
            weights: negated(&self.weights),
            n_columns: self.n_columns,
            polynomial: self.polynomial.as_ref().map(|polynomial| Polynomial {
                frame: polynomial.frame,
                coefficients: negated(&polynomial.coefficients),
            }),
        }
    }
}

impl Polynomial {
    fn add_at(&self, points: &[Vector], out: &mut [f64], r: usize) {
        if r == 0 {
            return;
        }
        parallel::for_blocks(out, parallel::BLOCK * r, &|first, rows| {
            for (row, point) in rows.chunks_exact_mut(r).zip(&points[first / r..]) {
                let terms = self.frame.terms(point);
                for (term, beta) in terms.iter().zip(self.coefficients.chunks_exact(r)) {
                    for (value, b) in row.iter_mut().zip(beta) {
                        *value += term * b;
                    }
                }
            }
        });
    }
}
