//! `$Elements` and `$ELM`: blocks of one type and entity in version 4; before, each element has its
//! own tags, and in text its own type.

use super::super::source::release_mapped;
use super::super::tokens::{Lines, Tokens};
use super::groups::{Shared, Tagged};
use super::index::{Index, Numbers};
use super::kinds::{self, Type};
use super::nodes::CHUNK;
use super::stream::{Binary, Stream, Version};
use crate::mesh::{Cells, too_many};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{block, map_items, try_map};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Groups, entities, partitions and numbers of the elements.
#[derive(Debug, Default)]
pub(super) struct Tags {
    pub physical: Tagged,
    pub elementary: Tagged,
    /// Cells by partition; by dimension too, which does not matter.
    pub partition: Tagged,
    /// Elements of several partitions.
    pub n_ghosts: usize,
    /// Elements that may be there more than once.
    pub shared: Shared,
    pub numbers: Numbers,
}

/// Elements of one type. Version 4 has a block for each entity and type; version 2 has blocks in binary,
/// whose elements have the same number of tags each.
pub(super) struct Block<'a> {
    of: &'static Type,
    first_cell: usize,
    n_cells: usize,
    /// Offset of the bytes in the file.
    start: usize,
    bytes: &'a [u8],
    /// `None` in binary.
    lines: Option<Lines<'a>>,
    binary: Binary,
    /// Tags between the number of a binary element and its nodes.
    n_tags: usize,
}

/// Reads all elements and their tags.
pub(super) fn read(stream: &mut Stream, nodes: &Index, tags: &mut Tags) -> Result<Cells> {
    if stream.version < Version::V40 {
        return read_list(stream, nodes, tags);
    }
    let blocks = read_blocks(stream, &mut tags.elementary)?;
    for block in &blocks {
        block.check_length(nodes)?;
    }
    let (cells, counts_up) = cells_of(&blocks, nodes)?;
    if !counts_up {
        for block in &blocks {
            block.numbers(&mut tags.numbers)?;
        }
    }
    Ok(cells)
}

