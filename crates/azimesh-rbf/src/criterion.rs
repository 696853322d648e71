//! The error of the interpolant at a node over all steps, from its residual in the modes.
//!
//! With `e (1, r)` the mode residual at a node, the displacement error at step `k` is `|e C_k|`; where
//! modes are in parts that do not cancel, as rotations about different centres, with the node's arm of
//! each part it is at most
//!
//! ```text
//! sum_p arm_p |e_p C_p,k|
//! ```

use azimesh_core::error::Result;
use azimesh_core::linear::{Matrix, svd};
use azimesh_core::parallel;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Number of steps sampled for an estimate; errors vary smoothly over most schedules.
const SAMPLED: usize = 24;
/// Number of nodes whose errors are summed first, before the sums are added.
const MEAN_CHUNK: usize = 4096;

/// Coefficients of the modes at every step, and bounds on them.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Criterion {
    n_modes: usize,
    n_steps: usize,
    /// `C_k` by steps: (K, r, 3).
    coefficients: Vec<f64>,
    /// Modes whose errors are vectors that add up; the errors of different parts add by their lengths.
    parts: Vec<Range<usize>>,
    /// `max_p |C_p,k|_2` of each step.
    norms: Vec<f64>,
    /// `max_k |C_p,k|_2` of each part.
    part_norms: Vec<f64>,
    /// Steps of the sample, ascending.
    sampled: Vec<usize>,
}

impl Criterion {
    /// Creates a criterion from `coefficients (K, r, 3)`, by steps; the modes are one part.
    pub fn new(n_modes: usize, coefficients: &[f64]) -> Result<Self> {
        let whole = std::iter::once(0..n_modes);
        Self::of_parts(n_modes, coefficients, whole.collect())
    }

    /// Creates a criterion for values that are not modes of a motion: the error is the largest of any column.
    pub fn of_columns(n_columns: usize) -> Result<Self> {
        // Column k is the displacement along x at step k.
        let mut coefficients = vec![0.0; 3 * n_columns * n_columns];
        for column in 0..n_columns {
            coefficients[3 * (column * n_columns + column)] = 1.0;
        }
        Self::new(n_columns, &coefficients)
    }

    /// Creates a criterion from `coefficients (K, r, 3)`, by steps, with the modes of each part.
    pub fn of_parts(
        n_modes: usize,
        coefficients: &[f64],
        parts: Vec<Range<usize>>,
    ) -> Result<Self> {
        let n_steps = coefficients.len() / (3 * n_modes).max(1);
        let mut norms = vec![0.0; n_steps];
        let mut part_norms = vec![0.0; parts.len()];
        for (step, c) in coefficients.chunks_exact((3 * n_modes).max(1)).enumerate() {
            for (part, modes) in parts.iter().enumerate() {
                let c = &c[3 * modes.start..3 * modes.end];
                let c = Matrix::from_fn(modes.len(), 3, |m, axis| c[3 * m + axis]);
                let norm = svd(&c)?.1.first().copied().unwrap_or(0.0);
                norms[step] = f64::max(norms[step], norm);
                part_norms[part] = f64::max(part_norms[part], norm);
            }
        }
        let stride = n_steps.div_ceil(SAMPLED).max(1);
        Ok(Self {
            n_modes,
            n_steps,
            coefficients: coefficients.to_vec(),
            parts,
            norms,
            part_norms,
            sampled: (0..n_steps).step_by(stride).collect(),
        })
    }

    /// Returns the criterion of one step only.
    pub fn of_step(&self, step: usize) -> Result<Self> {
        self.of_steps(step..step + 1)
    }

    /// Returns the criterion of some steps only.
    pub fn of_steps(&self, steps: Range<usize>) -> Result<Self> {
        let size = 3 * self.n_modes;
        let coefficients = &self.coefficients[size * steps.start..size * steps.end];
        Self::of_parts(self.n_modes, coefficients, self.parts.clone())
    }

    /// Number of modes.
    pub fn n_modes(&self) -> usize {
        self.n_modes
    }

    /// Number of parts.
    pub fn n_parts(&self) -> usize {
        self.parts.len()
    }

