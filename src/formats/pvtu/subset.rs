//! Some cells of a mesh, with their nodes and arrays; without groups.

use crate::mesh::{Cells, DataArray, Mesh};

/// Nodes used by these cells, and nodes for which `also` holds, ascending.
pub(super) fn nodes_of(mesh: &Mesh, cells: &[usize], also: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut used = vec![false; mesh.points.len()];
    for &cell in cells {
        for &node in mesh.cells.get(cell).nodes {
            used[node as usize] = true;
        }
    }
    let wanted = |node: &usize| used[*node] || also(*node);
    (0..used.len()).filter(wanted).collect()
}

/// The cells and nodes, both ascending, as a mesh; the nodes have all that the cells need.
pub(super) fn subset(mesh: &Mesh, cells: &[usize], nodes: &[usize]) -> Mesh {
    let mut new_index = vec![u32::MAX; mesh.points.len()];
    for (new, &old) in nodes.iter().enumerate() {
        new_index[old] = new as u32;
    }
    let mut new_cells = Cells::new();
    for &cell in cells {
        push(&mut new_cells, &mesh.cells, cell, |node| {
            new_index[node as usize]
        });
    }
    Mesh {
        points: nodes.iter().map(|&node| mesh.points[node]).collect(),
        cells: new_cells,
        groups: Vec::new(),
        point_arrays: select(&mesh.point_arrays, nodes),
        cell_arrays: select(&mesh.cell_arrays, cells),
        field_arrays: mesh.field_arrays.clone(),
    }
}

/// Appends a cell of another list, with new node indices.
pub(super) fn push(to: &mut Cells, from: &Cells, cell: usize, renumber: impl Fn(u32) -> u32) {
    let cell = from.get(cell);
    let mut nodes = [0; 32];
    let many: Vec<u32>;
    let nodes = match nodes.get_mut(..cell.nodes.len()) {
        Some(few) => {
            few.iter_mut()
                .zip(cell.nodes)
                .for_each(|(new, old)| *new = renumber(*old));
            &*few
        }
        None => {
            many = cell.nodes.iter().map(|node| renumber(*node)).collect();
            &many
        }
    };
    let Some(stream) = from.face_stream(cell.index) else {
        return to.push(cell.kind, nodes);
    };
    let mut new = vec![stream.first().copied().unwrap_or(0)];
    for face in from.polyhedron_faces(cell.index) {
        new.push(face.len() as u32);
        new.extend(face.iter().map(|node| renumber(*node)));
    }
    to.push_polyhedron_with_nodes(nodes, &new)
        .expect("it was checked when it was added");
}

fn select(arrays: &[DataArray], keep: &[usize]) -> Vec<DataArray> {
    let selected = arrays.iter().map(|array| DataArray {
        name: array.name.clone(),
        n_components: array.n_components,
        component_names: array.component_names.clone(),
        values: array.values.select(array.n_components, keep),
    });
    selected.collect()
}
