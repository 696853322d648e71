//! Notes of `run`: what is wrong with steps, and what an earlier run has left.

use super::shortest;
use std::fmt;
use std::mem::discriminant;

/// What the user should know of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum RunNote {
    /// A step has inverted cells.
    Inverted {
        /// The step.
        step: usize,
        /// Its azimuth in degrees.
        azimuth_deg: f64,
        /// How many.
        cells: usize,
        /// The first of them, where it is known.
        first: Option<usize>,
    },
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
    },
    /// A step was passed over.
    PassedOver {
        /// Why it cannot be written.
        reason: String,
    },
    /// Boxes for free-form deformation are not written.
    NoBoxes,
    /// The file system has no locks.
    NoLocks,
    /// The record of an earlier run is lost.
    LostRecord {
        /// Name of its file.
        record: String,
        /// Whether the file is there and no record.
        is_damaged: bool,
    },
    /// A finished step is done again.
    StepAgain {
        /// The step.
        step: usize,
        /// Its file.
        file: String,
        /// What is wrong with that.
        fault: FileFault,
    },
    /// More finished steps are done again than are named.
    MoreAgain {
        /// How many more.
        steps: usize,
    },
    /// A file of base points is written again.
    BaseAgain {
        /// The file.
        file: String,
        /// What is wrong with it.
        fault: FileFault,
    },
    /// A file of all steps did not end with its last one.
    CutOff {
        /// The file.
        file: String,
    },
    /// A file of all steps is not what its rows say.
    DiffersFrom {
        /// The file.
        file: String,
        /// The first step that differs.
        step: usize,
    },
    /// A sentence in the record of another run.
    Recorded(String),
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

impl RunNote {
    /// Whether it is of the same sort: the same but for its numbers, its step and its file.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::ConditionHolds { column: a, .. }, Self::ConditionHolds { column: b, .. }) => {
                a == b
            }
            (Self::Recorded(a), Self::Recorded(b))
            | (Self::PassedOver { reason: a }, Self::PassedOver { reason: b }) => {
                words(a).eq(words(b))
            }
            _ => discriminant(self) == discriminant(other),
        }
    }
}

/// The words of a sentence but for those with numbers.
fn words(sentence: &str) -> impl Iterator<Item = &str> {
    let has_digit = |word: &&str| word.contains(|c: char| c.is_ascii_digit());
    sentence
        .split_whitespace()
        .filter(move |word| !has_digit(word))
}

impl fmt::Display for RunNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inverted {
                step,
                azimuth_deg,
                cells,
                first,
            } => {
                write!(
                    f,
                    "step {step} (azimuth {azimuth_deg} degrees) has {cells} inverted cells"
                )?;
                first.map_or(Ok(()), |cell| write!(f, ", cell {cell} first"))
            }
            Self::ConditionHolds {
                step,
                condition,
                column,
                value,
            } => write!(
                f,
                "step {step}: {condition} holds: {column} is {}",
                shortest(*value)
            ),
            Self::PassedOver { reason } => write!(f, "{reason}; passed over"),
            Self::NoBoxes => f.write_str(
                "the boxes for free-form deformation (su2:FFD) fit the mesh at rest; left out",
            ),
            Self::NoLocks => f.write_str(
                "this file system has no locks: nothing keeps another run from the same steps",
            ),
            Self::LostRecord { record, is_damaged } => {
                let state = if *is_damaged {
                    "is empty, cut or no record of a run"
                } else {
                    "is missing"
                };
                write!(
                    f,
                    "{record} {state}: finished steps are computed again and kept where that gives the same bytes; \
                     conditions of --fail-on that the run had are not known any more"
                )
            }
            Self::StepAgain { step, file, fault } => {
                write!(f, "step {step} is done again: {file} {fault}")
            }
            Self::MoreAgain { steps } => write!(f, "and {steps} more steps are done again"),
            Self::BaseAgain { file, fault } => write!(f, "{file} {fault}; it is written again"),
            Self::CutOff { file } => write!(
                f,
                "{file} did not end with its last step; what came after is cut off"
            ),
            Self::DiffersFrom { file, step } => write!(
                f,
                "{file} is not at step {step} what steps.csv says; it is written again from there"
            ),
            Self::Recorded(sentence) => f.write_str(sentence),
        }
    }
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("is missing"),
            Self::OtherHash(table) => write!(f, "has another hash than {table} says"),
            Self::Unreadable(error) => write!(f, "cannot be read ({error})"),
            Self::NoCompanion => f.write_str("lacks the file that belongs beside it"),
            Self::OtherBytes => f.write_str("is not what this run writes"),
        }
    }
}
