//! The truncation error of modes at every node and step, and how many modes a motion needs.

use super::displacements::{Block, Displacements, add_mode, largest_norm};
use super::sketch::Course;
use super::{Form, Modes};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::linear::{Matrix, add_product, subtract_product};
use azimesh_core::parallel::{self, Scratch};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Result of measuring some nodes.
struct Measured {
    /// Modes that they need: one more than there are where all do not meet the limit.
    needed: usize,
    /// Largest errors with 0, 1, ... modes, where they were measured.
    errors: Vec<f64>,
}

/// The first modes of `V`, by columns and by rows.
struct First<'a> {
    n: usize,
    right: &'a Matrix,
    rows: Vec<f64>,
}

impl<F: Fn(usize, Range<usize>, &mut [Vector]) + Sync> Displacements<F> {
    /// The fewest modes that meet the limit at every node and step; `None` where all of `V` do not,
    /// unless it is `complete` and only round-off is left.
    pub fn modes(&self, course: &Course, limit: f64, complete: bool) -> Option<Modes> {
        let all = course.right.n_cols();
        for n in [course.enough, all] {
            let (values, measured) = self.measured(&First::new(&course.right, n), limit);
            if measured.needed <= n || (complete && n == all) {
                let n_modes = measured.needed.min(n);
                let truncation = measured.errors[n_modes];
                return Some(self.assembled(values, n, &course.right, n_modes, truncation));
            }
            if n == all {
                break;
            }
        }
        None
    }

    /// `U = D V (rows, n)`, by rows, and its errors with one mode after the other taken away from
    /// the last on, while they meet the limit.
    fn measured(&self, first: &First<'_>, limit: f64) -> (Vec<f64>, Measured) {
        let n = first.n;
        let mut values = vec![0.0; self.n_rows() * n];
        let nodes_a_block = self.nodes_with_all_steps();
        // Modes that some block is known to need: errors with fewer are of no interest.
        let known = AtomicUsize::new(0);
        let measure = |at, u: &mut [f64], block: &mut Block| {
            let start = at * nodes_a_block;
            let n_nodes = u.len() / (self.rows_a_node() * n);
            self.read(&(start..start + n_nodes), &(0..self.n_steps), block);
            let mut measured = Measured::nothing(n);
            add_product(u, &block.values, &first.rows, self.n_columns(), n);
            for steps in self.steps() {
                let values = &mut block.values[3 * n_nodes * steps.start..3 * n_nodes * steps.end];
                let columns = self.columns(&steps);
                let rows = &first.rows[n * columns.start..n * columns.end];
                subtract_product(values, u, rows, n);
                self.take_away(values, u, (first, columns), limit, &known, &mut measured);
            }
            measured
        };
        let scratch = Scratch::new(Block::default);
        let blocks = values.chunks_mut(nodes_a_block * self.rows_a_node() * n);
        let measured =
            parallel::map_items(blocks, &|at, u| scratch.with(|block| measure(at, u, block)));
        let measured = (measured.into_iter()).fold(Measured::nothing(n), Measured::worse);
        (values, measured)
    }

    /// Subtracts modes from a block whose errors are `values`.
    fn take_away(
        &self,
        values: &mut [f64],
        u: &[f64],
        (first, columns): (&First<'_>, Range<usize>),
        limit: f64,
        known: &AtomicUsize,
        measured: &mut Measured,
    ) {
        let n_nodes = u.len() / (self.rows_a_node() * first.n);
        let mut n_modes = first.n;
        let mut error = largest_norm(values, n_nodes, self.form);
        loop {
            measured.errors[n_modes] = measured.errors[n_modes].max(error);
            if error > limit {
                measured.needed = measured.needed.max(n_modes + 1);
                known.fetch_max(n_modes + 1, Ordering::Relaxed);
                return;
            }
            if n_modes <= known.load(Ordering::Relaxed) {
                return;
            }
            n_modes -= 1;
            let column = u.iter().skip(n_modes).step_by(first.n);
            let column: Vec<f64> = column.copied().collect();
            let row = &first.right.column(n_modes)[columns.clone()];
            error = add_mode(values, &column, row, n_nodes, self.form);
        }
    }

    /// The first `n_modes` of `n` columns, in the order of `Modes`.
    fn assembled(
        &self,
        mut values: Vec<f64>,
        n: usize,
        right: &Matrix,
        n_modes: usize,
        truncation: f64,
    ) -> Modes {
        let right = Matrix::from_fn(right.n_rows(), n_modes, |i, j| right[(i, j)]);
        let rows = self.rows_a_node();
        let mut row = vec![0.0; n_modes * rows];
        for node in 0..self.n_nodes {
            for (at, value) in row.iter_mut().enumerate() {
                *value = values[(node * rows + at % rows) * n + at / rows];
            }
            values[node * row.len()..][..row.len()].copy_from_slice(&row);
        }
        values.truncate(self.n_nodes * row.len());
        values.shrink_to_fit();
        let modes = match self.form {
            Form::Scalar => Modes::scalar(&right, self.n_steps),
            Form::Vector => Modes::vector(&right, self.n_steps),
        };
        Modes {
            values,
            truncation,
            ..modes
        }
    }
}

impl<'a> First<'a> {
    fn new(right: &'a Matrix, n: usize) -> Self {
        let rows = 0..right.n_rows();
        Self {
            n,
            right,
            rows: rows
                .flat_map(|i| (0..n).map(move |j| right[(i, j)]))
                .collect(),
        }
    }
}

impl Measured {
    fn nothing(n: usize) -> Self {
        Self {
            needed: 0,
            errors: vec![0.0; n + 1],
        }
    }

    fn worse(mut self, other: Self) -> Self {
        self.needed = self.needed.max(other.needed);
        for (error, other) in self.errors.iter_mut().zip(other.errors) {
            *error = error.max(other);
        }
        self
    }
}
