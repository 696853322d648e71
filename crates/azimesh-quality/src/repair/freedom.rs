//! Constraints of nodes: fixed, sliding in a plane or along a line, partners together.

use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::sides::{for_each_side, side};
use azimesh_io::mesh::{Across, Adjacency, CellRef, CellRun, Coincident, Mesh};
use azimesh_rbf::constraint::Constraint;
use std::collections::{BTreeMap, BTreeSet};

/// Rotations of a node that differ by less are one.
const SAME_ROTATION: f64 = 1e-9;

/// A node that goes where its leader's image goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partner {
    /// The node.
    pub node: u32,
    /// The node that it follows, which follows none itself.
    pub leader: u32,
    /// Rotates the leader's displacement to the node's.
    pub map: Transform,
}

/// Constraints of every node of a mesh. Nodes that are not named are free.
#[derive(Debug, Clone, Default)]
pub struct Freedom {
    fixed: Vec<bool>,
    held: BTreeMap<u32, Constraint>,
    partners: Vec<Partner>,
    /// Outer faces: cells, ascending, and which of their faces.
    outer: Vec<(u32, u16)>,
}

impl Freedom {
    /// Of a mesh with so many nodes: all are free.
    pub fn new(n_nodes: usize) -> Self {
        Self {
            fixed: vec![false; n_nodes],
            ..Self::default()
        }
    }

    /// All nodes of the boundary are fixed: nodes of outer faces, and of cells of a lower dimension.
    pub fn inner(mesh: &Mesh, adjacency: &Adjacency, copies: &Coincident) -> Self {
        Self::inside(mesh, adjacency, copies, &|_| true)
    }

    /// With the nodes of those faces of the boundary fixed for whose nodes `holds` is true. Two outer faces on the same
    /// places are no boundary, unless all of their nodes belong to cells of a lower dimension.
    pub fn inside(
        mesh: &Mesh,
        adjacency: &Adjacency,
        copies: &Coincident,
        holds: &(dyn Fn(&[u32]) -> bool + Sync),
    ) -> Self {
        let mut freedom = Self::new(mesh.points.len());
        let dimension = mesh.dimension();
        let below = |run: &CellRun<'_>| run.kind.dimension() < dimension;
        for run in mesh.cells.runs().filter(below) {
            for cell in run.cell_refs().filter(|cell| holds(cell.nodes)) {
                for &node in cell.nodes {
                    freedom.fixed[node as usize] = true;
                }
            }
        }
        let paired = paired_faces(mesh, adjacency, copies);
        let is_inner = |cell: usize, face: usize, corners: &[u32]| {
            paired.contains(&(cell as u32, face as u16))
                && corners.iter().any(|&node| !freedom.is_fixed(node))
        };
        let of_chunks = parallel::map(adjacency.n_chunks(), &|chunk| {
            let (mut nodes, mut outer) = (Vec::new(), Vec::new());
            for_each_outer(mesh, adjacency, chunk, &mut |cell, face, corners| {
                if holds(corners) && !is_inner(cell.index, face, corners) {
                    nodes.extend_from_slice(corners);
                    if cell.kind.is_curved() {
                        let all = side(&mesh.cells, cell, face);
                        nodes.extend(all.map_or(cell.nodes.to_vec(), |(_, all)| all));
                    }
                    outer.push((cell.index as u32, face as u16));
                }
            });
            (nodes, outer)
        });
        for (nodes, outer) in of_chunks {
            for node in nodes {
                freedom.fixed[node as usize] = true;
            }
            freedom.outer.extend(outer);
        }
        freedom
    }

    /// Holds a node where it is.
    pub fn fix(&mut self, node: u32) {
        self.fixed[node as usize] = true;
    }

    /// Lets a node move as it likes.
    pub fn free(&mut self, node: u32) {
        self.fixed[node as usize] = false;
        self.held.remove(&node);
    }

