//! Checks that base points meet the tolerance of the schedule: after selection, and at every step.

use crate::motion::{SelectionCriterion, SelectionMethod, Step};
use crate::plan::layer::Layer;
use crate::plan::{Plan, SELECTED};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::vector::distance;
use azimesh_core::numbers::{in_digits, short};
use azimesh_core::{Note, note};
use azimesh_rbf::select::Selection;
use std::fmt;

/// Returns whether the schedule accepts any error of these base points: method `constant` ends at `max_points`.
fn ends_at_max_points(plan: &Plan, n_base: usize) -> bool {
    let wanted = &plan.schedule.selection;
    wanted.method == SelectionMethod::Constant && n_base >= wanted.max_points
}

/// Returns the layers whose base points miss the tolerance, in their order.
pub fn missed_layers<'a>(
    plan: &'a Plan,
    selections: &'a [Selection],
) -> impl Iterator<Item = (&'a Layer, &'a Selection)> {
    plan.layers
        .iter()
        .zip(selections)
        .filter(|(layer, selection)| {
            let is_met = selection.measured <= layer.tolerance / SELECTED;
            !(is_met || ends_at_max_points(plan, selection.base.len()))
        })
}

/// Origin of the base points of a selection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseOrigin {
    /// Selected for this schedule.
    Chosen,
    /// Given by the user; selected before, perhaps for another schedule.
    Given,
    /// Selected by an earlier run to which the schedule adds steps.
    Earlier,
}

/// Returns an error of kind `Check` if the base points of a layer miss the tolerance.
pub fn check_tolerance(plan: &Plan, selections: &[Selection], origin: BaseOrigin) -> Result<()> {
    let Some((layer, selection)) = missed_layers(plan, selections).next() else {
        return Ok(());
    };
    Err(Error::check(missed(plan, layer, selection, origin)).file(&plan.schedule.path))
}

/// Returns the message for missed tolerances: the error, its cause and the remedy.
pub fn missed(plan: &Plan, layer: &Layer, selection: &Selection, origin: BaseOrigin) -> String {
    let radius = layer.space.basis.radius;
    let why = match Torn::find(plan, layer, selection) {
        _ if origin == BaseOrigin::Given => {
            format!(
                "they were chosen for another motion or tolerance; leave out {}, so that base points are chosen anew",
                option("base")
            )
        }
        _ if origin == BaseOrigin::Earlier => {
            format!(
                "they were chosen for the steps that are finished, and the added steps need more or others; {} starts a new \
                 run of all steps, and another folder keeps the finished one",
                option("force")
            )
        }
        Some(torn) => torn.to_string(),
        None if reaches_max_points(plan, selection) => format!(
            "max_points = {} is reached; set a larger `max_points` or a larger `tolerance`",
            plan.schedule.selection.max_points
        ),
        None => format!(
            "no surface node is left that would reduce it, in double precision with {} and a support radius of {}; set a \
             smaller `support_radius`, a kernel of lower order or a larger `tolerance`",
            layer.space.basis.kernel.name(),
            short(radius)
        ),
    };
    format!(
        "the tolerance {} is not met: {} base points leave an error of {:.3e}: {why}",
        short(plan.tolerance),
        selection.base.len(),
        selection.measured
    )
}

fn reaches_max_points(plan: &Plan, selection: &Selection) -> bool {
    let wanted = &plan.schedule.selection;
    wanted.method != SelectionMethod::All && selection.base.len() >= wanted.max_points
}

/// Two surface nodes whose motions differ by more than their distance.
struct Torn {
    nodes: [u32; 2],
    distance: f64,
    apart: f64,
}

impl Torn {
    /// Finds the surface point with the largest error and its nearest base point, if the difference of their motions is
    /// most of that error.
    fn find(plan: &Plan, layer: &Layer, selection: &Selection) -> Option<Self> {
        let (criterion, r) = (&layer.criterion, layer.criterion.n_modes());
        let error =
            |at: usize, row: &[f64]| criterion.exact(row, criterion.arms_of(at, &layer.lever_arms));
        let residuals = selection.residuals.chunks_exact(r.max(1)).enumerate();
        let errors = residuals.map(|(at, row)| (at, error(at, row)));
        let (worst, most) = errors.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let points = &plan.surface.points;
        let apart = |base: &&usize| distance(points[**base], points[worst]);
        let near = *selection
            .base
            .iter()
            .min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let row = |at: usize| &layer.interpolated()[at * r..][..r];
        let jump: Vec<f64> = row(worst)
            .iter()
            .zip(row(near))
            .map(|(a, b)| a - b)
            .collect();
        let torn = Self {
            nodes: [near, worst].map(|at| plan.surface.nodes[at]),
            distance: apart(&&near),
            apart: error(worst, &jump),
        };
        (near != worst && torn.apart > 0.5 * most && torn.distance < torn.apart).then_some(torn)
    }
}

impl fmt::Display for Torn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "nodes {} and {} are {:.1e} apart and move {} apart, which no smooth field does; move the tags of both with one \
             body, or leave a gap between them in the mesh",
            self.nodes[0],
            self.nodes[1],
            self.distance,
            in_digits(self.apart, 3)
        )
    }
}

/// Returns a note if a step misses the tolerance of its base points, and whether that fails the run. It does not fail if
/// the correction of every substep has made the surface exact, or if `constant` has ended at `max_points`. `n_base` is the
/// number of base points of the step. `repaired_in_substeps` is true if its folded cells made it one of several substeps.
pub fn missed_at_step(
    plan: &Plan,
    step: &Step,
    n_base: usize,
    repaired_in_substeps: bool,
    error: f64,
) -> Option<(Note, bool)> {
    let wanted = &plan.schedule.selection;
    let in_substeps = repaired_in_substeps || plan.schedule.rbf.substeps > 1;
    let by_largest = wanted.criterion == SelectionCriterion::Max;
    let is_held = match wanted.method {
        SelectionMethod::Sequence => by_largest,
        SelectionMethod::All => in_substeps,
        // The base points also serve steps for which they were not selected; that matters if the uncorrected positions are written.
        SelectionMethod::Real | SelectionMethod::Constant => by_largest && !wanted.correction,
    };
    (is_held && error > plan.tolerance).then(|| {
        let note = note!(
            "misses_tolerance",
            "step {}: the base points leave an error of {error:.3e}, more than the tolerance {}",
            step.index,
            short(plan.tolerance)
        );
        let is_corrected = in_substeps && wanted.correction;
        (note, !(is_corrected || ends_at_max_points(plan, n_base)))
    })
}
