//! `azimesh deform`: one deformed mesh per azimuth step.

use super::{Context, Outcome};
use crate::error::Result;
use crate::formats;
use crate::motion::Schedule;
use crate::quality::Criterion;
use crate::sequence::{Finished, Plan, Request, run};
use serde_json::json;
use std::ops::Range;
use std::path::PathBuf;

/// Warnings of one sort that are shown without `-v`.
const SHOWN: usize = 5;

/// Arguments of `azimesh deform`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The input's format is found by its content; --format stands in for output.format of \
the schedule."
)]
pub struct DeformArgs {
    /// Mesh with boundary tags; `-` reads standard input
    mesh: PathBuf,
    /// Motion schedule (TOML)
    schedule: PathBuf,
    /// Folder for the meshes, steps.csv, base points and run.json
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Base points chosen before by `azimesh select`
    #[arg(long, value_name = "BASE")]
    base: Option<PathBuf>,
    /// Write steps A to B - 1 only, counted from 0; the meshes are those of the whole run
    #[arg(long, value_name = "A..B", value_parser = step_range)]
    steps: Option<Range<usize>>,
    /// Replace the files of an earlier run in the folder
    #[arg(long)]
    force: bool,
    /// Exit with 1 where this holds at any step, e.g. `min_scaled_jacobian<0.1`; any column of
    /// steps.csv; may be given again
    #[arg(long, value_name = "EXPR")]
    fail_on: Vec<Criterion>,
}

pub(super) fn run_command(args: &DeformArgs, context: &Context) -> Result<Outcome> {
    let mut schedule = Schedule::read(&args.schedule)?;
    if let Some(name) = &context.common.format {
        schedule.output.format = formats::by_name(name)?.name().to_owned();
    }
    let mesh = context.read_any(&args.mesh)?;
    let mut plan = Plan::new(mesh, schedule).map_err(|error| error.file(&args.mesh))?;
    for choice in &plan.choices {
        context.note(choice);
    }
    let request = Request {
        mesh: args.mesh.clone(),
        folder: args.output.clone(),
        base: args.base.clone(),
        steps: args.steps.clone(),
        force: args.force,
        fail_on: args.fail_on.clone(),
    };
    let finished = run(&mut plan, &request, &*context.progress())?;
    report(args, &finished, context)
}

/// Reads `A..B`.
fn step_range(text: &str) -> std::result::Result<Range<usize>, String> {
    let ends = text.split_once("..").and_then(|(start, end)| {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        Some(number(start)?..number(end)?)
    });
    ends.ok_or_else(|| {
        format!("\"{text}\" is no range of steps; write A..B, as 0..90 for the first ninety")
    })
}

fn report(args: &DeformArgs, finished: &Finished, context: &Context) -> Result<Outcome> {
    warn_of_some(&finished.warnings, context);
    warn_of_some(&finished.failures, context);
    let failed = finished.inverted_steps > 0 || !finished.failures.is_empty();
    if context.common.json {
        context.print_json(json!({
            "folder": args.output.display().to_string(),
            "steps": finished.n_steps,
            "base_points": finished.n_base,
            "selection_error": finished.selection_error,
            "max_surface_error": finished.surface_error,
            "inverted_steps": finished.inverted_steps,
            "most_inverted": finished.most_inverted,
            "min_scaled_jacobian": finished.min_scaled_jacobian,
            "mesh_bytes": finished.mesh_bytes,
            "warnings": finished.warnings,
            "failures": finished.failures,
            "seconds": {
                "selection": finished.timings.selection,
                "modes": finished.timings.modes,
                "steps": finished.timings.steps,
                "writing": finished.timings.writing,
                "total": finished.timings.total,
            },
        }))?;
    } else if !context.common.quiet {
        context.print(&summary(args, finished))?;
    }
    Ok(match failed {
        true => Outcome::CheckFailed,
        false => Outcome::Fine,
    })
}

/// A condition may fail at every step: the first sentences are shown, all with `-v`.
fn warn_of_some(sentences: &[String], context: &Context) {
    let shown = match context.common.verbose {
        0 => sentences.len().min(SHOWN),
        _ => sentences.len(),
    };
    for sentence in &sentences[..shown] {
        context.warn(sentence);
    }
    if shown < sentences.len() {
        context.warn(&format!(
            "and {} more like these; -v shows them, run.json and steps.csv hold them",
            sentences.len() - shown
        ));
    }
}

fn summary(args: &DeformArgs, finished: &Finished) -> String {
    let t = &finished.timings;
    let jacobian = finished.min_scaled_jacobian.map_or(String::new(), |value| {
        format!(", smallest scaled Jacobian {value:.3e}")
    });
    format!(
        "{}: {} steps from {} base points, surface error {:.1e} ({:.1e} before the correction)\n\
         {} steps with inverted cells{jacobian}\n\
         {:.2} s: selection {:.2}, modes {:.2}, steps {:.2}, writing {:.2} (overlapping)\n",
        args.output.display(),
        finished.n_steps,
        finished.n_base,
        finished.surface_error,
        finished.selection_error,
        finished.inverted_steps,
        t.total,
        t.selection,
        t.modes,
        t.steps,
        t.writing,
    )
}
