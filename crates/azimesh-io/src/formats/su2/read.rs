//! Reading SU2: keywords with a value, some followed by a block of lines, in any order; zones one
//! after another.

use super::super::Notes;
use super::super::tokens::{Tokens, line_of, shown};
use super::zone::Zone;
use super::{Extra, OWN_NODES};
use crate::formats::names::Places;
use crate::mesh::{DataArray, Group, Mesh, Values};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use azimesh_core::numbers::with_verb;
use std::collections::{BTreeMap, BTreeSet};

/// Keywords without a meaning here that a note lists by name.
const LISTED: usize = 8;

/// Checks if the first line that is no comment sets one of the keywords that start a mesh.
pub(super) fn recognizes(head: &[u8]) -> bool {
    let mut lexer = Tokens::with_comments(head);
    let line = lexer.line();
    let keyword = line.and_then(|line| Keyword::of(&line));
    let names: [&[u8]; 6] = [b"NDIME", b"NZONE", b"IZONE", b"NELEM", b"NPOIN", b"NMARK"];
    keyword.is_some_and(|keyword| names.contains(&keyword.name))
}

/// The block that the next lines of data belong to.
pub(super) enum Block {
    /// None: blocks of the mesh are read with their keyword.
    None,
    /// A text that is kept.
    Text(Extra),
    /// A keyword without a meaning here.
    Unknown(String),
}

/// A block of lines whose number the file gives.
struct Counted {
    name: &'static [u8],
    n: usize,
    /// Offset of its first line.
    start: usize,
}

impl Counted {
    /// The block behind a keyword that ends before `start`.
    fn of(keyword: &Keyword, start: usize) -> Option<Self> {
        const NAMES: [&[u8]; 3] = [b"NELEM", b"NPOIN", b"MARKER_ELEMS"];
        let name = NAMES.into_iter().find(|name| *name == keyword.name)?;
        let n = usize::try_from(keyword.integers()[0]?).ok()?;
        Some(Self { name, n, start })
    }

    /// The refusal of a count that reaches beyond the next keyword.
    fn too_large(&self, bytes: &[u8]) -> Option<Error> {
        let mut lexer = Tokens::with_comments(bytes);
        lexer.set_position(self.start);
        let mut found = 0;
        while let Some(line) = lexer.line().filter(|_| found < self.n) {
            let keyword = Keyword::of(&line);
            if keyword.is_some_and(|keyword| !keyword.name.starts_with(b"SEND_")) {
                let (next, found) = (shown(line.rest()), counted(found, "line"));
                return Some(self.wrong(format!("but only {found} before {next}"), bytes));
            }
            found += usize::from(keyword.is_none());
        }
        None
    }

    fn wrong(&self, what: String, bytes: &[u8]) -> Error {
        let message = format!("{}= {}, {what}", self.name.escape_ascii(), self.n);
        Error::input(message).line(line_of(bytes, self.start.saturating_sub(1)))
    }
}

/// The file as its zones.
struct File<'a> {
    n_zones: Option<usize>,
    dimension: Option<usize>,
    zones: Vec<Zone<'a>>,
    numbers: BTreeSet<i32>,
    /// Lines behind each keyword that means nothing here, itself included.
    unknown: BTreeMap<String, usize>,
}

/// The mesh in these bytes. A count that is too large takes keywords for data; errors then name the count.
pub(super) fn read(bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    let mut blocks = Vec::new();
    let mesh = read_zones(bytes, notes, &mut blocks).map_err(|error| {
        let mut refusals = blocks.iter().filter_map(|block| block.too_large(bytes));
        refusals.next().unwrap_or(error)
    })?;
    // SU2 itself would not read these.
    for [found, meant] in SPELLINGS {
        if memchr::memmem::find(bytes, format!("{found}=").as_bytes()).is_some() {
            notes.push(note!("spelled", "{found}= is read as {meant}="));
        }
    }
    notes.dialect(bytes);
    Ok(mesh)
}

