//! Sweeps over all nodes: the residuals of base points.

use super::criterion::Criterion;
use super::interpolant::Interpolant;
use super::space::Space;
use super::targets::Targets;
use azimesh_core::parallel::{self, BLOCK};
use serde::{Deserialize, Serialize};

/// Sweeps over all nodes, and the residuals of the last one.
pub trait Sweeps {
    /// Finds the residuals of an interpolant.
    fn sweep(&mut self, interpolant: &Interpolant);
    /// Returns the largest error over all nodes and some steps, or `floor` if that is larger.
    fn largest(&mut self, criterion: &Criterion, over: Over, floor: f64) -> f64;
    /// Returns the worst node of each run by the sampled steps, and the residuals there (m, r).
    fn worst(&mut self, criterion: &Criterion) -> (Vec<usize>, Vec<f64>);
    /// Returns the residuals at every node (N, r), by rows.
    fn residuals(&mut self) -> &[f64];
    /// Returns the residuals when no more sweep is made.
    fn take_residuals(&mut self) -> Vec<f64>;
}

/// Nodes of a block in which the largest error is looked for.
const NODES: usize = 1024;
/// A bound times this is a bound in spite of round-off, so skipped nodes never change a result.
const SURE: f64 = 1.0 + 1e-12;

/// The steps at which an error is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Over {
    /// A sample of them.
    Sample,
    /// All.
    Steps,
}

/// Returns the length of about `runs` equal runs of `n` nodes.
pub fn run_length(n: usize, runs: usize) -> usize {
    n.div_ceil(runs).max(1)
}

/// Sweeps in this process.
pub struct LocalSweeps<'a> {
    space: &'a Space,
    targets: Targets<'a>,
    /// Nodes of a run.
    run: usize,
    residuals: Vec<f64>,
}

impl<'a> LocalSweeps<'a> {
    /// Creates sweeps over all points of the targets, with about `runs` candidates.
    pub fn new(space: &'a Space, targets: Targets<'a>, runs: usize) -> Self {
        Self::of_runs(space, targets, run_length(targets.points.len(), runs))
    }

    /// Creates sweeps with runs of `run` nodes.
    pub fn of_runs(space: &'a Space, targets: Targets<'a>, run: usize) -> Self {
        Self {
            space,
            targets,
            run,
            residuals: Vec::new(),
        }
    }

    fn n_modes(&self) -> usize {
        self.targets.criterion.n_modes()
    }

    fn residual(&self, node: usize) -> &[f64] {
        let r = self.n_modes();
        &self.residuals[node * r..][..r]
    }
}

impl Sweeps for LocalSweeps<'_> {
    /// `U - Phi W`; at sliding nodes the part along their normals.
    fn sweep(&mut self, interpolant: &Interpolant) {
        let (space, targets, r) = (self.space, self.targets, self.n_modes());
        self.residuals.clear();
        self.residuals.extend_from_slice(targets.values);
        let residuals = &mut self.residuals;
        if interpolant.n_columns > 0 {
            interpolant.negated().add_at(targets.points, residuals);
        }
        if space.constraints.is_some() && r > 0 {
            parallel::for_blocks(residuals, BLOCK * r, &|first, rows| {
                for (i, residual) in rows.chunks_exact_mut(r).enumerate() {
                    space.project(first / r + i, residual);
                }
            });
        }
    }

    fn largest(&mut self, criterion: &Criterion, over: Over, floor: f64) -> f64 {
        let error = match over {
            Over::Sample => Criterion::sampled,
            Over::Steps => Criterion::exact,
        };
        let n = self.residuals.len() / self.n_modes().max(1);
        let blocks = parallel::map_blocks(n, NODES, &|nodes| {
            nodes.fold(floor, |worst, node| {
                let e = self.residual(node);
                let lever_arms = criterion.arms_of(node, self.targets.lever_arms);
                if SURE * criterion.bound(e, lever_arms) <= worst {
                    worst
                } else {
                    f64::max(worst, error(criterion, e, lever_arms))
                }
            })
        });
        blocks.into_iter().fold(floor, f64::max)
    }

    /// Ties go to the lowest index.
    fn worst(&mut self, criterion: &Criterion) -> (Vec<usize>, Vec<f64>) {
        let n = self.residuals.len() / self.n_modes();
        let images = self.targets.images;
        let worst = parallel::map_blocks(n, self.run, &|nodes| {
            let mut worst = (usize::MAX, -1.0);
            for node in nodes {
                let e = self.residual(node);
                let image = !images.is_empty() && images[node];
                let lever_arms = criterion.arms_of(node, self.targets.lever_arms);
                if !image && criterion.bound(e, lever_arms) > worst.1 {
                    let error = criterion.sampled(e, lever_arms);
                    if error > worst.1 {
                        worst = (node, error);
                    }
                }
            }
            (worst.1 >= 0.0).then_some(worst.0)
        });
        let nodes: Vec<usize> = worst.into_iter().flatten().collect();
        let residuals = nodes.iter().flat_map(|&node| self.residual(node));
        let residuals = residuals.copied().collect();
        (nodes, residuals)
    }

    fn residuals(&mut self) -> &[f64] {
        &self.residuals
    }

    fn take_residuals(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.residuals)
    }
}
