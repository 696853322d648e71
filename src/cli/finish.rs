//! `azimesh finish`: the parts of a sequence joined.

use super::deform::report;
use super::{Context, Outcome};
use crate::error::Result;
use crate::sequence::finish;
use std::path::PathBuf;

/// Arguments of `azimesh finish`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Exit code 2 where a step is missing, written twice or damaged: nothing is written then. The files \
of the parts stay."
)]
pub struct FinishArgs {
    /// Folder that `azimesh deform --steps A..B` has filled
    folder: PathBuf,
    /// Replace what an earlier join has left
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &FinishArgs, context: &Context) -> Result<Outcome> {
    let finished = finish(&args.folder, args.force, &*context.progress())?;
    report(&args.folder, &finished, context)
}
