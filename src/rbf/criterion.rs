//! How far the interpolant is off at a node, over all steps, from its residual in the modes.
//!
//! With `e (1, r)` the mode residual at a node, the displacement error at step `k` is `|e C_k|`.

use super::select::arm;
use crate::error::Result;
use crate::linear::{Matrix, svd};
use rayon::prelude::*;

/// Steps looked at where an estimate serves; errors vary smoothly over a schedule.
const SAMPLED: usize = 24;
/// Nodes whose errors are summed before the sums of all are.
const MEAN_CHUNK: usize = 4096;

/// Coefficients of the modes at every step, and bounds on them.
#[derive(Debug, Clone)]
pub struct Criterion {
    n_modes: usize,
    /// `C_k` by steps: (K, r, 3).
    coefficients: Vec<f64>,
    /// `|C_k|_2` of each step.
    norms: Vec<f64>,
    largest_norm: f64,
    sampled: Vec<usize>,
}

impl Criterion {
    /// From `coefficients (K, r, 3)`, by steps.
    pub fn new(n_modes: usize, coefficients: &[f64]) -> Result<Self> {
        let norms = coefficients
            .chunks_exact((3 * n_modes).max(1))
            .map(|c| {
                let c = Matrix::from_fn(n_modes, 3, |m, axis| c[3 * m + axis]);
                Ok(svd(&c)?.1.first().copied().unwrap_or(0.0))
            })
            .collect::<Result<Vec<f64>>>()?;
        let stride = norms.len().div_ceil(SAMPLED).max(1);
        Ok(Self {
            n_modes,
            coefficients: coefficients.to_vec(),
            largest_norm: norms.iter().copied().fold(0.0, f64::max),
            sampled: (0..norms.len()).step_by(stride).collect(),
            norms,
        })
    }

    /// The error at one step alone.
    pub fn of_step(&self, step: usize) -> Result<Self> {
        let size = 3 * self.n_modes;
        Self::new(self.n_modes, &self.coefficients[step * size..][..size])
    }

    /// Number of steps.
    pub fn n_steps(&self) -> usize {
        self.norms.len()
    }

    /// Number of modes.
    pub fn n_modes(&self) -> usize {
        self.n_modes
    }

    /// Not below the error at any step: `|e| max_k |C_k|_2`.
    #[inline]
    pub fn bound(&self, residual: &[f64]) -> f64 {
        squared_norm(residual).sqrt() * self.largest_norm
    }

    /// The largest error over a sample of the steps; at most the exact one.
    #[inline]
    pub fn sampled(&self, residual: &[f64]) -> f64 {
        let squares = self.sampled.iter().map(|&k| self.squared(residual, k));
        squares.fold(0.0, f64::max).sqrt()
    }

    /// The largest error over all steps.
    pub fn exact(&self, residual: &[f64]) -> f64 {
        let squares = (0..self.n_steps()).map(|k| self.squared(residual, k));
        squares.fold(0.0, f64::max).sqrt()
    }

    /// The error at one step.
    pub fn at_step(&self, residual: &[f64], step: usize) -> f64 {
        self.squared(residual, step).sqrt()
    }

    #[inline]
    fn squared(&self, residual: &[f64], step: usize) -> f64 {
        let c = &self.coefficients[step * self.n_modes * 3..][..self.n_modes * 3];
        let mut sum = [0.0; 3];
        for (e, c) in residual.iter().zip(c.as_chunks::<3>().0) {
            for axis in 0..3 {
                sum[axis] += e * c[axis];
            }
        }
        sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]
    }

    /// The mean error over all nodes, from their residuals (N, r) and arms, at the step where that is
    /// largest.
    pub fn largest_mean(&self, residuals: &[f64], arms: &[f64]) -> f64 {
        let r = self.n_modes.max(1);
        let n_nodes = residuals.len() / r;
        let sums = residuals
            .par_chunks(r * MEAN_CHUNK)
            .enumerate()
            .map(|(chunk, nodes)| {
                let mut sums = vec![0.0; self.n_steps()];
                for (i, residual) in nodes.chunks_exact(r).enumerate() {
                    let arm = arm(arms, MEAN_CHUNK * chunk + i);
                    for (step, sum) in sums.iter_mut().enumerate() {
                        *sum += arm * self.at_step(residual, step);
                    }
                }
                sums
            })
            .collect::<Vec<_>>();
        let mean = |step: usize| {
            let total: f64 = sums.iter().map(|sums| sums[step]).sum();
            total / n_nodes.max(1) as f64
        };
        (0..self.n_steps()).map(mean).fold(0.0, f64::max)
    }

    /// The largest error at each step over all nodes, from their residuals (N, r) and arms. Nodes are
    /// taken by falling residual, so that few are looked at in each step.
    pub fn largest_by_step(&self, residuals: &[f64], arms: &[f64]) -> Vec<f64> {
        if self.n_modes == 0 {
            return vec![0.0; self.n_steps()];
        }
        let mut nodes: Vec<(f64, f64, &[f64])> = residuals
            .par_chunks_exact(self.n_modes)
            .enumerate()
            .map(|(node, e)| {
                let arm = arm(arms, node);
                (arm * squared_norm(e).sqrt(), arm, e)
            })
            .collect();
        nodes.par_sort_by(|a, b| b.0.total_cmp(&a.0));
        (0..self.n_steps())
            .map(|k| {
                let mut largest = 0.0;
                for (norm, arm, residual) in &nodes {
                    if norm * self.norms[k] <= largest {
                        break;
                    }
                    largest = f64::max(largest, arm * self.at_step(residual, k));
                }
                largest
            })
            .collect()
    }
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
            assert!(criterion.exact(e) <= criterion.bound(e) * (1.0 + 1e-12));
            assert!(criterion.sampled(e) <= criterion.exact(e));
        }
        for (k, largest) in by_step.iter().enumerate() {
            let brute = residuals.chunks(r).map(|e| criterion.at_step(e, k));
            assert_eq!(*largest, brute.fold(0.0, f64::max));
        }
    }
}
