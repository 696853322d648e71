//! Sweeps of a selection over the surface: each rank sweeps a range of the points.

use azimesh_core::ranks::Ranks;
use azimesh_rbf::criterion::Criterion;
use azimesh_rbf::interpolant::Interpolant;
use azimesh_rbf::space::Space;
use azimesh_rbf::sweeps::{LocalSweeps, Over, Sweeps, run_length};
use azimesh_rbf::targets::Targets;
use std::ops::Range;

/// Sweeps over the surface. Each rank has a range of the points, in whole runs. All ranks call each function together and
/// get the same results.
pub(crate) struct RankSweeps<'a> {
    own: LocalSweeps<'a>,
    /// Index of the first point of this rank.
    first: usize,
    ranks: Ranks,
    /// The residuals of all ranks, once they are collected. A single rank does not copy its own.
    all: Vec<f64>,
}

impl<'a> RankSweeps<'a> {
    /// Creates sweeps over all points of the targets, with about `candidates` runs. The space has no constraints.
    pub fn new(space: &'a Space, targets: Targets<'a>, candidates: usize, ranks: &Ranks) -> Self {
        let n = targets.points.len();
        let run = run_length(n, candidates);
        let own = points_of(n, run, ranks);
        let criterion = targets.criterion;
        let part = Targets {
            points: &targets.points[own.clone()],
            values: rows(targets.values, &own, criterion.n_modes()),
            criterion,
            images: rows(targets.images, &own, 1),
            lever_arms: rows(targets.lever_arms, &own, criterion.n_parts()),
        };
        Self {
            own: LocalSweeps::of_runs(space, part, run),
            first: own.start,
            ranks: ranks.clone(),
            all: Vec::new(),
        }
    }

    fn is_alone(&self) -> bool {
        self.ranks.n() == 1
    }
}

/// Returns the points of this rank: whole runs, evenly spread over the ranks.
fn points_of(n: usize, run: usize, ranks: &Ranks) -> Range<usize> {
    let start = |rank: usize| (rank * n.div_ceil(run) / ranks.n() * run).min(n);
    start(ranks.rank())..start(ranks.rank() + 1)
}

/// Returns the values of some points, `n` for each; empty values stay empty.
fn rows<'a, T>(values: &'a [T], points: &Range<usize>, n: usize) -> &'a [T] {
    if values.is_empty() {
        values
    } else {
        &values[points.start * n..points.end * n]
    }
}

