//! Pitch, flap and lag of a blade from a table over azimuth, time or step.

use super::clock::StepHistory;
use super::naming;
use super::{At, OnMesh, TableSource};
use crate::motion::steps::Step;
use crate::motion::table::{Column, History, Interpolation, Naming, Table};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::error::Result;

const COLUMNS: [&str; 3] = ["pitch", "flap", "lag"];
/// What `columns` and `units` may name.
pub(super) const NAMED: [&str; 10] = [
    "azimuth_deg",
    "azimuth_rad",
    "time_s",
    "step",
    "pitch_deg",
    "pitch_rad",
    "flap_deg",
    "flap_rad",
    "lag_deg",
    "lag_rad",
];

/// Angles at every step, in radians, without the signs of the rotor.
#[derive(Debug)]
pub(super) struct BladeAngles {
    history: StepHistory,
    /// Place of each of the three among the values; a column left out is 0.
    columns: [Option<usize>; 3],
    /// The largest size of each in a row.
    pub bound: [f64; 3],
    /// What the user should know of the table.
    pub notes: Vec<Diagnostic>,
}

impl BladeAngles {
    /// Reads `table` of `[body.cyclic]`; there must be values at every step.
    pub fn read(
        table: &TableSource,
        interpolation: Interpolation,
        naming: &Naming,
        on: &OnMesh<'_>,
    ) -> Result<Self> {
        let table = table.read(on, "cyclic.table")?;
        let names = naming::resolve(naming, on, None, "cyclic")?;
        let mut columns = table.columns_as(names.clone())?;
        let key = columns.require_key()?;
        let mut found = [None; 3];
        for (column, name) in found.iter_mut().zip(COLUMNS) {
            *column = columns.optional_angle(name)?;
        }
        let others = columns.done()?;
        if found.iter().all(Option::is_none) {
            let message = "the table has none of the columns pitch_deg, flap_deg, lag_deg";
            return Err(table.header_error(message));
        }
        check_plane(&table, &found, on)?;
        let present: Vec<Column> = found.iter().flatten().copied().collect();
        let history = History::from_table(&table, key, &present, interpolation)?;
        let mut next = 0..present.len();
        let largest = |column: Option<Column>| {
            let rows = column.into_iter().flat_map(|column| {
                let table = &table;
                (0..table.n_rows()).map(move |row| table.value(row, column).abs())
            });
            rows.fold(0.0, f64::max)
        };
        let history = StepHistory::new(history, on, "cyclic.table")?;
        let mut notes = naming::notes(naming, &names, &others, &table, &on.body.name);
        notes.extend(history.note.clone());
        Ok(Self {
            history,
            notes,
            bound: found.map(largest),
            columns: found.map(|column| column.and_then(|_| next.next())),
        })
    }

    /// Pitch, flap and lag at a step.
    pub fn angles(&self, step: &Step) -> [f64; 3] {
        self.three(&self.history.values(step))
    }

    /// Their rates, in radians a second.
    pub fn rates(&self, at: &At<'_>) -> [f64; 3] {
        self.three(&self.history.rates(at))
    }

    fn three(&self, values: &[f64]) -> [f64; 3] {
        self.columns.map(|at| at.map_or(0.0, |at| values[at]))
    }
}

/// Refuses an angle about an axis in the plane of a 2D mesh.
fn check_plane(table: &Table, found: &[Option<Column>; 3], on: &OnMesh<'_>) -> Result<()> {
    let [pitch, flap, lag] = *found;
    let leaving = match on.blade.is_upright() {
        _ if !on.blade.in_plane => return Ok(()),
        true => [pitch, flap],
        false => [flap, lag],
    };
    for column in leaving.into_iter().flatten() {
        if let Some(row) = (0..table.n_rows()).find(|&row| table.value(row, column) != 0.0) {
            let left = if on.blade.is_upright() {
                "lag_deg"
            } else {
                "pitch_deg"
            };
            let message = format!(
                "body \"{}\" would leave the plane of the 2D mesh; use only {left}",
                on.body.name
            );
            return Err(table.error(row, message));
        }
    }
    Ok(())
}
