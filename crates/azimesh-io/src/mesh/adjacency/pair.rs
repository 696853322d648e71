//! Pairing the sides of cells: each chunk's among themselves first, then those left of all chunks, in parts by
//! their smallest corner, since cells with neighbouring nodes are mostly neighbours in the file. Both by a table of
//! hashes that stays in the cache.

use super::super::Cells;
use super::super::faces::{self, BOUNDARY, Entry, all_corners};
use super::super::sides::{for_each_side, side_corners};
use super::super::walls::{Walls, face_on_side};
use super::{Chunk, Cuts, ELSEWHERE, INNER, NONE, OUTER, code_at};
use azimesh_core::parallel::{Scratch, map, map_blocks, map_items};
use std::ops::Range;

/// Code of a side while its face is still sought.
const OPEN: u8 = 3;
/// Parts of the sides that are left, by their smallest corner.
const PARTS: usize = 64;

/// The paired sides of all cells of the mesh's dimension, which is 2 or 3.
pub(super) fn chunks(cells: &Cells, dimension: u8, cuts: &Cuts) -> Vec<Chunk> {
    let n_nodes = n_nodes(cells);
    let desks = Scratch::new(Desk::default);
    let boundary = faces::boundary_cells(cells, dimension);
    let walls = Walls::of(cells, &boundary);
    let drafts = map(cuts.n(), &|chunk| {
        desks.with(|desk| desk.draft(cells, &walls, dimension, cuts.range(chunk), n_nodes))
    });
    let boundary = Open::new(&boundary, n_nodes);
    let settled = map(PARTS, &|part| {
        desks.with(|desk| {
            desk.settle(
                cells,
                &walls,
                drafts.iter().map(|(_, open)| open.part(part)),
                boundary.part(part),
            )
        })
    });
    let mut first = [0; PARTS];
    let with_first = |(chunk, open): (Chunk, Open)| {
        let own = first;
        for part in 0..PARTS {
            first[part] += open.part(part).len();
        }
        (chunk, open.parts, own)
    };
    let drafts: Vec<_> = drafts.into_iter().map(with_first).collect();
    map_items(drafts, &|_, (draft, parts, mut at)| {
        finish(
            draft,
            parts.iter().map(|&part| {
                let part = usize::from(part);
                at[part] += 1;
                settled[part][at[part] - 1]
            }),
        )
    })
}

/// One more than the largest index of a node.
fn n_nodes(cells: &Cells) -> usize {
    let nodes = cells.connectivity();
    let largest = map_blocks(nodes.len(), 1 << 20, &|range| {
        nodes[range].iter().max().copied()
    });
    largest
        .into_iter()
        .flatten()
        .max()
        .map_or(0, |node| node as usize + 1)
}

/// Sides that no cell of their chunk shares, or boundary cells.
struct Open {
    /// Part of each, in order.
    parts: Vec<u8>,
    /// Cell and face of each, part by part, each in order.
    sides: Vec<[u32; 2]>,
    /// Starts of the parts, and the end of the last.
    starts: [u32; PARTS + 1],
}

impl Open {
    fn new(entries: &[Entry], n_nodes: usize) -> Self {
        let part_of = |entry: &Entry| (entry.smallest() as usize * PARTS / n_nodes) as u8;
        let parts: Vec<u8> = entries.iter().map(part_of).collect();
        let mut starts = [0; PARTS + 1];
        for &part in &parts {
            starts[usize::from(part) + 1] += 1;
        }
        for part in 0..PARTS {
            starts[part + 1] += starts[part];
        }
        let mut next = starts;
        let mut sides = vec![[0; 2]; entries.len()];
        for (entry, &part) in entries.iter().zip(&parts) {
            let next = &mut next[usize::from(part)];
            sides[*next as usize] = [entry.cell, entry.face()];
            *next += 1;
        }
        Self {
            parts,
            sides,
            starts,
        }
    }

    fn part(&self, part: usize) -> &[[u32; 2]] {
        &self.sides[self.starts[part] as usize..self.starts[part + 1] as usize]
    }
}

