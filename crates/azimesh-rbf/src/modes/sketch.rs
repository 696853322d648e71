//! The modes of any motion, by random combinations of its steps.
//!
//! ```text
//! Y = D Omega,   Q = qr(Y),   Q^T D = U' S V^T,   C = V^T,   U = D V
//! ```
//!
//! `D` is evaluated in blocks: once for `Y`, once for `Q^T D`, and once for `U` and the error, which is
//! measured at every node and step (`measure`). While that is above the limit, `Omega` gets twice the
//! columns (Halko, Martinsson & Tropp 2011).

use super::displacements::{Block, Displacements, NODES};
use super::{Form, Modes};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::linear::{
    Matrix, add_product, add_transposed_product, multiply, orthonormalize, svd,
};
use azimesh_core::parallel::{self, Scratch};
use std::ops::Range;

/// Columns of the first `Omega`.
const FIRST_COLUMNS: usize = 40;
/// Part of the largest displacement that is round-off: no smaller limit is met.
const ROUND_OFF: f64 = 3e-14;
/// Blocks that one task of the second pass adds up, and values that tasks hold at once.
const BLOCKS: usize = 16;
const HELD: usize = 1 << 24;

impl Modes {
    /// The modes of any motion, to `limit` at every node and step, or to round-off where `limit` is
    /// less (3e-14 of the largest displacement): the first of the singular value decomposition, no
    /// more than the limit needs.
    ///
    /// `displacements(step, nodes, out)` writes the displacements of some nodes at a step; it is
    /// called three times for each, more when the motion takes more than 40 modes, from all threads.
    /// Memory: `40 N_s` numbers or `r N_s` if that is more, three times that in vector form. Fails
    /// where a displacement is no finite number.
    pub fn of_displacements(
        n_nodes: usize,
        n_steps: usize,
        limit: f64,
        form: Form,
        displacements: impl Fn(usize, Range<usize>, &mut [Vector]) + Sync,
    ) -> Result<Self> {
        let motion = Displacements {
            n_nodes,
            n_steps,
            form,
            fill: displacements,
        };
        let most = motion.n_rows().min(motion.n_columns());
        let mut n = FIRST_COLUMNS.min(most);
        while n > 0 {
            let (basis, largest) = motion.basis(n)?;
            if largest == 0.0 {
                break;
            }
            let limit = limit.max(ROUND_OFF * largest);
            let course = motion.course(basis, n, limit)?;
            if let Some(modes) = motion.modes(&course, limit, n == most) {
                return Ok(modes);
            }
            n = (2 * n).min(most);
        }
        Ok(Self::default())
    }
}

/// The course of the modes over the steps.
pub(super) struct Course {
    /// `V (columns, n)`.
    pub right: Matrix,
    /// A number of modes that is likely to meet the limit, and not much larger than must be.
    pub enough: usize,
}

impl<F: Fn(usize, Range<usize>, &mut [Vector]) + Sync> Displacements<F> {
    /// `Q (rows, n)`, by rows, and the largest displacement.
    fn basis(&self, n: usize) -> Result<(Vec<f64>, f64)> {
        let omega = combinations(self.n_columns(), n);
        let mut basis = vec![0.0; self.n_rows() * n];
        let project = |at, rows: &mut [f64], block: &mut Block| {
            let mut largest = 0.0f64;
            for steps in self.steps() {
                self.read(&self.nodes(at), &steps, block);
                largest = largest.max(self.largest(block)?);
                let columns = self.columns(&steps);
                let weights = &omega[n * columns.start..n * columns.end];
                add_product(rows, &block.values, weights, columns.len(), n);
            }
            Ok(largest)
        };
        let scratch = Scratch::new(Block::default);
        let blocks = basis.chunks_mut(NODES * self.rows_a_node() * n);
        let largest: Vec<Result<f64>> = parallel::map_items(blocks, &|at, rows| {
            scratch.with(|block| project(at, rows, block))
        });
        let largest = largest.into_iter().try_fold(0.0, |worst, largest| {
            largest.map(|largest| f64::max(worst, largest))
        })?;
        orthonormalize(&mut basis, n);
        Ok((basis, largest))
    }

