//! The rows of steps.csv as text, written and read back.

use crate::error::{Error, Result};
use std::collections::BTreeMap;

/// Columns of steps.csv, in order.
pub const COLUMNS: [&str; 24] = [
    "step",
    "azimuth_deg",
    "time_s",
    "file",
    "base_points",
    "max_displacement",
    "selection_error",
    "max_surface_error",
    "rms_surface_error",
    "inverted",
    "inverted_reference",
    "min_volume",
    "min_scaled_jacobian",
    "mean_scaled_jacobian",
    "p01_scaled_jacobian",
    "max_edge_ratio",
    "max_skew",
    "max_non_orthogonality",
    "min_size_skew",
    "mean_size_skew",
    "min_first_cell_ratio",
    "max_normal_change_deg",
    "blake3",
    "seconds",
];

/// Rows by their step.
pub type Rows = BTreeMap<usize, Row>;

/// The values of a step, one for each of [`COLUMNS`]; empty where a value is not known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row(Vec<String>);

impl Row {
    /// A row without values.
    pub fn new() -> Self {
        Self(vec![String::new(); COLUMNS.len()])
    }

    /// Sets the value of a column.
    pub fn set(&mut self, column: &str, value: String) {
        self.0[at(column)] = value;
    }

    /// The value of a column as it stands in the file.
    pub fn text(&self, column: &str) -> &str {
        &self.0[at(column)]
    }

    /// The value of a column that holds numbers.
    pub fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok()
    }

    /// Every column with its value where that is a number.
    pub fn numbers(&self) -> Vec<(&'static str, Option<f64>)> {
        let values = COLUMNS.into_iter().zip(&self.0);
        values
            .map(|(column, value)| (column, value.parse().ok()))
            .collect()
    }

    /// Its line in the file.
    pub fn line(&self) -> String {
        joined(self.0.iter().map(String::as_str))
    }
}

fn at(column: &str) -> usize {
    let at = COLUMNS.iter().position(|name| *name == column);
    at.expect("it is a column of steps.csv")
}

/// The text of a table.
pub fn text(rows: &Rows) -> String {
    rows.values()
        .fold(joined(COLUMNS), |text, row| text + &row.line())
}

/// The rows in the bytes of a table. A row that a killed run left cut is none; nor is one that is no row,
/// as a power cut may leave it.
pub fn parse(bytes: &[u8]) -> Result<Rows> {
    let mut lines = bytes
        .split_inclusive(|byte| *byte == b'\n')
        .filter_map(|line| line.strip_suffix(b"\n"))
        .map(|line| {
            std::str::from_utf8(line)
                .ok()
                .filter(|text| !text.contains('\0'))
        });
    match lines.next() {
        None => return Ok(Rows::new()),
        Some(Some(header)) if cut(header) != COLUMNS => {
            return Err(Error::input(format!(
                "the columns are \"{header}\"; this version has \"{}\"",
                COLUMNS.join(",")
            ))
            .line(1));
        }
        Some(_) => {}
    }
    let row = |line| {
        let row = cut(line);
        let step = (row.len() == COLUMNS.len()).then(|| row[0].parse().ok());
        Some((step.flatten()?, Row(row)))
    };
    Ok(lines.flatten().filter_map(row).collect())
}

fn joined<'a>(values: impl IntoIterator<Item = &'a str>) -> String {
    let values: Vec<String> = values.into_iter().map(quoted).collect();
    values.join(",") + "\n"
}

fn quoted(value: &str) -> String {
    match value.contains([',', '"', '\n']) {
        true => format!("\"{}\"", value.replace('"', "\"\"")),
        false => value.to_owned(),
    }
}

/// The values of a line.
fn cut(line: &str) -> Vec<String> {
    let mut values = vec![String::new()];
    let mut is_quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        let value = values.last_mut().expect("there is always one");
        match character {
            '"' if is_quoted && characters.next_if_eq(&'"').is_some() => value.push('"'),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => values.push(String::new()),
            _ => value.push(character),
        }
    }
    values
}

/// The shortest text that reads back as the same number.
pub fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-4..1e9).contains(&size) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_as_they_were() {
        for value in [0.0, 1.0, 37.0, 0.1 + 0.2, 1e-17, -2.9753038973609e-9, 1e300] {
            assert_eq!(number(value).parse::<f64>(), Ok(value));
        }
        assert_eq!(number(1e-17), "1e-17");
    }
}
