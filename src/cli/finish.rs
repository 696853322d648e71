//! `azimesh finish`: the parts of a sequence joined, or its slabs.

use super::deform::report;
use super::{Context, Outcome};
use crate::error::Result;
use crate::run::{finish, slabs_in};
use std::path::PathBuf;

/// Arguments of `azimesh finish`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A sequence that is joined already is left as it is; a join that was interrupted is completed. Exit code 1: \
a check failed in a part, as for inverted cells; 2: a step is missing, written twice or damaged, and nothing is written. The \
files of the parts stay."
)]
pub struct FinishArgs {
    /// Folder with the parts that `azimesh deform --steps A..B` has written, or the slabs of `azimesh deform --slab I/N`
    folder: PathBuf,
    /// Join again, and replace the sequence of other inputs
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &FinishArgs, context: &Context) -> Result<Outcome> {
    if let Some(left) = slabs_in(&args.folder)? {
        return super::slab::join(&args.folder, left, args.force, context);
    }
    #[cfg(unix)]
    super::signals::end("interrupted; files that are complete are kept")?;
    let finished = finish(&args.folder, args.force, &*context.progress())?;
    report(&args.folder, finished, context)
}
