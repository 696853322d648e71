//! Text as words, numbers, and blocks of lines.
//!
//! Positions are byte offsets; lines are counted only for errors. Large texts are cut at line ends or between words and
//! parsed on all threads, results and errors in the order of the file.
//!
//! ```text
//! let mut tokens = Tokens::new(bytes);                            // or with_comments(bytes)
//! while let Some(mut line) = tokens.line() {                      // a line is Tokens too
//!     let n: usize = line.narrow("a number of nodes")?;           // word, integer, narrow, real, rest, end
//!     let lines = tokens.take_lines(n, "nodes")?;                 // a block of records
//!     lines.parse_into(&mut points, 1, |line, i, out| ..)?;          // on all threads
//! }
//! let mut count = tokens.next_word();                             // free form: words on whatever lines
//! let words = tokens.words();                                     // counted on all threads, words.len()
//! words.parse_into(&mut reals, "a coordinate", &mut integers, |tokens, first, out| ..)?;
//! Err(line.error("line and message"))
//! ```

use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{map, map_items, try_map};
use std::ops::Range;

/// Lines that one task parses at a time.
const CHUNK_LINES: usize = 8192;
/// Bytes of free-form text that one task parses.
const PIECE: usize = 1 << 20;
/// Characters that begin a comment.
const COMMENTS: &[u8] = b"%#!";

/// One-based line of the byte at `offset`.
pub fn line_of(bytes: &[u8], offset: usize) -> u64 {
    let before = &bytes[..offset.min(bytes.len())];
    memchr::memchr_iter(b'\n', before).count() as u64 + 1
}

/// A part of a text, moving forward by words, lines or blocks of lines.
#[derive(Debug, Clone)]
pub struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
    has_comments: bool,
}

