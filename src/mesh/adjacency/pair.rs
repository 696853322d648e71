//! Pairing the sides of cells: each chunk's among themselves first, by a table of hashes, then those
//! left of all chunks, sorted by hash.

use super::super::Cells;
use super::super::faces::{self, Entry, all_corners};
use super::super::sides::{for_each_side, side_corners};
use super::{CHUNK, Chunk, ELSEWHERE, INNER, NONE, OUTER, code_at, range};
use crate::parallel::{BLOCK, for_items, map, map_items, sort_by_key};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Code of a side while its face is still sought.
const OPEN: u8 = 3;

/// The paired sides of all cells of the mesh's dimension, which is 2 or 3.
pub(super) fn chunks(cells: &Cells, dimension: u8) -> Vec<Chunk> {
    let n_cells = cells.len();
    let desks: Mutex<Vec<Desk>> = Mutex::default();
    let desks = || desks.lock().unwrap_or_else(PoisonError::into_inner);
    let drafts = map(n_cells.div_ceil(CHUNK), &|chunk| {
        let mut desk = desks().pop().unwrap_or_default();
        let draft = desk.draft(cells, dimension, range(chunk, n_cells));
        desks().push(desk);
        draft
    });
    let mut open = boundary_cells(cells, dimension);
    open.reserve_exact(drafts.iter().map(|(_, open)| open.len()).sum());
    let take = |(chunk, own): (Chunk, Vec<Open>)| {
        open.extend(own);
        chunk
    };
    let drafts: Vec<Chunk> = drafts.into_iter().map(take).collect();
    settle_all(cells, &mut open);
    map_items(drafts, &|chunk, draft| {
        let first = range(chunk, n_cells).start;
        let from = open.partition_point(|open| (open.cell as usize) < first);
        finish(draft, open[from..].iter())
    })
}

/// A side that no cell of its chunk shares, or a boundary cell.
#[derive(Clone, Copy)]
struct Open {
    /// Of its corners; later what [`Chunk::across`] holds.
    value: u32,
    cell: u32,
    /// Number of the side (24 bits; all set for a boundary cell) and its code (8 bits).
    face_and_code: u32,
}

const BOUNDARY: u32 = (1 << 24) - 1;

impl Open {
    fn new(entry: &Entry) -> Self {
        Self {
            value: (hash(entry) >> 32) as u32,
            cell: entry.cell,
            face_and_code: entry.face() << 8 | u32::from(OPEN),
        }
    }

    fn face(&self) -> u32 {
        self.face_and_code >> 8
    }

    fn code(&self) -> u8 {
        self.face_and_code as u8
    }

    fn is_boundary(&self) -> bool {
        self.face() == BOUNDARY
    }

    fn settle(&mut self, code: u8, value: u32) {
        self.face_and_code = self.face() << 8 | u32::from(code);
        self.value = value;
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
/// Marks in slots in place of positions of entries.
const FREE: u32 = u32::MAX;
const USED: u32 = u32::MAX - 1;

impl Desk {
    /// Pairs the sides of some cells among themselves; those left are open.
    fn draft(&mut self, cells: &Cells, dimension: u8, range: Range<usize>) -> (Chunk, Vec<Open>) {
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
                    self.across.push(entry.map_or(NOT_MINE, |_| SOUGHT));
                    self.entries.push(entry.unwrap_or(Entry::COLLAPSED));
                });
            }
        }
        self.pair(cells);
        let (mut chunk, mut open) = (Chunk::default(), Vec::new());
        for (side, (&across, entry)) in self.across.iter().zip(&self.entries).enumerate() {
            let code = match across {
                NOT_MINE => ELSEWHERE,
                SOUGHT => {
                    open.push(Open::new(entry));
                    OPEN
                }
                _ => INNER,
            };
            chunk.push(side, code, across);
        }
        chunk.codes.shrink_to_fit();
        chunk.across.shrink_to_fit();
        (chunk, open)
    }

    /// A side that finds its like in the table takes it out of there.
    fn pair(&mut self, cells: &Cells) {
        let n_slots = (2 * self.entries.len()).next_power_of_two();
        self.slots.clear();
        self.slots.resize(n_slots, FREE);
        for at in 0..self.entries.len() {
            if self.across[at] == NOT_MINE {
                continue;
            }
            let entry = self.entries[at];
            let mut slot = hash(&entry) as usize & (n_slots - 1);
            loop {
                match self.slots[slot] {
                    FREE => {
                        self.slots[slot] = at as u32;
                        break;
                    }
                    USED => {}
                    other if is_same(cells, &self.entries[other as usize], &entry) => {
                        self.across[other as usize] = entry.cell;
                        self.across[at] = NOT_MINE;
                        self.slots[slot] = USED;
                        break;
                    }
                    _ => {}
                }
                slot = (slot + 1) & (n_slots - 1);
            }
        }
    }
}

