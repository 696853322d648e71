//! `[body.table]`: six degrees of freedom from a table.

use crate::error::Result;
use crate::geometry::vector::Vector;
use crate::motion::reader::{Entry, Keys};
use crate::motion::table::Interpolation;

const TABLE: Keys = Keys {
    known: &["file", "origin", "interpolation"],
    later: &[],
};

/// Translations and rotations from a table: `Rz Ry Rx` about an origin, then the translation.
#[derive(Debug, Clone, PartialEq)]
pub struct TableMotion {
    /// The table, relative to the schedule.
    pub file: String,
    /// What it turns about, in mesh units.
    pub origin: Vector,
    /// How values between rows are found.
    pub interpolation: Interpolation,
    /// Line of the section.
    pub(in crate::motion) line: u64,
}

impl TableMotion {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[body.table]", &TABLE)?;
        let origin = section.get("origin").map(|origin| origin.numbers());
        Ok(Self {
            file: section
                .require("file", "file = \"motion.csv\"")?
                .string()?
                .to_owned(),
            origin: origin.transpose()?.unwrap_or_default(),
            interpolation: interpolation(section.get("interpolation"))?,
            line: section.line,
        })
    }
}

/// `"linear"`, which is the default, or `"cubic"`.
pub(super) fn interpolation(entry: Option<Entry<'_>>) -> Result<Interpolation> {
    let known = [
        ("linear", Interpolation::Linear),
        ("cubic", Interpolation::Cubic),
    ];
    let found = entry.map(|entry| entry.choice(&known, &[]));
    Ok(found.transpose()?.unwrap_or(Interpolation::Linear))
}
