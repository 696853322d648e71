//! Joins parts that share no nodes where their faces coincide, or are within a distance.

use super::connected::UnionFind;
use super::faces::OuterFace;
use super::near::Grid;
use super::nodes::for_each_shared_place;
use super::sides::side_corners;
use super::{Faces, Mesh, Origin};
use azimesh_core::error::{Error, Result, option};
use azimesh_core::geometry::vector::{add, cross, dot, scale, sub};
use azimesh_core::numbers::{point, short};
use azimesh_core::parallel::{collect, concat_blocks};
use std::collections::BTreeSet;

/// Counts of [`Mesh::join_zones`] and of joins within a distance.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct JoinCounts {
    /// Pairs of joined faces.
    pub n_faces: usize,
    /// Removed nodes.
    pub n_nodes: usize,
    /// Groups that lost faces: name, number of removed and of remaining faces. Groups without faces are removed.
    pub tags: Vec<(String, usize, usize)>,
}

/// Edge of a box of the grid, in distances of a join.
const BOX: f64 = 4.0;
/// Nodes per block of a parallel search.
const CHUNK: usize = 1 << 14;

/// Default joining distance, relative to the diagonal of the mesh.
pub const RELATIVE_DISTANCE: f64 = 1e-6;

impl Mesh {
    /// Number of pairs of faces that [`join_zones`](Self::join_zones) joins.
    pub fn n_joinable_faces(&self) -> usize {
        self.pairs(&self.places(), &Faces::of(self), |_| 0).len()
    }

    /// Joins cells whose outer faces coincide exactly, if neither face has a tag. Coincident nodes of the two cells become one:
    /// the first, with its values. Boundary cells without a tag on these faces are removed. Walls of no thickness, which have a
    /// tag, stay.
    ///
    /// `O(n log n)`; memory: about 40 bytes per node.
    pub fn join_zones(&mut self) -> JoinCounts {
        let (places, faces) = (self.places(), Faces::of(self));
        let pairs = self.pairs(&places, &faces, |_| 0);
        self.join(&places, &faces, &pairs)
    }

    /// Joins like [`join_zones`](Self::join_zones), with corners within `distance`: two nodes of parts that share no nodes coincide if
    /// each is the nearest node of its part to the other.
    ///
    /// # Errors
    /// If two nodes of one part would be joined.
    pub fn join_within(&mut self, distance: f64) -> Result<JoinCounts> {
        self.join_parts(distance, |_| 0)
    }

    /// Joins like [`join_within`](Self::join_within). Faces of two parts are joined even with tags, unless one is a wall; each node has
    /// the number of its part.
    ///
    /// # Errors
    /// If two nodes of one part would be joined, or parts overlap at a common face.
    pub fn join_parts(&mut self, distance: f64, part: impl Fn(u32) -> u32) -> Result<JoinCounts> {
        let (places, faces) = (self.places_within(distance)?, Faces::of(self));
        let pairs = self.pairs(&places, &faces, part);
        self.check_apart(&pairs)?;
        Ok(self.join(&places, &faces, &pairs))
    }

    fn join(&mut self, places: &[u32], faces: &Faces, pairs: &[[OuterFace; 2]]) -> JoinCounts {
        if pairs.is_empty() {
            return JoinCounts::default();
        }
        let mut first = UnionFind::new(self.points.len());
        for [one, other] in pairs {
            let nodes_of = |face: &OuterFace| self.cells.get(face.cell as usize).nodes;
            for &node in nodes_of(one) {
                let at_place = |twin: &&u32| places[**twin as usize] == places[node as usize];
                if let Some(&twin) = nodes_of(other).iter().find(at_place) {
                    first.join(&[node, twin]);
                }
            }
        }
        let first = (0..self.points.len() as u32).map(|node| first.of(node));
        JoinCounts {
            n_faces: pairs.len(),
            ..self.unite(&first.collect::<Vec<_>>(), &faces.between())
        }
    }

