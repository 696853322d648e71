//! steps.csv: the finished steps, one row each, in order.

use crate::record::{CHECKSUM, COLUMNS, lines};
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::read_file;
use std::path::PathBuf;

/// The rows of one table or of the tables of several parts.
#[derive(Debug, Clone, Default)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads tables with the same columns; rows come in the order of their steps, each step once.
    pub fn read(paths: &[PathBuf]) -> Result<Self> {
        let mut table = Self::default();
        for path in paths {
            let bytes = read_file(path);
            let bytes = bytes.map_err(|error| Error::io(path, &error))?;
            table.append(&bytes).map_err(|error| error.file(path))?;
        }
        let steps = table.numbers("step");
        let mut rows: Vec<(f64, Vec<String>)> = Vec::with_capacity(steps.len());
        for (step, row) in steps.into_iter().zip(table.rows) {
            rows.push((step.unwrap_or(f64::INFINITY), row));
        }
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows.dedup_by(|a, b| a.0 == b.0);
        table.rows = rows.into_iter().map(|(_, row)| row).collect();
        Ok(table)
    }

    /// The last line counts when it has ended: a run that was killed may leave half a row.
    fn append(&mut self, bytes: &[u8]) -> Result<()> {
        let mut rows = lines(bytes).map(|(line, row)| (line, row.unwrap_or_default()));
        let Some((_, header)) = rows.next() else {
            return Ok(());
        };
        if !header.iter().any(|name| name == "step") {
            return Err(Error::input("has no column `step`: this is no table of steps").line(1));
        }
        let n_columns = header.len();
        let checksum = header.iter().position(|name| name == CHECKSUM);
        let without_checksum = |mut row: Vec<String>| {
            checksum.map(|at| row.remove(at));
            row
        };
        let columns = without_checksum(header);
        if !self.columns.is_empty() && self.columns != columns {
            return Err(Error::input("its columns differ from the other parts").line(1));
        }
        self.columns = columns;
        for (line, row) in rows {
            if row.len() != n_columns {
                let n = row.len();
                let message = format!("a row of {n} values under {n_columns} columns");
                return Err(Error::input(message).line(line));
            }
            let row = without_checksum(row);
            self.check(&row).map_err(|error| error.line(line))?;
            self.rows.push(row);
        }
        Ok(())
    }

    fn check(&self, row: &[String]) -> Result<()> {
        for (name, value) in self.columns.iter().zip(row) {
            let needed = name == "step" && value.is_empty();
            let wrong = !value.is_empty() && value.parse::<f64>().is_err();
            if needed || holds_numbers(name) == Some(true) && wrong {
                return Err(Error::input(format!(
                    "{name} is \"{value}\"; it should be a number"
                )));
            }
        }
        Ok(())
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// The text in a row; empty where there is no such column.
    pub fn text(&self, row: usize, column: &str) -> &str {
        self.place(column).map_or("", |at| &self.rows[row][at])
    }

    /// A row, in the order of the columns.
    pub fn row(&self, row: usize) -> &[String] {
        &self.rows[row]
    }

    /// A column as numbers; `None` where a value is not known.
    pub fn numbers(&self, column: &str) -> Vec<Option<f64>> {
        let at = self.place(column);
        let number = |row: &Vec<String>| row[at?].parse().ok().filter(|x: &f64| x.is_finite());
        self.rows.iter().map(number).collect()
    }

    /// Returns the smallest and the largest value of a column.
    pub fn range(&self, column: &str) -> Option<[f64; 2]> {
        let values = self.numbers(column).into_iter().flatten();
        let ranges = values.map(|value| [value, value]);
        ranges.reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])
    }

    /// Returns the row with the worst cell: the smallest scaled Jacobian, or without quality the largest displacement. Of several
    /// the first.
    pub fn worst(&self) -> Option<usize> {
        if self.has("min_scaled_jacobian") {
            return least(self.numbers("min_scaled_jacobian"));
        }
        let moved = self.numbers("max_displacement").into_iter();
        least(moved.map(|value| value.map(|value| -value)))
    }

    /// Returns the row whose surface has moved least.
    pub fn least_displaced(&self) -> usize {
        least(self.numbers("max_displacement")).unwrap_or(0)
    }

    /// The number of a step in the schedule.
    pub fn step(&self, row: usize) -> usize {
        self.text(row, "step").parse().unwrap_or(row)
    }

    /// Tests if a column has a value in any row.
    pub fn has(&self, column: &str) -> bool {
        self.numbers(column).iter().any(Option::is_some)
    }

    /// Adds a column; `None` stays empty.
    pub fn add(&mut self, column: &str, values: &[Option<f64>]) {
        self.columns.push(column.to_owned());
        for (row, value) in self.rows.iter_mut().zip(values) {
            row.push(value.map_or_else(String::new, |value| value.to_string()));
        }
    }

    fn place(&self, column: &str) -> Option<usize> {
        self.columns.iter().position(|name| name == column)
    }
}

/// Returns the place of the smallest known value.
fn least(values: impl IntoIterator<Item = Option<f64>>) -> Option<usize> {
    let known = values
        .into_iter()
        .enumerate()
        .filter_map(|(row, value)| Some((row, value?)));
    known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
}

/// Returns whether a column of steps.csv holds numbers; `None` for one that this version does not know.
pub fn holds_numbers(column: &str) -> Option<bool> {
    COLUMNS
        .iter()
        .find(|known| known.name == column)
        .map(|known| known.is_number)
}
