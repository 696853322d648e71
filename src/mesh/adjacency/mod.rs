//! Which cells share each face, for repeated loops over all faces.
//!
//! A face belongs to the first cell that has it, its owner, which knows the cell across it. Kept are
//! four bytes a face and two bits a side of a cell; where the nodes are does not matter.

mod pair;

use super::{CellKind, CellRun, Cells, Mesh};
use crate::parallel::map;
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

/// The neighbour across a side of a cell.
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
    /// has an outer face. Time and memory grow with the number of cells: in addition to what is kept,
    /// 17 bytes for each side whose other cell is more than 32,768 cells away.
    pub fn of(mesh: &Mesh) -> Self {
        Self::of_cells(&mesh.cells, mesh.dimension())
    }

    /// [`Adjacency::of`] the cells of a mesh of this dimension.
    pub fn of_cells(cells: &Cells, dimension: u8) -> Self {
        let n_cells = cells.len();
        if dimension < 2 {
            return Self {
                n_cells,
                ..Self::default()
            };
        }
        let chunks = pair::chunks(cells, dimension);
        let count = |wanted: u8| {
            let of = |chunk: &Chunk| {
                (0..4 * chunk.codes.len())
                    .filter(|&i| code_at(&chunk.codes, i) == wanted)
                    .count()
            };
            map(chunks.len(), &|i| of(&chunks[i])).into_iter().sum()
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
    #[cfg(any(test, feature = "internals"))]
    pub fn memory_bytes(&self) -> usize {
        let of = |chunk: &Chunk| chunk.codes.len() + 4 * chunk.across.len();
        self.chunks.iter().map(of).sum()
    }
}

fn range(chunk: usize, n_cells: usize) -> Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(n_cells)
}

#[cfg(test)]
mod tests;
