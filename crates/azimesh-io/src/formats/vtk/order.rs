//! Node orders that differ between versions of VTK: of wedges, and of Lagrange and Bezier hexahedra.
//!
//! Wedges of six nodes: up to VTK 9.6 the normal of nodes 0, 1, 2 points away from nodes 3, 4, 5 (a positive volume), since
//! VTK 9.7 towards them, as in a mesh here. Files have the first order; one that does not say so may have either.
//!
//! Hexahedra before VTK 9: the inner nodes of two edges were swapped. Files older than XML 2.1 or
//! legacy 5.1 have the old order. The edges are those from node 2 to node 6 and from node 3 to node 7.

use crate::formats::Notes;
use crate::mesh::{CellKind, Cells, DataArray, Mesh, MeshView, Values, mirror_wedges};
use azimesh_core::geometry::vector::{Vector, cross, dot, sub};
use azimesh_core::note;
use azimesh_core::numbers::with_verb;
use azimesh_core::parallel::{BLOCK, map_blocks};
use std::borrow::Cow;

/// Name of the mark of files that have wedges in the order of VTK up to 9.6.
pub const WEDGES: &str = "wedges";
/// Value of this mark: where the normal of nodes 0, 1, 2 points.
pub const OUTWARD: &str = "outward";

/// Title of legacy files with this mark.
pub const TITLE: &str = "written by azimesh, wedges outward";

/// Returns whether a file of these cells is marked.
pub fn has_wedges(cells: &Cells) -> bool {
    cells.runs().any(|run| run.kind == CellKind::Wedge)
}

/// Lists the nodes of cells of one kind as files do.
pub fn listed(kind: CellKind, nodes: &[u32]) -> Cow<'_, [u32]> {
    let mut nodes = Cow::Borrowed(nodes);
    if kind == CellKind::Wedge {
        mirror_wedges(nodes.to_mut());
    }
    nodes
}

/// Lists the wedges of a file as a mesh does. In a file that is not marked, the sign of most volumes says which order it has;
/// a note if it is not the order of VTK up to 9.6.
pub fn turn_wedges(mesh: &mut Mesh, is_marked: bool, notes: &mut Notes) {
    if !is_marked && balance(&mesh.view()) > 0 {
        let wedges = mesh.cells.runs().filter(|run| run.kind == CellKind::Wedge);
        let n = wedges.map(|run| run.n_cells()).sum();
        notes.push(note!(
            "wedges_turned",
            "{} in the node order of VTK 9.7, not of VTK up to 9.6: most have a positive volume in it",
            with_verb(n, "wedge", "is")
        ));
        return;
    }
    mesh.cells.mirror_wedges();
}

/// Number of wedges of positive volume as listed, minus the number of negative volume.
fn balance(mesh: &MeshView) -> i64 {
    let mut sum = 0;
    for run in mesh.cells.runs().filter(|run| run.kind == CellKind::Wedge) {
        let blocks = map_blocks(run.n_cells(), BLOCK, &|block| {
            let wedges = run.connectivity[6 * block.start..6 * block.end].chunks_exact(6);
            let sign = |volume: f64| i64::from(volume > 0.0) - i64::from(volume < 0.0);
            let volumes = wedges.map(|nodes| six_volumes(mesh.points, nodes));
            volumes.map(sign).sum::<i64>()
        });
        sum += blocks.into_iter().sum::<i64>();
    }
    sum
}

/// Six times the volume of a wedge in the order of a mesh, from its sides without node 0.
fn six_volumes(points: &[Vector], nodes: &[u32]) -> f64 {
    let at = |i: usize| sub(points[nodes[i] as usize], points[nodes[0] as usize]);
    let sides = [[3, 4, 5], [1, 2, 5], [1, 5, 4]].map(|side| side.map(at));
    sides.iter().map(|[a, b, c]| dot(*a, cross(*b, *c))).sum()
}

/// VTK's name of the array with the degrees of each cell along its three axes.
const DEGREES: &str = "HigherOrderDegrees";

/// Returns whether cells of this kind had another order.
pub fn concerns(kind: CellKind) -> bool {
    matches!(
        kind,
        CellKind::LagrangeHexahedron | CellKind::BezierHexahedron
    )
}

