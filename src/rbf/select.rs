//! Chooses base points greedily, in rounds. Knows surface nodes and modes; nothing of rotors or
//! files.
//!
//! A sweep finds the residual at every node; the worst node of each run along a space-filling curve
//! is a candidate; the exact greedy picks among the candidates until their worst error has fallen
//! to a part of the round's first. The last sweep has verified the tolerance on every node.
//!
//! Source: Sheng and Allen, AIAA Journal 51(3), 2013 (one point a sweep); the rounds, the Newton
//! basis (Mueller and Schaback, J. Approx. Theory 161, 2009) and the criterion over all steps go
//! beyond it.

use super::criterion::Criterion;
use super::evaluate::WeightedBase;
use super::newton::Candidates;
use super::{Basis, system};
use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::linear::{GrowingCholesky, Matrix};
use rayon::prelude::*;

/// What the base points are to reproduce. Points are in the order of a space-filling curve, no two
/// at the same place.
#[derive(Debug, Clone, Copy)]
pub struct Targets<'a> {
    /// Surface nodes, N of them.
    pub points: &'a [Vector],
    /// Values of the modes there (N, r), by rows.
    pub values: &'a [f64],
    /// The error over all steps.
    pub criterion: &'a Criterion,
}

/// When the selection ends, and how many nodes a round looks at.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Displacement error allowed at any node and step, in mesh units.
    pub tolerance: f64,
    /// Most base points.
    pub max_points: usize,
    /// Candidates of a round; 1 is the plain greedy, a sweep for every point.
    pub candidates: usize,
    /// A round ends when the candidates' worst error is this part of its first.
    pub fall: f64,
}

impl Limits {
    /// A candidate for every 16 of `n_nodes`, 512 to 4096 of them; rounds that end at 0.4 of their
    /// first error.
    pub fn in_rounds(tolerance: f64, max_points: usize, n_nodes: usize) -> Self {
        Self {
            tolerance,
            max_points,
            candidates: (n_nodes / 16).clamp(512, 4096),
            fall: 0.4,
        }
    }
}

/// Chosen base points with their weights, and what is left at every node.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Indices into the targets' points, in the order chosen.
    pub base: Vec<usize>,
    /// Weights (n, r), by rows.
    pub weights: Vec<f64>,
    /// Residual of the modes at every node (N, r), by rows.
    pub residuals: Vec<f64>,
    /// Largest error at any node and step, in mesh units.
    pub error: f64,
    /// Number of base points and largest error at each sweep.
    pub history: Vec<(usize, f64)>,
    /// Candidates passed over because they lie too close to base points.
    pub skipped: usize,
}

/// Chooses base points until the largest error is at or below the tolerance, `max_points` is
/// reached or nothing is left to add; `Selection::error` tells.
///
/// Rounds x N n kernel evaluations, candidates x n^2 multiply-adds. `progress` hears of every sweep
/// as (base points, error).
pub fn select(
    basis: Basis,
    targets: Targets<'_>,
    limits: Limits,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<Selection> {
    let mut base: Vec<usize> = Vec::new();
    if targets.criterion.n_modes() == 0 {
        return finish(basis, targets, base, vec![(0, 0.0)], 0);
    }
    let mut factor = GrowingCholesky::default();
    let mut history = Vec::new();
    let mut skipped = 0;
    loop {
        let weights = weights_from(&factor, &targets, &base);
        let residuals = residuals(basis, targets, &base, &weights);
        let error = largest_error(targets.criterion, &residuals, limits.tolerance);
        history.push((base.len(), error));
        progress(base.len(), error);
        let before = base.len();
        if error > limits.tolerance && before < limits.max_points {
            let nodes = worst_of_runs(targets.criterion, &residuals, limits.candidates);
            let mut round = Candidates::new(basis, targets, &base, &factor, &residuals, &nodes);
            let stop = (error * limits.fall).max(0.95 * limits.tolerance);
            round.pick(stop, limits.max_points, &mut base, &mut factor);
            skipped += round.skipped();
        }
        if base.len() == before {
            return finish(basis, targets, base, history, skipped);
        }
    }
}

/// The selection with weights solved as any later run from the same base points solves them.
fn finish(
    basis: Basis,
    targets: Targets<'_>,
    base: Vec<usize>,
    history: Vec<(usize, f64)>,
    skipped: usize,
) -> Result<Selection> {
    let points: Vec<Vector> = base.iter().map(|&i| targets.points[i]).collect();
    let weights = system::weights(basis, &points, &targets.values_at(&base))?;
    let residuals = residuals(basis, targets, &base, &weights);
    let error = largest_error(targets.criterion, &residuals, 0.0);
    Ok(Selection {
        base,
        weights,
        residuals,
        error,
        history,
        skipped,
    })
}

/// The selection that given base points make: weights, residuals and error.
pub fn from_base(basis: Basis, targets: Targets<'_>, base: Vec<usize>) -> Result<Selection> {
    finish(basis, targets, base, Vec::new(), 0)
}

impl Targets<'_> {
    fn values_at(&self, nodes: &[usize]) -> Vec<f64> {
        let r = self.criterion.n_modes();
        nodes
            .iter()
            .flat_map(|&i| &self.values[i * r..(i + 1) * r])
            .copied()
            .collect()
    }
}

