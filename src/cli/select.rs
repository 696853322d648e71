//! `azimesh select`: base points chosen once and saved.

use super::{Context, Outcome};
use crate::run::base_file;
use azimesh_core::error::{Error, Result, path_in_line};
use azimesh_core::note;
use azimesh_core::numbers::in_digits;
use azimesh_core::ranks::Ranks;
use azimesh_deform::{
    BaseOrigin, Layer, LayerKind, Plan, choose, missed as missed_sentence, missed_layers,
};
use azimesh_io::formats::{Commit, guard_inputs, refuse_special};
use azimesh_rbf::select::Selection;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `azimesh select`.
#[derive(Debug, clap::Args)]
pub struct SelectArgs {
    /// Mesh with boundary tags
    mesh: PathBuf,
    /// Motion schedule (TOML)
    schedule: PathBuf,
    /// File for the base points (TOML); a .vtp for viewing is written next to it
    #[arg(short, long, value_name = "BASE")]
    output: PathBuf,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &SelectArgs, context: &Context) -> Result<Outcome> {
    let schedule = context.read_schedule(&args.schedule)?;
    guard_inputs([&args.mesh, &args.schedule]);
    guard_inputs(schedule.files());
    let commit = Commit::with_force(args.force);
    commit.check(&args.output)?;
    let picture = base_file::picture_of(&args.output);
    refuse_special(&picture)?;
    commit.check(&picture)?;
    let (plan, _) = context.plan(&args.mesh, schedule)?;
    for choice in &plan.choices {
        context.note(choice.clone());
    }
    let intervals = plan.selection_intervals();
    if intervals.len() > 1 {
        return Err(Error::input(format!(
            "method = \"real\" chooses base points {} times along this schedule, which only `deform` does; select is for \
             methods that choose once",
            intervals.len()
        ))
        .file(&args.schedule));
    }
    let selections = choose(&plan, &intervals[0], &Ranks::alone(), &*context.progress())?;
    base_file::save(&plan, &selections, &args.output, commit)?;
    report(args, &plan, &selections, context)
}

fn report(
    args: &SelectArgs,
    plan: &Plan,
    selections: &[Selection],
    context: &Context,
) -> Result<Outcome> {
    let beyond = |(layer, own): &(&Layer, &Selection)| own.measured / layer.tolerance;
    let missed = missed_layers(plan, selections).max_by(|a, b| beyond(a).total_cmp(&beyond(b)));
    if let Some((layer, selection)) = missed {
        let sentence = missed_sentence(plan, layer, selection, BaseOrigin::Chosen);
        context.complain(note!("missed", "{sentence}"));
    }
    if context.common.json {
        context.print_json(&as_json(args, plan, selections, missed.is_none()))?;
    } else {
        for (layer, selection) in plan.layers.iter().zip(selections) {
            context.print_result(&format!(
                "{}: {} {} of {} surface points, error {}, allowed {}\n",
                path_in_line(&args.output),
                selection.base.len(),
                match layer.kind {
                    LayerKind::Displacement => "base points",
                    LayerKind::Rotation(_) => "base points of the rotation",
                },
                plan.surface.nodes.len(),
                in_digits(selection.measured, 4),
                in_digits(layer.tolerance, 4)
            ))?;
        }
    }
    Ok(match missed {
        Some(_) => Outcome::CheckFailed,
        None => Outcome::Fine,
    })
}

fn as_json(args: &SelectArgs, plan: &Plan, selections: &[Selection], met: bool) -> Selected {
    let layer = |(layer, selection): (&Layer, &Selection)| SelectedLayer {
        of: layer.name(),
        base_points: selection.base.len(),
        modes: layer.modes.n_modes,
        support_radius: layer.space.basis.radius,
        tolerance: Some(layer.tolerance),
        error: Some(selection.error),
        measured: Some(selection.measured),
        skipped: selection.skipped,
        history: selection.history.clone(),
        residuals: selection.picked.clone(),
    };
    Selected {
        base: args.output.display().to_string(),
        surface_points: plan.surface.nodes.len(),
        support_radius: plan.basis.radius,
        tolerance: plan.tolerance,
        tolerance_met: met,
        layers: plan.layers.iter().zip(selections).map(layer).collect(),
    }
}

/// The base points that were chosen.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Selected {
    /// Path of the file.
    base: String,
    /// Surface nodes; nodes at one place count once.
    surface_points: usize,
    /// Support radius, mesh units.
    support_radius: f64,
    /// Displacement error allowed, mesh units.
    tolerance: f64,
    /// True if the base points meet it.
    tolerance_met: bool,
    /// One; with `twist` the rotations, then the translations.
    layers: Vec<SelectedLayer>,
}

/// A layer.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct SelectedLayer {
    /// Key of the base points in base.toml.
    #[cfg_attr(test, schemars(extend("enum" = ["nodes", "rotation_nodes"])))]
    of: &'static str,
    /// Number of base points.
    base_points: usize,
    /// Modes of the interpolated displacements or rotations.
    modes: usize,
    /// Support radius of this layer, mesh units.
    support_radius: f64,
    /// Error that was asked for; 0.99 of the schedule's.
    tolerance: Option<f64>,
    /// Largest error over the steps that the points were chosen for; null where it is not finite.
    error: Option<f64>,
    /// The error that is compared with the tolerance.
    measured: Option<f64>,
    /// Candidates too close to base points.
    skipped: usize,
    /// Base points and largest error at each sweep over all surface nodes.
    #[cfg_attr(test, schemars(with = "Vec<[Option<f64>; 2]>"))]
    history: Vec<(usize, f64)>,
    /// Error of each base point when it was chosen.
    #[cfg_attr(test, schemars(with = "Vec<Option<f64>>"))]
    residuals: Vec<f64>,
}
