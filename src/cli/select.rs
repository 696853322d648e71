//! `azimesh select`: base points chosen once and saved.

use super::{Context, Outcome};
use crate::run::base_file;
use azimesh_core::diagnostic::in_digits;
use azimesh_core::error::{Error, Result, path_in_line};
use azimesh_core::ranks::Ranks;
use azimesh_deform::motion::Schedule;
use azimesh_deform::{
    BaseOrigin, Layer, LayerKind, Plan, choose, missed as missed_sentence, missed_layers,
};
use azimesh_io::formats::{Commit, guard_inputs, refuse_special};
use azimesh_rbf::select::Selection;
use serde_json::{Value, json};
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
    let schedule = Schedule::read(&args.schedule)?;
    guard_inputs([&args.mesh, &args.schedule]);
    guard_inputs(schedule.files());
    let commit = Commit::with_force(args.force);
    commit.check(&args.output)?;
    let picture = base_file::picture_of(&args.output);
    refuse_special(&picture)?;
    commit.check(&picture)?;
    let (plan, _) = context.plan(&args.mesh, schedule)?;
    for choice in &plan.choices {
        context.note(&choice.to_string());
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
    if context.common.json {
        context.print_json(as_json(args, plan, selections, missed.is_none()))?;
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
    let Some((layer, selection)) = missed else {
        return Ok(Outcome::Fine);
    };
    context.complain(&missed_sentence(plan, layer, selection, BaseOrigin::Chosen));
    Ok(Outcome::CheckFailed)
}

fn as_json(args: &SelectArgs, plan: &Plan, selections: &[Selection], met: bool) -> Value {
    let layers = plan
        .layers
        .iter()
        .zip(selections)
        .map(|(layer, selection)| {
            let history = selection.history.iter();
            json!({
                "of": layer.name(),
                "base_points": selection.base.len(),
                "modes": layer.modes.n_modes,
                "support_radius": layer.space.basis.radius,
                "tolerance": layer.tolerance,
                "error": selection.error,
                "measured": selection.measured,
                "skipped": selection.skipped,
                "history": history.map(|(n, error)| json!([n, error])).collect::<Vec<_>>(),
                "residuals": selection.picked,
            })
        });
    json!({
        "base": args.output.display().to_string(),
        "surface_points": plan.surface.nodes.len(),
        "support_radius": plan.basis.radius,
        "tolerance": plan.tolerance,
        "tolerance_met": met,
        "layers": layers.collect::<Vec<_>>(),
    })
}
