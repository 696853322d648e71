//! Dense matrices, factors and products: the only home of faer. `blocks` has sparse matrices of 3x3 blocks.
//!
//! Every routine gives the same bytes on any number of threads: work is cut into tiles of fixed
//! size, and each tile is computed by one thread.

pub mod blocks;
mod cholesky;
mod growing;
mod tall;

pub use cholesky::{Cholesky, NotPositive};
pub use growing::GrowingCholesky;
pub use tall::{add_transposed_product, multiply, orthonormalize, subtract_product};

use crate::error::{Error, Result};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// A dense matrix, stored by columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    n_rows: usize,
    n_cols: usize,
    values: Vec<f64>,
}

impl Matrix {
    /// All zeros.
    pub fn zeros(n_rows: usize, n_cols: usize) -> Self {
        Self {
            n_rows,
            n_cols,
            values: vec![0.0; n_rows * n_cols],
        }
    }

    /// Entry by entry.
    pub fn from_fn(n_rows: usize, n_cols: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let values = (0..n_rows * n_cols)
            .map(|at| value(at % n_rows, at / n_rows))
            .collect();
        Self {
            n_rows,
            n_cols,
            values,
        }
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Number of columns.
    pub fn n_cols(&self) -> usize {
        self.n_cols
    }

    /// One column.
    pub fn column(&self, j: usize) -> &[f64] {
        &self.values[j * self.n_rows..(j + 1) * self.n_rows]
    }

    /// One column, to be written.
    pub fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.values[j * self.n_rows..(j + 1) * self.n_rows]
    }

    /// The entries by columns, to be written.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The product `self other`, on one thread.
    pub fn times(&self, other: &Matrix) -> Matrix {
        let mut product = Matrix::zeros(self.n_rows, other.n_cols);
        matmul(
            product.as_faer_mut(),
            Accum::Replace,
            self.as_faer(),
            other.as_faer(),
            1.0,
            Par::Seq,
        );
        product
    }

    fn as_faer(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.values, self.n_rows, self.n_cols)
    }

    fn as_faer_mut(&mut self) -> MatMut<'_, f64> {
        MatMut::from_column_major_slice_mut(&mut self.values, self.n_rows, self.n_cols)
    }
}

impl std::ops::Index<(usize, usize)> for Matrix {
    type Output = f64;
    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.values[j * self.n_rows + i]
    }
}

impl std::ops::IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.values[j * self.n_rows + i]
    }
}

/// `out (m, r) += tile (m, n) . weights (n, r)`, all by columns except `weights` and `out`, whose
/// rows are contiguous; on one thread.
pub fn add_product(out: &mut [f64], tile: &[f64], weights: &[f64], n: usize, r: usize) {
    let m = tile.len() / n;
    matmul(
        MatMut::from_row_major_slice_mut(out, m, r),
        Accum::Add,
        MatRef::from_column_major_slice(tile, m, n),
        MatRef::from_row_major_slice(weights, n, r),
        1.0,
        Par::Seq,
    );
}

/// Singular value decomposition `a (m, n) = U (m, q) diag(s) V^T (q, n)`, `q = min(m, n)`, singular
/// values descending. Returns `(U, s, V)`.
pub fn svd(a: &Matrix) -> Result<(Matrix, Vec<f64>, Matrix)> {
    let failed = |_| Error::system("the singular value decomposition did not converge");
    let svd = a.as_faer().thin_svd().map_err(failed)?;
    let q = a.n_rows.min(a.n_cols);
    Ok((
        Matrix::from_fn(a.n_rows, q, |i, j| svd.U()[(i, j)]),
        svd.S().column_vector().iter().copied().collect(),
        Matrix::from_fn(a.n_cols, q, |i, j| svd.V()[(i, j)]),
    ))
}

/// The upper triangular factor `R (n, n)` of `a (m, n) = Q R`.
pub fn qr_factor(a: &Matrix) -> Matrix {
    let qr = a.as_faer().qr();
    let r = qr.thin_R();
    Matrix::from_fn(
        r.nrows(),
        r.ncols(),
        |i, j| if i <= j { r[(i, j)] } else { 0.0 },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn svd_gives_the_matrix_back() {
        let a = Matrix::from_fn(3, 7, |i, j| ((i * 7 + j) as f64).sin());
        let (u, s, v) = svd(&a).expect("it converges");
        for i in 0..3 {
            for j in 0..7 {
                let sum: f64 = (0..3).map(|q| u[(i, q)] * s[q] * v[(j, q)]).sum();
                assert!((sum - a[(i, j)]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn add_product_adds_rows_times_weights() {
        let tile = [1.0, 2.0, 3.0, 4.0]; // columns (1, 2), (3, 4)
        let mut out = [10.0, 0.0];
        add_product(&mut out, &tile, &[1.0, -1.0], 2, 1);
        assert_eq!(out, [8.0, -2.0]);
    }
}
