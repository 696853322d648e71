//! Sweeps over the surface that ranks share: each has a run of points along the curve, and what is left there.

use super::Team;
use super::order::Order;
use crate::geometry::vector::Vector;
use crate::ranks::{Ranks, raw};
use crate::rbf::Basis;
use crate::rbf::criterion::Criterion;
use crate::rbf::interpolant::Interpolant;
use crate::rbf::space::Space;
use crate::rbf::sweeps::{Here, Over, Sweeps, run_length};
use crate::rbf::targets::Targets;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What a rank is to do in a selection.
#[derive(Clone, Serialize, Deserialize)]
pub(super) enum SweepOrder {
    /// Take a slab of the surface.
    Begin,
    /// Find the residuals of an interpolant.
    Sweep(Box<Interpolant>),
    /// Tell the largest error.
    Largest {
        criterion: Box<Criterion>,
        over: Over,
        floor: f64,
    },
    /// Tell the worst point of each run.
    Worst(Box<Criterion>),
    /// Give all residuals.
    Residuals,
    /// The selection has ended.
    End,
}

/// Some points of the surface, in its order.
#[derive(Serialize, Deserialize)]
pub(super) struct SurfaceSlab {
    /// The number of the first.
    first: usize,
    /// Points of a run.
    run: usize,
    basis: Basis,
    criterion: Criterion,
    #[serde(with = "raw")]
    points: Vec<Vector>,
    #[serde(with = "raw")]
    values: Vec<f64>,
    images: Vec<bool>,
    #[serde(with = "raw")]
    lever_arms: Vec<f64>,
    /// What the last sweep has found.
    #[serde(skip)]
    residuals: Vec<f64>,
}

/// The points of a rank: whole runs.
fn points_of(n: usize, run: usize, rank: usize, n_ranks: usize) -> Range<usize> {
    let start = |rank: usize| (rank * n.div_ceil(run) / n_ranks * run).min(n);
    start(rank)..start(rank + 1)
}

impl SurfaceSlab {
    fn of(targets: &Targets<'_>, basis: Basis, run: usize, points: Range<usize>) -> Self {
        fn rows<T: Copy>(values: &[T], points: &Range<usize>, n: usize) -> Vec<T> {
            match values.is_empty() {
                true => Vec::new(),
                false => values[points.start * n..points.end * n].to_vec(),
            }
        }
        let criterion = targets.criterion.clone();
        Self {
            first: points.start,
            run,
            basis,
            points: rows(targets.points, &points, 1),
            values: rows(targets.values, &points, criterion.n_modes()),
            images: rows(targets.images, &points, 1),
            lever_arms: rows(targets.lever_arms, &points, criterion.n_parts()),
            criterion,
            residuals: Vec::new(),
        }
    }

    /// Does `work` with the sweeps over these points.
    fn with<T>(&mut self, work: impl FnOnce(&mut Here<'_>) -> T) -> T {
        let space = Space::radial(self.basis);
        let targets = Targets {
            points: &self.points,
            values: &self.values,
            criterion: &self.criterion,
            images: &self.images,
            lever_arms: &self.lever_arms,
        };
        let residuals = std::mem::take(&mut self.residuals);
        let mut sweeps = Here::of_runs(&space, targets, self.run).after(residuals);
        let done = work(&mut sweeps);
        self.residuals = sweeps.take_residuals();
        done
    }

    /// Does what is ordered; all ranks do it at once. Gives what came out of it for all of them.
    fn serve(&mut self, order: &SweepOrder, ranks: &Ranks) -> Told {
        match order {
            SweepOrder::Begin | SweepOrder::Residuals | SweepOrder::End => Told::Nothing,
            SweepOrder::Sweep(interpolant) => {
                ranks.together(|| self.with(|sweeps| sweeps.sweep(interpolant)));
                Told::Nothing
            }
            SweepOrder::Largest {
                criterion,
                over,
                floor,
            } => {
                let largest = |sweeps: &mut Here<'_>| sweeps.largest(criterion, *over, *floor);
                let own = ranks.together(|| self.with(largest));
                Told::Largest(ranks.all(own).into_iter().fold(*floor, f64::max))
            }
            SweepOrder::Worst(criterion) => {
                let own = ranks.together(|| self.with(|sweeps| sweeps.worst(criterion)));
                let nodes: Vec<usize> = own.0.iter().map(|node| self.first + node).collect();
                let (nodes, residuals): (Vec<_>, Vec<_>) =
                    ranks.all((nodes, own.1)).into_iter().unzip();
                Told::Worst(nodes.concat(), residuals.concat())
            }
        }
    }
}

/// What all ranks have found.
enum Told {
    Nothing,
    Largest(f64),
    Worst(Vec<usize>, Vec<f64>),
}

/// Does on another rank than the first what that orders.
pub(super) fn serve(slab: &mut Option<SurfaceSlab>, order: &SweepOrder, ranks: &Ranks) {
    match (order, slab) {
        (SweepOrder::Begin, slab) => *slab = Some(ranks.scatter(&mut |_| None)),
        (SweepOrder::End, slab) => *slab = None,
        (_, None) => unreachable!("a selection begins before it sweeps"),
        (SweepOrder::Residuals, Some(slab)) => ranks.send_part(&slab.residuals),
        (order, Some(slab)) => drop(slab.serve(order, ranks)),
    }
}

/// Sweeps of a selection, ordered by the first rank.
pub(crate) struct SharedSweeps<'a> {
    team: &'a Team,
    own: SurfaceSlab,
    /// The points of each rank.
    slabs: Vec<Range<usize>>,
    /// The residuals of all, once they are asked for.
    residuals: Vec<f64>,
}