    /// Lets a node move across the directions of a constraint only.
    pub fn hold(&mut self, node: u32, constraint: Constraint) {
        self.fixed[node as usize] = constraint.rank() == 3;
        if constraint.rank() > 0 {
            self.held.insert(node, constraint);
        } else {
            self.held.remove(&node);
        }
    }

    /// Holds a node in one more direction.
    pub fn hold_too(&mut self, node: u32, normal: Vector) {
        let held = self.held.get(&node);
        let mut normals = held.map_or(Vec::new(), |held| held.columns().to_vec());
        normals.push(normal);
        self.hold(node, Constraint::of_normals(&normals));
    }

    /// Makes nodes follow others; in any order, each node once.
    pub fn pair(&mut self, mut partners: Vec<Partner>) {
        partners.sort_unstable_by_key(|partner| partner.node);
        self.partners = partners;
    }

    /// Makes the copies of a node one node with the constraints of all of them. It follows the constraints and the partners.
    pub fn unite(&mut self, copies: &Coincident) {
        if copies.is_empty() {
            return;
        }
        let mut links: BTreeMap<u32, Vec<(u32, Transform)>> = BTreeMap::new();
        let mut link = |from: u32, to: u32, map: Transform| {
            links.entry(from).or_default().push((to, map));
            links.entry(to).or_default().push((from, map.inverse()));
        };
        copies
            .pairs()
            .for_each(|(node, first)| link(first, node, Transform::IDENTITY));
        for Partner { node, leader, map } in std::mem::take(&mut self.partners) {
            link(leader, node, map);
        }
        let mut partners = Vec::new();
        let mut known: BTreeMap<u32, Transform> = BTreeMap::new();
        for &leader in links.keys() {
            if known.contains_key(&leader) {
                continue;
            }
            known.insert(leader, Transform::IDENTITY);
            let mut all = vec![leader];
            let mut is_fixed = false;
            let mut at = 0;
            while let Some(&node) = all.get(at) {
                at += 1;
                is_fixed |= self.is_fixed(node);
                for (next, map) in &links[&node] {
                    let map = known[&node].then(map);
                    match known.get(next) {
                        Some(other) => is_fixed |= !turn_alike(&map, other),
                        None => {
                            known.insert(*next, map);
                            all.push(*next);
                        }
                    }
                }
            }
            let normals = all.iter().flat_map(|node| {
                let back = known[node].inverse();
                let held = self.held(*node).map_or(&[][..], Constraint::columns);
                held.iter().map(move |normal| back.turn(*normal))
            });
            let held = Constraint::of_normals(&normals.collect::<Vec<_>>());
            if is_fixed || held.rank() == 3 {
                all.into_iter().for_each(|node| self.fix(node));
                continue;
            }
            self.hold(leader, held);
            partners.extend(all[1..].iter().map(|&node| Partner {
                node,
                leader,
                map: known[&node],
            }));
        }
        self.pair(partners);
    }

    /// Returns whether a node stays where it is.
    #[inline]
    pub fn is_fixed(&self, node: u32) -> bool {
        self.fixed[node as usize]
    }

    /// The directions in which a node that moves is held.
    pub(super) fn held(&self, node: u32) -> Option<&Constraint> {
        self.held.get(&node)
    }

    /// The leader of a node.
    pub(super) fn partner(&self, node: u32) -> Option<&Partner> {
        let at = self
            .partners
            .binary_search_by_key(&node, |partner| partner.node);
        at.ok().map(|at| &self.partners[at])
    }

    /// The outer faces, where they are known: cells, ascending, each with the number of its face.
    pub(super) fn outer(&self) -> &[(u32, u16)] {
        &self.outer
    }

    /// All that follow others.
    pub(super) fn partners(&self) -> &[Partner] {
        &self.partners
    }
}

/// Returns whether two maps turn a displacement alike.
fn turn_alike(a: &Transform, b: &Transform) -> bool {
    let entries = a.rotation.iter().flatten();
    let mut pairs = entries.zip(b.rotation.iter().flatten());
    pairs.all(|(a, b)| (a - b).abs() < SAME_ROTATION)
}

