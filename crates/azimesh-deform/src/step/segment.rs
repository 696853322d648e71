//! A segment: steps of a deformation that one run has computed. A run to which steps were added has several. Each is computed
//! with the plan of its own run, so that computing a step again gives the same bytes.

use super::step_memory::{Rounding, StepMemory};
use crate::motion::Step;
use crate::plan::Plan;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Some steps with the plan of all steps up to their end.
pub(crate) struct Segment {
    /// The steps.
    pub steps: Range<usize>,
    plan: OnceLock<Arc<Plan>>,
    /// Results of steps, without and with rounding of coordinates.
    memory: [StepMemory; 2],
    /// The displacement of the nodes by the repair of the step before, in the rotating frame; `None` if it was not repaired.
    seam: OnceLock<Option<Vec<Vector>>>,
}

impl Segment {
    /// Creates the segments of a schedule to which steps were added: after each of these numbers of steps. `is_repaired`
    /// returns whether the repair of the last step before is to be found.
    pub fn all(
        n_steps: usize,
        added_after: &[usize],
        is_repaired: impl Fn(usize) -> bool,
    ) -> Vec<Arc<Self>> {
        let ends = added_after.iter().copied().chain([n_steps]);
        let starts = [0].into_iter().chain(added_after.iter().copied());
        let segment = |(start, end): (usize, usize)| {
            let seam = OnceLock::new();
            if start == 0 || !is_repaired(start - 1) {
                let _ = seam.set(None);
            }
            Arc::new(Self {
                steps: start..end,
                plan: OnceLock::new(),
                memory: Default::default(),
                seam,
            })
        };
        starts.zip(ends).map(segment).collect()
    }

    /// Returns its plan; `all` is the plan of all steps of the schedule.
    ///
    /// # Errors
    /// If the modes of its steps cannot be found.
    pub fn plan(&self, all: &Arc<Plan>) -> Result<Arc<Plan>> {
        if self.steps.end == all.motion.steps.len() {
            return Ok(Arc::clone(all));
        }
        if let Some(plan) = self.plan.get() {
            return Ok(Arc::clone(plan));
        }
        let plan = Arc::new(all.of_first_steps(self.steps.end)?);
        Ok(Arc::clone(self.plan.get_or_init(|| plan)))
    }

    pub fn memory(&self, rounding: Rounding) -> &StepMemory {
        &self.memory[usize::from(rounding == Rounding::Single)]
    }

    /// Returns whether the repair of the step before its first is to be found.
    pub fn lacks_seam(&self) -> bool {
        self.seam.get().is_none()
    }

    pub fn set_seam(&self, seam: Option<Vec<Vector>>) {
        self.seam.get_or_init(|| seam);
    }

    /// Returns the displacement by the repair of the step before its first; `None` if it was not repaired.
    pub fn seam(&self) -> Option<&[Vector]> {
        self.seam.get()?.as_deref()
    }

    /// Returns the number of steps since the last step of an earlier run; without one, a number larger than any.
    pub fn after_seam(&self, step: &Step) -> usize {
        match self.steps.start {
            0 => usize::MAX,
            start => step.index + 1 - start,
        }
    }
}
