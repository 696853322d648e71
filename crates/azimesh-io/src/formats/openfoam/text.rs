//! A place in a file of OpenFOAM: blanks and comments, words, numbers and values of dictionaries. Knows nothing of
//! lists or of what the words mean.

use super::super::tokens::{line_of, shown};
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// A place in a file, moving forward.
#[derive(Debug, Clone)]
pub(super) struct Text<'a> {
    /// The whole file, so that positions in errors are those in it.
    pub bytes: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
    /// Where the part that is read ends.
    pub end: usize,
    /// Whether errors tell the byte rather than the line.
    pub is_binary: bool,
}

impl<'a> Text<'a> {
    /// A part of a file that is text.
    pub fn new(bytes: &'a [u8], part: Range<usize>) -> Self {
        let end = part.end.min(bytes.len());
        Self {
            bytes,
            at: part.start.min(end),
            end,
            is_binary: false,
        }
    }

    /// What is left.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at.min(self.end)..self.end]
    }

    /// An error at the next byte.
    #[cold]
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.error_at(self.at, message)
    }

    /// An error at this byte.
    #[cold]
    pub fn error_at(&self, at: usize, message: impl Into<String>) -> Error {
        if self.is_binary {
            Error::input(message).byte(at as u64)
        } else {
            Error::input(message).line(line_of(self.bytes, at))
        }
    }

    /// What stands here, for errors.
    pub fn found(&self) -> String {
        match self.rest() {
            [] => "the end of the file".to_owned(),
            rest => {
                let line = rest.split(|byte| *byte == b'\n').next();
                shown(line.unwrap_or(rest).trim_ascii_end())
            }
        }
    }

    /// Passes blanks and comments, `//` to the end of the line and `/* */`.
    pub fn skip(&mut self) {
        loop {
            let rest = self.rest();
            let blanks = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
            let blanks = blanks.count();
            self.at += blanks;
            match &rest[blanks..] {
                [b'/', b'/', comment @ ..] => {
                    let length = memchr::memchr(b'\n', comment).unwrap_or(comment.len());
                    self.at += 2 + length;
                }
                [b'/', b'*', comment @ ..] => {
                    let length = memchr::memmem::find(comment, b"*/").map(|at| at + 2);
                    self.at += 2 + length.unwrap_or(comment.len());
                }
                _ => return,
            }
        }
    }

    /// The next byte that is no blank, without moving past it.
    pub fn peek(&mut self) -> Option<u8> {
        self.skip();
        self.rest().first().copied()
    }

    /// Passes this byte if it is the next.
    pub fn take(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == Some(byte);
        self.at += usize::from(is_next);
        is_next
    }

    /// Passes this byte; an error where another comes.
    pub fn expect(&mut self, byte: u8, what: &str) -> Result<()> {
        if self.take(byte) {
            return Ok(());
        }
        let (byte, found) = (char::from(byte), self.found());
        Err(self.error(format!("expected {byte} {what}, found {found}")))
    }

    /// The next word, or the text between quotes. A word may have balanced brackets in it, as in `div(phi,U)`.
    pub fn word(&mut self, what: &str) -> Result<&'a [u8]> {
        self.skip();
        let rest = self.rest();
        if let [b'"', text @ ..] = rest {
            let Some(length) = end_of_string(text) else {
                return Err(self.error("the text after \" has no closing \""));
            };
            self.at += length + 2;
            return Ok(&text[..length]);
        }
        let length = length_of_word(rest);
        if length == 0 {
            return Err(self.error(format!("expected {what}, found {}", self.found())));
        }
        self.at += length;
        Ok(&rest[..length])
    }

    /// The next integer, and nothing after it.
    pub fn integer(&mut self, what: &str) -> Result<i64> {
        self.skip();
        match integer(self.rest()) {
            Some((value, length)) => {
                self.at += length;
                Ok(value)
            }
            None => Err(self.error(format!(
                "expected an integer as {what}, found {}",
                self.found()
            ))),
        }
    }

    /// The text up to the next semicolon that is in no brackets and no quotes, trimmed; passes the semicolon.
    pub fn value(&mut self) -> Result<&'a [u8]> {
        self.skip();
        let start = self.at;
        let mut depth = 0usize;
        loop {
            let place = self.at;
            match self.peek() {
                Some(b';') if depth == 0 => {
                    self.at += 1;
                    return Ok(self.bytes[start..place.max(start)].trim_ascii());
                }
                Some(b'(' | b'[' | b'{') => depth += 1,
                Some(b')' | b']' | b'}') if depth > 0 => depth -= 1,
                Some(b'"') => {
                    self.word("a text")?;
                    continue;
                }
                Some(b')' | b']' | b'}') | None => {
                    let message = "an entry ends without a semicolon";
                    return Err(self.error_at(start, message));
                }
                Some(_) => {}
            }
            self.at += 1;
        }
    }

    /// The text from the next `{` to its `}`, both included.
    pub fn braces(&mut self) -> Result<&'a [u8]> {
        self.expect(b'{', "before a dictionary")?;
        let start = self.at - 1;
        let mut depth = 1usize;
        while depth > 0 {
            match self.peek() {
                Some(b'{') => depth += 1,
                Some(b'}') => depth -= 1,
                Some(b'"') => {
                    self.word("a text")?;
                    continue;
                }
                Some(_) => {}
                None => return Err(self.error_at(start, "a { has no closing }")),
            }
            self.at += 1;
        }
        Ok(&self.bytes[start..self.at])
    }
}

