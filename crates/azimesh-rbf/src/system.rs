//! The interpolation system: weights that reproduce values at the base points.

use super::Basis;
use super::interpolant::{Interpolant, LINEAR, Polynomial, PolynomialFrame};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::linear::{Cholesky, Matrix, svd};
use azimesh_core::parallel;

/// Singular values of the polynomial's system below this part of the largest are left out: base
/// points in one plane, or fewer than four of them.
const RANK: f64 = 1e-10;

/// Solves for the interpolant that reproduces `values (n, r)`, by rows, at the base points:
///
/// ```text
/// Phi (n, n) . weights (n, r) = values (n, r),   Phi(i, j) = phi(|b_i - b_j| / R)
/// ```
///
/// By Cholesky, as `Phi` is symmetric positive definite. `n^3 / 3 + 2 n^2 r` multiply-adds, `n^2`
/// numbers of memory. With `linear`, a polynomial is added (eq. 4 of the paper) and solved through
/// the Schur complement of the same factor, with `P (n, 4)` the terms at the base points:
///
/// ```text
/// (P^T Phi^-1 P) beta = P^T Phi^-1 values,   Phi weights = values - P beta,   P^T weights = 0
/// ```
///
/// If the base points do not determine all four terms, the smallest `beta` is taken.
///
/// # Errors
/// If `Phi` is not positive definite to working precision: base points that nearly coincide
/// against the support radius.
pub fn interpolant(
    basis: Basis,
    base: &[Vector],
    values: &[f64],
    linear: bool,
) -> Result<Interpolant> {
    let n = base.len();
    let mut interpolant = Interpolant {
        basis,
        points: base.to_vec(),
        weights: Vec::new(),
        n_columns: values.len().checked_div(n).unwrap_or(0),
        polynomial: None,
    };
    if n == 0 {
        return Ok(interpolant);
    }
    let r = interpolant.n_columns;
    let factor =
        Cholesky::factor(kernel_matrix(basis, base)).map_err(|at| too_close(basis, at.0, n))?;
    let mut solution = Matrix::from_fn(n, r, |i, j| values[i * r + j]);
    factor.solve(&mut solution);
    if linear {
        let (polynomial, weights) = with_polynomial(base, &factor, &solution)?;
        interpolant.polynomial = Some(polynomial);
        solution = weights;
    }
    interpolant.weights = by_rows(&solution);
    Ok(interpolant)
}

impl Interpolant {
    /// Solves for the weights that reproduce `values (n, n_columns)`, by rows, at `points (n)`:
    ///
    /// ```text
    /// Phi (n, n) . weights (n, n_columns) = values (n, n_columns),   Phi(i, j) = phi(|x_i - x_j| / R)
    /// ```
    ///
    /// By Cholesky: `n^3 / 3` multiply-adds, `n^2` numbers of memory. For more than about 10,000 points
    /// see [`Selection::to_tolerance`](crate::Selection::to_tolerance); [`interpolant`] adds a linear
    /// polynomial.
    ///
    /// ```
    /// use azimesh_rbf::{Basis, Interpolant, Kernel};
    ///
    /// let basis = Basis { kernel: Kernel::WendlandC0, radius: 2.0 };
    /// let line = Interpolant::through(basis, &[[0.0; 3], [1.0, 0.0, 0.0]], &[15.0, 0.0], 1)?;
    /// assert!((line.weights[0] - 16.0).abs() < 1e-12); // w_0 + w_1 / 4 = 15
    /// assert!((line.weights[1] + 4.0).abs() < 1e-12); // w_0 / 4 + w_1 = 0
    /// # Ok::<(), azimesh_rbf::Error>(())
    /// ```
    ///
    /// # Errors
    /// Of kind `Input` if the counts do not agree, or if a number is not finite or the radius not
    /// positive; of kind `Check` if two points nearly coincide against the support radius.
    pub fn through(
        basis: Basis,
        points: &[Vector],
        values: &[f64],
        n_columns: usize,
    ) -> Result<Self> {
        check_data(basis, points, values, n_columns)?;
        let through = interpolant(basis, points, values, false)?;
        Ok(Self {
            n_columns,
            ..through
        })
    }
}

