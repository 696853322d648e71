//! Walks over the faces of a mesh, each once, with its owner: faces between two cells in blocks, outer ones one by one.
//! Cells of kinds with fixed faces go side by side, one face of all of them after the other.

use super::block::{Between, CentreColumns, FaceBlock, Faces, Measured, one};
use super::centres::{Centres, Finder};
use super::geometry::{self, Centre};
use super::solids::{self, Hexahedron, Pyramid, Solid, Tetrahedron, Wedge};
use crate::block::{BLOCK, Column, Columns, gather};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::adjacency::Sides;
use azimesh_io::mesh::sides::for_each_side;
use azimesh_io::mesh::{Across, Adjacency, CellKind, CellRef, CellRun};

/// Receiver of the faces of a chunk of cells.
pub(super) trait Sink {
    /// Faces between two cells.
    fn inner(&mut self, faces: &Measured<'_>);
    /// An outer face: its cell and its skewness.
    fn outer(&mut self, cell: usize, skewness: f64);
}

/// Hands the faces that cells of a chunk own to `sink`.
pub(super) fn faces_of(
    centres: &Centres<'_>,
    adjacency: &Adjacency,
    chunk: usize,
    sink: &mut impl Sink,
) {
    let (cells, sides) = adjacency.chunk(chunk);
    let mut walk = Walk {
        centres,
        sides,
        own: Finder::new(centres, cells.start),
        other: Finder::new(centres, cells.start),
        two: FaceBlock::new(),
        three: FaceBlock::new(),
        four: FaceBlock::new(),
    };
    let dimension = centres.mesh.dimension();
    for run in centres.mesh.cells.runs_in(cells) {
        if run.kind.dimension() == dimension {
            walk.run(&run, sink);
        }
    }
    let take = &mut |faces: &Measured<'_>| sink.inner(faces);
    walk.two.flush(take);
    walk.three.flush(take);
    walk.four.flush(take);
}

struct Walk<'a> {
    centres: &'a Centres<'a>,
    sides: Sides<'a>,
    own: Finder<'a>,
    other: Finder<'a>,
    two: Box<FaceBlock<2>>,
    three: Box<FaceBlock<3>>,
    four: Box<FaceBlock<4>>,
}

/// Fewer cells are not worth a block of their own.
const FEW: usize = BLOCK / 4;
/// In place of a cell across.
const NONE: u32 = u32::MAX;

/// Cells of a kind with `N` corners and `F` faces, side by side.
struct SolidBlock<const N: usize, const F: usize> {
    n: usize,
    cells: [u32; BLOCK],
    corners: Columns<N>,
    turn: Column,
    own: CentreColumns,
    /// The cell across each side, or `NONE`.
    others: [[u32; BLOCK]; F],
    /// Centres of those across the side that is measured.
    other: CentreColumns,
}

const NO_NORMAL: [Column; 3] = [[0.0; BLOCK]; 3];

impl<const N: usize, const F: usize> SolidBlock<N, F> {
    const EMPTY: Self = Self {
        n: 0,
        cells: [0; BLOCK],
        corners: [[[0.0; BLOCK]; 3]; N],
        turn: [0.0; BLOCK],
        own: [[0.0; BLOCK]; 4],
        others: [[NONE; BLOCK]; F],
        other: [[0.0; BLOCK]; 4],
    };

    fn cell(&self, i: usize) -> Own {
        let [x, y, z, volume] = &self.own;
        Own {
            cell: self.cells[i] as usize,
            centre: Centre {
                at: [x[i], y[i], z[i]],
                volume: volume[i],
            },
            turn: self.turn[i],
            normal: [0.0; 3],
        }
    }

    fn measure<const C: usize>(&self, side: usize, corners: [usize; C], sink: &mut impl Sink) {
        let faces = Faces {
            corners: corners.map(|k| &self.corners[k]),
            normal: &NO_NORMAL,
            turn: &self.turn,
            centres: [&self.own, &self.other],
        };
        let cells = [&self.cells[..self.n], &self.others[side][..self.n]];
        faces.measure(cells, &mut |measured| sink.inner(measured));
    }
}

#[inline(always)]
fn put(columns: &mut CentreColumns, i: usize, centre: &Centre) {
    for axis in 0..3 {
        columns[axis][i] = centre.at[axis];
    }
    columns[3][i] = centre.volume;
}

/// A cell whose sides are passed.
struct Own {
    cell: usize,
    centre: Centre,
    /// See [`FaceBlock`].
    turn: f64,
    normal: Vector,
}

