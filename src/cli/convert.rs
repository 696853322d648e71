//! `azimesh convert`.

use super::{Context, Outcome};
use crate::error::Result;

/// Arguments of `azimesh convert`.
#[derive(Debug, clap::Args)]
pub struct ConvertArgs {}

pub(super) fn run(_args: &ConvertArgs, _context: &Context) -> Result<Outcome> {
    Ok(Outcome::Fine)
}
