//! `azimesh finish`: the parts of a sequence joined.

use super::deform::report;
use super::{Context, Outcome};
use crate::run::finish;
use azimesh_core::error::Result;
use std::path::PathBuf;

/// Arguments of `azimesh finish`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A sequence that is joined already is left as it is; a join that was interrupted is completed. Exit code 1: \
a check failed in a part, as for inverted cells; 2: a step is missing, written twice or damaged, and nothing is written. The \
files of the parts stay."
)]
pub struct FinishArgs {
    /// Folder with the parts that `azimesh deform --steps A..B` has written
    folder: PathBuf,
    /// Join again, and replace the sequence of other inputs
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &FinishArgs, context: &Context) -> Result<Outcome> {
    #[cfg(unix)]
    super::signals::end("interrupted; files that are complete are kept")?;
    let finished = finish(&args.folder, args.force, &*context.progress())?;
    report(&args.folder, finished, 0, context)
}
