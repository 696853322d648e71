//! A mesh with its cells in another order.

use super::{Cells, DataArray, Group, Mesh, MeshView, Origin};

impl Cells {
    /// These cells, in this order.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn select(&self, order: impl IntoIterator<Item = usize>) -> Self {
        let mut cells = Self::new();
        cells.reserve(self.connectivity().len());
        for cell in order {
            let cell = self.get(cell);
            match self.face_stream(cell.index) {
                Some(stream) => cells
                    .push_polyhedron_with_nodes(cell.nodes, stream)
                    .expect("it was checked when it was added"),
                None => cells.push(cell.kind, cell.nodes),
            }
        }
        cells
    }
}

impl MeshView<'_> {
    /// The mesh with its cells in this order, which has every cell once; groups and arrays follow.
    pub fn with_cells_in_order(&self, order: &[usize]) -> Mesh {
        let mut new_index = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            new_index[old] = new;
        }
        let group = |group: &Group| Group {
            cells: group.cells.iter().map(|cell| new_index[cell]).collect(),
            ..group.clone()
        };
        let array = |array: &&DataArray| DataArray {
            values: array.values.select(array.n_components, order),
            ..DataArray::clone(array)
        };
        Mesh {
            points: self.points.to_vec(),
            cells: self.cells.select(order.iter().copied()),
            groups: self.groups.iter().map(group).collect(),
            point_arrays: self.point_arrays.iter().copied().cloned().collect(),
            cell_arrays: self.cell_arrays.iter().map(array).collect(),
            field_arrays: self.field_arrays.iter().copied().cloned().collect(),
            space: self.space,
            origin: Origin::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, Values};
    use super::*;

    #[test]
    fn groups_and_arrays_follow_their_cells() {
        let mut mesh = Mesh::default();
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        let tetrahedron = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
        mesh.cells
            .push_polyhedron(&tetrahedron)
            .expect("a good stream");
        mesh.cells.push(CellKind::Triangle, &[1, 2, 3]);
        mesh.groups.push(Group {
            dimension: 2,
            name: "wall".into(),
            number: None,
            condition: None,
            cells: [2].into_iter().collect(),
        });
        let id = Values::I32(vec![10, 11, 12]);
        mesh.cell_arrays.push(DataArray::scalar("id", id));
        let other = mesh.view().with_cells_in_order(&[1, 2, 0]);
        assert_eq!(other.cells.face_stream(0), Some(&tetrahedron[..]));
        assert_eq!(other.cells.get(1).nodes, [1, 2, 3]);
        assert_eq!(other.groups[0].cells.iter().collect::<Vec<_>>(), [1]);
        assert_eq!(other.cell_arrays[0].values, Values::I32(vec![11, 12, 10]));
    }
}
