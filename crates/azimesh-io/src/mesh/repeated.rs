//! Boundary faces that a file lists once per group, made one face in several groups.

use super::{CellSet, Mesh, Values};
use std::collections::{BTreeMap, BTreeSet};

impl Mesh {
    /// Merges boundary faces with the same nodes, of one kind and in different groups, into the
    /// first of them, which then belongs to the groups of all. Files that hold one group a face
    /// repeat a face that is in two. Two faces of one group are a baffle's and stay. Of values in arrays
    /// the first that is a number stays.
    pub fn merge_repeated_faces(&mut self) {
        let dimension = self.dimension();
        let tagged = self.boundary_tags().filter(|tag| !tag.cells.is_empty());
        if dimension == 0 || tagged.count() < 2 {
            return;
        }
        self.merge_repeated_cells(dimension - 1);
    }

    /// Merges cells of this dimension in the same way.
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
            let n = array.n_components;
            match &mut array.values {
                Values::F32(values) => fill_missing(values, n, &replaced_by, |x| x.is_nan()),
                Values::F64(values) => fill_missing(values, n, &replaced_by, |x| x.is_nan()),
                _ => {}
            }
            array.values = array.values.select(n, &keep);
        }
        self.cells = self.cells.select(keep);
    }

    /// Repeated cells and the first cell with the same nodes in none of their groups.
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
        let coincident = |same: &[(Vec<u32>, usize)]| same.iter().map(|(_, cell)| *cell).collect();
        let sets: Vec<Vec<usize>> = faces
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|same| same.len() > 1)
            .map(coincident)
            .collect();
        drop(faces);
        let groups = self.groups_of(sets.iter().flatten().copied().collect());
        let mut replaced_by = BTreeMap::new();
        for set in &sets {
            // Cells that stay, with the groups they get.
            let mut kept: Vec<(usize, BTreeSet<usize>)> = Vec::new();
            for cell in set {
                let own = groups.get(cell).cloned().unwrap_or_default();
                let is_other = |(_, known): &&mut (usize, BTreeSet<usize>)| {
                    !known.is_empty() && !own.is_empty() && known.is_disjoint(&own)
                };
                match kept.iter_mut().find(is_other) {
                    Some((first, known)) => {
                        replaced_by.insert(*cell, *first);
                        known.extend(own);
                    }
                    None => kept.push((*cell, own)),
                }
            }
        }
        replaced_by
    }

    /// The groups of each of these cells that is in one.
    fn groups_of(&self, mut cells: Vec<usize>) -> BTreeMap<usize, BTreeSet<usize>> {
        cells.sort_unstable();
        let mut groups: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for (i, group) in self.groups.iter().enumerate() {
            for range in group.cells.ranges() {
                let first = cells.partition_point(|cell| *cell < range.start);
                for cell in cells[first..].iter().take_while(|cell| **cell < range.end) {
                    groups.entry(*cell).or_default().insert(i);
                }
            }
        }
        groups
    }
}

/// Fills the values of kept cells that have none (NaN in every component) from the first cell replaced by them that has one.
fn fill_missing<T: Copy>(
    values: &mut [T],
    n_components: usize,
    replaced_by: &BTreeMap<usize, usize>,
    is_missing: impl Fn(&T) -> bool,
) {
    let row = |cell: usize| cell * n_components..(cell + 1) * n_components;
    for (&repeated, &kept) in replaced_by {
        if values[row(kept)].iter().all(&is_missing) {
            values.copy_within(row(repeated), kept * n_components);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, DataArray, Group};
    use super::*;

    #[test]
    fn a_face_listed_under_two_tags_becomes_one_face_in_both() {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 3]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.cells.push(CellKind::Line, &[1, 2]);
        mesh.cells.push(CellKind::Line, &[1, 0]);
        for (name, cells) in [("wall", vec![1, 2]), ("probe", vec![3])] {
            mesh.groups
                .push(Group::new(1, name, None, cells.into_iter().collect()));
        }
        let id = Values::I32(vec![10, 11, 12, 13]);
        mesh.cell_arrays.push(DataArray::scalar("id", id));
        let heat = vec![[1.0, 2.0], [f64::NAN; 2], [3.0, f64::NAN], [4.0, f64::NAN]];
        let heat = Values::F64(heat.into_flattened());
        mesh.cell_arrays.push(DataArray::tuples("heat", 2, heat));
        mesh.merge_repeated_faces();
        assert_eq!(mesh.cells.len(), 3);
        assert_eq!(mesh.groups[0].cells.iter().collect::<Vec<_>>(), [1, 2]);
        assert_eq!(mesh.groups[1].cells.iter().collect::<Vec<_>>(), [1]);
        assert_eq!(mesh.cell_arrays[0].values, Values::I32(vec![10, 11, 12]));
        // The face had no value under its first tag, but under its second.
        let Values::F64(heat) = &mesh.cell_arrays[1].values else {
            panic!("they were reals");
        };
        assert_eq!((&heat[..3], heat[4]), (&[1.0, 2.0, 4.0][..], 3.0));
        mesh.validate().expect("it stays a good mesh");
    }

    #[test]
    fn a_baffle_keeps_both_its_faces_in_each_of_its_tags() {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 3]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        for nodes in [[0, 1], [1, 0], [0, 1], [1, 0], [0, 1]] {
            mesh.cells.push(CellKind::Line, &nodes);
        }
        for (name, cells) in [("baffle", vec![1, 2]), ("probe", vec![3, 4])] {
            mesh.groups
                .push(Group::new(1, name, None, cells.into_iter().collect()));
        }
        mesh.merge_repeated_faces();
        // The last is in no tag.
        assert_eq!(mesh.cells.len(), 4);
        assert_eq!(mesh.groups[0].cells.iter().collect::<Vec<_>>(), [1, 2]);
        assert_eq!(mesh.groups[1].cells.iter().collect::<Vec<_>>(), [1, 2]);
    }
}
