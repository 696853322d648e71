//! Displacements of any motion, evaluated in blocks of nodes and steps.

use super::Form;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use multiversion::multiversion;
use std::ops::Range;

/// Nodes and steps of a block: together about half of a second-level cache.
pub(super) const NODES: usize = 512;
const STEPS: usize = 32;
/// Values of a block of all steps, at most, unless one node has more.
const MOST: usize = 1 << 23;

/// A motion that is not stored: `fill(step, nodes, out)` writes the displacements of some nodes at a
/// step.
pub(super) struct Displacements<F> {
    pub n_nodes: usize,
    pub n_steps: usize,
    pub form: Form,
    pub fill: F,
}

/// A block of `D`, by columns: rows are nodes (or components of nodes, in vector form), columns are
/// components of steps (or steps).
#[derive(Default)]
pub(super) struct Block {
    pub values: Vec<f64>,
    displaced: Vec<Vector>,
}

impl<F: Fn(usize, Range<usize>, &mut [Vector]) + Sync> Displacements<F> {
    /// Rows of `D` a node.
    pub fn rows_a_node(&self) -> usize {
        match self.form {
            Form::Scalar => 1,
            Form::Vector => 3,
        }
    }

    /// Columns of `D` a step.
    pub fn columns_a_step(&self) -> usize {
        3 / self.rows_a_node()
    }

    pub fn n_rows(&self) -> usize {
        self.n_nodes * self.rows_a_node()
    }

    pub fn n_columns(&self) -> usize {
        self.n_steps * self.columns_a_step()
    }

    /// The steps of all blocks, in order.
    pub fn steps(&self) -> impl Iterator<Item = Range<usize>> + use<F> {
        let n = self.n_steps;
        (0..n)
            .step_by(STEPS)
            .map(move |start| start..(start + STEPS).min(n))
    }

    /// The nodes of all blocks, in order.
    pub fn nodes(&self, block: usize) -> Range<usize> {
        block * NODES..((block + 1) * NODES).min(self.n_nodes)
    }

    pub fn n_blocks(&self) -> usize {
        self.n_nodes.div_ceil(NODES)
    }

    /// Columns of `D` of some steps.
    pub fn columns(&self, steps: &Range<usize>) -> Range<usize> {
        let n = self.columns_a_step();
        n * steps.start..n * steps.end
    }

    /// Nodes of blocks that have all steps.
    pub fn nodes_with_all_steps(&self) -> usize {
        (MOST / (3 * self.n_steps)).clamp(1, NODES)
    }

    /// Fills `block` with the displacements of some nodes and steps.
    pub fn read(&self, nodes: &Range<usize>, steps: &Range<usize>, block: &mut Block) {
        let n = nodes.len();
        block.values.resize(3 * n * steps.len(), 0.0);
        block.displaced.resize(n, [0.0; 3]);
        for (step, out) in steps.clone().zip(block.values.chunks_exact_mut(3 * n)) {
            let displaced = &mut block.displaced[..];
            match self.form {
                Form::Vector => (self.fill)(step, nodes.clone(), out.as_chunks_mut().0),
                Form::Scalar => {
                    (self.fill)(step, nodes.clone(), displaced);
                    for (axis, column) in out.chunks_exact_mut(n).enumerate() {
                        for (value, displaced) in column.iter_mut().zip(displaced.iter()) {
                            *value = displaced[axis];
                        }
                    }
                }
            }
        }
    }

    /// The largest displacement of a block; an error where one is no finite number.
    pub fn largest(&self, block: &Block) -> Result<f64> {
        // Zero times infinity or NaN is NaN, and comparisons skip it.
        let zero: f64 = block.values.iter().map(|value| value * 0.0).sum();
        let largest = largest_norm(&block.values, block.displaced.len(), self.form);
        if zero == 0.0 && largest.is_finite() {
            Ok(largest)
        } else {
            Err(Error::input(
                "the motion has displacements that are not finite or far too large",
            ))
        }
    }
}

/// The largest distance from zero among the nodes of a block at its steps.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn largest_norm(values: &[f64], n: usize, form: Form) -> f64 {
    let mut largest = vec![0.0; n];
    for step in values.chunks_exact(3 * n) {
        raise(&mut largest, step, form);
    }
    largest.into_iter().fold(0.0, f64::max).sqrt()
}

/// Adds the product of one column of `U` and a row of `C` to a block, and returns its largest norm.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn add_mode(values: &mut [f64], u: &[f64], c: &[f64], n: usize, form: Form) -> f64 {
    let mut largest = vec![0.0; n];
    let c = c.chunks_exact(3 * n / u.len());
    for (step, c) in values.chunks_exact_mut(3 * n).zip(c) {
        for (column, c) in step.chunks_exact_mut(u.len()).zip(c) {
            for (value, u) in column.iter_mut().zip(u) {
                *value += u * c;
            }
        }
        raise(&mut largest, step, form);
    }
    largest.into_iter().fold(0.0, f64::max).sqrt()
}

/// Raises the largest square of each node to the square of its displacement at one step.
#[inline(always)]
fn raise(largest: &mut [f64], step: &[f64], form: Form) {
    let n = largest.len();
    let higher = |a: f64, b: f64| if b > a { b } else { a };
    match form {
        Form::Scalar => {
            let (x, rest) = step.split_at(n);
            let (y, z) = rest.split_at(n);
            for i in 0..n {
                largest[i] = higher(largest[i], x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
            }
        }
        Form::Vector => {
            for (largest, [x, y, z]) in largest.iter_mut().zip(step.as_chunks::<3>().0) {
                *largest = higher(*largest, x * x + y * y + z * z);
            }
        }
    }
}
