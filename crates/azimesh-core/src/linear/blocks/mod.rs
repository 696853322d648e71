//! Sparse symmetric matrices of 3x3 blocks, one block row a node: their pattern, products and solutions.
//!
//! `incomplete` has the preconditioner, `conjugate` the solver. All of it runs on one thread, in a fixed order.

mod conjugate;
mod incomplete;
#[cfg(test)]
mod tests;

pub use conjugate::{Solved, solve};
pub use incomplete::Incomplete;

use multiversion::multiversion;

/// The three numbers of a block row.
pub type Vector = [f64; 3];
/// A 3x3 block by rows.
pub type Block = [f64; 9];

/// A symmetric matrix: the diagonal blocks and those below it.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// Start of each row in `columns`.
    starts: Vec<usize>,
    /// Columns below the diagonal, ascending in each row.
    columns: Vec<u32>,
    below: Vec<Block>,
    diagonal: Vec<Block>,
}

impl Blocks {
    /// Zeros. `pairs` are the (row, column) of the blocks below the diagonal, in any order and with
    /// repetitions; the diagonal is always there.
    pub fn with_pattern(n_rows: usize, mut pairs: Vec<(u32, u32)>) -> Self {
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; n_rows + 1];
        for &(row, column) in &pairs {
            debug_assert!(column < row);
            starts[row as usize + 1] += 1;
        }
        for row in 0..n_rows {
            starts[row + 1] += starts[row];
        }
        Self {
            starts,
            below: vec![[0.0; 9]; pairs.len()],
            columns: pairs.into_iter().map(|pair| pair.1).collect(),
            diagonal: vec![[0.0; 9]; n_rows],
        }
    }

    /// Number of block rows.
    pub fn n_rows(&self) -> usize {
        self.diagonal.len()
    }

    /// Index of a block below the diagonal; `None` where the pattern has none.
    pub fn slot(&self, row: u32, column: u32) -> Option<usize> {
        let range = self.starts[row as usize]..self.starts[row as usize + 1];
        let at = self.columns[range.clone()].binary_search(&column).ok()?;
        Some(range.start + at)
    }

    /// The blocks below the diagonal, to be written.
    pub fn below_mut(&mut self) -> &mut [Block] {
        &mut self.below
    }

    /// The diagonal blocks, to be written.
    pub fn diagonal_mut(&mut self) -> &mut [Block] {
        &mut self.diagonal
    }

    /// Calls `act(row, column, block)` for each block below the diagonal.
    pub fn for_each_below(&mut self, mut act: impl FnMut(u32, u32, &mut Block)) {
        for row in 0..self.diagonal.len() {
            let range = self.starts[row]..self.starts[row + 1];
            let columns = &self.columns[range.clone()];
            for (&column, block) in columns.iter().zip(&mut self.below[range]) {
                act(row as u32, column, block);
            }
        }
    }

    /// Makes all blocks zero.
    pub fn clear(&mut self) {
        self.below.fill([0.0; 9]);
        self.diagonal.fill([0.0; 9]);
    }

    /// `y = A x`.
    pub fn multiply(&self, x: &[Vector], y: &mut [Vector]) {
        multiply(
            &self.starts,
            &self.columns,
            &self.below,
            &self.diagonal,
            x,
            y,
        );
    }
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn multiply(
    starts: &[usize],
    columns: &[u32],
    below: &[Block],
    diagonal: &[Block],
    x: &[Vector],
    y: &mut [Vector],
) {
    for row in 0..diagonal.len() {
        let own = x[row];
        let mut sum = times(&diagonal[row], own);
        let range = starts[row]..starts[row + 1];
        for (&column, block) in columns[range.clone()].iter().zip(&below[range]) {
            let column = column as usize;
            add_times(&mut sum, block, x[column]);
            add_transposed_times(&mut y[column], block, own);
        }
        y[row] = sum;
    }
}

/// `A x`.
#[inline(always)]
fn times(a: &Block, x: Vector) -> Vector {
    [
        a[0] * x[0] + a[1] * x[1] + a[2] * x[2],
        a[3] * x[0] + a[4] * x[1] + a[5] * x[2],
        a[6] * x[0] + a[7] * x[1] + a[8] * x[2],
    ]
}

/// `y += A x`.
#[inline(always)]
fn add_times(y: &mut Vector, a: &Block, x: Vector) {
    let product = times(a, x);
    for axis in 0..3 {
        y[axis] += product[axis];
    }
}

/// `y -= A x`.
#[inline(always)]
fn subtract_times(y: &mut Vector, a: &Block, x: Vector) {
    let product = times(a, x);
    for axis in 0..3 {
        y[axis] -= product[axis];
    }
}

/// `A^T x`.
#[inline(always)]
fn transposed_times(a: &Block, x: Vector) -> Vector {
    [
        a[0] * x[0] + a[3] * x[1] + a[6] * x[2],
        a[1] * x[0] + a[4] * x[1] + a[7] * x[2],
        a[2] * x[0] + a[5] * x[1] + a[8] * x[2],
    ]
}

/// `y += A^T x`.
#[inline(always)]
fn add_transposed_times(y: &mut Vector, a: &Block, x: Vector) {
    let product = transposed_times(a, x);
    for axis in 0..3 {
        y[axis] += product[axis];
    }
}

/// `y -= A^T x`.
#[inline(always)]
fn subtract_transposed_times(y: &mut Vector, a: &Block, x: Vector) {
    let product = transposed_times(a, x);
    for axis in 0..3 {
        y[axis] -= product[axis];
    }
}
