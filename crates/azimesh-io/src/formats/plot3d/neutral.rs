//! Neutral map files (.nmf): the sizes of the blocks, then a line for each part of a side with its type, and for
//! interfaces the part that it coincides with. A grid in a plane has the map of two such planes, or, from Construct2D, one of a
//! single plane with sides 1 to 4.

use super::super::tokens::Tokens;
use super::blocks::Block;
use crate::mesh::Cells;
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// A part of a side.
pub(super) struct Entry {
    /// Its type, `None` for an interface.
    pub name: Option<String>,
    /// The block, from 0.
    pub block: usize,
    pub faces: Cells,
}

/// The constant index of a side of this number, whether it is at its end, and the indices along which its ranges run.
fn side(number: i64, map: Map) -> Option<(usize, bool, [usize; 2])> {
    Some(match number {
        1..=4 if map == Map::OnePlane => {
            let across = usize::from(number > 2);
            (across, number % 2 == 0, [1 - across, 2])
        }
        _ if map == Map::OnePlane => return None,
        1 => (2, false, [0, 1]),
        2 => (2, true, [0, 1]),
        3 => (0, false, [1, 2]),
        4 => (0, true, [1, 2]),
        5 => (1, false, [2, 0]),
        6 => (1, true, [2, 0]),
        _ => return None,
    })
}

/// The parts of the sides of these blocks.
pub(super) fn parse(bytes: &[u8], blocks: &[Block]) -> Result<Vec<Entry>> {
    let mut lexer = Tokens::with_comments(bytes);
    let maps = check_sizes(&mut lexer, blocks)?;
    let blocks: Vec<(&Block, Map)> = blocks.iter().zip(maps).collect();
    let mut entries = Vec::new();
    while let Some(mut line) = next_line(&mut lexer) {
        let name = name(&mut line)?;
        let is_interface = name.replace('_', "-").eq_ignore_ascii_case("one-to-one");
        entries.push(Entry {
            name: (!is_interface).then_some(name),
            ..part(&mut line, &blocks)?
        });
        if is_interface {
            let other = part(&mut line, &blocks)?;
            entries.push(other);
        }
    }
    Ok(entries)
}

/// The next line with content; some files end lines, also empty ones, with a backslash.
fn next_line<'a>(lexer: &mut Tokens<'a>) -> Option<Tokens<'a>> {
    std::iter::from_fn(|| lexer.line()).find(|line| line.rest() != b"\\")
}

/// The type at the start of a line, between apostrophes or not.
fn name(line: &mut Tokens) -> Result<String> {
    let word = line.word().unwrap_or_default();
    let word = String::from_utf8_lossy(word);
    let name = word.trim_matches(['\'', '"']);
    if name.is_empty() {
        return Err(line.error("a line must begin with a type"));
    }
    Ok(name.to_owned())
}

/// The map that the file has of each block; refuses one of other blocks.
fn check_sizes(lexer: &mut Tokens, blocks: &[Block]) -> Result<Vec<Map>> {
    let ended = |lexer: &Tokens| lexer.error("the file ends before the sizes of its blocks do");
    let mut line = next_line(lexer).ok_or_else(|| ended(lexer))?;
    let n: usize = line.narrow("the number of blocks")?;
    if n != blocks.len() {
        return Err(line.error(format!(
            "it is for {n} blocks; the grid has {}",
            blocks.len()
        )));
    }
    let mut maps = Vec::with_capacity(n);
    for (i, block) in blocks.iter().enumerate() {
        let mut line = next_line(lexer).ok_or_else(|| ended(lexer))?;
        let number: usize = line.narrow("the number of a block")?;
        let mut sizes = [0usize; 3];
        for size in &mut sizes {
            *size = line.narrow("a number of nodes")?;
        }
        let of_plane = || [Map::OnePlane, Map::TwoPlanes].into_iter();
        let map = match block.grid.n_indices {
            3 => Some(Map::Space),
            2 if block.has_sides() => of_plane().find(|map| map.nodes(block) == sizes),
            _ => None,
        };
        let [a, b, c] = block.grid.nodes;
        let is_same = map.is_some_and(|map| map.nodes(block) == sizes);
        if number != i + 1 || !(is_same || sizes == block.grid.nodes) {
            return Err(line.error(format!(
                "block {number} has {} x {} x {} nodes; block {} of the grid has {a} x {b} x {c}",
                sizes[0],
                sizes[1],
                sizes[2],
                i + 1
            )));
        }
        maps.push(map.ok_or_else(|| {
            line.error(format!(
                "block {number} has no cells in space; only sides of such blocks are named"
            ))
        })?);
    }
    Ok(maps)
}

