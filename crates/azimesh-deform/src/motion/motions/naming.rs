//! Columns of a table by the names and units of the program that wrote it: `columns` and `units` of a motion.

use super::clock::StepHistory;
use super::{At, OnMesh, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{Kind, object};
use crate::motion::reader::Entry;
use crate::motion::steps::Step;
use crate::motion::table::{
    Column, ColumnNames, History, Interpolation, Naming, RotationForm, Scales, Table, Unit,
    is_length, known_units,
};
use azimesh_core::error::{Result, counted};
use azimesh_core::{Note, note};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A motion whose table may have other names and units.
pub(in crate::motion) trait NamedColumns {
    /// Names of its columns here, separated by blanks.
    const COLUMNS: &'static str;

    fn names() -> Vec<&'static str> {
        Self::COLUMNS.split(' ').collect()
    }
}

/// Names of columns in the file.
pub(super) const fn columns<M: NamedColumns>() -> Kind<BTreeMap<String, String>> {
    Kind {
        words: "table of strings",
        read: |entry| {
            let title = "columns = { name = \"name in the file\" }";
            read(entry, title, &M::names(), |name| Ok(name.string()?.into()))
        },
        schema: || schema(M::names(), |_| json!({ "type": "string", "minLength": 1 })),
    }
}

/// Units of columns in the file.
pub(super) const fn units<M: NamedColumns>() -> Kind<BTreeMap<String, Unit>> {
    Kind {
        words: "table of strings or factors",
        read: |entry| {
            let title = "units = { name = \"unit in the file\" }";
            read(entry, title, &M::names(), |unit| match unit.number() {
                Ok(factor) => Ok(Unit::Factor(factor)),
                Err(_) => Ok(unit.string()?.into()),
            })
        },
        schema: || {
            let names = M::names().into_iter();
            let with_units = names.filter(|name| !known_units(name).is_empty());
            schema(
                with_units.collect(),
                |name| json!({ "anyOf": [{ "enum": known_units(name) }, { "type": "number" }] }),
            )
        },
    }
}

fn read<T>(
    entry: &Entry<'_>,
    title: &'static str,
    known: &[&str],
    value: impl Fn(&Entry<'_>) -> Result<T>,
) -> Result<BTreeMap<String, T>> {
    let section = entry.section(title, known)?;
    let mut names = BTreeMap::new();
    for name in known {
        if let Some(value) = section.optional(name, &value)? {
            names.insert((*name).to_owned(), value);
        }
    }
    Ok(names)
}

fn schema(names: Vec<&str>, of: impl Fn(&str) -> Value) -> Value {
    let names = names.into_iter();
    object(
        names.map(|name| (name.to_owned(), of(name))).collect(),
        Vec::new(),
    )
}

/// Refuses unknown names and units; `key` is the key of the motion.
pub(super) fn check<M: NamedColumns>(naming: &Naming, body: &Body, key: &str) -> Result<()> {
    let checked = naming.check(&M::names());
    checked.map_err(|(of, message)| body.places.error(&format!("{key}.{of}"), message))
}

/// Refuses names and units of columns that rotations in this form do not have.
pub(super) fn check_rotation(
    naming: &Naming,
    form: Option<RotationForm>,
    body: &Body,
    key: &str,
) -> Result<()> {
    let names = naming.columns.keys().map(|name| ("columns", name));
    for (of, name) in names.chain(naming.units.keys().map(|name| ("units", name))) {
        if let Some(needed) = form.unwrap_or_default().needed_for(name) {
            let message = format!("`{name}` needs {needed}");
            return Err(body.places.error(&format!("{key}.{of}"), message));
        }
    }
    Ok(())
}

/// The form of the rotations in a table: what the schedule gives, or the format of the file.
pub(super) fn rotation_of(
    table: &Table,
    given: Option<RotationForm>,
    on: &OnMesh<'_>,
    key: &str,
) -> Result<RotationForm> {
    match (given, table.rotation()) {
        (Some(given), Some(own)) if given != own => Err(on.error(
            &format!("{key}.rotation"),
            "the angles of OpenFOAM's table are \"euler_xyz\"; leave `rotation` out",
        )),
        (given, own) => Ok(given.or(own).unwrap_or_default()),
    }
}

/// Returns the names in a file, and factors of their units. A blade ends at `radius` from the hub. `key` is the key of
/// the motion.
pub(super) fn resolve(
    naming: &Naming,
    on: &OnMesh<'_>,
    radius: Option<f64>,
    key: &str,
) -> Result<ColumnNames> {
    let scales = Scales {
        length_unit: on.length_unit,
        radius,
    };
    let names = naming.resolve(scales);
    names.map_err(|message| on.error(&format!("{key}.units"), message))
}

/// Returns notes: ignored columns, and a mesh that is assumed to be in m.
pub(super) fn notes(
    naming: &Naming,
    names: &ColumnNames,
    passed_over: &[String],
    table: &Table,
    body: &str,
) -> Vec<Note> {
    let mut notes = Vec::new();
    if !passed_over.is_empty() {
        notes.push(note!(
            "other_columns",
            "body \"{body}\": passed over {} that `columns` does not name: {}",
            counted(passed_over.len(), "column"),
            passed_over.join(", ")
        ));
    }
    if names.assumes_metres {
        let lengths = naming.units.iter().filter(|(name, _)| is_length(name));
        let lengths = lengths.filter_map(|(name, unit)| match unit {
            Unit::Named(unit) if unit != "radius" => Some(format!("{name} in {unit}")),
            _ => None,
        });
        notes.push(note!(
            "assumes_metres",
            "body \"{body}\": {} is converted for a mesh in m; for another write for example  length_unit = \"mm\"  in [output]",
            lengths.collect::<Vec<_>>().join(", ")
        ));
    }
    let at_file = |note: Note| note.file(table.path());
    notes.into_iter().map(at_file).collect()
}

/// Values over the steps from columns of a table, 0 for a missing column.
#[derive(Debug)]
pub(super) struct ColumnValues<const N: usize> {
    history: StepHistory,
    /// Index of each among the values of the history.
    columns: [Option<usize>; N],
    /// Largest magnitude of each in any row.
    pub bound: [f64; N],
    /// The form of the rotations, as they are interpolated.
    pub rotation: RotationForm,
    /// Notes on the table.
    pub notes: Vec<Note>,
}

/// A table as a motion declares it; `key` is the key of the motion in the schedule, `place` the key of the table.
pub(super) struct NamedTable<'a> {
    pub table: &'a TableSource,
    pub interpolation: Interpolation,
    pub naming: &'a Naming,
    pub rotation: Option<RotationForm>,
    /// Columns that it may have.
    pub known: Vec<&'static str>,
    pub key: &'a str,
    pub place: &'a str,
}