/// The mesh, and each block of lines whose number the file gives.
fn read_zones(bytes: &[u8], notes: &mut Notes, blocks: &mut Vec<Counted>) -> Result<Mesh> {
    let mut lexer = Tokens::with_comments(bytes);
    let mut file = File {
        n_zones: None,
        dimension: None,
        zones: vec![Zone::default()],
        numbers: BTreeSet::new(),
        unknown: BTreeMap::new(),
    };
    while let Some(line) = lexer.line() {
        let expected = |line: &Tokens| {
            let found = shown(line.rest());
            line.error(format!("expected a line KEYWORD= value, found {found}"))
        };
        let keyword = Keyword::of(&line).ok_or_else(|| expected(&line))?;
        let counted = Counted::of(&keyword, lexer.position());
        let is_counted = counted.is_some();
        let taken = file.take(&keyword, &line, &mut lexer, notes);
        blocks.extend(counted);
        let block = taken?;
        while let Some(line) = lexer.peek_line().filter(|line| Keyword::of(line).is_none()) {
            lexer.line();
            match &block {
                &Block::Text(extra) => file.zone().keep(extra, line.rest(), notes),
                Block::Unknown(name) => *file.unknown.entry(name.clone()).or_default() += 1,
                Block::None => {
                    let known = blocks.last().filter(|_| is_counted);
                    let known = known.ok_or_else(|| expected(&line))?;
                    let (what, found) = ("there are more lines before", shown(line.rest()));
                    let what = format!("but {what} the next keyword: {found}");
                    return Err(known.wrong(what, bytes));
                }
            }
        }
    }
    for (name, n) in file.unknown.iter().take(LISTED) {
        notes.push(note!(
            "keyword_not_kept",
            "{name}= is not kept ({})",
            counted(*n, "line")
        ));
    }
    let left = file.unknown.len().saturating_sub(LISTED);
    notes.count(left, |n| {
        note!(
            "keywords_not_kept",
            "{} not kept",
            with_verb(n, "more keyword", "is")
        )
    });
    file.mesh(&lexer, notes)
}

impl<'a> File<'a> {
    fn zone(&mut self) -> &mut Zone<'a> {
        self.zones.last_mut().expect("there is always one")
    }

    fn take(
        &mut self,
        keyword: &Keyword<'a>,
        line: &Tokens<'a>,
        lexer: &mut Tokens<'a>,
        notes: &mut Notes,
    ) -> Result<Block> {
        match keyword.name {
            b"NZONE" => {
                let n = keyword.count(line)?;
                if n == 0 {
                    return Err(line.error("NZONE= 0; there must be at least one zone"));
                }
                self.n_zones = Some(n);
            }
            b"IZONE" => {
                let number = keyword.integer(line)?;
                let number = i32::try_from(number)
                    .map_err(|_| line.error(format!("IZONE= {number} is out of range")))?;
                if !self.numbers.insert(number) {
                    return Err(line.error(format!("IZONE= {number} appears twice")));
                }
                if self.zone().has_begun() || self.zone().number.is_some() {
                    self.zones.push(Zone::default());
                }
                // All zones have the dimension before the first.
                self.dimension = self.dimension.or(self.zones[0].dimension);
                self.zone().number = Some(number);
            }
            _ => {
                let block = self.zone().take(keyword, line, lexer, notes)?;
                if let Block::Unknown(name) = &block {
                    *self.unknown.entry(name.clone()).or_default() += 1;
                }
                return Ok(block);
            }
        }
        Ok(Block::None)
    }

    fn mesh(mut self, lexer: &Tokens, notes: &mut Notes) -> Result<Mesh> {
        let n_zones = self.zones.len();
        if let Some(n) = self.n_zones.filter(|n| *n != n_zones) {
            return Err(lexer.error(format!(
                "NZONE= {n}, but the file has {}; each starts with IZONE=",
                counted(n_zones, "zone")
            )));
        }
        for zone in &mut self.zones {
            zone.dimension = zone.dimension.or(self.dimension);
            zone.check(lexer, notes)?;
        }
        let dimension = self.zones[0].dimension;
        if let Some(other) = self.zones.iter().find(|zone| zone.dimension != dimension) {
            let message = "the zones have dimensions 2 and 3; all must have the same";
            return Err(Error::input(message).line(line_of(lexer.bytes(), other.dimension_at)));
        }
        let mut mesh = Mesh::default();
        let mut markers = Places::default();
        for (i, zone) in self.zones.iter().enumerate() {
            let volume = zone.append_to(&mut mesh, &mut markers, notes);
            let volume =
                volume.map_err(|error| error.line(line_of(lexer.bytes(), lexer.position())))?;
            if n_zones > 1 {
                let number = zone.number.unwrap_or(i as i32 + 1);
                let (dimension, name) = (dimension.expect("it was checked"), number.to_string());
                let zone = Group::new(dimension as u8, name, Some(number), volume.into());
                mesh.groups.push(zone);
            }
        }
        let dimension = dimension.map(|dimension| dimension as u8);
        // Markers without a volume are the surface of one.
        mesh.space = dimension.filter(|dimension| *dimension > mesh.dimension());
        self.add_extra(&mut mesh);
        Ok(mesh)
    }

    /// Puts text that only SU2 understands into field arrays, one entry a zone.
    fn add_extra(&mut self, mesh: &mut Mesh) {
        for extra in Extra::ALL {
            let text = |zone: &mut Zone| std::mem::take(&mut zone.extra[extra as usize]);
            let texts: Vec<String> = self.zones.iter_mut().map(text).collect();
            if texts.iter().any(|text| !text.is_empty()) {
                let array = DataArray::scalar(extra.array(), Values::Text(texts));
                mesh.field_arrays.push(array);
            }
        }
        let numbers = self.zones.iter().map(|zone| zone.own_nodes);
        if numbers.clone().any(|own| own.is_some()) {
            // Zones without copies have none to count.
            let numbers = numbers.map(|own| own.unwrap_or(-1)).collect();
            let array = DataArray::scalar(OWN_NODES, Values::I64(numbers));
            mesh.field_arrays.push(array);
        }
    }
}

