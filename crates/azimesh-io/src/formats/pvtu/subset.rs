//! Some cells of a mesh, with their nodes and arrays, without groups.

use crate::mesh::{DataArray, Mesh, MeshView};

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
        let of_cells = of_cells.map(|node| *node as usize);
        for node in of_cells.chain(more_nodes.iter().copied()) {
            if self.new_index[node] == u32::MAX {
                self.new_index[node] = 0;
                nodes.push(node);
            }
        }
        nodes.sort_unstable();
        for (new, &old) in nodes.iter().enumerate() {
            self.new_index[old] = new as u32;
        }
        let mut new_cells = mesh.cells.select(cells.iter().copied());
        new_cells.renumber_nodes(&self.new_index);
        for &node in &nodes {
            self.new_index[node] = u32::MAX;
        }
        let part = Mesh {
            points: nodes.iter().map(|&node| mesh.points[node]).collect(),
            cells: new_cells,
            point_arrays: select(&mesh.point_arrays, &nodes),
            cell_arrays: select(&mesh.cell_arrays, cells),
            field_arrays: mesh.field_arrays.iter().copied().cloned().collect(),
            space: mesh.space,
            ..Mesh::default()
        };
        (part, nodes)
    }
}

fn select(arrays: &[&DataArray], keep: &[usize]) -> Vec<DataArray> {
    arrays.iter().map(|array| array.select(keep)).collect()
}
