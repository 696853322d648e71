//! Text for the formats that are lines of numbers: words, numbers, and blocks of lines.
//!
//! Positions are byte offsets; lines are counted only for errors. Large blocks of lines
//! are cut at line ends and parsed on all threads, results and errors in the order of the file.

use super::dialect::{COMMENTS, fortran_real};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{map_items, try_map};
use std::ops::Range;

/// Lines that one task parses at a time.
const CHUNK_LINES: usize = 8192;

/// One-based line of the byte at `offset`.
pub fn line_of(bytes: &[u8], offset: usize) -> u64 {
    let before = &bytes[..offset.min(bytes.len())];
    memchr::memchr_iter(b'\n', before).count() as u64 + 1
}

/// A place in a text, moving forward by words, lines or blocks of lines.
#[derive(Debug, Clone)]
pub struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    comment: Option<u8>,
}

impl<'a> Lexer<'a> {
    /// From the start of `bytes`; with `comment` a line whose first visible character is that, `%`, `#` or `!` is passed
    /// over.
    pub fn new(bytes: &'a [u8], comment: Option<u8>) -> Self {
        Self {
            bytes,
            at: 0,
            comment,
        }
    }

    /// Offset of the next byte.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Goes on from this offset.
    pub fn set_position(&mut self, at: usize) {
        self.at = at.min(self.bytes.len());
    }

    /// The whole text.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The bytes from the position on.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The next line that is neither blank nor a comment; `None` at the end.
    pub fn line(&mut self) -> Option<Fields<'a>> {
        loop {
            let start = self.at;
            if start == self.bytes.len() {
                return None;
            }
            if self.pass_line() {
                let line = Fields::new(self.bytes, start..self.at);
                return Some(line);
            }
        }
    }

    /// The next line without moving on.
    pub fn peek_line(&self) -> Option<Fields<'a>> {
        self.clone().line()
    }

    /// The next word, on whatever line; `None` at the end.
    pub fn word(&mut self) -> Option<Fields<'a>> {
        let skipped = self.rest().iter().take_while(|b| b.is_ascii_whitespace());
        let start = self.at + skipped.count();
        let word = self.bytes[start..].iter();
        let end = start + word.take_while(|b| !b.is_ascii_whitespace()).count();
        self.at = end;
        (start < end).then(|| Fields::new(self.bytes, start..end))
    }

    /// The next `n` lines that are neither blank nor comments. Nothing is allocated for lines that
    /// are not there.
    pub fn take_lines(&mut self, n: usize, what: &str) -> Result<Lines<'a>> {
        let mut lines = Lines {
            bytes: self.bytes,
            comment: self.comment,
            n_lines: 0,
            chunks: Vec::new(),
        };
        while lines.n_lines < n {
            let start = self.at;
            let mut taken = 0;
            while taken < CHUNK_LINES.min(n - lines.n_lines) {
                if self.at == self.bytes.len() {
                    let found = lines.n_lines + taken;
                    return Err(self.error(format!(
                        "the file ends after {found} of {n} lines of {what}"
                    )));
                }
                taken += usize::from(self.pass_line());
            }
            lines.chunks.push((start..self.at, taken));
            lines.n_lines += taken;
        }
        Ok(lines)
    }

    /// Moves past one line; whether it holds anything.
    fn pass_line(&mut self) -> bool {
        let rest = self.rest();
        let length = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        let first = rest[..length].iter().find(|b| !b.is_ascii_whitespace());
        let begins = |byte: &u8| {
            self.comment.is_some() && (COMMENTS.contains(byte) || self.comment == Some(*byte))
        };
        first.is_some_and(|byte| !begins(byte))
    }

    /// An error at the line of the next byte.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::input(message).line(line_of(self.bytes, self.at))
    }
}

