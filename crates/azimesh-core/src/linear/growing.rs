//! A Cholesky factor that grows by one row at a time.

use super::Matrix;
use crate::parallel;
use faer::Par;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{MatMut, MatRef};

/// Columns of right-hand sides that one thread solves for at a time.
const TILE: usize = 64;

/// Lower triangular `L (n, n)`, stored by rows, each row padded to the capacity.
#[derive(Debug, Clone, Default)]
pub struct GrowingCholesky {
    n: usize,
    capacity: usize,
    values: Vec<f64>,
}

impl GrowingCholesky {
    /// Number of rows.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Appends a row: `off_diagonal (n)` and the diagonal entry.
    pub fn push(&mut self, off_diagonal: &[f64], diagonal: f64) {
        assert_eq!(off_diagonal.len(), self.n);
        if self.n == self.capacity {
            self.grow();
        }
        let row = self.n * self.capacity;
        self.values[row..row + self.n].copy_from_slice(off_diagonal);
        self.values[row + self.n] = diagonal;
        self.n += 1;
    }

    fn grow(&mut self) {
        let capacity = self.capacity * 5 / 4 + 64;
        let mut values = vec![0.0; capacity * capacity];
        for i in 0..self.n {
            let old = &self.values[i * self.capacity..][..self.n];
            values[i * capacity..][..self.n].copy_from_slice(old);
        }
        self.capacity = capacity;
        self.values = values;
    }

    fn lower(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice_with_stride(&self.values, self.n, self.n, self.capacity)
    }

    /// Overwrites the columns of `rhs (n, m)` with the solutions of `L x = rhs`, on all threads.
    /// `n^2 m / 2` multiply-adds.
    pub fn solve_lower(&self, rhs: &mut Matrix) {
        let n = self.n;
        if n == 0 {
            return;
        }
        parallel::for_blocks(rhs.values_mut(), n * TILE, &|_, columns| {
            let n_columns = columns.len() / n;
            let columns = MatMut::from_column_major_slice_mut(columns, n, n_columns);
            solve_lower_triangular_in_place(self.lower(), columns, Par::Seq);
        });
    }

    /// Overwrites `rhs (n, r)` with the solution of `L^T x = rhs`, on one thread.
    pub fn solve_transposed(&self, rhs: &mut Matrix) {
        if self.n > 0 {
            solve_upper_triangular_in_place(self.lower().transpose(), rhs.as_faer_mut(), Par::Seq);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_solves_undo_the_product() {
        let entry = |i: usize, j: usize| {
            if i == j {
                2.0 + i as f64
            } else {
                1.0 / (1 + i + j) as f64
            }
        };
        let n = 150;
        let mut factor = GrowingCholesky::default();
        for i in 0..n {
            let row: Vec<f64> = (0..i).map(|j| entry(i, j)).collect();
            factor.push(&row, entry(i, i));
        }
        let lower = Matrix::from_fn(n, n, |i, j| if j <= i { entry(i, j) } else { 0.0 });
        let upper = Matrix::from_fn(n, n, |i, j| lower[(j, i)]);
        let x = Matrix::from_fn(n, 2, |i, j| (i as f64 + 0.3 * j as f64).sin());
        let (mut forward, mut back) = (lower.times(&x), upper.times(&x));
        factor.solve_lower(&mut forward);
        factor.solve_transposed(&mut back);
        for i in 0..n {
            assert!((forward[(i, 1)] - x[(i, 1)]).abs() < 1e-12);
            assert!((back[(i, 1)] - x[(i, 1)]).abs() < 1e-12);
        }
    }
}
