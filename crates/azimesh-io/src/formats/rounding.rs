//! Effects of coordinates of 32 bits on a mesh: lost digits, and cells that become flat or fold.

use crate::mesh::{CellRef, Cells, MeshView, corners, first_where};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, sub};
use azimesh_core::{Note, note, parallel};
use std::ops::Range;

/// Cells of a block.
const BLOCK: usize = 1 << 12;
/// Jacobian over the lengths of its edges, below which a corner is flat before it is rounded.
const FLAT: f64 = 1e-9;

/// Checks if a coordinate is another one in 32 bits.
pub(super) fn loses_digits(mesh: &MeshView) -> bool {
    let is_rounded = |x: &f64| f64::from(*x as f32) != *x;
    first_where(mesh.points.as_flattened(), is_rounded).is_some()
}

/// The number of cells of the mesh's own dimension that become flat or fold in coordinates of 32 bits, as a note. `O(n)`.
pub(super) fn flattened(mesh: &MeshView) -> Option<Note> {
    if !loses_digits(mesh) {
        return None;
    }
    let (mut n, mut of, mut first) = (0, 0, None);
    for run in mesh.volume_runs() {
        let is_flat = |i: &usize| {
            let cell = mesh.cells.get(run.first_cell + i);
            becomes_flat(mesh.cells, &cell, mesh.points)
        };
        let cells = |range: Range<usize>| range.filter(is_flat).collect::<Vec<usize>>();
        let flat = parallel::map_blocks(run.n_cells(), BLOCK, &cells).concat();
        n += flat.len();
        of += run.n_cells();
        first = first.or(flat.first().map(|i| run.first_cell + i));
    }
    first.map(|first| {
        note!(
            "flattened",
            "cells become flat or fold in coordinates of 32 bits: {n} of {of} (the first is cell {first}); 64 bits keep them"
        )
    })
}

/// Checks if a note reports cells that become flat in coordinates of 32 bits.
pub fn is_flattened(note: &Note) -> bool {
    note.code == "flattened"
}

/// Checks if a corner of a cell, or a polyhedron as a whole, has no volume in coordinates of 32 bits, or one of the other sign.
fn becomes_flat(cells: &Cells, cell: &CellRef<'_>, points: &[Vector]) -> bool {
    let exact = |node: u32| points[node as usize];
    let rounded = |node: u32| points[node as usize].map(|x| f64::from(x as f32));
    let corners = corners::of(cell.kind.linear());
    if !corners.is_empty() {
        let is_solid = cell.kind.dimension() == 3;
        return corners.iter().any(|corner| {
            let nodes = corner.map(|at| cell.nodes[usize::from(at)]);
            let (before, size) = jacobian(nodes.map(exact), is_solid);
            let (after, _) = jacobian(nodes.map(rounded), is_solid);
            norm(before) > FLAT * size && dot(before, after) <= 0.0
        });
    }
    match cells.face_stream(cell.index) {
        Some(_) => {
            let volume = |place: &dyn Fn(u32) -> Vector| {
                let origin = place(cell.nodes[0]);
                let faces = cells.polyhedron_faces(cell.index);
                faces
                    .map(|face| dot(sub(place(face[0]), origin), area(face, place)))
                    .sum::<f64>()
            };
            volume(&exact) * volume(&rounded) <= 0.0 && volume(&exact) != 0.0
        }
        None => {
            let nodes = &cell.nodes[..cell.kind.n_corners(cell.nodes.len())];
            let [before, after] = [area(nodes, &exact), area(nodes, &rounded)];
            norm(before) > 0.0 && dot(before, after) <= 0.0
        }
    }
}

/// The area vector of a polygon, times two.
fn area(nodes: &[u32], place: &dyn Fn(u32) -> Vector) -> Vector {
    let [first, rest @ ..] = nodes else {
        return [0.0; 3];
    };
    let along = |node: u32| sub(place(node), place(*first));
    let parts = rest
        .windows(2)
        .map(|two| cross(along(two[0]), along(two[1])));
    parts.fold([0.0; 3], add)
}

/// The Jacobian at a corner as a vector, of a solid cell along x, and the product of the lengths of its edges.
fn jacobian([corner, ends @ ..]: [Vector; 4], is_solid: bool) -> (Vector, f64) {
    let [a, b, c] = ends.map(|end| sub(end, corner));
    let (area, size) = (cross(a, b), norm(a) * norm(b));
    if is_solid {
        return ([dot(area, c), 0.0, 0.0], size * norm(c));
    }
    (area, size)
}