/// Keywords as some programs spell them, and as they are.
const SPELLINGS: [[&str; 2]; 2] = [["MARKERTAG", "MARKER_TAG"], ["MARKERELEMS", "MARKER_ELEMS"]];

/// A keyword and what follows its `=`, without a comment behind it.
#[derive(Clone, Copy)]
pub(super) struct Keyword<'a> {
    pub name: &'a [u8],
    pub value: &'a [u8],
}

impl<'a> Keyword<'a> {
    /// The keyword of a line; `None` for a line of data.
    pub fn of(line: &Tokens<'a>) -> Option<Self> {
        let text = line.rest();
        let at = memchr::memchr(b'=', without_comment(text))?;
        let name = text[..at].trim_ascii();
        let meant = SPELLINGS.iter().find(|[odd, _]| odd.as_bytes() == name);
        Some(Self {
            name: meant.map_or(name, |[_, name]| name.as_bytes()),
            value: without_comment(text[at + 1..].trim_ascii()).trim_ascii(),
        })
    }

    pub fn name(&self) -> String {
        self.name.escape_ascii().to_string()
    }

    /// The first integer of the value.
    pub fn integer(&self, line: &Tokens) -> Result<i64> {
        self.integers()[0].ok_or_else(|| {
            let found = shown(self.value);
            line.error(format!("{}= needs an integer, found {found}", self.name()))
        })
    }

    /// The first two integers of the value, where they are there.
    pub fn integers(&self) -> [Option<i64>; 2] {
        let mut value = Tokens::new(self.value).line();
        let mut next = || value.as_mut().and_then(|value| value.integer("").ok());
        let first = next();
        [first, first.and_then(|_| next())]
    }

    /// The first integer of the value, which counts something.
    pub fn count(&self, line: &Tokens) -> Result<usize> {
        let value = self.integer(line)?;
        usize::try_from(value).map_err(|_| {
            let name = self.name();
            line.error(format!("{name}= {value}: a count cannot be negative"))
        })
    }
}

/// The text before a `%`, or before a `#` or `!` that follows a space: names may have these.
fn without_comment(text: &[u8]) -> &[u8] {
    let begins = |&at: &usize| text[at] == b'%' || (at > 0 && text[at - 1].is_ascii_whitespace());
    let end = memchr::memchr3_iter(b'%', b'#', b'!', text).find(begins);
    &text[..end.unwrap_or(text.len())]
}
