//! A line `NAME= value`.

use super::super::lexer::{Fields, Lexer, shown};
use azimesh_core::error::Result;

/// Keywords as some programs spell them, and as they are.
pub(super) const SPELLINGS: [[&str; 2]; 2] =
    [["MARKERTAG", "MARKER_TAG"], ["MARKERELEMS", "MARKER_ELEMS"]];

/// A keyword and what follows its `=`, without a comment behind it.
#[derive(Clone, Copy)]
pub(super) struct Keyword<'a> {
    /// Text before the `=`.
    pub name: &'a [u8],
    /// Text behind it.
    pub value: &'a [u8],
}

impl<'a> Keyword<'a> {
    /// The keyword of a line; `None` for a line of data.
    pub fn of(line: &Fields<'a>) -> Option<Self> {
        let text = line.rest();
        let at = memchr::memchr(b'=', without_comment(text))?;
        let name = text[..at].trim_ascii();
        let meant = SPELLINGS.iter().find(|[odd, _]| odd.as_bytes() == name);
        Some(Self {
            name: meant.map_or(name, |[_, name]| name.as_bytes()),
            value: without_comment(text[at + 1..].trim_ascii()).trim_ascii(),
        })
    }

    /// The name as text.
    pub fn name(&self) -> String {
        self.name.escape_ascii().to_string()
    }

    /// The first integer of the value.
    pub fn integer(&self, line: &Fields) -> Result<i64> {
        self.integers()[0].ok_or_else(|| {
            let found = shown(self.value);
            line.error(format!("{}= needs an integer, found {found}", self.name()))
        })
    }

    /// The first two integers of the value, where they are there.
    pub fn integers(&self) -> [Option<i64>; 2] {
        let mut value = Lexer::new(self.value, None).line();
        let mut next = || value.as_mut().and_then(|value| value.integer("").ok());
        let first = next();
        [first, first.and_then(|_| next())]
    }

    /// The first integer of the value, which counts something.
    pub fn count(&self, line: &Fields) -> Result<usize> {
        let value = self.integer(line)?;
        usize::try_from(value).map_err(|_| {
            line.error(format!(
                "{}= {value}: a count cannot be negative",
                self.name()
            ))
        })
    }
}

/// What stands before a `%`, and before a `#` or `!` with a space before it: names may have these.
fn without_comment(text: &[u8]) -> &[u8] {
    let begins = |&at: &usize| text[at] == b'%' || (at > 0 && text[at - 1].is_ascii_whitespace());
    let end = memchr::memchr3_iter(b'%', b'#', b'!', text).find(begins);
    &text[..end.unwrap_or(text.len())]
}
