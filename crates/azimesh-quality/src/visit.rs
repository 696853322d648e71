//! Walks over volume cells and measures them block by block, each of one kind.

use super::block::{BLOCK, Block, Corners, Shape, measure};
use super::facing::Facing;
use super::metrics::Metrics;
use super::{plane, solid};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::{CellKind, CellRun, Mesh};
use std::ops::Range;

/// Cells in a chunk: sums are folded chunk by chunk, on any number of threads.
pub(super) const CHUNK: usize = 4096;

macro_rules! shapes {
    ($($name:ident $corners:literal $faces:literal |$p:ident, $facing:ident| $metrics:expr;)*) => {
        $(
            struct $name;

            impl Shape<$corners> for $name {
                const FACES: bool = $faces;

                #[inline(always)]
                fn measure($p: &[Vector; $corners], $facing: Vector) -> Metrics {
                    $metrics
                }
            }
        )*
    };
}

shapes! {
    Triangle 3 true |p, facing| plane::triangle(p, facing);
    Quadrilateral 4 true |p, facing| plane::quadrilateral(p, facing);
    Tetrahedron 4 false |p, _facing| solid::tetrahedron(p);
    Pyramid 5 false |p, _facing| solid::pyramid(p);
    Wedge 6 false |p, _facing| solid::wedge(p);
    Hexahedron 8 false |p, _facing| solid::hexahedron(p);
}

/// Calls `visit(first_cell, block)` for the volume cells of `range`, in order, with nodes at
/// `points`.
pub(super) fn volume_cells(
    mesh: &Mesh,
    points: &[Vector],
    facing: &Facing,
    range: Range<usize>,
    mut visit: impl FnMut(usize, &Block),
) {
    let dimension = mesh.dimension();
    let mut walk = Walk {
        mesh,
        points,
        facing,
        block: Block::EMPTY,
    };
    for run in mesh.cells.runs_in(range) {
        if run.kind.dimension() != dimension {
            continue;
        }
        match run.kind.linear() {
            CellKind::Triangle => walk.measure::<Triangle, 3>(&run, &mut visit),
            CellKind::Quadrilateral => walk.measure::<Quadrilateral, 4>(&run, &mut visit),
            CellKind::Tetrahedron => walk.measure::<Tetrahedron, 4>(&run, &mut visit),
            CellKind::Pyramid => walk.measure::<Pyramid, 5>(&run, &mut visit),
            CellKind::Wedge => walk.measure::<Wedge, 6>(&run, &mut visit),
            CellKind::Hexahedron => walk.measure::<Hexahedron, 8>(&run, &mut visit),
            CellKind::Vertex | CellKind::Line => {} // a mesh of lines or vertices has no quality
            _ => walk.one_by_one(&run, &mut visit),
        }
    }
}

struct Walk<'a> {
    mesh: &'a Mesh,
    points: &'a [Vector],
    facing: &'a Facing,
    block: Block,
}

impl Walk<'_> {
    fn measure<S: Shape<N>, const N: usize>(
        &mut self,
        run: &CellRun,
        visit: &mut impl FnMut(usize, &Block),
    ) {
        let mut corners = Corners::<N>::EMPTY;
        let mut first = run.first_cell;
        for connectivity in run.connectivity.chunks(BLOCK * run.n_nodes) {
            measure::<S, N>(
                connectivity,
                run.n_nodes,
                self.points,
                self.facing,
                first,
                &mut corners,
                &mut self.block,
            );
            visit(first, &self.block);
            first += self.block.n;
        }
    }

    /// Polygons, polyhedra, and prisms on five or six corners, which are measured as polyhedra.
    fn one_by_one(&mut self, run: &CellRun, visit: &mut impl FnMut(usize, &Block)) {
        let points = self.points;
        for (cell, nodes) in (run.first_cell..).zip(run.cells()) {
            let origin = points[nodes[0] as usize];
            let metrics = match run.kind.linear() {
                CellKind::Polygon => {
                    let corner = |k: usize| points[nodes[k] as usize];
                    let n_corners = run.kind.n_corners(nodes.len());
                    plane::polygon(n_corners, corner, self.facing.of(cell))
                }
                CellKind::Polyhedron => {
                    let faces = self.mesh.cells.polyhedron_faces(cell);
                    solid::polyhedron(faces.map(|face| face.iter().copied()), points, origin)
                }
                prism => {
                    let faces = prism.faces().iter();
                    let faces = faces.map(|face| face.iter().map(|&k| nodes[usize::from(k)]));
                    solid::polyhedron(faces, points, origin)
                }
            };
            self.block.n = 1;
            self.block.set(0, &metrics);
            visit(cell, &self.block);
        }
    }
}
