//! What is found of the steps of a deformation, and kept: how good they are before any repair, windows of repaired steps,
//! positions in substeps that a window was found from until its steps are repaired, and, where velocities need their
//! neighbours, the last repaired positions.
//!
//! All of it can be found again: what is kept saves time and decides nothing. No lock is held while something is computed.

use super::positions::Positions;
use super::repair::n_not_valid;
use super::window::Window;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::in_32_bits;
use azimesh_quality::Summary;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Repaired steps whose positions are kept: a step and its neighbours.
const KEPT: usize = 3;
/// Bytes of positions in substeps that are kept at most.
pub(crate) const STARTS: usize = 64 << 20;

/// What coordinates become in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rounding {
    /// They stay what they are.
    None,
    /// Numbers of 32 bits.
    Single,
}

impl Rounding {
    /// Makes coordinates what they will be.
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

/// What is kept of the steps for one rounding of their coordinates.
#[derive(Default)]
pub(crate) struct StepMemory {
    verdicts: Mutex<BTreeMap<usize, Summary>>,
    windows: Mutex<Vec<Arc<Window>>>,
    repaired: Mutex<VecDeque<Arc<RepairedStep>>>,
    starts: Mutex<BTreeMap<usize, Start>>,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl StepMemory {
    /// The quality of a step before any repair.
    pub fn verdict(&self, step: usize) -> Option<Summary> {
        lock(&self.verdicts).get(&step).cloned()
    }

    /// How many cells of a step are not valid, or not proven to be so, before any repair.
    pub fn folded(&self, step: usize) -> Option<usize> {
        let verdicts = lock(&self.verdicts);
        verdicts.get(&step).map(n_not_valid)
    }

    pub fn keep_verdict(&self, step: usize, cells: &Summary) {
        lock(&self.verdicts).insert(step, cells.clone());
    }

    /// The window of a step, where one was found.
    pub fn window(&self, step: usize) -> Option<Arc<Window>> {
        let windows = lock(&self.windows);
        let window = windows.iter().find(|window| window.steps.contains(&step));
        window.cloned()
    }

    pub fn keep_window(&self, window: &Arc<Window>) {
        let mut windows = lock(&self.windows);
        if !windows.iter().any(|known| known.steps == window.steps) {
            windows.push(Arc::clone(window));
        }
    }

    /// Keeps a step before its repair, as long as there is room for it: on all ranks or on none. The mesh has `n_nodes`.
    pub fn keep_start(&self, step: usize, n_nodes: usize, points: &[Vector], selection_error: f64) {
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

    /// Copies a step before its repair to `points`, where it was kept; gives its error.
    pub fn copy_start(&self, step: usize, points: &mut [Vector]) -> Option<f64> {
        let starts = lock(&self.starts);
        let start = starts.get(&step)?;
        points.copy_from_slice(&start.points);
        Some(start.selection_error)
    }

    /// A step before its repair, where it was kept, which it is no more then.
    pub fn take_start(&self, step: usize) -> Option<Start> {
        lock(&self.starts).remove(&step)
    }

    /// A repaired step, where it is one of the last.
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
            memory.keep_start(step, points.len(), &points, 0.5);
        }
        assert!(memory.take_start(6).is_none());
        let start = memory.take_start(4).expect("there was room for two");
        assert_eq!((start.points, start.selection_error), (points, 0.5));
        assert!(memory.take_start(4).is_none());
    }
}