impl<'a> Tokens<'a> {
    /// All of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self::between(bytes, 0..bytes.len())
    }

    /// All of `bytes`, without the lines whose first visible character is `%`, `#` or `!`.
    pub fn with_comments(bytes: &'a [u8]) -> Self {
        Self {
            has_comments: true,
            ..Self::new(bytes)
        }
    }

    /// The part of `bytes` in a range.
    pub fn between(bytes: &'a [u8], range: Range<usize>) -> Self {
        Self {
            bytes,
            at: range.start,
            end: range.end,
            has_comments: false,
        }
    }

    /// Offset of the next byte.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Continues from this offset.
    pub fn set_position(&mut self, at: usize) {
        self.at = at.min(self.end);
    }

    /// The whole text.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The bytes from the position on.
    pub fn left(&self) -> &'a [u8] {
        &self.bytes[self.at..self.end]
    }

    /// The bytes from the position on, without white space around them.
    pub fn rest(&self) -> &'a [u8] {
        self.left().trim_ascii()
    }

    /// The next line that is neither blank nor a comment; `None` at the end.
    pub fn line(&mut self) -> Option<Self> {
        while self.at < self.end {
            let start = self.at;
            if let Some(end) = self.pass_line() {
                return Some(Self::between(self.bytes, start..end));
            }
        }
        None
    }

    /// The next line without moving on.
    pub fn peek_line(&self) -> Option<Self> {
        self.clone().line()
    }

    /// The next `n` lines that are neither blank nor comments. Nothing is allocated for lines that
    /// are not there.
    pub fn take_lines(&mut self, n: usize, what: &str) -> Result<Lines<'a>> {
        let mut lines = Lines {
            bytes: self.bytes,
            has_comments: self.has_comments,
            n_lines: 0,
            chunks: Vec::new(),
        };
        while lines.n_lines < n {
            let start = self.at;
            let mut taken = 0;
            while taken < CHUNK_LINES.min(n - lines.n_lines) {
                if self.at == self.end {
                    let found = lines.n_lines + taken;
                    return Err(self.error(format!(
                        "the file ends after {found} of {n} lines of {what}"
                    )));
                }
                taken += usize::from(self.pass_line().is_some());
            }
            lines.chunks.push((start..self.at, taken));
            lines.n_lines += taken;
        }
        Ok(lines)
    }

    /// Moves past one line; its end, if it holds anything.
    fn pass_line(&mut self) -> Option<usize> {
        let left = self.left();
        let length = memchr::memchr(b'\n', left).unwrap_or(left.len());
        let end = self.at + length;
        self.at = self.end.min(end + 1);
        let first = left[..length].iter().find(|b| !b.is_ascii_whitespace())?;
        (!self.has_comments || !COMMENTS.contains(first)).then_some(end)
    }

    /// All words from the position on, counted on all threads.
    pub fn words(&self) -> Words<'a> {
        let mut pieces = Vec::new();
        let mut start = self.at;
        while start < self.end {
            let wanted = self.end.min(start + PIECE);
            let rest = self.bytes[wanted..self.end].iter();
            let end = wanted + rest.take_while(|byte| !byte.is_ascii_whitespace()).count();
            pieces.push(start..end);
            start = end;
        }
        let sizes = map(pieces.len(), &|i| n_words(&self.bytes[pieces[i].clone()]));
        Words {
            bytes: self.bytes,
            pieces: pieces.into_iter().zip(sizes).collect(),
        }
    }

    fn skip_blanks(&mut self) {
        while self.at < self.end && self.bytes[self.at].is_ascii_whitespace() {
            self.at += 1;
        }
    }

    /// Returns whether nothing is left but a comment.
    pub fn is_done(&mut self) -> bool {
        self.skip_blanks();
        self.at == self.end || COMMENTS.contains(&self.bytes[self.at])
    }

    /// The next word; `None` at the end.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let left = self.left();
        let length = left.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        self.at += length;
        (length > 0).then(|| &left[..length])
    }

    /// The next word, to be parsed; `None` at the end.
    pub fn next_word(&mut self) -> Option<Self> {
        let length = self.word()?.len();
        Some(Self::between(self.bytes, self.at - length..self.at))
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

    /// An error at the line of the next byte.
    #[cold]
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::input(message).line(line_of(self.bytes, self.at))
    }

    /// An error at the end of the text.
    #[cold]
    pub fn error_at_end(&self, message: impl Into<String>) -> Error {
        Error::input(message).line(line_of(self.bytes, self.end))
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

/// A piece of a file as shown in messages.
pub fn shown(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(40)];
    let more = if head.len() < bytes.len() { "..." } else { "" };
    format!("\"{}{more}\"", head.escape_ascii())
}

/// A block of lines, ready to be parsed on all threads.
#[derive(Debug)]
pub struct Lines<'a> {
    bytes: &'a [u8],
    has_comments: bool,
    n_lines: usize,
    /// Byte range and number of lines of each task.
    chunks: Vec<(Range<usize>, usize)>,
}

impl<'a> Lines<'a> {
    /// Number of lines.
    pub fn len(&self) -> usize {
        self.n_lines
    }

