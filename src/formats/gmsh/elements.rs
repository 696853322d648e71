//! `$Elements` of version 4.1: blocks of one type and one entity.

use super::super::lexer::Lines;
use super::groups::Tagged;
use super::kinds;
use super::nodes::{CHUNK, NodeIndex};
use super::stream::{Binary, Stream};
use crate::error::{Error, Result};
use crate::mesh::{CellKind, Cells};
use rayon::prelude::*;

/// Elements of one type in one entity.
struct Block<'a> {
    kind: CellKind,
    n_nodes: usize,
    n_cells: usize,
    body: Body<'a>,
}

enum Body<'a> {
    Text(Lines<'a>),
    /// Encoding, offset in the file, and the bytes.
    Binary(Binary, usize, &'a [u8]),
}

/// Reads all elements; `tagged` takes those of each entity.
pub(super) fn read41(stream: &mut Stream, nodes: &NodeIndex, tagged: &mut Tagged) -> Result<Cells> {
    let blocks = read_blocks(stream, tagged)?;
    let n_entries = blocks.iter().map(|block| block.n_nodes * block.n_cells);
    let mut connectivity = vec![0u32; n_entries.sum()];
    let mut rest = &mut connectivity[..];
    for block in &blocks {
        let (out, tail) = rest.split_at_mut(block.n_nodes * block.n_cells);
        block.fill(nodes, out)?;
        rest = tail;
    }
    let kinds = blocks
        .iter()
        .map(|block| (block.kind, block.n_nodes, block.n_cells));
    Ok(Cells::from_connectivity(connectivity, kinds))
}

/// Finds the blocks and makes sure that the file holds them whole.
fn read_blocks<'a>(stream: &mut Stream<'a>, tagged: &mut Tagged) -> Result<Vec<Block<'a>>> {
    let n_blocks = stream.size("the number of element blocks")?;
    let n_elements = stream.size("the number of elements")?;
    stream.size("the lowest element tag")?;
    stream.size("the highest element tag")?;
    let mut blocks = Vec::new();
    let mut n_cells = 0;
    for _ in 0..n_blocks {
        let dimension = stream.int("the dimension of an entity")?;
        let entity = stream.int("the tag of an entity")?;
        let number = stream.int("an element type")?;
        let kind = kinds::kind(number.into()).map_err(|why| stream.error(why))?;
        if dimension != i32::from(kind.dimension()) {
            return Err(stream.error(format!(
                "an entity of dimension {dimension} holds elements of type {number}, a {}",
                kind.name()
            )));
        }
        let block = read_block(stream, kind)?;
        tagged.add(kind.dimension(), entity, n_cells..n_cells + block.n_cells);
        n_cells += block.n_cells;
        if n_cells >= u32::MAX as usize {
            return Err(stream.error("at most 4294967294 elements are possible"));
        }
        blocks.push(block);
    }
    if n_cells != n_elements {
        return Err(stream.error(format!(
            "the blocks hold {n_cells} elements, but $Elements promises {n_elements}"
        )));
    }
    Ok(blocks)
}

fn read_block<'a>(stream: &mut Stream<'a>, kind: CellKind) -> Result<Block<'a>> {
    let n_cells = stream.size("the number of elements in a block")?;
    let n_nodes = kind.n_nodes().expect("Gmsh's kinds have a number of nodes");
    let body = match stream.binary {
        Some(binary) => {
            let start = stream.text.position();
            let each = binary.size_bytes * (1 + n_nodes);
            Body::Binary(binary, start, stream.take(n_cells, each, "the elements")?)
        }
        None => Body::Text(stream.lines(n_cells, "the elements")?),
    };
    Ok(Block {
        kind,
        n_nodes,
        n_cells,
        body,
    })
}

impl Block<'_> {
    /// Node indices of the block's cells in VTK's order.
    fn fill(&self, nodes: &NodeIndex, out: &mut [u32]) -> Result<()> {
        match &self.body {
            Body::Text(lines) => lines.parse_into(out, self.n_nodes, |line, cell| {
                line.integer("an element tag")?;
                parse_nodes(line, self.kind, nodes, cell)
            }),
            Body::Binary(binary, start, body) => {
                let each = binary.size_bytes * (1 + self.n_nodes);
                let results: Vec<Result<()>> = out
                    .par_chunks_mut(CHUNK * self.n_nodes)
                    .zip(body.par_chunks(CHUNK * each))
                    .enumerate()
                    .map(|(i, (out, body))| {
                        self.decode(*binary, body, nodes, out).map_err(|(at, tag)| {
                            let place = start + i * CHUNK * each + at;
                            unknown_node(self.kind, tag).byte(place as u64)
                        })
                    })
                    .collect();
                results.into_iter().collect()
            }
        }
    }

    /// Converts binary elements; an unknown node is given with its offset in `body`.
    fn decode(
        &self,
        binary: Binary,
        body: &[u8],
        nodes: &NodeIndex,
        out: &mut [u32],
    ) -> std::result::Result<(), (usize, i64)> {
        let width = binary.size_bytes;
        let each = width * (1 + self.n_nodes);
        let order = kinds::order(self.kind);
        for (i, (cell, element)) in out
            .chunks_exact_mut(self.n_nodes)
            .zip(body.chunks_exact(each))
            .enumerate()
        {
            for (node, bytes) in cell.iter_mut().zip(element[width..].chunks_exact(width)) {
                let tag = binary.size(bytes);
                *node = nodes.get(tag).ok_or((i * each, tag))?;
            }
            if let Some(order) = order {
                kinds::to_vtk(order, cell);
            }
        }
        Ok(())
    }
}

/// Reads the nodes that end an element's line.
pub(super) fn parse_nodes(
    line: &mut super::super::lexer::Fields,
    kind: CellKind,
    nodes: &NodeIndex,
    cell: &mut [u32],
) -> Result<()> {
    let n_nodes = cell.len();
    for (i, node) in cell.iter_mut().enumerate() {
        if line.is_done() {
            let name = kind.name();
            return Err(line.error(format!("a {name} needs {n_nodes} nodes, found {i}")));
        }
        let tag = line.integer("a node of an element")?;
        *node = nodes
            .get(tag)
            .ok_or_else(|| line.error(unknown_node(kind, tag).message))?;
    }
    if let Some(order) = kinds::order(kind) {
        kinds::to_vtk(order, cell);
    }
    line.end("an element")
}

/// The refusal of a node that `$Nodes` does not have.
pub(super) fn unknown_node(kind: CellKind, tag: i64) -> Error {
    Error::input(format!(
        "a {} has node {tag}, which is not among $Nodes",
        kind.name()
    ))
}
