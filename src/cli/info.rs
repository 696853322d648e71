//! `azimesh info`.

use super::{Context, Outcome};
use crate::error::Result;

/// Arguments of `azimesh info`.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {}

pub(super) fn run(_args: &InfoArgs, _context: &Context) -> Result<Outcome> {
    Ok(Outcome::Fine)
}
