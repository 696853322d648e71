//! Conditions such as `min_scaled_jacobian<0.1` under which a result counts as failed.

use super::COLUMNS;
use azimesh_core::error::{Error, Result, nearest_name, option};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

/// `column comparison value`: holds if the column's value satisfies the comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Criterion {
    column: String,
    comparison: Comparison,
    value: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Comparison {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// Longer symbols first, so that `<=` is not read as `<`.
const SYMBOLS: [(&str, Comparison); 4] = [
    ("<=", Comparison::LessOrEqual),
    (">=", Comparison::GreaterOrEqual),
    ("<", Comparison::Less),
    (">", Comparison::Greater),
];

impl Criterion {
    /// Returns its column.
    pub fn column(&self) -> &str {
        &self.column
    }

    /// Returns its limit.
    pub fn limit(&self) -> f64 {
        self.value
    }

    /// Checks that its column exists in steps.csv and holds numbers.
    pub fn check_column(&self) -> Result<()> {
        let numbers = COLUMNS.iter().filter(|column| column.is_number);
        let known: Vec<&str> = numbers.map(|column| column.name).collect();
        if known.contains(&self.column.as_str()) {
            return Ok(());
        }
        let is_extreme = |name: &&str| {
            ["min_", "max_"]
                .map(|of| name.strip_prefix(of))
                .contains(&Some(&self.column))
        };
        let extreme = known.iter().copied().find(is_extreme);
        let hint = extreme
            .or_else(|| nearest_name(&self.column, known.iter().copied()))
            .map_or_else(String::new, |name| format!(" (did you mean {name}?)"));
        Err(Error::input(format!(
            "\"{self}\": there is no column \"{}\"{hint}; the columns are: {}",
            self.column,
            known.join(", ")
        )))
    }

    /// Checks that its column can be computed from meshes only: the columns of an [`Assessment`](azimesh_quality::Assessment).
    pub fn check_of_meshes(&self) -> Result<()> {
        self.check_column()?;
        let reason = match self.column() {
            "step" | "azimuth_deg" | "time_s" => "it is the place of a step in its schedule",
            "base_points" | "selection_error" | "seconds" | "repaired" => {
                "it describes how the steps were computed"
            }
            "max_displacement" | "max_surface_error" | "rms_surface_error" => {
                "it is measured against the motion"
            }
            "min_first_cell_ratio" | "max_normal_change_deg" => {
                "only the schedule says which walls move"
            }
            _ => return Ok(()),
        };
        Err(Error::input(format!(
            "\"{self}\": {} cannot be computed from meshes, since {reason}; {} of deform takes it, and steps.csv has it",
            self.column,
            option("fail-on")
        )))
    }

    /// Returns the value of its column if the condition holds. A column that is missing, has no value or is not a number is an
    /// error, since the condition cannot be evaluated.
    pub fn met_by(&self, columns: &[(&str, Option<f64>)]) -> Result<Option<f64>> {
        self.check_column()?;
        let found = columns
            .iter()
            .find(|(name, _)| *name == self.column)
            .and_then(|(_, value)| *value)
            .filter(|value| !value.is_nan());
        let Some(found) = found else {
            return Err(Error::input(format!(
                "\"{self}\" cannot be evaluated: {} has no value for the cells of this mesh",
                self.column
            )));
        };
        let is_met = match self.comparison {
            Comparison::Less => found < self.value,
            Comparison::LessOrEqual => found <= self.value,
            Comparison::Greater => found > self.value,
            Comparison::GreaterOrEqual => found >= self.value,
        };
        Ok(is_met.then_some(found))
    }

    /// Returns the note for a value that satisfies it, at a step of a sequence.
    pub fn note(&self, step: Option<usize>, value: f64) -> Note {
        let place = step.map_or_else(String::new, |step| format!("step {step}: "));
        let note = note!(
            "condition_holds",
            "{place}{self} holds: {} is {}",
            self.column,
            short(value)
        );
        let note = note.with("metric", self.column()).with("value", value);
        let note = note.with("limit", self.value);
        step.iter()
            .fold(note, |note, step| note.with("step", *step))
    }

    /// Returns a note if it holds for the columns of the mesh before it deforms.
    pub fn note_at_rest(&self, columns: &[(&str, Option<f64>)]) -> Option<Note> {
        let value = self.met_by(columns).ok()??;
        let note = note!(
            "holds_at_rest",
            "{self} holds for the mesh before it deforms: {} is {} there",
            self.column,
            short(value)
        );
        Some(note.with("metric", self.column()).with("value", value))
    }

    /// Compares values: the value further beyond the limit comes first.
    pub fn worst_first(&self, a: f64, b: f64) -> Ordering {
        match self.comparison {
            Comparison::Less | Comparison::LessOrEqual => a.total_cmp(&b),
            Comparison::Greater | Comparison::GreaterOrEqual => b.total_cmp(&a),
        }
    }
}

impl FromStr for Criterion {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::input(format!(
                "\"{text}\" is not a condition; write a column, one of <, <=, >, >= and a number, as in \
                 \"inverted>0\""
            ))
        };
        let (symbol, comparison) = SYMBOLS
            .into_iter()
            .find(|(symbol, _)| text.contains(symbol))
            .ok_or_else(wrong)?;
        let (column, value) = text.split_once(symbol).ok_or_else(wrong)?;
        let value: f64 = value.trim().parse().map_err(|_| wrong())?;
        let column = column.trim();
        if column.is_empty() || value.is_nan() {
            return Err(wrong());
        }
        Ok(Self {
            column: column.to_owned(),
            comparison,
            value,
        })
    }
}

