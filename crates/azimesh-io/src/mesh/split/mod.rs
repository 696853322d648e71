//! Polyhedra and polygons made of cells that every format has.
//!
//! ```text
//! mod       the order of the work: nodes of faces, parts of each cell, groups and arrays
//! nodes     new nodes: one for each face of more than four corners, one for each cell
//! solid     the parts of one polyhedron: its faces, turned outward, and a point inside
//! flat      the parts of one polygon
//! inside    a point on the inner side of all planes
//! ```
//!
//! A face of three or four corners is the base of one tetrahedron or pyramid. One of more corners is a fan of
//! triangles around the mean of its corners. How a face is split depends on the face alone, so that the cells on
//! both sides, and the boundary face on it, have the same parts.

mod flat;
mod inside;
mod nodes;
mod solid;

#[cfg(test)]
mod tests;

use super::arrays::select_tuples;
use super::{CellKind, CellRef, CellSet, Cells, Group, Mesh};
use azimesh_core::error::Result;
use azimesh_core::parallel::{SMALL_BLOCK, map_blocks};
use nodes::{FaceNodes, NewNodes};
use std::ops::Range;

/// Counts of a split.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SplitCounts {
    /// Cells of the mesh's own dimension.
    pub n_cells: usize,
    /// Boundary faces.
    pub n_faces: usize,
    /// New nodes.
    pub n_nodes: usize,
    /// Cells and faces of fewer than three corners, which are removed.
    pub n_gone: usize,
    /// Cells with a part whose volume (in 2D: area) is not positive at each of its corners.
    pub n_not_positive: usize,
    /// The first of them, by its number before.
    pub first_not_positive: Option<usize>,
}

/// Stands for the node in the middle of a cell until that has a number.
const MIDDLE: u32 = u32::MAX;

/// The cells that one cell becomes, as nodes one after another.
#[derive(Default)]
struct Parts {
    /// Tetrahedra, in 2D triangles.
    simplices: Vec<u32>,
    /// Pyramids, in 2D quadrilaterals.
    others: Vec<u32>,
    /// Position of the node in its middle, if it needs one.
    middle: Option<[f64; 3]>,
    is_positive: bool,
}

impl Mesh {
    /// Replaces polyhedra, and prisms over pentagons and hexagons, by tetrahedra and pyramids around a new node
    /// in each, and polygons by triangles and quadrilaterals.
    ///
    /// The parts of a cell have its volume, to round-off. Groups hold the parts of their cells, cell arrays have
    /// the value of the cell in each part, point arrays the mean of a cell's or a face's nodes at its new node
    /// (of integers the nearest to it, of text none). Parts come in the place of their cells; of consecutive
    /// cells the tetrahedra come first.
    ///
    /// # Errors
    /// If there would be more nodes or cells than a mesh can have.
    pub fn split_polyhedra(&mut self) -> Result<SplitCounts> {
        let dimension = self.dimension();
        if !self.cells.runs().any(|run| is_split(run.kind)) {
            return Ok(SplitCounts::default());
        }
        let mut new_nodes = NewNodes::after(self.points.len());
        let faces = match dimension {
            3 => FaceNodes::of(self, &mut new_nodes)?,
            _ => FaceNodes::default(),
        };
        let mut draft = Draft::new(self);
        for stretch in stretches(&self.cells) {
            if stretch.is_split {
                let is_volume = stretch.dimension == dimension;
                let places = (&faces, &mut new_nodes);
                self.split_stretch(&stretch, is_volume, places, &mut draft)?;
            } else {
                draft.keep(&self.cells, stretch.cells)?
            }
        }
        draft.counts.n_nodes = new_nodes.len();
        let counts = draft.counts;
        self.take(draft, new_nodes);
        Ok(counts)
    }

    /// Splits consecutive cells of one dimension.
    fn split_stretch(
        &self,
        stretch: &Stretch,
        is_volume: bool,
        (faces, new_nodes): (&FaceNodes, &mut NewNodes),
        draft: &mut Draft,
    ) -> Result<()> {
        let first = stretch.cells.start;
        let of_blocks = map_blocks(stretch.cells.len(), SMALL_BLOCK, &|range| {
            let cells = range.map(|i| self.cells.get(first + i));
            let points = (&self.points[..], new_nodes.places());
            let split = |cell: CellRef<'_>| match (stretch.dimension, is_volume) {
                (3, _) => solid::split(&self.cells, &cell, points, faces),
                (_, true) => flat::split(cell.nodes, &self.points),
                (_, false) => flat::split_face(cell.nodes, faces),
            };
            cells.map(split).collect::<Vec<_>>()
        });
        let mut all: Vec<Parts> = of_blocks.into_iter().flatten().collect();
        for (i, parts) in all.iter_mut().enumerate() {
            let cell = self.cells.get(first + i);
            if let Some(place) = parts.middle {
                let middle = new_nodes.add(place, cell.nodes)?;
                let nodes = parts.simplices.iter_mut().chain(&mut parts.others);
                for node in nodes.filter(|node| **node == MIDDLE) {
                    *node = middle;
                }
            }
            draft.counts.count(cell.index, is_volume, parts);
        }
        draft.add(first, stretch.dimension, &all)
    }

    /// Takes over new cells and nodes.
    fn take(&mut self, draft: Draft, new_nodes: NewNodes) {
        for group in &mut self.groups {
            *group = draft.group(group);
        }
        select_tuples(&mut self.cell_arrays, &draft.origin);
        for array in &mut self.point_arrays {
            let n = array.n_components;
            array.values.append_means(n, new_nodes.nodes());
        }
        self.points.extend_from_slice(new_nodes.places());
        self.cells = draft.cells;
    }
}

