//! `azimesh select`: base points chosen once and saved.

use super::{Context, Outcome};
use crate::error::{Error, Result};
use crate::motion::Schedule;
use crate::sequence::{Plan, base, select_base};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `azimesh select`.
#[derive(Debug, clap::Args)]
pub struct SelectArgs {
    /// Mesh with boundary tags
    mesh: PathBuf,
    /// Motion schedule (TOML)
    schedule: PathBuf,
    /// Where the base points go (TOML); a .vtp to look at is written beside it
    #[arg(short, long, value_name = "BASE")]
    output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &SelectArgs, context: &Context) -> Result<Outcome> {
    let schedule = Schedule::read(&args.schedule)?;
    for path in [args.output.clone(), base::picture_of(&args.output)] {
        if path.exists() && !args.force {
            return Err(Error::input("exists already; --force replaces it").file(&path));
        }
    }
    let plan = Plan::new(context.read_mesh(&args.mesh)?, schedule)?;
    for choice in &plan.choices {
        context.note(choice);
    }
    let selection = select_base(&plan, &*context.progress())?;
    base::save(&plan, &selection, &args.output)?;
    let met = selection.error <= plan.tolerance;
    if context.common.json {
        let history = selection.history.iter();
        context.print_json(json!({
            "base": args.output.display().to_string(),
            "base_points": selection.base.len(),
            "surface_points": plan.surface.nodes.len(),
            "modes": plan.modes.n_modes,
            "support_radius": plan.basis.radius,
            "tolerance": plan.tolerance,
            "error": selection.error,
            "tolerance_met": met,
            "history": history.map(|(n, error)| json!([n, error])).collect::<Vec<_>>(),
        }))?;
    } else if !context.common.quiet {
        context.print(&format!(
            "{}: {} base points of {} surface nodes, error {:.3e} of {:.3e} allowed\n",
            args.output.display(),
            selection.base.len(),
            plan.surface.nodes.len(),
            selection.error,
            plan.tolerance
        ))?;
    }
    if !met {
        context.warn("the tolerance is not met; a smaller support_radius, another kernel or more max_points would help");
    }
    Ok(match met {
        true => Outcome::Fine,
        false => Outcome::CheckFailed,
    })
}
