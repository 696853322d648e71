//! Whether base points meet the tolerance of the schedule: as they were chosen, and at every step.

use super::layer::Layer;
use super::plan::{Plan, SELECTED};
use crate::diagnostic::deform::DeformNote;
use crate::diagnostic::short;
use crate::error::{Error, Result};
use crate::motion::{SelectionCriterion, SelectionMethod, Step};
use crate::rbf::select::Selection;

/// Whether the schedule accepts these base points at any error: method `constant` ends at `max_points`.
fn ends_at_max_points(plan: &Plan, n_base: usize) -> bool {
    let wanted = &plan.schedule.selection;
    wanted.method == SelectionMethod::Constant && n_base >= wanted.max_points
}

/// The layers whose base points miss the tolerance, in their order. Method `all` has none.
pub fn missed_layers<'a>(
    plan: &'a Plan,
    selections: &'a [Selection],
) -> impl Iterator<Item = (&'a Layer, &'a Selection)> {
    let takes_all = plan.schedule.selection.method == SelectionMethod::All;
    plan.layers
        .iter()
        .zip(selections)
        .filter(move |(layer, selection)| {
            let is_met = selection.measured <= layer.tolerance / SELECTED;
            !(is_met || takes_all || ends_at_max_points(plan, selection.base.len()))
        })
}

/// An error of kind `Check` where the base points of a layer miss the tolerance.
pub fn check_tolerance(plan: &Plan, selections: &[Selection]) -> Result<()> {
    let Some((layer, selection)) = missed_layers(plan, selections).next() else {
        return Ok(());
    };
    let reason = if selection.base.len() >= plan.schedule.selection.max_points {
        "max_points is reached"
    } else {
        "no further surface node can be added"
    };
    Err(Error::check(format!(
        "the tolerance {} is not met: {} base points leave an error of {:.3e} ({reason}). The base points are \
         saved; no mesh was written. Try a support_radius below {}, another kernel or a larger max_points",
        short(plan.tolerance),
        selection.base.len(),
        selection.measured,
        short(layer.space.basis.radius)
    ))
    .file(&plan.schedule.path))
}

/// A note where a step misses the tolerance that its base points were chosen by, and whether that
/// fails the run: not where the correction of every substep has made the surface exact, nor where
/// `constant` has ended at `max_points`; `n_base` are the base points of the step.
pub(crate) fn missed_at_step(
    plan: &Plan,
    step: &Step,
    n_base: usize,
    error: f64,
) -> Option<(DeformNote, bool)> {
    let wanted = &plan.schedule.selection;
    let in_substeps = plan.schedule.rbf.substeps > 1;
    let by_largest = wanted.criterion == SelectionCriterion::Max;
    let is_held = match wanted.method {
        SelectionMethod::Sequence => by_largest,
        SelectionMethod::All => in_substeps,
        // The base points serve steps that they were not chosen for, which matters where that is written.
        SelectionMethod::Real | SelectionMethod::Constant => by_largest && !wanted.correction,
    };
    (is_held && error > plan.tolerance).then(|| {
        let note = DeformNote::Misses {
            step: step.index,
            error,
            tolerance: plan.tolerance,
        };
        let is_corrected = in_substeps && wanted.correction;
        (note, !(is_corrected || ends_at_max_points(plan, n_base)))
    })
}