impl Sweeps for RankSweeps<'_> {
    fn sweep(&mut self, interpolant: &Interpolant) {
        self.all.clear();
        self.own.sweep(interpolant);
    }

    fn largest(&mut self, criterion: &Criterion, over: Over, floor: f64) -> f64 {
        let largest = self.own.largest(criterion, over, floor);
        self.ranks
            .allgather(largest)
            .into_iter()
            .fold(floor, f64::max)
    }

    fn worst(&mut self, criterion: &Criterion) -> (Vec<usize>, Vec<f64>) {
        let (mut nodes, residuals) = self.own.worst(criterion);
        nodes.iter_mut().for_each(|node| *node += self.first);
        if self.is_alone() {
            return (nodes, residuals);
        }
        let (nodes, residuals): (Vec<_>, Vec<_>) =
            self.ranks.allgather((nodes, residuals)).into_iter().unzip();
        (nodes.concat(), residuals.concat())
    }

    fn residuals(&mut self) -> &[f64] {
        if self.is_alone() {
            return self.own.residuals();
        }
        if self.all.is_empty() {
            self.all = self.ranks.all_numbers(self.own.residuals());
        }
        &self.all
    }

    fn take_residuals(&mut self) -> Vec<f64> {
        if self.is_alone() {
            return self.own.take_residuals();
        }
        self.residuals();
        std::mem::take(&mut self.all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::vector::Vector;
    use azimesh_core::ranks::on_threads;
    use azimesh_rbf::select::{Limits, Measure, Selection, select, select_by};
    use azimesh_rbf::{Basis, Kernel};

    /// A strip that bends and twists, with modes of two parts.
    struct Example {
        points: Vec<Vector>,
        values: Vec<f64>,
        criterion: Criterion,
        images: Vec<bool>,
        lever_arms: Vec<f64>,
        space: Space,
    }

    impl Example {
        fn new(n: usize) -> Self {
            let at = |i: usize| i as f64 / n as f64;
            let point = |i: usize| [4.0 * at(i), (i as f64 * 1.7).sin() * 0.3, 0.1 * at(i)];
            let values = |i: usize| {
                [
                    at(i).powi(2),
                    (7.0 * at(i)).sin(),
                    0.3 * (19.0 * at(i)).cos(),
                ]
            };
            let step = |k: usize| {
                let turn = k as f64 * 0.21;
                [
                    turn.sin(),
                    0.0,
                    turn.cos(),
                    0.2,
                    turn,
                    0.0,
                    0.0,
                    1.0,
                    turn.cos(),
                ]
            };
            let coefficients: Vec<f64> = (0..60).flat_map(step).collect();
            Self {
                points: (0..n).map(point).collect(),
                values: (0..n).flat_map(values).collect(),
                criterion: Criterion::of_parts(3, &coefficients, vec![0..2, 2..3])
                    .expect("it is finite"),
                images: (0..n).map(|i| i % 11 == 5).collect(),
                lever_arms: (0..n).flat_map(|i| [1.0, 0.5 + at(i)]).collect(),
                space: Space::radial(Basis {
                    kernel: Kernel::WendlandC2,
                    radius: 1.5,
                }),
            }
        }

        fn targets(&self) -> Targets<'_> {
            Targets {
                points: &self.points,
                values: &self.values,
                criterion: &self.criterion,
                images: &self.images,
                lever_arms: &self.lever_arms,
            }
        }
    }

    fn bits(values: &[f64]) -> Vec<u64> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    type Sweep = (usize, f64);

    fn facts(found: &Selection, sweeps: &[Sweep]) -> (Vec<usize>, Vec<Vec<u64>>, Vec<usize>) {
        let (counts, errors): (Vec<usize>, Vec<f64>) =
            found.history.iter().chain(sweeps).copied().unzip();
        let numbers = [
            &found.residuals[..],
            &found.interpolant.weights,
            &found.picked,
            &errors,
            &[found.error, found.measured],
        ];
        let skipped = vec![found.skipped];
        let counts = [counts, skipped].concat();
        (found.base.clone(), numbers.map(bits).to_vec(), counts)
    }

    #[test]
    fn ranks_select_the_very_base_points_of_one() {
        let example = Example::new(400);
        for (candidates, measure) in [(40, Measure::Max), (3, Measure::Mean), (1, Measure::Max)] {
            let limits = Limits {
                tolerance: 2e-3,
                measure,
                max_points: 60,
                candidates,
                fall: 0.4,
            };
            let mut sweeps = Vec::new();
            let mut say = |n: usize, error: f64| sweeps.push((n, error));
            let alone = select(&example.space, example.targets(), limits, &mut say)
                .expect("it can be solved");
            assert!(alone.base.len() > 20 && alone.history.len() > 2);
            let wanted = facts(&alone, &sweeps);
            for n in [1, 2, 3, 5] {
                let found = on_threads(n, |ranks| {
                    let (space, targets) = (&example.space, example.targets());
                    let mut own = RankSweeps::new(space, targets, candidates, &ranks);
                    let mut sweeps = Vec::new();
                    let mut say = |n: usize, error: f64| sweeps.push((n, error));
                    let found = select_by(&mut own, space, targets, limits, &mut say)
                        .expect("it can be solved");
                    facts(&found, &sweeps)
                });
                for found in found {
                    assert!(found == wanted, "{candidates} candidates, {n} ranks");
                }
            }
        }
    }

    #[test]
    fn residuals_of_all_ranks_follow_each_sweep() {
        let example = Example::new(50);
        let interpolants = [vec![3, 40], vec![1, 20, 33, 48]].map(|base: Vec<usize>| {
            let values: Vec<f64> = (base.iter())
                .flat_map(|&at| &example.values[3 * at..][..3])
                .copied()
                .collect();
            (example.space)
                .interpolant(&example.points, &base, &values)
                .expect("it can be solved")
        });
        let residuals = |ranks: &Ranks| {
            let mut sweeps = RankSweeps::new(&example.space, example.targets(), 7, ranks);
            let mut all = Vec::new();
            for interpolant in &interpolants {
                sweeps.sweep(interpolant);
                all.push(bits(sweeps.residuals()));
                all.push(bits(sweeps.residuals()));
            }
            all.push(bits(&sweeps.take_residuals()));
            all
        };
        let wanted = residuals(&Ranks::alone());
        assert_eq!(wanted[0].len(), 150);
        assert_ne!(wanted[0], wanted[2]);
        for n in [2, 5] {
            let found = on_threads(n, |ranks| residuals(&ranks));
            assert!(found.into_iter().all(|found| found == wanted));
        }
    }
}
