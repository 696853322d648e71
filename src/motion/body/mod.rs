//! A moving body: its tags and its motions, read from `[[body]]`; a file for each sort of motion.

mod beam;
mod cyclic;
mod modes;
mod rigid;
mod surface;
mod table;

pub use beam::BeamMotion;
pub use cyclic::{Cyclic, Harmonic, Series};
pub use modes::ModesMotion;
pub use rigid::Rigid;
pub use surface::{Matching, SurfaceMotion};
pub use table::TableMotion;

use super::names::{Pattern, list};
use super::reader::{AngleUnit, Entry, Keys};
use crate::error::{Error, Result};
use std::collections::BTreeMap;

const BODY: Keys = Keys {
    known: &[
        "name",
        "tags",
        "azimuth_offset",
        "parent",
        "cyclic",
        "rigid",
        "table",
        "beam",
        "modes",
        "surface",
    ],
    later: &[],
};

/// A moving body. Its motions act in the order surface, modes, rigid, table, then beam and cyclic as
/// one; then those of its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name, of its own among the bodies.
    pub name: String,
    /// Boundary tags that move with it.
    pub tags: Vec<Pattern>,
    /// Azimuth of its blade when the rotor's is zero, in radians.
    pub azimuth_offset: f64,
    /// The body it moves with, as a place in the schedule before its own.
    pub parent: Option<usize>,
    /// Pitch, flap and lag as functions of the azimuth.
    pub cyclic: Option<Cyclic>,
    /// A rotation and a translation.
    pub rigid: Option<Rigid>,
    /// Six degrees of freedom from a table.
    pub table: Option<TableMotion>,
    /// Bending from a structural code.
    pub beam: Option<BeamMotion>,
    /// Mode shapes times coordinates.
    pub modes: Option<ModesMotion>,
    /// Displacements from another program.
    pub surface: Option<SurfaceMotion>,
    /// Line of its name.
    pub(super) line: u64,
}

impl Body {
    /// Reads a body; `before` are those that stand before it in the schedule, with the place of each name.
    pub(super) fn read(
        entry: &Entry<'_>,
        (before, names): (&[Self], &BTreeMap<String, usize>),
        unit: AngleUnit,
    ) -> Result<Self> {
        let section = entry.section("[[body]]", &BODY)?;
        let name = section.require("name", "name = \"blade\"")?;
        let line = name.line();
        let name = name.string()?.to_owned();
        if names.contains_key(&name) {
            return Err(Error::input(format!(
                "there are two bodies \"{name}\"; each needs a name of its own"
            ))
            .line(line));
        }
        let tags = patterns(&section.require("tags", "tags = [\"blade\"]")?, "tags")?;
        let parent = section
            .get("parent")
            .map(|parent| find_parent(&parent, before, names));
        let parent = parent.transpose()?;
        let azimuth_offset = match (section.get("azimuth_offset"), parent) {
            (Some(offset), _) => offset.angle(unit)?,
            (None, Some(parent)) => before[parent].azimuth_offset,
            (None, None) => 0.0,
        };
        let cyclic = section
            .get("cyclic")
            .map(|entry| Cyclic::read(&entry, unit));
        let rigid = section.get("rigid").map(|entry| Rigid::read(&entry, unit));
        let table = section.get("table").map(|entry| TableMotion::read(&entry));
        let beam = section.get("beam").map(|entry| BeamMotion::read(&entry));
        let modes = section.get("modes").map(|entry| ModesMotion::read(&entry));
        let surface = section.get("surface");
        let surface = surface.map(|entry| SurfaceMotion::read(&entry));
        let motions = [
            "cyclic", "rigid", "table", "beam", "modes", "surface", "parent",
        ];
        if motions.iter().all(|key| section.get(key).is_none()) {
            return Err(section.error(format!(
                "body \"{name}\" has no motion; give it [body.cyclic], [body.rigid] or another one, or list its \
                 tags as `fixed`"
            )));
        }
        Ok(Self {
            name,
            tags,
            azimuth_offset,
            parent,
            cyclic: cyclic.transpose()?,
            rigid: rigid.transpose()?,
            table: table.transpose()?,
            beam: beam.transpose()?,
            modes: modes.transpose()?,
            surface: surface.transpose()?,
            line,
        })
    }
}

impl Body {
    /// Line of its name in the schedule.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// The files that its motions name, relative to the schedule.
    pub(super) fn files(&self) -> Vec<&str> {
        let surface = self.surface.iter().map(|surface| &surface.file);
        let modes = self.modes.iter();
        let modes = modes.flat_map(|modes| [&modes.shapes, &modes.coordinates]);
        let table = self.table.iter().map(|table| &table.file);
        let beam = self.beam.iter();
        let beam = beam.flat_map(|beam| [Some(&beam.table), beam.lifting_line.as_ref()]);
        let files = surface.chain(modes).chain(table).chain(beam.flatten());
        files.map(String::as_str).collect()
    }

    /// Whether its cyclic motion changes with the azimuth.
    pub(super) fn has_harmonics(&self) -> bool {
        let cyclic = self.cyclic.iter();
        let mut series = cyclic.flat_map(|cyclic| [&cyclic.pitch, &cyclic.flap, &cyclic.lag]);
        series.any(|series| !series.harmonics.is_empty())
    }
}

/// The place of the body that `parent` names.
fn find_parent(
    parent: &Entry<'_>,
    before: &[Body],
    names: &BTreeMap<String, usize>,
) -> Result<usize> {
    let name = parent.string()?;
    names.get(name).copied().ok_or_else(|| {
        let names = list(before.iter().map(|body| body.name.as_str()));
        let before = match before {
            [] => "there is none before it".to_owned(),
            _ => format!("before it: {names}"),
        };
        parent.error(&format!(
            "= \"{name}\" is no body that stands before its child in the schedule; {before}"
        ))
    })
}

/// A list of names or globs that is not empty.
pub(super) fn patterns(entry: &Entry<'_>, what: &str) -> Result<Vec<Pattern>> {
    let elements = entry.elements("strings")?;
    if elements.is_empty() {
        return Err(entry.error(&format!("is empty; name the {what}, or leave the key out")));
    }
    elements.iter().map(pattern).collect()
}

/// A name or a glob.
pub(super) fn pattern(element: &Entry<'_>) -> Result<Pattern> {
    Ok(Pattern {
        text: element.string()?.to_owned(),
        line: element.line(),
    })
}
