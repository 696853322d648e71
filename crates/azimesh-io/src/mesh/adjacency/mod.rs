//! Pairs of cells that share a face, for repeated loops over all faces.
//!
//! A face belongs to the first cell that has it, its owner, which stores the cell across it. Memory: four bytes per face
//! and two bits per side of a cell. Node positions do not matter.

mod pair;

use super::{CellKind, CellRun, Cells, Mesh, RankPart};
use azimesh_core::parallel::map;
use std::ops::Range;

/// Cells whose sides are compared among themselves first, and that one task passes over later.
const CHUNK: usize = 1 << 15;

/// The faces of the cells of a mesh's own dimension.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adjacency {
    chunks: Vec<Chunk>,
    n_inner: usize,
    n_outer: usize,
    cuts: Cuts,
    own_chunks: Range<usize>,
}

/// First cells of the chunks of a mesh, and the end of the last. The cells of a part that are in one chunk of the whole
/// mesh form a chunk, so that sides are paired in the same order.
#[derive(Debug, Clone, Default, PartialEq)]
struct Cuts(Vec<usize>);

impl Cuts {
    fn new(n_cells: usize, part: Option<&RankPart>) -> Self {
        let mut starts: Vec<usize> = match part {
            None => (0..n_cells).step_by(CHUNK).collect(),
            Some(part) => {
                let chunk = |cell: usize| part.cells[cell] as usize / CHUNK;
                let is_start = |&cell: &usize| cell == 0 || chunk(cell) != chunk(cell - 1);
                (0..n_cells).filter(is_start).collect()
            }
        };
        starts.push(n_cells);
        Self(starts)
    }

    fn n(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    fn range(&self, chunk: usize) -> Range<usize> {
        self.0[chunk]..self.0[chunk + 1]
    }

    /// The chunks of consecutive cells, which begin and end where chunks do.
    fn chunks(&self, cells: &Range<usize>) -> Range<usize> {
        let before = |cell: usize| self.0[..self.n()].partition_point(|&start| start < cell);
        before(cells.start)..before(cells.end)
    }
}

/// The neighbour across a side of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// The face belongs to a cell before this one, or the side has collapsed to an edge.
    Elsewhere,
    /// A cell further on, which shares the face.
    Cell(u32),
    /// No cell: an outer face, with its first boundary cell.
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

const NONE: u32 = u32::MAX;

/// The sides of a chunk's cells, one after another as `sides::for_each_side` has them.
#[derive(Debug, Clone)]
pub struct Sides<'a> {
    codes: &'a [u8],
    across: std::slice::Iter<'a, u32>,
    at: usize,
}

impl Sides<'_> {
    /// The neighbour across the next side.
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
        let found = *self.across.next().expect("one entry per face");
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
    /// has an outer face. Time and memory grow with the number of cells: in addition to what is kept,
    /// 17 bytes for each side whose other cell is more than 32,768 cells away.
    pub fn of(mesh: &Mesh) -> Self {
        Self::with_own(&mesh.cells, mesh.dimension(), mesh.part.as_deref())
    }

    /// [`Adjacency::of`] the cells of a mesh of this dimension.
    pub fn of_cells(cells: &Cells, dimension: u8) -> Self {
        Self::with_own(cells, dimension, None)
    }

    fn with_own(cells: &Cells, dimension: u8, part: Option<&RankPart>) -> Self {
        let cuts = Cuts::new(cells.len(), part);
        if dimension < 2 {
            return Self {
                cuts,
                ..Self::default()
            };
        }
        let chunks = pair::chunks(cells, dimension, &cuts);
        let all = 0..cells.len();
        let own_chunks = cuts.chunks(part.map_or(&all, |part| &part.own_cells));
        let own = &chunks[own_chunks.clone()];
        let count = |wanted: u8| {
            let of = |chunk: &Chunk| {
                (0..4 * chunk.codes.len())
                    .filter(|&i| code_at(&chunk.codes, i) == wanted)
                    .count()
            };
            map(own.len(), &|i| of(&own[i])).into_iter().sum()
        };
        let n_inner = count(INNER);
        Self {
            n_outer: own.iter().map(|chunk| chunk.across.len()).sum::<usize>() - n_inner,
            n_inner,
            chunks,
            cuts,
            own_chunks,
        }
    }

    /// Number of faces between two cells whose first cell is an own cell.
    pub fn n_inner(&self) -> usize {
        self.n_inner
    }

    /// Faces of one cell, which is an own one.
    pub fn n_outer(&self) -> usize {
        self.n_outer
    }

    /// Number of chunks: the cells are passed over chunk by chunk.
    pub fn n_chunks(&self) -> usize {
        self.chunks.len()
    }

    /// The chunks of the cells that this rank answers for.
    pub fn own_chunks(&self) -> Range<usize> {
        self.own_chunks.clone()
    }

    /// The cells of a chunk, and the sides of those that have the mesh's dimension.
    pub fn chunk(&self, chunk: usize) -> (Range<usize>, Sides<'_>) {
        let Chunk { codes, across } = &self.chunks[chunk];
        let sides = Sides {
            codes,
            across: across.iter(),
            at: 0,
        };
        (self.cuts.range(chunk), sides)
    }

    /// Estimates the bytes of the adjacency of a mesh before it is built. An outer face counts as half.
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

#[cfg(test)]
mod tests;
