//! The one error type: what went wrong, and the place.
//!
//! Library code returns [`Error`]; only `cli` prints it and turns its [`ErrorKind`] into an exit code.
//! A parser that has bytes and no path gives the position alone; the caller that opened the file adds the
//! path with [`Error::file`].

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// The crate's result.
pub type Result<T> = std::result::Result<T, Error>;

/// Meaning of a failure to the caller. The program exits with 2 for `Input`, 1 for `Check`, 3 for `System`, and 128
/// plus the signal's number for `Interrupted`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorKind {
    /// The input or the arguments are wrong; nothing was written.
    Input,
    /// The work was done but a check failed.
    Check,
    /// The operating system refused: disk full, no permission, out of memory.
    System,
    /// A signal asked the program to end; what was finished is kept.
    Interrupted {
        /// Number of the signal.
        signal: i32,
    },
}

/// Place in a file where an error was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Position {
    /// One-based line of a text file.
    Line(u64),
    /// Byte offset from the start of a binary file.
    Byte(u64),
    /// A named part: an XML data array, an HDF5 dataset, a section.
    Dataset(String),
    /// An item given in memory, in words: `body "wing"`, `rbf`.
    Item(String),
}

/// An error with its place: file, position, what was found and what would be right.
///
/// ```
/// use azimesh_core::Error;
/// use std::path::Path;
///
/// let error = Error::input("there is no such tag").file(Path::new("wing.su2")).line(3);
/// assert_eq!(error.to_string(), "wing.su2:3: there is no such tag");
/// ```
#[derive(Debug, thiserror::Error, Serialize, Deserialize)]
pub struct Error {
    /// Meaning of the failure to the caller.
    pub kind: ErrorKind,
    /// File that it concerns, once known.
    #[serde(with = "shown_path")]
    pub path: Option<PathBuf>,
    /// Place in that file, if known.
    pub position: Option<Position>,
    /// Text: what was found, and what would be right.
    pub message: String,
}

/// Serialization of a path: its name may hold bytes that are not text.
mod shown_path {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::path::PathBuf;

    pub fn serialize<S: Serializer>(path: &Option<PathBuf>, to: S) -> Result<S::Ok, S::Error> {
        let shown = path.as_ref().map(|path| path.to_string_lossy());
        shown.serialize(to)
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Option<PathBuf>, D::Error> {
        let shown = Option::<String>::deserialize(from)?;
        Ok(shown.map(PathBuf::from))
    }
}

impl Error {
    /// Reports wrong input: the message says what was found and what would be right.
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Input, message)
    }

    /// Reports a check that failed after the work was done.
    pub fn check(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Check, message)
    }

    /// Reports a failure of the system, in its own words.
    pub fn system(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::System, message)
    }

    /// Reports the end that a signal requested.
    pub fn interrupted(signal: i32, message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Interrupted { signal }, message)
    }

    /// Reports an input or output error on `path`. A missing file, a folder in its place and a name that is too long
    /// are wrong input; anything else is a failure of the system.
    pub fn io(path: &Path, source: &std::io::Error) -> Self {
        use std::io::ErrorKind as Io;
        let kind = match source.kind() {
            Io::NotFound
            | Io::IsADirectory
            | Io::NotADirectory
            | Io::InvalidInput
            | Io::InvalidFilename => ErrorKind::Input,
            _ => ErrorKind::System,
        };
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        let message = match (source.kind(), folder) {
            (Io::NotFound, Some(folder)) if !folder.exists() => {
                format!("there is no folder {}", folder.display())
            }
            (Io::NotFound, _) => "there is no such file".to_owned(),
            (Io::InvalidFilename, _) => {
                "the name is longer than this file system allows".to_owned()
            }
            _ => source.to_string(),
        };
        Self::new(kind, message).file(path)
    }

    fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self {
            kind,
            path: None,
            position: None,
            message: message.into(),
        }
    }

    /// Adds the file, unless one is named already. An empty path names no file.
    #[must_use]
    pub fn file(mut self, path: &Path) -> Self {
        if !path.as_os_str().is_empty() {
            self.path.get_or_insert_with(|| path.to_path_buf());
        }
        self
    }

    /// Adds a one-based line, unless a position is known already.
    #[must_use]
    pub fn line(self, line: u64) -> Self {
        self.at(Some(Position::Line(line)))
    }

    /// Adds a byte offset, unless a position is known already.
    #[must_use]
    pub fn byte(self, offset: u64) -> Self {
        self.at(Some(Position::Byte(offset)))
    }

    /// Adds the name of the part of the file, unless a position is known already.
    #[must_use]
    pub fn dataset(self, name: &str) -> Self {
        let name = match name {
            "" => "an array without a name",
            name => name,
        };
        self.at(Some(Position::Dataset(name.to_owned())))
    }

    /// Adds a position, unless one is known already.
    #[must_use]
    pub fn at(mut self, position: Option<Position>) -> Self {
        self.position = self.position.or(position);
        self
    }
}

