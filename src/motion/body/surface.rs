//! `[body.surface]`: displacements of surface nodes from another program.

use crate::error::Result;
use crate::motion::reader::{Entry, Keys, Section};

const SURFACE: Keys = Keys {
    known: &["file", "match_tolerance", "missing"],
    later: &[],
};
/// Distance at which a place in a file is that of a node, in mesh units.
const MATCH_TOLERANCE: f64 = 1e-9;

/// Displacements or positions of the body's nodes, the same at every step or one set for each.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceMotion {
    /// The file, relative to the schedule.
    pub file: String,
    /// How the file's nodes are found in the mesh.
    pub matching: Matching,
    /// Line of the section.
    pub(in crate::motion) line: u64,
}

/// How nodes of a file are found among those of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matching {
    /// Distance at which a place is that of a node, in mesh units.
    pub tolerance: f64,
    /// Whether nodes that the file does not name stay where they are; else they are an error.
    pub missing_fixed: bool,
}

impl SurfaceMotion {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[body.surface]", &SURFACE)?;
        let file = section.require("file", "file = \"surface.csv\"")?;
        Ok(Self {
            file: file.string()?.to_owned(),
            matching: Matching::read(&section)?,
            line: section.line,
        })
    }
}

impl Matching {
    pub(super) fn read(section: &Section<'_>) -> Result<Self> {
        let tolerance = section.get("match_tolerance");
        let tolerance = tolerance.map(|tolerance| tolerance.positive());
        let missing = section.get("missing");
        let missing = missing.map(|missing| missing.choice(&[("fixed", true)], &[]));
        Ok(Self {
            tolerance: tolerance.transpose()?.unwrap_or(MATCH_TOLERANCE),
            missing_fixed: missing.transpose()?.unwrap_or(false),
        })
    }
}
