//! A position in a file of OpenFOAM: blanks and comments, words, integers and values of dictionaries.

use super::super::tokens::{line_of, shown};
use azimesh_core::error::{Error, Result};

/// A position in a file, moving forward. Values end at brackets and semicolons as well as at blanks, and comments may be
/// anywhere, which the shared `Tokens` do not have.
#[derive(Debug, Clone)]
pub(super) struct Text<'a> {
    /// The file up to the end of the part that is read, so that positions in errors are positions in the file.
    pub bytes: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
    /// Errors report the byte rather than the line.
    pub is_binary: bool,
}

impl<'a> Text<'a> {
    /// A file, from a byte on.
    pub fn new(bytes: &'a [u8], at: usize) -> Self {
        Self {
            bytes,
            at,
            is_binary: false,
        }
    }

    /// The bytes from the position on.
    #[inline]
    pub fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
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

    /// An error at this byte, with the text that is there.
    #[cold]
    pub fn expected(&self, at: usize, what: &str) -> Error {
        let found = match self.bytes.get(at..).unwrap_or_default() {
            [] => "the end of the file".to_owned(),
            rest => {
                let line = rest.split(|byte| *byte == b'\n').next();
                shown(line.unwrap_or(rest).trim_ascii_end())
            }
        };
        self.error_at(at, format!("expected {what}, found {found}"))
    }

    /// Passes blanks and comments, `//` to the end of the line and `/* */`.
    #[inline]
    pub fn skip(&mut self) {
        loop {
            while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
                self.at += 1;
            }
            if self.bytes.get(self.at) != Some(&b'/') {
                return;
            }
            match length_of_comment(self.rest()) {
                0 => return,
                length => self.at += length,
            }
        }
    }

    /// The next byte that is not blank, without moving past it.
    #[inline]
    pub fn peek(&mut self) -> Option<u8> {
        self.skip();
        self.bytes.get(self.at).copied()
    }

    /// Passes this byte if it is the next.
    #[inline]
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
        Err(self.expected(self.at, &format!("{} {what}", char::from(byte))))
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
        let mut depth = 0usize;
        let length = rest.iter().enumerate().position(|(at, byte)| match byte {
            b'(' if at > 0 => {
                depth += 1;
                false
            }
            b')' if depth > 0 => {
                depth -= 1;
                false
            }
            b'(' | b')' | b'{' | b'}' | b';' | b'"' | b'[' | b']' => true,
            byte => byte.is_ascii_whitespace(),
        });
        let length = length.unwrap_or(rest.len());
        if length == 0 {
            return Err(self.expected(self.at, what));
        }
        self.at += length;
        Ok(&rest[..length])
    }

    /// The next integer, which no word may follow directly.
    pub fn integer(&mut self, what: &str) -> Result<i64> {
        self.digits()
            .ok_or_else(|| self.expected(self.at, &format!("an integer as {what}")))
    }

    /// [`Text::integer`], `None` where there is none.
    #[inline]
    pub fn digits(&mut self) -> Option<i64> {
        self.skip();
        let bytes = self.rest();
        let is_negative = bytes.first() == Some(&b'-');
        let start = usize::from(is_negative || bytes.first() == Some(&b'+'));
        let (mut at, mut value) = (start, 0i64);
        while let Some(byte) = bytes.get(at).filter(|byte| byte.is_ascii_digit()) {
            let digit = i64::from(byte - b'0');
            value = value.checked_mul(10)?.checked_add(digit)?;
            at += 1;
        }
        let goes_on = |byte: &u8| byte.is_ascii_alphanumeric() || b"._-+".contains(byte);
        if at == start || bytes.get(at).is_some_and(goes_on) {
            return None;
        }
        self.at += at;
        Some(if is_negative { -value } else { value })
    }

    /// The value of an entry: a dictionary with its braces, or the text up to the next semicolon that is in no brackets
    /// and no quotes, trimmed. Passes the semicolon.
    pub fn value(&mut self) -> Result<&'a [u8]> {
        let is_dictionary = self.peek() == Some(b'{');
        let start = self.at;
        let mut depth = 0usize;
        loop {
            let end = self.at;
            match self.peek() {
                Some(b'"') => {
                    self.word("a text")?;
                    continue;
                }
                Some(b'{') => depth += 1,
                Some(b'}') if depth > 0 => depth -= 1,
                None if is_dictionary => {
                    return Err(self.error_at(start, "a { has no closing }"));
                }
                Some(_) if is_dictionary => {}
                Some(b'(' | b'[') => depth += 1,
                Some(b')' | b']') if depth > 0 => depth -= 1,
                Some(b')' | b']' | b'}') | None => {
                    return Err(self.error_at(start, "an entry ends without a semicolon"));
                }
                Some(b';') if depth == 0 => {
                    self.at += 1;
                    return Ok(self.bytes[start..end].trim_ascii());
                }
                Some(_) => {}
            }
            self.at += 1;
            if is_dictionary && depth == 0 {
                return Ok(&self.bytes[start..self.at]);
            }
        }
    }
}

/// Length of a comment at the start of these bytes; 0 without one.
#[cold]
fn length_of_comment(text: &[u8]) -> usize {
    match text {
        [b'/', b'/', comment @ ..] => 2 + memchr::memchr(b'\n', comment).unwrap_or(comment.len()),
        [b'/', b'*', comment @ ..] => {
            let length = memchr::memmem::find(comment, b"*/");
            2 + length.map_or(comment.len(), |length| length + 2)
        }
        _ => 0,
    }
}

/// Length of a text before its closing quote.
fn end_of_string(text: &[u8]) -> Option<usize> {
    let mut at = 0;
    loop {
        at += memchr::memchr2(b'"', b'\\', text.get(at..)?)?;
        if text[at] == b'"' {
            return Some(at);
        }
        at += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Text<'_> {
        Text::new(text.as_bytes(), 0)
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
        assert_eq!(text.value().expect("two"), b"{ c d; }");
        let error = text.value().expect_err("no semicolon").to_string();
        assert_eq!(error, "line 1: an entry ends without a semicolon");
    }

    #[test]
    fn an_integer_ends_at_a_bracket_and_not_in_a_word() {
        assert_eq!(text("12)").digits(), Some(12));
        assert_eq!(text("-7 ").digits(), Some(-7));
        for wrong in ["", "-", "1.5", "x", "3a", "99999999999999999999"] {
            assert_eq!(text(wrong).digits(), None, "{wrong}");
        }
    }
}