    /// Refuses pairs of faces whose cells are on the same side of them.
    fn check_apart(&self, pairs: &[[OuterFace; 2]]) -> Result<()> {
        if self.dimension() < self.space_dimension() {
            return Ok(());
        }
        let at = |node: &u32| self.points[*node as usize];
        let mean = |nodes: &[u32]| {
            let sum = nodes.iter().map(at).fold([0.0; 3], add);
            scale(sum, 1.0 / nodes.len() as f64)
        };
        let overlap = pairs.iter().find_map(|pair| {
            let cells = pair.map(|face| self.cells.get(face.cell as usize));
            side_corners(&self.cells, &cells[0], pair[0].face as usize, |corners| {
                let edge = |i: usize| sub(at(&corners[i]), at(&corners[0]));
                let normal = match corners.len() {
                    2 => [edge(1)[1], -edge(1)[0], 0.0],
                    n => (2..n)
                        .map(|i| cross(edge(i - 1), edge(i)))
                        .fold([0.0; 3], add),
                };
                let middle = mean(corners);
                let [one, other] = cells.map(|cell| dot(normal, sub(mean(cell.nodes), middle)));
                (one * other > 0.0).then_some(middle)
            })
            .map(|middle| (pair, middle))
        });
        let Some(([one, other], middle)) = overlap else {
            return Ok(());
        };
        Err(Error::input(format!(
            "parts overlap: cells {} and {} are on the same side of the face at {}; parts that are joined touch at their faces and share no volume",
            one.cell,
            other.cell,
            point(&middle)
        )))
    }

    /// Renumbers each node to `first`, an earlier node or itself. Boundary cells that are now between two cells, and were not
    /// `between` two cells before, are removed.
    pub(super) fn unite(&mut self, first: &[u32], between: &[u32]) -> JoinCounts {
        self.cells.renumber_nodes(first);
        let is_kept = |node: &usize| first[*node] as usize == *node;
        let nodes: Vec<usize> = (0..first.len()).filter(is_kept).collect();
        let n_nodes = self.points.len() - nodes.len();
        let mut is_united = vec![false; self.points.len()];
        for (node, first) in first.iter().enumerate() {
            is_united[*first as usize] |= *first as usize != node;
        }
        let mut gone = vec![false; self.cells.len()];
        for cell in Faces::of(self).between() {
            gone[cell as usize] = between.binary_search(&cell).is_err();
        }
        self.mark_repeated(&is_united, &mut gone);
        let before: Vec<usize> = self.groups.iter().map(|group| group.cells.len()).collect();
        self.keep_nodes(&nodes);
        let cells: Vec<usize> = (0..gone.len()).filter(|cell| !gone[*cell]).collect();
        self.keep_cells(&cells);
        self.origin = Origin::default();
        let groups = self.groups.iter().zip(&before);
        let lost = groups.filter(|(group, n)| group.cells.len() < **n);
        let lost = lost.map(|(group, n)| {
            let left = group.cells.len();
            (group.name.clone(), n - left, left)
        });
        let tags = lost.collect();
        let mut before = before.into_iter();
        self.groups
            .retain(|group| before.next() == Some(0) || !group.cells.is_empty());
        JoinCounts {
            n_faces: 0,
            n_nodes,
            tags,
        }
    }

    /// Marks edges and points of lower dimension than the boundary that repeat earlier ones after the join.
    fn mark_repeated(&self, is_united: &[bool], gone: &mut [bool]) {
        let dimension = self.dimension();
        let mut known = BTreeSet::new();
        let runs = self.cells.runs();
        for run in runs.filter(|run| run.kind.dimension() + 1 < dimension) {
            for cell in run.cell_refs() {
                if cell.nodes.iter().all(|node| is_united[*node as usize]) {
                    let mut nodes = cell.nodes.to_vec();
                    nodes.sort_unstable();
                    gone[cell.index] = !known.insert((cell.kind, nodes));
                }
            }
        }
    }

