//! The scalars of an MSH file, as text or as binary of either byte order.

use super::super::tokens::{Tokens, line_of};
use azimesh_core::error::{Error, Result};

/// The versions of the format, as far as they differ; 2 stands for 2.0 to 2.2.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) enum Version {
    V1,
    V2,
    V40,
    V41,
}

/// Encoding of the numbers in a binary file.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Binary {
    pub big_endian: bool,
    /// Bytes of a `size_t`: 8 or 4.
    pub size_bytes: usize,
}

impl Binary {
    pub fn int(self, bytes: &[u8]) -> i32 {
        let number = i32::from_le_bytes(bytes.try_into().expect("an int has 4 bytes"));
        if self.big_endian {
            number.swap_bytes()
        } else {
            number
        }
    }

    /// A tag or `size_t` of 8 or 4 bytes; one above the signed range comes out negative and unknown.
    pub fn size(self, bytes: &[u8]) -> i64 {
        match (bytes.try_into(), self.big_endian) {
            (Ok(bytes), false) => i64::from_le_bytes(bytes),
            (Ok(bytes), true) => i64::from_be_bytes(bytes),
            (Err(_), _) => self.int(bytes).into(),
        }
    }

    pub fn real(self, bytes: &[u8]) -> f64 {
        f64::from_bits(self.size(bytes) as u64)
    }
}

/// A position in an MSH file.
#[derive(Debug)]
pub(super) struct Stream<'a> {
    /// Lines, which binary files have too.
    pub text: Tokens<'a>,
    pub version: Version,
    /// `None` in text.
    pub binary: Option<Binary>,
    /// Sections whose end is missing, as they are shown.
    pub unended: Vec<String>,
}

impl<'a> Stream<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            text: Tokens::new(bytes),
            version: Version::V1,
            binary: None,
            unended: Vec::new(),
        }
    }

    pub fn int(&mut self, what: &str) -> Result<i32> {
        match self.binary {
            Some(binary) => Ok(binary.int(self.take(1, 4, what)?)),
            None => self.word(what)?.narrow(what),
        }
    }

    pub fn size(&mut self, what: &str) -> Result<usize> {
        let value = match self.binary {
            Some(binary) => binary.size(self.take(1, binary.size_bytes, what)?),
            None => self.word(what)?.integer(what)?,
        };
        usize::try_from(value)
            .map_err(|_| self.error(format!("{what} is {value}, which is out of range")))
    }

    pub fn real(&mut self, what: &str) -> Result<f64> {
        match self.binary {
            Some(binary) => Ok(binary.real(self.take(1, 8, what)?)),
            None => self.word(what)?.real(what),
        }
    }

    /// Reads the counts that start a section of version 4: blocks and items.
    pub fn block_counts(&mut self, item: &str) -> Result<(usize, usize)> {
        let n_blocks = self.size(&format!("the number of {item} blocks"))?;
        let n_items = self.size(&format!("the number of {item}s"))?;
        if self.version == Version::V41 {
            self.size(&format!("the lowest {item} tag"))?;
            self.size(&format!("the highest {item} tag"))?;
        }
        Ok((n_blocks, n_items))
    }

    /// Dimension and tag of the entity of a block; version 4.0 gives the tag first.
    pub fn entity(&mut self) -> Result<(i32, i32)> {
        let first = self.int("the entity of a block")?;
        let second = self.int("the entity of a block")?;
        Ok(match self.version {
            Version::V40 => (second, first),
            _ => (first, second),
        })
    }

    /// The count that starts a section up to version 2, a line of text in binary files too.
    pub fn count(&mut self, what: &str) -> Result<usize> {
        let line = self.text.line();
        let mut line = line.ok_or_else(|| self.error(format!("the file ends before {what}")))?;
        let n = line.narrow(what)?;
        line.end(what)?;
        Ok(n)
    }

    /// The next word of a text file.
    pub fn word(&mut self, what: &str) -> Result<Tokens<'a>> {
        let word = self.text.next_word();
        word.ok_or_else(|| self.error(format!("the file ends before {what}")))
    }

    /// The next `n` items of `each` bytes, of a binary file.
    pub fn take(&mut self, n: usize, each: usize, what: &str) -> Result<&'a [u8]> {
        let rest = self.text.left();
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
        let rest = self.text.left();
        let rest = rest.strip_prefix(b"\r").unwrap_or(rest);
        let rest = rest.strip_prefix(b"\n").unwrap_or(rest);
        let at = self.text.bytes().len() - rest.len();
        self.text.set_position(at);
    }

    /// Checks if the next line of a text file has more than `n` words: some programs write a whole
    /// block on one line.
    pub fn has_long_line(&self, n: usize) -> bool {
        let line = self.text.peek_line();
        line.is_some_and(|mut line| std::iter::from_fn(|| line.word()).nth(n).is_some())
    }

    /// An error at the next byte, or its line.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.located(Error::input(message))
    }

    /// Adds the next byte, or its line, to an error.
    pub fn located(&self, error: Error) -> Error {
        let at = self.text.position();
        match self.binary {
            Some(_) => error.byte(at as u64),
            None => error.line(line_of(self.text.bytes(), at)),
        }
    }
}
