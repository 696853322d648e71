//! Which cells share each face, for whoever passes over all faces again and again.
//!
//! A face belongs to the first cell that has it, its owner, which knows the cell across it. Kept are
//! four bytes a face and two bits a side of a cell; where the nodes are does not matter.

use super::faces::{Entry, all_corners};
use super::sides::{for_each_side, side_corners};
use super::{CellKind, CellRun, Cells, Mesh};
use rayon::prelude::*;
use std::ops::Range;

/// Cells whose sides are compared among themselves first, and that one task passes over later.
const CHUNK: usize = 1 << 15;

/// The faces of the cells of a mesh's own dimension.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adjacency {
    chunks: Vec<Chunk>,
    n_inner: usize,
    n_outer: usize,
    n_cells: usize,
}

/// What lies across a side of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// The face belongs to a cell before this one, or the side has collapsed to an edge.
    Elsewhere,
    /// A cell further on, which shares the face.
    Cell(u32),
    /// No cell: an outer face, and the first boundary cell that lies on it.
    Outside(Option<u32>),
}

/// Sides of the cells of a chunk, in order.
#[derive(Debug, Clone, Default, PartialEq)]
struct Chunk {
    /// Two bits a side: one of the codes below.
    codes: Vec<u8>,
    /// Cell across each inner side, boundary cell on each outer one or `NONE`.
    across: Vec<u32>,
}

const ELSEWHERE: u8 = 0;
const INNER: u8 = 1;
const OUTER: u8 = 2;
/// While faces are still sought.
const OPEN: u8 = 3;

const NONE: u32 = u32::MAX;

/// The sides of a chunk's cells, one after another as [`for_each_side`] has them.
#[derive(Debug, Clone)]
pub struct Sides<'a> {
    codes: &'a [u8],
    across: std::slice::Iter<'a, u32>,
    at: usize,
}

impl Sides<'_> {
    /// What lies across the next side.
    ///
    /// # Panics
    /// After the last side of the chunk.
    #[inline]
    pub fn across(&mut self) -> Across {
        let code = code_at(self.codes, self.at);
        self.at += 1;
        if code == ELSEWHERE {
            return Across::Elsewhere;
        }
        let found = *self.across.next().expect("a face has an entry");
        match code {
            INNER => Across::Cell(found),
            _ => Across::Outside((found != NONE).then_some(found)),
        }
    }
}

#[inline]
fn code_at(codes: &[u8], side: usize) -> u8 {
    codes[side >> 2] >> (2 * (side & 3)) & 3
}

impl Chunk {
    fn push(&mut self, side: usize, code: u8, across: u32) {
        if side.is_multiple_of(4) {
            self.codes.push(0);
        }
        self.codes[side >> 2] |= code << (2 * (side & 3));
        if matches!(code, INNER | OUTER) {
            self.across.push(across);
        }
    }
}

impl Adjacency {
    /// Pairs the sides of all cells of the mesh's dimension; a mesh of lines or vertices has no faces.
    ///
    /// Of a face that more than two cells have, the cells pair up in their order, and one that is left
    /// has an outer face. Time and memory grow with the number of cells: beside what is kept,
    /// 12 to 24 bytes for each side whose other cell is more than 32,768 cells away.
    pub fn of(mesh: &Mesh) -> Self {
        let dimension = mesh.dimension();
        let n_cells = mesh.cells.len();
        if dimension < 2 {
            return Self {
                n_cells,
                ..Self::default()
            };
        }
        let drafts: Vec<(Chunk, Vec<Open>)> = (0..n_cells.div_ceil(CHUNK))
            .into_par_iter()
            .map_init(Desk::default, |desk, chunk| {
                desk.draft(mesh, dimension, range(chunk, n_cells))
            })
            .collect();
        let mut open = boundary_cells(mesh, dimension);
        open.reserve_exact(drafts.iter().map(|(_, open)| open.len()).sum());
        let take = |(chunk, own): (Chunk, Vec<Open>)| {
            open.extend(own);
            chunk
        };
        let drafts: Vec<Chunk> = drafts.into_iter().map(take).collect();
        settle_all(&mesh.cells, &mut open);
        let chunks: Vec<Chunk> = drafts
            .into_par_iter()
            .enumerate()
            .map(|(chunk, draft)| {
                let cells = range(chunk, n_cells);
                let from = open.partition_point(|open| (open.cell as usize) < cells.start);
                finish(draft, open[from..].iter())
            })
            .collect();
        let count = |wanted: u8| {
            let of = |chunk: &Chunk| {
                (0..4 * chunk.codes.len())
                    .filter(|&i| code_at(&chunk.codes, i) == wanted)
                    .count()
            };
            chunks.par_iter().map(of).sum()
        };
        let n_inner = count(INNER);
        Self {
            n_outer: chunks.iter().map(|chunk| chunk.across.len()).sum::<usize>() - n_inner,
            n_inner,
            chunks,
            n_cells,
        }
    }

