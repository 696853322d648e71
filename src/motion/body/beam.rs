//! `[body.beam]`: the elastic motion of a blade from a structural code's table.

use super::table::interpolation;
use crate::error::Result;
use crate::motion::reader::{Entry, Keys};
use crate::motion::table::Interpolation;

const BEAM: Keys = Keys {
    known: &["table", "lifting_line", "interpolation"],
    later: &[],
};

/// Translations and rotations of a blade's sections, over azimuth and span.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamMotion {
    /// The table, relative to the schedule.
    pub table: String,
    /// Table of the points that sections turn about; the quarter chord of the mesh when `None`.
    pub lifting_line: Option<String>,
    /// How values between azimuths are found; along the span it is linear.
    pub interpolation: Interpolation,
    /// Line of the section.
    pub(in crate::motion) line: u64,
}

impl BeamMotion {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[body.beam]", &BEAM)?;
        let line = section.get("lifting_line").map(|line| line.string());
        let line = line.transpose()?.filter(|line| *line != "quarter_chord");
        Ok(Self {
            table: section
                .require("table", "table = \"beam.csv\"")?
                .string()?
                .to_owned(),
            lifting_line: line.map(str::to_owned),
            interpolation: interpolation(section.get("interpolation"))?,
            line: section.line,
        })
    }
}
