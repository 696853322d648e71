//! Blocks: their cells, the faces of their sides, and which of these coincide with another side.

use super::super::grid::Grid;
use super::super::vtk::structured;
use crate::mesh::{Cells, too_many};
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::ops::Range;

/// Names of the sides: across which index, and whether at its end.
const SIDES: [(&str, usize, bool); 6] = [
    ("imin", 0, false),
    ("imax", 0, true),
    ("jmin", 1, false),
    ("jmax", 1, true),
    ("kmin", 2, false),
    ("kmax", 2, true),
];

/// A block, with the cells that it became.
pub(super) struct Block {
    pub grid: Grid,
    pub cells: Range<usize>,
}

pub(super) fn append(blocks: &[[usize; 3]], cells: &mut Cells) -> Result<Vec<Block>> {
    let mut first_node = 0;
    let mut found = Vec::new();
    for nodes in blocks {
        let n_cells = structured::n_cells(*nodes);
        if cells.len().saturating_add(n_cells) >= u32::MAX as usize {
            return Err(Error::input(too_many("cells")).byte(0));
        }
        let first = cells.len();
        structured::append(cells, *nodes, first_node as u32);
        let n_indices = nodes.iter().filter(|n| **n > 1).count();
        found.push(Block {
            grid: Grid::new(n_indices, *nodes, first_node),
            cells: first..cells.len(),
        });
        first_node += nodes.iter().product::<usize>();
    }
    Ok(found)
}

impl Block {
    /// Returns whether it has sides: its indices are the first ones, and as many as its cells have dimensions.
    pub fn has_sides(&self) -> bool {
        let n = self.grid.n_indices;
        n > 1 && self.grid.nodes[..n].iter().all(|n| *n > 1)
    }

    /// The sides: names with faces; none where it has no sides.
    pub fn sides(&self) -> impl Iterator<Item = (&'static str, Cells)> {
        let n_sides = if self.has_sides() {
            2 * self.grid.n_indices
        } else {
            0
        };
        SIDES[..n_sides].iter().map(|(name, across, is_end)| {
            let mut ranges = self.grid.cells.map(|n| 0..n);
            let last = self.grid.nodes[*across] - 1;
            ranges[*across] = if *is_end { last..last + 1 } else { 0..1 };
            (*name, self.faces(*across, ranges))
        })
    }

    /// The faces across an index whose lowest corners are in these ranges.
    pub fn faces(&self, across: usize, ranges: [Range<usize>; 3]) -> Cells {
        let mut faces = Cells::new();
        self.grid.append_faces(across, ranges, &mut faces);
        faces
    }
}

/// Places of the corners of a face, in order.
type Key = Vec<[u64; 3]>;

/// Number of faces of sides at each position.
pub(super) struct Places<'a> {
    points: &'a [[f64; 3]],
    counts: BTreeMap<Key, u32>,
}

impl<'a> Places<'a> {
    pub fn new(points: &'a [[f64; 3]]) -> Self {
        let counts = BTreeMap::new();
        Self { points, counts }
    }

    fn key(&self, face: &[u32]) -> Key {
        // Adding zero makes -0 the same as 0.
        let bits = |node: &u32| self.points[*node as usize].map(|x| (x + 0.0).to_bits());
        let mut key: Key = face.iter().map(bits).collect();
        key.sort_unstable();
        key
    }

    /// Counts the faces of a side.
    pub fn add(&mut self, faces: &Cells) {
        for face in faces.iter() {
            *self.counts.entry(self.key(face.nodes)).or_default() += 1;
        }
    }

    /// Number of these faces that coincide with another face.
    pub fn n_shared(&self, faces: &Cells) -> usize {
        let is_shared = |nodes: &[u32]| self.counts.get(&self.key(nodes)).is_some_and(|n| *n > 1);
        faces.iter().filter(|face| is_shared(face.nodes)).count()
    }
}
