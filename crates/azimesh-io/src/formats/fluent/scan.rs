//! Sections in parentheses: `(index (header) (body))`, text, or binary with an index from 2000 on.

use super::content::Place;
use crate::formats::lexer::{line_of, shown};
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// Closes a binary section, with its index.
const END: &[u8] = b"End of Binary Section";
/// Most numbers of a header.
const HEADER: usize = 64;

/// A place in a file, moving forward by sections.
pub(super) struct Scanner<'a> {
    /// The whole file.
    pub bytes: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
    /// The first binary section: what lies behind has no line.
    first_binary: usize,
}

/// The numbers of a header.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Header {
    /// Offset of its first byte.
    pub at: usize,
    /// Its numbers.
    pub numbers: Vec<u64>,
}

impl<'a> Scanner<'a> {
    /// From the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            first_binary: usize::MAX,
        }
    }

    /// The index of the next section; `None` at the end of the file. Sections with a word as index, as Fluent Meshing
    /// has them for its own settings, are passed.
    pub fn section(&mut self) -> Result<Option<u32>> {
        loop {
            self.blanks();
            match self.peek() {
                None => return Ok(None),
                Some(b'(') => self.at += 1,
                Some(_) => return Err(self.expected("a section, which starts with \"(\"")),
            }
            self.blanks();
            if !self.peek().is_some_and(|byte| byte.is_ascii_alphabetic()) {
                return self.index().map(Some);
            }
            let word = String::from_utf8_lossy(self.word());
            self.pass_text(&word, false)?;
        }
    }

    /// The number that a section begins with.
    fn index(&mut self) -> Result<u32> {
        let start = self.at;
        let digits = self.rest().iter().take_while(|b| b.is_ascii_digit());
        let n = digits.count();
        let text = &self.bytes[start..start + n];
        let number = std::str::from_utf8(text).ok().and_then(|t| t.parse().ok());
        let Some(number) = number else {
            return Err(self.expected("the index of a section"));
        };
        self.at += n;
        if number >= 2000 {
            self.first_binary = self.first_binary.min(self.at);
        }
        Ok(number)
    }

    /// The next `(number ...)`, of hexadecimal numbers.
    pub fn header(&mut self) -> Result<Header> {
        self.blanks();
        let at = self.at;
        self.need(b'(', "the numbers of a section in parentheses")?;
        let mut numbers = Vec::new();
        loop {
            self.blanks();
            if self.peek() == Some(b')') {
                self.at += 1;
                return Ok(Header { at, numbers });
            }
            let n = self
                .rest()
                .iter()
                .take_while(|b| b.is_ascii_hexdigit())
                .count();
            let text = std::str::from_utf8(&self.rest()[..n]).unwrap_or("");
            match u64::from_str_radix(text, 16) {
                Ok(number) if numbers.len() < HEADER => numbers.push(number),
                _ => return Err(self.expected("a hexadecimal number")),
            }
            self.at += n;
        }
    }

    /// The bytes between the parentheses of a body of numbers; `None` where the section ends instead. The section is
    /// passed.
    pub fn numbers(&mut self) -> Result<Option<Range<usize>>> {
        self.blanks();
        if self.peek() == Some(b')') {
            self.at += 1;
            return Ok(None);
        }
        self.need(b'(', "the numbers of the section in parentheses")?;
        let start = self.at;
        let Some(n) = memchr::memchr2(b')', b'(', self.rest()) else {
            let message = "the file ends within the numbers of a section";
            return Err(self.place(self.bytes.len()).error(message));
        };
        self.at += n;
        self.need(b')', "the end of the numbers")?;
        self.blanks();
        self.need(b')', "the end of the section")?;
        Ok(Some(start..start + n))
    }

    /// Whether a binary section has a body; its first byte is the next one then. Without a body the section is passed.
    pub fn binary_body(&mut self) -> Result<bool> {
        self.blanks();
        if self.peek() == Some(b'(') {
            self.at += 1;
            return Ok(true);
        }
        self.end_of_binary()?;
        Ok(false)
    }

    /// Passes over what closes a binary body: `)`, and the words at its end.
    pub fn close_binary(&mut self) -> Result<()> {
        self.blanks();
        self.need(b')', "the end of the binary numbers")?;
        self.end_of_binary()
    }

    fn end_of_binary(&mut self) -> Result<()> {
        self.blanks();
        if self.rest().starts_with(END) {
            self.at += END.len();
            self.blanks();
            let digits = self.rest().iter().take_while(|b| b.is_ascii_digit());
            self.at += digits.count();
            self.blanks();
        }
        self.need(b')', "the end of the section")
    }

    /// Passes over a section whose index was read.
    pub fn pass(&mut self, index: u32) -> Result<()> {
        if index >= 2000 {
            let found = memchr::memmem::find(self.rest(), END);
            let Some(n) = found else {
                self.at = self.bytes.len();
                return Err(self.error(format!(
                    "the file ends within the binary section {index}: \"End of Binary Section\" is not there"
                )));
            };
            self.at += n;
            return self.end_of_binary();
        }
        // Comments have quotes and backslashes as their writers like.
        let is_free = index == 0 && {
            self.blanks();
            self.peek() != Some(b'"')
        };
        self.pass_text(&index.to_string(), is_free)
    }

    /// Passes over a section of text whose index was read. In free text quotes and backslashes mean nothing.
    fn pass_text(&mut self, index: &str, is_free: bool) -> Result<()> {
        let start = self.at;
        let mut depth = 1_usize;
        while depth > 0 {
            let found = match is_free {
                true => memchr::memchr2(b'(', b')', self.rest()),
                false => {
                    let is_mark = |b: &u8| matches!(b, b'(' | b')' | b'"' | b'\\');
                    self.rest().iter().position(is_mark)
                }
            };
            let Some(n) = found else {
                self.at = start;
                return Err(self.error(format!(
                    "section {index} has no end: expected \")\", found the end of the file"
                )));
            };
            self.at += n + 1;
            match self.bytes[self.at - 1] {
                b'(' => depth += 1,
                b')' => depth -= 1,
                b'"' => self.string(),
                _ => self.at = (self.at + 1).min(self.bytes.len()),
            }
        }
        Ok(())
    }

    /// Passes over the rest of a string; a quote without another one is a character like others.
    fn string(&mut self) {
        let mut at = self.at;
        while let Some(n) = memchr::memchr2(b'"', b'\\', &self.bytes[at..]) {
            let found = at + n;
            if self.bytes[found] == b'"' {
                self.at = found + 1;
                return;
            }
            at = (found + 2).min(self.bytes.len());
        }
    }

    /// The next word up to a blank or a parenthesis, which may be in quotes.
    pub fn word(&mut self) -> &'a [u8] {
        self.blanks();
        let start = self.at;
        if self.peek() == Some(b'"') {
            self.at += 1;
            self.string();
            let end = self.at.saturating_sub(1).max(start + 1);
            return &self.bytes[start + 1..end];
        }
        let is_end = |b: &u8| b.is_ascii_whitespace() || matches!(b, b'(' | b')');
        let n = self.rest().iter().take_while(|b| !is_end(b)).count();
        self.at += n;
        &self.bytes[start..start + n]
    }

    /// Passes over white space.
    pub fn blanks(&mut self) {
        // Some writers close a file with zeros.
        let is_blank = |b: &&u8| b.is_ascii_whitespace() || **b == 0;
        self.at += self.rest().iter().take_while(is_blank).count();
    }

    /// Passes over this byte.
    pub fn need(&mut self, byte: u8, what: &str) -> Result<()> {
        if self.peek() != Some(byte) {
            return Err(self.expected(what));
        }
        self.at += 1;
        Ok(())
    }

    /// The next byte.
    pub fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// The bytes from here on.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn expected(&self, what: &str) -> Error {
        let found = match self.rest() {
            [] => "the end of the file".to_owned(),
            rest => shown(&rest[..rest.len().min(24)]),
        };
        self.error(format!("expected {what}, found {found}"))
    }

    /// Whether the file ends within the numbers that begin here.
    pub fn is_cut_off(&self) -> bool {
        memchr::memchr2(b')', b'(', self.rest()).is_none()
    }

    /// An error at the next byte.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.place(self.at).error(message)
    }

    /// Where a byte is: its line, or itself behind binary data.
    pub fn place(&self, at: usize) -> Place {
        match at < self.first_binary {
            true => Place::Line(line_of(self.bytes, at)),
            false => Place::Byte(at as u64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_passed_with_what_they_contain() {
        let text = b"(0 \"a ) in quotes, \\\" too\")(0 free ( \" ) text)\n(37 (x . \"(\") (y #\\())\n(2041 (1 2)\n(\x01)((\x02)\n\
                     End of Binary Section   2041)\n(2 3)\0\0";
        let mut scanner = Scanner::new(text);
        for expected in [0, 0, 37, 2041] {
            let index = scanner.section().expect("a section").expect("one more");
            assert_eq!(index, expected);
            scanner.pass(index).expect("it has an end");
        }
        assert_eq!(scanner.section().expect("a section"), Some(2));
        assert_eq!(scanner.word(), b"3");
        scanner.need(b')', "the end").expect("it ends");
        assert_eq!(scanner.section().expect("the end"), None);
    }

    #[test]
    fn sections_with_a_word_as_index_are_passed() {
        let text = b"(cad/adv-options ((unit \"m)m\") (on . #t)))\n(meshing-data)(2 3)";
        let mut scanner = Scanner::new(text);
        assert_eq!(scanner.section().expect("a section"), Some(2));
        let mut scanner = Scanner::new(b"\n(cad/options (1 2)\n(2 3)");
        let error = scanner.section().expect_err("no end").to_string();
        assert!(
            error.contains("line 2: section cad/options has no end"),
            "{error}"
        );
        let mut scanner = Scanner::new(b"(+ 3)");
        let error = scanner.section().expect_err("no index").to_string();
        assert!(error.contains("expected the index of a section"), "{error}");
    }

    #[test]
    fn headers_are_hexadecimal_and_errors_have_their_place() {
        let mut scanner = Scanner::new(b"\n(10 ( 1 ff A 2)( x ) )\n(10 (1 -2))\n");
        assert_eq!(scanner.section().expect("a section"), Some(10));
        let header = scanner.header().expect("numbers");
        assert_eq!((header.numbers, header.at), (vec![1, 255, 10, 2], 5));
        assert_eq!(scanner.numbers().expect("a body"), Some(17..20));
        assert_eq!(scanner.section().expect("a section"), Some(10));
        let error = scanner.header().expect_err("no number").to_string();
        assert_eq!(
            error,
            "line 3: expected a hexadecimal number, found \"-2))\\n\""
        );
        let mut scanner = Scanner::new(b"(2041 (1)\n(\x01");
        assert_eq!(scanner.section().expect("a section"), Some(2041));
        let error = scanner.pass(2041).expect_err("no end").to_string();
        assert!(error.contains("byte 12: the file ends within"), "{error}");
    }
}