/// The words of one line.
#[derive(Debug, Clone)]
pub struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Fields<'a> {
    fn new(bytes: &'a [u8], range: Range<usize>) -> Self {
        Self {
            bytes,
            at: range.start,
            end: range.end,
        }
    }

    /// The words between two places, on whatever lines.
    pub fn between(bytes: &'a [u8], range: Range<usize>) -> Self {
        Self::new(bytes, range)
    }

    /// The rest of the line, without white space around it.
    pub fn rest(&self) -> &'a [u8] {
        self.bytes[self.at..self.end].trim_ascii()
    }

    fn skip_blanks(&mut self) {
        while self.at < self.end && self.bytes[self.at].is_ascii_whitespace() {
            self.at += 1;
        }
    }

    /// Whether nothing is left but a comment.
    pub fn is_done(&mut self) -> bool {
        self.skip_blanks();
        self.at == self.end || COMMENTS.contains(&self.bytes[self.at])
    }

    /// The next word; `None` at the end of the line.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..self.end];
        let length = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        self.at += length;
        (length > 0).then(|| &rest[..length])
    }

    /// The next word as an integer; `what` names it in an error.
    pub fn integer(&mut self, what: &str) -> Result<i64> {
        self.skip_blanks();
        let start = self.at;
        let negative = self.bytes[start..self.end].first() == Some(&b'-');
        let signed = negative || self.bytes[start..self.end].first() == Some(&b'+');
        self.at += usize::from(signed);
        let digits = self.at;
        let mut value = Some(0i64);
        while self.at < self.end && self.bytes[self.at].is_ascii_digit() {
            let digit = i64::from(self.bytes[self.at] - b'0');
            value = value.and_then(|v| v.checked_mul(10)?.checked_add(digit));
            self.at += 1;
        }
        match value {
            Some(value) if self.at > digits && self.at_word_end() => {
                Ok(if negative { -value } else { value })
            }
            _ => Err(self.wrong(start, "an integer", what)),
        }
    }

    /// The next word as an integer of a narrower type.
    pub fn narrow<T: TryFrom<i64>>(&mut self, what: &str) -> Result<T> {
        self.skip_blanks();
        let start = self.at;
        let value = self.integer(what)?;
        T::try_from(value).map_err(|_| {
            Error::input(format!("{what} is {value}, which is out of range"))
                .line(line_of(self.bytes, start))
        })
    }

    /// The next word as a finite number; its exponent may be Fortran's, as in `1.0D-3`.
    pub fn real(&mut self, what: &str) -> Result<f64> {
        self.skip_blanks();
        let start = self.at;
        match fast_float2::parse_partial::<f64, _>(&self.bytes[start..self.end]) {
            Ok((value, length)) if value.is_finite() => {
                self.at += length;
                if self.at_word_end() {
                    return Ok(value);
                }
                let Some((value, length)) = fortran_real(&self.bytes[start..self.end]) else {
                    return Err(self.wrong(start, "a number", what));
                };
                self.at = start + length;
                Ok(value)
            }
            _ => Err(self.wrong(start, "a number", what)),
        }
    }

    fn at_word_end(&self) -> bool {
        self.at == self.end || self.bytes[self.at].is_ascii_whitespace()
    }

    #[cold]
    fn wrong(&mut self, start: usize, expected: &str, what: &str) -> Error {
        self.at = start;
        let line = line_of(self.bytes, start.min(self.end.saturating_sub(1)));
        let found = match self.word() {
            Some(word) => shown(word),
            None => "the end of the line".into(),
        };
        Error::input(format!("expected {expected} as {what}, found {found}")).line(line)
    }

    /// An error at this line.
    #[cold]
    pub fn error(&self, message: impl Into<String>) -> Error {
        let inside = self.at.min(self.end.saturating_sub(1));
        Error::input(message).line(line_of(self.bytes, inside))
    }

    /// An error unless the line is done.
    pub fn end(&mut self, what: &str) -> Result<()> {
        if self.is_done() {
            return Ok(());
        }
        let found = shown(self.rest());
        Err(self.error(format!("{what} is followed by {found} on the same line")))
    }
}

/// A piece of a file as it is shown in messages.
pub fn shown(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(40)];
    let more = if head.len() < bytes.len() { "..." } else { "" };
    format!("\"{}{more}\"", head.escape_ascii())
}

/// A block of lines, ready to be parsed on all threads.
#[derive(Debug)]
pub struct Lines<'a> {
    bytes: &'a [u8],
    comment: Option<u8>,
    n_lines: usize,
    /// Byte range and number of lines of each task.
    chunks: Vec<(Range<usize>, usize)>,
}

impl<'a> Lines<'a> {
    /// Number of lines.
    pub fn len(&self) -> usize {
        self.n_lines
    }

