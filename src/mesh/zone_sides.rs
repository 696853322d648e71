//! The nodes of some volume cells of a mesh, and where these cells meet the others.

use super::sides::for_each_side;
use super::{CellKind, Cells, Faces, Mesh};
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;

/// What some volume cells of a mesh have.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneSides {
    /// For each node of the mesh, whether one of the cells has it.
    pub nodes: Vec<bool>,
    /// The box around these.
    pub bounds: Bounds,
    /// Those of them that other volume cells have as well, ascending, and where these are.
    pub interface_nodes: Vec<u32>,
    pub interface_places: Vec<Vector>,
    /// Linear faces whose nodes are all on the interface and that only one of the cells has, in the order of their nodes.
    pub interface_faces: Cells,
    /// Boundary faces whose nodes are all on the interface and that lie on marked cells alone, ascending.
    pub rim_faces: Vec<u32>,
}

impl ZoneSides {
    /// Of the volume cells that are marked.
    pub fn of(mesh: &Mesh, marked: &[bool]) -> Self {
        let (nodes, interface) = nodes_in_and_between(mesh, marked);
        let of_cells = mesh.points.iter().zip(&nodes);
        let inside = of_cells.filter(|(_, inside)| **inside).map(|(x, _)| x);
        let on_interface = |node: &u32| interface[*node as usize];
        let numbers = 0..interface.len() as u32;
        let interface_nodes: Vec<u32> = numbers.filter(on_interface).collect();
        let place = |&node: &u32| mesh.points[node as usize];
        Self {
            bounds: Bounds::around(inside),
            interface_places: interface_nodes.iter().map(place).collect(),
            interface_faces: faces_between(mesh, |cell| marked[cell], on_interface),
            rim_faces: faces_on_rim(mesh, marked, &interface),
            interface_nodes,
            nodes,
        }
    }
}

/// Nodes of the cells marked, and those of them that other volume cells have as well.
fn nodes_in_and_between(mesh: &Mesh, marked: &[bool]) -> (Vec<bool>, Vec<bool>) {
    let mut inside = vec![false; mesh.points.len()];
    let mut outside = vec![false; mesh.points.len()];
    for run in mesh.volume_runs() {
        for (nodes, &marked) in run.cells().zip(&marked[run.first_cell..]) {
            let side = if marked { &mut inside } else { &mut outside };
            for &node in nodes {
                side[node as usize] = true;
            }
        }
    }
    for (outside, &inside) in outside.iter_mut().zip(&inside) {
        *outside &= inside;
    }
    (inside, outside)
}

/// Boundary faces whose nodes are all on the interface and that a marked cell has but none of the others, ascending.
fn faces_on_rim(mesh: &Mesh, marked: &[bool], interface: &[bool]) -> Vec<u32> {
    let is_on = |node: &u32| interface[*node as usize];
    let mut found = faces_of_nodes(&mesh.cells, mesh.dimension(), is_on);
    if found.is_empty() {
        return found;
    }
    let [outside, inside] = [false, true].map(|side| {
        Faces::of_cells(mesh, |cell| {
            marked[cell.index] == side && cell.nodes.iter().any(is_on)
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

/// Faces of one of the marked cells only, all on the interface, in the order of their nodes.
pub(super) fn faces_between(
    mesh: &Mesh,
    is_marked: impl Fn(usize) -> bool + Sync,
    is_on: impl Fn(&u32) -> bool + Sync,
) -> Cells {
    let faces = Faces::of_cells(mesh, |cell| {
        is_marked(cell.index) && cell.nodes.iter().any(&is_on)
    });
    let mut found: Vec<(Vec<u32>, Vec<u32>)> = Vec::new();
    for outer in &faces.outer {
        let cell = mesh.cells.get(outer.cell as usize);
        for_each_side(&mesh.cells, &cell, |face, corners| {
            if face == outer.face as usize && corners.iter().all(&is_on) {
                let mut key = corners.to_vec();
                key.sort_unstable();
                found.push((key, corners.to_vec()));
            }
        });
    }
    found.sort_unstable();
    let mut single = Cells::new();
    for (_, face) in found {
        let kind = match face.len() {
            1 => CellKind::Vertex,
            2 => CellKind::Line,
            3 => CellKind::Triangle,
            4 => CellKind::Quadrilateral,
            _ => CellKind::Polygon,
        };
        single.push(kind, &face);
    }
    single
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
        let marked = [vec![true], vec![false; 7]].concat();
        let sides = ZoneSides::of(&mesh, &marked);
        assert_eq!(sides.interface_nodes, [0, 1, 2, 3]);
        assert_eq!(sides.rim_faces, [3, 5, 7]);
    }
}
