//! Walks over volume cells and measures them block by block, each of one kind. Cells that list a node twice are measured as what
//! they are, such as hexahedra with an edge of no length as wedges.

use super::block::{BLOCK, Block, Corners, Shape, measure};
use super::facing::Facing;
use super::metrics::Metrics;
use super::{plane, solid};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::{CellKind, CellRef, CellRun, Cells, Mesh};
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
            self.block.collapsed.clear();
            // An edge between a node and itself has no length.
            if self.block.edge.low[..self.block.n].contains(&0.0) {
                self.measure_collapsed(run, first);
            }
            visit(first, &self.block);
            first += self.block.n;
        }
    }

    /// Measures the cells of a block again that list a node twice.
    #[cold]
    fn measure_collapsed(&mut self, run: &CellRun, first: usize) {
        for i in 0..self.block.n {
            if self.block.edge.low[i] != 0.0 {
                continue;
            }
            let cell = first + i;
            let at = (cell - run.first_cell) * run.n_nodes;
            let listed = CellRef {
                index: cell,
                kind: run.kind,
                nodes: &run.connectivity[at..at + run.n_nodes],
            };
            if let Some(one) = listed.uncollapsed() {
                let metrics = metrics(&one, &one.get(0), self.points, self.facing.of(cell));
                self.block.set(i, &metrics);
                self.block.collapsed.push(cell as u32);
            }
        }
    }

    fn one_by_one(&mut self, run: &CellRun, visit: &mut impl FnMut(usize, &Block)) {
        for cell in run.cell_refs() {
            let facing = self.facing.of(cell.index);
            let metrics = metrics(&self.mesh.cells, &cell, self.points, facing);
            self.block.n = 1;
            self.block.set(0, &metrics);
            visit(cell.index, &self.block);
        }
    }
}

/// Metrics of one of these cells. Prisms on five or six corners are measured as polyhedra.
fn metrics(cells: &Cells, cell: &CellRef<'_>, points: &[Vector], facing: Vector) -> Metrics {
    let corner = |k: usize| points[cell.nodes[k] as usize];
    match cell.kind.linear() {
        CellKind::Triangle => plane::triangle(&std::array::from_fn(corner), facing),
        CellKind::Tetrahedron => solid::tetrahedron(&std::array::from_fn(corner)),
        CellKind::Pyramid => solid::pyramid(&std::array::from_fn(corner)),
        CellKind::Wedge => solid::wedge(&std::array::from_fn(corner)),
        CellKind::Polygon => {
            let n_corners = cell.kind.n_corners(cell.nodes.len());
            plane::polygon(n_corners, corner, facing)
        }
        CellKind::Polyhedron => {
            let faces = cells.polyhedron_faces(cell.index);
            solid::polyhedron(faces.map(|face| face.iter().copied()), points, corner(0))
        }
        prism => {
            let faces = prism.faces().iter();
            let faces = faces.map(|face| face.iter().map(|&k| cell.nodes[usize::from(k)]));
            solid::polyhedron(faces, points, corner(0))
        }
    }
}
