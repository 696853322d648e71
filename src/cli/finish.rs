//! `azimesh finish`: the parts of a sequence joined.

use super::deform::report;
use super::{Context, Outcome};
use crate::error::Result;
use crate::run::finish;
use std::path::PathBuf;

/// Arguments of `azimesh finish`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "What is joined already and whole is left as it is; what an ended join has left is completed. Exit code 1 \
where a check failed in a part, as for inverted cells; 2 where a step is missing, written twice or damaged: nothing is \
written then. The files of the parts stay."
)]
pub struct FinishArgs {
    /// Folder that `azimesh deform --steps A..B` has filled
    folder: PathBuf,
    /// Join again, also in place of a run with other inputs
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &FinishArgs, context: &Context) -> Result<Outcome> {
    let finished = finish(&args.folder, args.force, &*context.progress())?;
    report(&args.folder, &finished, context)
}
