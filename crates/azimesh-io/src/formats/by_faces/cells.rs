//! Cells from faces: which faces each cell has, and the cells in the order of the file, in blocks on all threads.

use super::faces::{Faces, FacesView, Label, Labels};
use super::{shapes, uniform};
use crate::mesh::{Cells, sides::flat};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::parallel::{for_items, map_blocks, n_threads};
use std::ops::Range;

/// In place of the neighbour of a face on the boundary.
pub(in crate::formats) const NONE: u32 = u32::MAX;
/// Faces of a block.
const FACES: usize = 1 << 14;
/// In the number of a face of a cell: it points into the cell. Faces have three nodes or more, of fewer than 2^32 in all.
pub(in crate::formats) const INWARD: u32 = 1 << 31;
/// Cells that one task puts together: few, so that their memory is used again from task to task.
const CELLS: usize = 1 << 12;
/// Tasks whose cells are held before they are appended.
const BATCH: usize = 64;
/// Parts of the cells whose faces are collected at once.
const PARTS: usize = 16;
/// Least number of parts whose faces are held at a time: a few, so that they take little memory.
const HELD: usize = 4;

/// Of a part of the cells, the ends of the lists of their faces with a 0 before them, and the lists.
type Part = (Vec<u32>, Vec<u32>);

/// The faces of each of some cells, ascending, with [`INWARD`].
struct CellFaces {
    cells: Range<usize>,
    /// Cells of a part.
    size: usize,
    parts: Vec<Part>,
}

impl CellFaces {
    /// Collects the faces of `cells`, in parts of `size`, in the memory of others.
    fn new(blocks: &Blocks, cells: Range<usize>, size: usize, mut parts: Vec<Part>) -> Self {
        let first = |i: usize| (cells.start + i * size).min(cells.end);
        parts.resize_with(cells.len().div_ceil(size), Part::default);
        let fill = |i, part: &mut Part| blocks.of_cells(first(i)..first(i + 1), part);
        for_items(&mut parts, &fill);
        Self { cells, size, parts }
    }

    /// The faces of a cell.
    fn get(&self, cell: usize) -> &[u32] {
        let cell = cell - self.cells.start;
        let (ends, faces) = &self.parts[cell / self.size];
        let cell = cell % self.size;
        &faces[ends[cell] as usize..ends[cell + 1] as usize]
    }
}

/// The cells on both sides of all faces, and those that blocks of faces belong to, so that faces of other cells are passed
/// over.
pub(in crate::formats) struct Blocks<'a> {
    pub owner: &'a [Label],
    /// Of the faces between two cells, which are the first.
    pub neighbour: &'a [Label],
    of_owner: Vec<Range<u32>>,
    of_neighbour: Vec<Range<u32>>,
}

impl<'a> Blocks<'a> {
    pub fn new(owner: &'a [Label], neighbour: &'a [Label]) -> Self {
        // Bounds rather than options: so the loop over a block takes many labels at a time.
        let span = |cells: &[Label]| {
            let cells = cells.iter().map(|cell| cell.get());
            let low = cells.clone().fold(u32::MAX, u32::min);
            low..cells.fold(0, u32::max) + 1
        };
        let spans = |cells: &[Label]| map_blocks(cells.len(), FACES, &|range| span(&cells[range]));
        Self {
            of_owner: spans(owner),
            of_neighbour: spans(neighbour),
            owner,
            neighbour,
        }
    }

    /// The lists of these cells.
    fn of_cells(&self, cells: Range<usize>, (ends, faces): &mut Part) {
        // The end of a list is where the next face of the cell before it goes, until that has all of its faces.
        let n = cells.len();
        ends.clear();
        ends.resize(n + 2, 0);
        self.visit(&cells, |cell, _| ends[cell + 2] += 1);
        for i in 1..ends.len() {
            ends[i] += ends[i - 1];
        }
        faces.resize(ends[n + 1] as usize, 0);
        self.visit(&cells, |cell, face| {
            faces[ends[cell + 1] as usize] = face;
            ends[cell + 1] += 1;
        });
        ends.pop();
    }

