//! Boundary faces that a file lists once per group, made one face in several groups.

use super::{CellSet, Cells, Mesh};
use std::collections::BTreeMap;

impl Mesh {
    /// Merges boundary faces with the same nodes, of one kind, into the first of them, which then
    /// belongs to the groups of all. Files that hold one group a face repeat a face that is in two.
    pub fn merge_repeated_faces(&mut self) {
        let dimension = self.dimension();
        let tagged = self.boundary_tags().filter(|tag| !tag.cells.is_empty());
        if dimension == 0 || tagged.count() < 2 {
            return;
        }
        self.merge_repeated_cells(dimension - 1);
    }

    /// Merges cells of this dimension with the same nodes, of one kind, into the first of them,
    /// which then belongs to the groups of all.
    pub fn merge_repeated_cells(&mut self, dimension: u8) {
        let replaced_by = self.repeated_cells(dimension);
        if replaced_by.is_empty() {
            return;
        }
        let keep: Vec<usize> = (0..self.cells.len())
            .filter(|cell| !replaced_by.contains_key(cell))
            .collect();
        let mut new_index = vec![usize::MAX; self.cells.len()];
        for (new, &old) in keep.iter().enumerate() {
            new_index[old] = new;
        }
        for group in &mut self.groups {
            let renumbered = group
                .cells
                .iter()
                .map(|cell| new_index[*replaced_by.get(&cell).unwrap_or(&cell)]);
            group.cells = renumbered.collect::<CellSet>();
        }
        for array in &mut self.cell_arrays {
            array.values = array.values.select(array.n_components, &keep);
        }
        self.cells = self.cells_without(&replaced_by);
    }

    /// Repeated cells and the first cell with the same nodes.
    fn repeated_cells(&self, dimension: u8) -> BTreeMap<usize, usize> {
        let mut faces: Vec<(Vec<u32>, usize)> = self
            .cells
            .iter()
            .filter(|cell| cell.kind.dimension() == dimension)
            .map(|cell| {
                let mut nodes = cell.nodes.to_vec();
                nodes.sort_unstable();
                nodes.push(cell.kind.vtk().into());
                (nodes, cell.index)
            })
            .collect();
        faces.sort_unstable();
        let mut replaced_by = BTreeMap::new();
        let mut first = 0;
        for i in 1..faces.len() {
            if faces[i].0 == faces[first].0 {
                replaced_by.insert(faces[i].1, faces[first].1);
            } else {
                first = i;
            }
        }
        replaced_by
    }

    fn cells_without(&self, removed: &BTreeMap<usize, usize>) -> Cells {
        let mut cells = Cells::new();
        cells.reserve(self.cells.connectivity().len());
        for cell in self.cells.iter() {
            if removed.contains_key(&cell.index) {
                continue;
            }
            match self.cells.face_stream(cell.index) {
                Some(stream) => cells
                    .push_polyhedron_with_nodes(cell.nodes, stream)
                    .expect("it was checked when it was added"),
                None => cells.push(cell.kind, cell.nodes),
            }
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, DataArray, Group, Values};
    use super::*;

    #[test]
    fn a_face_listed_under_two_tags_becomes_one_face_in_both() {
        let mut mesh = Mesh {
            points: vec![[0.0; 3]; 3],
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.cells.push(CellKind::Line, &[1, 2]);
        mesh.cells.push(CellKind::Line, &[1, 0]);
        for (name, cells) in [("wall", vec![1, 2]), ("probe", vec![3])] {
            mesh.groups.push(Group {
                dimension: 1,
                name: name.into(),
                number: None,
                condition: None,
                cells: cells.into_iter().collect(),
            });
        }
        let id = Values::I32(vec![10, 11, 12, 13]);
        mesh.cell_arrays.push(DataArray::scalar("id", id));
        mesh.merge_repeated_faces();
        assert_eq!(mesh.cells.len(), 3);
        assert_eq!(mesh.groups[0].cells.iter().collect::<Vec<_>>(), [1, 2]);
        assert_eq!(mesh.groups[1].cells.iter().collect::<Vec<_>>(), [1]);
        assert_eq!(mesh.cell_arrays[0].values, Values::I32(vec![10, 11, 12]));
        mesh.validate().expect("it stays a good mesh");
    }
}
