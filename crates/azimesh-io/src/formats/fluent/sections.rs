//! Files of sections in parentheses, text and binary, as [`Content`].

use super::content::{CellZone, Content, FaceZone, INACTIVE, Named, check_cover};
use super::numbers::{self, Body};
use crate::formats::Notes;
use crate::formats::names::decoded;
use crate::formats::number::DType;
use crate::formats::tokens::{line_of, shown};
use azimesh_core::error::{Error, Position, Result};
use std::borrow::Cow;
use std::ops::Range;

/// Closes a binary section, with its index.
const END: &[u8] = b"End of Binary Section";
/// Most numbers of a header.
const HEADER: usize = 64;

/// First number of a little-endian machine.
const LITTLE_ENDIAN: u64 = 0x60;

/// Reads a file.
pub(super) fn read(bytes: &[u8], notes: &mut Notes) -> Result<Content> {
    let mut reader = Reader {
        scanner: Scanner::new(bytes),
        content: Content::default(),
        is_big_endian: false,
        nodes: Vec::new(),
        starts: Default::default(),
        said: [None; 3],
    };
    while let Some(index) = reader.scanner.section()? {
        reader.section(index, notes)?;
    }
    reader.finish()
}

struct Reader<'a> {
    scanner: Scanner<'a>,
    content: Content,
    is_big_endian: bool,
    /// Nodes of each section, from 0, and their coordinates.
    nodes: Vec<(usize, Vec<[f64; 3]>)>,
    /// Offsets of the sections of nodes and of cells.
    starts: [Vec<usize>; 2],
    /// Declared numbers of nodes, cells and faces, and the offsets of these declarations.
    said: [Option<(usize, usize)>; 3],
}

/// Indices in [`Reader::said`].
const NODES: usize = 0;
const CELLS: usize = 1;
const FACES: usize = 2;
const ITEMS: [&str; 3] = ["nodes", "cells", "faces"];

