//! Cholesky factor of a symmetric positive definite matrix, in parallel tiles.

use super::Matrix;
use crate::parallel;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::reborrow::*;
use faer::{Accum, MatMut, MatRef, Par};

/// Columns factored at a time, and rows or columns of a tile.
const TILE: usize = 128;

/// `A = L L^T`, `L` lower triangular.
#[derive(Debug, Clone)]
pub struct Cholesky {
    lower: Matrix,
}

/// The matrix is not positive definite to working precision at this row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPositive(pub usize);

impl Cholesky {
    /// Factors `a (n, n)` from its lower triangle. `n^3 / 3` multiply-adds.
    ///
    /// # Errors
    /// [`NotPositive`] where a pivot is not above zero.
    pub fn factor(mut a: Matrix) -> Result<Self, NotPositive> {
        let n = a.n_rows;
        for start in (0..n).step_by(TILE) {
            let width = TILE.min(n - start);
            let (_, mut trailing) = a
                .as_faer_mut()
                .split_at_row_mut(start)
                .1
                .split_at_col_mut(start);
            let (mut panel, right) = trailing.rb_mut().split_at_col_mut(width);
            factor_panel(panel.rb_mut(), width).map_err(|row| NotPositive(start + row))?;
            let below = panel.rb().split_at_row(width).1;
            update(below, right.split_at_row_mut(width).1);
        }
        Ok(Self { lower: a })
    }

    /// Overwrites `rhs (n, r)` with the solution of `A x = rhs`. `2 n^2 r` multiply-adds.
    pub fn solve(&self, rhs: &mut Matrix) {
        let lower = self.lower.as_faer();
        solve_lower_triangular_in_place(lower, rhs.as_faer_mut(), Par::Seq);
        solve_upper_triangular_in_place(lower.transpose(), rhs.as_faer_mut(), Par::Seq);
    }
}

/// Factors the top block of a panel and solves for the rows below it.
fn factor_panel(panel: MatMut<'_, f64>, width: usize) -> Result<(), usize> {
    let (mut top, below) = panel.split_at_row_mut(width);
    let scratch = cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
    let mut buffer = MemBuffer::new(scratch);
    cholesky_in_place(
        top.rb_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut buffer),
        Default::default(),
    )
    .map_err(|error| match error {
        faer::linalg::cholesky::llt::factor::LltError::NonPositivePivot { index } => index,
    })?;
    let top = top.into_const();
    // X L^T = B by rows, as L X^T = B^T.
    parallel::for_items(row_tiles(below), &|_, rows| {
        solve_lower_triangular_in_place(top, rows.transpose_mut(), Par::Seq);
    });
    Ok(())
}

/// `trailing -= below below^T` in its lower triangle.
fn update(below: MatRef<'_, f64>, trailing: MatMut<'_, f64>) {
    let mut columns = Vec::new();
    let mut rest = trailing;
    let mut start = 0;
    while rest.ncols() > 0 {
        let width = TILE.min(rest.ncols());
        let (tile, after) = rest.split_at_col_mut(width);
        columns.push((start, tile));
        rest = after;
        start += width;
    }
    parallel::for_items(columns, &|_, (start, tile)| {
        let width = tile.ncols();
        let rows = below.get(start.., ..);
        let (top, bottom) = tile.split_at_row_mut(start).1.split_at_row_mut(width);
        triangular_matmul(
            top,
            BlockStructure::TriangularLower,
            Accum::Add,
            rows.get(..width, ..),
            BlockStructure::Rectangular,
            rows.get(..width, ..).transpose(),
            BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        faer::linalg::matmul::matmul(
            bottom,
            Accum::Add,
            rows.get(width.., ..),
            rows.get(..width, ..).transpose(),
            -1.0,
            Par::Seq,
        );
    });
}

fn row_tiles(matrix: MatMut<'_, f64>) -> Vec<MatMut<'_, f64>> {
    let mut tiles = Vec::new();
    let mut rest = matrix;
    while rest.nrows() > 0 {
        let height = TILE.min(rest.nrows());
        let (tile, after) = rest.split_at_row_mut(height);
        tiles.push(tile);
        rest = after;
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spd(n: usize) -> Matrix {
        Matrix::from_fn(n, n, |i, j| {
            (-((i as f64 - j as f64) / 9.0).powi(2)).exp() + f64::from(u8::from(i == j))
        })
    }

    #[test]
    fn the_solution_reproduces_the_right_hand_side() {
        for n in [1, 5, 128, 129, 400] {
            let a = spd(n);
            let rhs = Matrix::from_fn(n, 3, |i, j| ((i * 3 + j) as f64).cos());
            let mut x = rhs.clone();
            Cholesky::factor(a.clone())
                .expect("positive definite")
                .solve(&mut x);
            let back = a.times(&x);
            for j in 0..3 {
                for i in 0..n {
                    assert!((back[(i, j)] - rhs[(i, j)]).abs() < 1e-12, "n {n}");
                }
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_at_its_row() {
        let mut a = spd(200);
        a[(150, 150)] = -1.0;
        assert_eq!(Cholesky::factor(a).err(), Some(NotPositive(150)));
    }
}