/// Turns the old order into the present one, or back.
pub fn swap(mesh: &mut Mesh, notes: &mut Notes) {
    if !mesh.cells.runs().any(|run| concerns(run.kind)) {
        return;
    }
    let degrees = mesh.cell_arrays.iter().find(|array| is_degrees(array));
    let (cells, n_unknown) = swapped(&mesh.cells, degrees);
    mesh.cells = cells;
    notes.count(n_unknown, |n| {
        note!(
            "old_order",
            "hexahedra of high order ({n}) keep the node order of VTK before version 9: their degrees are not given"
        )
    });
}

/// Cells in the other order, and how many hexahedra have degrees that cannot be known.
pub fn swapped(cells: &Cells, degrees: Option<&DataArray>) -> (Cells, usize) {
    let mut n_unknown = 0;
    let mut nodes: Vec<u32> = Vec::new();
    let mut new = Cells::new();
    new.reserve(cells.connectivity().len());
    for run in cells.runs() {
        if run.kind == CellKind::Polyhedron {
            for (i, nodes) in run.cells().enumerate() {
                let stream = cells.face_stream(run.first_cell + i).unwrap_or(&[]);
                new.push_polyhedron_with_nodes(nodes, stream)
                    .expect("it was checked when it was added");
            }
            continue;
        }
        if !concerns(run.kind) {
            new.push_run(run.kind, run.n_nodes, run.connectivity);
            continue;
        }
        nodes.clear();
        nodes.extend_from_slice(run.connectivity);
        for (i, nodes) in nodes.chunks_exact_mut(run.n_nodes).enumerate() {
            let of_cell = degrees.and_then(|array| degrees_of(array, run.first_cell + i));
            match of_cell.or_else(|| cube_root(nodes.len()).map(|n| [n - 1; 3])) {
                Some(degrees) => swap_edges(nodes, degrees),
                None => n_unknown += 1,
            }
        }
        new.push_run(run.kind, run.n_nodes, &nodes);
    }
    (new, n_unknown)
}

/// Returns whether an array has the degrees of cells.
pub fn is_degrees(array: &DataArray) -> bool {
    array.name == DEGREES && array.n_components == 3 && !matches!(array.values, Values::Text(_))
}

fn degrees_of(array: &DataArray, cell: usize) -> Option<[usize; 3]> {
    let degrees = array.values.select(3, &[cell]).to_integers()?;
    let mut of_axes = [0; 3];
    for (of_axis, degree) in of_axes.iter_mut().zip(degrees) {
        *of_axis = usize::try_from(degree).ok().filter(|n| *n > 0)?;
    }
    Some(of_axes)
}

fn cube_root(n: usize) -> Option<usize> {
    let roots = (2..=n).take_while(|k| k * k * k <= n);
    roots.last().filter(|k| k * k * k == n)
}

/// Swaps the inner nodes of the last two edges along the third axis.
fn swap_edges(nodes: &mut [u32], degrees: [usize; 3]) {
    let inner = degrees.map(|n| n - 1);
    let [Some(x), Some(y), Some(z)] = inner.map(|n| n.checked_mul(4)) else {
        return;
    };
    let start = [8, x, y, z / 2].into_iter().try_fold(0, usize::checked_add);
    let edges = start.and_then(|start| {
        let end = start.checked_add(2 * inner[2])?;
        nodes.get_mut(start..end)
    });
    if let Some(edges) = edges {
        let (third, fourth) = edges.split_at_mut(inner[2]);
        third.swap_with_slice(fourth);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// VTK 9.7's reading of a file of version 2.0 with consecutive node numbers.
    #[test]
    fn edges_are_swapped_as_vtk_does() {
        for (degrees, expected) in [
            ([2, 2, 2], vec![19, 18]),
            ([3, 3, 3], vec![30, 31, 28, 29]),
            ([2, 3, 4], vec![29, 30, 31, 26, 27, 28]),
        ] {
            let n: usize = degrees.iter().map(|n| n + 1).product();
            let mut nodes: Vec<u32> = (0..n as u32).collect();
            swap_edges(&mut nodes, degrees);
            let moved = nodes.iter().zip(0..).filter(|(node, i)| *node != i);
            assert_eq!(moved.map(|(node, _)| *node).collect::<Vec<_>>(), expected);
        }
    }
}
