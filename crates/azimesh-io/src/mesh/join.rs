//! Joins zones that share no nodes where their faces coincide.

use super::faces::OuterFace;
use super::nodes::for_each_shared_place;
use super::sides::side_corners;
use super::{Faces, Mesh, Origin};

/// Counts of [`Mesh::join_zones`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct JoinCounts {
    /// Pairs of faces that are one now.
    pub n_faces: usize,
    /// Nodes that are gone.
    pub n_nodes: usize,
}

impl Mesh {
    /// Number of pairs of faces that [`join_zones`](Self::join_zones) joins.
    pub fn n_joinable_faces(&self) -> usize {
        self.pairs(&self.places()).len()
    }

    /// Joins cells whose outer faces coincide exactly, if neither face has a tag. Coincident nodes of the two cells become one:
    /// the first, with its values. Boundary cells without a tag on these faces are removed. Walls of no thickness, which have a
    /// tag, stay.
    ///
    /// `O(n log n)`; memory: about 40 bytes per node.
    pub fn join_zones(&mut self) -> JoinCounts {
        let places = self.places();
        let pairs = self.pairs(&places);
        if pairs.is_empty() {
            return JoinCounts::default();
        }
        let mut first: Vec<u32> = (0..self.points.len() as u32).collect();
        for [one, other] in &pairs {
            let nodes_of = |face: &OuterFace| self.cells.get(face.cell as usize).nodes;
            for &node in nodes_of(one) {
                let at_place = |twin: &&u32| places[**twin as usize] == places[node as usize];
                if let Some(&twin) = nodes_of(other).iter().find(at_place) {
                    let [a, b] = [root(&mut first, node), root(&mut first, twin)];
                    first[a.max(b) as usize] = a.min(b);
                }
            }
        }
        for node in 0..first.len() as u32 {
            root(&mut first, node);
        }
        self.cells.renumber_nodes(&first);
        let is_kept = |node: &usize| first[*node] as usize == *node;
        let nodes: Vec<usize> = (0..first.len()).filter(is_kept).collect();
        let n_nodes = self.points.len() - nodes.len();
        self.keep_nodes(&nodes);
        let mut gone = vec![false; self.cells.len()];
        for face in pairs.iter().flatten() {
            if let Some(cell) = face.boundary {
                gone[cell as usize] = true;
            }
        }
        let cells: Vec<usize> = (0..gone.len()).filter(|cell| !gone[*cell]).collect();
        self.keep_cells(&cells);
        self.origin = Origin::default();
        JoinCounts {
            n_faces: pairs.len(),
            n_nodes,
        }
    }

    /// For each node the first one at its place.
    fn places(&self) -> Vec<u32> {
        let mut places: Vec<u32> = (0..self.points.len() as u32).collect();
        for_each_shared_place(&self.points, &mut |nodes| {
            for node in nodes {
                places[*node as usize] = nodes[0];
            }
        });
        places
    }

    /// Pairs of coincident outer faces without a tag.
    fn pairs(&self, places: &[u32]) -> Vec<[OuterFace; 2]> {
        let mut is_shared = vec![false; places.len()];
        for (node, place) in places.iter().enumerate() {
            if *place as usize != node {
                is_shared[*place as usize] = true;
            }
        }
        let tagged = self.in_a_boundary_tag();
        let mut found: Vec<(Vec<u32>, OuterFace)> = Vec::new();
        for face in Faces::of(self).outer {
            if face.boundary.is_some_and(|cell| tagged[cell as usize]) {
                continue;
            }
            let cell = self.cells.get(face.cell as usize);
            side_corners(&self.cells, &cell, face.face as usize, |corners| {
                let mut key: Vec<u32> = corners.iter().map(|node| places[*node as usize]).collect();
                if key.iter().all(|place| is_shared[*place as usize]) {
                    key.sort_unstable();
                    found.push((key, face));
                }
            });
        }
        found.sort_unstable();
        let pairs = found.chunk_by(|a, b| a.0 == b.0);
        let pairs = pairs.filter_map(|same| match same {
            [(_, one), (_, other)] if one.cell != other.cell => Some([*one, *other]),
            _ => None,
        });
        pairs.collect()
    }
}