/// Calls `visit` with the cell, the number and the corners of each outer face of a chunk.
fn for_each_outer(
    mesh: &Mesh,
    adjacency: &Adjacency,
    chunk: usize,
    visit: &mut dyn FnMut(&CellRef<'_>, usize, &[u32]),
) {
    let (cells, mut sides) = adjacency.chunk(chunk);
    for run in mesh.volume_runs_in(cells) {
        for cell in run.cell_refs() {
            for_each_side(&mesh.cells, &cell, |face, corners| {
                if let Across::Outside(_) = sides.across() {
                    visit(&cell, face, corners);
                }
            });
        }
    }
}

/// Returns the outer faces that coincide with another: each as its cell and the number of its face.
fn paired_faces(mesh: &Mesh, adjacency: &Adjacency, copies: &Coincident) -> BTreeSet<(u32, u16)> {
    if copies.is_empty() {
        return BTreeSet::new();
    }
    let faces = parallel::map(adjacency.n_chunks(), &|chunk| {
        let mut faces = Vec::new();
        for_each_outer(mesh, adjacency, chunk, &mut |cell, face, corners| {
            if corners.iter().all(|&node| copies.is_shared(node)) {
                let mut places: Vec<u32> = corners.iter().map(|&node| copies.first(node)).collect();
                places.sort_unstable();
                faces.push((places, (cell.index as u32, face as u16)));
            }
        });
        faces
    });
    let mut faces = faces.concat();
    faces.sort_unstable();
    let pairs = faces.chunk_by(|a, b| a.0 == b.0);
    let pairs =
        pairs.filter(|pair| pair.len() == 2 && pair[0].0.windows(2).all(|two| two[0] < two[1]));
    pairs.flatten().map(|(_, face)| *face).collect()
}

/// The part of a displacement that a node may make.
pub(super) fn allowed(held: Option<&Constraint>, by: Vector) -> Vector {
    held.map_or(by, |held| held.remove(by))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{grid, repaired_with};
    use super::*;
    use azimesh_core::geometry::vector::distance;
    use azimesh_io::mesh::CellKind;

    /// A cube of hexahedra with nodes of their own at x > 1/2: each node at x = 1/2 has a copy.
    fn two_blocks(n: usize) -> (Mesh, Vec<u32>) {
        let whole = grid(CellKind::Hexahedron, n);
        let is_at_cut = |node: &u32| (whole.points[*node as usize][0] - 0.5).abs() < 1e-9;
        let cut: Vec<u32> = (0..whole.points.len() as u32).filter(is_at_cut).collect();
        let mut mesh = Mesh {
            points: whole.points.clone(),
            ..Mesh::default()
        };
        mesh.points
            .extend(cut.iter().map(|&node| whole.points[node as usize]));
        for cell in whole.cells.iter() {
            let is_right = cell
                .nodes
                .iter()
                .any(|&node| whole.points[node as usize][0] > 0.51);
            let copy = |&node: &u32| match cut.binary_search(&node) {
                Ok(at) if is_right => (whole.points.len() + at) as u32,
                _ => node,
            };
            mesh.cells
                .push(cell.kind, &cell.nodes.iter().map(copy).collect::<Vec<_>>());
        }
        (mesh, cut)
    }

    #[test]
    fn a_mesh_of_two_blocks_is_repaired_as_one_and_no_copy_moves_alone() {
        let whole = grid(CellKind::Hexahedron, 8);
        let (blocks, cut) = two_blocks(8);
        let push = |points: &mut [Vector]| {
            for x in points {
                // Inside, and in the bottom.
                let near = |at: Vector| distance(*x, at) < 1e-9;
                if near([0.5; 3]) || near([0.5, 0.25, 0.0]) {
                    x[0] += 0.16;
                    x[1] += 0.14;
                }
            }
        };
        let bottom = Constraint::of_normals(&[[0.0, 0.0, 1.0]]);
        let repaired = |mesh: &Mesh| {
            let copies = Coincident::of(&mesh.points, |_| 0);
            let mut freedom = Freedom::inner(mesh, &Adjacency::of(mesh), &copies);
            for (node, x) in (0..).zip(&mesh.points) {
                if x[2] == 0.0 && x[..2].iter().all(|x| *x > 0.01 && *x < 0.99) {
                    freedom.hold(node, bottom);
                }
            }
            freedom.unite(&copies);
            let mut points = mesh.points.clone();
            push(&mut points);
            let found = repaired_with(mesh, &mut points, &freedom);
            assert!(found.patches.iter().all(|patch| patch.invalid_before > 2));
            assert_eq!(found.unrepaired, []);
            points
        };
        let (one, two) = (repaired(&whole), repaired(&blocks));
        let n = whole.points.len();
        for (node, (x, y)) in one.iter().zip(&two).enumerate() {
            assert!(distance(*x, *y) < 1e-9, "{node}");
            assert!(whole.points[node][2] > 0.0 || y[2] == 0.0);
        }
        for (at, &node) in cut.iter().enumerate() {
            assert_eq!(two[node as usize], two[n + at]);
        }
    }

    /// Copies of so many nodes by their classes.
    fn copies(classes: &[f64]) -> Coincident {
        let points: Vec<Vector> = classes.iter().map(|&x| [x, 0.0, 0.0]).collect();
        Coincident::of(&points, |_| 0)
    }

    #[test]
    fn a_node_has_the_constraints_of_all_of_its_copies() {
        let mut freedom = Freedom::new(5);
        freedom.hold(0, Constraint::of_normals(&[[1.0, 0.0, 0.0]]));
        freedom.hold(2, Constraint::of_normals(&[[0.0, 1.0, 0.0]]));
        freedom.fix(4);
        freedom.unite(&copies(&[7.0, 8.0, 7.0, 8.0, 8.0]));
        assert_eq!(freedom.held(0).map(Constraint::rank), Some(2));
        assert_eq!(freedom.partners().len(), 1);
        assert!([1, 3, 4].into_iter().all(|node| freedom.is_fixed(node)));
        assert!(!freedom.is_fixed(0) && !freedom.is_fixed(2));
    }

    #[test]
    fn copies_of_periodic_partners_follow_one_leader_and_a_loop_that_turns_is_fixed() {
        let turn = Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], 0.5);
        let partner = |leader, node| Partner {
            node,
            leader,
            map: turn,
        };
        // 1 and 4 are copies of one node, and follow 0, which has the copy 3.
        let mut freedom = Freedom::new(5);
        freedom.hold(4, Constraint::of_normals(&[turn.turn([1.0, 0.0, 0.0])]));
        freedom.pair(vec![partner(0, 1)]);
        freedom.unite(&copies(&[1.0, 2.0, 3.0, 1.0, 2.0]));
        let found: Vec<_> = freedom
            .partners()
            .iter()
            .map(|of| (of.node, of.leader))
            .collect();
        assert_eq!(found, [(1, 0), (3, 0), (4, 0)]);
        assert!(
            freedom
                .partner(4)
                .is_some_and(|of| turn_alike(&of.map, &turn))
        );
        assert!(
            freedom
                .partner(3)
                .is_some_and(|of| turn_alike(&of.map, &Transform::IDENTITY))
        );
        let held = freedom.held(0).expect("as its copies");
        assert!(distance(held.columns()[0], [1.0, 0.0, 0.0]) < 1e-12);
        // Its own partner: no displacement but that along the axis fits.
        let mut freedom = Freedom::new(2);
        freedom.pair(vec![partner(0, 1)]);
        freedom.unite(&copies(&[1.0, 1.0]));
        assert!(freedom.is_fixed(0) && freedom.is_fixed(1) && freedom.partners().is_empty());
    }
}
