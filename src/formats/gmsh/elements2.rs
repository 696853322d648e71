//! `$Elements` of version 2: each element with its own type and tags.

use super::elements::{parse_nodes, unknown_node};
use super::groups::{Shared, Tagged};
use super::kinds;
use super::nodes::{CHUNK, NodeIndex, count};
use super::stream::{Binary, Stream};
use crate::error::{Error, Result};
use crate::mesh::{CellKind, Cells};
use rayon::prelude::*;

/// Elements in a row, as one task finds them.
#[derive(Default)]
struct Part {
    connectivity: Vec<u32>,
    runs: Vec<Run>,
}

/// Elements of one type with the same tags.
#[derive(Clone, Copy, PartialEq)]
struct Run {
    kind: CellKind,
    physical: i32,
    elementary: i32,
    n_cells: usize,
}

impl Part {
    /// Room for the nodes of one more element.
    fn push(&mut self, kind: CellKind, physical: i32, elementary: i32) -> &mut [u32] {
        let tags = |run: &Run| (run.kind, run.physical, run.elementary);
        match self.runs.last_mut() {
            Some(run) if tags(run) == (kind, physical, elementary) => run.n_cells += 1,
            _ => self.runs.push(Run {
                kind,
                physical,
                elementary,
                n_cells: 1,
            }),
        }
        let known = self.connectivity.len();
        let n_nodes = n_nodes_of(kind);
        self.connectivity.resize(known + n_nodes, 0);
        &mut self.connectivity[known..]
    }
}

/// Reads all elements; `physical` and `elementary` take those of each physical group and entity,
/// `shared` what tells of elements that are there more than once.
pub(super) fn read2(
    stream: &mut Stream,
    nodes: &NodeIndex,
    physical: &mut Tagged,
    elementary: &mut Tagged,
    shared: &mut Shared,
) -> Result<Cells> {
    let n = count(stream, "the number of elements")?;
    if n >= u32::MAX as usize {
        return Err(stream.error("at most 4294967294 elements are possible"));
    }
    let mut cells = Cells::new();
    let mut add = |parts: Vec<Part>| {
        for part in parts {
            let mut rest = &part.connectivity[..];
            for run in part.runs {
                let n_nodes = n_nodes_of(run.kind);
                let (own, tail) = rest.split_at(n_nodes * run.n_cells);
                let range = cells.len()..cells.len() + run.n_cells;
                let dimension = run.kind.dimension();
                shared.add(dimension, run.elementary, run.physical);
                // Version 2 says 0 for an element without a tag.
                if run.physical != 0 {
                    physical.add(dimension, run.physical, range.clone());
                }
                if run.elementary != 0 {
                    elementary.add(dimension, run.elementary, range);
                }
                cells.push_run(run.kind, n_nodes, own);
                rest = tail;
            }
        }
    };
    match stream.binary {
        None => {
            let lines = stream.lines(n, "$Elements")?;
            add(lines.parse(|line, part| parse_element(line, nodes, part))?);
        }
        Some(binary) => {
            let mut left = n;
            while left > 0 {
                let block = Block::read(stream, binary, left)?;
                left -= block.n_cells;
                add(block.parts(nodes)?);
            }
        }
    }
    Ok(cells)
}

fn n_nodes_of(kind: CellKind) -> usize {
    kind.n_nodes().expect("Gmsh's kinds have a number of nodes")
}

/// One line: number, type, number of tags, tags, nodes.
fn parse_element(
    line: &mut super::super::lexer::Fields,
    nodes: &NodeIndex,
    part: &mut Part,
) -> Result<()> {
    line.integer("an element number")?;
    let number = line.integer("an element type")?;
    let kind = kinds::kind(number).map_err(|why| line.error(why))?;
    let n_tags: usize = line.narrow("the number of tags")?;
    let mut tags = [0; 2];
    for i in 0..n_tags {
        let tag: i32 = line.narrow("a tag")?;
        if let Some(known) = tags.get_mut(i) {
            *known = tag;
        }
    }
    let [physical, elementary] = tags;
    let physical = physical
        .checked_abs()
        .ok_or_else(|| line.error(format!("physical group {physical} is out of range")))?;
    parse_nodes(line, kind, nodes, part.push(kind, physical, elementary))
}

/// Binary elements of one type with the same number of tags.
struct Block<'a> {
    binary: Binary,
    kind: CellKind,
    n_tags: usize,
    n_cells: usize,
    /// Offset of `body` in the file.
    start: usize,
    body: &'a [u8],
}

impl<'a> Block<'a> {
    fn read(stream: &mut Stream<'a>, binary: Binary, left: usize) -> Result<Self> {
        let number = stream.int("an element type")?;
        let kind = kinds::kind(number.into()).map_err(|why| stream.error(why))?;
        let n_cells = stream.int("the number of elements in a block")?;
        let n_tags = stream.int("the number of tags")?;
        let n_cells = usize::try_from(n_cells)
            .ok()
            .filter(|n| (1..=left).contains(n));
        let n_cells = n_cells.ok_or_else(|| {
            stream.error(format!(
                "a block of elements with a wrong length; {left} elements are left"
            ))
        })?;
        let each = usize::try_from(n_tags)
            .ok()
            .and_then(|n| n.checked_add(1 + n_nodes_of(kind))?.checked_mul(4))
            .ok_or_else(|| stream.error(format!("a block of elements with {n_tags} tags")))?;
        let start = stream.text.position();
        Ok(Self {
            binary,
            kind,
            n_tags: n_tags as usize,
            n_cells,
            start,
            body: stream.take(n_cells, each, "the elements")?,
        })
    }

    fn parts(&self, nodes: &NodeIndex) -> Result<Vec<Part>> {
        let each = 4 * (1 + self.n_tags + n_nodes_of(self.kind));
        let results: Vec<Result<Part>> = self
            .body
            .par_chunks(CHUNK * each)
            .enumerate()
            .map(|(i, body)| {
                let mut part = Part::default();
                part.connectivity
                    .reserve(body.len() / each * n_nodes_of(self.kind));
                for (j, element) in body.chunks_exact(each).enumerate() {
                    self.decode(element, nodes, &mut part).map_err(|error| {
                        error.byte((self.start + (i * CHUNK + j) * each) as u64)
                    })?;
                }
                Ok(part)
            })
            .collect();
        results.into_iter().collect()
    }

    fn decode(&self, element: &[u8], nodes: &NodeIndex, part: &mut Part) -> Result<()> {
        let int = |i: usize| self.binary.int(&element[4 * i..4 * i + 4]);
        let tag = |i: usize| if i < self.n_tags { int(1 + i) } else { 0 };
        let physical = tag(0)
            .checked_abs()
            .ok_or_else(|| Error::input(format!("physical group {} is out of range", tag(0))))?;
        let cell = part.push(self.kind, physical, tag(1));
        for (i, node) in cell.iter_mut().enumerate() {
            let tag = i64::from(int(1 + self.n_tags + i));
            *node = nodes.get(tag).ok_or_else(|| unknown_node(self.kind, tag))?;
        }
        if let Some(order) = kinds::order(self.kind) {
            kinds::to_vtk(order, cell);
        }
        Ok(())
    }
}
