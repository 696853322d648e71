//! The scalars of an MSH file, as text or as binary of either byte order.

use super::super::lexer::{Fields, Lexer, Lines};
use azimesh_core::error::{Error, Result};

/// The versions of the format, as far as they differ; 2 stands for 2.0 to 2.2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Version {
    V1,
    V2,
    V3,
    V40,
    V41,
}

/// How numbers are stored in a binary file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Binary {
    pub big_endian: bool,
    /// Bytes of a `size_t`: 8 or 4.
    pub size_bytes: usize,
}

impl Binary {
    /// A 4-byte integer.
    pub fn int(self, bytes: &[u8]) -> i32 {
        let bytes = bytes.try_into().expect("an int has 4 bytes");
        match self.big_endian {
            false => i32::from_le_bytes(bytes),
            true => i32::from_be_bytes(bytes),
        }
    }

    /// A `size_t`; tags are kept as `i64`, one above its range comes out negative and unknown.
    pub fn size(self, bytes: &[u8]) -> i64 {
        match (bytes.try_into(), self.big_endian) {
            (Ok(bytes), false) => i64::from_le_bytes(bytes),
            (Ok(bytes), true) => i64::from_be_bytes(bytes),
            (Err(_), _) => i64::from(self.int(bytes) as u32),
        }
    }

    /// An 8-byte real.
    pub fn real(self, bytes: &[u8]) -> f64 {
        let bytes = bytes.try_into().expect("a double has 8 bytes");
        match self.big_endian {
            false => f64::from_le_bytes(bytes),
            true => f64::from_be_bytes(bytes),
        }
    }
}

/// A place in an MSH file.
#[derive(Debug)]
pub(super) struct Stream<'a> {
    /// Lines, which binary files have too.
    pub text: Lexer<'a>,
    /// How numbers are stored; `None` in text.
    pub binary: Option<Binary>,
    /// Sections whose end is missing, as they are shown.
    pub unended: Vec<String>,
}

impl<'a> Stream<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            text: Lexer::new(bytes, None),
            binary: None,
            unended: Vec::new(),
        }
    }

    /// The next `int`.
    pub fn int(&mut self, what: &str) -> Result<i32> {
        match self.binary {
            Some(binary) => Ok(binary.int(self.take(1, 4, what)?)),
            None => self.word(what)?.narrow(what),
        }
    }

    /// The next `size_t`.
    pub fn size(&mut self, what: &str) -> Result<usize> {
        let value = match self.binary {
            Some(binary) => binary.size(self.take(1, binary.size_bytes, what)?),
            None => self.word(what)?.integer(what)?,
        };
        usize::try_from(value)
            .map_err(|_| self.error(format!("{what} is {value}, which is out of range")))
    }

    /// Dimension and tag of the entity of a block; version 4.0 gives the tag first.
    pub fn entity(&mut self, version: Version) -> Result<(i32, i32)> {
        let first = self.int("the entity of a block")?;
        let second = self.int("the entity of a block")?;
        Ok(match version {
            Version::V40 => (second, first),
            _ => (first, second),
        })
    }

    /// The next `double`.
    pub fn real(&mut self, what: &str) -> Result<f64> {
        match self.binary {
            Some(binary) => Ok(binary.real(self.take(1, 8, what)?)),
            None => self.word(what)?.real(what),
        }
    }

    /// The next word of a text file.
    pub fn word(&mut self, what: &str) -> Result<Fields<'a>> {
        let word = self.text.word();
        word.ok_or_else(|| self.error(format!("the file ends before {what}")))
    }

    /// The next `n` items of `each` bytes, of a binary file.
    pub fn take(&mut self, n: usize, each: usize, what: &str) -> Result<&'a [u8]> {
        let rest = self.text.rest();
        let wanted = n.checked_mul(each).filter(|wanted| *wanted <= rest.len());
        let Some(wanted) = wanted else {
            return Err(self.error(format!(
                "the file ends within {what}: {n} times {each} bytes are needed, {} are left",
                rest.len()
            )));
        };
        self.text.set_position(self.text.position() + wanted);
        Ok(&rest[..wanted])
    }

    /// Moves past the end of a line of text that binary data follow.
    pub fn pass_line_end(&mut self) {
        let rest = self.text.rest();
        let rest = rest.strip_prefix(b"\r").unwrap_or(rest);
        let rest = rest.strip_prefix(b"\n").unwrap_or(rest);
        let at = self.text.bytes().len() - rest.len();
        self.text.set_position(at);
    }

    /// The next `n` lines of a text file.
    pub fn lines(&mut self, n: usize, what: &str) -> Result<Lines<'a>> {
        self.text.take_lines(n, what)
    }

    /// Whether the next line of a text file has more than `n` words: some programs write a whole
    /// block on one line.
    pub fn has_long_line(&self, n: usize) -> bool {
        let line = self.text.rest().trim_ascii_start();
        let line = line.iter().take_while(|byte| **byte != b'\n');
        let mut n_words = 0;
        let mut blank_before = true;
        for is_blank in line.map(u8::is_ascii_whitespace) {
            n_words += usize::from(blank_before && !is_blank);
            if n_words > n {
                return true;
            }
            blank_before = is_blank;
        }
        false
    }

    /// An error at the next byte, or its line.
    pub fn error(&self, message: impl Into<String>) -> Error {
        match self.binary {
            Some(_) => Error::input(message).byte(self.text.position() as u64),
            None => self.text.error(message),
        }
    }
}
