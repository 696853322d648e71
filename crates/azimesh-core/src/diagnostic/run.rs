//! Notes of `run`: what is wrong with steps, and what an earlier run has left.

use super::notes::notes;
use super::{named_step, short, with_verb};
use crate::error::{counted, option};
use std::fmt;
use std::mem::discriminant;

notes! {
/// What the user should know of a run.
RunNote as Run {
    /// A step has inverted cells.
    Inverted {
        /// The step.
        step: usize,
        /// Its azimuth in degrees; `None` where the schedule has times alone.
        azimuth_deg: Option<f64>,
        /// Its time in seconds, where it is known.
        time_s: Option<f64>,
        /// How many.
        cells: usize,
        /// The first of them, where it is known.
        first: Option<usize>,
    } => (
        "{} has {}{}",
        named_step(*step, *azimuth_deg, *time_s),
        counted(*cells, "inverted cell"),
        first.map_or(String::new(), |cell| format!(", the first is cell {cell}"))
    )

    /// A condition holds under which a run fails.
    ConditionHolds {
        /// The step.
        step: usize,
        /// The condition.
        condition: String,
        /// Its column of steps.csv.
        column: String,
        /// The value there.
        value: f64,
    } => ("step {step}: {condition} holds: {column} is {}", short(*value))

    /// A step was skipped.
    Skipped {
        /// Why it cannot be written.
        reason: String,
    } => ("{reason}; skipped")

    /// Boxes for free-form deformation are not written.
    NoBoxes => ("the boxes of free-form deformation (su2:FFD) fit the undeformed mesh only; they are left out")

    /// The file system has no locks.
    NoLocks => ("this file system has no locks: nothing prevents another run from writing the same steps")

    /// The record of an earlier run is lost.
    LostRecord {
        /// Name of its file.
        record: String,
        /// Whether the file is there and no record.
        is_damaged: bool,
    } => (
        "{record} is {}: finished steps are computed again, and kept where that gives the same bytes; the {} \
         conditions of the earlier run are lost",
        if *is_damaged { "damaged" } else { "missing" }, option("fail-on")
    )

    /// A finished step is computed again.
    StepAgain {
        /// The step.
        step: usize,
        /// Its file.
        file: String,
        /// What is wrong with that.
        fault: FileFault,
    } => ("step {step} is computed again: {file} {fault}")

    /// More finished steps are computed again than are named.
    MoreAgain {
        /// How many more.
        steps: usize,
    } => ("{} computed again", with_verb(*steps, "more step", "is"))

    /// A file of base points is written again.
    BaseAgain {
        /// The file.
        file: String,
        /// What is wrong with it.
        fault: FileFault,
    } => ("{file} {fault}; it is written again")

    /// A file of all steps did not end with its last one.
    CutOff {
        /// The file.
        file: String,
    } => ("{file} does not end with its last step; what follows it is cut off")

    /// A file of all steps is not what its rows say.
    DiffersFrom {
        /// The file.
        file: String,
        /// The first step that differs.
        step: usize,
    } => ("{file}: step {step} is not what steps.csv says; the file is written again from there on")

    /// A sentence in the record of another run.
    Recorded {
        /// The sentence.
        sentence: String,
    } => ("{sentence}")
}}

impl RunNote {
    /// Whether it is of the same sort: the same but for its numbers, its step and its file.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::ConditionHolds { column: a, .. }, Self::ConditionHolds { column: b, .. }) => {
                a == b
            }
            (Self::Recorded { sentence: a }, Self::Recorded { sentence: b })
            | (Self::Skipped { reason: a }, Self::Skipped { reason: b }) => words(a).eq(words(b)),
            _ => discriminant(self) == discriminant(other),
        }
    }
}

/// The words of a sentence but for those with numbers, in the singular.
fn words(sentence: &str) -> impl Iterator<Item = &str> {
    let has_digit = |word: &&str| word.contains(|c: char| c.is_ascii_digit());
    sentence
        .split_whitespace()
        .filter(move |word| !has_digit(word))
        .map(|word| word.trim_end_matches('s'))
}

/// What is wrong with a file that an earlier run has left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileFault {
    /// It is not there.
    Missing,
    /// It has another hash than this table or record says.
    OtherHash(&'static str),
    /// The system does not let it be read.
    Unreadable(String),
    /// What belongs beside it is not there.
    NoCompanion,
    /// The same step, computed again, gives other bytes.
    OtherBytes,
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("is missing"),
            Self::OtherHash(table) => write!(f, "does not have the hash in {table}"),
            Self::Unreadable(error) => write!(f, "cannot be read ({error})"),
            Self::NoCompanion => f.write_str("lacks its companion file"),
            Self::OtherBytes => f.write_str("is not what this run writes"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_inverted_cell_is_named_where_it_is_known() {
        let told = |azimuth_deg, time_s, first| {
            let note = RunNote::Inverted {
                step: 1,
                azimuth_deg,
                time_s,
                cells: 29,
                first,
            };
            note.to_string()
        };
        let start = "step 1 (azimuth 120 degrees) has 29 inverted cells";
        assert_eq!(told(Some(120.0), None, None), start);
        let first = told(Some(120.0), Some(0.5), Some(244));
        assert_eq!(first, format!("{start}, the first is cell 244"));
        let by_time = "step 1 (0.5 s) has 29 inverted cells";
        assert_eq!(told(None, Some(0.5), None), by_time);
    }
}
