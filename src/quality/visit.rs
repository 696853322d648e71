//! Walks over volume cells and measures each, run by run so that the kind is looked at once a run.

use super::metrics::Metrics;
use super::reference::Facing;
use super::{plane, solid};
use crate::geometry::vector::Vector;
use crate::mesh::{CellKind, CellRun, Mesh};
use std::ops::Range;

/// Cells in a chunk: sums are folded chunk by chunk, whatever the threads.
pub(super) const CHUNK: usize = 4096;

/// The chunks of a mesh's cells, in order.
pub(super) fn chunks(n_cells: usize) -> impl Fn(usize) -> Range<usize> {
    move |chunk| chunk * CHUNK..((chunk + 1) * CHUNK).min(n_cells)
}

/// Calls `visit(cell, metrics)` for each volume cell of `range`, with nodes at `points`.
#[inline]
pub(super) fn volume_cells(
    mesh: &Mesh,
    points: &[Vector],
    facing: &Facing,
    range: Range<usize>,
    mut visit: impl FnMut(usize, Metrics),
) {
    let dimension = mesh.dimension();
    for run in mesh.cells.runs_in(range) {
        if run.kind.dimension() != dimension {
            continue;
        }
        let toward = |cell: usize| facing.of(cell);
        let visit = &mut visit;
        match run.kind.linear() {
            CellKind::Triangle => {
                each(&run, points, |i, p| visit(i, plane::triangle(p, toward(i))))
            }
            CellKind::Quadrilateral => each(&run, points, |i, p| {
                visit(i, plane::quadrilateral(p, toward(i)));
            }),
            CellKind::Tetrahedron => each(&run, points, |i, p| visit(i, solid::tetrahedron(p))),
            CellKind::Pyramid => each(&run, points, |i, p| visit(i, solid::pyramid(p))),
            CellKind::Wedge => each(&run, points, |i, p| visit(i, solid::wedge(p))),
            CellKind::Hexahedron => each(&run, points, |i, p| visit(i, solid::hexahedron(p))),
            CellKind::Polygon => {
                for (i, nodes) in (run.first_cell..).zip(run.cells()) {
                    let at = |k: usize| points[nodes[k] as usize];
                    visit(i, plane::polygon(nodes.len(), at, toward(i)));
                }
            }
            CellKind::Polyhedron => {
                for (i, nodes) in (run.first_cell..).zip(run.cells()) {
                    let faces = mesh.cells.polyhedron_faces(i);
                    visit(
                        i,
                        solid::polyhedron(faces, points, points[nodes[0] as usize]),
                    );
                }
            }
            _ => {} // a mesh of lines or vertices has no quality
        }
    }
}

/// Gathers the first `N` nodes of each cell of a run.
#[inline]
fn each<const N: usize>(
    run: &CellRun,
    points: &[Vector],
    mut visit: impl FnMut(usize, &[Vector; N]),
) {
    for (i, nodes) in (run.first_cell..).zip(run.cells()) {
        visit(i, &std::array::from_fn(|k| points[nodes[k] as usize]));
    }
}
