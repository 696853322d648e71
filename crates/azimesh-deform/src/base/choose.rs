//! Selects the base points of a selection interval by the method of the schedule.
//!
//! | method | targets | ends |
//! |---|---|---|
//! | `sequence` | the modes over all steps | at the tolerance |
//! | `real` | the modes at the first step of the interval that moves anything (Algorithm 1 of the paper) | at the tolerance |
//! | `constant` | one vector on all that moves (Algorithm 2) | at the tolerance or at `max_points` |
//! | `all` | none: every surface node that double precision can distinguish | |

use super::base_points::BasePoints;
use super::rank_sweeps::RankSweeps;
use crate::motion::{SelectionCriterion, SelectionMethod};
use crate::plan::Plan;
use crate::plan::layer::{Layer, LayerKind};
use azimesh_core::error::{Error, ErrorKind, Result};
use azimesh_core::geometry::vector::{Vector, norm};
use azimesh_core::numbers::short;
use azimesh_core::progress::Progress;
use azimesh_core::ranks::Ranks;
use azimesh_core::{Note, note};
use azimesh_rbf::criterion::Criterion;
use azimesh_rbf::distinct::distinct;
use azimesh_rbf::power::by_power;
use azimesh_rbf::select::{self, Limits, Measure, Selection};
use azimesh_rbf::space::Space;
use azimesh_rbf::targets::Targets;
use std::ops::Range;

/// Base points closer than this part of the support radius are equal to working precision.
const DISTINCT: f64 = 1e-7;

/// Selects the base points of every layer for the steps of an interval.
///
/// # Errors
/// If no base points can be chosen. All ranks call it and get the same result.
pub fn choose(
    plan: &Plan,
    interval: &Range<usize>,
    ranks: &Ranks,
    progress: &dyn Progress,
) -> Result<Vec<Selection>> {
    progress.start("selection", None);
    let layers = plan.layers.iter();
    let selections = layers
        .map(|layer| choose_for(plan, layer, interval, ranks, progress))
        .collect::<Result<Vec<_>>>();
    progress.finish();
    selections.map_err(|error| error.file(&plan.schedule.path))
}

/// Builds the selections of given base points, for the steps of an interval.
pub fn from_nodes(
    plan: &Plan,
    interval: &Range<usize>,
    base: &BasePoints,
) -> Result<Vec<Selection>> {
    let points_of = |layer: &Layer| {
        let nodes = match layer.kind {
            LayerKind::Displacement => base.nodes.as_slice(),
            LayerKind::Rotation(_) => base.rotation_nodes.as_deref().unwrap_or_default(),
        };
        check_distinct(nodes)?;
        plan.surface.find(nodes)
    };
    let bases: Vec<Vec<usize>> = plan.layers.iter().map(points_of).collect::<Result<_>>()?;
    plan.layers
        .iter()
        .zip(bases)
        .map(|(layer, base)| {
            let constant = match plan.schedule.selection.method {
                SelectionMethod::Constant => Some(constant_error(plan, layer, base.clone())?),
                _ => None,
            };
            let criterion = criterion_of(plan, layer, interval)?;
            let targets = Targets {
                criterion: criterion.as_ref().unwrap_or(&layer.criterion),
                ..plan.targets(layer)
            };
            let own = select::from_base(&layer.space, targets, base, measure(plan))?;
            Ok(Selection {
                measured: constant.unwrap_or(own.measured),
                ..own
            })
        })
        .collect()
}

fn check_distinct(nodes: &[u32]) -> Result<()> {
    let mut sorted = nodes.to_vec();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        None => Ok(()),
        Some(pair) => Err(Error::input(format!("node {} is listed twice", pair[0]))),
    }
}

/// Returns the criterion of method `real`: the error over one step.
fn criterion_of(plan: &Plan, layer: &Layer, interval: &Range<usize>) -> Result<Option<Criterion>> {
    match plan.schedule.selection.method {
        SelectionMethod::Real => {
            let step = first_that_moves(plan, interval);
            Ok(Some(layer.criterion.of_step(step)?))
        }
        _ => Ok(None),
    }
}