impl fmt::Display for Criterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let symbol = SYMBOLS
            .iter()
            .find(|(_, comparison)| *comparison == self.comparison)
            .map_or("", |(symbol, _)| symbol);
        write!(f, "{}{symbol}{}", self.column, self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_condition_compares_its_column() {
        let columns = [("inverted", Some(1.0)), ("min_volume", None)];
        let met = |text: &str| text.parse::<Criterion>().and_then(|c| c.met_by(&columns));
        assert_eq!(met("inverted>0").expect("it has a value"), Some(1.0));
        assert_eq!(met(" inverted >= 1.0 ").expect("it has a value"), Some(1.0));
        assert_eq!(met("inverted<1").expect("it has a value"), None);
        assert!(met("min_volume<0").is_err());
        for (text, meant) in [
            ("invertd>0", "inverted"),
            ("scaled_jacobian<1", "min_scaled_jacobian"),
        ] {
            let error = met(text).expect_err("no such column").to_string();
            assert!(error.contains(&format!("did you mean {meant}?")), "{error}");
        }
        assert!(met("file>0").is_err());
        for bad in ["inverted", "inverted=0", ">0", "inverted>", "inverted>nan"] {
            assert!(bad.parse::<Criterion>().is_err(), "{bad}");
        }
    }

    #[test]
    fn every_column_of_numbers_is_measured_on_meshes_or_says_why_not() {
        let measured = azimesh_quality::Assessment::default().columns();
        let measured: Vec<&str> = measured.iter().map(|(name, _)| *name).collect();
        for column in COLUMNS.iter().filter(|column| column.is_number) {
            let text = format!("{}>0", column.name);
            let condition: Criterion = text.parse().expect("it is a condition");
            assert!(condition.check_column().is_ok(), "{text}");
            let of_meshes = condition.check_of_meshes();
            assert_eq!(of_meshes.is_ok(), measured.contains(&column.name), "{text}");
            if let Err(error) = of_meshes {
                assert!(error.to_string().contains(", since "), "{error}");
            }
        }
        for name in measured {
            assert!(COLUMNS.iter().any(|column| column.name == name), "{name}");
        }
    }

    #[test]
    fn a_condition_that_holds_is_told_with_value_and_limit() {
        let told = |text: &str, value: f64| text.parse().map(|c: Criterion| c.note(None, value));
        let told = |text: &str, value: f64| told(text, value).expect("it is a condition").text;
        assert_eq!(told("inverted > 0", 3.0), "inverted>0 holds: inverted is 3");
        let small = told("min_volume<1e-9", -2.5e-12);
        assert_eq!(
            small,
            "min_volume<0.000000001 holds: min_volume is -2.5e-12"
        );
    }
}
