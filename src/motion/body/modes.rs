//! `[body.modes]`: mode shapes times generalised coordinates.

use super::surface::Matching;
use super::table::interpolation;
use crate::error::Result;
use crate::motion::reader::{Entry, Keys};
use crate::motion::table::Interpolation;

const MODES: Keys = Keys {
    known: &[
        "shapes",
        "coordinates",
        "interpolation",
        "match_tolerance",
        "missing",
    ],
    later: &[],
};

/// The sum over modes of a generalised coordinate times its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesMotion {
    /// The shapes at the nodes, relative to the schedule.
    pub shapes: String,
    /// The table of coordinates, relative to the schedule.
    pub coordinates: String,
    /// How coordinates between rows are found.
    pub interpolation: Interpolation,
    /// How the file's nodes are found in the mesh.
    pub matching: Matching,
    /// Line of the section.
    pub(in crate::motion) line: u64,
}

impl ModesMotion {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[body.modes]", &MODES)?;
        let shapes = section.require("shapes", "shapes = \"modes.csv\"")?;
        let coordinates = section.require("coordinates", "coordinates = \"q.csv\"")?;
        Ok(Self {
            shapes: shapes.string()?.to_owned(),
            coordinates: coordinates.string()?.to_owned(),
            interpolation: interpolation(section.get("interpolation"))?,
            matching: Matching::read(&section)?,
            line: section.line,
        })
    }
}
