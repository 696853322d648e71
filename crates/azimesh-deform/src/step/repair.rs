//! The repair of folded cells of a step, and its report. With `on_inverted = "substeps"` the step is repeated in 2, 4 and 8
//! substeps, from the same base points, finally with another kernel. With `"repair"` remaining cells are then untangled.

use super::substeps::Parts;
use super::window::Window;
use crate::motion::{Interpolate, OnInverted};
use crate::plan::Plan;
use azimesh_core::error::{ErrorKind, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_quality::Summary;
use azimesh_quality::repair::{Count, PatchLog};
use azimesh_rbf::Kernel;
use std::ops::Range;

/// Numbers of substeps to try, in order.
const TRIES: [usize; 3] = [2, 4, 8];

/// The kernel of the last attempt. It decreases linearly from a base point, so that the mesh of a narrow gap deforms
/// evenly; a smooth kernel moves the middle of the gap with one of its sides.
const LAST_KERNEL: Kernel = Kernel::WendlandC0;

/// The repair of the folded cells of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// Substeps of the result; `None` if they did not help.
    pub substeps: Option<Parts>,
    /// Cells that are not valid without substeps.
    pub before: Count,
    /// Cells that are not valid with them.
    pub after: Count,
    /// The untangling after that; `None` if it was not requested.
    pub untangled: Option<Untangled>,
    /// Its part in the repair of a window.
    pub window: Option<WindowPart>,
    /// Cells below the scaled Jacobian that the schedule wants, before all that.
    pub low: usize,
    /// Low cells after all that.
    pub still_low: usize,
}

/// Cells of a step that need a repair.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct CellsToRepair {
    /// Not valid, or not proven to be so.
    pub not_valid: usize,
    /// Below the scaled Jacobian that the schedule wants.
    pub low: usize,
}

/// The cells of a step that were untangled.
#[derive(Debug, Clone, PartialEq)]
pub struct Untangled {
    pub patches: Vec<PatchLog>,
    /// Inverted and unproven cells after it.
    pub left: usize,
}

/// The share of a step in the repair of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowPart {
    pub steps: Range<usize>,
    pub weight: f64,
}

/// Cells that are not valid or not proven to be so.
pub(crate) fn n_not_valid(summary: &Summary) -> usize {
    summary.inverted + summary.unproven
}

fn count(summary: &Summary) -> Count {
    Count {
        inverted: summary.inverted,
        unproven: summary.unproven,
    }
}

/// Returns whether a step is to be repaired.
pub(crate) fn wants_repair(plan: &Plan, summary: &Summary) -> bool {
    match plan.schedule.output.on_inverted {
        OnInverted::Substeps => summary.inverted > 0,
        OnInverted::Repair => n_not_valid(summary) > 0,
        OnInverted::Warn | OnInverted::Stop => false,
    }
}

/// Returns whether a step can be computed in substeps: not with a twisting beam.
fn has_substeps(plan: &Plan) -> bool {
    let mut bodies = 0..plan.motion.bodies.len();
    plan.schedule.rbf.interpolate != Interpolate::Twist
        || bodies.all(|body| plan.motion.is_rigid(body))
}

/// Returns the substeps to try, in order.
fn tries(plan: &Plan) -> Vec<Parts> {
    let n_now = plan.schedule.rbf.substeps;
    if !has_substeps(plan) {
        return Vec::new();
    }
    let more = TRIES.into_iter().filter(|&n| n > n_now);
    let mut tries: Vec<Parts> = more.map(|n| Parts { n, kernel: None }).collect();
    if plan.method.displacement.basis.kernel != LAST_KERNEL {
        tries.push(Parts {
            n: n_now.max(TRIES[TRIES.len() - 1]),
            kernel: Some(LAST_KERNEL),
        });
    }
    tries
}

/// Tries substeps until no cell is inverted. `points`, `summary` and `error` are set by the first attempt with the
/// fewest inverted cells. `attempt` computes the step in parts; it receives the number of inverted cells.
pub(crate) fn try_substeps(
    plan: &Plan,
    points: &mut [Vector],
    summary: &mut Summary,
    error: &mut f64,
    attempt: impl Fn(Parts, usize, &mut [Vector]) -> Result<(f64, Summary)>,
) -> Result<Repair> {
    let before = count(summary);
    let mut substeps = None;
    let mut trial = points.to_vec();
    for parts in tries(plan) {
        if summary.inverted == 0 {
            break;
        }
        let (found_error, found) = match attempt(parts, summary.inverted, &mut trial) {
            Ok(found) => found,
            Err(error) if error.kind == ErrorKind::System => return Err(error),
            // A failed attempt repairs nothing.
            Err(_) => continue,
        };
        if found.inverted < summary.inverted {
            points.copy_from_slice(&trial);
            (*error, *summary, substeps) = (found_error, found, Some(parts));
        }
    }
    Ok(Repair {
        substeps,
        before,
        after: count(summary),
        untangled: None,
        window: None,
        low: 0,
        still_low: 0,
    })
}

impl Repair {
    /// Creates the repair of a step of a window with this `weight`. The quality of its cells is `before` without substeps,
    /// `after` with them, and `cells` in the end, with `still_low` low ones.
    pub(crate) fn of_window(
        window: &Window,
        weight: f64,
        before: (&Summary, CellsToRepair),
        after: Count,
        patches: Vec<PatchLog>,
        (cells, still_low): (&Summary, usize),
    ) -> Self {
        Self {
            substeps: window.substeps,
            before: count(before.0),
            low: before.1.low,
            still_low,
            after,
            untangled: Some(Untangled {
                patches,
                left: n_not_valid(cells),
            }),
            window: Some(WindowPart {
                steps: window.steps.clone(),
                weight,
            }),
        }
    }

    /// Adds the patches untangled after the substeps, and the number of remaining cells.
    pub(crate) fn untangled(&mut self, patches: Vec<PatchLog>, left: usize) {
        self.untangled = Some(Untangled { patches, left });
    }

    /// Returns the number of cells made valid by moving nodes near them.
    pub fn n_untangled(&self) -> usize {
        let untangled = self.untangled.as_ref();
        untangled.map_or(0, |untangled| {
            self.after.all().saturating_sub(untangled.left)
        })
    }
}
