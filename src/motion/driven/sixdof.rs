//! Six degrees of freedom over azimuth, time or step.

use super::Clock;
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::motion::body::{Body, TableMotion};
use crate::motion::steps::Step;
use crate::motion::table::{Column, Columns, History, Table};
use crate::motion::turn::{Displaced, Turn};
use std::path::Path;

/// Axes that a body in the plane cannot be moved along or turned about, as columns.
const OUT_OF_PLANE: [usize; 3] = [2, 3, 4];
const COLUMNS: [&str; 6] = ["dx", "dy", "dz", "rot_x", "rot_y", "rot_z"];

/// A table of `dx, dy, dz, rot_x, rot_y, rot_z`.
#[derive(Debug, Clone)]
pub(in crate::motion) struct SixDegrees {
    history: History,
    /// Place of each of the six among the values; a column left out is 0.
    columns: [Option<usize>; 6],
    origin: Vector,
}

impl SixDegrees {
    /// Reads the table at `path`; it must have values at every step.
    pub fn read(
        motion: &TableMotion,
        path: &Path,
        body: &Body,
        clock: &Clock<'_>,
        in_plane: bool,
    ) -> Result<Self> {
        let table = Table::read(path)?;
        let mut columns = table.columns();
        let key = columns.require_key()?;
        let found = six(&mut columns)?;
        columns.done()?;
        if found.iter().all(Option::is_none) {
            let message =
                "the table has none of the columns dx, dy, dz, rot_x_deg, rot_y_deg, rot_z_deg";
            return Err(table.header_error(message));
        }
        if in_plane {
            check_plane(&table, &found, body)?;
        }
        let present: Vec<Column> = found.iter().flatten().copied().collect();
        let mut next = 0..present.len();
        let history = History::from_table(&table, key, &present, motion.interpolation)?;
        clock.check(&history, body.azimuth_offset, motion.line)?;
        Ok(Self {
            history,
            columns: found.map(|column| column.and_then(|_| next.next())),
            origin: motion.origin,
        })
    }

    /// Rotations about x, y, z through the origin, in this order, then the translation.
    pub fn at(&self, step: &Step, offset: f64, clock: &Clock<'_>) -> Displaced {
        let key = self.history.key();
        let place = Clock::place(key, step, offset).expect("the history was checked at every step");
        let promise = "the history was checked at every step";
        let values = self.history.at(place).expect(promise);
        let rates = self.history.rates_at(place).expect(promise);
        let each = clock.rate(key, step);
        let of = |values: &[f64], i: usize| self.columns[i].map_or(0.0, |at| values[at]);
        let turn = |axis: usize| Turn {
            axis: std::array::from_fn(|i| f64::from(u8::from(i == axis))),
            origin: self.origin,
            angle: of(&values, 3 + axis),
            rate: each * of(&rates, 3 + axis),
        };
        Displaced {
            turns: (0..3)
                .filter(|axis| self.columns[3 + axis].is_some())
                .map(turn)
                .collect(),
            translation: std::array::from_fn(|i| of(&values, i)),
            rate: std::array::from_fn(|i| each * of(&rates, i)),
        }
    }

    /// What it turns about, where it turns at all.
    pub fn centre(&self) -> Option<Vector> {
        let turns = self.columns[3..].iter().any(Option::is_some);
        turns.then_some(self.origin)
    }
}

/// The six columns; those of a wrong name are refused when all are taken.
fn six(columns: &mut Columns<'_>) -> Result<[Option<Column>; 6]> {
    let mut found = [None; 6];
    for (i, name) in COLUMNS.iter().enumerate() {
        found[i] = match i {
            0..3 => columns.optional(name),
            _ => columns.optional_angle(name)?,
        };
    }
    Ok(found)
}

fn check_plane(table: &Table, columns: &[Option<Column>; 6], body: &Body) -> Result<()> {
    for i in OUT_OF_PLANE {
        let Some(column) = columns[i] else { continue };
        if let Some(row) = (0..table.n_rows()).find(|&row| table.value(row, column) != 0.0) {
            return Err(leaves_plane(table, row, COLUMNS[i], body));
        }
    }
    Ok(())
}

fn leaves_plane(table: &Table, row: usize, column: &str, body: &Body) -> Error {
    table.error(
        row,
        format!(
            "`{column}` is not 0, and body \"{}\" would leave the plane of the 2D mesh; dx, dy and rot_z_deg stay in it",
            body.name
        ),
    )
}
