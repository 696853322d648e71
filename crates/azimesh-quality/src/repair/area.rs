//! A part of a mesh whose nodes are moved in the same way at many positions of the mesh.
//!
//! [`untangle`](super::untangle) moves as few nodes as possible, and stops as soon as cells are valid: results may differ
//! strongly for nearly equal positions. An area is the same for all positions, and its functional is minimised to
//! convergence: its nodes then move as smoothly as the positions do.

use super::nearby::Nearby;
use super::newton::minimise;
use super::regions::{self, Region};
use super::solve::{GROSS, PatchTargets, Weights, patch, start_from_rim};
use super::{PatchLog, Repaired, Task, between_of, still_invalid};
use crate::validity::{Proof, invalid};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::parallel;
use azimesh_core::progress::Stop;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Newton steps of a region.
const MOST_STEPS: usize = 200;
/// A region has converged when a step lowers the functional by less than this part.
const SETTLED: f64 = 1e-7;

/// Folded or low cells of several positions of a mesh.
#[derive(Debug, Clone, Default)]
pub struct FoldedCells {
    pub(super) cells: BTreeSet<u32>,
    /// Cells that have become worse: they move too where a region has one of `cells`.
    pub(super) worse: BTreeSet<u32>,
}

/// Number of cells that are not valid at some positions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Count {
    /// Cells with a Jacobian that is not positive.
    pub inverted: usize,
    /// Cells neither proven nor refuted.
    pub unproven: usize,
}

impl Count {
    /// Both.
    pub fn all(self) -> usize {
        self.inverted + self.unproven
    }
}

impl FoldedCells {
    /// Adds the cells that are not valid at `points`; returns their number.
    pub fn add(&mut self, task: Task<'_>, points: &[Vector]) -> Count {
        let found = invalid(task.mesh, points, task.reference);
        self.cells.extend(found.iter().map(|entry| entry.0));
        let unproven = found.iter().filter(|entry| entry.1 == Proof::Unproven);
        let unproven = unproven.count();
        Count {
            inverted: found.len() - unproven,
            unproven,
        }
    }
}

/// Regions that are the same at all positions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Area {
    pub(super) regions: Vec<Region>,
    /// Cells with simplices between their corners: whichever was folded.
    between: BTreeSet<u32>,
    /// Cells that become regular, whatever the reference.
    regular: BTreeSet<u32>,
    weights: Weights,
    rings: usize,
}

impl Area {
    /// A number of rings of neighbours around folded cells.
    pub fn around(task: Task<'_>, folded: &FoldedCells, rings: usize) -> Self {
        let seeds: Vec<u32> = folded.cells.union(&folded.worse).copied().collect();
        let mut regions = match super::refused(task.mesh) {
            Some(_) => Vec::new(),
            None => regions::around(&Nearby::new(task.mesh), task.freedom, &seeds, rings).0,
        };
        let is_wanted = |seed: &u32| folded.cells.contains(seed);
        regions.retain(|region| region.seeds.iter().any(is_wanted));
        Self {
            regions,
            between: folded.cells.clone(),
            rings,
            ..Self::default()
        }
    }

    /// To improve valid cells, and make some regular.
    pub(super) fn improving(mut self, weights: Weights, regular: &BTreeSet<u32>) -> Self {
        (self.regular, self.weights) = (regular.clone(), weights);
        self
    }

    /// Nodes that may move.
    pub(super) fn n_nodes(&self) -> usize {
        self.regions.iter().map(|region| region.moving.len()).sum()
    }

    /// Returns whether the nodes of each region are all in one region of another area.
    pub(super) fn covers_no_more_than(&self, other: &Self) -> bool {
        let has = |region: &Region| other.regions.iter().any(|of| of.moving == region.moving);
        self.regions.iter().all(has)
    }

    /// Also uses simplices between the corners for cells that are folded between valid corners at `points`; returns whether
    /// there were new ones.
    pub fn look_between(&mut self, task: Task<'_>, points: &[Vector]) -> bool {
        let n_before = self.between.len();
        for region in &self.regions {
            let found = still_invalid(task, &region.cells, points);
            self.between.extend(between_of(&found));
        }
        self.between.len() > n_before
    }

    /// Moves the nodes of the area to the minimum of its functional, which makes its cells valid unless the area is too small.
    /// The result is the same on any number of threads.
    ///
    /// # Errors
    /// If `stop` was requested.
    pub fn relax(&self, task: Task<'_>, points: &mut [Vector], stop: &Stop) -> Result<Repaired> {
        let relaxed = parallel::try_map(self.regions.len(), &|i| {
            self.relax_region(task, &self.regions[i], points, stop)
        })?;
        let mut repaired = Repaired::default();
        for (region, (mut log, moved)) in self.regions.iter().zip(relaxed) {
            let before: Vec<Vector> = moved
                .iter()
                .map(|(node, _)| points[*node as usize])
                .collect();
            for &(node, place) in &moved {
                log.largest_move = log.largest_move.max(distance(points[node as usize], place));
                points[node as usize] = place;
            }
            log.invalid = still_invalid(task, &region.cells, points).len();
            if log.invalid > log.invalid_before {
                for (&(node, _), place) in moved.iter().zip(before) {
                    points[node as usize] = place;
                }
                (log.invalid, log.largest_move, log.least) =
                    (log.invalid_before, 0.0, log.least_before);
            }
            repaired.patches.push(log);
        }
        Ok(repaired)
    }

    fn relax_region(
        &self,
        task: Task<'_>,
        region: &Region,
        points: &[Vector],
        stop: &Stop,
    ) -> Result<(PatchLog, Vec<(u32, Vector)>)> {
        let wishes = PatchTargets {
            between: &self.between,
            regular: &self.regular,
            weights: self.weights,
        };
        let found = still_invalid(task, &region.cells, points);
        let first = found.first().map(|entry| entry.0);
        let first = first.or(region.seeds.first().copied());
        let (mut patch, _) = patch(task, region, points, wishes);
        let least_before = patch.state(1e-9, &patch.places).least;
        if least_before < GROSS {
            start_from_rim(task, &mut patch);
        }
        let course = minimise(&mut patch, MOST_STEPS, Some(SETTLED), stop)?;
        let log = PatchLog {
            invalid_before: found.len(),
            first_cell: first.unwrap_or(0) as usize,
            n_cells: region.cells.len(),
            n_nodes: region.moving.len(),
            rings: self.rings,
            steps: course.steps,
            iterations: course.iterations,
            least_before,
            least: course.state.least,
            ..PatchLog::default()
        };
        Ok((log, patch.moved_nodes().collect()))
    }
}