    /// Parses each line, whose number among these is passed too, into its `per_line` entries of `out`; the first wrong line
    /// is the error.
    ///
    /// # Panics
    /// When `out` has not `per_line` entries for every line.
    pub fn parse_into<T: Send>(
        &self,
        out: &mut [T],
        per_line: usize,
        parse: impl Fn(&mut Tokens<'a>, usize, &mut [T]) -> Result<()> + Sync,
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
        parse: impl Fn(&mut Tokens<'a>, &mut T) -> Result<()> + Sync,
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
        mut act: impl FnMut(&mut Tokens<'a>) -> Result<()>,
    ) -> Result<()> {
        let mut tokens = Tokens {
            has_comments: self.has_comments,
            ..Tokens::between(self.bytes, range)
        };
        while let Some(mut line) = tokens.line() {
            act(&mut line)?;
        }
        Ok(())
    }
}

/// Words wherever lines end, ready to be parsed on all threads.
#[derive(Debug)]
pub struct Words<'a> {
    bytes: &'a [u8],
    /// Byte range and number of words of each task.
    pieces: Vec<(Range<usize>, usize)>,
}

impl Words<'_> {
    /// Number of words.
    pub fn len(&self) -> usize {
        self.pieces.iter().map(|(_, n)| n).sum()
    }

    /// Parses the first words as `reals`, and the next ones with `parse` as `integers`: its arguments are the words, the
    /// index of the first integer, and the integers. The first wrong word is the error.
    pub fn parse_into<T: Send>(
        &self,
        reals: &mut [f64],
        what: &str,
        integers: &mut [T],
        parse: impl Fn(&mut Tokens, usize, &mut [T]) -> Result<()> + Sync,
    ) -> Result<()> {
        let mut tasks = Vec::with_capacity(self.pieces.len());
        let (mut reals_left, mut integers_left) = (reals, integers);
        let mut first = 0;
        for (piece, n) in &self.pieces {
            let (reals, tail) = reals_left.split_at_mut(reals_left.len().min(*n));
            reals_left = tail;
            let n_integers = integers_left.len().min(n - reals.len());
            let (integers, tail) = integers_left.split_at_mut(n_integers);
            integers_left = tail;
            tasks.push((piece.clone(), reals, first, integers));
            first += n_integers;
        }
        let results = map_items(tasks, &|_, (piece, reals, first, integers)| {
            let mut tokens = Tokens::between(self.bytes, piece);
            for x in reals {
                *x = tokens.real(what)?;
            }
            parse(&mut tokens, first, integers)
        });
        results.into_iter().collect()
    }
}

/// Number of words of a text.
pub fn n_words(bytes: &[u8]) -> usize {
    let is_blank = bytes.iter().map(u8::is_ascii_whitespace);
    let before = std::iter::once(true).chain(is_blank.clone());
    before.zip(is_blank).filter(|&(a, b)| a && !b).count()
}

/// A number whose exponent is Fortran's, as in `1.0D-3`, at the start of a word; with its length.
pub fn fortran_real(text: &[u8]) -> Option<(f64, usize)> {
    let n = text.iter().take_while(|b| !b.is_ascii_whitespace()).count();
    let at = text[..n].iter().position(|b| b"dD".contains(b))?;
    let mut word = text[..n].to_vec();
    word[at] = b'e';
    let value = fast_float2::parse::<f64, _>(&word).ok()?;
    value.is_finite().then_some((value, n))
}

/// The line of the first word that is a number with Fortran's exponent; `None` without one.
pub fn first_fortran_real(bytes: &[u8]) -> Option<u64> {
    let found = memchr::memchr2_iter(b'd', b'D', bytes).find(|&at| {
        let begins = |b: &u8| b.is_ascii_whitespace();
        let start = bytes[..at].iter().rposition(begins).map_or(0, |at| at + 1);
        at > start && fortran_real(&bytes[start..]).is_some()
    });
    found.map(|at| line_of(bytes, at))
}

/// Number of lines that begin with `#` or `!`, and of those that end with a comment behind a blank. A line that begins
/// with `%` is a comment of SU2 and counts nowhere.
pub fn n_comments(bytes: &[u8]) -> (usize, usize) {
    let (mut n_lines, mut n_trailing, mut next) = (0, 0, 0);
    for at in memchr::memchr2_iter(b'#', b'!', bytes) {
        if at < next {
            continue;
        }
        let start = memchr::memrchr(b'\n', &bytes[..at]).map_or(0, |end| end + 1);
        let before = &bytes[start..at];
        match before.trim_ascii() {
            [] => n_lines += 1,
            [b'%', ..] => {}
            _ if before.ends_with(b" ") || before.ends_with(b"\t") => n_trailing += 1,
            _ => continue,
        }
        next = memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |n| at + n);
    }
    (n_lines, n_trailing)
}

