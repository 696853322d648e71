//! The factors of any motion, by random combinations of its steps.
//!
//! ```text
//! Y = D Omega,   Q = qr(Y),   Q^T D = U' S V^T,   U = Q U' S,   C = V^T
//! ```
//!
//! `D` is evaluated in blocks, once for `Y`, once for `Q^T D` and once for the error, which is measured
//! at every node and step. While that is above the limit, `Omega` gets twice the columns (Halko,
//! Martinsson & Tropp 2011). The number of modes is the smallest that meets the limit.

use super::displacements::{Block, Displacements, NODES, add_mode, largest_norm};
use super::{Form, Modes};
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::linear::{
    Matrix, add_product, add_transposed_product, multiply, orthonormalize, subtract_product, svd,
};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Columns of the first `Omega`.
const FIRST_COLUMNS: usize = 40;
/// Part of the largest displacement that is round-off: no smaller limit is met.
const ROUND_OFF: f64 = 1e-13;
/// Blocks that one task of the second pass adds up, and values that tasks hold at once.
const BLOCKS: usize = 16;
const HELD: usize = 1 << 24;

/// Factors with all columns: `U (rows, n)` by rows, `V (columns, n)` by rows.
struct Factors {
    u: Vec<f64>,
    v: Matrix,
    v_rows: Vec<f64>,
    n: usize,
}

/// What the measurement of one or more blocks found.
struct Measured {
    /// Modes that they need: all and one more where all do not meet the limit.
    needed: usize,
    /// Largest errors with 0, 1, ... modes, where they were measured.
    errors: Vec<f64>,
}

impl Modes {
    /// The modes of any motion, to `limit` at every node and step, or to round-off where `limit` is
    /// less (1e-13 of the largest displacement).
    ///
    /// `displacements(step, nodes, out)` writes the displacements of some nodes at a step; it is
    /// called three times for each, more when the motion takes more than 40 modes, from all threads.
    /// Memory: the larger of `40 N_s` and `r N_s` numbers, three times that in vector form. Fails
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
                return Ok(Self::default());
            }
            let limit = limit.max(ROUND_OFF * largest);
            let factors = motion.factors(basis, n)?;
            if let Some((n_modes, truncation)) = motion.rank(&factors, limit, n == most) {
                return Ok(motion.modes(factors, n_modes, truncation));
            }
            n = (2 * n).min(most);
        }
        Ok(Self::default())
    }
}

impl<F: Fn(usize, Range<usize>, &mut [Vector]) + Sync> Displacements<F> {
    /// `Q (rows, n)`, by rows, and the largest displacement.
    fn basis(&self, n: usize) -> Result<(Vec<f64>, f64)> {
        let omega = combinations(self.n_columns(), n);
        let mut basis = vec![0.0; self.n_rows() * n];
        let blocks = basis.par_chunks_mut(NODES * self.rows_a_node() * n);
        let largest: Vec<Result<f64>> = blocks
            .enumerate()
            .map_init(Block::default, |block, (at, rows)| {
                let mut largest = 0.0f64;
                for steps in self.steps() {
                    self.read(&self.nodes(at), &steps, block);
                    largest = largest.max(self.largest(block)?);
                    let columns = self.columns(&steps);
                    let weights = &omega[n * columns.start..n * columns.end];
                    add_product(rows, &block.values, weights, columns.len(), n);
                }
                Ok(largest)
            })
            .collect();
        let largest = largest.into_iter().try_fold(0.0, |worst, largest| {
            largest.map(|largest| f64::max(worst, largest))
        })?;
        orthonormalize(&mut basis, n);
        Ok((basis, largest))
    }

    /// `U` in the place of `Q`, and `V`.
    fn factors(&self, mut basis: Vec<f64>, n: usize) -> Result<Factors> {
        let projected = self.projected(&basis, n);
        let (left, singular, right) = svd(&projected)?;
        multiply(
            &mut basis,
            &Matrix::from_fn(n, n, |i, j| left[(i, j)] * singular[j]),
        );
        let rows = 0..right.n_rows();
        Ok(Factors {
            u: basis,
            v_rows: rows
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .map(|at| right[at])
                .collect(),
            v: right,
            n,
        })
    }