    /// Returns the lever arms of one point, one per part, from the arms of all points (N, parts). Empty arms stand for 1
    /// everywhere.
    #[inline]
    pub fn arms_of<'a>(&self, point: usize, lever_arms: &'a [f64]) -> &'a [f64] {
        if lever_arms.is_empty() {
            &[]
        } else {
            &lever_arms[point * self.parts.len()..][..self.parts.len()]
        }
    }

    /// Returns an upper bound of the error at any step: `sum_p arm_p |e_p| max_k |C_p,k|_2`.
    #[inline]
    pub fn bound(&self, residual: &[f64], lever_arms: &[f64]) -> f64 {
        self.sum(lever_arms, |part, modes| {
            squared_norm(&residual[modes]).sqrt() * self.part_norms[part]
        })
    }

    /// The largest error over a sample of the steps; at most the exact one.
    #[inline]
    pub fn sampled(&self, residual: &[f64], lever_arms: &[f64]) -> f64 {
        self.largest(residual, lever_arms, self.sampled.iter().copied())
    }

    /// The largest error over all steps.
    pub fn exact(&self, residual: &[f64], lever_arms: &[f64]) -> f64 {
        self.largest(residual, lever_arms, 0..self.n_steps)
    }

    /// The error at one step.
    #[inline]
    pub fn at_step(&self, residual: &[f64], lever_arms: &[f64], step: usize) -> f64 {
        self.sum(lever_arms, |_, modes| {
            self.squared(residual, modes, step).sqrt()
        })
    }

    /// Adds the worst of the steps with errors above `stop` to the sample, until it has twice as many; `errors` has one error
    /// per step. Returns whether there was such a step.
    pub fn sample_more(&mut self, by_step: &[f64], stop: f64) -> bool {
        let above = (0..by_step.len()).filter(|step| by_step[*step] > stop);
        let mut missed: Vec<usize> = above
            .filter(|step| self.sampled.binary_search(step).is_err())
            .collect();
        missed.sort_by(|a, b| by_step[*b].total_cmp(&by_step[*a]));
        missed.truncate(self.sampled.len());
        self.sampled.extend(&missed);
        self.sampled.sort_unstable();
        !missed.is_empty()
    }

    #[inline]
    fn largest(
        &self,
        residual: &[f64],
        lever_arms: &[f64],
        steps: impl Iterator<Item = usize>,
    ) -> f64 {
        // For a single part the root is taken once.
        let mut largest = 0.0;
        if let [modes] = self.parts.as_slice() {
            for step in steps {
                largest = f64::max(largest, self.squared(residual, modes.clone(), step));
            }
            return arm(lever_arms, 0) * largest.sqrt();
        }
        for step in steps {
            largest = f64::max(largest, self.at_step(residual, lever_arms, step));
        }
        largest
    }

    /// The sum over the parts of arm times length.
    #[inline]
    fn sum(&self, lever_arms: &[f64], length: impl Fn(usize, Range<usize>) -> f64) -> f64 {
        let mut sum = 0.0;
        for (part, modes) in self.parts.iter().enumerate() {
            sum += arm(lever_arms, part) * length(part, modes.clone());
        }
        sum
    }

    #[inline]
    fn squared(&self, residual: &[f64], modes: Range<usize>, step: usize) -> f64 {
        let c = &self.coefficients[step * self.n_modes * 3..][3 * modes.start..3 * modes.end];
        let mut sum = [0.0; 3];
        let residual = &residual[modes];
        for mode in 0..residual.len() {
            for axis in 0..3 {
                sum[axis] += residual[mode] * c[3 * mode + axis];
            }
        }
        sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]
    }

    /// Returns the mean error over all nodes at the step with the largest mean, from residuals (N, r) and lever arms.
    pub fn largest_mean(&self, residuals: &[f64], lever_arms: &[f64]) -> f64 {
        let r = self.n_modes.max(1);
        let n_nodes = residuals.len() / r;
        let sums = parallel::map_blocks(n_nodes, MEAN_CHUNK, &|nodes| {
            let mut sums = vec![0.0; self.n_steps];
            for node in nodes {
                let residual = &residuals[node * r..][..r];
                let lever_arms = self.arms_of(node, lever_arms);
                for (step, sum) in sums.iter_mut().enumerate() {
                    *sum += self.at_step(residual, lever_arms, step);
                }
            }
            sums
        });
        let mean = |step: usize| {
            let total: f64 = sums.iter().map(|sums| sums[step]).sum();
            total / n_nodes.max(1) as f64
        };
        (0..self.n_steps).map(mean).fold(0.0, f64::max)
    }

    /// Returns the largest error at each step over all nodes, from their residuals (N, r) and lever arms. Nodes are sorted by
    /// decreasing residual, so that few are evaluated in each step.
    pub fn largest_by_step(&self, residuals: &[f64], lever_arms: &[f64]) -> Vec<f64> {
        if self.n_modes == 0 {
            return vec![0.0; self.n_steps];
        }
        let residual = |node: usize| &residuals[node * self.n_modes..][..self.n_modes];
        // The bits of numbers that are not negative are in the order of the numbers.
        let mut falling = parallel::collect(residuals.len() / self.n_modes, |node| {
            let (lever_arms, e) = (self.arms_of(node, lever_arms), residual(node));
            let length = self.sum(lever_arms, |_, modes| squared_norm(&e[modes]).sqrt());
            (!length.to_bits(), node as u32)
        });
        parallel::sort(&mut falling);
        (0..self.n_steps)
            .map(|k| {
                let mut largest = 0.0;
                for &(bits, node) in &falling {
                    if f64::from_bits(!bits) * self.norms[k] <= largest {
                        break;
                    }
                    let node = node as usize;
                    let error = self.at_step(residual(node), self.arms_of(node, lever_arms), k);
                    largest = f64::max(largest, error);
                }
                largest
            })
            .collect()
    }
}