impl Walk<'_> {
    fn run(&mut self, run: &CellRun<'_>, sink: &mut impl Sink) {
        match run.kind.linear() {
            _ if run.n_cells() < FEW => self.cells_of_any_kind(run, sink),
            CellKind::Tetrahedron => self.solids::<Tetrahedron, 4, 4>(run, sink),
            CellKind::Pyramid => self.solids::<Pyramid, 5, 5>(run, sink),
            CellKind::Wedge => self.solids::<Wedge, 6, 5>(run, sink),
            CellKind::Hexahedron => self.solids::<Hexahedron, 8, 6>(run, sink),
            _ => self.cells_of_any_kind(run, sink),
        }
    }

    fn solids<S: Solid<N, F>, const N: usize, const F: usize>(
        &mut self,
        run: &CellRun<'_>,
        sink: &mut impl Sink,
    ) {
        let mut block = SolidBlock::<N, F>::EMPTY;
        let mut first = run.first_cell;
        for cells in run.connectivity.chunks(BLOCK * run.n_nodes) {
            block.n = cells.len() / run.n_nodes;
            gather(cells, run.n_nodes, self.centres.points, &mut block.corners);
            self.find_own::<S, N, F>(first, &mut block);
            for (i, nodes) in cells.chunks_exact(run.n_nodes).enumerate() {
                self.find_others::<S, N, F>(i, nodes, &mut block, sink);
            }
            for side in 0..F {
                self.measure::<S, N, F>(side, &mut block, sink);
            }
            first += block.n;
        }
    }

    /// Centres of the cells of a block.
    fn find_own<S: Solid<N, F>, const N: usize, const F: usize>(
        &mut self,
        first: usize,
        block: &mut SolidBlock<N, F>,
    ) {
        for i in 0..block.n {
            block.cells[i] = (first + i) as u32;
            block.turn[i] = self.own.turn(first + i);
        }
        if self.own.is_simplex() {
            solids::centres::<S, N, F>(&block.corners, &mut block.own);
            for i in 0..block.n {
                block.own[3][i] *= block.turn[i];
            }
        } else {
            for i in 0..block.n {
                put(&mut block.own, i, &self.own.centre(first + i));
            }
        }
    }

    /// The cells across the sides of cell `i` of a block.
    #[inline(always)]
    fn find_others<S: Solid<N, F>, const N: usize, const F: usize>(
        &mut self,
        i: usize,
        nodes: &[u32],
        block: &mut SolidBlock<N, F>,
        sink: &mut impl Sink,
    ) {
        for side in 0..F {
            block.others[side][i] = match self.sides.across() {
                Across::Cell(other) => other,
                Across::Elsewhere => NONE,
                Across::Outside(_) => {
                    let corners = S::SIDES[side];
                    self.outer(&block.cell(i), corners.len(), &|k| nodes[corners[k]], sink);
                    NONE
                }
            };
        }
    }

    /// Measures the faces on one side of the cells of a block.
    fn measure<S: Solid<N, F>, const N: usize, const F: usize>(
        &mut self,
        side: usize,
        block: &mut SolidBlock<N, F>,
        sink: &mut impl Sink,
    ) {
        let n = block.n;
        let others = &mut block.others[side];
        if others[..n].iter().all(|other| *other == NONE) {
            return;
        }
        for i in 0..n {
            if others[i] == NONE {
                put(&mut block.other, i, &Centre::NONE);
                others[i] = block.cells[i];
            } else {
                let centre = self.other.centre(others[i] as usize);
                put(&mut block.other, i, &centre);
            }
        }
        match *S::SIDES[side] {
            [a, b, c] => block.measure(side, [a, b, c], sink),
            [a, b, c, d] => block.measure(side, [a, b, c, d], sink),
            _ => {}
        }
    }

    fn cells_of_any_kind(&mut self, run: &CellRun<'_>, sink: &mut impl Sink) {
        let mesh = self.centres.mesh;
        for cell in run.cell_refs() {
            let own = self.own(&cell);
            for_each_side(&mesh.cells, &cell, |_, corners| {
                self.side(&own, corners, sink);
            });
        }
    }

    #[inline(always)]
    fn own(&mut self, cell: &CellRef<'_>) -> Own {
        Own {
            cell: cell.index,
            centre: self.own.centre(cell.index),
            turn: self.own.turn(cell.index),
            normal: self.centres.normal(cell),
        }
    }

    #[inline(always)]
    fn side(&mut self, own: &Own, corners: &[u32], sink: &mut impl Sink) {
        match self.sides.across() {
            Across::Elsewhere => {}
            Across::Cell(other) => self.inner(own, other, corners, sink),
            Across::Outside(_) => self.outer(own, corners.len(), &|k| corners[k], sink),
        }
    }

    #[inline(always)]
    fn inner(&mut self, own: &Own, other: u32, corners: &[u32], sink: &mut impl Sink) {
        let points = self.centres.points;
        let face = Between {
            corners,
            normal: own.normal,
            turn: own.turn,
            cells: [own.cell as u32, other],
            centres: [own.centre, self.other.centre(other as usize)],
        };
        let take = &mut |faces: &Measured<'_>| sink.inner(faces);
        match corners.len() {
            2 => self.two.push(points, &face, take),
            3 => self.three.push(points, &face, take),
            4 => self.four.push(points, &face, take),
            _ => one(points, &face, take),
        }
    }

    #[cold]
    fn outer(&self, own: &Own, n: usize, node: &dyn Fn(usize) -> u32, sink: &mut impl Sink) {
        let corner = |k: usize| -> Vector { self.centres.points[node(k) as usize] };
        let face = geometry::face(n, corner, own.normal);
        sink.outer(
            own.cell,
            geometry::outer_skewness(&face, n, corner, &own.centre),
        );
    }
}
