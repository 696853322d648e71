//! Sections of text and binary sections, one after another, as [`Content`].

use super::binary::{self, Storage};
use super::content::{CellZone, Content, FaceZone, Named, check_cover};
use super::kinds::INACTIVE;
use super::scan::{Header, Scanner};
use super::text;
use crate::formats::Notes;
use crate::formats::lexer::line_of;
use crate::formats::names::decoded;
use azimesh_core::error::{Error, Result};
use std::borrow::Cow;
use std::ops::Range;

/// First number of a machine whose first byte of a number is its smallest one.
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
    /// Where the sections of nodes and of cells begin.
    starts: [Vec<usize>; 2],
    /// Numbers of nodes, cells and faces that the file says it has, and where.
    said: [Option<(usize, usize)>; 3],
}

/// What is counted in [`Reader::said`].
const NODES: usize = 0;
const CELLS: usize = 1;
const FACES: usize = 2;

impl Reader<'_> {
    fn section(&mut self, index: u32, notes: &mut Notes) -> Result<()> {
        let storage = Storage {
            is_big_endian: self.is_big_endian,
            is_double: index >= 3000,
        };
        let storage = (index >= 2000).then_some(storage);
        match index {
            2 => self.dimension(),
            4 => self.machine(),
            10 | 2010 | 3010 => self.nodes(storage),
            12 | 2012 | 3012 => self.cells(index),
            13 | 2013 | 3013 => self.faces(storage),
            18 | 2018 | 3018 => self.shadows(index),
            39 | 45 => self.zone(notes),
            58 | 2058 | 3058 | 59 | 2059 | 3059 => self.tree(index),
            _ => self.scanner.pass(index),
        }
    }

    fn dimension(&mut self) -> Result<()> {
        let word = self.scanner.word();
        self.content.dimension = match word {
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

    /// The header of a section of nodes, cells or faces, or of a declaration of how many there are, which is `None` here.
    fn part(&mut self, what: usize) -> Result<Option<Part>> {
        let header = self.scanner.header()?;
        let [zone, first, last, rest @ ..] = &header.numbers[..] else {
            let message = "a section of nodes, cells or faces begins with a zone, its first and its last item";
            return Err(self.wrong(&header, message));
        };
        let kind = rest.first().copied().unwrap_or(1);
        let size = rest.get(1).copied().unwrap_or(0);
        let range = usize::try_from(*last)
            .ok()
            .filter(|last| *last <= u32::MAX as usize);
        let start = usize::try_from(*first)
            .ok()
            .and_then(|first| first.checked_sub(1));
        if let (0, Some(end)) = (*zone, range) {
            return self.declared(what, (end, header.at), rest);
        }
        let (Some(start), Some(end)) = (start, range) else {
            let message = "the first item is 1, and there are at most 4294967295";
            return Err(self.wrong(&header, message));
        };
        if end < start {
            return Err(self.wrong(&header, "the last item is before the first one"));
        }
        Ok(Some(Part {
            zone: zone_number(*zone)
                .ok_or_else(|| self.wrong(&header, "the number of the zone is too large"))?,
            items: start..end,
            kind: u32::try_from(kind).unwrap_or(u32::MAX),
            size: usize::try_from(size).unwrap_or(usize::MAX),
            at: header.at,
        }))
    }

    fn declared(&mut self, what: usize, n: (usize, usize), rest: &[u64]) -> Result<Option<Part>> {
        self.said[what] = Some(n);
        if what == NODES && self.content.dimension == 0 {
            self.content.dimension = rest
                .get(1)
                .filter(|d| [2, 3].contains(*d))
                .map_or(0, |d| *d as u8);
        }
        Ok(None)
    }

    fn wrong(&self, header: &Header, message: &str) -> Error {
        self.scanner.place(header.at).error(message)
    }

    /// The end of a declaration, which has no body, or an empty one.
    fn end_of_declaration(&mut self, is_binary: bool) -> Result<()> {
        if is_binary {
            return match self.scanner.binary_body()? {
                true => self.scanner.close_binary(),
                false => Ok(()),
            };
        }
        self.scanner.numbers().map(|_| ())
    }

    fn nodes(&mut self, storage: Option<Storage>) -> Result<()> {
        let Some(part) = self.part(NODES)? else {
            return self.end_of_declaration(storage.is_some());
        };
        let dimension = match (part.size, self.content.dimension) {
            (n @ (2 | 3), _) => n,
            (_, 0) => 3,
            (_, n) => usize::from(n),
        };
        let n = part.items.len();
        let points = match storage {
            Some(storage) => {
                if !self.scanner.binary_body()? {
                    return Err(self.without_body(&part, "nodes"));
                }
                let points = binary::points(&mut self.scanner, n, dimension, storage)?;
                self.scanner.close_binary()?;
                points
            }
            None => {
                let Some(body) = self.body(&part, "nodes", |words| words / dimension)? else {
                    return Err(self.without_body(&part, "nodes"));
                };
                text::points(self.scanner.bytes, body, n, dimension)?
            }
        };
        if self.content.dimension == 0 {
            self.content.dimension = dimension as u8;
        }
        self.starts[NODES].push(part.at);
        self.nodes.push((part.items.start, points));
        Ok(())
    }

    /// The body of a section of text. Where the file ends within it, the error says what is missing.
    fn body(
        &mut self,
        part: &Part,
        what: &str,
        n_of: impl Fn(usize) -> usize,
    ) -> Result<Option<Range<usize>>> {
        let found = self.scanner.numbers();
        found.map_err(|error| {
            if !self.scanner.is_cut_off() {
                return error;
            }
            let found = n_of(text::n_words(self.scanner.rest()));
            let message = format!(
                "the file ends within the section of {what} that begins in line {}: expected {}, found {found}",
                line_of(self.scanner.bytes, part.at),
                part.items.len()
            );
            self.scanner.place(self.scanner.bytes.len()).error(message)
        })
    }

    fn without_body(&self, part: &Part, what: &str) -> Error {
        let message = format!("the section of {what} has none: numbers in parentheses must follow");
        self.scanner.place(part.at).error(message)
    }

    fn cells(&mut self, index: u32) -> Result<()> {
        let Some(part) = self.part(CELLS)? else {
            return self.end_of_declaration(index >= 2000);
        };
        // Kinds of cells follow, which their faces tell too.
        match index >= 2000 {
            true => self.scanner.pass(index)?,
            false => _ = self.body(&part, "cells", |words| words)?,
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

    fn faces(&mut self, storage: Option<Storage>) -> Result<()> {
        let Some(part) = self.part(FACES)? else {
            return self.end_of_declaration(storage.is_some());
        };
        let place = self.scanner.place(part.at);
        let size = match part.size {
            0 | 5 => 0,
            n @ 2..=4 => n,
            n => {
                return Err(place.error(format!(
                    "the type of the faces is {n}; it is 2 to 4 for faces of so many nodes, 0 or 5 for faces of several sizes"
                )));
            }
        };
        let n = part.items.len();
        let mut body_of_text = None;
        let list = match storage {
            Some(storage) => {
                if !self.scanner.binary_body()? {
                    return Err(self.without_body(&part, "faces"));
                }
                let list = binary::faces(&mut self.scanner, n, size, storage)?;
                self.scanner.close_binary()?;
                list
            }
            None => {
                let words = if size == 0 { 6 } else { size + 2 };
                let Some(body) = self.body(&part, "faces", |n| n / words)? else {
                    return Err(self.without_body(&part, "faces"));
                };
                body_of_text = Some(body.clone());
                text::faces(self.scanner.bytes, body, n, size)?
            }
        };
        self.content.faces.push(FaceZone {
            zone: part.zone,
            first: part.items.start,
            kind: part.kind,
            place,
            body: body_of_text,
            list,
        });
        Ok(())
    }

    /// `(18 (first last zone shadow)(pairs of faces))`: the pairs are not needed.
    fn shadows(&mut self, index: u32) -> Result<()> {
        let header = self.scanner.header()?;
        let zone = |i: usize| {
            header
                .numbers
                .get(i)
                .and_then(|zone| u32::try_from(*zone).ok())
        };
        let (Some(zone), Some(shadow)) = (zone(2), zone(3)) else {
            return Err(self.wrong(&header, "a section of periodic faces names two zones"));
        };
        self.content.shadows.push([zone, shadow]);
        self.rest_of(index)
    }

    /// `(59 (first last ...)(kids))`: faces, or cells, that others stand for.
    fn tree(&mut self, index: u32) -> Result<()> {
        let header = self.scanner.header()?;
        let [first, last, ..] = header.numbers[..] else {
            return Err(self.wrong(&header, "a tree begins with its first and its last item"));
        };
        if first == 0 || last > u64::from(u32::MAX) || first > last {
            return Err(self.wrong(
                &header,
                "a tree begins with its first and its last item, from 1",
            ));
        }
        let range = first as usize - 1..last as usize;
        match index % 1000 {
            58 => self.content.refined_cells.push(range),
            _ => self.content.refined_faces.push(range),
        }
        self.rest_of(index)
    }

    /// Passes over the numbers of a section whose header was read.
    fn rest_of(&mut self, index: u32) -> Result<()> {
        match index >= 2000 {
            true => self.scanner.pass(index),
            false => self.scanner.numbers().map(|_| ()),
        }
    }

    /// `(39 (zone type name domain)(conditions))`.
    fn zone(&mut self, notes: &mut Notes) -> Result<()> {
        zone(&mut self.scanner, &mut self.content, notes)
    }

    fn finish(mut self) -> Result<Content> {
        let wrong = |at: usize, message: String| Err(self.scanner.place(at).error(message));
        if self.content.dimension == 0 {
            self.content.dimension = 3;
        }
        let n_nodes = self
            .nodes
            .iter()
            .map(|(first, points)| first + points.len())
            .max();
        let n_nodes = n_nodes.unwrap_or(0);
        let parts = self
            .nodes
            .iter()
            .map(|(first, points)| *first..first + points.len());
        if let Err(uncovered) = check_cover(parts.collect(), n_nodes, "node") {
            return wrong(self.starts[NODES][uncovered.part], uncovered.message);
        }
        let cells = self.content.cells.iter().map(|zone| zone.cells.clone());
        if let Err(uncovered) = check_cover(cells.collect(), self.content.n_cells, "cell") {
            return wrong(self.starts[CELLS][uncovered.part], uncovered.message);
        }
        let n_faces: usize = self.content.faces.iter().map(|zone| zone.list.len()).sum();
        let found = [n_nodes, self.content.n_cells, n_faces];
        for ((said, found), what) in self.said.iter().zip(found).zip(["nodes", "cells", "faces"]) {
            // Faces of which a file has none are in other files.
            if let Some((said, at)) = said.filter(|said| said.0 > found) {
                let message = format!(
                    "the file says that it has {said} {what}, but its sections have {found}"
                );
                return wrong(at, message);
            }
        }
        self.nodes.sort_by_key(|(first, _)| *first);
        let mut nodes = std::mem::take(&mut self.nodes).into_iter();
        let mut points = nodes.next().map_or(Vec::new(), |(_, points)| points);
        points.reserve_exact(n_nodes - points.len());
        nodes.for_each(|(_, part)| points.extend(part));
        self.content.points = points;
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

/// The number of a zone, where tags can have it.
fn zone_number(zone: u64) -> Option<u32> {
    i32::try_from(zone).ok().map(i32::unsigned_abs)
}

/// The type and name of a zone, in a section whose index was read.
fn zone(scanner: &mut Scanner, content: &mut Content, notes: &mut Notes) -> Result<()> {
    scanner.blanks();
    scanner.need(b'(', "the number, type and name of a zone in parentheses")?;
    let at = scanner.at;
    let number = std::str::from_utf8(scanner.word()).ok();
    let Some(number) = number.and_then(|number| number.parse().ok()) else {
        return Err(scanner
            .place(at)
            .error("the number of a zone is a decimal number"));
    };
    let [kind, name] = [scanner.word(), scanner.word()].map(|word| {
        let text = decoded(word);
        if let Cow::Owned(text) = &text {
            notes.latin1(text);
        }
        text.into_owned()
    });
    content.names.entry(number).or_insert(Named { kind, name });
    // The domain, and what Fluent has set for the zone.
    scanner.pass(39)?;
    scanner.pass(39)
}

/// The types and names in a text of sections, such as HDF5 files have among their settings.
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
