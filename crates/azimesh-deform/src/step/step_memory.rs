//! Stored results of steps of a deformation: their quality before any repair, windows of repaired steps, and positions in
//! substeps until the steps of their window are repaired. Velocities need neighbours, so the last repaired positions are
//! stored too.
//!
//! All of it can be recomputed: it saves time and never changes a result. No lock is held during computations.

use super::positions::Positions;
use super::repair::CellsToRepair;
use super::window::Window;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::in_32_bits;
use azimesh_quality::Summary;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Number of repaired steps whose positions are stored: a step and its neighbours.
const KEPT: usize = 3;
/// Largest size in bytes of stored positions in substeps.
pub(crate) const STARTS: usize = 64 << 20;

/// Rounding of coordinates in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rounding {
    /// No rounding.
    None,
    /// To 32 bits.
    Single,
}

impl Rounding {
    /// Rounds coordinates.
    pub fn apply(self, points: &mut [Vector]) {
        if self == Self::Single {
            parallel::update(points, |_, x| *x = in_32_bits(*x));
        }
    }
}

/// A repaired step.
pub(crate) struct RepairedStep {
    pub step: usize,
    pub points: Vec<Vector>,
    pub found: Positions,
}

/// A folded step of a window before its repair.
#[derive(Clone)]
pub(crate) struct Start {
    pub points: Vec<Vector>,
    pub selection_error: f64,
}

/// Stored results of the steps for one rounding of their coordinates.
#[derive(Default)]
pub(crate) struct StepMemory {
    verdicts: Mutex<BTreeMap<usize, (Summary, CellsToRepair)>>,
    windows: Mutex<Vec<Arc<Window>>>,
    repaired: Mutex<VecDeque<Arc<RepairedStep>>>,
    /// By whether the window improves cells, and the step.
    starts: Mutex<BTreeMap<(bool, usize), Start>>,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl StepMemory {
    /// Returns the quality of a step before any repair.
    pub fn verdict(&self, step: usize) -> Option<Summary> {
        let verdicts = lock(&self.verdicts);
        verdicts.get(&step).map(|verdict| verdict.0.clone())
    }

    /// Which cells of a step need a repair.
    pub fn repair_count(&self, step: usize) -> Option<CellsToRepair> {
        lock(&self.verdicts).get(&step).map(|verdict| verdict.1)
    }

    pub fn keep_verdict(&self, step: usize, cells: &Summary, repair_count: CellsToRepair) {
        lock(&self.verdicts).insert(step, (cells.clone(), repair_count));
    }

    /// Returns the window of a step that improves cells or not, if it was found.
    pub fn window(&self, improves: bool, step: usize) -> Option<Arc<Window>> {
        let windows = lock(&self.windows);
        let of_step =
            |window: &&Arc<Window>| window.improves == improves && window.steps.contains(&step);
        windows.iter().find(of_step).cloned()
    }

    pub fn keep_window(&self, window: &Arc<Window>) {
        let mut windows = lock(&self.windows);
        let key = |window: &Window| (window.improves, window.steps.clone());
        if !windows.iter().any(|known| key(known) == key(window)) {
            windows.push(Arc::clone(window));
        }
    }

    /// Stores a step before its repair, if it fits in `STARTS`: on all ranks or on none. The mesh has `n_nodes`.
    pub fn keep_start(
        &self,
        step: (bool, usize),
        n_nodes: usize,
        points: &[Vector],
        selection_error: f64,
    ) {
        let mut starts = lock(&self.starts);
        if (starts.len() + 1) * n_nodes * size_of::<Vector>() <= STARTS {
            let points = points.to_vec();
            starts.insert(
                step,
                Start {
                    points,
                    selection_error,
                },
            );
        }
    }

    /// Copies a stored step before its repair to `points`; returns its error.
    pub fn copy_start(&self, step: (bool, usize), points: &mut [Vector]) -> Option<f64> {
        let starts = lock(&self.starts);
        let start = starts.get(&step)?;
        points.copy_from_slice(&start.points);
        Some(start.selection_error)
    }

    /// Removes and returns a stored step before its repair.
    pub fn take_start(&self, step: (bool, usize)) -> Option<Start> {
        lock(&self.starts).remove(&step)
    }

    /// Returns a repaired step, if it is one of the last.
    pub fn repaired(&self, step: usize) -> Option<Arc<RepairedStep>> {
        let repaired = lock(&self.repaired);
        repaired.iter().find(|known| known.step == step).cloned()
    }

    pub fn keep_repaired(&self, step: RepairedStep) {
        let mut repaired = lock(&self.repaired);
        repaired.retain(|known| known.step != step.step);
        repaired.push_back(Arc::new(step));
        if repaired.len() > KEPT {
            repaired.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_kept_as_long_as_there_is_room_and_given_once() {
        let memory = StepMemory::default();
        let points = vec![[1.0, 2.0, 3.0]; STARTS / 24 / 2];
        for step in [4, 5, 6] {
            memory.keep_start((false, step), points.len(), &points, 0.5);
        }
        assert!(memory.take_start((false, 6)).is_none());
        assert!(memory.take_start((true, 4)).is_none());
        let start = memory
            .take_start((false, 4))
            .expect("there was room for two");
        assert_eq!((start.points, start.selection_error), (points, 0.5));
        assert!(memory.take_start((false, 4)).is_none());
    }
}
