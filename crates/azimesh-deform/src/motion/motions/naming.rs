//! `columns` and `units` of a motion: what a file of another program calls its columns, and their units.

use super::OnMesh;
use crate::motion::body::Body;
use crate::motion::reader::{Entry, Section};
use crate::motion::table::{ColumnNames, Naming, Scales, Table};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::motion::MotionNote;
use azimesh_core::error::Result;

/// Reads `columns` and `units`, by the names of `known`.
pub(super) fn read(section: &Section<'_>, known: &[&str]) -> Result<Naming> {
    let mut naming = Naming::default();
    for (key, title, names) in [
        (
            "columns",
            "columns = { name = \"name in the file\" }",
            &mut naming.columns,
        ),
        (
            "units",
            "units = { name = \"unit in the file\" }",
            &mut naming.units,
        ),
    ] {
        let Some(entry) = section.get(key) else {
            continue;
        };
        let found = entry.section(title, known)?;
        for name in known {
            if let Some(value) = found.optional(name, Entry::string)? {
                names.insert((*name).to_owned(), value.to_owned());
            }
        }
    }
    Ok(naming)
}

/// Refuses names and units that there are not; the motion is under `key`.
pub(super) fn check(naming: &Naming, known: &[&str], body: &Body, key: &str) -> Result<()> {
    let checked = naming.check(known);
    checked.map_err(|(of, message)| body.places.error(&format!("{key}.{of}"), message))
}

/// The names in a file, and factors of their units; a blade ends at `radius` from the hub. The motion is under `key`.
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

/// What the user should know: columns that are passed over, and a mesh that is taken to be in m.
pub(super) fn notes(
    naming: &Naming,
    names: &ColumnNames,
    passed_over: &[String],
    table: &Table,
    body: &str,
) -> Vec<Diagnostic> {
    let mut notes = Vec::new();
    if !passed_over.is_empty() {
        notes.push(MotionNote::OtherColumns {
            body: body.to_owned(),
            columns: passed_over.to_vec(),
        });
    }
    if names.assumes_metres {
        let lengths = ["station", "dx", "dy", "dz"].into_iter();
        let told = lengths.filter_map(|name| {
            let unit = naming.units.get(name)?;
            (unit != "radius").then(|| format!("{name} in {unit}"))
        });
        notes.push(MotionNote::AssumesMetres {
            body: body.to_owned(),
            lengths: told.collect(),
        });
    }
    let at_file = |note| Diagnostic::new(note).file(table.path());
    notes.into_iter().map(at_file).collect()
}
