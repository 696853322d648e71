//! Reading SU2: keywords with a value, some followed by a block of lines, in any order; zones one
//! after another.

use super::super::Notes;
use super::super::lexer::{Fields, Lexer, line_of, shown};
use super::extra::{Extra, OWN_NODES};
use super::keyword::{Keyword, SPELLINGS};
use super::zone::{Markers, Taken, Zone};
use crate::mesh::{DataArray, Group, Mesh, Values};
use azimesh_core::diagnostic::formats::{NotKept, Read};
use azimesh_core::error::{Error, Result, counted};
use std::collections::{BTreeMap, BTreeSet};

/// Keywords without a meaning here that a note lists by name.
const LISTED: usize = 8;

/// Whether the first line that is no comment sets one of the keywords that start a mesh.
pub(super) fn recognizes(head: &[u8]) -> bool {
    let mut lexer = Lexer::new(head, Some(b'%'));
    let line = lexer.line();
    let keyword = line.and_then(|line| Keyword::of(&line));
    keyword.is_some_and(|keyword| {
        matches!(
            keyword.name,
            b"NDIME" | b"NZONE" | b"IZONE" | b"NELEM" | b"NPOIN" | b"NMARK"
        )
    })
}

/// The block that the next lines of data belong to.
enum Block {
    /// None: blocks of the mesh have been read with their keyword.
    None,
    /// A text that is kept.
    Text(Extra),
    /// A keyword that means nothing here.
    Unknown(String),
}

/// A block of lines whose number the file gives.
struct Counted {
    name: &'static [u8],
    n: usize,
    /// Where its first line starts.
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
        let mut lexer = Lexer::new(bytes, Some(b'%'));
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

    /// The refusal of a count that a line comes after.
    fn too_small(&self, line: &Fields, bytes: &[u8]) -> Error {
        let found = shown(line.rest());
        self.wrong(
            format!("but there are more lines before the next keyword: {found}"),
            bytes,
        )
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
    /// Numbers of the zones.
    numbers: BTreeSet<i32>,
    block: Block,
    /// Name of the last keyword.
    last: &'a [u8],
    /// Lines behind each keyword that means nothing here, itself included.
    unknown: BTreeMap<String, usize>,
}

/// The mesh in these bytes. A count that is too large takes keywords for data, and what goes wrong then
/// is blamed on it.
pub(super) fn read(bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    let mut blocks = Vec::new();
    let mesh = read_zones(bytes, notes, &mut blocks).map_err(|error| {
        let mut refusals = blocks.iter().filter_map(|block| block.too_large(bytes));
        refusals.next().unwrap_or(error)
    })?;
    note_dialect(bytes, notes);
    Ok(mesh)
}

/// Notes of what SU2 itself would not read.
fn note_dialect(bytes: &[u8], notes: &mut Notes) {
    for [found, meant] in SPELLINGS {
        if memchr::memmem::find(bytes, format!("{found}=").as_bytes()).is_some() {
            notes.push(Read::Spelled { found, meant });
        }
    }
    notes.dialect(bytes);
}

/// The mesh, and each block of lines whose number the file gives.
fn read_zones(bytes: &[u8], notes: &mut Notes, blocks: &mut Vec<Counted>) -> Result<Mesh> {
    let mut lexer = Lexer::new(bytes, Some(b'%'));
    let mut file = File {
        n_zones: None,
        dimension: None,
        zones: vec![Zone::default()],
        numbers: BTreeSet::new(),
        block: Block::None,
        last: b"",
        unknown: BTreeMap::new(),
    };
    while let Some(line) = lexer.line() {
        match Keyword::of(&line) {
            Some(keyword) => {
                let block = Counted::of(&keyword, lexer.position());
                let taken = file.take(&keyword, &line, &mut lexer, notes);
                blocks.extend(block);
                taken?;
            }
            None => file.take_data(&line, blocks.last(), bytes, notes)?,
        }
    }
    file.note_unknown(notes);
    file.mesh(&lexer, notes)
}

impl<'a> File<'a> {
    fn zone(&mut self) -> &mut Zone<'a> {
        self.zones.last_mut().expect("there is always one")
    }