    /// Faces between two cells.
    pub fn n_inner(&self) -> usize {
        self.n_inner
    }

    /// Faces of one cell.
    pub fn n_outer(&self) -> usize {
        self.n_outer
    }

    /// Number of chunks: the cells are passed over chunk by chunk.
    pub fn n_chunks(&self) -> usize {
        self.chunks.len()
    }

    /// The cells of a chunk, and the sides of those that have the mesh's dimension.
    pub fn chunk(&self, chunk: usize) -> (Range<usize>, Sides<'_>) {
        let Chunk { codes, across } = &self.chunks[chunk];
        let sides = Sides {
            codes,
            across: across.iter(),
            at: 0,
        };
        (range(chunk, self.n_cells), sides)
    }

    /// Bytes that those of a mesh will hold, before it is made: outer faces count as half.
    pub fn estimate_bytes(mesh: &Mesh) -> usize {
        let n_sides = |run: CellRun<'_>| match run.kind {
            CellKind::Polyhedron => {
                let cells = run.first_cell..run.first_cell + run.n_cells();
                let stream = |cell| mesh.cells.face_stream(cell).unwrap_or(&[]);
                cells
                    .map(|cell| stream(cell).first().map_or(0, |n| *n as usize))
                    .sum()
            }
            CellKind::Polygon | CellKind::QuadraticPolygon => {
                run.n_cells() * run.kind.n_corners(run.n_nodes)
            }
            kind => run.n_cells() * kind.faces().len(),
        };
        let n_sides: usize = mesh.volume_runs().map(n_sides).sum();
        2 * n_sides + n_sides / 4
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        let of = |chunk: &Chunk| chunk.codes.len() + 4 * chunk.across.len();
        self.chunks.iter().map(of).sum()
    }
}

fn range(chunk: usize, n_cells: usize) -> Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(n_cells)
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