fn choose_for(
    plan: &Plan,
    layer: &Layer,
    interval: &Range<usize>,
    ranks: &Ranks,
    progress: &dyn Progress,
) -> Result<Selection> {
    let targets = plan.targets(layer);
    let wanted = &plan.schedule.selection;
    match wanted.method {
        SelectionMethod::Sequence | SelectionMethod::Real => {
            let criterion = criterion_of(plan, layer, interval)?;
            let targets = Targets {
                criterion: criterion.as_ref().unwrap_or(&layer.criterion),
                ..targets
            };
            in_rounds(plan, layer, targets, ranks, progress)
        }
        SelectionMethod::Constant => by_constant(plan, layer, targets, progress),
        SelectionMethod::All => every_point(plan, layer, targets),
    }
}

/// Selects every surface point except points that are equal to others to working precision. If the kernel matrix of all
/// of them is not positive definite in double precision, only points that reduce the power function are kept; the others
/// are reproduced within round-off.
fn every_point(plan: &Plan, layer: &Layer, targets: Targets<'_>) -> Result<Selection> {
    let (space, points) = (&layer.space, &plan.surface.points);
    let base = match layer.modes.n_modes {
        0 => Vec::new(),
        _ => distinct(points, DISTINCT * space.basis.radius, targets.images),
    };
    let mut selection = match select::from_base(space, targets, base, Measure::Max) {
        Err(error) if error.kind == ErrorKind::Check => {
            let is_image = |at: usize| targets.images.get(at).is_some_and(|image| *image);
            let weight = |at| if is_image(at) { 0.0 } else { 1.0 };
            let weights: Vec<f64> = (0..points.len()).map(weight).collect();
            let (base, _) = by_power(space, points, &weights, 0.0, points.len());
            select::from_base(space, targets, base, Measure::Max)?
        }
        selection => selection?,
    };
    selection.skipped = plan.surface.nodes.len() - selection.base.len();
    Ok(selection)
}

/// Returns a note if method `all` has left out surface points.
pub(crate) fn left_out(plan: &Plan, selections: &[Selection]) -> Vec<Note> {
    let is_all = plan.schedule.selection.method == SelectionMethod::All;
    let n_images = plan
        .periodic
        .is_image
        .iter()
        .filter(|image| **image)
        .count();
    let wanted = plan.surface.points.len() - n_images;
    let layers = plan
        .layers
        .iter()
        .zip(selections)
        .filter(|(layer, own)| is_all && layer.modes.n_modes > 0 && own.base.len() < wanted);
    let notes = layers.map(|(layer, own)| {
        let (n_base, error) = (own.base.len(), own.error);
        let basis = &layer.space.basis;
        let note = note!(
            "not_all",
            "method = \"all\" takes {n_base} of {wanted} surface nodes: with {} and a support radius of {} double \
             precision cannot tell the others from them; they are reproduced within {error:.1e} before the correction",
            basis.kernel.name(),
            short(basis.radius)
        );
        note.with("base_points", n_base).with("surface", wanted).with("error", error)
    });
    notes.collect()
}

/// Returns the first step of an interval at which anything moves, or the first step. Base points for no motion would
/// serve no other step.
fn first_that_moves(plan: &Plan, interval: &Range<usize>) -> usize {
    let mut steps = interval.clone();
    steps
        .find(|&step| plan.largest_displacement(step) > 0.0)
        .unwrap_or(interval.start)
}

fn measure(plan: &Plan) -> Measure {
    match plan.schedule.selection.criterion {
        SelectionCriterion::Max => Measure::Max,
        SelectionCriterion::Mean => Measure::Mean,
    }
}

fn limits(plan: &Plan, layer: &Layer) -> Limits {
    let most = plan.schedule.selection.max_points;
    Limits {
        measure: measure(plan),
        ..Limits::in_rounds(layer.tolerance, most, plan.surface.nodes.len())
    }
}