impl Reader<'_> {
    fn section(&mut self, index: u32, notes: &mut Notes) -> Result<()> {
        match index {
            2 => self.dimension(),
            4 => self.machine(),
            10 | 2010 | 3010 => self.nodes(index),
            12 | 2012 | 3012 => self.cells(index),
            13 | 2013 | 3013 => self.faces(index),
            18 | 2018 | 3018 => self.shadows(index),
            39 | 45 => zone(&mut self.scanner, &mut self.content, notes),
            58 | 2058 | 3058 | 59 | 2059 | 3059 => self.tree(index),
            _ => self.scanner.pass(index),
        }
    }

    fn dimension(&mut self) -> Result<()> {
        self.content.dimension = match self.scanner.word() {
            b"2" => 2,
            b"3" => 3,
            _ => {
                return Err(self
                    .scanner
                    .error("the dimension of the mesh must be 2 or 3"));
            }
        };
        self.scanner.blanks();
        self.scanner.need(b')', "the end of the section")
    }

    fn machine(&mut self) -> Result<()> {
        let header = self.scanner.header()?;
        self.is_big_endian = header.numbers.first() != Some(&LITTLE_ENDIAN);
        self.scanner.blanks();
        self.scanner.need(b')', "the end of the section")
    }

    /// Reads the header of a section of nodes, cells or faces. `None` for a declaration of their number, which is passed.
    fn part(&mut self, what: usize, index: u32) -> Result<Option<Part>> {
        let header = self.scanner.header()?;
        let wrong = |message: &str| Err(self.scanner.error_at(header.at, message));
        let [zone, first, last, rest @ ..] = &header.numbers[..] else {
            return wrong(
                "a section of nodes, cells or faces begins with a zone, its first and its last item",
            );
        };
        let number = |i: usize| rest.get(i).copied();
        let end = usize::try_from(*last)
            .ok()
            .filter(|last| *last <= u32::MAX as usize);
        let start = usize::try_from(*first)
            .ok()
            .and_then(|first| first.checked_sub(1));
        if let (0, Some(end)) = (*zone, end) {
            self.said[what] = Some((end, header.at));
            if what == NODES && self.content.dimension == 0 {
                let dimension = number(1).filter(|d| [2, 3].contains(d));
                self.content.dimension = dimension.map_or(0, |d| d as u8);
            }
            // A declaration has no body, or an empty one.
            if index < 2000 {
                self.scanner.numbers()?;
            } else if self.scanner.binary_body()? {
                self.scanner.close_binary()?;
            }
            return Ok(None);
        }
        let (Some(start), Some(end)) = (start, end) else {
            return wrong("the first item is 1, and there are at most 4294967295");
        };
        if end < start {
            return wrong("the last item is before the first one");
        }
        // Tags have numbers of 31 bits.
        let Ok(zone) = i32::try_from(*zone) else {
            return wrong("the number of the zone is too large");
        };
        Ok(Some(Part {
            zone: zone.unsigned_abs(),
            items: start..end,
            kind: number(0).map_or(1, |kind| u32::try_from(kind).unwrap_or(u32::MAX)),
            size: number(1).map_or(0, |size| usize::try_from(size).unwrap_or(usize::MAX)),
            at: header.at,
        }))
    }

    /// The body of a section of text, of records of so many words; `None` if there is none. If the file ends in it, the
    /// error has the number of missing items.
    fn text(&mut self, part: &Part, what: usize, words: usize) -> Result<Option<Range<usize>>> {
        let found = self.scanner.numbers();
        found.map_err(|error| {
            if !self.scanner.is_cut_off() {
                return error;
            }
            let message = format!(
                "the file ends within the section of {} that begins in line {}: expected {}, found {}",
                ITEMS[what],
                line_of(self.scanner.bytes, part.at),
                part.items.len(),
                numbers::n_words(self.scanner.rest()) / words
            );
            self.scanner.error_at(self.scanner.bytes.len(), message)
        })
    }

    /// The body of a section of nodes or faces, which must have one.
    fn body(&mut self, part: &Part, what: usize, index: u32, words: usize) -> Result<Body> {
        let body = if index < 2000 {
            self.text(part, what, words)?.map(Body::Text)
        } else {
            let width = if index >= 3000 { 8 } else { 4 };
            let reals = DType::real(width, self.is_big_endian);
            self.scanner.binary_body()?.then_some(Body::Binary(reals))
        };
        body.ok_or_else(|| {
            let message = format!(
                "the section of {} has none: numbers in parentheses must follow",
                ITEMS[what]
            );
            self.scanner.error_at(part.at, message)
        })
    }

    fn nodes(&mut self, index: u32) -> Result<()> {
        let Some(part) = self.part(NODES, index)? else {
            return Ok(());
        };
        let dimension = match (part.size, self.content.dimension) {
            (n @ (2 | 3), _) => n,
            (_, 0) => 3,
            (_, n) => usize::from(n),
        };
        let body = self.body(&part, NODES, index, dimension)?;
        let points = numbers::points(&mut self.scanner, &body, part.items.len(), dimension)?;
        if self.content.dimension == 0 {
            self.content.dimension = dimension as u8;
        }
        self.starts[NODES].push(part.at);
        self.nodes.push((part.items.start, points));
        Ok(())
    }

    fn cells(&mut self, index: u32) -> Result<()> {
        let Some(part) = self.part(CELLS, index)? else {
            return Ok(());
        };
        // Kinds of cells follow, which their faces imply.
        if index < 2000 {
            self.text(&part, CELLS, 1)?;
        } else {
            self.scanner.pass(index)?;
        }
        self.starts[CELLS].push(part.at);
        self.content.n_cells = self.content.n_cells.max(part.items.end);
        self.content.cells.push(CellZone {
            zone: part.zone,
            cells: part.items,
            is_active: part.kind != INACTIVE,
        });
        Ok(())
    }

    fn faces(&mut self, index: u32) -> Result<()> {
        let Some(part) = self.part(FACES, index)? else {
            return Ok(());
        };
        let place = self.scanner.place(part.at);
        let (size, words) = match part.size {
            0 | 5 => (0, 6),
            n @ 2..=4 => (n, n + 2),
            n => {
                return Err(self.scanner.error_at(part.at, format!(
                    "the type of the faces is {n}; it is 2 to 4 for faces of so many nodes, 0 or 5 for faces of several sizes"
                )));
            }
        };
        let body = self.body(&part, FACES, index, words)?;
        let list = numbers::faces(&mut self.scanner, &body, part.items.len(), size)?;
        self.content.faces.push(FaceZone {
            zone: part.zone,
            first: part.items.start,
            kind: part.kind,
            place,
            body: match body {
                Body::Text(body) => Some(body),
                Body::Binary(_) => None,
            },
            list,
        });
        Ok(())
    }

    /// `(18 (first last zone shadow)(pairs of faces))`: the pairs are not needed.
    fn shadows(&mut self, index: u32) -> Result<()> {
        let header = self.scanner.header()?;
        let zone = |i: usize| u32::try_from(*header.numbers.get(i)?).ok();
        let (Some(zone), Some(shadow)) = (zone(2), zone(3)) else {
            let message = "a section of periodic faces names two zones";
            return Err(self.scanner.error_at(header.at, message));
        };
        self.content.shadows.push([zone, shadow]);
        self.rest_of(index)
    }

    /// `(59 (first last ...)(kids))`: faces, or with 58 cells, that others replace.
    fn tree(&mut self, index: u32) -> Result<()> {
        let header = self.scanner.header()?;
        let wrong = |message: &str| Err(self.scanner.error_at(header.at, message));
        let [first, last, ..] = header.numbers[..] else {
            return wrong("a tree begins with its first and its last item");
        };
        if first == 0 || last > u64::from(u32::MAX) || first > last {
            return wrong("a tree begins with its first and its last item, from 1");
        }
        let range = first as usize - 1..last as usize;
        if index % 1000 == 58 {
            self.content.refined_cells.push(range);
        } else {
            self.content.refined_faces.push(range);
        }
        self.rest_of(index)
    }

    /// Passes over the numbers of a section whose header was read.
    fn rest_of(&mut self, index: u32) -> Result<()> {
        if index >= 2000 {
            return self.scanner.pass(index);
        }
        self.scanner.numbers().map(|_| ())
    }

    fn finish(mut self) -> Result<Content> {
        let content = &mut self.content;
        if content.dimension == 0 {
            content.dimension = 3;
        }
        let nodes = self
            .nodes
            .iter()
            .map(|(first, points)| *first..first + points.len());
        let n_nodes = nodes.clone().map(|range| range.end).max().unwrap_or(0);
        let cells = content.cells.iter().map(|zone| zone.cells.clone());
        let wrong = |at: usize, message: String| self.scanner.error_at(at, message);
        check_cover(nodes, n_nodes, "node")
            .map_err(|(part, message)| wrong(self.starts[NODES][part], message))?;
        check_cover(cells, content.n_cells, "cell")
            .map_err(|(part, message)| wrong(self.starts[CELLS][part], message))?;
        let n_faces: usize = content.faces.iter().map(|zone| zone.list.len()).sum();
        let found = [n_nodes, content.n_cells, n_faces];
        for ((said, found), what) in self.said.iter().zip(found).zip(ITEMS) {
            if let Some((said, at)) = said.filter(|said| said.0 > found) {
                return Err(wrong(
                    at,
                    format!(
                        "the file says that it has {said} {what}, but its sections have {found}"
                    ),
                ));
            }
        }
        self.nodes.sort_by_key(|(first, _)| *first);
        let mut nodes = self.nodes.into_iter();
        let mut points = nodes.next().map_or(Vec::new(), |(_, points)| points);
        points.reserve_exact(n_nodes - points.len());
        nodes.for_each(|(_, part)| points.extend(part));
        content.points = points;
        Ok(self.content)
    }
}

