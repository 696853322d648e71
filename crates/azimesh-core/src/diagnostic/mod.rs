//! Notes and warnings for the user: a kind with its names and numbers, and its place.
//!
//! Every module makes diagnostics; `Display` makes the sentence when one is printed. Two of one sort have the
//! same [`NoteKind`] but for its numbers.

pub mod deform;
pub mod formats;
pub mod motion;
mod notes;
mod numbers;
pub mod preflight;
pub mod quality;
pub mod run;

pub use numbers::{amount, in_digits, point, short, shortest, with_verb};

use crate::error::{Position, path_in_line};
use deform::DeformNote;
use motion::MotionNote;
use preflight::PreflightNote;
use quality::QualityNote;
use run::RunNote;
use serde::{Serialize, Serializer};
use std::fmt;
use std::mem::discriminant;
use std::path::{Path, PathBuf};

/// A note or a warning with its place; `Display` is its sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnostic {
    /// Its subject, with names and numbers.
    pub kind: NoteKind,
    /// File that it concerns, if any.
    pub path: Option<PathBuf>,
    /// Place in that file, if known.
    pub position: Option<Position>,
}

/// Subject of a diagnostic. Each module has an enum of its notes.
#[derive(Debug, Clone, PartialEq)]
pub enum NoteKind {
    /// A note on a mesh file, read or written.
    Format(formats::FormatNote),
    /// A note on a motion and its files.
    Motion(MotionNote),
    /// A note on a deformation.
    Deform(DeformNote),
    /// A note on a motion and its mesh, before work starts.
    Preflight(PreflightNote),
    /// A note on cells and metrics that the quality of a mesh leaves out.
    Quality(QualityNote),
    /// A note on a run that writes to a folder.
    Run(RunNote),
}

impl Diagnostic {
    /// Makes one of a kind, without a place.
    pub fn new(kind: impl Into<NoteKind>) -> Self {
        Self {
            kind: kind.into(),
            path: None,
            position: None,
        }
    }

    /// Adds the file, unless one is named already.
    #[must_use]
    pub fn file(mut self, path: &Path) -> Self {
        self.path.get_or_insert_with(|| path.to_path_buf());
        self
    }

    /// Adds a line, counted from 1.
    #[must_use]
    pub fn line(mut self, line: u64) -> Self {
        self.position = Some(Position::Line(line));
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            f.write_str(&path_in_line(path))?;
            if let Some(Position::Line(line)) = self.position {
                write!(f, ":{line}")?;
            }
            f.write_str(": ")?;
        }
        self.kind.fmt(f)
    }
}

/// Serializes its sentence.
impl Serialize for Diagnostic {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl NoteKind {
    /// Checks if it is of the same sort as another: the same but for names and numbers.
    pub fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Format(a), Self::Format(b)) => a.is_like(b),
            (Self::Motion(a), Self::Motion(b)) => discriminant(a) == discriminant(b),
            (Self::Deform(a), Self::Deform(b)) => discriminant(a) == discriminant(b),
            (Self::Preflight(a), Self::Preflight(b)) => discriminant(a) == discriminant(b),
            (Self::Quality(a), Self::Quality(b)) => discriminant(a) == discriminant(b),
            (Self::Run(a), Self::Run(b)) => a.is_like(b),
            _ => self == other,
        }
    }
}

impl fmt::Display for NoteKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(note) => note.fmt(f),
            Self::Motion(note) => note.fmt(f),
            Self::Deform(note) => note.fmt(f),
            Self::Preflight(note) => note.fmt(f),
            Self::Quality(note) => note.fmt(f),
            Self::Run(note) => note.fmt(f),
        }
    }
}

impl<T: Into<NoteKind>> From<T> for Diagnostic {
    fn from(kind: T) -> Self {
        Self::new(kind)
    }
}

/// A step as sentences name it: with its azimuth in degrees or, where the schedule has none, with its
/// time in seconds.
pub fn named_step(step: usize, azimuth_deg: Option<f64>, time_s: Option<f64>) -> String {
    match (azimuth_deg, time_s) {
        (None, Some(time)) => format!("step {step} ({} s)", short(time)),
        (azimuth, _) => {
            let azimuth = short(azimuth.unwrap_or(0.0));
            format!("step {step} (azimuth {azimuth} degrees)")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inverted(step: usize) -> Diagnostic {
        let note = RunNote::Inverted {
            step,
            azimuth_deg: Some(10.0 * step as f64),
            time_s: None,
            cells: 7 * step,
            first: None,
        };
        note.into()
    }

    #[test]
    fn a_diagnostic_reads_path_line_sentence() {
        let note = Diagnostic::new(DeformNote::SupportRadius { radius: 2.5 });
        assert_eq!(note.to_string(), "support_radius = 2.5 (chosen)");
        let note = note.file(Path::new("a\nb.csv")).line(3);
        assert_eq!(
            note.to_string(),
            "a\\nb.csv:3: support_radius = 2.5 (chosen)"
        );
    }

    #[test]
    fn diagnostics_of_one_sort_are_the_same_but_for_their_numbers() {
        assert!(inverted(1).kind.is_like(&inverted(2).kind));
        let gap = NoteKind::from(RunNote::CutOff {
            file: "a".to_owned(),
        });
        assert!(!inverted(1).kind.is_like(&gap));
        let recorded = |text: &str| {
            NoteKind::from(RunNote::Recorded {
                sentence: text.to_owned(),
            })
        };
        assert!(recorded("step 1 has 2").is_like(&recorded("step 3 has 4")));
        assert!(!recorded("step 1 has 2").is_like(&recorded("body b moves")));
        let holds = |column: &str| {
            NoteKind::from(RunNote::ConditionHolds {
                step: 0,
                condition: format!("{column}>0"),
                column: column.to_owned(),
                value: 1.0,
            })
        };
        assert!(holds("max_skew").is_like(&holds("max_skew")));
        assert!(!holds("max_skew").is_like(&holds("inverted")));
    }
}
