//! A binary file of version 4.1 by slabs: parts of its blocks of nodes and elements.

use super::super::slabs::{Refusal, Slabs, overlapping, points_of, whole};
use super::elements::{self, Block, cells_of};
use super::groups::Tagged;
use super::index::Index;
use super::nodes::{self, Records, block_counts, block_head, check_total};
use super::read::{Passed, complete, sections};
use super::stream::{Binary, Stream, Version};
use crate::formats::{Notes, ReadOptions};
use crate::mesh::{Cells, Mesh, too_many};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel::any;
use std::ops::Range;

type Found<T> = std::result::Result<T, Refusal>;

/// The blocks of a file.
struct Blocks<'a> {
    bytes: &'a [u8],
    options: ReadOptions,
    nodes: Nodes<'a>,
    elements: Vec<Block<'a>>,
}

/// Nodes whose tags count up in the order of the file.
struct Nodes<'a> {
    blocks: Vec<(Range<usize>, Records<'a>)>,
    /// The tag of the first.
    first: i64,
    /// How many have parametric coordinates.
    n_parametric: usize,
    /// Where their section ends.
    end: usize,
}

/// Finds the blocks of a file.
pub(super) fn open<'a>(bytes: &'a [u8], options: &ReadOptions) -> Found<impl Slabs + use<'a>> {
    let (mut nodes, mut elements) = (None, None);
    let stream = sections(bytes, |name, version, stream| {
        let Some(binary) = stream.binary.filter(|_| version == Version::V41) else {
            return Err(whole("it is not in binary MSH 4.1"));
        };
        match name {
            b"Nodes" if nodes.is_none() => nodes = Some(Nodes::find(stream, binary)?),
            b"Nodes" => return Err(whole("it has several sections of nodes")),
            b"ParametricNodes" => return Err(whole("it has $ParametricNodes")),
            b"Elements" if nodes.is_none() => return Err(whole("$Elements comes before $Nodes")),
            b"Elements" => {
                elements = Some(find_elements(stream, version)?);
                return Ok(Passed::Last);
            }
            _ => return Ok(Passed::Over),
        }
        Ok(Passed::Read)
    })?;
    Ok(Blocks {
        bytes,
        options: options.clone(),
        nodes: nodes.ok_or_else(|| stream.error("the file has no $Nodes"))?,
        elements: elements.unwrap_or_default(),
    })
}

/// The blocks of elements that are not empty.
fn find_elements<'a>(stream: &mut Stream<'a>, version: Version) -> Result<Vec<Block<'a>>> {
    let mut blocks = elements::read_blocks(stream, version, &mut Tagged::default())?;
    blocks.retain(|block| !block.cells().is_empty());
    Ok(blocks)
}

impl<'a> Nodes<'a> {
    /// Finds the blocks of a section.
    fn find(stream: &mut Stream<'a>, binary: Binary) -> Found<Self> {
        let (n_blocks, n_nodes) = block_counts(stream, Version::V41)?;
        let mut blocks: Vec<(Range<usize>, Records)> = Vec::new();
        let (mut first, mut n_found, mut n_parametric) = (0, 0, 0);
        for _ in 0..n_blocks {
            let (n, n_parameters) = block_head(stream, Version::V41)?;
            let tags = stream.take(n, binary.size_bytes, "the node tags")?;
            let each = 24 + 8 * n_parameters;
            let records = Records {
                binary,
                start: stream.text.position(),
                each,
                before: 0,
                body: stream.take(n, each, "the nodes")?,
            };
            if n == 0 {
                continue;
            }
            if n_found == 0 {
                first = binary.size(&tags[..binary.size_bytes]);
            }
            if !count_up(tags, binary, first, n_found) {
                return Err(whole("the tags of its nodes do not count up"));
            }
            blocks.push((n_found..n_found + n, records));
            n_found += n;
            n_parametric += if n_parameters > 0 { n } else { 0 };
        }
        check_total(stream, n_found, n_nodes)?;
        if n_found >= u32::MAX as usize {
            return Err(stream.error(too_many("nodes")).into());
        }
        Ok(Self {
            blocks,
            first,
            n_parametric,
            end: stream.text.position(),
        })
    }

    fn index(&self) -> Index {
        Index::Consecutive {
            first: self.first,
            n: self.len() as u64,
        }
    }

    fn len(&self) -> usize {
        self.blocks.last().map_or(0, |(nodes, _)| nodes.end)
    }
}

/// Whether tags count up by one, those of all nodes from `first` on, of which `n_before` are before these.
fn count_up(tags: &[u8], binary: Binary, first: i64, n_before: usize) -> bool {
    let width = binary.size_bytes;
    !any(tags.len() / width, |i| {
        let expected = first.checked_add((n_before + i) as i64);
        Some(binary.size(&tags[i * width..][..width])) != expected
    })
}

impl Slabs for Blocks<'_> {
    fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    fn n_cells(&self) -> usize {
        self.elements.last().map_or(0, |last| last.cells().end)
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        let of_block = |(nodes, _): &(Range<usize>, Records)| nodes.clone();
        points_of(&self.nodes.blocks, of_block, nodes, |block, own, out| {
            block.1.points(own, out)
        })
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let parts = overlapping(&self.elements, Block::cells, cells);
        let parts: Vec<Block> = parts.filter_map(|(block, own)| block.part(own)).collect();
        Ok(cells_of(&parts, &self.nodes.index())?.0)
    }

    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        let nodes = &self.nodes;
        let known = nodes::Nodes::counting_up(nodes.first, nodes.len(), nodes.n_parametric);
        let known = (known, nodes.end);
        Ok(complete(self.bytes, known, mesh, &self.options, notes)?)
    }
}
