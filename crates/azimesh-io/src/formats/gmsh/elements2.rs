//! Elements of versions 1 to 3: each with its own type and tags.

use super::super::lexer::Fields;
use super::elements::{read_nodes, unknown_node};
use super::groups::{Shared, Tagged};
use super::index::{Index, Numbers};
use super::kinds::{self, Type};
use super::nodes::{CHUNK, count};
use super::stream::{Binary, Stream, Version};
use crate::mesh::too_many;
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{block, try_map};

/// Groups, entities, partitions and numbers of the elements.
#[derive(Debug, Default)]
pub(super) struct Tags {
    /// Cells by physical group.
    pub physical: Tagged,
    /// Cells by elementary entity.
    pub elementary: Tagged,
    /// Cells by partition; by dimension too, which does not matter.
    pub partition: Tagged,
    /// Elements of several partitions.
    pub n_ghosts: usize,
    /// Elements that may be there more than once.
    pub shared: Shared,
    /// Numbers of the elements.
    pub numbers: Numbers,
}

/// Consecutive elements, parsed by one task.
#[derive(Default)]
struct ElementBatch {
    connectivity: Vec<u32>,
    runs: Vec<Run>,
    numbers: Numbers,
    n_ghosts: usize,
}

/// Elements of one type with the same tags.
#[derive(Clone, Copy)]
struct Run {
    of: &'static Type,
    tags: ElementTags,
    n_cells: usize,
}

/// The tags of an element that are kept; 0 stands for none.
#[derive(Clone, Copy, PartialEq, Default)]
struct ElementTags {
    physical: i32,
    elementary: i32,
    partition: i32,
}

impl ElementBatch {
    /// Adds an element; returns the slots for its nodes.
    fn push(&mut self, of: &'static Type, number: i64, tags: ElementTags) -> &mut [u32] {
        self.numbers.push(number);
        match self.runs.last_mut() {
            Some(run) if std::ptr::eq(run.of, of) && run.tags == tags => run.n_cells += 1,
            _ => self.runs.push(Run {
                of,
                tags,
                n_cells: 1,
            }),
        }
        let known = self.connectivity.len();
        self.connectivity.resize(known + of.n_nodes, 0);
        &mut self.connectivity[known..]
    }
}

/// Reads all elements.
pub(super) fn read(
    stream: &mut Stream,
    version: Version,
    nodes: &Index,
    tags: &mut Tags,
) -> Result<Cells> {
    let n = count(stream, "the number of elements")?;
    if n >= u32::MAX as usize {
        return Err(stream.error(too_many("elements")));
    }
    let mut cells = Cells::new();
    match (stream.binary, version) {
        (None, _) => {
            let lines = stream.lines(n, "the elements")?;
            let parts = lines.parse(|line, part| parse_element(line, version, nodes, part))?;
            parts.iter().for_each(|part| part.add_to(&mut cells, tags));
        }
        (Some(binary), Version::V3) => {
            let part = read_v3(stream, binary, n, nodes)?;
            part.add_to(&mut cells, tags);
        }
        (Some(binary), _) => {
            let mut left = n;
            while left > 0 {
                let block = Block::read(stream, binary, left)?;
                left -= block.n_cells;
                let parts = block.parts(nodes)?;
                parts.iter().for_each(|part| part.add_to(&mut cells, tags));
            }
        }
    }
    Ok(cells)
}

