//! Boundary tags for a mesh that has none: its outer faces, one tag for each connected part.

use super::arrays::append_tuples;
use super::faces::Faces;
use super::sides::side;
use super::{CellSet, Group, Mesh};
use azimesh_core::error::{Error, Result, option};
use std::collections::{BTreeMap, BTreeSet};

/// An outer face without a tag: a boundary cell that is there, or one to be made.
struct Untagged {
    first_node: u32,
    cell: usize,
}

impl Mesh {
    /// Makes boundary cells of the outer faces that have none, and puts all outer faces without a
    /// tag into new tags `boundary_1`, `boundary_2`, ...: faces that share a node into the same. The
    /// largest part comes first. Returns how many cells and tags are new.
    ///
    /// In cell arrays, new cells have the values of the cells that they bound.
    pub fn tag_connected_boundary(&mut self) -> Result<(usize, usize)> {
        let Some(dimension) = self.dimension().checked_sub(1) else {
            return Ok((0, 0));
        };
        let faces = Faces::of(self);
        let mut owners = Vec::new();
        let mut parts = UnionFind::new(self.points.len());
        let mut untagged = Vec::new();
        let tagged = self.in_a_boundary_tag();
        for outer in &faces.outer {
            let cell = match outer.boundary.map(|cell| cell as usize) {
                Some(cell) if tagged[cell] => continue,
                Some(cell) => cell,
                None => {
                    owners.push(outer.cell as usize);
                    self.add_side(outer.cell as usize, outer.face as usize)?
                }
            };
            let nodes = self.cells.get(cell).nodes;
            parts.join(nodes);
            let first_node = nodes[0];
            untagged.push(Untagged { first_node, cell });
        }
        append_tuples(&mut self.cell_arrays, &owners);
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for face in &untagged {
            let part = parts.of(face.first_node);
            members.entry(part).or_default().push(face.cell);
        }
        let mut sets: Vec<CellSet> = members
            .into_values()
            .map(|cells| cells.into_iter().collect())
            .collect();
        sets.sort_by_key(|set| (usize::MAX - set.len(), set.iter().next()));
        let n_tags = sets.len();
        self.add_boundary_tags(dimension, sets);
        Ok((owners.len(), n_tags))
    }

    /// For each cell, whether a boundary tag holds it.
    pub fn in_a_boundary_tag(&self) -> Vec<bool> {
        let mut tagged = vec![false; self.cells.len()];
        for range in self.boundary_tags().flat_map(|tag| tag.cells.ranges()) {
            tagged[range].fill(true);
        }
        tagged
    }

    fn add_side(&mut self, cell: usize, face: usize) -> Result<usize> {
        let cell = self.cells.get(cell);
        let Some((kind, nodes)) = side(&self.cells, &cell, face) else {
            return Err(Error::input(format!(
                "cell {} is a {} with {} nodes, whose boundary faces cannot be made; make its cells linear first (convert {})",
                cell.index,
                cell.kind.name(),
                cell.nodes.len(),
                option("linearize")
            )));
        };
        self.cells.push(kind, &nodes);
        Ok(self.cells.len() - 1)
    }

    fn add_boundary_tags(&mut self, dimension: u8, sets: Vec<CellSet>) {
        let taken = self.groups.iter().map(|group| group.name.clone());
        let taken: BTreeSet<String> = taken.collect();
        let names = (1..).map(|i| format!("boundary_{i}"));
        let free = names.filter(|name| !taken.contains(name));
        for (cells, name) in sets.into_iter().zip(free) {
            self.groups.push(Group::new(dimension, name, None, cells));
        }
    }
}

/// Numbers in connected parts; a part goes by its smallest number.
pub(crate) struct UnionFind {
    above: Vec<u32>,
}

impl UnionFind {
    pub fn new(n: usize) -> Self {
        Self {
            above: (0..n as u32).collect(),
        }
    }

    pub fn of(&mut self, mut node: u32) -> u32 {
        while self.above[node as usize] != node {
            let next = self.above[self.above[node as usize] as usize];
            self.above[node as usize] = next;
            node = next;
        }
        node
    }

    pub fn join(&mut self, nodes: &[u32]) {
        for pair in nodes.windows(2) {
            let (a, b) = (self.of(pair[0]), self.of(pair[1]));
            self.above[a.max(b) as usize] = a.min(b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, DataArray, Values};
    use super::*;

    /// Two separate squares of two triangles each; the first has one tagged and one untagged edge.
    fn two_squares() -> Mesh {
        let mut mesh = Mesh::of_points(vec![[0.0; 3]; 8]);
        for first in [0, 4] {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
            mesh.cells.push(CellKind::Triangle, &[a, b, c]);
            mesh.cells.push(CellKind::Triangle, &[a, c, d]);
        }
        mesh.cells.push(CellKind::Line, &[0, 1]);
        mesh.cells.push(CellKind::Line, &[2, 1]);
        mesh.groups
            .push(Group::new(1, "boundary_1", None, [4].into_iter().collect()));
        let id = Values::I32(vec![1, 2, 3, 4, 5, 6]);
        mesh.cell_arrays.push(DataArray::scalar("id", id));
        mesh
    }

    #[test]
    fn every_outer_face_gets_a_tag_and_tagged_ones_keep_theirs() {
        let mut mesh = two_squares();
        assert_eq!(mesh.tag_connected_boundary().expect("plain cells"), (6, 2));
        mesh.validate().expect("it stays a good mesh");
        let tags: Vec<_> = mesh
            .boundary_tags()
            .map(|tag| (tag.name.as_str(), tag.cells.len()))
            .collect();
        assert_eq!(
            tags,
            [("boundary_1", 1), ("boundary_2", 4), ("boundary_3", 3)]
        );
        assert!(mesh.groups[2].cells.contains(5));
        assert_eq!(Faces::of(&mesh).bare().count(), 0);
        // Of the edges that were made two belong to each of the first and second triangles, and so on; the
        // edges that were there keep their values.
        let id = Values::I32(vec![1, 2, 3, 4, 5, 6, 2, 2, 3, 3, 4, 4]);
        assert_eq!(mesh.cell_arrays[0].values, id);
        assert_eq!(mesh.tag_connected_boundary().expect("again"), (0, 0));
    }
}
