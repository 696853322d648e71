//! Names and units that the columns of a file have in place of the program's own.

use super::Table;
use azimesh_core::error::{Result, nearest_name};
use std::collections::BTreeMap;
use std::f64::consts::PI;

const DEGREE: f64 = PI / 180.0;
/// Units with their sizes in m, in radians, in s.
const LENGTHS: &[(&str, f64)] = &[
    ("m", 1.0),
    ("mm", 1e-3),
    ("cm", 1e-2),
    ("km", 1e3),
    ("um", 1e-6),
    ("in", 0.0254),
    ("ft", 0.3048),
];
const ANGLES: &[(&str, f64)] = &[("deg", DEGREE), ("rad", 1.0)];
const TIMES: &[(&str, f64)] = &[
    ("s", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("min", 60.0),
    ("h", 3600.0),
];
/// Stations in parts of the distance from the hub to the end of the blade.
const RADIUS: &str = "radius";

/// What the columns of a file are called, and their units, by the program's own names.
#[derive(Debug, Clone, Default)]
pub struct Naming {
    /// Names in the file; columns without one have the program's own.
    pub columns: BTreeMap<String, String>,
    /// Units in the file.
    pub units: BTreeMap<String, String>,
}

/// What lengths in a file are converted by.
#[derive(Debug, Clone, Copy)]
pub struct Scales<'a> {
    /// What the mesh unit is called, where the schedule says.
    pub length_unit: Option<&'a str>,
    /// The distance of the end of the blade from the hub, in mesh units, where there is a blade.
    pub radius: Option<f64>,
}

/// Names of columns in a file, with factors to the units of the program's own names.
#[derive(Debug, Clone, Default)]
pub struct ColumnNames {
    pub(super) in_file: BTreeMap<String, String>,
    pub(super) factors: BTreeMap<String, f64>,
    /// True if a length in a unit of its own was taken for one of a mesh in m, since nothing is said of the mesh.
    pub assumes_metres: bool,
}

impl Naming {
    /// Refuses names that are not among `known`, a name in the file that is given twice, and units that there are
    /// not; the message and whether it is of `columns` or of `units`.
    pub fn check(&self, known: &[&str]) -> std::result::Result<(), (&'static str, String)> {
        for (key, names) in [("columns", &self.columns), ("units", &self.units)] {
            if let Some(name) = names.keys().find(|name| !known.contains(&name.as_str())) {
                let meant = nearest_name(name, known.iter().copied());
                let meant =
                    meant.map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
                let known = known.join(", ");
                return Err((
                    key,
                    format!("unknown column `{name}` in `{key}`{meant} known: {known}"),
                ));
            }
        }
        let mut theirs: Vec<&String> = self.columns.values().collect();
        theirs.sort();
        if let Some(pair) = theirs.windows(2).find(|pair| pair[0] == pair[1]) {
            let message = format!(
                "`columns` gives the column `{}` two names; keep one of them",
                pair[0]
            );
            return Err(("columns", message));
        }
        for (name, unit) in &self.units {
            let known = known_units(name);
            if known.contains(&unit.as_str()) {
                continue;
            }
            let all: Vec<String> = known.iter().map(|unit| format!("\"{unit}\"")).collect();
            let message = if known.is_empty() {
                format!("`{name}` has no unit")
            } else {
                format!(
                    "unit \"{unit}\" of `{name}` is not known; known: {}",
                    all.join(", ")
                )
            };
            return Err(("units", message));
        }
        Ok(())
    }

    /// The names with their factors; an error in words where a length cannot be converted.
    pub fn resolve(&self, scales: Scales<'_>) -> std::result::Result<ColumnNames, String> {
        let mut names = ColumnNames {
            in_file: self.columns.clone(),
            ..ColumnNames::default()
        };
        for (name, unit) in &self.units {
            let size = |units: &[(&str, f64)]| {
                let found = units.iter().find(|(other, _)| other == unit);
                found.map(|(_, size)| *size)
            };
            let factor = match (scales.radius, size(units_of(name))) {
                (Some(radius), None) if unit == RADIUS => radius,
                (_, Some(size)) if is_length(name) => {
                    names.assumes_metres |= scales.length_unit.is_none();
                    size / metres(scales.length_unit.unwrap_or("m"), name, unit)?
                }
                (_, Some(size)) if name.ends_with("_deg") => size / DEGREE,
                (_, Some(size)) => size,
                (_, None) => return Err(format!("unit \"{unit}\" of `{name}` needs a blade")),
            };
            names.factors.insert(name.clone(), factor);
        }
        Ok(names)
    }
}

impl ColumnNames {
    /// Returns whether columns that nobody asks for are passed over.
    pub(super) fn passes_over(&self) -> bool {
        !self.in_file.is_empty()
    }

    /// The name in the file of a column; `None` where the file has this name for another.
    pub(super) fn of<'a>(&'a self, name: &'a str) -> Option<&'a str> {
        match self.in_file.get(name) {
            Some(theirs) => Some(theirs),
            None if self.in_file.values().any(|theirs| theirs == name) => None,
            None => Some(name),
        }
    }

    /// Refuses names that the table does not have.
    pub(super) fn check(&self, table: &Table) -> Result<()> {
        let missing = |pair: &(&String, &String)| !table.names.contains(pair.1);
        match self.in_file.iter().find(missing) {
            None => Ok(()),
            Some((ours, theirs)) => Err(table.header_error(format!(
                "the table has no column `{theirs}`, which `columns` gives for `{ours}`; found: {}",
                table.names.join(", ")
            ))),
        }
    }
}

fn is_length(name: &str) -> bool {
    ["station", "dx", "dy", "dz"].contains(&name)
}

/// Units that the column of a name may have.
pub fn known_units(name: &str) -> Vec<&'static str> {
    let radius = (name == "station").then_some(RADIUS);
    let units = units_of(name).iter().map(|(unit, _)| *unit);
    units.chain(radius).collect()
}

fn units_of(name: &str) -> &'static [(&'static str, f64)] {
    match name {
        "time_s" => TIMES,
        "step" => &[],
        _ if is_length(name) => LENGTHS,
        _ => ANGLES,
    }
}

/// The size of the mesh unit in m.
fn metres(mesh_unit: &str, name: &str, unit: &str) -> std::result::Result<f64, String> {
    let found = LENGTHS.iter().find(|(other, _)| *other == mesh_unit);
    found.map(|(_, size)| *size).ok_or_else(|| {
        let known: Vec<&str> = LENGTHS.iter().map(|(unit, _)| *unit).collect();
        format!(
            "`{name}` is in {unit}, which cannot be converted to `length_unit` = \"{mesh_unit}\" in [output]; known: {}",
            known.join(", ")
        )
    })
}
