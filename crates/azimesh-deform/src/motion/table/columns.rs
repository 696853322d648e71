//! Columns of a table, picked by name in any order.

use super::{ColumnNames, Key, RotationForm, Table, is_length};
use azimesh_core::error::{Error, Result, nearest_name};
use std::f64::consts::PI;

/// A column that was picked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    pub(super) index: usize,
    /// Factor from the file's unit to the program's.
    pub(super) factor: f64,
}

/// Selection of columns; `done` refuses unknown ones.
#[derive(Debug)]
pub struct Columns<'a> {
    table: &'a Table,
    /// Their names in the file.
    names: ColumnNames,
    /// Known names.
    known: Vec<String>,
    taken: Vec<bool>,
}

impl<'a> Columns<'a> {
    pub(super) fn new(table: &'a Table, names: ColumnNames) -> Self {
        Self {
            table,
            names,
            known: Vec::new(),
            taken: vec![false; table.names.len()],
        }
    }

    /// Returns whether the table has a column of this name.
    pub fn has(&self, name: &str) -> bool {
        let in_file = self.names.of(name);
        in_file.is_some_and(|name| self.table.names.iter().any(|other| other == name))
    }

    /// A column that may be left out.
    pub fn optional(&mut self, name: &str) -> Option<Column> {
        self.scaled(name, 1.0)
    }

    /// A column that must be there.
    pub fn require(&mut self, name: &str) -> Result<Column> {
        self.optional(name).ok_or_else(|| self.missing(name))
    }

    /// Angles, `<stem>_deg` or `<stem>_rad`, that may be left out.
    pub fn optional_angle(&mut self, stem: &str) -> Result<Option<Column>> {
        let (deg, rad) = (format!("{stem}_deg"), format!("{stem}_rad"));
        let found = (self.scaled(&deg, PI / 180.0), self.scaled(&rad, 1.0));
        match found {
            (Some(_), Some(_)) => Err(self.both(&deg, &rad)),
            (deg, rad) => Ok(deg.or(rad)),
        }
    }

    /// Angles that must be there.
    pub fn require_angle(&mut self, stem: &str) -> Result<Column> {
        let found = self.optional_angle(stem)?;
        found.ok_or_else(|| self.missing(&format!("{stem}_deg")))
    }

    /// Picks the key of a row, in its own unit: `azimuth_deg`, `azimuth_rad`, `time_s` or `step`.
    pub fn optional_key(&mut self) -> Result<Option<(Key, Column)>> {
        let mut found: Option<(Key, Column)> = None;
        for key in Key::ALL {
            if let Some(column) = self.optional(key.name()) {
                if let Some((other, _)) = found {
                    return Err(self.both(other.name(), key.name()));
                }
                found = Some((key, column));
            }
        }
        Ok(found)
    }

    /// The key column; an error where there is none.
    pub fn require_key(&mut self) -> Result<(Key, Column)> {
        let found = self.optional_key()?;
        found.ok_or_else(|| self.missing("azimuth_deg"))
    }

    /// All columns that were not picked, in the order of the file.
    pub fn rest(&mut self) -> Vec<(&'a str, Column)> {
        let names: &'a [String] = &self.table.names;
        let mut rest = Vec::new();
        for (index, name) in names.iter().enumerate() {
            if !self.taken[index] {
                self.taken[index] = true;
                rest.push((name.as_str(), Column { index, factor: 1.0 }));
            }
        }
        rest
    }

    /// Refuses a column that was not picked. In a file with its own names, such columns are ignored and returned.
    ///
    /// # Errors
    /// Also if the table has a line of units that no reader has used.
    pub fn done(self) -> Result<Vec<String>> {
        if let Some((line, _)) = self.table.units.as_ref().filter(|_| !self.names.has_units) {
            let message = "this table has no `units`, and so no line of them; remove it, and give lengths in mesh units, times in s";
            return Err(Error::input(message).line(*line).file(&self.table.path));
        }
        let Some(index) = self.taken.iter().position(|taken| !taken) else {
            return Ok(Vec::new());
        };
        if self.names.passes_over() {
            let columns = self.table.names.iter().zip(&self.taken);
            let others = columns.filter(|(_, taken)| !**taken);
            return Ok(others.map(|(name, _)| name.clone()).collect());
        }
        let name = &self.table.names[index];
        let known = || self.known.iter().map(String::as_str);
        let free = known().filter(|known| !self.has(known));
        let units = ["deg", "rad"].map(|unit| format!("{name}_{unit}"));
        let needed = RotationForm::default().needed_for(name);
        let meant = match nearest_name(name, free) {
            _ if needed.is_some() => format!("; it needs {};", needed.unwrap_or_default()),
            _ if units.iter().all(|unit| self.known.contains(unit)) => {
                format!("; did you mean `{}` or `{}`?", units[0], units[1])
            }
            Some(meant) => format!("; did you mean `{meant}`?"),
            None => ";".to_owned(),
        };
        let known: Vec<&str> = known().collect();
        let known = known.join(", ");
        let message = format!("unknown column `{name}`{meant} known columns: {known}");
        Err(self.table.header_error(message))
    }

    fn scaled(&mut self, name: &str, factor: f64) -> Option<Column> {
        self.known.push(name.to_owned());
        let in_file = self.names.of(name)?;
        let index = self.table.names.iter().position(|other| other == in_file)?;
        self.taken[index] = true;
        let unit = self.names.factors.get(name).copied().unwrap_or(1.0);
        Some(Column {
            index,
            factor: factor * unit,
        })
    }

    fn missing(&self, name: &str) -> Error {
        let found = self.table.names.join(", ");
        let (wanted, missing) = match name {
            "azimuth_deg" => (
                Key::ALL.map(Key::name).to_vec(),
                "`azimuth_deg`, `azimuth_rad`, `time_s` or `step`".to_owned(),
            ),
            name => match name.strip_suffix("_deg") {
                Some(stem) => (vec![name], format!("`{name}` or `{stem}_rad`")),
                None => (vec![name], format!("`{name}`")),
            },
        };
        let others = || {
            self.table
                .names
                .iter()
                .map(String::as_str)
                .filter(|name| !is_ours(name))
        };
        let meant = wanted
            .iter()
            .find_map(|name| Some((name, nearest_name(name, others())?)));
        let meant = meant.map_or(String::new(), |(name, theirs)| match self.names.has_units {
            true => format!(" if it is `{theirs}`, write  columns = {{ {name} = \"{theirs}\" }};"),
            false => format!(" if it is `{theirs}`, call it `{name}`;"),
        });
        let message = format!("the table has no column {missing};{meant} found: {found}");
        self.table.header_error(message)
    }

    /// Returns the error of two columns for the same value.
    pub fn both(&self, one: &str, other: &str) -> Error {
        let message =
            format!("columns `{one}` and `{other}` have the same meaning; keep one of them");
        self.table.header_error(message)
    }
}

/// Returns whether a name has a meaning of its own in some table.
fn is_ours(name: &str) -> bool {
    let stem = name.trim_end_matches("_deg").trim_end_matches("_rad");
    let angles = [
        "azimuth", "rot_x", "rot_y", "rot_z", "pitch", "flap", "lag", "angle",
    ];
    let others = ["time_s", "step", "node", "mode"];
    is_length(name)
        || (stem != name && angles.contains(&stem))
        || others.contains(&name)
        || ["quat_", "wm_"].iter().any(|start| name.starts_with(start))
}
