//! Notes, errors and failed checks in JSON, in run.json and on standard output.

use azimesh_core::Note;
use azimesh_core::error::{Error, ErrorKind, Position};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::PathBuf;

/// A note or a warning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Diagnostic {
    /// Word for programs; [all codes](notes.md).
    pub code: String,
    /// Level of printing.
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["note", "warning"])))]
    pub level: Level,
    /// The sentence, without the place.
    pub text: String,
    /// File that it concerns; null without.
    pub path: Option<String>,
    /// Line of the file, from 1; null where it has none.
    pub line: Option<u64>,
    /// Names and numbers of the sentence.
    pub data: Map<String, Value>,
}

/// Level of printing of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// As a note.
    Note,
    /// As a warning.
    Warning,
}

impl Diagnostic {
    /// A note with its level.
    pub fn new(level: Level, note: &Note) -> Self {
        Self {
            code: note.code.to_string(),
            level,
            text: note.text.clone(),
            path: note.path.as_ref().map(|path| path.display().to_string()),
            line: line(note.position.as_ref()),
            data: note.data.clone(),
        }
    }

    /// Notes that are printed as warnings.
    pub fn warnings(notes: &[Note]) -> Vec<Self> {
        let warning = |note| Self::new(Level::Warning, note);
        notes.iter().map(warning).collect()
    }

    /// The original note.
    pub fn note(&self) -> Note {
        Note {
            code: self.code.clone().into(),
            path: self.path.as_ref().map(PathBuf::from),
            position: self.line.map(Position::Line),
            text: self.text.clone(),
            data: self.data.clone(),
        }
    }
}

/// Returns notes as sentences.
pub fn sentences(notes: &[Note]) -> Vec<String> {
    notes.iter().map(Note::to_string).collect()
}

fn line(position: Option<&Position>) -> Option<u64> {
    match position {
        Some(Position::Line(line)) => Some(*line),
        _ => None,
    }
}

/// The error that ended a command or a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Failed {
    /// Cause of the failure: the input or the arguments, a check, the system, or a signal.
    #[cfg_attr(test, schemars(extend("enum" = ["input", "check", "system", "interrupted"])))]
    pub kind: String,
    /// Sentence with the value found and the remedy, without the place.
    pub text: String,
    /// File that it concerns; null without.
    pub path: Option<String>,
    /// Line of the file, from 1; null where it has none.
    pub line: Option<u64>,
    /// Byte of a binary file, from 0; null likewise.
    pub byte: Option<u64>,
    /// Part of the file, or item given in memory; null likewise.
    pub part: Option<String>,
}

impl From<&Error> for Failed {
    fn from(error: &Error) -> Self {
        let kind = match error.kind {
            ErrorKind::Input => "input",
            ErrorKind::Check => "check",
            ErrorKind::System => "system",
            ErrorKind::Interrupted { .. } => "interrupted",
        };
        let (byte, part) = match &error.position {
            Some(Position::Byte(byte)) => (Some(*byte), None),
            Some(Position::Dataset(part) | Position::Item(part)) => (None, Some(part.clone())),
            _ => (None, None),
        };
        Self {
            kind: kind.to_owned(),
            text: error.message.clone(),
            path: error.path.as_ref().map(|path| path.display().to_string()),
            line: line(error.position.as_ref()),
            byte,
            part,
        }
    }
}

/// A check of a run that failed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Failure {
    /// Word for programs; [all codes](notes.md).
    pub code: String,
    /// The failure in a sentence.
    pub message: String,
    /// Column of a condition of `--fail-on`; null for another check.
    pub metric: Option<String>,
    /// Its value; null likewise.
    pub value: Option<f64>,
    /// The number that it is compared with; null likewise.
    pub limit: Option<f64>,
    /// The step; null where the check is of no step.
    pub step: Option<usize>,
}

impl From<&Note> for Failure {
    fn from(note: &Note) -> Self {
        Self {
            code: note.code.to_string(),
            message: note.to_string(),
            metric: note.get("metric").as_str().map(str::to_owned),
            value: note.get("value").as_f64(),
            limit: note.get("limit").as_f64(),
            step: note.get("step").as_u64().map(|step| step as usize),
        }
    }
}

impl From<Failure> for Note {
    fn from(failure: Failure) -> Self {
        let Failure {
            code,
            message,
            metric,
            value,
            limit,
            step,
        } = failure;
        let data = [
            ("metric", metric.map(Value::from)),
            ("value", value.map(Value::from)),
            ("limit", limit.map(Value::from)),
            ("step", step.map(Value::from)),
        ];
        let data = data.into_iter();
        data.filter_map(|(key, value)| Some((key, value?)))
            .fold(Note::new(code, message), |note, (key, value)| {
                note.with(key, value)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::note;
    use serde_json::json;
    use std::path::Path;

    #[test]
    fn a_note_is_the_same_after_json() {
        let note = note!("turns_far", "body \"a\" turns").with("angle_deg", 340.5);
        let note = note.file(Path::new("a.toml")).line(3);
        let told = serde_json::to_value(Diagnostic::new(Level::Note, &note)).expect("it is JSON");
        let wanted = json!({
            "code": "turns_far", "level": "note", "text": "body \"a\" turns", "path": "a.toml", "line": 3,
            "data": {"angle_deg": 340.5},
        });
        assert_eq!(told, wanted);
        let read: Diagnostic = serde_json::from_value(told).expect("it is a note");
        assert_eq!(read.note(), note);
    }

    #[test]
    fn an_error_has_its_place_as_data() {
        let error = Error::input("a number is wrong").file(Path::new("a.vtu"));
        let told = Failed::from(&error.dataset("Points"));
        let part = told.part.as_deref();
        assert_eq!((&*told.kind, part), ("input", Some("Points")));
        assert_eq!(
            (&*told.text, told.path.as_deref()),
            ("a number is wrong", Some("a.vtu"))
        );
    }

    #[test]
    fn a_failure_is_the_same_after_json() {
        let note =
            note!("condition_holds", "step 3: max_skew>0.5 holds").with("metric", "max_skew");
        let note = note.with("value", 0.75).with("limit", 0.5).with("step", 3);
        assert_eq!(Note::from(Failure::from(&note)), note);
        let other = note!("missed", "a tolerance is missed");
        assert_eq!(Note::from(Failure::from(&other)), other);
    }
}