/// One line, whatever names are in it.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}:", path_in_line(path))?;
        }
        match &self.position {
            Some(Position::Line(line)) if self.path.is_some() => write!(f, "{line}: ")?,
            Some(Position::Line(line)) => write!(f, "line {line}: ")?,
            Some(Position::Byte(offset)) => write!(f, " byte {offset}: ")?,
            Some(Position::Dataset(name)) => write!(f, " {}: ", one_line(name))?,
            Some(Position::Item(item)) => {
                f.write_str(if self.path.is_some() { " " } else { "" })?;
                // Not twice where the message is about it anyway.
                if !self.message.starts_with(item) {
                    write!(f, "{}: ", one_line(item))?;
                }
            }
            None if self.path.is_some() => write!(f, " ")?,
            None => {}
        }
        f.write_str(&one_line(&self.message))
    }
}

/// Text that keeps to its line and its direction: control characters and the like, as names may have
/// them, are written as escapes, `\n` or `\u{1b}`.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_unseen)
}

/// A path as printed in a line.
pub fn path_in_line(path: &Path) -> String {
    one_line(&path.to_string_lossy()).into_owned()
}

/// The same as [`one_line`] for text of several lines.
pub fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c != '\n' && is_unseen(c))
}

fn escaped(text: &str, wanted: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&wanted) {
        return text.into();
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if wanted(c) {
            escaped.extend(c.escape_default())
        } else {
            escaped.push(c)
        }
    }
    escaped.into()
}

/// Checks if a character is invisible but acts on a terminal: moves its cursor, ends its line, changes the
/// direction of its text.
pub fn is_unseen(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns || matches!(c, '\u{2028}' | '\u{2029}')
}

/// The name of an option in a sentence: a flag for the program, a word for the library alone, whose readers have `format` for
/// `input-format`.
pub fn option(name: &str) -> String {
    if ARE_FLAGS.load(Ordering::Relaxed) {
        format!("--{name}")
    } else {
        let name = name.strip_prefix("input-").unwrap_or(name);
        format!("`{}`", name.replace('-', "_"))
    }
}

static ARE_FLAGS: AtomicBool = AtomicBool::new(false);

/// From here on sentences name options as flags of the program.
pub fn name_options_as_flags() {
    ARE_FLAGS.store(true, Ordering::Relaxed);
}

/// A count and what it counts, as in `1 face` and `2 faces`.
pub fn counted(n: usize, noun: &str) -> String {
    match n {
        1 => format!("1 {noun}"),
        n => format!("{n} {noun}s"),
    }
}

/// The name of `known` nearest to `found`, for "did you mean" sentences.
pub fn nearest_name<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let found = found.to_lowercase();
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&found, &name.to_lowercase()), name))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_reads_path_line_message() {
        let error = Error::input("a triangle needs 3 node indices, found 2")
            .line(412)
            .file(Path::new("wing.su2"));
        assert_eq!(
            error.to_string(),
            "wing.su2:412: a triangle needs 3 node indices, found 2"
        );
    }

    #[test]
    fn what_is_missing_is_named() {
        let missing = |path: &str| {
            let path = Path::new(path);
            let error = std::fs::File::open(path).expect_err("it is not there");
            Error::io(path, &error).to_string()
        };
        assert_eq!(missing("no.vtu"), "no.vtu: there is no such file");
        let found = missing("no/x.vtu");
        assert_eq!(found, "no/x.vtu: there is no folder no");
    }

    #[test]
    fn the_innermost_place_wins() {
        let error = Error::input("x").line(1).line(2).file(Path::new("a"));
        assert_eq!(error.file(Path::new("b")).to_string(), "a:1: x");
    }

    #[test]
    fn a_part_without_a_name_is_called_so() {
        let error = Error::input("x").dataset("").file(Path::new("a"));
        assert_eq!(error.to_string(), "a: an array without a name: x");
    }

    #[test]
    fn an_item_is_named_once() {
        let at =
            |message: &str| Error::input(message).at(Some(Position::Item("body \"a\"".into())));
        assert_eq!(at("x").to_string(), "body \"a\": x");
        assert_eq!(at("body \"a\" flaps").to_string(), "body \"a\" flaps");
        assert_eq!(at("x").file(Path::new("")).to_string(), "body \"a\": x");
    }

    #[test]
    fn a_name_cannot_leave_its_line() {
        let name = "a\nb\u{1b}[31m\u{7f}\u{9b}\u{202e}é";
        let seen = r"a\nb\u{1b}[31m\u{7f}\u{9b}\u{202e}é";
        let error = Error::input(name).dataset(name).file(Path::new(name));
        assert_eq!(error.to_string(), format!("{seen}: {seen}: {seen}"));
        assert_eq!(lines("a\n\tb"), "a\n\\tb");
        assert_eq!(one_line("é \u{a0}"), "é \u{a0}");
    }

    #[test]
    fn the_nearest_name_is_suggested() {
        assert_eq!(nearest_name("blade1", ["hub", "blade_1"]), Some("blade_1"));
        assert_eq!(nearest_name("zzz", ["hub", "blade_1"]), None);
    }
}