/// The text with spaces in place of comments, from `#` or `!` to the end of the line, for formats of numbers alone;
/// `None` where there is none.
pub fn without_comments(bytes: &[u8]) -> Option<Vec<u8>> {
    let first = memchr::memchr2(b'#', b'!', bytes)?;
    let mut text = bytes.to_vec();
    let mut at = first;
    loop {
        let rest = &mut text[at..];
        let n = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        rest[..n].fill(b' ');
        match memchr::memchr2(b'#', b'!', &text[at + n..]) {
            Some(next) => at += n + next,
            None => return Some(text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{Notes, ReadOptions, Source, read};
    use crate::mesh::Mesh;
    use crate::testing::assert_says;
    use std::path::Path;

    #[test]
    fn numbers_are_read_and_wrong_ones_named_with_their_line() {
        let mut lexer = Tokens::with_comments(b"% note\n\n 12 -3\t1.5e-3\r\nx 1.0y\n");
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
        let mut line = Tokens::new(b"9223372036854775808").line().expect("a");
        assert!(line.integer("n").is_err());
        let mut line = Tokens::new(b"-1").line().expect("a");
        assert!(line.narrow::<u32>("n").is_err());
    }

    #[test]
    fn a_large_block_is_parsed_in_order_and_its_first_error_is_reported() {
        let mut text: String = (0..20_000).map(|i| format!("{i}\n")).collect();
        let lines = Tokens::new(text.as_bytes())
            .take_lines(20_000, "numbers")
            .expect("all are there");
        let mut out = vec![0i64; 20_000];
        lines
            .parse_into(&mut out, 1, |line, _, out| {
                out[0] = line.integer("n")?;
                line.end("n")
            })
            .expect("all are numbers");
        assert!(out.iter().enumerate().all(|(i, n)| *n == i as i64));
        text = text.replace("\n17000\n", "\nseventeen\n");
        text = text.replace("\n19000\n", "\nnineteen\n");
        let lines = Tokens::new(text.as_bytes())
            .take_lines(20_000, "numbers")
            .expect("all are there");
        let error = lines
            .parse_into(&mut out, 1, |line, _, out| {
                out[0] = line.integer("n")?;
                Ok(())
            })
            .expect_err("seventeen is none");
        assert!(error.to_string().starts_with("line 17001:"), "{error}");
    }

    #[test]
    fn missing_lines_are_counted() {
        let error = Tokens::new(b"1\n\n2\n")
            .take_lines(usize::MAX, "nodes")
            .expect_err("two are there");
        assert_says(&error, "after 2 of");
    }

    fn load(name: &str, text: String) -> (Mesh, Notes) {
        let source = Source::from_bytes(Path::new(name), text.into_bytes());
        let loaded = read(&source.into(), &ReadOptions::default());
        let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
        (loaded.mesh, loaded.notes)
    }

    fn testdata(name: &str) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("testdata")
            .join(name);
        std::fs::read_to_string(path).expect("the file is there")
    }

    #[test]
    fn su2_files_with_comments_exponents_and_spellings_of_others_are_read_and_told() {
        let plain = "NDIME= 2\nNELEM= 1\n9 0 1 2 3\nNPOIN= 4\n0 0\n1 0\n1 1\n0 1\nNMARK= 1\nMARKER_TAG= wall#1\n\
                     MARKER_ELEMS= 1\n3 0 1\n";
        let odd = "# made by a tool, with a=b\n  ! twice\nNDIME= 2 ! plane\nNELEM= 1\n9 0 1 2 3 # one\nNPOIN= 4\n0.0D0 0\n\
                   1.0d+0 0.0 ! node\n1 1\n0 10.0D-1\nNMARK= 1\nMARKERTAG= wall#1 # wall\nMARKER_ELEMS= 1\n3 0 1\n";
        let (wanted, notes) = load("m.su2", plain.to_owned());
        assert!(notes.is_empty(), "{notes:?}");
        let (mesh, notes) = load("m.su2", odd.to_owned());
        assert_eq!(mesh, wanted);
        assert_eq!(mesh.groups[0].name, "wall#1");
        for text in [
            "MARKERTAG= is read as MARKER_TAG=",
            "numbers with exponents of Fortran, such as that in line 7, are read: D stands for E",
            "2 lines that begin with # or !, which the format does not know as comments, are passed over",
            "what follows # or !, which the format does not know as comments, is passed over in 4 lines",
        ] {
            assert!(notes.says(text), "{text}: {notes:?}");
        }
        let trailing = plain.replacen("1 0\n", "1 0 ! node\n", 1);
        let (mesh, notes) = load("m.su2", trailing);
        assert_eq!(mesh, wanted);
        assert_eq!(notes, ["trailing_comments"]);
    }

    #[test]
    fn ugrid_text_with_comments_and_exponents_of_fortran_is_read_and_told() {
        let plain = testdata("mixed_cells.ugrid");
        let (counts, rest) = plain.split_once('\n').expect("counts come first");
        let lines = rest.lines().map(|line| {
            if line.contains('.') {
                line.split(' ')
                    .map(|x| format!("{x}D0 "))
                    .collect::<String>()
                    + "! a node\n"
            } else {
                format!("{line}\n")
            }
        });
        let odd = format!("# a mesh\n{counts} ! counts\n{}", lines.collect::<String>());
        let (wanted, _) = load("m.ugrid", plain.clone());
        let (mesh, notes) = load("m.ugrid", odd);
        assert_eq!(mesh, wanted);
        for text in [
            "numbers with exponents of Fortran, such as that in line 3, are read: D stands for E",
            "1 line that begins with # or !, which the format does not know as comments, is passed over",
        ] {
            assert!(notes.says(text), "{text}: {notes:?}");
        }
    }

    #[test]
    fn msh_files_without_the_ends_of_sections_are_read_and_told() {
        let plain = testdata("mixed_cells_v22.msh");
        let is_end = |line: &&str| line.starts_with("$End") && *line != "$EndMeshFormat";
        let lines = plain.lines().filter(|line| !is_end(line));
        let odd: String = lines.map(|line| format!("{line}\n")).collect();
        let (wanted, _) = load("m.msh", plain.clone());
        let (mesh, notes) = load("m.msh", odd);
        assert_eq!(mesh, wanted);
        let told = notes
            .iter()
            .map(ToString::to_string)
            .find(|note| note.contains("$Elements"));
        assert!(
            told.is_some_and(|note| note.contains("$Nodes")),
            "{notes:?}"
        );
    }

    #[test]
    fn exponents_of_fortran_are_numbers_and_names_with_a_d_are_not() {
        assert_eq!(fortran_real(b"1.5D-3 7"), Some((1.5e-3, 6)));
        assert_eq!(fortran_real(b"-2d+00"), Some((-2.0, 6)));
        assert_eq!(fortran_real(b"1.0D"), None);
        assert_eq!(fortran_real(b"NDIME="), None);
        assert_eq!(
            first_fortran_real(b"NDIME= 2\nside3d 3D\n1 2.0D0\n"),
            Some(3)
        );
        assert_eq!(first_fortran_real(b"NDIME= 2\n3 4d\n"), None);
    }

    #[test]
    fn comments_are_counted_and_blanked_without_moving_what_is_behind() {
        let text = b"# a\n1 2 ! counts\n \t!b\n3#\n";
        assert_eq!(n_comments(text), (2, 1));
        assert_eq!(n_comments(b"% a # b\nname#1\n1 % of # 2 ! 3\n"), (0, 1));
        let blanked = without_comments(text).expect("there are comments");
        assert_eq!(blanked, b"   \n1 2         \n \t  \n3 \n");
        assert!(without_comments(b"1 2\n").is_none());
    }
}