/// The header of a section of nodes, cells or faces.
struct Part {
    zone: u32,
    items: Range<usize>,
    kind: u32,
    /// Coordinates of a node, or the type of the items.
    size: usize,
    at: usize,
}

/// Reads `(39 (zone type name domain)(conditions))` after its index.
fn zone(scanner: &mut Scanner, content: &mut Content, notes: &mut Notes) -> Result<()> {
    scanner.blanks();
    scanner.need(b'(', "the number, type and name of a zone in parentheses")?;
    let at = scanner.at;
    let number = std::str::from_utf8(scanner.word()).ok();
    let Some(number) = number.and_then(|number| number.parse().ok()) else {
        return Err(scanner.error_at(at, "the number of a zone is a decimal number"));
    };
    let [kind, name] = [scanner.word(), scanner.word()].map(|word| {
        let text = decoded(word);
        if let Cow::Owned(text) = &text {
            notes.latin1(text);
        }
        text.into_owned()
    });
    content.names.entry(number).or_insert(Named { kind, name });
    // The domain, and the settings of the zone.
    scanner.pass(39)?;
    scanner.pass(39)
}

/// Reads types and names of zones in a text of sections, such as the settings of HDF5 files.
pub(super) fn zones(text: &[u8], content: &mut Content, notes: &mut Notes) -> Result<()> {
    let mut scanner = Scanner::new(text);
    while let Some(index) = scanner.section()? {
        match index {
            39 | 45 => zone(&mut scanner, content, notes)?,
            _ => scanner.pass(index)?,
        }
    }
    Ok(())
}

/// A place in a file, moving forward by sections: `(index (header) (body))`, binary if the index is 2000 or more.
pub(super) struct Scanner<'a> {
    /// The whole file.
    pub bytes: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
    /// The first binary section: bytes after it have no line.
    first_binary: usize,
}

/// The numbers of a header, from the byte `at` on.
#[derive(Debug)]
struct Header {
    at: usize,
    numbers: Vec<u64>,
}