    /// Returns the first node at the position of each node.
    fn places(&self) -> Vec<u32> {
        let mut places: Vec<u32> = (0..self.points.len() as u32).collect();
        for_each_shared_place(&self.points, &mut |nodes| {
            for node in nodes {
                places[*node as usize] = nodes[0];
            }
        });
        places
    }

    /// Returns the representative of the position of each node. Two nodes of parts that share no nodes coincide if each is the nearest
    /// node of its part to the other, within `distance`.
    fn places_within(&self, distance: f64) -> Result<Vec<u32>> {
        let mut places = self.places();
        if distance == 0.0 {
            return Ok(places);
        }
        let mut parts = UnionFind::new(places.len());
        self.cells.iter().for_each(|cell| parts.join(cell.nodes));
        let mut is_outer = vec![false; places.len()];
        for face in Faces::of(self).outer {
            for node in self.cells.get(face.cell as usize).nodes {
                is_outer[*node as usize] = true;
            }
        }
        // A node stands for all of its part at its place: (part, place, node).
        let outer = (0..places.len() as u32).filter(|node| is_outer[*node as usize]);
        let mut nodes: Vec<(u32, u32, u32)> = outer
            .map(|node| (parts.of(node), places[node as usize], node))
            .collect();
        nodes.sort_unstable();
        let all = nodes.clone();
        nodes.dedup_by_key(|(part, place, _)| (*part, *place));
        let mut joined = UnionFind::new(places.len());
        for [a, b] in self.nearest_pairs(&nodes, distance) {
            joined.join(&[a, b]);
        }
        let mut clusters: Vec<(u32, u32, u32)> = nodes
            .iter()
            .map(|(part, _, node)| (joined.of(*node), *part, *node))
            .collect();
        clusters.sort_unstable();
        let twice = clusters
            .windows(2)
            .find(|two| (two[0].0, two[0].1) == (two[1].0, two[1].1));
        if let Some([(_, _, a), (_, _, b)]) = twice.and_then(|two| two.first_chunk()) {
            return Err(Error::input(format!(
                "nodes {a} and {b} of one part would become one node within {}; use a smaller {}",
                short(distance),
                option("join")
            )));
        }
        for (part, place, node) in all {
            let at = nodes.partition_point(|other| (other.0, other.1) < (part, place));
            places[node as usize] = joined.of(nodes[at].2);
        }
        Ok(places)
    }

    /// Returns pairs of nodes of different parts, each the nearest node of its part to the other, within `distance`. Ties go to the
    /// first.
    fn nearest_pairs(&self, nodes: &[(u32, u32, u32)], distance: f64) -> Vec<[u32; 2]> {
        let numbers = collect(nodes.len(), |i| nodes[i].2);
        let grid = Grid::of(&self.points, &numbers, distance, BOX, usize::MAX);
        let mut part_of = vec![u32::MAX; self.points.len()];
        nodes
            .iter()
            .for_each(|(part, _, node)| part_of[*node as usize] = *part);
        // (node, part of the other, squared distance, the other), of each node and part the nearest.
        let mut near = concat_blocks(nodes.len(), CHUNK, &|range| {
            let mut near: Vec<(u32, u32, f64, u32)> = Vec::new();
            for (part, _, node) in &nodes[range] {
                let at = self.points[*node as usize];
                let from = near.len();
                grid.visit(at, |other| {
                    let there = self.points[other as usize];
                    let squared = (0..3).map(|k| (at[k] - there[k]).powi(2)).sum::<f64>();
                    let its_part = part_of[other as usize];
                    if its_part != *part && squared <= distance * distance {
                        near.push((*node, its_part, squared, other));
                    }
                });
                near[from..].sort_unstable_by(|a, b| {
                    (a.1.cmp(&b.1))
                        .then(a.2.total_cmp(&b.2))
                        .then(a.3.cmp(&b.3))
                });
            }
            near.dedup_by_key(|(node, part, _, _)| (*node, *part));
            near
        });
        near.sort_unstable_by_key(|(node, part, _, _)| (*node, *part));
        let is_mutual = |&&(node, part, _, other): &&(u32, u32, f64, u32)| {
            let own = part_of[node as usize];
            let back = near.binary_search_by_key(&(other, own), |entry| (entry.0, entry.1));
            own < part && back.is_ok_and(|at| near[at].3 == node)
        };
        let mutual = near.iter().filter(is_mutual);
        mutual.map(|&(node, _, _, other)| [node, other]).collect()
    }

