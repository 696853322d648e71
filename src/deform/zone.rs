//! Cuts the deforming zone from the rest of the mesh where it is to turn: interface nodes are
//! duplicated, and the zone's cells take the copies.

use crate::error::{Error, Result};
use crate::mesh::{Cells, DataArray, Faces, Mesh};
use crate::motion::{DeformingZone, Motion};

/// Duplicates the interface nodes of the motion's zone in `mesh`, and makes the motion speak of the
/// copies. Copies follow the other nodes, in the order of their originals.
pub fn detach(mesh: &mut Mesh, motion: &mut Motion) -> Result<()> {
    let Some(zone) = &mut motion.zone else {
        return Ok(());
    };
    let n = mesh.points.len();
    if n + zone.sides.interface_nodes.len() > u32::MAX as usize {
        return Err(Error::input(
            "the mesh would have more than 4294967295 nodes",
        ));
    }
    let originals = zone.sides.interface_nodes.clone();
    let rim = faces_on_rim(mesh, zone);
    let copy = |node: u32| match originals.binary_search(&node) {
        Ok(at) => (n + at) as u32,
        Err(_) => node,
    };
    mesh.cells = renumber(
        &mesh.cells,
        |cell, nodes| rim.binary_search(&cell).is_ok() || belongs(zone, &originals, cell, nodes),
        copy,
    )?;
    zone.sides.interface_faces = renumber(&zone.sides.interface_faces, |_, _| true, copy)?;
    for &node in &originals {
        mesh.points.push(mesh.points[node as usize]);
        zone.sides.nodes[node as usize] = false;
        zone.sides.nodes.push(true);
    }
    for array in &mut mesh.point_arrays {
        repeat_tuples(array, n, &originals);
    }
    zone.sides.interface_nodes = originals.iter().map(|&node| copy(node)).collect();
    let surface = &mut motion.surface.nodes;
    let mut roles: Vec<_> = surface
        .nodes
        .iter()
        .map(|&node| copy(node))
        .zip(surface.roles.clone())
        .collect();
    roles.sort_unstable_by_key(|entry| entry.0);
    (surface.nodes, surface.roles) = roles.into_iter().unzip();
    Ok(())
}

/// Whether a cell goes with the zone: its own cells, and boundary faces with a node inside it.
fn belongs(zone: &DeformingZone, interface: &[u32], cell: usize, nodes: &[u32]) -> bool {
    zone.cells[cell]
        || nodes.iter().all(|&node| zone.sides.nodes[node as usize])
            && nodes
                .iter()
                .any(|node| interface.binary_search(node).is_err())
}

/// Boundary faces whose nodes are all on the interface and that a cell of the zone has but none
/// outside it, ascending.
fn faces_on_rim(mesh: &Mesh, zone: &DeformingZone) -> Vec<usize> {
    let mut interface = vec![false; mesh.points.len()];
    for &node in &zone.sides.interface_nodes {
        interface[node as usize] = true;
    }
    let is_on = |node: &u32| interface[*node as usize];
    let runs = mesh.cells.runs();
    let boundary = runs.filter(|run| run.kind.dimension() + 1 == mesh.dimension());
    let on_interface = boundary.flat_map(|run| {
        let cells = run.cells().enumerate();
        let on = cells.filter(|(_, nodes)| nodes.iter().all(is_on));
        on.map(move |(i, _)| run.first_cell + i)
    });
    let mut found: Vec<usize> = on_interface.collect();
    if found.is_empty() {
        return found;
    }
    let [outside, inside] = [false, true].map(|in_zone| {
        Faces::of_cells(mesh, |cell| {
            zone.cells[cell.index] == in_zone && cell.nodes.iter().any(is_on)
        })
    });
    let has = |faces: &Faces, cell: usize| faces.dangling.binary_search(&(cell as u32)).is_err();
    found.retain(|&cell| has(&inside, cell) && !has(&outside, cell));
    found
}

fn renumber(
    cells: &Cells,
    takes: impl Fn(usize, &[u32]) -> bool,
    copy: impl Fn(u32) -> u32,
) -> Result<Cells> {
    let mut renumbered = Cells::new();
    renumbered.reserve(cells.connectivity().len());
    let mut nodes = Vec::new();
    for cell in cells.iter() {
        let moved = takes(cell.index, cell.nodes);
        let number = |&node: &u32| if moved { copy(node) } else { node };
        nodes.clear();
        nodes.extend(cell.nodes.iter().map(number));
        if cells.face_stream(cell.index).is_none() {
            renumbered.push(cell.kind, &nodes);
            continue;
        }
        let mut stream = vec![cells.polyhedron_faces(cell.index).count() as u32];
        for face in cells.polyhedron_faces(cell.index) {
            stream.push(face.len() as u32);
            stream.extend(face.iter().map(number));
        }
        renumbered.push_polyhedron_with_nodes(&nodes, &stream)?;
    }
    Ok(renumbered)
}

fn repeat_tuples(array: &mut DataArray, n: usize, nodes: &[u32]) {
    let keep: Vec<usize> = (0..n)
        .chain(nodes.iter().map(|&node| node as usize))
        .collect();
    array.values = array.values.select(array.n_components, &keep);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Bounds;
    use crate::mesh::{CellKind, ZoneSides};

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
        let zone = DeformingZone {
            cells: [vec![true], vec![false; 7]].concat(),
            sides: ZoneSides {
                nodes: vec![true, true, true, true, false, false],
                bounds: Bounds::EMPTY,
                interface_nodes: vec![0, 1, 2, 3],
                interface_places: vec![[0.0; 3]; 4],
                interface_faces: Cells::new(),
            },
        };
        assert_eq!(faces_on_rim(&mesh, &zone), [3, 5, 7]);
    }
}