/// Checks that there are `n_columns` finite values for each of the points, and a support radius.
pub(super) fn check_data(
    basis: Basis,
    points: &[Vector],
    values: &[f64],
    n_columns: usize,
) -> Result<()> {
    let radius = basis.radius;
    if !(radius.is_finite() && radius > 0.0) {
        return Err(Error::input(format!(
            "the support radius is {radius}; it should be positive"
        )));
    }
    let (n, found) = (points.len(), values.len());
    if n.checked_mul(n_columns) != Some(found) {
        return Err(Error::input(format!(
            "there are {found} values for {n} points; {n_columns} columns need as many for each point"
        )));
    }
    let not_finite = |values: &[f64]| values.iter().any(|value| !value.is_finite());
    if let Some(at) = points.iter().position(|point| not_finite(point)) {
        return Err(Error::input(format!(
            "a coordinate of point {at} is not finite"
        )));
    }
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        let point = at / n_columns;
        return Err(Error::input(format!(
            "a value at point {point} is not finite"
        )));
    }
    Ok(())
}

/// The error of a kernel matrix that is not positive definite at base point `at` of `n`.
pub(super) fn too_close(basis: Basis, at: usize, n: usize) -> Error {
    Error::check(format!(
        "the base point {at} of {n} is too close to another for a support radius of {} ({}); a \
         smaller support radius, a kernel of lower order or selection by tolerance would help",
        basis.radius,
        basis.kernel.name()
    ))
}

/// `beta`, and the weights, from `Phi^-1 values`.
fn with_polynomial(
    base: &[Vector],
    factor: &Cholesky,
    solved: &Matrix,
) -> Result<(Polynomial, Matrix)> {
    let (n, r) = (base.len(), solved.n_cols());
    let frame = PolynomialFrame::around(base);
    let terms: Vec<[f64; LINEAR]> = base.iter().map(|b| frame.terms(b)).collect();
    let mut inverse = Matrix::from_fn(n, LINEAR, |i, j| terms[i][j]);
    factor.solve(&mut inverse);
    let transposed = Matrix::from_fn(LINEAR, n, |i, j| terms[j][i]);
    let beta = least(&transposed.times(&inverse), &transposed.times(solved))?;
    let weights = Matrix::from_fn(n, r, |i, j| {
        let polynomial: f64 = (0..LINEAR).map(|t| inverse[(i, t)] * beta[(t, j)]).sum();
        solved[(i, j)] - polynomial
    });
    let polynomial = Polynomial {
        frame,
        coefficients: by_rows(&beta),
    };
    Ok((polynomial, weights))
}

/// The smallest solution of a symmetric system that may be singular.
fn least(matrix: &Matrix, right: &Matrix) -> Result<Matrix> {
    let (u, s, v) = svd(matrix)?;
    let floor = RANK * s.first().copied().unwrap_or(0.0);
    let n = matrix.n_rows();
    Ok(Matrix::from_fn(n, right.n_cols(), |i, j| {
        (0..s.len())
            .filter(|&m| s[m] > floor)
            .map(|m| {
                let along: f64 = (0..n).map(|k| u[(k, m)] * right[(k, j)]).sum();
                v[(i, m)] * along / s[m]
            })
            .sum()
    }))
}

fn by_rows(matrix: &Matrix) -> Vec<f64> {
    let r = matrix.n_cols();
    (0..matrix.n_rows() * r)
        .map(|at| matrix[(at / r, at % r)])
        .collect()
}

/// `Phi (n, n)`.
fn kernel_matrix(basis: Basis, base: &[Vector]) -> Matrix {
    let n = base.len();
    let mut phi = Matrix::zeros(n, n);
    parallel::for_items(
        phi.values_mut().chunks_mut(n).zip(base),
        &|_, (column, b)| {
            for (value, a) in column.iter_mut().zip(base) {
                *value = basis.between(a, b);
            }
        },
    );
    phi
}

#[cfg(test)]
mod tests {
    use super::super::kernel::Kernel;
    use super::*;

    fn cloud(n: usize) -> Vec<Vector> {
        (0..n)
            .map(|i| std::array::from_fn(|k| (i as f64 * [78.233, 12.9898, 37.719][k]).sin()))
            .collect()
    }

    const BASIS: Basis = Basis {
        kernel: Kernel::WendlandC2,
        radius: 1.5,
    };