#[inline]
fn hash(entry: &Entry) -> u64 {
    let (corners, size) = entry.key();
    let mixed = (corners as u64 ^ u64::from(size)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed =
        (mixed.rotate_left(29) ^ (corners >> 64) as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed ^ mixed >> 31
}

/// Work space of one task.
#[derive(Default)]
struct Desk {
    entries: Vec<Entry>,
    /// For each entry: the cell across, or one of the marks below.
    across: Vec<u32>,
    slots: Vec<u32>,
}

/// Marks in place of indices of cells, which are smaller.
const SOUGHT: u32 = u32::MAX;
const NOT_MINE: u32 = u32::MAX - 1;
const ON_WALL: u32 = u32::MAX - 2;
/// Marks in slots in place of positions of entries.
const FREE: u32 = u32::MAX;
const USED: u32 = u32::MAX - 1;

/// The result for an open side: its code, and its entry in [`Chunk::across`].
type Settled = (u8, u32);

impl Desk {
    /// Pairs the sides of some cells among themselves; those left are open.
    fn draft(
        &mut self,
        cells: &Cells,
        walls: &Walls,
        dimension: u8,
        range: Range<usize>,
        n_nodes: usize,
    ) -> (Chunk, Open) {
        self.entries.clear();
        self.across.clear();
        let least = usize::from(dimension);
        for run in cells.runs_in(range) {
            if run.kind.dimension() != dimension {
                continue;
            }
            for cell in run.cell_refs() {
                for_each_side(cells, &cell, |face, corners| {
                    let entry = Entry::new(corners, least, cell.index, face as u32);
                    let mark = |entry: Entry| match walls.at(cells, &entry) {
                        Some(_) => ON_WALL,
                        None => SOUGHT,
                    };
                    self.across.push(entry.map_or(NOT_MINE, mark));
                    self.entries.push(entry.unwrap_or(Entry::COLLAPSED));
                });
            }
        }
        self.pair(cells);
        let (mut chunk, mut open) = (Chunk::default(), Vec::new());
        for (side, (&across, entry)) in self.across.iter().zip(&self.entries).enumerate() {
            let code = match across {
                NOT_MINE => ELSEWHERE,
                SOUGHT | ON_WALL => {
                    open.push(*entry);
                    OPEN
                }
                _ => INNER,
            };
            chunk.push(side, code, across);
        }
        chunk.codes.shrink_to_fit();
        chunk.across.shrink_to_fit();
        (chunk, Open::new(&open, n_nodes))
    }

    /// Pairs a part of the open sides of all chunks. A side without a partner gets the first boundary cell with its
    /// corners, if any, and one on a wall of no thickness the face that turns like it.
    fn settle<'a>(
        &mut self,
        cells: &Cells,
        walls: &Walls,
        open: impl Iterator<Item = &'a [[u32; 2]]>,
        boundary: &[[u32; 2]],
    ) -> Vec<Settled> {
        self.entries.clear();
        let entries = |open: &'a [[u32; 2]]| open.iter().map(|side| entry_of(cells, *side));
        self.entries.extend(open.flat_map(entries));
        self.across.clear();
        let on_wall = |entry: &Entry| walls.at(cells, entry).map_or(SOUGHT, |_| ON_WALL);
        self.across.extend(self.entries.iter().map(on_wall));
        self.pair(cells);
        let sides = self.across.iter().zip(&self.entries);
        let mut settled: Vec<Settled> = sides
            .map(|(&across, entry)| match across {
                NOT_MINE => (ELSEWHERE, NONE),
                SOUGHT => (OUTER, NONE),
                ON_WALL => {
                    let wall = walls.at(cells, entry).expect("it is on one");
                    let cell = cells.get(entry.cell as usize);
                    let own = |corners: &[u32]| face_on_side(cells, wall, corners);
                    (
                        OUTER,
                        side_corners(cells, &cell, entry.face() as usize, own),
                    )
                }
                across => (INNER, across),
            })
            .collect();
        for lying in boundary.iter().map(|side| entry_of(cells, *side)) {
            self.walk(cells, &lying, |_, at| {
                if settled[at] == (OUTER, NONE) {
                    settled[at].1 = lying.cell;
                }
                false
            });
        }
        settled
    }

    /// A side that finds its like in the table takes it out of there.
    fn pair(&mut self, cells: &Cells) {
        let n_slots = (2 * self.entries.len()).next_power_of_two();
        self.slots.clear();
        self.slots.resize(n_slots, FREE);
        for at in 0..self.entries.len() {
            if [NOT_MINE, ON_WALL].contains(&self.across[at]) {
                continue;
            }
            let entry = self.entries[at];
            let mut alike = None;
            let free = self.walk(cells, &entry, |slot, other| {
                alike = Some((slot, other));
                true
            });
            match alike {
                Some((slot, other)) => {
                    self.across[other] = entry.cell;
                    self.across[at] = NOT_MINE;
                    self.slots[slot] = USED;
                }
                None => self.slots[free] = at as u32,
            }
        }
    }

    /// Calls `is_last(slot, position)` for the entries in the table that are one face with `entry`, until it is so;
    /// gives the slot where it ended, free if it never was.
    #[inline(always)]
    fn walk(
        &self,
        cells: &Cells,
        entry: &Entry,
        mut is_last: impl FnMut(usize, usize) -> bool,
    ) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(entry) as usize & mask;
        loop {
            match self.slots[slot] {
                FREE => return slot,
                USED => {}
                other if !is_same(cells, &self.entries[other as usize], entry) => {}
                other if is_last(slot, other as usize) => return slot,
                _ => {}
            }
            slot = (slot + 1) & mask;
        }
    }
}

/// The entry that an open side or a boundary cell was made from.
#[inline]
fn entry_of(cells: &Cells, [cell, face]: [u32; 2]) -> Entry {
    let cell = cells.get(cell as usize);
    let made = |corners: &[u32]| Entry::new(corners, 1, cell.index, face);
    let made = match face {
        BOUNDARY => made(&cell.nodes[..cell.kind.n_corners(cell.nodes.len())]),
        _ => side_corners(cells, &cell, face as usize, made),
    };
    made.expect("an open side has corners")
}

/// Returns whether two sides are one face of two cells.
#[inline]
fn is_same(cells: &Cells, a: &Entry, b: &Entry) -> bool {
    a.key() == b.key()
        && a.cell != b.cell
        && (a.size() <= 4 || all_corners(cells, a) == all_corners(cells, b))
}

/// The draft of a chunk with its open sides settled, which come in the order of the sides.
fn finish(draft: Chunk, mut open: impl Iterator<Item = Settled>) -> Chunk {
    let mut across = draft.across.iter();
    let mut done = Chunk {
        codes: Vec::with_capacity(draft.codes.len()),
        across: Vec::with_capacity(draft.across.len()),
    };
    for side in 0..4 * draft.codes.len() {
        match code_at(&draft.codes, side) {
            OPEN => {
                let (code, across) = open.next().expect("an open side is in the list");
                done.push(side, code, across);
            }
            ELSEWHERE => done.push(side, ELSEWHERE, NONE),
            code => {
                let across = across.next().expect("one entry per face");
                done.push(side, code, *across);
            }
        }
    }
    done.across.shrink_to_fit();
    done
}