/// Reads the tags of all elements of a binary file of version 4; little of the file is in memory at a time.
pub(super) fn read_tags(stream: &mut Stream, tags: &mut Tags) -> Result<()> {
    for block in read_blocks(stream, &mut tags.elementary)? {
        for start in (0..block.n_cells).step_by(16 * CHUNK) {
            let some = block.part(start..block.n_cells.min(start + 16 * CHUNK));
            some.numbers(&mut tags.numbers)?;
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
    let kind = |block: &Block| (block.of.kind, block.of.n_nodes, block.n_cells);
    let kinds = blocks.iter().map(kind);
    let cells = Cells::from_connectivity(connectivity, kinds);
    Ok((cells, counts_up.into_inner()))
}

/// Finds the blocks of version 4 and checks that the file holds all of them.
pub(super) fn read_blocks<'a>(
    stream: &mut Stream<'a>,
    tagged: &mut Tagged,
) -> Result<Vec<Block<'a>>> {
    let (n_blocks, n_elements) = stream.block_counts("element")?;
    let mut blocks = Vec::new();
    let mut n_cells = 0;
    for _ in 0..n_blocks {
        let (dimension, entity) = stream.entity()?;
        let number = stream.int("an element type")?;
        let of = kinds::element_type(number.into()).map_err(|why| stream.error(why))?;
        if dimension != i32::from(of.kind.dimension()) {
            let (name, own) = (of.kind.name(), of.kind.dimension());
            return Err(stream.error(format!(
                "an entity of dimension {dimension} has elements of type {number}, {name}s of dimension {own}"
            )));
        }
        let n = stream.size("the number of elements in a block")?;
        let block = Block::read(stream, of, n_cells, n, 0)?;
        tagged.add(of.kind.dimension(), entity, block.cells());
        n_cells += n;
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

impl<'a> Block<'a> {
    fn read(
        stream: &mut Stream<'a>,
        of: &'static Type,
        first_cell: usize,
        n_cells: usize,
        n_tags: usize,
    ) -> Result<Self> {
        let mut binary = stream.binary.unwrap_or_default();
        if stream.version != Version::V41 {
            binary.size_bytes = 4;
        }
        let start = stream.text.position();
        let mut lines = None;
        if stream.binary.is_some() {
            let each = (1 + n_tags + of.n_nodes) * binary.size_bytes;
            stream.take(n_cells, each, "the elements")?;
        } else {
            lines = Some(stream.text.take_lines(n_cells, "the elements")?);
        }
        let bytes = &stream.text.bytes()[start..stream.text.position()];
        Ok(Self {
            of,
            first_cell,
            n_cells,
            start,
            bytes,
            lines,
            binary,
            n_tags,
        })
    }

    /// Bytes of a binary element.
    fn each(&self) -> usize {
        self.binary.size_bytes * (1 + self.n_tags + self.of.n_nodes)
    }

    /// Its cells in the mesh.
    pub fn cells(&self) -> Range<usize> {
        self.first_cell..self.first_cell + self.n_cells
    }

    /// Some of the elements of a binary block, counted from its first.
    pub fn part(&self, elements: Range<usize>) -> Self {
        let bytes = self.each() * elements.start..self.each() * elements.end;
        Self {
            first_cell: self.first_cell + elements.start,
            n_cells: elements.len(),
            start: self.start + bytes.start,
            bytes: &self.bytes[bytes],
            lines: None,
            ..*self
        }
    }

    /// Finds the line that is too short in a block of fewer bytes than its nodes need, before there is
    /// memory for all of them.
    fn check_length(&self, nodes: &Index) -> Result<()> {
        let needed = self.n_cells.saturating_mul(2 * (1 + self.of.n_nodes));
        let is_short = self.bytes.len() + 1 < needed;
        let Some(lines) = self.lines.as_ref().filter(|_| is_short) else {
            return Ok(());
        };
        let parse = |line: &mut Tokens, cell: &mut Vec<u32>| {
            cell.resize(self.of.n_nodes, 0);
            line.integer("an element tag")?;
            parse_nodes(line, self.of, nodes, cell)
        };
        lines.parse(parse).map(drop)
    }

    /// Node indices of the block's cells in VTK's order; clears `counts_up` where the tags of the
    /// elements do not count from 1 in the mesh.
    fn fill(&self, nodes: &Index, out: &mut [u32], counts_up: &AtomicBool) -> Result<()> {
        let n_nodes = self.of.n_nodes;
        if let Some(lines) = &self.lines {
            return lines.parse_into(out, n_nodes, |line, i, cell| {
                if line.integer("an element tag")? != number_of(self.first_cell + i) {
                    counts_up.store(false, Ordering::Relaxed);
                }
                parse_nodes(line, self.of, nodes, cell)
            });
        }
        let results = map_items(out.chunks_mut(CHUNK * n_nodes), &|i, out| {
            let part = self.part(block(self.n_cells, CHUNK, i));
            if !part.decode(nodes, out)? {
                counts_up.store(false, Ordering::Relaxed);
            }
            Ok(())
        });
        results.into_iter().collect()
    }

    /// Converts binary elements; whether their tags count up.
    fn decode(&self, nodes: &Index, out: &mut [u32]) -> Result<bool> {
        let Self { of, binary, .. } = *self;
        let width = binary.size_bytes;
        let mut counts_up = true;
        let elements = self.bytes.chunks_exact(self.each()).enumerate();
        for ((i, element), cell) in elements.zip(out.chunks_exact_mut(of.n_nodes)) {
            counts_up &= binary.size(&element[..width]) == number_of(self.first_cell + i);
            let tags = element[width * (1 + self.n_tags)..].chunks_exact(width);
            for (j, bytes) in tags.enumerate() {
                let tag = binary.size(bytes);
                let node = nodes.get(tag).ok_or_else(|| unknown_node(of, tag));
                cell[of.vtk(j)] = node.map_err(|why| Error::input(why).byte(self.place(i)))?;
            }
        }
        Ok(counts_up)
    }

    /// Offset of a binary element in the file.
    fn place(&self, element: usize) -> u64 {
        (self.start + element * self.each()) as u64
    }

    /// Adds the tags of the elements.
    fn numbers(&self, numbers: &mut Numbers) -> Result<()> {
        let Some(lines) = &self.lines else {
            for element in self.bytes.chunks_exact(self.each()) {
                numbers.push(self.binary.size(&element[..self.binary.size_bytes]));
            }
            return Ok(());
        };
        let parts = lines.parse(|line, part: &mut Numbers| {
            part.push(line.integer("an element tag")?);
            Ok(())
        })?;
        parts.iter().for_each(|part| numbers.extend(part));
        Ok(())
    }

    /// Converts the elements of a binary block of version 2.
    fn batch(&self, nodes: &Index) -> Result<Batch> {
        let mut batch = Batch {
            connectivity: vec![0; self.n_cells * self.of.n_nodes],
            ..Batch::default()
        };
        self.decode(nodes, &mut batch.connectivity)?;
        for (i, element) in self.bytes.chunks_exact(self.each()).enumerate() {
            let int = |i: usize| self.binary.int(&element[4 * i..4 * i + 4]);
            let tags = std::array::from_fn(|i| if i < self.n_tags { int(1 + i) } else { 0 });
            let added = batch.add(self.of, int(0).into(), self.n_tags, tags);
            added.map_err(|why| Error::input(why).byte(self.place(i)))?;
        }
        Ok(batch)
    }
}

/// The tag of a cell where tags count up from 1.
fn number_of(cell: usize) -> i64 {
    cell as i64 + 1
}

/// Reads the nodes that end an element's line.
fn parse_nodes(line: &mut Tokens, of: &Type, nodes: &Index, cell: &mut [u32]) -> Result<()> {
    for i in 0..cell.len() {
        if line.is_done() {
            return Err(line.error(wrong_count(of, i as i64)));
        }
        let tag = line.integer("a node of an element")?;
        let node = nodes.get(tag).ok_or_else(|| unknown_node(of, tag));
        cell[of.vtk(i)] = node.map_err(|why| line.error(why))?;
    }
    line.end("an element")
}

fn wrong_count(of: &Type, found: i64) -> String {
    let (name, n) = (of.kind.name(), of.n_nodes);
    format!("a {name} needs {n} nodes, found {found}")
}

fn unknown_node(of: &Type, tag: i64) -> String {
    let name = of.kind.name();
    format!("a {name} has node {tag}, which is not in $Nodes")
}

/// Consecutive elements of versions 1 and 2, read by one task.
#[derive(Default)]
struct Batch {
    connectivity: Vec<u32>,
    runs: Vec<Run>,
    numbers: Numbers,
    n_ghosts: usize,
}

/// Elements of one type with the same physical group, entity and partition; 0 stands for none.
struct Run {
    of: &'static Type,
    tags: [i32; 3],
    n_cells: usize,
}

/// Reads the elements of versions 1 and 2.
fn read_list(stream: &mut Stream, nodes: &Index, tags: &mut Tags) -> Result<Cells> {
    let n = stream.count("the number of elements")?;
    if n >= u32::MAX as usize {
        return Err(stream.error(too_many("elements")));
    }
    let mut cells = Cells::new();
    if stream.binary.is_none() {
        let lines = stream.text.take_lines(n, "the elements")?;
        let version = stream.version;
        let parts = lines.parse(|line, part| parse_element(line, version, nodes, part))?;
        parts.iter().for_each(|part| part.add_to(&mut cells, tags));
        return Ok(cells);
    }
    while cells.len() < n {
        let block = read_block(stream, n - cells.len())?;
        let parts = try_map(block.n_cells.div_ceil(CHUNK), &|i| {
            let part = block.part(self::block(block.n_cells, CHUNK, i));
            part.batch(nodes)
        })?;
        parts.iter().for_each(|part| part.add_to(&mut cells, tags));
    }
    Ok(cells)
}

/// Finds a binary block of version 2, of at most `left` elements.
fn read_block<'a>(stream: &mut Stream<'a>, left: usize) -> Result<Block<'a>> {
    let number = stream.int("an element type")?;
    let of = kinds::element_type(number.into()).map_err(|why| stream.error(why))?;
    let n_cells = stream.int("the number of elements in a block")?;
    let n_tags = stream.int("the number of tags")?;
    let n_cells = usize::try_from(n_cells).unwrap_or(0);
    if !(1..=left).contains(&n_cells) {
        return Err(stream.error(format!(
            "the number of elements in a block is wrong: it must be 1 to {left}, those that are left"
        )));
    }
    let n_tags = usize::try_from(n_tags).map_err(|_| {
        let message = "which is out of range";
        stream.error(format!("a block of elements has {n_tags} tags, {message}"))
    })?;
    Block::read(stream, of, 0, n_cells, n_tags)
}

