//! `azimesh info`.

mod facts;
mod json;
mod text;

use super::input::Input;
use super::{Context, Outcome};
use crate::error::Result;
use crate::formats;
use facts::Facts;
use std::path::PathBuf;

/// Arguments of `azimesh info`.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {
    /// Mesh or sequence; - is standard input
    mesh: PathBuf,

    /// Look at this step of a sequence, counted from 0; the last by default
    #[arg(long, value_name = "I")]
    step: Option<usize>,
}

pub(super) fn run(args: &InfoArgs, context: &Context) -> Result<Outcome> {
    let format = context.common.format.as_deref().map(formats::by_name);
    let input = Input::open(&args.mesh, format.transpose()?, context)?;
    input.check_step(args.step)?;
    let loaded = input.read(args.step, context)?;
    let facts = context.stage("inspecting", || Ok(Facts::of(&input, args.step, &loaded)))?;
    if context.common.json {
        context.print_json(json::of(&facts))?;
    } else {
        for note in &facts.notes {
            context.note(&format!("{}: {note}", args.mesh.display()));
        }
        context.print_result(&text::of(&facts))?;
    }
    Ok(Outcome::Fine)
}