/// The arm of a part; 1 where there are none.
#[inline]
fn arm(lever_arms: &[f64], part: usize) -> f64 {
    lever_arms.get(part).copied().unwrap_or(1.0)
}

fn squared_norm(e: &[f64]) -> f64 {
    e.iter().map(|x| x * x).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_holds_and_the_largest_by_step_is_exact() {
        let (r, steps, nodes) = (4, 90, 200);
        let coefficients: Vec<f64> = (0..steps * r * 3).map(|i| (i as f64 * 0.7).sin()).collect();
        let residuals: Vec<f64> = (0..nodes * r).map(|i| (i as f64 * 1.3).cos()).collect();
        let criterion = Criterion::new(r, &coefficients).expect("it converges");
        let by_step = criterion.largest_by_step(&residuals, &[]);
        for e in residuals.chunks(r) {
            assert!(criterion.exact(e, &[]) <= criterion.bound(e, &[]) * (1.0 + 1e-12));
            assert!(criterion.sampled(e, &[]) <= criterion.exact(e, &[]));
        }
        for (k, largest) in by_step.iter().enumerate() {
            let brute = residuals.chunks(r).map(|e| criterion.at_step(e, &[], k));
            assert_eq!(*largest, brute.fold(0.0, f64::max));
        }
    }

    #[test]
    fn residuals_of_parts_that_turn_about_different_centres_do_not_cancel() {
        // Two rotations that cancel as vectors, with lever arms of 3 and 0.5; at the second step twice both.
        let coefficients = [0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 2.0, 0.0, 0.0, -2.0];
        let parts = vec![0..1, 1..2];
        let criterion = Criterion::of_parts(2, &coefficients, parts).expect("it converges");
        let (residuals, lever_arms) = ([0.1, 0.1, 0.0, 0.1], [3.0, 0.5, 1.0, 1.0]);
        let (residual, own) = (&residuals[..2], criterion.arms_of(0, &lever_arms));
        assert!((criterion.at_step(residual, own, 0) - 0.35).abs() < 1e-15);
        assert!((criterion.exact(residual, own) - 0.7).abs() < 1e-15);
        assert_eq!(
            criterion.exact(residual, own),
            criterion.sampled(residual, own)
        );
        assert!(criterion.bound(residual, own) >= 0.7 - 1e-15);
        let by_step = criterion.largest_by_step(&residuals, &lever_arms);
        assert!((by_step[0] - 0.35).abs() < 1e-15 && (by_step[1] - 0.7).abs() < 1e-15);
        assert!((criterion.largest_mean(&residuals, &lever_arms) - 0.45).abs() < 1e-15);
    }

    #[test]
    fn a_step_between_those_of_the_sample_joins_it_when_it_is_the_worst() {
        let mut coefficients = vec![0.0; 3 * 100];
        coefficients[3 * 7] = 1.0;
        coefficients[3 * 11] = 0.5;
        let mut criterion = Criterion::new(1, &coefficients).expect("it converges");
        assert_eq!(criterion.sampled(&[1.0], &[]), 0.0);
        let by_step = criterion.largest_by_step(&[1.0], &[]);
        assert!(criterion.sample_more(&by_step, 0.75));
        assert_eq!(criterion.sampled(&[1.0], &[]), 1.0);
        assert!(!criterion.sample_more(&by_step, 0.75));
    }
}