/// Reads one line. Version 1: number, type, physical group, entity, number of nodes, nodes. Version 2:
/// number, type, number of tags, tags, nodes.
fn parse_element(
    line: &mut Tokens,
    version: Version,
    nodes: &Index,
    part: &mut Batch,
) -> Result<()> {
    let number = line.integer("an element number")?;
    let of = line.integer("an element type")?;
    let of = kinds::element_type(of).map_err(|why| line.error(why))?;
    let mut tags = [0; 4];
    let mut n_tags = 2;
    if version == Version::V1 {
        tags[0] = line.narrow("a physical group")?;
        tags[1] = line.narrow("an entity")?;
        let found = line.integer("the number of nodes")?;
        if found != of.n_nodes as i64 {
            return Err(line.error(wrong_count(of, found)));
        }
    } else {
        n_tags = line.narrow("the number of tags")?;
        for i in 0..n_tags {
            let tag = line.narrow("a tag")?;
            if let Some(known) = tags.get_mut(i) {
                *known = tag;
            }
        }
    }
    let added = part.add(of, number, n_tags, tags);
    added.map_err(|why| line.error(why))?;
    let known = part.connectivity.len();
    part.connectivity.resize(known + of.n_nodes, 0);
    parse_nodes(line, of, nodes, &mut part.connectivity[known..])
}