    /// Returns pairs of coincident outer faces: both without a tag, or of two parts and no walls.
    fn pairs(
        &self,
        places: &[u32],
        faces: &Faces,
        part: impl Fn(u32) -> u32,
    ) -> Vec<[OuterFace; 2]> {
        let mut is_shared = vec![false; places.len()];
        for (node, place) in places.iter().enumerate() {
            if *place as usize != node {
                is_shared[*place as usize] = true;
            }
        }
        let tagged = self.in_a_boundary_tag();
        let walls = self.walls();
        // Corners by their places, the part, whether there is a tag, the face.
        type Found = (Vec<u32>, u32, bool, OuterFace);
        let mut found: Vec<Found> = Vec::new();
        for face in &faces.outer {
            if face.boundary.is_some_and(|cell| walls[cell as usize]) {
                continue;
            }
            let cell = self.cells.get(face.cell as usize);
            side_corners(&self.cells, &cell, face.face as usize, |corners| {
                let mut key: Vec<u32> = corners.iter().map(|node| places[*node as usize]).collect();
                if key.iter().all(|place| is_shared[*place as usize]) {
                    key.sort_unstable();
                    let has_tag = face.boundary.is_some_and(|cell| tagged[cell as usize]);
                    found.push((key, part(cell.nodes[0]), has_tag, *face));
                }
            });
        }
        found.sort_unstable();
        let pairs = found.chunk_by(|a, b| a.0 == b.0).flat_map(|same| {
            let bare = same.iter().filter(|face| !face.2).collect::<Vec<_>>();
            let of_two_parts = |two: &[Found]| matches!(two, [a, b] if a.1 != b.1);
            match (same, &bare[..]) {
                ([a, b], _) if of_two_parts(same) => Some([a.3, b.3]),
                (_, [a, b]) if a.3.cell != b.3.cell => Some([a.3, b.3]),
                _ => None,
            }
        });
        pairs.collect()
    }

    /// Marks cells in boundary tags with the condition of a wall, by the words of OpenFOAM and CGNS.
    fn walls(&self) -> Vec<bool> {
        let mut walls = vec![false; self.cells.len()];
        let is_wall = |condition: &str| condition == "wall" || condition.starts_with("BCWall");
        let tags = self.boundary_tags();
        for tag in tags.filter(|tag| tag.condition.as_deref().is_some_and(is_wall)) {
            tag.cells.ranges().for_each(|range| walls[range].fill(true));
        }
        walls
    }
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
            tags: Vec::new(),
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
    fn parts_that_overlap_are_refused() {
        let mut mesh = squares();
        let mut moved = mesh.clone();
        moved.points.iter_mut().for_each(|x| x[0] += 2.0);
        let mut beside = mesh.clone();
        beside.append(&moved).expect("they are plane");
        let part = |node: u32| node / 16;
        let counts = beside.join_parts(1e-9, part).expect("they touch");
        assert_eq!(counts.n_faces, 4 + 4 + 2);
        mesh.append(&squares()).expect("they are plane");
        let error = mesh.join_parts(1e-9, part).expect_err("they overlap");
        assert!(
            error.message.starts_with("parts overlap: cells 0 and 4 "),
            "{error}"
        );
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
