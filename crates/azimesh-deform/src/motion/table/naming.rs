//! Names and units of the columns of a file that differ from the program's own.

use super::Table;
use azimesh_core::error::{Error, Result, nearest_name};
use std::collections::BTreeMap;
use std::f64::consts::PI;

const DEGREE: f64 = PI / 180.0;
/// Units with their sizes in m, radians or s.
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
/// Stations as parts of the distance from the hub to the end of the blade.
const RADIUS: &str = "radius";

/// The unit of a column: a known one, or a factor to the unit of the program's own name.
#[derive(Debug, Clone, PartialEq)]
pub enum Unit {
    /// Such as "mm".
    Named(String),
    /// Factor applied to the numbers of the file.
    Factor(f64),
}

impl From<&str> for Unit {
    fn from(name: &str) -> Self {
        Self::Named(name.to_owned())
    }
}

impl From<String> for Unit {
    fn from(name: String) -> Self {
        Self::Named(name)
    }
}

impl From<f64> for Unit {
    fn from(factor: f64) -> Self {
        Self::Factor(factor)
    }
}

/// Names and units of the columns of a file, by the program's own names.
#[derive(Debug, Clone, Default)]
pub struct Naming {
    /// Names in the file; columns without one have the program's own. A minus before a name changes the sign.
    pub columns: BTreeMap<String, String>,
    /// Units in the file.
    pub units: BTreeMap<String, Unit>,
}

/// Scales for lengths in a file.
#[derive(Debug, Clone, Copy)]
pub struct Scales<'a> {
    /// Name of the mesh unit, if the schedule gives it.
    pub length_unit: Option<&'a str>,
    /// The distance of the end of the blade from the hub, in mesh units, if there is a blade.
    pub radius: Option<f64>,
}

/// Names of columns in a file, with factors to the units of the program's own names.
#[derive(Debug, Clone, Default)]
pub struct ColumnNames {
    pub(super) in_file: BTreeMap<String, String>,
    pub(super) factors: BTreeMap<String, f64>,
    /// True if units may be given.
    pub(super) has_units: bool,
    /// True if a length was converted for a mesh in m, because the unit of the mesh is not given.
    pub assumes_metres: bool,
}