/// The first node of those that are joined with this one; the way there is made short.
fn root(first: &mut [u32], node: u32) -> u32 {
    let mut at = node;
    while first[at as usize] != at {
        at = first[at as usize];
    }
    first[node as usize] = at;
    at
}

#[cfg(test)]
mod tests {
    use super::super::{CellKind, DataArray, Values};
    use super::*;

    /// Four squares around a node that each has its own, the upper right one without its lower edge as a wall of two
    /// sides.
    fn squares() -> Mesh {
        let mut mesh = Mesh::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let first = mesh.points.len() as u32;
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                mesh.points.push([x + dx, y + dy, 0.0]);
            }
            let nodes = [0, 1, 2, 3].map(|node| first + node);
            mesh.cells.push(CellKind::Quadrilateral, &nodes);
        }
        let numbers = (0..mesh.points.len() as i32).collect();
        mesh.point_arrays = vec![DataArray::scalar("n", Values::I32(numbers))];
        mesh
    }

    #[test]
    fn faces_at_one_place_become_one_and_nodes_that_meet_there_too() {
        let mut mesh = squares();
        assert_eq!(mesh.n_joinable_faces(), 4);
        let counts = mesh.join_zones();
        let expected = JoinCounts {
            n_faces: 4,
            n_nodes: 7,
        };
        assert_eq!(counts, expected);
        mesh.validate().expect("it is a mesh");
        assert_eq!((mesh.points.len(), mesh.n_repeated_nodes()), (9, 0));
        assert_eq!(Faces::of(&mesh).outer.len(), 8);
        let Values::I32(numbers) = &mesh.point_arrays[0].values else {
            panic!("the type changed");
        };
        assert_eq!(numbers, &[0, 1, 2, 3, 5, 6, 10, 11, 14]);
        assert_eq!(mesh.join_zones(), JoinCounts::default());
    }

    #[test]
    fn walls_of_no_thickness_stay_and_edges_without_a_tag_go() {
        let mut mesh = squares();
        // Between the lower squares a wall; between the upper ones an edge of no tag.
        mesh.cells.push(CellKind::Line, &[1, 2]);
        mesh.cells.push(CellKind::Line, &[4, 7]);
        mesh.cells.push(CellKind::Line, &[9, 10]);
        mesh.add_tag("wall", [4, 5]).expect("they are edges");
        let counts = mesh.join_zones();
        assert_eq!(counts.n_faces, 3);
        mesh.validate().expect("it is a mesh");
        assert_eq!(mesh.cells.len(), 6);
        let tag = mesh.boundary_tags().next().expect("it stays");
        assert_eq!(tag.cells.iter().collect::<Vec<_>>(), [4, 5]);
        // The wall's lower end is two nodes, its upper end is one, which all squares have.
        assert_eq!(mesh.n_repeated_nodes(), 1);
        let faces = Faces::of(&mesh);
        assert_eq!((faces.outer.len(), faces.dangling.len()), (10, 0));
    }

    #[test]
    fn curved_cells_are_joined_with_the_nodes_between_their_corners() {
        let mut mesh = Mesh::default();
        for points in [
            [
                [0.0, 0.0],
                [1.0, 0.0],
                [0.0, 1.0],
                [0.5, 0.0],
                [0.6, 0.6],
                [0.0, 0.5],
            ],
            [
                [1.0, 0.0],
                [1.0, 1.0],
                [0.0, 1.0],
                [1.0, 0.5],
                [0.5, 1.0],
                [0.6, 0.6],
            ],
        ] {
            let first = mesh.points.len() as u32;
            mesh.points.extend(points.map(|[x, y]| [x, y, 0.0]));
            let nodes = [0, 1, 2, 3, 4, 5].map(|node| first + node);
            mesh.cells.push(CellKind::Triangle6, &nodes);
        }
        let counts = mesh.join_zones();
        assert_eq!((counts.n_faces, counts.n_nodes), (1, 3));
        mesh.validate().expect("it is a mesh");
        assert_eq!(mesh.n_repeated_nodes(), 0);
    }
}
