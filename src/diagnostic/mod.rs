//! What a user should know that is no error: a kind with its names and numbers, and where it is.
//!
//! Every room makes diagnostics; the sentence is made where one is printed, by `Display`. Two of one sort
//! have the same [`Kind`] but for its numbers.

pub mod formats;

use crate::error::{Position, path_in_line};
use std::fmt;
use std::path::{Path, PathBuf};

/// A note or a warning with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnostic {
    /// What it is about, with its names and numbers.
    pub kind: Kind,
    /// The file it is about, where it is about one.
    pub path: Option<PathBuf>,
    /// Where in that file, where it is known.
    pub position: Option<Position>,
}

/// What a diagnostic is about; the kinds of a room are one enum.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Of a mesh file, read or written.
    Format(formats::FormatNote),
    /// A sentence that has no kind of its own.
    Text(String),
}

impl Diagnostic {
    /// Of a kind, without a place.
    pub fn new(kind: impl Into<Kind>) -> Self {
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
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path_in_line(path))?;
        }
        self.kind.fmt(f)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(note) => note.fmt(f),
            Self::Text(text) => f.write_str(text),
        }
    }
}

impl From<String> for Kind {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}