/// Length of the word at the start of these bytes.
fn length_of_word(bytes: &[u8]) -> usize {
    let mut depth = 0usize;
    let is_part = |(at, byte): (usize, &u8)| {
        match byte {
            b'(' if at > 0 => depth += 1,
            b')' if depth > 0 => depth -= 1,
            b'(' | b')' | b'{' | b'}' | b';' | b'"' | b'[' | b']' => return false,
            byte => return !byte.is_ascii_whitespace(),
        }
        true
    };
    bytes
        .iter()
        .enumerate()
        .map(is_part)
        .take_while(|is_part| *is_part)
        .count()
}

/// Length of a text before its closing quote.
fn end_of_string(text: &[u8]) -> Option<usize> {
    let mut at = 0;
    loop {
        at += memchr::memchr2(b'"', b'\\', &text[at..])?;
        match text[at] {
            b'"' => return Some(at),
            _ => at += 2,
        }
        if at > text.len() {
            return None;
        }
    }
}

/// The integer at the start of these bytes, and its length. No word may follow it directly.
#[inline]
pub(super) fn integer(bytes: &[u8]) -> Option<(i64, usize)> {
    let is_negative = bytes.first() == Some(&b'-');
    let start = usize::from(is_negative || bytes.first() == Some(&b'+'));
    let mut at = start;
    let mut value = 0i64;
    while let Some(byte) = bytes.get(at).filter(|byte| byte.is_ascii_digit()) {
        let digit = i64::from(byte - b'0');
        value = value.checked_mul(10)?.checked_add(digit)?;
        at += 1;
    }
    let goes_on = bytes.get(at).is_some_and(|byte| {
        byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-' | b'+')
    });
    let is_number = at > start && !goes_on;
    is_number.then_some((if is_negative { -value } else { value }, at))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Text<'_> {
        Text::new(text.as_bytes(), 0..text.len())
    }

    #[test]
    fn comments_are_blanks() {
        let mut text = text("// a\n /* b */ /*c\n*/ div(phi,U) \"x y\" 12(");
        assert_eq!(text.word("a word").expect("one"), b"div(phi,U)");
        assert_eq!(text.word("a word").expect("two"), b"x y");
        assert_eq!(text.integer("a number").expect("three"), 12);
        assert!(text.take(b'(') && text.peek().is_none());
    }

    #[test]
    fn a_value_ends_at_its_own_semicolon() {
        let mut text = text(" 1(wall \";\" ) ; b { c d; } e");
        assert_eq!(text.value().expect("one"), b"1(wall \";\" )");
        assert_eq!(text.word("a key").expect("b"), b"b");
        assert_eq!(text.braces().expect("two"), b"{ c d; }");
        let error = text.value().expect_err("no semicolon").to_string();
        assert_eq!(error, "line 1: an entry ends without a semicolon");
    }

    #[test]
    fn numbers_stand_alone() {
        assert_eq!(integer(b"12)"), Some((12, 2)));
        assert_eq!(integer(b"-7 "), Some((-7, 2)));
        for wrong in ["", "-", "1.5", "x", "3a", "99999999999999999999"] {
            assert_eq!(integer(wrong.as_bytes()), None, "{wrong}");
        }
    }
}
