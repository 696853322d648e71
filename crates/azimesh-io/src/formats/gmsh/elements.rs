//! `$Elements` of version 4: blocks of one type and one entity.

use super::super::lexer::{Fields, Lines};
use super::super::source::release_mapped;
use super::groups::Tagged;
use super::index::{Index, Numbers};
use super::kinds::{self, Type};
use super::nodes::CHUNK;
use super::stream::{Binary, Stream, Version};
use crate::mesh::too_many;
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::map_items;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Elements of one type in one entity.
pub(super) struct Block<'a> {
    of: &'static Type,
    first_cell: usize,
    n_cells: usize,
    body: Body<'a>,
}

enum Body<'a> {
    /// The lines and their bytes.
    Text(Lines<'a>, usize),
    /// Encoding, offset in the file, and the bytes.
    Binary(Binary, usize, &'a [u8]),
}

/// Reads all elements; `tagged` takes those of each entity, `numbers` their tags.
pub(super) fn read(
    stream: &mut Stream,
    version: Version,
    nodes: &Index,
    tagged: &mut Tagged,
    numbers: &mut Numbers,
) -> Result<Cells> {
    let blocks = read_blocks(stream, version, tagged)?;
    for block in &blocks {
        block.check_length(nodes)?;
    }
    let (cells, counts_up) = cells_of(&blocks, nodes)?;
    if !counts_up {
        for block in &blocks {
            block.numbers(numbers)?;
        }
    }
    Ok(cells)
}

/// Passes all elements of a binary file, which `tagged` and `numbers` take as in [`read`]; of the file little is in memory at a time.
pub(super) fn read_tags(
    stream: &mut Stream,
    version: Version,
    tagged: &mut Tagged,
    numbers: &mut Numbers,
) -> Result<()> {
    for block in read_blocks(stream, version, tagged)? {
        for start in (0..block.n_cells).step_by(16 * CHUNK) {
            let some = block.part(start..block.n_cells.min(start + 16 * CHUNK));
            some.map_or(Ok(()), |some| some.numbers(numbers))?;
            release_mapped();
        }
    }
    Ok(())
}

/// The cells of blocks, and whether their tags count up from 1.
pub(super) fn cells_of(blocks: &[Block], nodes: &Index) -> Result<(Cells, bool)> {
    let n_entries = blocks.iter().map(|block| block.of.n_nodes * block.n_cells);
    let mut connectivity = vec![0u32; n_entries.sum()];
    let mut rest = &mut connectivity[..];
    let counts_up = AtomicBool::new(true);
    for block in blocks {
        let (out, tail) = rest.split_at_mut(block.of.n_nodes * block.n_cells);
        block.fill(nodes, out, &counts_up)?;
        rest = tail;
    }
    let kinds = blocks
        .iter()
        .map(|block| (block.of.kind, block.of.n_nodes, block.n_cells));
    let cells = Cells::from_connectivity(connectivity, kinds);
    Ok((cells, counts_up.into_inner()))
}

/// Finds the blocks and checks that the file holds all of them.
pub(super) fn read_blocks<'a>(
    stream: &mut Stream<'a>,
    version: Version,
    tagged: &mut Tagged,
) -> Result<Vec<Block<'a>>> {
    let n_blocks = stream.size("the number of element blocks")?;
    let n_elements = stream.size("the number of elements")?;
    if version == Version::V41 {
        stream.size("the lowest element tag")?;
        stream.size("the highest element tag")?;
    }
    let mut blocks = Vec::new();
    let mut n_cells = 0;
    for _ in 0..n_blocks {
        let (dimension, entity) = stream.entity(version)?;
        let number = stream.int("an element type")?;
        let of = kinds::element_type(number.into()).map_err(|why| stream.error(why))?;
        if dimension != i32::from(of.kind.dimension()) {
            return Err(stream.error(format!(
                "an entity of dimension {dimension} has elements of type {number}, {}s of dimension {}",
                of.kind.name(),
                of.kind.dimension()
            )));
        }
        let block = read_block(stream, version, of, n_cells)?;
        tagged.add(
            of.kind.dimension(),
            entity,
            n_cells..n_cells + block.n_cells,
        );
        n_cells += block.n_cells;
        if n_cells >= u32::MAX as usize {
            return Err(stream.error(too_many("elements")));
        }
        blocks.push(block);
    }
    if n_cells != n_elements {
        return Err(stream.error(format!(
            "the blocks hold {n_cells} elements, but $Elements says {n_elements}"
        )));
    }
    Ok(blocks)
}

fn read_block<'a>(
    stream: &mut Stream<'a>,
    version: Version,
    of: &'static Type,
    first_cell: usize,
) -> Result<Block<'a>> {
    let n_cells = stream.size("the number of elements in a block")?;
    let body = match stream.binary {
        Some(mut binary) => {
            if version == Version::V40 {
                binary.size_bytes = 4;
            }
            let start = stream.text.position();
            let each = binary.size_bytes * (1 + of.n_nodes);
            Body::Binary(binary, start, stream.take(n_cells, each, "the elements")?)
        }
        None => {
            let start = stream.text.position();
            let lines = stream.lines(n_cells, "the elements")?;
            Body::Text(lines, stream.text.position() - start)
        }
    };
    Ok(Block {
        of,
        first_cell,
        n_cells,
        body,
    })
}

impl<'a> Block<'a> {
    /// Its cells in the mesh.
    pub fn cells(&self) -> Range<usize> {
        self.first_cell..self.first_cell + self.n_cells
    }