impl Team {
    /// Sweeps over all points of targets without constraints, with about `runs` candidates.
    pub(crate) fn sweeps(
        &self,
        targets: &Targets<'_>,
        basis: Basis,
        runs: usize,
    ) -> SharedSweeps<'_> {
        let (n, n_ranks) = (targets.points.len(), self.ranks.n());
        let run = run_length(n, runs);
        let slab = |rank: usize| points_of(n, run, rank, n_ranks);
        let _alone = self.state();
        self.order(Order::Select(SweepOrder::Begin));
        let slab_of = |rank: usize| Some(SurfaceSlab::of(targets, basis, run, slab(rank)));
        SharedSweeps {
            team: self,
            own: self.ranks.scatter(&mut |rank| slab_of(rank)),
            slabs: (0..n_ranks).map(slab).collect(),
            residuals: Vec::new(),
        }
    }
}

impl SharedSweeps<'_> {
    fn order(&mut self, order: SweepOrder) -> Told {
        let _alone = self.team.state();
        self.team.order(Order::Select(order.clone()));
        self.own.serve(&order, &self.team.ranks)
    }
}

impl Sweeps for SharedSweeps<'_> {
    fn sweep(&mut self, interpolant: &Interpolant) {
        self.residuals.clear();
        self.order(SweepOrder::Sweep(Box::new(interpolant.clone())));
    }

    fn largest(&mut self, criterion: &Criterion, over: Over, floor: f64) -> f64 {
        let criterion = Box::new(criterion.clone());
        let told = self.order(SweepOrder::Largest {
            criterion,
            over,
            floor,
        });
        match told {
            Told::Largest(largest) => largest,
            _ => floor,
        }
    }

    fn worst(&mut self, criterion: &Criterion) -> (Vec<usize>, Vec<f64>) {
        match self.order(SweepOrder::Worst(Box::new(criterion.clone()))) {
            Told::Worst(nodes, residuals) => (nodes, residuals),
            _ => Default::default(),
        }
    }

    fn residuals(&mut self) -> &[f64] {
        if self.residuals.is_empty() {
            let _alone = self.team.state();
            self.team.order(Order::Select(SweepOrder::Residuals));
            let r = self.own.criterion.n_modes();
            let n = self.slabs.last().map_or(0, |slab| slab.end);
            let mut all = vec![0.0; n * r];
            let mut rest = &mut all[..];
            let mut parts = Vec::new();
            for slab in &self.slabs {
                let (part, others) = rest.split_at_mut(slab.len() * r);
                parts.push(part);
                rest = others;
            }
            parts[0].copy_from_slice(&self.own.residuals);
            self.team.ranks.receive_parts(&mut parts);
            self.residuals = all;
        }
        &self.residuals
    }

    fn take_residuals(&mut self) -> Vec<f64> {
        self.residuals();
        std::mem::take(&mut self.residuals)
    }
}

impl Drop for SharedSweeps<'_> {
    fn drop(&mut self) {
        self.order(SweepOrder::End);
    }
}
