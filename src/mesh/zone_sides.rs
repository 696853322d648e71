//! The nodes of some volume cells of a mesh, and where these cells meet the others.

use super::sides::for_each_side;
use super::{CellKind, CellRun, CellSet, Cells, Faces, Mesh, NodeBits};
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;
use std::ops::Range;

/// What some volume cells of a mesh have.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneSides {
    /// The nodes of these cells.
    pub nodes: NodeBits,
    /// The box around these.
    pub bounds: Bounds,
    /// Those of them that other volume cells have as well, ascending, and where these are.
    pub interface_nodes: Vec<u32>,
    pub interface_places: Vec<Vector>,
    /// Linear faces whose nodes are all on the interface and that only one of the cells has, in the order of their nodes.
    pub interface_faces: Cells,
    /// The marked cell of each of them.
    pub interface_cells: Vec<u32>,
    /// Boundary faces whose nodes are all on the interface and that lie on marked cells alone, ascending.
    pub rim_faces: Vec<u32>,
}

impl ZoneSides {
    /// Of the volume cells that are marked.
    pub fn of(mesh: &Mesh, marked: &CellSet) -> Self {
        let [nodes, outside] = [true, false].map(|side| {
            let nodes = NodeBits::new(&(0..mesh.points.len()));
            nodes.add_nodes_of(&mesh.cells, &runs_of(mesh.volume_runs(), 0, marked, side));
            nodes
        });
        let of_cells = (0..).zip(&mesh.points);
        let inside = of_cells.filter(|of| nodes.has(of.0)).map(|of| of.1);
        let on_interface = |node: &u32| nodes.has(*node) && outside.has(*node);
        let numbers = 0..mesh.points.len() as u32;
        let interface_nodes: Vec<u32> = numbers.filter(on_interface).collect();
        let place = |&node: &u32| mesh.points[node as usize];
        let (interface_faces, interface_cells) =
            faces_between(mesh, |cell| marked.contains(cell), on_interface);
        Self {
            bounds: Bounds::around(inside),
            interface_places: interface_nodes.iter().map(place).collect(),
            interface_faces,
            interface_cells,
            rim_faces: faces_on_rim(mesh, marked, on_interface),
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
            match side {
                true => found.push(range.clone()),
                false => found.push(end..range.start),
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
    marked: &CellSet,
    is_on: impl Fn(&u32) -> bool + Copy + Sync,
) -> Vec<u32> {
    let mut found = faces_of_nodes(&mesh.cells, mesh.dimension(), is_on);
    if found.is_empty() {
        return found;
    }
    let [outside, inside] = [false, true].map(|side| {
        Faces::of_cells(mesh, |cell| {
            cell.nodes.iter().any(is_on) && marked.contains(cell.index) == side
        })
    });
    let has = |faces: &Faces, cell: u32| faces.dangling.binary_search(&cell).is_err();
    found.retain(|&cell| has(&inside, cell) && !has(&outside, cell));
    found
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

/// Faces of one of the marked cells only, all on the interface, in the order of their nodes, and that cell of each.
pub(super) fn faces_between(
    mesh: &Mesh,
    is_marked: impl Fn(usize) -> bool + Sync,
    is_on: impl Fn(&u32) -> bool + Sync,
) -> (Cells, Vec<u32>) {
    let faces = Faces::of_cells(mesh, |cell| {
        cell.nodes.iter().any(&is_on) && is_marked(cell.index)
    });
    let mut found: Vec<(Vec<u32>, Vec<u32>, u32)> = Vec::new();
    for outer in &faces.outer {
        let cell = mesh.cells.get(outer.cell as usize);
        for_each_side(&mesh.cells, &cell, |face, corners| {
            if face == outer.face as usize && corners.iter().all(&is_on) {
                let mut key = corners.to_vec();
                key.sort_unstable();
                found.push((key, corners.to_vec(), outer.cell));
            }
        });
    }
    found.sort_unstable();
    let mut single = Cells::new();
    for (_, face, _) in &found {
        let kind = match face.len() {
            1 => CellKind::Vertex,
            2 => CellKind::Line,
            3 => CellKind::Triangle,
            4 => CellKind::Quadrilateral,
            _ => CellKind::Polygon,
        };
        single.push(kind, face);
    }
    (single, found.iter().map(|of| of.2).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundary_faces_with_all_nodes_on_the_rim_go_with_the_cell_of_the_zone() {
        let mut mesh = Mesh {
            points: vec![[0.0; 3]; 6],
            ..Mesh::default()
        };
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
