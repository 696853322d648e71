//! Tables that a schedule names: CSV files of numbers, and interpolation between their rows.
//!
//! ```text
//! file ── Table ── Columns: by name ──┬─ History       values over azimuth, time or step
//!                                     └─ SpanHistory   such values at every station of a blade
//! ```
//!
//! Owns the file format, its errors by line, and interpolation between rows. The motions choose the columns and the
//! meaning of the numbers.

mod columns;
mod foam;
mod history;
mod key;
mod naming;
mod period;
mod rotation;
mod span;
mod spline;
mod text;

pub use columns::{Column, Columns};
pub use history::{History, Interpolation};
pub use key::Key;
pub use naming::{ColumnNames, Naming, Scales, Unit, is_length, known_units};
pub use period::{ADD, Period, why as why_once};
pub use rotation::RotationForm;
pub use span::{SpanHistory, SpanValues};

use azimesh_core::error::{Error, Result};
use azimesh_io::formats::Source;
use std::path::{Path, PathBuf};

/// Placeholder for the path of a table in memory.
const IN_MEMORY: &str = "table in memory";

/// A table of finite numbers under named columns.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Table};
///
/// // Plunge over time, in s and mesh units; angles would be `rot_x_deg`, `rot_y_deg`, `rot_z_deg`.
/// let table = Table::from_rows(["time_s", "dy"], [[0.0, 0.0], [0.5, 0.1], [1.0, 0.0]]);
/// let airfoil = Body::new("airfoil", ["airfoil"]).table(table);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Table {
    path: PathBuf,
    names: Vec<String>,
    /// Units in a line below the names, which may be empty, with the number of that line.
    units: Option<(u64, Vec<String>)>,
    /// The form of its rotations, where the format of the file says.
    rotation: Option<RotationForm>,
    /// Line of the names.
    header: u64,
    /// By rows.
    values: Vec<f64>,
    /// Line of each row.
    lines: Vec<u32>,
    /// An invalid row of a table in memory, with the error.
    wrong: Option<(usize, String)>,
}

impl Table {
    /// Reads a CSV file: names of the columns, then rows of numbers between commas, semicolons, tabs or blanks. A
    /// line of units in brackets may follow the names. Blank lines and comments after `#` are ignored; a header
    /// behind a `#` is found. The table of OpenFOAM's `tabulated6DoFMotion` is read too.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let source = Source::open(path.as_ref())?;
        Self::parse(source.bytes(), path.as_ref())
    }

    /// Reads a table from the bytes of a CSV file; `path` is named in errors.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let table = if foam::is_list(bytes) {
            foam::parse(bytes, path)
        } else {
            text::parse(bytes, path)
        };
        table.map_err(|error| error.file(path))
    }

    /// Creates a table from the names of its columns and rows of a number for each. Errors name a row by its number, from 1. A
    /// row of another length or with a number that is not finite is an error when the table is used.
    pub fn from_rows(
        columns: impl IntoIterator<Item = impl Into<String>>,
        rows: impl IntoIterator<Item = impl AsRef<[f64]>>,
    ) -> Self {
        let mut table = Self {
            path: PathBuf::from(IN_MEMORY),
            names: columns.into_iter().map(Into::into).collect(),
            ..Self::default()
        };
        let n = table.names.len();
        for (at, row) in rows.into_iter().enumerate() {
            let row = row.as_ref();
            if table.wrong.is_none() && (row.len() != n || !row.iter().all(|x| x.is_finite())) {
                let message =
                    format!("{row:?} is not a row of {n} finite numbers, one for each column");
                table.wrong = Some((at, message));
            }
            table.values.extend(row);
            table.lines.push(u32::try_from(at + 1).unwrap_or(u32::MAX));
        }
        table
    }

    /// Refuses an invalid table in memory.
    pub(super) fn check(&self) -> Result<()> {
        match &self.wrong {
            Some((row, message)) => Err(self.error(*row, message)),
            None if self.lines.is_empty() => Err(self.header_error("the table has no rows")),
            None => Ok(()),
        }
    }

    /// Picks columns by name.
    pub fn columns(&self) -> Columns<'_> {
        Columns::new(self, ColumnNames::default())
    }

    /// Picks columns that may have other names and units.
    pub fn columns_as(&self, names: ColumnNames) -> Result<Columns<'_>> {
        Ok(Columns::new(self, names.found_in(self)?))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The form of its rotations, where the format of the file says.
    pub fn rotation(&self) -> Option<RotationForm> {
        self.rotation
    }

    /// Returns the table with three more columns of radians.
    fn with_angles(&self, names: [&str; 3], angles: &[[f64; 3]]) -> (Self, [Column; 3]) {
        let width = self.names.len();
        let rows = self.values.chunks_exact(width).zip(angles);
        let values = rows.flat_map(|(row, angles)| row.iter().chain(angles));
        let table = Self {
            path: self.path.clone(),
            names: self
                .names
                .iter()
                .cloned()
                .chain(names.map(str::to_owned))
                .collect(),
            values: values.copied().collect(),
            header: self.header,
            lines: self.lines.clone(),
            ..Self::default()
        };
        (
            table,
            std::array::from_fn(|i| Column {
                index: width + i,
                factor: 1.0,
            }),
        )
    }

    /// Number of rows, at least one.
    pub fn n_rows(&self) -> usize {
        self.lines.len()
    }

    /// Returns the number in a row and column, in radians if the column holds angles.
    pub fn value(&self, row: usize, column: Column) -> f64 {
        column.factor * self.values[row * self.names.len() + column.index]
    }

    /// Reads a number that must be whole and not negative, such as a node number.
    pub fn whole(&self, row: usize, column: Column) -> Result<u64> {
        let value = self.value(row, column);
        // Whole numbers up to here are exact.
        if value.fract() == 0.0 && (0.0..=9e15).contains(&value) {
            return Ok(value as u64);
        }
        let name = &self.names[column.index];
        let message = format!("column `{name}` has {value}; it must be a whole number, 0 or more");
        Err(self.error(row, message))
    }

    /// One-based line of a row.
    pub fn line(&self, row: usize) -> u64 {
        u64::from(self.lines[row])
    }

    /// Returns an error at a row.
    pub fn error(&self, row: usize, message: impl Into<String>) -> Error {
        Error::input(message).line(self.line(row)).file(&self.path)
    }

    /// Returns an error at a row, or at the names of the columns without one.
    pub fn error_at(&self, row: Option<usize>, message: impl Into<String>) -> Error {
        match row {
            Some(row) => self.error(row, message),
            None => self.header_error(message),
        }
    }

    /// Returns an error at the names of the columns.
    pub fn header_error(&self, message: impl Into<String>) -> Error {
        Error::input(message).line(self.header).file(&self.path)
    }
}

#[cfg(test)]
mod tests;