fn in_rounds(
    plan: &Plan,
    layer: &Layer,
    targets: Targets<'_>,
    ranks: &Ranks,
    progress: &dyn Progress,
) -> Result<Selection> {
    let limits = limits(plan, layer);
    let space = &layer.space;
    let mut say = |n: usize, error: f64| {
        progress.say(&format!(
            "{n} base points, error {error:.2e} (tolerance {:.2e})",
            plan.tolerance
        ));
    };
    if ranks.n() > 1 && space.constraints.is_none() && targets.criterion.n_modes() > 0 {
        let mut sweeps = RankSweeps::new(space, targets, limits.candidates, ranks);
        return select::select_by(&mut sweeps, space, targets, limits, &mut say);
    }
    select::select(space, targets, limits, &mut say)
}

/// Algorithm 2: selects base points that reproduce one vector at all moving points, zero elsewhere; then computes the
/// layer's own modes from them.
fn by_constant(
    plan: &Plan,
    layer: &Layer,
    targets: Targets<'_>,
    progress: &dyn Progress,
) -> Result<Selection> {
    let Some(field) = constant_field(plan, layer)? else {
        return select::from_base(&layer.space, targets, Vec::new(), measure(plan));
    };
    let limits = limits(plan, layer);
    let chosen = select::select(
        &field.space,
        field.targets(targets),
        limits,
        &mut |n, error| {
            progress.say(&format!(
                "{n} base points, error {error:.2e} of the constant displacement"
            ));
        },
    )?;
    let own = select::from_base(&layer.space, targets, chosen.base, measure(plan))?;
    Ok(Selection {
        measured: chosen.measured,
        history: chosen.history,
        picked: chosen.picked,
        skipped: chosen.skipped,
        ..own
    })
}

/// The target of Algorithm 2: one vector at all moving points.
struct ConstantField {
    space: Space,
    values: Vec<f64>,
    criterion: Criterion,
}

impl ConstantField {
    /// Targets with the values of this field, otherwise as `of`.
    fn targets<'a>(&'a self, of: Targets<'a>) -> Targets<'a> {
        Targets {
            values: &self.values,
            criterion: &self.criterion,
            ..of
        }
    }
}

/// Returns the constant vector at all moving points, zero elsewhere; `None` if there is nothing to select for. It has
/// one direction, so a scalar field of its length is enough, except with periodic images, which rotate it.
fn constant_field(plan: &Plan, layer: &Layer) -> Result<Option<ConstantField>> {
    let vector = constant(plan, layer);
    let size = norm(vector);
    if size == 0.0 || layer.modes.n_modes == 0 {
        return Ok(None);
    }
    let moving = plan.surface.body.iter().map(Option::is_some);
    if layer.space.images.is_empty() {
        return Ok(Some(ConstantField {
            space: layer.space.scalar(),
            values: moving.map(|moves| if moves { size } else { 0.0 }).collect(),
            criterion: Criterion::new(1, &[1.0, 0.0, 0.0])?,
        }));
    }
    Ok(Some(ConstantField {
        space: layer.space.clone(),
        values: moving
            .flat_map(|moves| if moves { vector } else { [0.0; 3] })
            .collect(),
        criterion: Criterion::new(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?,
    }))
}

/// Returns the error of Algorithm 2 for given base points.
fn constant_error(plan: &Plan, layer: &Layer, base: Vec<usize>) -> Result<f64> {
    let Some(field) = constant_field(plan, layer)? else {
        return Ok(0.0);
    };
    let targets = field.targets(plan.targets(layer));
    Ok(select::from_base(&field.space, targets, base, measure(plan))?.measured)
}

/// Returns the vector of Algorithm 2: from the schedule, or the largest component of the layer's data over moving
/// points and steps in each direction.
pub fn constant(plan: &Plan, layer: &Layer) -> Vector {
    if let Some(constant) = plan.schedule.selection.constant {
        return constant;
    }
    layer.modes.largest_components()
}
