//! The nodes of some volume cells of a mesh, and where these cells meet the others.

use super::bounded::faces_on_cells;
use super::sides::{flat, for_each_side};
use super::{CellRun, CellSet, Cells, Faces, Mesh, NodeBits};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::ranks::raw::List;
use std::ops::Range;

/// Nodes and faces of the marked volume cells of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneSides {
    /// The nodes of these cells.
    pub nodes: NodeBits,
    /// The box around these.
    pub bounds: Bounds,
    /// Nodes that unmarked volume cells have as well, ascending.
    pub interface_nodes: Vec<u32>,
    /// Their positions.
    pub interface_places: Vec<Vector>,
    /// Linear faces with all nodes on the interface that only one marked cell has, in the order of their nodes.
    pub interface_faces: Cells,
    /// The marked cell of each of them.
    pub interface_cells: Vec<u32>,
    /// Boundary faces of marked cells alone, with all nodes on the interface, ascending.
    pub rim_faces: Vec<u32>,
}

impl ZoneSides {
    /// Finds the sides of the marked volume cells. All numbers refer to the whole mesh. All ranks call it and get the same result.
    pub fn of(mesh: &Mesh, marked: &CellSet) -> Self {
        let first = mesh.own_offset();
        let [nodes, outside] = [true, false].map(|side| {
            let nodes = NodeBits::new(&(0..mesh.points.len()));
            let own = mesh.volume_runs_in(mesh.own_cells());
            nodes.add_nodes_of(&mesh.cells, &runs_of(own, first, marked, side));
            mesh.bits_of_all(nodes)
        });
        let is_inside = |node: &usize| nodes.has(mesh.number_of_node(*node as u32));
        let inside = mesh.own_nodes().filter(is_inside);
        let bounds = Bounds::around(inside.map(|node| &mesh.points[node]));
        let is_shared = |number: u32| nodes.has(number) && outside.has(number);
        let on_interface = |node: &u32| is_shared(mesh.number_of_node(*node));
        let numbers = 0..mesh.n_nodes_of_all() as u32;
        let interface_nodes: Vec<u32> = numbers.filter(|number| is_shared(*number)).collect();
        let is_marked = |cell: u32| marked.contains(cell as usize);
        let (interface_faces, interface_cells) = faces_between(mesh, is_marked, on_interface);
        Self {
            bounds: mesh.united(bounds),
            interface_places: mesh.values_of_nodes(&interface_nodes, |node| mesh.points[node]),
            interface_faces,
            interface_cells,
            rim_faces: faces_on_rim(mesh, is_marked, on_interface),
            interface_nodes,
            nodes,
        }
    }
}

/// Consecutive cells of some runs that are marked, or with `side` false those that are not; the first cell of all has the number
/// `first` among those that are marked.
pub(super) fn runs_of<'a>(
    runs: impl Iterator<Item = CellRun<'a>>,
    first: usize,
    marked: &CellSet,
    side: bool,
) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for run in runs {
        let own = run.first_cell..run.first_cell + run.n_cells();
        let mut end = own.start;
        for range in marked.ranges_in(first + own.start..first + own.end) {
            let range = range.start - first..range.end - first;
            if side {
                found.push(range.clone())
            } else {
                found.push(end..range.start)
            }
            end = range.end;
        }
        if !side {
            found.push(end..own.end);
        }
    }
    found.retain(|range| !range.is_empty());
    found
}

/// Boundary faces whose nodes are all on the interface and that a marked cell has but none of the others, ascending.
fn faces_on_rim(
    mesh: &Mesh,
    is_marked: impl Fn(u32) -> bool + Sync,
    is_on: impl Fn(&u32) -> bool,
) -> Vec<u32> {
    let own = own_faces_of_nodes(mesh, is_on).into_iter();
    let own = own.map(|face| mesh.number_of_cell(face)).collect();
    let found = mesh.ranks().allgather(List(own)).into_iter();
    let mut found: Vec<u32> = found.flat_map(|List(own)| own).collect();
    let [outside, inside] =
        [false, true].map(|side| faces_on_cells(mesh, &found, |cell| is_marked(cell) == side));
    let mut at = 0..;
    let mut is_on_rim = |at: u32| inside.has(at) && !outside.has(at);
    found.retain(|_| at.next().is_some_and(&mut is_on_rim));
    found
}

/// Own boundary faces that have none but these nodes, ascending.
pub(super) fn own_faces_of_nodes(mesh: &Mesh, is_on: impl Fn(&u32) -> bool) -> Vec<u32> {
    let own = mesh.own_cells();
    let mut faces = faces_of_nodes(&mesh.cells, mesh.dimension(), is_on);
    faces.retain(|&face| own.contains(&(face as usize)));
    faces
}

/// Boundary faces that have none but these nodes, ascending.
pub(super) fn faces_of_nodes(
    cells: &Cells,
    dimension: u8,
    is_on: impl Fn(&u32) -> bool,
) -> Vec<u32> {
    let runs = cells.runs();
    let boundary = runs.filter(|run| run.kind.dimension() + 1 == dimension);
    let on = boundary.flat_map(|run| {
        let cells = (run.first_cell as u32..).zip(run.cells());
        cells.filter(|(_, nodes)| nodes.iter().all(&is_on))
    });
    on.map(|(cell, _)| cell).collect()
}

/// Faces of one of the marked cells only, all on the interface, in the order of their nodes, and that cell of each, with the numbers
/// of the whole mesh. Cells are marked by their numbers there.
pub(super) fn faces_between(
    mesh: &Mesh,
    is_marked: impl Fn(u32) -> bool + Sync,
    is_on: impl Fn(&u32) -> bool + Sync,
) -> (Cells, Vec<u32>) {
    let faces = Faces::of_cells(mesh, |cell| {
        cell.nodes.iter().any(&is_on) && is_marked(mesh.number_of_cell(cell.index as u32))
    });
    let own = mesh.own_cells();
    let mut found: Vec<(Vec<u32>, Vec<u32>, u32)> = Vec::new();
    for outer in &faces.outer {
        if !own.contains(&(outer.cell as usize)) {
            continue;
        }
        let cell = mesh.cells.get(outer.cell as usize);
        for_each_side(&mesh.cells, &cell, |face, corners| {
            if face == outer.face as usize && corners.iter().all(&is_on) {
                let numbers = corners.iter().map(|&node| mesh.number_of_node(node));
                let corners: Vec<u32> = numbers.collect();
                let mut key = corners.clone();
                key.sort_unstable();
                found.push((key, corners, mesh.number_of_cell(outer.cell)));
            }
        });
    }
    let mut found = mesh.ranks().allgather(found).concat();
    found.sort_unstable();
    let mut single = Cells::new();
    for (_, face, _) in &found {
        single.push(flat(face.len()), face);
    }
    (single, found.iter().map(|of| of.2).collect())
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    #[test]
    fn boundary_faces_with_all_nodes_on_the_rim_go_with_the_cell_of_the_zone() {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 6]);
        for tetra in [[0, 1, 2, 3], [0, 1, 3, 4], [1, 2, 3, 5]] {
            mesh.cells.push(CellKind::Tetrahedron, &tetra);
        }
        // Of the zone, between both, of the zone, outside, the first again.
        for face in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [0, 1, 4], [2, 1, 0]] {
            mesh.cells.push(CellKind::Triangle, &face);
        }
        let marked = [0].into_iter().collect();
        let sides = ZoneSides::of(&mesh, &marked);
        assert_eq!(sides.interface_nodes, [0, 1, 2, 3]);
        assert_eq!(sides.rim_faces, [3, 5, 7]);
    }
}