impl SplitCounts {
    fn count(&mut self, cell: usize, is_volume: bool, parts: &Parts) {
        let n_parts = parts.simplices.len() + parts.others.len();
        self.n_gone += usize::from(n_parts == 0);
        let is_one = parts.middle.is_none() && n_parts <= 4;
        if is_volume {
            self.n_cells += usize::from(!is_one)
        } else {
            self.n_faces += usize::from(!is_one)
        }
        if is_volume && !parts.is_positive {
            self.n_not_positive += 1;
            self.first_not_positive.get_or_insert(cell);
        }
    }
}

/// Kinds that few formats have, and that are split.
fn is_split(kind: CellKind) -> bool {
    use CellKind::{HexagonalPrism, PentagonalPrism, Polygon, Polyhedron};
    matches!(
        kind,
        Polygon | Polyhedron | PentagonalPrism | HexagonalPrism
    )
}

/// Consecutive cells that stay, or that are split and have one dimension.
struct Stretch {
    cells: Range<usize>,
    is_split: bool,
    dimension: u8,
}

fn stretches(cells: &Cells) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for run in cells.runs() {
        let (is_split, dimension) = (is_split(run.kind), run.kind.dimension());
        let range = run.first_cell..run.first_cell + run.n_cells();
        match stretches.last_mut() {
            Some(last) if last.is_split && is_split && last.dimension == dimension => {
                last.cells.end = range.end;
            }
            _ => stretches.push(Stretch {
                cells: range,
                is_split,
                dimension,
            }),
        }
    }
    stretches
}

/// The new cells so far.
struct Draft {
    cells: Cells,
    /// Of each new cell the one that it is a part of.
    origin: Vec<usize>,
    /// Of each old cell its simplices and its other parts; where it stays, itself.
    parts: Vec<[Range<u32>; 2]>,
    counts: SplitCounts,
}

impl Draft {
    fn new(mesh: &Mesh) -> Self {
        Self {
            cells: Cells::new(),
            origin: Vec::with_capacity(mesh.cells.len()),
            parts: Vec::with_capacity(mesh.cells.len()),
            counts: SplitCounts::default(),
        }
    }

    /// Adds cells as they are.
    fn keep(&mut self, cells: &Cells, range: Range<usize>) -> Result<()> {
        self.cells.check_space(range.len())?;
        for run in cells.runs_in(range.clone()) {
            self.cells.push_run(run.kind, run.n_nodes, run.connectivity);
        }
        let new = (self.origin.len() as u32..).map(|i| [i..i + 1, 0..0]);
        self.parts.extend(new.take(range.len()));
        self.origin.extend(range);
        Ok(())
    }

    /// Adds the parts of the cells from `first` on: all simplices, then all others.
    fn add(&mut self, first: usize, dimension: u8, all: &[Parts]) -> Result<()> {
        let (simplex, other) = match dimension {
            3 => (CellKind::Tetrahedron, CellKind::Pyramid),
            _ => (CellKind::Triangle, CellKind::Quadrilateral),
        };
        let n_nodes = usize::from(dimension) + 1;
        let from = self.parts.len();
        self.parts.resize(from + all.len(), [0..0, 0..0]);
        for (which, kind, n_nodes) in [(0, simplex, n_nodes), (1, other, n_nodes + 1)] {
            for (i, parts) in all.iter().enumerate() {
                let nodes = [&parts.simplices, &parts.others][which];
                let (start, n) = (self.origin.len(), nodes.len() / n_nodes);
                self.cells.check_space(n)?;
                self.cells.push_run(kind, n_nodes, nodes);
                self.origin.resize(start + n, first + i);
                self.parts[from + i][which] = start as u32..(start + n) as u32;
            }
        }
        Ok(())
    }

    /// A group with the parts of its cells.
    fn group(&self, group: &Group) -> Group {
        let parts = group.cells.iter().flat_map(|cell| self.parts[cell].clone());
        let mut ranges: Vec<Range<u32>> = parts.filter(|range| !range.is_empty()).collect();
        ranges.sort_unstable_by_key(|range| range.start);
        let mut cells = CellSet::new();
        for range in ranges {
            cells.push_range(range.start as usize..range.end as usize);
        }
        Group {
            cells,
            ..group.clone()
        }
    }
}
