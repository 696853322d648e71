//! Boundary faces that a file lists once per group, made one face in several groups; between two cells, two faces that are a
//! wall of no thickness.

use super::arrays::append_tuples;
use super::faces::{entries, for_each_face};
use super::walls::wall;
use super::{CellRef, CellSet, Cells, Mesh, NodeBits, Values};
use std::collections::{BTreeMap, BTreeSet};

impl Mesh {
    /// Merges boundary faces with the same nodes, of one kind and in different groups, into the
    /// first of them, which then belongs to the groups of all. Files that hold one group a face
    /// repeat a face that is in two. Two faces of one group are a baffle's and stay. Of values in arrays
    /// the first that is a number stays.
    ///
    /// Between two cells, faces that turn against each other stay, each with its groups: they are a wall of no thickness. So
    /// is a face there that is in two boundary tags: it becomes two faces, the first with the first tag.
    pub fn merge_repeated_faces(&mut self) {
        let dimension = self.dimension();
        let tagged = self.boundary_tags().filter(|tag| !tag.cells.is_empty());
        if dimension == 0 || tagged.count() < 2 {
            return;
        }
        let sets = self.coincident(dimension - 1);
        let mut listed: Vec<usize> = sets.iter().flatten().copied().collect();
        listed.extend(self.in_several_tags());
        listed.sort_unstable();
        let between = self.between_cells(&listed);
        let (walls, others): (Vec<_>, Vec<_>) =
            (sets.into_iter()).partition(|set| between.contains(&set[0]));
        // The faces of each side of a wall.
        let sides = walls.iter().flat_map(|set| {
            let is_first = |face: &&usize| !self.is_turned(set[0], **face);
            let (one, other): (Vec<usize>, Vec<usize>) = set.iter().partition(is_first);
            [one, other]
        });
        let sets: Vec<Vec<usize>> = others.into_iter().chain(sides).collect();
        let mut single = between;
        for set in &walls {
            // Faces of one turn are listed again.
            let is_wall = set.iter().any(|face| self.is_turned(set[0], *face));
            set[usize::from(!is_wall)..].iter().for_each(|face| {
                single.remove(face);
            });
        }
        let new_index = self.merge_cells(self.replaced_by(&sets));
        let single = single.into_iter().map(|face| new_index.get(face).copied());
        let single: Vec<usize> = single.flatten().collect();
        self.make_walls(&single);
    }

    /// Boundary faces in two boundary tags or more.
    fn in_several_tags(&self) -> Vec<usize> {
        let tags: Vec<_> = self.boundary_tags().collect();
        let mut ranges: Vec<_> = tags.iter().flat_map(|tag| tag.cells.ranges()).collect();
        ranges.sort_unstable_by_key(|range| range.start);
        let (mut end, mut several) = (0, Vec::new());
        for range in ranges {
            several.extend(range.start..end.min(range.end));
            end = end.max(range.end);
        }
        several
    }

    /// Returns the boundary faces of this ascending list that are between two cells.
    fn between_cells(&self, faces: &[usize]) -> BTreeSet<usize> {
        if faces.is_empty() {
            return BTreeSet::new();
        }
        let touched = NodeBits::new(&(0..self.points.len()));
        for &face in faces {
            touched.add(self.cells.get(face).nodes);
        }
        let touches = |cell: &CellRef<'_>| cell.nodes.iter().any(|&node| touched.has(node));
        let dimension = self.dimension();
        let mut entries = entries(&self.cells, self.points.len(), dimension, touches);
        let mut found = BTreeSet::new();
        for_each_face(&self.cells, &mut entries, |same| {
            if same.iter().filter(|entry| !entry.is_boundary()).count() == 2 {
                let all = same.iter().filter(|entry| entry.is_boundary());
                let all = all.map(|face| face.cell as usize);
                found.extend(all.filter(|face| faces.binary_search(face).is_ok()));
            }
        });
        found
    }

    /// Checks if two faces with the same nodes turn against each other.
    fn is_turned(&self, one: usize, other: usize) -> bool {
        wall(&self.cells, [one as u32, other as u32]).is_some()
    }

    /// Gives each of these faces a second one for all its boundary tags but the first.
    fn make_walls(&mut self, faces: &[usize]) {
        let dimension = self.dimension();
        let mut turned = Cells::new();
        let mut sources = Vec::new();
        let first = self.cells.len();
        let mut groups = self.groups.clone();
        for &face in faces {
            let cell = self.cells.get(face);
            let is_in =
                |of: &&mut super::Group| of.dimension + 1 == dimension && of.cells.contains(face);
            let further: Vec<_> = groups.iter_mut().filter(is_in).skip(1).collect();
            let mut one = Cells::new();
            one.push(cell.kind, cell.nodes);
            // A curved face without a known mirror image gets no second face.
            let Some(image) = one.mirrored().ok().filter(|_| !further.is_empty()) else {
                continue;
            };
            turned.append(&image);
            for group in further {
                let others = group.cells.iter().filter(|cell| *cell != face);
                group.cells = others.chain([first + sources.len()]).collect();
            }
            sources.push(face);
        }
        self.groups = groups;
        self.cells.append(&turned);
        append_tuples(&mut self.cell_arrays, &sources);
    }