    /// Some of the elements of a binary block, counted from its first; `None` in text.
    pub fn part(&self, elements: Range<usize>) -> Option<Self> {
        let Body::Binary(binary, start, body) = self.body else {
            return None;
        };
        let each = binary.size_bytes * (1 + self.of.n_nodes);
        let bytes = each * elements.start..each * elements.end;
        Some(Self {
            of: self.of,
            first_cell: self.first_cell + elements.start,
            n_cells: elements.len(),
            body: Body::Binary(binary, start + bytes.start, &body[bytes]),
        })
    }

    /// Finds the line that is too short in a block of fewer bytes than its nodes need, before there is
    /// memory for all of them.
    fn check_length(&self, nodes: &Index) -> Result<()> {
        let Body::Text(lines, n_bytes) = &self.body else {
            return Ok(());
        };
        let needed = self.n_cells.saturating_mul(2 * (1 + self.of.n_nodes));
        if *n_bytes + 1 < needed {
            lines.parse(|line, cell: &mut Vec<u32>| {
                cell.resize(self.of.n_nodes, 0);
                line.integer("an element tag")?;
                parse_nodes(line, self.of, nodes, cell)
            })?;
        }
        Ok(())
    }

    /// Node indices of the block's cells in VTK's order; `counts_up` is cleared where the tags of the
    /// elements are not those of cells counted from 1.
    fn fill(&self, nodes: &Index, out: &mut [u32], counts_up: &AtomicBool) -> Result<()> {
        match &self.body {
            Body::Text(lines, _) => lines.parse_each(out, self.of.n_nodes, |line, i, cell| {
                if line.integer("an element tag")? != number_of(self.first_cell + i) {
                    counts_up.store(false, Ordering::Relaxed);
                }
                parse_nodes(line, self.of, nodes, cell)
            }),
            Body::Binary(binary, start, body) => {
                let each = binary.size_bytes * (1 + self.of.n_nodes);
                let blocks = out.chunks_mut(CHUNK * self.of.n_nodes);
                let tasks = blocks.zip(body.chunks(CHUNK * each));
                let results = map_items(tasks, &|i, (out, body)| {
                    let first = self.first_cell + i * CHUNK;
                    let counts = self.decode(*binary, body, nodes, out, first);
                    let counts = counts.map_err(|(at, tag)| {
                        let place = start + i * CHUNK * each + at;
                        unknown_node(self.of.kind, tag).byte(place as u64)
                    })?;
                    if !counts {
                        counts_up.store(false, Ordering::Relaxed);
                    }
                    Ok(())
                });
                results.into_iter().collect()
            }
        }
    }

    /// Converts binary elements from the cell `first` on; whether their tags count up. An unknown node
    /// is given with its offset in `body`.
    fn decode(
        &self,
        binary: Binary,
        body: &[u8],
        nodes: &Index,
        out: &mut [u32],
        first: usize,
    ) -> std::result::Result<bool, (usize, i64)> {
        let width = binary.size_bytes;
        let each = width * (1 + self.of.n_nodes);
        let mut counts_up = true;
        for (i, (cell, element)) in out
            .chunks_exact_mut(self.of.n_nodes)
            .zip(body.chunks_exact(each))
            .enumerate()
        {
            counts_up &= binary.size(&element[..width]) == number_of(first + i);
            for (j, bytes) in element[width..].chunks_exact(width).enumerate() {
                let tag = binary.size(bytes);
                cell[self.of.vtk(j)] = nodes.get(tag).ok_or((i * each, tag))?;
            }
        }
        Ok(counts_up)
    }

    /// Adds the tags of the elements.
    fn numbers(&self, numbers: &mut Numbers) -> Result<()> {
        match &self.body {
            Body::Text(lines, _) => {
                let parts = lines.parse(|line, part: &mut Numbers| {
                    part.push(line.integer("an element tag")?);
                    Ok(())
                })?;
                parts.iter().for_each(|part| numbers.extend(part));
            }
            Body::Binary(binary, _, body) => {
                let width = binary.size_bytes;
                for element in body.chunks_exact(width * (1 + self.of.n_nodes)) {
                    numbers.push(binary.size(&element[..width]));
                }
            }
        }
        Ok(())
    }
}

/// The tag of a cell where tags count up from 1.
fn number_of(cell: usize) -> i64 {
    cell as i64 + 1
}

/// Reads the nodes that end an element's line.
fn parse_nodes(line: &mut Fields, of: &Type, nodes: &Index, cell: &mut [u32]) -> Result<()> {
    read_nodes(line, of, nodes, cell)?;
    line.end("an element")
}

/// Reads the nodes of an element.
pub(super) fn read_nodes(
    line: &mut Fields,
    of: &Type,
    nodes: &Index,
    cell: &mut [u32],
) -> Result<()> {
    for i in 0..cell.len() {
        if line.is_done() {
            let (name, n) = (of.kind.name(), cell.len());
            return Err(line.error(format!("a {name} needs {n} nodes, found {i}")));
        }
        let tag = line.integer("a node of an element")?;
        cell[of.vtk(i)] = nodes
            .get(tag)
            .ok_or_else(|| line.error(unknown_node(of.kind, tag).message))?;
    }
    Ok(())
}

/// The refusal of a node that `$Nodes` does not have.
pub(super) fn unknown_node(kind: CellKind, tag: i64) -> Error {
    Error::input(format!(
        "a {} has node {tag}, which is not in $Nodes",
        kind.name()
    ))
}