/// Whether two sides are one face of two cells.
#[inline]
fn is_same(cells: &Cells, a: &Entry, b: &Entry) -> bool {
    a.key() == b.key()
        && a.cell != b.cell
        && (a.size() <= 4 || all_corners(cells, a) == all_corners(cells, b))
}

fn boundary_cells(cells: &Cells, dimension: u8) -> Vec<Open> {
    let entries = faces::boundary_cells(cells, dimension);
    entries.iter().map(Open::new).collect()
}

/// Pairs what is open and sorts it by cell and side, without the boundary cells.
fn settle_all(cells: &Cells, open: &mut Vec<Open>) {
    sort_by_key(open, |open| (open.value, open.cell, open.face_and_code));
    for_items(whole_groups(open), &|_, open| {
        for alike in open.chunk_by_mut(|a, b| a.value == b.value) {
            settle(cells, alike);
        }
    });
    open.retain(|open| !open.is_boundary());
    sort_by_key(open, |open| (open.cell, open.face_and_code));
}

/// Blocks of sides that no hash is in two of.
fn whole_groups(mut open: &mut [Open]) -> Vec<&mut [Open]> {
    let mut blocks = Vec::new();
    while !open.is_empty() {
        let at = open.len().min(BLOCK);
        let hash = open[at - 1].value;
        let more = open[at..].iter().take_while(|open| open.value == hash);
        let (block, rest) = open.split_at_mut(at + more.count());
        blocks.push(block);
        open = rest;
    }
    blocks
}

/// Pairs sides of equal hash, which are few.
fn settle(cells: &Cells, alike: &mut [Open]) {
    let mut few = [Entry::COLLAPSED; 4];
    let mut many = Vec::new();
    let entries = if alike.len() <= few.len() {
        &mut few[..alike.len()]
    } else {
        many.resize(alike.len(), Entry::COLLAPSED);
        &mut many
    };
    for (entry, open) in entries.iter_mut().zip(alike.iter()) {
        *entry = entry_of(cells, open);
    }
    for at in 0..alike.len() {
        if alike[at].is_boundary() || alike[at].code() != OPEN {
            continue;
        }
        let is_other = |other: &usize| is_same(cells, &entries[at], &entries[*other]);
        let open = |other: &usize| !alike[*other].is_boundary() && alike[*other].code() == OPEN;
        if let Some(other) = (at + 1..alike.len()).filter(open).find(is_other) {
            let across = alike[other].cell;
            alike[at].settle(INNER, across);
            alike[other].settle(ELSEWHERE, NONE);
            continue;
        }
        let mut boundary = (0..alike.len()).filter(|&other| alike[other].is_boundary());
        let on_it = boundary.find(is_other);
        let on_it = on_it.map_or(NONE, |other| alike[other].cell);
        alike[at].settle(OUTER, on_it);
    }
}

/// The entry that an open side was made from.
fn entry_of(cells: &Cells, open: &Open) -> Entry {
    let cell = cells.get(open.cell as usize);
    let made = |corners: &[u32]| Entry::new(corners, 1, cell.index, open.face());
    let made = match open.is_boundary() {
        true => made(&cell.nodes[..cell.kind.n_corners(cell.nodes.len())]),
        false => side_corners(cells, &cell, open.face() as usize, made),
    };
    made.expect("an open side has corners")
}

/// The draft of a chunk with its open sides settled, which come in the order of the sides.
fn finish<'a>(draft: Chunk, mut open: impl Iterator<Item = &'a Open>) -> Chunk {
    let mut across = draft.across.iter();
    let mut done = Chunk {
        codes: Vec::with_capacity(draft.codes.len()),
        across: Vec::with_capacity(draft.across.len()),
    };
    for side in 0..4 * draft.codes.len() {
        match code_at(&draft.codes, side) {
            OPEN => {
                let open = open.next().expect("an open side is in the list");
                done.push(side, open.code(), open.value);
            }
            ELSEWHERE => done.push(side, ELSEWHERE, NONE),
            code => {
                let across = across.next().expect("a face has an entry");
                done.push(side, code, *across);
            }
        }
    }
    done.across.shrink_to_fit();
    done
}