fn hash(entry: &Entry) -> u64 {
    let (corners, size) = entry.key();
    let mixed = (corners as u64 ^ u64::from(size)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed =
        (mixed.rotate_left(29) ^ (corners >> 64) as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed ^ mixed >> 31
}

/// What one task works with.
#[derive(Default)]
struct Desk {
    entries: Vec<Entry>,
    /// For each entry: the cell across, or one of the marks below.
    across: Vec<u32>,
    slots: Vec<u32>,
}

/// Marks beside indices of cells, which are smaller.
const SOUGHT: u32 = u32::MAX;
const NOT_MINE: u32 = u32::MAX - 1;
/// Marks in slots beside places of entries.
const FREE: u32 = u32::MAX;
const USED: u32 = u32::MAX - 1;

impl Desk {
    /// Pairs the sides of some cells among themselves; those left are open.
    fn draft(&mut self, mesh: &Mesh, dimension: u8, cells: Range<usize>) -> (Chunk, Vec<Open>) {
        self.entries.clear();
        self.across.clear();
        let least = usize::from(dimension);
        for run in mesh.cells.runs_in(cells) {
            if run.kind.dimension() != dimension {
                continue;
            }
            for cell in run.cell_refs() {
                for_each_side(&mesh.cells, &cell, |face, corners| {
                    let entry = Entry::new(corners, least, cell.index, face as u32);
                    self.across.push(entry.map_or(NOT_MINE, |_| SOUGHT));
                    self.entries.push(entry.unwrap_or(Entry::COLLAPSED));
                });
            }
        }
        self.pair(&mesh.cells);
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
fn is_same(cells: &Cells, a: &Entry, b: &Entry) -> bool {
    a.key() == b.key()
        && a.cell != b.cell
        && (a.size() <= 4 || all_corners(cells, a) == all_corners(cells, b))
}

fn boundary_cells(mesh: &Mesh, dimension: u8) -> Vec<Open> {
    let entries = super::faces::boundary_cells(mesh, dimension);
    entries.iter().map(Open::new).collect()
}

/// Pairs what is open and sorts it by cell and side, without the boundary cells.
fn settle_all(cells: &Cells, open: &mut Vec<Open>) {
    open.par_sort_unstable_by_key(|open| (open.value, open.cell, open.face_and_code));
    open.par_chunk_by_mut(|a, b| a.value == b.value)
        .for_each(|alike| settle(cells, alike));
    open.retain(|open| !open.is_boundary());
    open.par_sort_unstable_by_key(|open| (open.cell, open.face_and_code));
}

/// Pairs sides of equal hash, which are few.
fn settle(cells: &Cells, alike: &mut [Open]) {
    let entries: Vec<Entry> = alike.iter().map(|open| entry(cells, open)).collect();
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
fn entry(cells: &Cells, open: &Open) -> Entry {
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

#[cfg(test)]
mod tests {
    use super::super::Faces;
    use super::*;

    /// Cell, side, what lies across.
    fn listed(mesh: &Mesh) -> Vec<(usize, usize, Across)> {
        let adjacency = Adjacency::of(mesh);
        let mut found = Vec::new();
        for chunk in 0..adjacency.n_chunks() {
            let (cells, mut sides) = adjacency.chunk(chunk);
            for cell in cells.map(|cell| mesh.cells.get(cell)) {
                if cell.kind.dimension() == mesh.dimension() {
                    for_each_side(&mesh.cells, &cell, |side, _| {
                        found.push((cell.index, side, sides.across()));
                    });
                }
            }
        }
        found
    }

    fn with_points(n: usize) -> Mesh {
        Mesh {
            points: vec![[0.0; 3]; n],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_face_belongs_to_its_first_cell_and_knows_the_other_and_what_lies_on_it() {
        let mut mesh = with_points(6);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        mesh.cells.push(CellKind::Triangle, &[2, 1, 0]);
        mesh.cells.push(CellKind::Triangle, &[3, 2, 1]);
        mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
        let outside = Across::Outside(None);
        let wanted = [
            (0, 0, outside),
            (0, 1, Across::Cell(3)),
            (0, 2, outside),
            (0, 3, Across::Outside(Some(1))),
            (3, 0, outside),
            (3, 1, outside),
            (3, 2, outside),
            (3, 3, Across::Elsewhere),
        ];
        assert_eq!(listed(&mesh), wanted);
    }

    #[test]
    fn polyhedra_meet_and_collapsed_sides_are_no_faces() {
        let mut mesh = with_points(12);
        let hexagons = [
            2, 6, 0, 1, 2, 3, 4, 5, 3, 0, 1, 6, //
        ];
        let other = [2, 6, 5, 4, 3, 2, 1, 0, 3, 0, 1, 7];
        let unlike = [1, 6, 0, 1, 2, 3, 4, 8];
        for stream in [&hexagons[..], &other, &unlike] {
            mesh.cells.push_polyhedron(stream).expect("a good stream");
        }
        mesh.cells
            .push(CellKind::Hexahedron, &[0, 1, 2, 2, 8, 9, 10, 10]);
        let found = listed(&mesh);
        assert_eq!(found[0], (0, 0, Across::Cell(1)));
        assert_eq!(found[2].2, Across::Elsewhere);
        assert_eq!(found[4], (2, 0, Across::Outside(None)));
        let collapsed = found.iter().filter(|side| side.0 == 3);
        let collapsed = collapsed.filter(|side| side.2 == Across::Elsewhere);
        assert_eq!(collapsed.count(), 1);
    }

    /// Cells of a grid of squares in an order that leaves no neighbours in one chunk.
    #[test]
    fn cells_far_apart_in_the_file_find_each_other() {
        let (n, m) = (200usize, 200usize);
        let mut mesh = with_points((n + 1) * (m + 1));
        let mut order: Vec<usize> = (0..n * m).collect();
        order.sort_by_key(|&cell| (cell.wrapping_mul(0x9e37_79b9) & 0xffff, cell));
        for &cell in &order {
            let (i, j) = (cell % n, cell / n);
            let a = (j * (n + 1) + i) as u32;
            let d = a + n as u32 + 1;
            mesh.cells
                .push(CellKind::Quadrilateral, &[a, a + 1, d + 1, d]);
        }
        let adjacency = Adjacency::of(&mesh);
        assert_eq!(adjacency.n_inner(), 2 * n * m - n - m);
        assert_eq!(adjacency.n_outer(), 2 * (n + m));
        assert_eq!(adjacency.n_outer(), Faces::of(&mesh).outer.len());
        for (cell, side, across) in listed(&mesh) {
            if let Across::Cell(other) = across {
                assert!(cell < other as usize);
                let (here, there) = (order[cell], order[other as usize]);
                let apart = [
                    here.wrapping_sub(n),
                    here + 1,
                    here + n,
                    here.wrapping_sub(1),
                ];
                assert_eq!(apart[side], there);
            }
        }
        let (bytes, foreseen) = (adjacency.memory_bytes(), Adjacency::estimate_bytes(&mesh));
        assert!(bytes.abs_diff(foreseen) < bytes / 50, "{bytes} {foreseen}");
    }
}