    /// `V` from `Q`. What the modes from one on add to a component is at most the product of their
    /// largest norms in `U` and in `V`, which gives the number that is enough.
    fn course(&self, mut basis: Vec<f64>, n: usize, limit: f64) -> Result<Course> {
        let projected = self.projected(&basis, n);
        // First columns that span the rows of Q^T D to the last digit: its decomposition alone would
        // miss them by round-off of the largest singular value.
        let rows = projected.n_rows() * projected.n_cols();
        let mut spanning: Vec<f64> = (0..rows).map(|at| projected[(at % n, at / n)]).collect();
        orthonormalize(&mut spanning, n);
        let spanning = Matrix::from_fn(self.n_columns(), n, |i, j| spanning[i * n + j]);
        let small = projected.times(&spanning);
        let (_, _, turn) = svd(&small)?;
        let right = spanning.times(&turn);
        multiply(&mut basis, &small.times(&turn));
        let of_u = tails(&basis, n);
        let rows: Vec<f64> = (0..rows).map(|at| right[(at / n, at % n)]).collect();
        let bounds = of_u.into_iter().zip(tails(&rows, n)).map(|(u, v)| u * v);
        let fewer = bounds.rev().take_while(|bound| *bound <= 0.5 * limit);
        Ok(Course {
            right,
            enough: (n - fewer.count()).max(1),
        })
    }

    /// `Q^T D (n, columns)`: sums of a fixed number of blocks, added in order.
    fn projected(&self, basis: &[f64], n: usize) -> Matrix {
        let mut projected = Matrix::zeros(n, self.n_columns());
        let rows_a_block = NODES * self.rows_a_node() * n;
        let tasks: Vec<usize> = (0..self.n_blocks()).step_by(BLOCKS).collect();
        let at_once = (HELD / (n * self.n_columns())).max(1);
        for tasks in tasks.chunks(at_once) {
            let of_task = |_, first: &usize| {
                let mut part = vec![0.0; n * self.n_columns()];
                let mut block = Block::default();
                for at in *first..(first + BLOCKS).min(self.n_blocks()) {
                    let rows = &basis[at * rows_a_block..];
                    let rows = &rows[..rows_a_block.min(rows.len())];
                    for steps in self.steps() {
                        self.read(&self.nodes(at), &steps, &mut block);
                        let columns = self.columns(&steps);
                        let part = &mut part[n * columns.start..n * columns.end];
                        add_transposed_product(part, rows, &block.values, n);
                    }
                }
                part
            };
            let parts = parallel::map_items(tasks, &of_task);
            for part in parts {
                for (sum, part) in projected.values_mut().iter_mut().zip(part) {
                    *sum += part;
                }
            }
        }
        projected
    }
}

/// The largest norm over rows of the entries from each column on.
fn tails(rows: &[f64], n: usize) -> Vec<f64> {
    let larger = |mut a: Vec<f64>, b: Vec<f64>| {
        for (a, b) in a.iter_mut().zip(b) {
            *a = a.max(b);
        }
        a
    };
    let squares = parallel::map_blocks(rows.len() / n, NODES, &|range| {
        let mut largest = vec![0.0; n];
        for row in rows[range.start * n..range.end * n].chunks_exact(n) {
            let mut square = 0.0;
            for (largest, value) in largest.iter_mut().zip(row).rev() {
                square += value * value;
                *largest = f64::max(*largest, square);
            }
        }
        largest
    });
    let squares = squares.into_iter().fold(vec![0.0; n], larger);
    squares.into_iter().map(f64::sqrt).collect()
}

/// `Omega (columns, n)`, by rows: numbers between -1 and 1 that follow from their place alone; the
/// identity where it has as many columns as rows.
fn combinations(n_columns: usize, n: usize) -> Vec<f64> {
    let entry = |at: usize| {
        if n == n_columns {
            f64::from(u8::from(at / n == at % n))
        } else {
            random(at as u64)
        }
    };
    (0..n_columns * n).map(entry).collect()
}

/// Number `at` of a fixed sequence between -1 and 1 (SplitMix64; Steele, Lea & Flood 2014).
fn random(at: u64) -> f64 {
    let mut z = (at + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