    /// Merges cells of this dimension as [`merge_repeated_faces`](Self::merge_repeated_faces) does faces on the outside.
    pub fn merge_repeated_cells(&mut self, dimension: u8) {
        self.merge_cells(self.replaced_by(&self.coincident(dimension)));
    }

    /// Replaces cells; returns the new number of each cell that stays.
    fn merge_cells(&mut self, replaced_by: BTreeMap<usize, usize>) -> Vec<usize> {
        if replaced_by.is_empty() {
            return (0..self.cells.len()).collect();
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
        new_index
    }

    /// Returns sets of cells of a dimension that have the same nodes, each ascending.
    fn coincident(&self, dimension: u8) -> Vec<Vec<usize>> {
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
        let sets = faces.chunk_by(|a, b| a.0 == b.0);
        sets.filter(|same| same.len() > 1).map(coincident).collect()
    }

    /// Repeated cells, of some with the same nodes, and the first cell in none of their groups.
    fn replaced_by(&self, sets: &[Vec<usize>]) -> BTreeMap<usize, usize> {
        let groups = self.groups_of(sets.iter().flatten().copied().collect());
        let mut replaced_by = BTreeMap::new();
        for set in sets {
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

    /// Two squares with these lines, a list of them for each tag, between them.
    fn two_squares(tags: &[&[[u32; 2]]]) -> Mesh {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 6]);
        mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 4, 3]);
        mesh.cells.push(CellKind::Quadrilateral, &[1, 2, 5, 4]);
        for (at, lines) in tags.iter().enumerate() {
            let first = mesh.cells.len();
            lines
                .iter()
                .for_each(|line| mesh.cells.push(CellKind::Line, line));
            let cells = (first..mesh.cells.len()).collect();
            mesh.groups
                .push(Group::new(1, format!("tag {at}"), None, cells));
        }
        let ids = (0..mesh.cells.len() as i32).collect();
        mesh.cell_arrays = vec![DataArray::scalar("id", Values::I32(ids))];
        mesh.merge_repeated_faces();
        mesh.validate().expect("it stays a good mesh");
        mesh
    }

    /// The tag of the line on the side of each cell, where that is an outer face of it.
    fn sides(mesh: &Mesh) -> Vec<(u32, Vec<usize>)> {
        let faces = crate::mesh::Faces::of(mesh);
        let lined = faces
            .outer
            .iter()
            .filter_map(|face| Some((face.cell, face.boundary? as usize)));
        let tags = |line: usize| {
            let groups = mesh.groups.iter().enumerate();
            groups
                .filter(|(_, of)| of.cells.contains(line))
                .map(|(at, _)| at)
                .collect()
        };
        lined.map(|(cell, line)| (cell, tags(line))).collect()
    }

    #[test]
    fn faces_between_two_cells_in_two_tags_are_a_wall() {
        // The lines of the first cell turn from 1 to 4.
        let lines: [(&[&[[u32; 2]]], _); 5] = [
            (&[&[[1, 4]], &[[4, 1]]], vec![(0, vec![0]), (1, vec![1])]),
            (&[&[[4, 1]], &[[1, 4]]], vec![(0, vec![1]), (1, vec![0])]),
            (&[&[[1, 4]], &[[1, 4]]], vec![(0, vec![0]), (1, vec![1])]),
            (
                &[&[[1, 4], [4, 1]], &[[0, 1]]],
                vec![(0, vec![0]), (0, vec![1]), (1, vec![0])],
            ),
            (
                &[&[[1, 4]], &[[4, 1]], &[[4, 1], [1, 4]]],
                vec![(0, vec![0, 2]), (1, vec![1, 2])],
            ),
        ];
        for (tags, mut expected) in lines {
            let mesh = two_squares(tags);
            let mut found = sides(&mesh);
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected, "{tags:?}");
            let again = crate::mesh::Adjacency::of(&mesh);
            assert_eq!((again.n_inner(), again.n_outer()), (0, 8), "{tags:?}");
        }
        for tags in [
            &[&[[1, 4]][..], &[[0, 1]]][..],
            &[&[[1, 4], [1, 4]], &[[0, 1]]],
        ] {
            assert_eq!(crate::mesh::Adjacency::of(&two_squares(tags)).n_inner(), 1);
        }
    }
}
