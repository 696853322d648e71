//! Some cells of a mesh, with their nodes and arrays; without groups.

use crate::mesh::{Cells, DataArray, Mesh, MeshView};

/// Takes parts out of a mesh, each in a time that goes by its own size.
pub(super) struct Subsets<'m> {
    mesh: &'m MeshView<'m>,
    /// `u32::MAX` but for the nodes of the part that is taken.
    new_index: Vec<u32>,
}

impl<'m> Subsets<'m> {
    /// Parts of this mesh.
    pub fn of(mesh: &'m MeshView<'m>) -> Self {
        Self {
            mesh,
            new_index: vec![u32::MAX; mesh.points.len()],
        }
    }

    /// These cells, ascending, with their nodes and some more, as a mesh; and its nodes, ascending.
    pub fn take(&mut self, cells: &[usize], more_nodes: &[usize]) -> (Mesh, Vec<usize>) {
        let mesh = self.mesh;
        let mut nodes: Vec<usize> = Vec::new();
        let of_cells = cells.iter().flat_map(|cell| mesh.cells.get(*cell).nodes);
        for node in of_cells
            .map(|node| *node as usize)
            .chain(more_nodes.iter().copied())
        {
            if self.new_index[node] == u32::MAX {
                self.new_index[node] = 0;
                nodes.push(node);
            }
        }
        nodes.sort_unstable();
        for (new, &old) in nodes.iter().enumerate() {
            self.new_index[old] = new as u32;
        }
        let mut new_cells = Cells::new();
        for &cell in cells {
            let new_index = |node: u32| self.new_index[node as usize];
            push(&mut new_cells, mesh.cells, cell, new_index);
        }
        for &node in &nodes {
            self.new_index[node] = u32::MAX;
        }
        let part = Mesh {
            points: nodes.iter().map(|&node| mesh.points[node]).collect(),
            cells: new_cells,
            groups: Vec::new(),
            point_arrays: select(&mesh.point_arrays, &nodes),
            cell_arrays: select(&mesh.cell_arrays, cells),
            field_arrays: mesh.field_arrays.iter().copied().cloned().collect(),
            space: mesh.space,
            ..Mesh::default()
        };
        (part, nodes)
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

fn select(arrays: &[&DataArray], keep: &[usize]) -> Vec<DataArray> {
    let selected = arrays.iter().map(|array| DataArray {
        name: array.name.clone(),
        n_components: array.n_components,
        component_names: array.component_names.clone(),
        values: array.values.select(array.n_components, keep),
    });
    selected.collect()
}