    #[test]
    fn weights_reproduce_base_point_displacements() {
        let base = cloud(200);
        let values: Vec<f64> = (0..600).map(|i| (i as f64 * 0.37).cos()).collect();
        for linear in [false, true] {
            let interpolant = interpolant(BASIS, &base, &values, linear).expect("definite");
            let mut back = vec![0.0; 600];
            interpolant.add_at(&base, &mut back);
            for (a, b) in back.iter().zip(&values) {
                assert!((a - b).abs() < 1e-9, "{a} {b}");
            }
        }
    }

    #[test]
    fn a_linear_polynomial_reproduces_linear_data_everywhere() {
        let plane = |x: &Vector| 0.3 + 2.0 * x[0] - 0.7 * x[1] + 0.1 * x[2];
        let flat: Vec<Vector> = cloud(60).into_iter().map(|x| [x[0], x[1], 2.0]).collect();
        for (base, off) in [(cloud(60), 0.5), (flat, 0.0)] {
            let values: Vec<f64> = base.iter().map(plane).collect();
            let interpolant = interpolant(BASIS, &base, &values, true).expect("definite");
            let far: Vec<Vector> = base
                .iter()
                .map(|x| [3.0 * x[0], x[1] - 5.0, x[2] + off])
                .collect();
            let mut found = vec![0.0; far.len()];
            interpolant.add_at(&far, &mut found);
            for (value, x) in found.iter().zip(&far) {
                let off = (value - plane(x)).abs();
                assert!(off < 1e-9, "{value} is off by {off:e}");
            }
        }
    }

    #[test]
    fn weights_solve_a_system_of_two_points_as_by_hand() {
        // phi(1/2) = 1/4, so Phi = (1, 1/4; 1/4, 1) and Phi^-1 = 16/15 (1, -1/4; -1/4, 1).
        let basis = Basis {
            kernel: Kernel::WendlandC0,
            radius: 2.0,
        };
        let points = [[0.0; 3], [0.0, 1.0, 0.0]];
        let values = [1.0, 0.0, 0.0, 15.0]; // two columns
        let found = Interpolant::through(basis, &points, &values, 2).expect("definite");
        let by_hand = [16.0 / 15.0, -4.0, -4.0 / 15.0, 16.0];
        for (weight, by_hand) in found.weights.iter().zip(by_hand) {
            assert!((weight - by_hand).abs() < 1e-14, "{weight} {by_hand}");
        }
        // phi(1/4) = 9/16 at the middle, phi(1) = 0 at a distance of 2 from the second point.
        let at = found.at(&[[0.0, 0.5, 0.0], [0.0, -1.0, 0.0], [9.0; 3]]);
        let by_hand = [0.45, 6.75, 4.0 / 15.0, -1.0, 0.0, 0.0];
        for (value, by_hand) in at.iter().zip(by_hand) {
            assert!((value - by_hand).abs() < 1e-14, "{value} {by_hand}");
        }
    }

    #[test]
    fn data_that_do_not_fit_together_are_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0]];
        let refused = |basis: Basis, points: &[Vector], values: &[f64], n_columns: usize| {
            let found = Interpolant::through(basis, points, values, n_columns);
            found.expect_err("it is refused").message
        };
        assert!(refused(BASIS, &points, &[1.0; 3], 1).contains("3 values for 2 points"));
        assert!(refused(BASIS, &points, &[1.0; 3], usize::MAX).contains("3 values"));
        assert!(refused(BASIS, &points, &[1.0, f64::NAN], 1).contains("value at point 1"));
        let far = [[0.0; 3], [f64::INFINITY, 0.0, 0.0]];
        assert!(refused(BASIS, &far, &[1.0; 2], 1).contains("point 1"));
        for radius in [0.0, -1.0, f64::NAN] {
            let basis = Basis { radius, ..BASIS };
            assert!(refused(basis, &points, &[1.0; 2], 1).contains("support radius"));
        }
        let none = Interpolant::through(BASIS, &[], &[], 2).expect("zero everywhere");
        assert_eq!(none.at(&points), [0.0; 4]);
    }

    #[test]
    fn coincident_base_points_are_an_error_that_names_the_remedy() {
        let basis = Basis {
            radius: 1.0,
            ..BASIS
        };
        let error =
            interpolant(basis, &[[0.0; 3], [0.0; 3]], &[1.0, 1.0], false).expect_err("singular");
        assert!(error.message.contains("smaller support radius"));
    }
}