impl Naming {
    /// Refuses names that are not in `known`, duplicate names in the file, and unknown units. Returns the message and
    /// whether it is about `columns` or `units`.
    pub fn check(&self, known: &[&str]) -> std::result::Result<(), (&'static str, String)> {
        let columns = self.columns.keys().map(|name| ("columns", name));
        for (key, name) in columns.chain(self.units.keys().map(|name| ("units", name))) {
            if !known.contains(&name.as_str()) {
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
        let columns = self.columns.values();
        let mut theirs: Vec<&str> = columns.map(|name| unsigned(name).unwrap_or(name)).collect();
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
            let is_known = match unit {
                Unit::Named(unit) => known.contains(&unit.as_str()),
                Unit::Factor(factor) => !known.is_empty() && factor.is_finite() && *factor != 0.0,
            };
            if is_known {
                continue;
            }
            let all: Vec<String> = known.iter().map(|unit| format!("\"{unit}\"")).collect();
            let message = if known.is_empty() {
                format!("`{name}` has no unit")
            } else {
                let unit = match unit {
                    Unit::Named(unit) => format!("\"{unit}\""),
                    Unit::Factor(factor) => factor.to_string(),
                };
                format!(
                    "unit {unit} of `{name}` is not known; known: {}, or a factor other than 0",
                    all.join(", ")
                )
            };
            return Err(("units", message));
        }
        Ok(())
    }

    /// Adds the units in a line of the table, for columns in `known` that have none yet.
    ///
    /// # Errors
    /// If the unit of a used column is not of its kind.
    pub fn with_units_of(&self, table: &Table, known: &[&str]) -> Result<Self> {
        let mut all = self.clone();
        let Some((line, units)) = &table.units else {
            return Ok(all);
        };
        for name in known.iter().filter(|name| !self.units.contains_key(**name)) {
            let unit = self.place_in(table, name).map(|at| units[at].as_str());
            let Some(unit) = unit.filter(|unit| !["", "-"].contains(unit)) else {
                continue;
            };
            let known = known_units(name);
            if known.is_empty() {
                continue;
            }
            if !known.contains(&unit) {
                let message = format!(
                    "unit \"{unit}\" of `{name}` is not known; known: {}; `units` can give a factor",
                    known.join(", ")
                );
                return Err(Error::input(message).line(*line).file(&table.path));
            }
            all.units.insert((*name).to_owned(), unit.into());
        }
        Ok(all)
    }

    /// Returns the index of a column in the table.
    fn place_in(&self, table: &Table, name: &str) -> Option<usize> {
        let place = |name: &str| table.names.iter().position(|other| other == name);
        match self.columns.get(name) {
            Some(theirs) => place(theirs).or_else(|| place(unsigned(theirs)?)),
            None if self
                .columns
                .values()
                .any(|theirs| unsigned(theirs).unwrap_or(theirs) == name) =>
            {
                None
            }
            None => place(name),
        }
    }

    /// Returns the column of a rotation by its name here, and the entry of `columns` for the other sign.
    pub fn angle_in(&self, table: &Table, name: &str) -> (String, String) {
        let rad = name.replace("_deg", "_rad");
        let has_rad = self.columns.contains_key(&rad) || table.names.contains(&rad);
        let ours = if has_rad { rad } else { name.to_owned() };
        let theirs = self.columns.get(&ours).unwrap_or(&ours);
        let turned = unsigned(theirs).map_or_else(|| format!("-{theirs}"), str::to_owned);
        (ours, turned)
    }

    /// Returns the names with their factors; an error message if a length cannot be converted.
    pub fn resolve(&self, scales: Scales<'_>) -> std::result::Result<ColumnNames, String> {
        let mut names = ColumnNames {
            in_file: self.columns.clone(),
            has_units: true,
            ..ColumnNames::default()
        };
        for (name, unit) in &self.units {
            let unit = match unit {
                Unit::Named(unit) => unit,
                Unit::Factor(factor) => {
                    names.factors.insert(name.clone(), *factor);
                    continue;
                }
            };
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
    /// Returns whether unused columns are ignored.
    pub(super) fn passes_over(&self) -> bool {
        !self.in_file.is_empty()
    }

    /// Returns the name in the file of a column; `None` if the file uses this name for another column.
    pub(super) fn of<'a>(&'a self, name: &'a str) -> Option<&'a str> {
        match self.in_file.get(name) {
            Some(theirs) => Some(theirs),
            None if self.in_file.values().any(|theirs| theirs == name) => None,
            None => Some(name),
        }
    }

    /// Finds the columns of a table; a minus before a name that the table does not have changes the sign.
    ///
    /// # Errors
    /// If the table lacks a name.
    pub(super) fn found_in(mut self, table: &Table) -> Result<Self> {
        let is_there = |name: &str| table.names.iter().any(|other| other == name);
        for (ours, theirs) in &mut self.in_file {
            if is_there(theirs) {
                continue;
            }
            match unsigned(theirs).filter(|name| is_there(name)) {
                Some(name) => {
                    *self.factors.entry(ours.clone()).or_insert(1.0) *= -1.0;
                    *theirs = name.to_owned();
                }
                None => {
                    let theirs = unsigned(theirs).unwrap_or(theirs);
                    let names = table.names.iter().map(String::as_str);
                    let meant = nearest_name(theirs, names)
                        .map_or(";".to_owned(), |meant| format!("; did you mean `{meant}`?"));
                    return Err(table.header_error(format!(
                        "the table has no column `{theirs}`, which `columns` gives for `{ours}`{meant} found: {}",
                        table.names.join(", ")
                    )));
                }
            }
        }
        Ok(self)
    }
}

/// Returns the name behind a minus.
fn unsigned(name: &str) -> Option<&str> {
    name.strip_prefix('-').map(str::trim_start)
}

/// Returns whether the column of a name has lengths.
pub fn is_length(name: &str) -> bool {
    let names = [
        "station", "dx", "dy", "dz", "x", "y", "z", "x_new", "y_new", "z_new",
    ];
    names.contains(&name)
}

/// Returns the units that a column may have.
pub fn known_units(name: &str) -> Vec<&'static str> {
    let radius = (name == "station").then_some(RADIUS);
    let units = units_of(name).iter().map(|(unit, _)| *unit);
    units.chain(radius).collect()
}

fn units_of(name: &str) -> &'static [(&'static str, f64)] {
    match name {
        "time_s" => TIMES,
        _ if is_length(name) => LENGTHS,
        _ if name.ends_with("_deg") || name.ends_with("_rad") => ANGLES,
        _ => &[],
    }
}

/// Returns the size of the mesh unit in m.
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
