//! The interpolation system: weights that reproduce values at the base points.

use super::Basis;
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::linear::{Cholesky, Matrix};
use rayon::prelude::*;

/// Weights (n, r), by rows, that reproduce `values (n, r)`, by rows, at the base points:
///
/// ```text
/// Phi (n, n) . weights (n, r) = values (n, r),   Phi(i, j) = phi(|b_i - b_j| / R)
/// ```
///
/// By Cholesky, as `Phi` is symmetric positive definite. `n^3 / 3 + 2 n^2 r` multiply-adds, `n^2`
/// numbers of memory.
///
/// # Errors
/// Where `Phi` is not positive definite to working precision: base points that nearly coincide
/// against the support radius.
pub fn weights(basis: Basis, base: &[Vector], values: &[f64]) -> Result<Vec<f64>> {
    let n = base.len();
    if n == 0 {
        return Ok(Vec::new());
    }
    let r = values.len() / n;
    let factor = Cholesky::factor(kernel_matrix(basis, base)).map_err(|at| {
        Error::check(format!(
            "the base point {} of {n} is too close to another for a support radius of {} ({}); a \
             smaller support radius, a kernel of lower order or selection by tolerance would help",
            at.0,
            basis.radius,
            basis.kernel.name()
        ))
    })?;
    let mut solution = Matrix::from_fn(n, r, |i, j| values[i * r + j]);
    factor.solve(&mut solution);
    Ok((0..n * r).map(|at| solution[(at / r, at % r)]).collect())
}

/// `Phi (n, n)`.
fn kernel_matrix(basis: Basis, base: &[Vector]) -> Matrix {
    let n = base.len();
    let mut phi = Matrix::zeros(n, n);
    phi.values_mut()
        .par_chunks_mut(n)
        .zip(base.par_iter())
        .for_each(|(column, b)| {
            for (value, a) in column.iter_mut().zip(base) {
                *value = basis.between(a, b);
            }
        });
    phi
}

#[cfg(test)]
mod tests {
    use super::super::evaluate::WeightedBase;
    use super::super::kernel::Kernel;
    use super::*;

    #[test]
    fn weights_reproduce_base_point_displacements() {
        let base: Vec<Vector> = (0..200)
            .map(|i| std::array::from_fn(|k| ((i * 3 + k) as f64 * 78.233).sin()))
            .collect();
        let values: Vec<f64> = (0..600).map(|i| (i as f64 * 0.37).cos()).collect();
        let basis = Basis {
            kernel: Kernel::WendlandC2,
            radius: 1.5,
        };
        let weights = weights(basis, &base, &values).expect("positive definite");
        let mut back = vec![0.0; 600];
        let weighted = WeightedBase {
            basis,
            points: &base,
            weights: &weights,
            n_columns: 3,
        };
        weighted.add_at(&base, &mut back);
        for (a, b) in back.iter().zip(&values) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn coincident_base_points_are_an_error_that_names_the_remedy() {
        let basis = Basis {
            kernel: Kernel::WendlandC2,
            radius: 1.0,
        };
        let error = weights(basis, &[[0.0; 3], [0.0; 3]], &[1.0, 1.0]).expect_err("singular");
        assert!(error.message.contains("smaller support radius"));
    }
}