impl<const N: usize> ColumnValues<N> {
    /// Reads lengths (`dx`) and angles (`rot_x`, a column `rot_x_deg` or `rot_x_rad`) of these names, at least one; every
    /// step needs values. The last three may be rotations in another form. `refused` returns an error message for a name that may
    /// only be 0, by the index of the name and the column.
    pub fn read(
        source: &NamedTable<'_>,
        names: [&str; N],
        on: &OnMesh<'_>,
        refused: impl Fn(usize, &str) -> Option<String>,
    ) -> Result<Self> {
        let table = source.table.read(on, source.place)?;
        let naming = source.naming.with_units_of(&table, &source.known)?;
        let rotation = rotation_of(&table, source.rotation, on, source.key)?;
        let in_file = resolve(&naming, on, None, source.key)?;
        let mut columns = table.columns_as(in_file.clone())?;
        let key = columns.require_key()?;
        let mut found = [None; N];
        let mut turns = Vec::new();
        for (column, name) in found.iter_mut().zip(names) {
            match name {
                "rot_x" => turns = rotation.pick(&mut columns)?,
                "rot_y" | "rot_z" => {}
                name if is_length(name) => *column = columns.optional(name),
                name => *column = columns.optional_angle(name)?,
            }
        }
        let others = columns.done()?;
        let mut of_turns = rotation.columns().into_iter();
        let names = names.map(|name| match name {
            name if is_length(name) => name.to_owned(),
            name if name.starts_with("rot_") => of_turns.next().unwrap_or(name).to_owned(),
            name => format!("{name}_deg"),
        });
        let (table, vectors) = match turns[..] {
            [] => (table, [None; 3]),
            _ => rotation.vectors(table, &turns, true)?,
        };
        if !turns.is_empty() {
            found[N - 3..].copy_from_slice(&vectors);
        }
        if found.iter().all(Option::is_none) {
            let names = names.join(", ");
            return Err(table.header_error(format!("the table has none of the columns {names}")));
        }
        let rows = |column: Column| {
            let table = &table;
            (0..table.n_rows()).map(move |row| table.value(row, column).abs())
        };
        for (i, column) in found.iter().enumerate() {
            if let (Some(column), Some(message)) = (*column, refused(i, &names[i]))
                && let Some(row) = rows(column).position(|size| size != 0.0)
            {
                return Err(table.error(row, message));
            }
        }
        let present: Vec<Column> = found.iter().flatten().copied().collect();
        let mut next = 0..present.len();
        let history = History::from_table(&table, key, &present, source.interpolation)?;
        let history = StepHistory::new(history, on, source.place)?;
        let mut notes = notes(&naming, &in_file, &others, &table, &on.body.name);
        notes.extend(history.note.clone());
        Ok(Self {
            history,
            notes,
            rotation,
            bound: found
                .map(|column| column.map_or(0.0, |column| rows(column).fold(0.0, f64::max))),
            columns: found.map(|column| column.and_then(|_| next.next())),
        })
    }

    /// Returns whether the table has a column.
    pub fn has(&self, column: usize) -> bool {
        self.columns[column].is_some()
    }

    /// Returns the values at a step.
    pub fn at(&self, step: &Step) -> [f64; N] {
        self.each(&self.history.values(step))
    }

    /// Returns their rates per second.
    pub fn rates(&self, at: &At<'_>) -> [f64; N] {
        self.each(&self.history.rates(at))
    }

    fn each(&self, values: &[f64]) -> [f64; N] {
        self.columns.map(|at| at.map_or(0.0, |at| values[at]))
    }
}