impl<'a> Scanner<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            first_binary: usize::MAX,
        }
    }

    /// The index of the next section; `None` at the end of the file. Passes sections with a word as index, settings of
    /// Fluent Meshing.
    fn section(&mut self) -> Result<Option<u32>> {
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

    fn index(&mut self) -> Result<u32> {
        let n = self.n_while(u8::is_ascii_digit);
        let text = std::str::from_utf8(&self.rest()[..n]).ok();
        let Some(number) = text.and_then(|text| text.parse().ok()) else {
            return Err(self.expected("the index of a section"));
        };
        self.at += n;
        if number >= 2000 {
            self.first_binary = self.first_binary.min(self.at);
        }
        Ok(number)
    }

    /// The next `(number ...)`, of hexadecimal numbers.
    fn header(&mut self) -> Result<Header> {
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
            let n = self.n_while(u8::is_ascii_hexdigit);
            let text = std::str::from_utf8(&self.rest()[..n]).unwrap_or("");
            match u64::from_str_radix(text, 16) {
                Ok(number) if numbers.len() < HEADER => numbers.push(number),
                _ => return Err(self.expected("a hexadecimal number")),
            }
            self.at += n;
        }
    }

    /// Bytes between the parentheses of a body of numbers; `None` if the section ends instead. Passes the section.
    fn numbers(&mut self) -> Result<Option<Range<usize>>> {
        self.blanks();
        if self.peek() == Some(b')') {
            self.at += 1;
            return Ok(None);
        }
        self.need(b'(', "the numbers of the section in parentheses")?;
        let start = self.at;
        let Some(n) = memchr::memchr2(b')', b'(', self.rest()) else {
            let message = "the file ends within the numbers of a section";
            return Err(self.error_at(self.bytes.len(), message));
        };
        self.at += n;
        self.need(b')', "the end of the numbers")?;
        self.blanks();
        self.need(b')', "the end of the section")?;
        Ok(Some(start..start + n))
    }

    /// Moves to the first byte of a binary body. Returns `false` without a body and passes the section.
    fn binary_body(&mut self) -> Result<bool> {
        self.blanks();
        if self.peek() == Some(b'(') {
            self.at += 1;
            return Ok(true);
        }
        self.end_of_binary()?;
        Ok(false)
    }

    /// Passes over the end of a binary section, after its numbers.
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
            self.at += self.n_while(u8::is_ascii_digit);
            self.blanks();
        }
        self.need(b')', "the end of the section")
    }

    /// Passes over a section whose index was read.
    fn pass(&mut self, index: u32) -> Result<()> {
        if index >= 2000 {
            let Some(n) = memchr::memmem::find(self.rest(), END) else {
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
            let is_mark = |b: &u8| matches!(b, b'(' | b')' | b'"' | b'\\');
            let found = if is_free {
                memchr::memchr2(b'(', b')', self.rest())
            } else {
                self.rest().iter().position(is_mark)
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
    fn word(&mut self) -> &'a [u8] {
        self.blanks();
        let start = self.at;
        if self.peek() == Some(b'"') {
            self.at += 1;
            self.string();
            let end = self.at.saturating_sub(1).max(start + 1);
            return &self.bytes[start + 1..end];
        }
        let n = self.n_while(|b| !b.is_ascii_whitespace() && !matches!(b, b'(' | b')'));
        self.at += n;
        &self.bytes[start..start + n]
    }

    fn blanks(&mut self) {
        // Some writers close a file with zeros.
        self.at += self.n_while(|b| b.is_ascii_whitespace() || *b == 0);
    }

    fn n_while(&self, is_part: impl Fn(&u8) -> bool) -> usize {
        self.rest().iter().take_while(|b| is_part(b)).count()
    }

    fn need(&mut self, byte: u8, what: &str) -> Result<()> {
        if self.peek() != Some(byte) {
            return Err(self.expected(what));
        }
        self.at += 1;
        Ok(())
    }

    fn peek(&self) -> Option<u8> {
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

    /// True if the file ends within the numbers that begin here.
    fn is_cut_off(&self) -> bool {
        memchr::memchr2(b')', b'(', self.rest()).is_none()
    }

    /// An error at the next byte.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.error_at(self.at, message)
    }

    fn error_at(&self, at: usize, message: impl Into<String>) -> Error {
        Error::input(message).at(Some(self.place(at)))
    }

    /// The line of a byte, or the byte itself after binary data.
    fn place(&self, at: usize) -> Position {
        if at < self.first_binary {
            Position::Line(line_of(self.bytes, at))
        } else {
            Position::Byte(at as u64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

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
        assert_says(&error, "line 2: section cad/options has no end");
        let mut scanner = Scanner::new(b"(+ 3)");
        let error = scanner.section().expect_err("no index").to_string();
        assert_says(&error, "expected the index of a section");
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
        assert_says(&error, "byte 12: the file ends within");
    }
}
