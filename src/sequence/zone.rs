//! Cuts the deforming zone from the rest of the mesh where it is to turn: interface nodes are
//! duplicated, and the zone's cells take the copies.

use crate::error::{Error, Result};
use crate::mesh::{Cells, DataArray, Mesh};
use crate::motion::{DeformingZone, Motion};

/// Duplicates the interface nodes of the motion's zone in `mesh`, and makes the motion speak of the
/// copies. Copies follow the other nodes, in the order of their originals.
pub fn detach(mesh: &mut Mesh, motion: &mut Motion) -> Result<()> {
    let Some(zone) = &mut motion.zone else {
        return Ok(());
    };
    let n = mesh.points.len();
    if n + zone.interface_nodes.len() > u32::MAX as usize {
        return Err(Error::input(
            "the mesh would have more than 4294967295 nodes",
        ));
    }
    let originals = zone.interface_nodes.clone();
    let copy = |node: u32| match originals.binary_search(&node) {
        Ok(at) => (n + at) as u32,
        Err(_) => node,
    };
    mesh.cells = renumber(
        &mesh.cells,
        |cell, nodes| belongs(zone, &originals, cell, nodes),
        copy,
    )?;
    zone.interface_faces = renumber(&zone.interface_faces, |_, _| true, copy)?;
    for &node in &originals {
        mesh.points.push(mesh.points[node as usize]);
        zone.nodes[node as usize] = false;
        zone.nodes.push(true);
    }
    for array in &mut mesh.point_arrays {
        repeat_tuples(array, n, &originals);
    }
    zone.interface_nodes = originals.iter().map(|&node| copy(node)).collect();
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
        || nodes.iter().all(|&node| zone.nodes[node as usize])
            && nodes
                .iter()
                .any(|node| interface.binary_search(node).is_err())
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