    /// `Q^T D (n, columns)`: sums of a fixed number of blocks, added in order.
    fn projected(&self, basis: &[f64], n: usize) -> Matrix {
        let mut projected = Matrix::zeros(n, self.n_columns());
        let rows_a_block = NODES * self.rows_a_node() * n;
        let tasks: Vec<usize> = (0..self.n_blocks()).step_by(BLOCKS).collect();
        let at_once = (HELD / (n * self.n_columns())).max(1);
        for tasks in tasks.chunks(at_once) {
            let of_task = |first: &usize| {
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
            let parts: Vec<Vec<f64>> = tasks.par_iter().map(of_task).collect();
            for part in parts {
                for (sum, part) in projected.values_mut().iter_mut().zip(part) {
                    *sum += part;
                }
            }
        }
        projected
    }

    /// The smallest number of modes that meets the limit at every node and step, and their error;
    /// `None` where all do not meet it, unless they are `complete`.
    fn rank(&self, factors: &Factors, limit: f64, complete: bool) -> Option<(usize, f64)> {
        let enough = factors.enough(limit);
        for start in [enough, factors.n] {
            let measured = self.measured(factors, start, limit);
            if measured.needed <= start {
                return Some((measured.needed, measured.errors[measured.needed]));
            }
            if start == factors.n && complete {
                return Some((start, measured.errors[start]));
            }
            if start == factors.n {
                return None;
            }
        }
        None
    }

    /// Errors with `start` modes and with one after the other taken away, while they meet the limit.
    fn measured(&self, factors: &Factors, start: usize, limit: f64) -> Measured {
        let rows_a_block = NODES * self.rows_a_node() * factors.n;
        // Modes that some block is known to need: less is of no interest to others.
        let known = AtomicUsize::new(0);
        let blocks = factors.u.par_chunks(rows_a_block).enumerate();
        let measured = blocks.map_init(Block::default, |block, (at, u)| {
            let nodes = self.nodes(at);
            let mut errors = vec![0.0; start + 1];
            let mut needed = 0;
            for steps in self.steps() {
                self.read(&nodes, &steps, block);
                let columns = self.columns(&steps);
                let v = &factors.v_rows[factors.n * columns.start..factors.n * columns.end];
                subtract_product(&mut block.values, u, v, factors.n, start);
                let mut n_modes = start;
                let mut error = largest_norm(&block.values, nodes.len(), self.form);
                loop {
                    errors[n_modes] = f64::max(errors[n_modes], error);
                    if error > limit {
                        needed = needed.max(n_modes + 1);
                        known.fetch_max(needed, Ordering::Relaxed);
                        break;
                    }
                    if n_modes <= known.load(Ordering::Relaxed) {
                        break;
                    }
                    n_modes -= 1;
                    let column = u.iter().skip(n_modes).step_by(factors.n);
                    let column: Vec<f64> = column.copied().collect();
                    let row = &factors.v.column(n_modes)[columns.clone()];
                    error = add_mode(&mut block.values, &column, row, nodes.len(), self.form);
                }
            }
            Measured { needed, errors }
        });
        let none = || Measured {
            needed: 0,
            errors: vec![0.0; start + 1],
        };
        measured.reduce(none, Measured::worse)
    }

    /// The first modes of the factors, in the order of `Modes`.
    fn modes(&self, factors: Factors, n_modes: usize, truncation: f64) -> Modes {
        let Factors { mut u, v, n, .. } = factors;
        let right = Matrix::from_fn(v.n_rows(), n_modes, |i, j| v[(i, j)]);
        let rows = self.rows_a_node();
        let mut row = vec![0.0; n_modes * rows];
        for node in 0..self.n_nodes {
            for (at, value) in row.iter_mut().enumerate() {
                *value = u[(node * rows + at % rows) * n + at / rows];
            }
            u[node * row.len()..][..row.len()].copy_from_slice(&row);
        }
        u.truncate(self.n_nodes * row.len());
        u.shrink_to_fit();
        let modes = match self.form {
            Form::Scalar => Modes::scalar(&right, self.n_steps),
            Form::Vector => Modes::vector(&right, self.n_steps),
        };
        Modes {
            values: u,
            truncation,
            ..modes
        }
    }
}

impl Factors {
    /// A number of modes that is likely to meet a limit, and not much larger than must be: what the
    /// rest adds to a component is at most the product of its norms in `U` and in `V`.
    fn enough(&self, limit: f64) -> usize {
        let of_u = tails(&self.u, self.n);
        let of_v = tails(&self.v_rows, self.n);
        let bounds = of_u.iter().zip(&of_v).map(|(u, v)| u * v);
        // Columns go with growing error from the last to the first.
        let fewer = bounds.rev().take_while(|bound| *bound <= 0.5 * limit);
        self.n - fewer.count()
    }
}

impl Measured {
    fn worse(mut self, other: Self) -> Self {
        self.needed = self.needed.max(other.needed);
        for (error, other) in self.errors.iter_mut().zip(other.errors) {
            *error = error.max(other);
        }
        self
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
    let squares = rows.par_chunks(n * NODES).map(|rows| {
        let mut largest = vec![0.0; n];
        for row in rows.chunks_exact(n) {
            let mut square = 0.0;
            for (largest, value) in largest.iter_mut().zip(row).rev() {
                square += value * value;
                *largest = f64::max(*largest, square);
            }
        }
        largest
    });
    let squares = squares.reduce(|| vec![0.0; n], larger);
    squares.into_iter().map(f64::sqrt).collect()
}

/// `Omega (columns, n)`, by rows: numbers between -1 and 1 that follow from their place alone; the
/// identity where it has as many columns as rows.
fn combinations(n_columns: usize, n: usize) -> Vec<f64> {
    let entry = |at: usize| match n == n_columns {
        true => f64::from(u8::from(at / n == at % n)),
        false => random(at as u64),
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