fn weights_from(factor: &GrowingCholesky, targets: &Targets<'_>, base: &[usize]) -> Vec<f64> {
    let r = targets.criterion.n_modes();
    let values = targets.values_at(base);
    let mut solution = Matrix::from_fn(base.len(), r, |i, j| values[i * r + j]);
    factor.solve_lower(&mut solution);
    factor.solve_transposed(&mut solution);
    (0..values.len())
        .map(|at| solution[(at / r, at % r)])
        .collect()
}

/// `U - Phi W` at every node (N, r).
fn residuals(basis: Basis, targets: Targets<'_>, base: &[usize], weights: &[f64]) -> Vec<f64> {
    let points: Vec<Vector> = base.iter().map(|&i| targets.points[i]).collect();
    let negative: Vec<f64> = weights.iter().map(|w| -w).collect();
    let mut residuals = targets.values.to_vec();
    WeightedBase {
        basis,
        points: &points,
        weights: &negative,
        n_columns: targets.criterion.n_modes(),
    }
    .add_at(targets.points, &mut residuals);
    residuals
}

/// The largest error over all nodes and steps. Above `tolerance` an estimate over a sample of the
/// steps serves; at or below it the value is exact.
fn largest_error(criterion: &Criterion, residuals: &[f64], tolerance: f64) -> f64 {
    let r = criterion.n_modes().max(1);
    let largest = |error: fn(&Criterion, &[f64], f64) -> f64, floor: f64| {
        residuals
            .par_chunks(r * 1024)
            .map(|nodes| {
                let errors = nodes.chunks_exact(r);
                errors.fold(floor, |worst, e| error(criterion, e, worst).max(worst))
            })
            .reduce(|| floor, f64::max)
    };
    let estimate = largest(sampled_above, 0.0);
    if estimate > tolerance && tolerance > 0.0 {
        return estimate;
    }
    largest(exact_above, estimate)
}

fn sampled_above(criterion: &Criterion, residual: &[f64], worst: f64) -> f64 {
    if criterion.bound(residual) <= worst {
        return 0.0;
    }
    criterion.sampled(residual)
}

fn exact_above(criterion: &Criterion, residual: &[f64], worst: f64) -> f64 {
    if criterion.bound(residual) <= worst {
        return 0.0;
    }
    criterion.exact(residual)
}

/// The worst node of each of about `runs` equal runs of nodes; ties to the lowest index.
fn worst_of_runs(criterion: &Criterion, residuals: &[f64], runs: usize) -> Vec<usize> {
    let r = criterion.n_modes();
    let n = residuals.len() / r;
    let length = n.div_ceil(runs).max(1);
    residuals
        .par_chunks(length * r)
        .enumerate()
        .map(|(run, residuals)| {
            let mut worst = (0, -1.0);
            for (i, e) in residuals.chunks_exact(r).enumerate() {
                if criterion.bound(e) > worst.1 {
                    let error = criterion.sampled(e);
                    if error > worst.1 {
                        worst = (i, error);
                    }
                }
            }
            run * length + worst.0
        })
        .collect()
}
