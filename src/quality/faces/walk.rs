//! Walks over the faces of a mesh, each once, with its owner: faces between two cells in blocks,
//! outer ones one by one.

use super::block::{Between, FaceBlock, Measured, one};
use super::centres::{Centres, Finder};
use super::geometry;
use crate::geometry::vector::Vector;
use crate::mesh::adjacency::Sides;
use crate::mesh::sides::for_each_side;
use crate::mesh::{Across, Adjacency, CellRef, CellRun};

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

impl Walk<'_> {
    fn run(&mut self, run: &CellRun<'_>, sink: &mut impl Sink) {
        let mesh = self.centres.mesh;
        let faces = run.kind.faces();
        for cell in run.cell_refs() {
            if faces.is_empty() {
                for_each_side(&mesh.cells, &cell, |_, corners| {
                    self.side(&cell, corners, sink)
                });
                continue;
            }
            for face in faces {
                let mut corners = [0; 8];
                for (node, &corner) in corners.iter_mut().zip(*face) {
                    *node = cell.nodes[usize::from(corner)];
                }
                self.side(&cell, &corners[..face.len()], sink);
            }
        }
    }

    #[inline]
    fn side(&mut self, cell: &CellRef<'_>, corners: &[u32], sink: &mut impl Sink) {
        match self.sides.across() {
            Across::Elsewhere => {}
            Across::Cell(other) => self.inner(cell, other, corners, sink),
            Across::Outside(_) => self.outer(cell, corners, sink),
        }
    }

    #[inline]
    fn inner(&mut self, cell: &CellRef<'_>, other: u32, corners: &[u32], sink: &mut impl Sink) {
        let centres = self.centres;
        let points = centres.points;
        let face = Between {
            corners,
            normal: match corners.len() {
                2 => centres.normal(cell),
                _ => [0.0; 3],
            },
            turn: centres.outward(cell.index, cell.kind),
            cells: [cell.index as u32, other],
            centres: [
                self.own.centre(cell.index),
                self.other.centre(other as usize),
            ],
        };
        let take = &mut |faces: &Measured<'_>| sink.inner(faces);
        match corners.len() {
            2 => self.two.push(points, &face, take),
            3 => self.three.push(points, &face, take),
            4 => self.four.push(points, &face, take),
            _ => one(points, &face, take),
        }
    }

    fn outer(&mut self, cell: &CellRef<'_>, corners: &[u32], sink: &mut impl Sink) {
        let n = corners.len();
        let corner = |k: usize| -> Vector { self.centres.points[corners[k] as usize] };
        let face = geometry::face(n, corner, self.centres.normal(cell));
        let skewness = geometry::outer_skewness(&face, n, corner, &self.own.centre(cell.index));
        sink.outer(cell.index, skewness);
    }
}