impl ElementBatch {
    fn add_to(&self, cells: &mut Cells, tags: &mut Tags) {
        let mut rest = &self.connectivity[..];
        for run in &self.runs {
            let (own, tail) = rest.split_at(run.of.n_nodes * run.n_cells);
            let range = cells.len()..cells.len() + run.n_cells;
            let dimension = run.of.kind.dimension();
            let of = run.tags;
            tags.shared.add(dimension, of.elementary, of.physical);
            // 0 stands for an element without a tag.
            for (tagged, tag) in [
                (&mut tags.physical, of.physical),
                (&mut tags.elementary, of.elementary),
                (&mut tags.partition, of.partition),
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

/// One line. Version 1: number, type, physical group, entity, number of nodes, nodes. Version 2:
/// number, type, number of tags, tags, nodes. Version 3: number, type, entity, number of nodes and
/// what follows them, nodes, partitions.
fn parse_element(
    line: &mut Fields,
    version: Version,
    nodes: &Index,
    part: &mut ElementBatch,
) -> Result<()> {
    let element = line.integer("an element number")?;
    let number = line.integer("an element type")?;
    let of = kinds::element_type(number).map_err(|why| line.error(why))?;
    let mut tags = ElementTags::default();
    match version {
        Version::V1 => {
            tags.physical = line.narrow("a physical group")?;
            tags.elementary = line.narrow("an entity")?;
            check_count(of.kind, of.n_nodes, line.narrow("the number of nodes")?)
                .map_err(|why| line.error(why))?;
        }
        Version::V3 => {
            tags.elementary = line.narrow("an entity")?;
            line.integer("the number of nodes")?;
        }
        _ => {
            let n_tags: usize = line.narrow("the number of tags")?;
            let mut first = [0; 4];
            for i in 0..n_tags {
                let tag: i32 = line.narrow("a tag")?;
                if let Some(known) = first.get_mut(i) {
                    *known = tag;
                }
            }
            let (found, is_ghost) = version2_tags(n_tags, first);
            tags = found;
            part.n_ghosts += usize::from(is_ghost);
        }
    }
    tags.physical = positive(tags.physical).map_err(|why| line.error(why))?;
    if version != Version::V3 {
        read_nodes(line, of, nodes, part.push(of, element, tags))?;
        return line.end("an element");
    }
    // The partitions of version 3 come last.
    let mut cell = [0; 1000];
    let cell = &mut cell[..of.n_nodes];
    read_nodes(line, of, nodes, cell)?;
    if !line.is_done() {
        let n: usize = line.narrow("the number of partitions")?;
        for i in 0..n {
            let partition: i32 = line.narrow("a partition")?;
            if i == 0 {
                tags.partition = partition;
            }
        }
        part.n_ghosts += usize::from(n > 1);
    }
    part.push(of, element, tags).copy_from_slice(cell);
    line.end("an element")
}

/// Physical group, entity and partition from the first tags of version 2, and whether there are more
/// partitions. Up to 2.1 the third tag is the partition; later it is the number of partitions that follow.
fn version2_tags(
    n_tags: usize,
    [physical, elementary, third, fourth]: [i32; 4],
) -> (ElementTags, bool) {
    let tags = ElementTags {
        physical,
        elementary,
        partition: if n_tags > 3 { fourth } else { third },
    };
    (tags, n_tags > 4 && third > 1)
}

fn positive(physical: i32) -> std::result::Result<i32, String> {
    physical
        .checked_abs()
        .ok_or_else(|| format!("physical group {physical} is out of range"))
}

fn check_count(kind: CellKind, n_nodes: usize, found: i64) -> std::result::Result<(), String> {
    if found == n_nodes as i64 {
        return Ok(());
    }
    let name = kind.name();
    Err(format!("a {name} needs {n_nodes} nodes, found {found}"))
}

/// Binary elements of version 3, integers one after another as in its text.
fn read_v3(stream: &mut Stream, binary: Binary, n: usize, nodes: &Index) -> Result<ElementBatch> {
    let mut part = ElementBatch::default();
    for _ in 0..n {
        let start = stream.text.position() as u64;
        let head = stream.take(4, 4, "the elements")?;
        let head: [i32; 4] = std::array::from_fn(|i| binary.int(&head[4 * i..4 * i + 4]));
        let [element, number, elementary, n_data] = head;
        let wrong = |why: String| Error::input(why).byte(start);
        let of = kinds::element_type(number.into()).map_err(wrong)?;
        let n_data = usize::try_from(n_data).unwrap_or(0);
        if n_data < of.n_nodes {
            check_count(of.kind, of.n_nodes, n_data as i64).map_err(wrong)?;
        }
        let data = stream.take(n_data, 4, "the nodes of an element")?;
        let int = |i: usize| binary.int(&data[4 * i..4 * i + 4]);
        let mut tags = ElementTags {
            elementary,
            ..ElementTags::default()
        };
        if n_data > of.n_nodes + 1 {
            tags.partition = int(of.n_nodes + 1);
        }
        part.n_ghosts += usize::from(n_data > of.n_nodes + 2);
        let cell = part.push(of, element.into(), tags);
        for i in 0..of.n_nodes {
            let tag = i64::from(int(i));
            let node = nodes.get(tag);
            cell[of.vtk(i)] = node.ok_or_else(|| unknown_node(of.kind, tag).byte(start))?;
        }
    }
    Ok(part)
}

/// Binary elements of version 2, of one type with the same number of tags.
struct Block<'a> {
    binary: Binary,
    of: &'static Type,
    n_tags: usize,
    n_cells: usize,
    /// Offset of `body` in the file.
    start: usize,
    body: &'a [u8],
}

impl<'a> Block<'a> {
    fn read(stream: &mut Stream<'a>, binary: Binary, left: usize) -> Result<Self> {
        let number = stream.int("an element type")?;
        let of = kinds::element_type(number.into()).map_err(|why| stream.error(why))?;
        let n_cells = stream.int("the number of elements in a block")?;
        let n_tags = stream.int("the number of tags")?;
        let n_cells = usize::try_from(n_cells)
            .ok()
            .filter(|n| (1..=left).contains(n));
        let n_cells = n_cells.ok_or_else(|| {
            stream.error(format!(
                "the number of elements in a block is wrong: it must be 1 to {left}, those that are left"
            ))
        })?;
        let each = usize::try_from(n_tags)
            .ok()
            .and_then(|n| n.checked_add(1 + of.n_nodes)?.checked_mul(4))
            .ok_or_else(|| {
                stream.error(format!(
                    "a block of elements has {n_tags} tags, which is out of range"
                ))
            })?;
        let start = stream.text.position();
        Ok(Self {
            binary,
            of,
            n_tags: n_tags as usize,
            n_cells,
            start,
            body: stream.take(n_cells, each, "the elements")?,
        })
    }

    fn parts(&self, nodes: &Index) -> Result<Vec<ElementBatch>> {
        let each = 4 * (1 + self.n_tags + self.of.n_nodes);
        try_map(self.n_cells.div_ceil(CHUNK), &|i| {
            let cells = block(self.n_cells, CHUNK, i);
            let mut part = ElementBatch::default();
            part.connectivity.reserve(cells.len() * self.of.n_nodes);
            for cell in cells {
                let element = &self.body[cell * each..(cell + 1) * each];
                let decoded = self.decode(element, nodes, &mut part);
                decoded.map_err(|error| error.byte((self.start + cell * each) as u64))?;
            }
            Ok(part)
        })
    }

    fn decode(&self, element: &[u8], nodes: &Index, part: &mut ElementBatch) -> Result<()> {
        let int = |i: usize| self.binary.int(&element[4 * i..4 * i + 4]);
        let first = std::array::from_fn(|i| if i < self.n_tags { int(1 + i) } else { 0 });
        let (mut tags, is_ghost) = version2_tags(self.n_tags, first);
        tags.physical = positive(tags.physical).map_err(Error::input)?;
        part.n_ghosts += usize::from(is_ghost);
        let cell = part.push(self.of, int(0).into(), tags);
        for i in 0..self.of.n_nodes {
            let tag = i64::from(int(1 + self.n_tags + i));
            let node = nodes.get(tag);
            cell[self.of.vtk(i)] = node.ok_or_else(|| unknown_node(self.of.kind, tag))?;
        }
        Ok(())
    }
}