    /// Calls `act(cell, face)` for the sides of these cells, counted from the first of them, in the order of the faces;
    /// the face with [`INWARD`].
    pub fn visit(&self, cells: &Range<usize>, mut act: impl FnMut(usize, u32)) {
        let (owner, neighbour) = (self.owner, self.neighbour);
        let (first, n) = (cells.start as u32, cells.len() as u32);
        let touches = |span: Option<&Range<u32>>| {
            span.is_some_and(|span| (span.start as usize) < cells.end && span.end > first)
        };
        for (block, span) in self.of_owner.iter().enumerate() {
            let of_neighbour = touches(self.of_neighbour.get(block));
            if !of_neighbour && !touches(Some(span)) {
                continue;
            }
            let faces = block * FACES..owner.len().min((block + 1) * FACES);
            for face in faces {
                let owner = owner[face].get().wrapping_sub(first);
                if owner < n {
                    act(owner as usize, face as u32);
                }
                if let Some(neighbour) = neighbour.get(face) {
                    let neighbour = neighbour.get().wrapping_sub(first);
                    if neighbour < n {
                        act(neighbour as usize, face as u32 | INWARD);
                    }
                }
            }
        }
    }
}

/// The cells of the mesh, then the faces on its boundary as cells. Messages count cells from `first`.
pub(in crate::formats) fn assemble(
    faces: &Faces,
    owner: &Labels,
    neighbour: &Labels,
    n_cells: usize,
    first: usize,
) -> Result<Cells> {
    let blocks = Blocks::new(owner.view(), neighbour.view());
    uniform::assemble(&blocks, faces.view(), n_cells)
        .map_or_else(|| one_by_one(&blocks, faces.view(), n_cells, first), Ok)
}

/// [`assemble`] of cells of any kind, each found from its own faces.
pub(in crate::formats) fn one_by_one(
    blocks: &Blocks,
    faces: FacesView,
    n_cells: usize,
    first_number: usize,
) -> Result<Cells> {
    let size = n_cells.div_ceil(PARTS).max(1);
    let n_held = size * n_threads().max(HELD);
    let (mut cells, mut parts) = (Cells::new(), Vec::new());
    for first in (0..n_cells).step_by(n_held) {
        let held = first..n_cells.min(first + n_held);
        let of_cells = CellFaces::new(blocks, held.clone(), size, parts);
        in_batches(held, n_cells, &mut cells, &|range| {
            let (mut part, mut stream) = (Cells::new(), Vec::new());
            for cell in range {
                let found = of_cells.get(cell);
                if found.len() < 4 {
                    return Err(Error::input(format!(
                        "cell {} has {}; it must have at least 4",
                        cell + first_number,
                        counted(found.len(), "face")
                    )));
                }
                shapes::push(&mut part, faces, found, &mut stream)?;
            }
            Ok(part)
        })?;
        parts = of_cells.parts;
    }
    drop(parts);
    let outside = blocks.neighbour.len()..faces.len();
    in_batches(outside, faces.len(), &mut cells, &|range| {
        let (mut part, mut scratch) = (Cells::new(), Vec::new());
        for face in range {
            scratch.clear();
            scratch.extend(faces.get(face).iter().map(|node| node.get()));
            part.push(flat(scratch.len()), &scratch);
        }
        Ok(part)
    })?;
    Ok(cells)
}

/// Appends the cells of a range; after the first batch reserves memory for the cells up to `last`.
fn in_batches(
    range: Range<usize>,
    last: usize,
    cells: &mut Cells,
    part: &(dyn Fn(Range<usize>) -> Result<Cells> + Sync),
) -> Result<()> {
    let mut start = range.start;
    let n_entries = cells.connectivity().len();
    while start < range.end {
        let end = range.end.min(start + BATCH * CELLS);
        let of_block = |block: Range<usize>| part(start + block.start..start + block.end);
        for part in map_blocks(end - start, CELLS, &of_block) {
            cells.append(&part?);
        }
        if start == range.start {
            // The others take about as much as the first.
            let first = cells.connectivity().len() - n_entries;
            cells.reserve(first / (end - start) * (last - end));
        }
        start = end;
    }
    Ok(())
}
