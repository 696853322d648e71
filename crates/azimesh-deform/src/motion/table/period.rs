//! The rule by which rows over azimuth are periodic, in all tables and in sets of displacements.

use super::Key;

/// Allowed offset of a last row from whole revolutions after the first, as a part of a revolution.
const CLOSING: f64 = 1e-4;
/// Allowed difference of the interval back to the first row from the last interval, relative: positions may be printed
/// with one decimal.
const SAME_STEP: f64 = 0.03;

/// The remedy for a table that ends too early.
pub const ADD: &str = "add the missing rows";

/// The period of rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Period {
    /// Whole revolutions, in the unit of the key.
    pub length: f64,
    /// Number of rows in it: all, or all but a last row that repeats the first.
    pub n_rows: usize,
}

impl Period {
    /// Finds the period of rows at increasing positions. Rows are periodic if the last one is whole revolutions after the
    /// first and has its values, or is one interval of the same length before that position. Two rows need the first again.
    ///
    /// # Errors
    /// The reason why they are not periodic, in words; `None` for one row, and for times and steps.
    pub fn of(
        key: Key,
        places: &[f64],
        last_differs: impl FnOnce() -> bool,
    ) -> Result<Self, Option<String>> {
        let (Some(revolution), [first, .., last]) = (key.revolution(), places) else {
            return Err(None);
        };
        let n_rows = places.len();
        let turns = (last - first) / revolution;
        let whole = turns.round();
        if whole >= 1.0 && (turns - whole).abs() <= CLOSING {
            if last_differs() {
                return Err(Some(format!(
                    "its values at {} differ from those at {}, so it is not periodic",
                    key.place(*last),
                    key.place(*first)
                )));
            }
            return Ok(Self {
                length: whole * revolution,
                n_rows: n_rows - 1,
            });
        }
        let length = turns.ceil() * revolution;
        let end = first + length;
        let step = last - places[n_rows - 2];
        if n_rows > 2 && (end - last - step).abs() <= SAME_STEP * step {
            return Ok(Self { length, n_rows });
        }
        let end = key.place(end);
        Err(Some(match n_rows {
            2 => format!("it has two rows, and the last is not at {end}: {ADD}"),
            _ => format!("its last row is neither at {end} nor one step before it: {ADD}"),
        }))
    }
}

/// Returns the reason why rows are not periodic, without the remedy.
pub fn why(open: Option<&str>) -> String {
    let why = open.unwrap_or("it has one row");
    why.split(':').next().unwrap_or(why).to_owned()
}
