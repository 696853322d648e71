//! Notes and warnings for the user.

use crate::error::{Position, path_in_line};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};

/// A note or a warning, made where its cause is found. `Display` is its sentence after its place.
///
/// ```
/// use azimesh_core::note;
/// use std::path::Path;
///
/// let (body, angle_deg) = ("blade", 340.0);
/// let note = note!("turns_far", "body \"{body}\" turns by {angle_deg} degrees").with("angle_deg", angle_deg);
/// assert_eq!(note.code, "turns_far");
/// assert_eq!(note.get("angle_deg"), 340.0);
/// assert_eq!(note.file(Path::new("a.toml")).line(3).to_string(), "a.toml:3: body \"blade\" turns by 340 degrees");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// Word for programs, in snake case. Notes of one code differ in names and numbers only.
    pub code: Cow<'static, str>,
    /// File that it concerns, if any.
    pub path: Option<PathBuf>,
    /// Place in that file, if known.
    pub position: Option<Position>,
    /// Sentence for people, without the place.
    pub text: String,
    /// Names and numbers of the sentence that a program can use.
    pub data: Map<String, Value>,
}

/// Makes a [`Note`] of a code and a sentence, which is what `format!` takes.
#[macro_export]
macro_rules! note {
    ($code:literal, $($text:tt)+) => {
        $crate::Note::new($code, format!($($text)+))
    };
}

impl Note {
    /// Makes a note without a place and without data.
    pub fn new(code: impl Into<Cow<'static, str>>, text: impl Into<String>) -> Self {
        Self {
            code: code.into(),
            path: None,
            position: None,
            text: text.into(),
            data: Map::new(),
        }
    }

    /// Adds a name or a number for programs.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Value>) -> Self {
        self.data.insert(key.to_owned(), value.into());
        self
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

    /// Returns a value of `data`, or `null` if there is no such key.
    pub fn get(&self, key: &str) -> &Value {
        self.data.get(key).unwrap_or(&Value::Null)
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            f.write_str(&path_in_line(path))?;
            if let Some(Position::Line(line)) = self.position {
                write!(f, ":{line}")?;
            }
            f.write_str(": ")?;
        }
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_reads_path_line_sentence() {
        let note = note!("x", "a value is {}", 2.5);
        assert_eq!(note.to_string(), "a value is 2.5");
        let note = note.file(Path::new("a\nb.csv")).line(3);
        assert_eq!(note.to_string(), "a\\nb.csv:3: a value is 2.5");
    }
}