    fn take(
        &mut self,
        keyword: &Keyword<'a>,
        line: &Fields<'a>,
        lexer: &mut Lexer<'a>,
        notes: &mut Notes,
    ) -> Result<()> {
        self.block = Block::None;
        self.last = keyword.name;
        match keyword.name {
            b"NZONE" => {
                let n = keyword.count(line)?;
                if n == 0 {
                    return Err(line.error("NZONE= 0; there must be at least one zone"));
                }
                self.n_zones = Some(n);
            }
            b"IZONE" => {
                let number = zone_number(keyword, line)?;
                if !self.numbers.insert(number) {
                    return Err(line.error(format!("IZONE= {number} appears twice")));
                }
                if self.zone().has_begun() || self.zone().number.is_some() {
                    self.zones.push(Zone::default());
                }
                // A dimension before the first zone is that of all.
                self.dimension = self.dimension.or(self.zones[0].dimension);
                self.zone().number = Some(number);
            }
            _ => match self.zone().take(keyword, line, lexer, notes)? {
                Taken::Mesh => {}
                Taken::Text(extra) => {
                    self.zone().keep(extra, line.rest(), notes);
                    self.block = Block::Text(extra);
                }
                Taken::Unknown => {
                    let name = keyword.name();
                    *self.unknown.entry(name.clone()).or_default() += 1;
                    self.block = Block::Unknown(name);
                }
            },
        }
        Ok(())
    }

    /// Takes a line that is no keyword; `before` is the last block of a known number of lines.
    fn take_data(
        &mut self,
        line: &Fields,
        before: Option<&Counted>,
        bytes: &[u8],
        notes: &mut Notes,
    ) -> Result<()> {
        match &self.block {
            Block::Text(extra) => {
                let extra = *extra;
                self.zone().keep(extra, line.rest(), notes);
            }
            Block::Unknown(name) => {
                *self.unknown.get_mut(name).expect("its keyword came first") += 1;
            }
            Block::None => {
                if let Some(block) = before.filter(|block| block.name == self.last) {
                    return Err(block.too_small(line, bytes));
                }
                let found = shown(line.rest());
                return Err(line.error(format!("expected a line KEYWORD= value, found {found}")));
            }
        }
        Ok(())
    }

    /// Says which keywords are not kept.
    fn note_unknown(&self, notes: &mut Notes) {
        for (name, n) in self.unknown.iter().take(LISTED) {
            notes.push(NotKept::Keyword {
                name: name.to_string(),
                n_lines: *n,
            });
        }
        let left = self.unknown.len().saturating_sub(LISTED);
        notes.count(left, |n| NotKept::Keywords { n });
    }

    fn mesh(mut self, lexer: &Lexer, notes: &mut Notes) -> Result<Mesh> {
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
        let mut markers = Markers::default();
        for (i, zone) in self.zones.iter().enumerate() {
            let volume = zone
                .append_to(&mut mesh, &mut markers, notes)
                .map_err(|error| error.line(line_of(lexer.bytes(), lexer.position())))?;
            if n_zones > 1 {
                let number = zone.number.unwrap_or(i as i32 + 1);
                mesh.groups.push(Group {
                    dimension: dimension.expect("it was checked") as u8,
                    name: number.to_string(),
                    number: Some(number),
                    condition: None,
                    cells: volume.collect(),
                });
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
            let texts = self.zones.iter_mut();
            let texts: Vec<String> = texts
                .map(|zone| std::mem::take(&mut zone.extra[extra as usize]))
                .collect();
            if texts.iter().any(|text| !text.is_empty()) {
                let values = Values::Text(texts);
                let array = DataArray::scalar(extra.array(), values);
                mesh.field_arrays.push(array);
            }
        }
        if self.zones.iter().any(|zone| zone.own_nodes.is_some()) {
            let numbers = self.zones.iter();
            // Zones without copies have none to count.
            let numbers = numbers.map(|zone| zone.own_nodes.unwrap_or(-1)).collect();
            let array = DataArray::scalar(OWN_NODES, Values::I64(numbers));
            mesh.field_arrays.push(array);
        }
    }
}

fn zone_number(keyword: &Keyword, line: &Fields) -> Result<i32> {
    let number = keyword.integer(line)?;
    i32::try_from(number).map_err(|_| line.error(format!("IZONE= {number} is out of range")))
}
