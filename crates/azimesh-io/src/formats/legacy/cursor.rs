//! A position in a legacy file: reads keywords, counts and lines, and places errors.
//!
//! The file is words separated by white space; only the values of binary arrays are not, and they
//! start on the line after their keyword.

use super::super::Notes;
use super::super::names::text_of;
use super::super::tokens::{line_of, shown};
use super::super::vtk::number::Element;
use azimesh_core::error::{Error, Result};

/// A place in a legacy file.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub binary: bool,
    /// Version of the file, major and minor.
    pub version: (u32, u32),
    /// The second line.
    pub title: &'a [u8],
}

impl<'a> Cursor<'a> {
    /// Reads the three lines of the header.
    pub fn open(bytes: &'a [u8]) -> Result<Self> {
        let mut cursor = Self {
            bytes,
            at: 0,
            binary: false,
            version: (0, 0),
            title: &[],
        };
        let first = cursor.line().trim_ascii();
        cursor.version = version(first).ok_or_else(|| {
            let found = shown(first);
            let message =
                format!("expected \"# vtk DataFile Version\" and a number, found {found}");
            Error::input(message).line(1)
        })?;
        cursor.title = cursor.line().trim_ascii();
        cursor.binary = match cursor.keyword().as_deref() {
            Some("ascii") => false,
            Some("binary") => true,
            _ => return Err(Error::input("the third line must be ASCII or BINARY").line(3)),
        };
        Ok(cursor)
    }

    /// The type of numbers that text and binary files have as different types.
    pub fn by_encoding(&self, binary: Element, text: Element) -> Element {
        if self.binary { binary } else { text }
    }

    /// The bytes from the position on.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The rest of the line; moves on to the next one.
    pub fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        &rest[..length]
    }

    /// The next word; `None` at the end.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        let blank = |byte: &&u8| byte.is_ascii_whitespace() || **byte == 0;
        self.at += self.rest().iter().take_while(blank).count();
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..length.unwrap_or(rest.len())];
        self.at += word.len();
        (!word.is_empty()).then_some(word)
    }

    /// The next word in lower case, comments passed over.
    pub fn keyword(&mut self) -> Option<String> {
        loop {
            let word = self.word()?;
            if word[0] == b'#' {
                self.line();
                continue;
            }
            // Whatever is longer is none, but data read as text.
            let head = &word[..word.len().min(64)];
            return Some(String::from_utf8_lossy(head).to_ascii_lowercase());
        }
    }

    /// The next keyword without moving on.
    pub fn peek(&self) -> Option<String> {
        self.clone().keyword()
    }

    /// The next word, which must be there.
    pub fn need(&mut self, what: &str) -> Result<&'a [u8]> {
        let at = self.at;
        let word = self.word();
        word.ok_or_else(|| self.error_at(at, format!("the file ends where {what} should be")))
    }

    /// The next word as the name of an array, decoded.
    pub fn name(&mut self, notes: &mut Notes) -> Result<String> {
        Ok(decoded(self.need("the name of an array")?, notes))
    }

    /// The next word as a whole number, zero or more.
    pub fn count(&mut self, what: &str) -> Result<usize> {
        let word = self.need(what)?;
        let text = std::str::from_utf8(word).ok();
        text.and_then(|text| text.parse().ok()).ok_or_else(|| {
            let found = shown(word);
            self.error(format!("expected {what}, a whole number, found {found}"))
        })
    }

    /// The next word as a number.
    pub fn real(&mut self, what: &str) -> Result<f64> {
        let word = self.need(what)?;
        fast_float2::parse(word).map_err(|_| {
            let found = shown(word);
            self.error(format!("expected {what}, a number, found {found}"))
        })
    }

    /// An error at the last word.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.error_at(self.at.saturating_sub(1), message)
    }

    /// An error at a byte: as a line of text, or as the byte.
    pub fn error_at(&self, at: usize, message: impl Into<String>) -> Error {
        if self.binary {
            Error::input(message).byte(at as u64)
        } else {
            Error::input(message).line(line_of(self.bytes, at))
        }
    }
}

fn version(line: &[u8]) -> Option<(u32, u32)> {
    let line = std::str::from_utf8(line).ok()?.to_ascii_lowercase();
    let number = line.strip_prefix("# vtk datafile version")?.trim();
    let mut parts = number.split('.');
    let major = parts.next()?.parse().ok()?;
    let minor = parts.next().unwrap_or("0");
    Some((major, minor.parse().ok()?))
}

/// A name or string as VTK encodes it: `%` and two digits for a byte.
pub(super) fn decoded(word: &[u8], notes: &mut Notes) -> String {
    let mut bytes = Vec::with_capacity(word.len());
    let mut rest = word;
    while let Some((&byte, tail)) = rest.split_first() {
        let code = tail.get(..2).filter(|_| byte == b'%');
        let code = code.and_then(|code| std::str::from_utf8(code).ok());
        let code = code.and_then(|code| u8::from_str_radix(code, 16).ok());
        bytes.push(code.unwrap_or(byte));
        rest = &tail[2 * usize::from(code.is_some())..];
    }
    text_of(&bytes, notes)
}

/// The other way round.
pub(super) fn encoded(text: &str) -> String {
    let mut encoded = String::with_capacity(text.len());
    for byte in text.bytes() {
        match byte {
            b'"' | b'%' | 0..=32 | 127.. => encoded += &format!("%{byte:02X}"),
            _ => encoded.push(char::from(byte)),
        }
    }
    encoded
}
