//! Walks over the faces of a mesh, each once, with its owner: faces between two cells in blocks,
//! outer ones one by one.

use super::block::{Between, FaceBlock, Measured, one};
use super::centres::{Centres, Finder};
use super::geometry::{self, Centre};
use crate::geometry::vector::Vector;
use crate::mesh::adjacency::Sides;
use crate::mesh::sides::for_each_side;
use crate::mesh::{Across, Adjacency, CellKind, CellRef, CellRun};

/// Its sides, as in `CellKind::faces`.
const TETRAHEDRON: [[usize; 3]; 4] = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]];

/// What takes the faces of a chunk of cells.
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
            CellKind::Tetrahedron => self.cells::<3, 4>(run, &TETRAHEDRON, sink),
            _ => self.cells_of_any_kind(run, sink),
        }
    }

    /// Cells of `F` sides of `N` corners each.
    fn cells<const N: usize, const F: usize>(
        &mut self,
        run: &CellRun<'_>,
        sides: &[[usize; N]; F],
        sink: &mut impl Sink,
    ) {
        for cell in run.cell_refs() {
            let own = self.own(&cell);
            for side in sides {
                let mut corners = [0; N];
                for k in 0..N {
                    corners[k] = cell.nodes[side[k]];
                }
                self.side(&own, &corners, sink);
            }
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
        let (centre, turn) = self.own.centre(cell.index);
        Own {
            cell: cell.index,
            centre,
            turn,
            normal: self.centres.normal(cell),
        }
    }

    #[inline(always)]
    fn side(&mut self, own: &Own, corners: &[u32], sink: &mut impl Sink) {
        match self.sides.across() {
            Across::Elsewhere => {}
            Across::Cell(other) => self.inner(own, other, corners, sink),
            Across::Outside(_) => self.outer(own, corners, sink),
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
            centres: [own.centre, self.other.centre(other as usize).0],
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
    fn outer(&mut self, own: &Own, corners: &[u32], sink: &mut impl Sink) {
        let n = corners.len();
        let corner = |k: usize| -> Vector { self.centres.points[corners[k] as usize] };
        let face = geometry::face(n, corner, own.normal);
        sink.outer(
            own.cell,
            geometry::outer_skewness(&face, n, corner, &own.centre),
        );
    }
}