/// The blocks that a map describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Map {
    Space,
    /// The grid's plane twice, as the first and second nodes along i: indices of the grid are j and k of the map.
    TwoPlanes,
    /// The grid's plane, with one node along k.
    OnePlane,
}

impl Map {
    /// Nodes of a block along the indices of the map.
    fn nodes(self, block: &Block) -> [usize; 3] {
        let [i, j, k] = block.grid.nodes;
        match self {
            Self::TwoPlanes => [2, i, j],
            Self::Space | Self::OnePlane => [i, j, k],
        }
    }
}

/// Block, side and ranges.
fn part(line: &mut Tokens, blocks: &[(&Block, Map)]) -> Result<Entry> {
    let number: usize = line.narrow("the number of a block")?;
    let i = number.wrapping_sub(1);
    let &(block, map) = blocks.get(i).ok_or_else(|| {
        let n = blocks.len();
        line.error(format!("there is no block {number}; the grid has {n}"))
    })?;
    let number = line.integer("the number of a side")?;
    let (across, is_end, along) = side(number, map).ok_or_else(|| {
        let most = if map == Map::OnePlane { 4 } else { 6 };
        line.error(format!("there is no side {number}; it must be 1 to {most}"))
    })?;
    let nodes = map.nodes(block);
    let mut ranges: [Range<usize>; 3] = [0..1, 0..1, 0..1];
    if is_end {
        ranges[across] = nodes[across] - 1..nodes[across];
    }
    for index in along {
        let ends: [usize; 2] = [line.narrow("an index")?, line.narrow("an index")?];
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let is_plane = nodes[index] == 1;
        if low < 1 || high > nodes[index] || (low == high) != is_plane {
            return Err(line.error(format!(
                "the range {} to {} does not fit {} nodes",
                ends[0], ends[1], nodes[index]
            )));
        }
        ranges[index] = low - 1..(high - 1).max(low);
    }
    let faces = match (map, across) {
        (Map::Space | Map::OnePlane, _) => block.faces(across, ranges),
        (Map::TwoPlanes, 0) => Cells::new(),
        (Map::TwoPlanes, _) => {
            let [_, i, j] = ranges;
            block.faces(across - 1, [i, j, 0..1])
        }
    };
    let (name, block) = (None, i);
    Ok(Entry { name, block, faces })
}

/// Refuses parts that do not cover each face of the sides once.
pub(super) fn check_whole(entries: &[Entry], blocks: &[Block]) -> Result<()> {
    for (i, block) in blocks.iter().enumerate() {
        let mut named: Vec<Vec<u32>> = Vec::new();
        for entry in entries.iter().filter(|entry| entry.block == i) {
            named.extend(entry.faces.iter().map(|face| face.nodes.to_vec()));
        }
        let n = named.len();
        named.iter_mut().for_each(|nodes| nodes.sort_unstable());
        named.sort_unstable();
        named.dedup();
        let n_sides: usize = block.sides().map(|(_, faces)| faces.len()).sum();
        if named.len() != n_sides || n != n_sides {
            return Err(Error::input(format!(
                "its lines cover {n} faces of block {}, {} of them once; its sides have {n_sides}",
                i + 1,
                named.len()
            )));
        }
    }
    Ok(())
}
