//! Reading triangles: text or binary, nodes at one place made one.

use super::super::names::{Places, text_of};
use super::super::number::DType;
use super::super::tokens::Tokens;
use crate::formats::Notes;
use crate::mesh::{CellKind, CellSet, Cells, Group, Mesh, too_many};
use azimesh_core::error::{Error, Result};
use std::collections::HashMap;

/// Bytes before the triangles of a binary file: a title, and their number.
const HEAD: usize = 84;
/// Bytes of a triangle: normal, corners, attributes.
const TRIANGLE: usize = 50;

/// Number of triangles that a binary file says it has, where it is as long as that.
fn n_binary(bytes: &[u8]) -> Option<usize> {
    let n = u32::from_le_bytes(bytes.get(80..HEAD)?.try_into().ok()?) as usize;
    let length = n.checked_mul(TRIANGLE)?.checked_add(HEAD)?;
    (length == bytes.len()).then_some(n)
}

fn is_text(bytes: &[u8]) -> bool {
    let head = bytes[..bytes.len().min(1024)].trim_ascii_start();
    let has = |word: &[u8]| memchr::memmem::find(head, word).is_some();
    let words: [&[u8]; 4] = [b"facet", b"FACET", b"endsolid", b"ENDSOLID"];
    let begins = head.len() >= 5 && head[..5].eq_ignore_ascii_case(b"solid");
    begins && words.into_iter().any(has)
}

/// Returns whether a file is STL. Binary files may begin with the word of text.
pub(super) fn recognizes(bytes: &[u8]) -> bool {
    is_text(bytes) || n_binary(bytes).is_some_and(|n| n > 0)
}

pub(super) fn read(bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    match n_binary(bytes) {
        Some(n) => binary(bytes, n, notes),
        None if is_text(bytes) => text(bytes, notes),
        None => Err(neither(bytes)),
    }
}

fn neither(bytes: &[u8]) -> Error {
    let Some(n) = bytes.get(80..HEAD) else {
        return Error::input(format!(
            "the file has {} bytes; it must be text that begins with \"solid\", or binary of at least {HEAD} bytes",
            bytes.len()
        ))
        .byte(0);
    };
    let n = n.try_into().map_or(0, u32::from_le_bytes);
    Error::input(format!(
        "{n} triangles take {} bytes, but the file has {}; it is cut, or no binary STL (text begins with \"solid\")",
        HEAD as u64 + TRIANGLE as u64 * u64::from(n),
        bytes.len()
    ))
    .byte(80)
}

#[derive(Default)]
struct Nodes {
    points: Vec<[f64; 3]>,
    places: HashMap<[u64; 3], u32>,
}

impl Nodes {
    fn node(&mut self, point: [f64; 3]) -> Result<u32> {
        // Zero and minus zero are one place.
        let place = point.map(|x| (x + 0.0).to_bits());
        let new = u32::try_from(self.points.len()).ok();
        let new = new
            .filter(|n| *n < u32::MAX)
            .ok_or_else(|| Error::input(too_many("nodes")))?;
        let node = *self.places.entry(place).or_insert(new);
        if node == new {
            self.points.push(point);
        }
        Ok(node)
    }

    fn mesh(self, triangles: Vec<u32>, groups: Vec<Group>) -> Mesh {
        let n = triangles.len() / 3;
        Mesh {
            points: self.points,
            cells: Cells::from_connectivity(triangles, [(CellKind::Triangle, 3, n)]),
            groups,
            space: Some(3),
            ..Mesh::default()
        }
    }
}

fn binary(bytes: &[u8], n: usize, notes: &mut Notes) -> Result<Mesh> {
    let mut nodes = Nodes::default();
    let mut triangles = Vec::with_capacity(3 * n);
    let mut n_attributes = 0;
    for (i, triangle) in bytes[HEAD..].chunks_exact(TRIANGLE).enumerate() {
        for corner in triangle[12..48].chunks_exact(12) {
            let mut point = [0.0; 3];
            DType::real(4, false).of(corner).few_reals(&mut point);
            if !point.iter().all(|x| x.is_finite()) {
                let message = format!("triangle {i} has a coordinate that is not finite");
                return Err(Error::input(message).byte((HEAD + TRIANGLE * i) as u64));
            }
            triangles.push(nodes.node(point)?);
        }
        n_attributes += usize::from(triangle[48..] != [0, 0]);
    }
    notes.not_kept("attributes of triangles, such as colours,", n_attributes);
    Ok(nodes.mesh(triangles, Vec::new()))
}

/// Content read from a text.
struct Text<'a> {
    lexer: Tokens<'a>,
    nodes: Nodes,
    triangles: Vec<u32>,
    /// Triangles of each named solid, in the order of their names in the file.
    solids: Vec<Group>,
    places: Places<String>,
}

fn text(bytes: &[u8], notes: &mut Notes) -> Result<Mesh> {
    let mut text = Text {
        lexer: Tokens::new(bytes),
        nodes: Nodes::default(),
        triangles: Vec::new(),
        solids: Vec::new(),
        places: Places::default(),
    };
    while let Some(mut line) = text.lexer.line() {
        keyword(&mut line, "solid")?;
        let name = text_of(line.rest(), notes);
        text.solid(&name)?;
    }
    Ok(text.nodes.mesh(text.triangles, text.solids))
}

/// Moves past a word if it is the next.
fn take(line: &mut Tokens, word: &str) -> bool {
    let mut after = line.clone();
    let found = after.word().unwrap_or_default();
    let is_next = found.eq_ignore_ascii_case(word.as_bytes());
    if is_next {
        *line = after;
    }
    is_next
}

/// Moves past a word.
fn keyword(line: &mut Tokens, word: &str) -> Result<()> {
    if take(line, word) {
        return Ok(());
    }
    let found = line.clone().word().unwrap_or_default();
    let found = String::from_utf8_lossy(&found[..found.len().min(40)]);
    Err(line.error(format!("expected \"{word}\", found \"{found}\"")))
}

impl<'a> Text<'a> {
    fn next(&mut self) -> Result<Tokens<'a>> {
        let message = "the file ends within a solid; \"endsolid\" is missing";
        self.lexer.line().ok_or_else(|| self.lexer.error(message))
    }

    /// The facets of a solid, to its end.
    fn solid(&mut self, name: &str) -> Result<()> {
        let first = self.triangles.len() / 3;
        loop {
            let mut line = self.next()?;
            if take(&mut line, "endsolid") {
                break;
            }
            // The numbers of the normal follow from the corners.
            keyword(&mut line, "facet")?;
            let mut line = self.next()?;
            keyword(&mut line, "outer")?;
            for _ in 0..3 {
                let mut line = self.next()?;
                keyword(&mut line, "vertex")?;
                let mut coordinate = || line.real("a coordinate");
                let point = [coordinate()?, coordinate()?, coordinate()?];
                let node = self.nodes.node(point)?;
                self.triangles.push(node);
            }
            for word in ["endloop", "endfacet"] {
                keyword(&mut self.next()?, word)?;
            }
        }
        let own = first..self.triangles.len() / 3;
        if name.is_empty() {
            return Ok(());
        }
        let new = || Group::new(2, name, None, CellSet::new());
        let solid = self.places.entry(name.to_owned(), &mut self.solids, new);
        solid.cells.push_range(own);
        Ok(())
    }
}
