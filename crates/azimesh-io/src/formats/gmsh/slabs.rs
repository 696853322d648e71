//! A binary file of version 4.1 by slabs: parts of its blocks of nodes and elements.

use super::super::slabs::{Refusal, Slabs, overlapping, points_of, whole};
use super::elements::{self, cells_of};
use super::groups::Tagged;
use super::index::Index;
use super::nodes::{self, Nodes, block_head, check_total};
use super::read::{Passed, complete, sections};
use super::stream::{Binary, Stream, Version};
use crate::formats::{Notes, ReadOptions};
use crate::mesh::{Cells, Mesh, too_many};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel::any;
use std::ops::Range;

type Found<T> = std::result::Result<T, Refusal>;

/// The blocks of a file that are not empty. The tags of its nodes count up.
#[derive(Default)]
struct Blocks<'a> {
    bytes: &'a [u8],
    options: ReadOptions,
    nodes: Vec<(Range<usize>, nodes::Block<'a>)>,
    first_node: i64,
    n_parametric: usize,
    /// End of the section of nodes.
    end: Option<usize>,
    elements: Vec<elements::Block<'a>>,
}

/// Finds the blocks of a file.
pub(super) fn open<'a>(bytes: &'a [u8], options: &ReadOptions) -> Found<impl Slabs + use<'a>> {
    let mut blocks = Blocks {
        bytes,
        options: options.clone(),
        ..Blocks::default()
    };
    let stream = sections(bytes, |name, stream| {
        let Some(binary) = stream.binary.filter(|_| stream.version == Version::V41) else {
            return Err(whole("it is not in binary MSH 4.1"));
        };
        match name {
            b"Nodes" if blocks.end.is_none() => blocks.find_nodes(stream, binary)?,
            b"Nodes" => return Err(whole("it has several sections of nodes")),
            b"ParametricNodes" => return Err(whole("it has $ParametricNodes")),
            b"Elements" if blocks.end.is_none() => {
                return Err(whole("$Elements comes before $Nodes"));
            }
            b"Elements" => {
                blocks.elements = elements::read_blocks(stream, &mut Tagged::default())?;
                blocks.elements.retain(|block| !block.cells().is_empty());
                return Ok(Passed::Last);
            }
            _ => return Ok(Passed::Over),
        }
        Ok(Passed::Read)
    })?;
    if blocks.end.is_none() {
        return Err(stream.error("the file has no $Nodes").into());
    }
    Ok(blocks)
}

impl<'a> Blocks<'a> {
    fn find_nodes(&mut self, stream: &mut Stream<'a>, binary: Binary) -> Found<()> {
        let (n_blocks, n_nodes) = stream.block_counts("node")?;
        for _ in 0..n_blocks {
            let (n, n_parameters) = block_head(stream)?;
            let block = nodes::Block::read(stream, binary, n, n_parameters)?;
            if n == 0 {
                continue;
            }
            let known = self.n_nodes();
            if known == 0 {
                self.first_node = block.tag(0);
            }
            let number = |i| self.first_node.checked_add((known + i) as i64);
            if any(n, |i| Some(block.tag(i)) != number(i)) {
                return Err(whole("the tags of its nodes do not count up"));
            }
            self.nodes.push((known..known + n, block));
            self.n_parametric += if n_parameters > 0 { n } else { 0 };
        }
        check_total(stream, self.n_nodes(), n_nodes)?;
        if n_nodes >= u32::MAX as usize {
            return Err(stream.error(too_many("nodes")).into());
        }
        self.end = Some(stream.text.position());
        Ok(())
    }
}

impl Slabs for Blocks<'_> {
    fn n_nodes(&self) -> usize {
        self.nodes.last().map_or(0, |(nodes, _)| nodes.end)
    }

    fn n_cells(&self) -> usize {
        self.elements.last().map_or(0, |last| last.cells().end)
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        let of_block = |(nodes, _): &(Range<usize>, nodes::Block)| nodes.clone();
        points_of(&self.nodes, of_block, nodes, |block, own, out| {
            block.1.points(own, out)
        })
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let parts = overlapping(&self.elements, elements::Block::cells, cells);
        let parts: Vec<_> = parts.map(|(block, own)| block.part(own)).collect();
        let nodes = Index::Consecutive {
            first: self.first_node,
            n: self.n_nodes() as u64,
        };
        Ok(cells_of(&parts, &nodes)?.0)
    }

    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        let nodes = Nodes::counting_up(self.first_node, self.n_nodes(), self.n_parametric);
        let known = (nodes, self.end.unwrap_or(0));
        Ok(complete(self.bytes, known, mesh, &self.options, notes)?)
    }
}