impl Batch {
    /// Adds an element with the first of its tags, without its nodes. Up to version 2.1 the third tag
    /// is the partition; later it is the number of partitions that follow.
    fn add(
        &mut self,
        of: &'static Type,
        number: i64,
        n_tags: usize,
        [physical, elementary, third, fourth]: [i32; 4],
    ) -> std::result::Result<(), String> {
        let physical = physical
            .checked_abs()
            .ok_or_else(|| format!("physical group {physical} is out of range"))?;
        let partition = if n_tags > 3 { fourth } else { third };
        let tags = [physical, elementary, partition];
        self.n_ghosts += usize::from(n_tags > 4 && third > 1);
        self.numbers.push(number);
        match self.runs.last_mut() {
            Some(run) if std::ptr::eq(run.of, of) && run.tags == tags => run.n_cells += 1,
            _ => {
                let n_cells = 1;
                self.runs.push(Run { of, tags, n_cells });
            }
        }
        Ok(())
    }

    fn add_to(&self, cells: &mut Cells, tags: &mut Tags) {
        let mut rest = &self.connectivity[..];
        for run in &self.runs {
            let (own, tail) = rest.split_at(run.of.n_nodes * run.n_cells);
            let range = cells.len()..cells.len() + run.n_cells;
            let dimension = run.of.kind.dimension();
            let [physical, elementary, partition] = run.tags;
            tags.shared.add(dimension, elementary, physical);
            for (tagged, tag) in [
                (&mut tags.physical, physical),
                (&mut tags.elementary, elementary),
                (&mut tags.partition, partition),
            ] {
                if tag != 0 {
                    tagged.add(dimension, tag, range.clone());
                }
            }
            cells.push_run(run.of.kind, run.of.n_nodes, own);
            rest = tail;
        }
        tags.numbers.extend(&self.numbers);
        tags.n_ghosts += self.n_ghosts;
    }
}