    /// Parses each line into its `per_line` entries of `out`; the first wrong line is the error.
    ///
    /// # Panics
    /// When `out` has not `per_line` entries for every line.
    pub fn parse_into<T: Send>(
        &self,
        out: &mut [T],
        per_line: usize,
        parse: impl Fn(&mut Fields<'a>, &mut [T]) -> Result<()> + Sync,
    ) -> Result<()> {
        self.parse_each(out, per_line, |line, _, entry| parse(line, entry))
    }

    /// As [`Lines::parse_into`], with the number of the line among these, from 0.
    ///
    /// # Panics
    /// When `out` has not `per_line` entries for every line.
    pub fn parse_each<T: Send>(
        &self,
        out: &mut [T],
        per_line: usize,
        parse: impl Fn(&mut Fields<'a>, usize, &mut [T]) -> Result<()> + Sync,
    ) -> Result<()> {
        assert_eq!(out.len(), self.n_lines * per_line);
        let mut tasks = Vec::with_capacity(self.chunks.len());
        let mut rest = out;
        let mut first = 0;
        for (range, n) in &self.chunks {
            let (part, tail) = rest.split_at_mut(n * per_line);
            tasks.push((range.clone(), first, part));
            rest = tail;
            first += n;
        }
        let results = map_items(tasks, &|_, (range, first, part)| {
            let mut entries = (first..).zip(part.chunks_exact_mut(per_line));
            self.for_each_in(range, |line| {
                let (i, entry) = entries.next().expect("one entry for each line");
                parse(line, i, entry)
            })
        });
        results.into_iter().collect()
    }

    /// Parses the lines of each task into one `T`; these in the order of the file.
    pub fn parse<T: Default + Send>(
        &self,
        parse: impl Fn(&mut Fields<'a>, &mut T) -> Result<()> + Sync,
    ) -> Result<Vec<T>> {
        try_map(self.chunks.len(), &|i| {
            let mut part = T::default();
            self.for_each_in(self.chunks[i].0.clone(), |line| parse(line, &mut part))?;
            Ok(part)
        })
    }

    fn for_each_in(
        &self,
        range: Range<usize>,
        mut act: impl FnMut(&mut Fields<'a>) -> Result<()>,
    ) -> Result<()> {
        let mut lexer = Lexer {
            bytes: &self.bytes[..range.end],
            at: range.start,
            comment: self.comment,
        };
        while let Some(mut line) = lexer.line() {
            act(&mut line)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_and_wrong_ones_named_with_their_line() {
        let mut lexer = Lexer::new(b"% note\n\n 12 -3\t1.5e-3\r\nx 1.0y\n", Some(b'%'));
        let mut line = lexer.line().expect("a line");
        assert_eq!(line.integer("a").expect("12"), 12);
        assert_eq!(line.integer("b").expect("-3"), -3);
        assert_eq!(line.real("c").expect("1.5e-3"), 1.5e-3);
        assert!(line.is_done());
        let error = line.integer("d").expect_err("nothing is left");
        assert_eq!(
            error.to_string(),
            "line 3: expected an integer as d, found the end of the line"
        );
        let mut line = lexer.line().expect("a line");
        assert_eq!(line.word(), Some(&b"x"[..]));
        let error = line.real("y").expect_err("1.0y is no number");
        assert_eq!(
            error.to_string(),
            "line 4: expected a number as y, found \"1.0y\""
        );
        assert!(lexer.line().is_none());
    }

    #[test]
    fn integers_that_do_not_fit_are_refused() {
        let mut line = Lexer::new(b"9223372036854775808", None).line().expect("a");
        assert!(line.integer("n").is_err());
        let mut line = Lexer::new(b"-1", None).line().expect("a");
        assert!(line.narrow::<u32>("n").is_err());
    }

    #[test]
    fn a_large_block_is_parsed_in_order_and_its_first_error_is_reported() {
        let mut text: String = (0..20_000).map(|i| format!("{i}\n")).collect();
        let lines = Lexer::new(text.as_bytes(), None)
            .take_lines(20_000, "numbers")
            .expect("all are there");
        let mut out = vec![0i64; 20_000];
        lines
            .parse_into(&mut out, 1, |line, out| {
                out[0] = line.integer("n")?;
                line.end("n")
            })
            .expect("all are numbers");
        assert!(out.iter().enumerate().all(|(i, n)| *n == i as i64));
        text = text.replace("\n17000\n", "\nseventeen\n");
        text = text.replace("\n19000\n", "\nnineteen\n");
        let lines = Lexer::new(text.as_bytes(), None)
            .take_lines(20_000, "numbers")
            .expect("all are there");
        let error = lines
            .parse_into(&mut out, 1, |line, out| {
                out[0] = line.integer("n")?;
                Ok(())
            })
            .expect_err("seventeen is none");
        assert!(error.to_string().starts_with("line 17001:"), "{error}");
    }

    #[test]
    fn missing_lines_are_counted() {
        let error = Lexer::new(b"1\n\n2\n", None)
            .take_lines(usize::MAX, "nodes")
            .expect_err("two are there");
        assert!(error.to_string().contains("after 2 of"), "{error}");
    }
}
