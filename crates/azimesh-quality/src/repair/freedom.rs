//! Constraints of nodes: fixed, sliding in a plane or along a line, partners together.

use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::sides::{for_each_side, side};
use azimesh_io::mesh::{Across, Adjacency, Mesh};
use azimesh_rbf::constraint::Constraint;
use std::collections::BTreeMap;

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
    pub fn inner(mesh: &Mesh, adjacency: &Adjacency) -> Self {
        Self::inside(mesh, adjacency, &|_| true)
    }

    /// With the nodes of those faces of the boundary fixed for whose nodes `holds` is true.
    pub fn inside(
        mesh: &Mesh,
        adjacency: &Adjacency,
        holds: &(dyn Fn(&[u32]) -> bool + Sync),
    ) -> Self {
        let mut freedom = Self::new(mesh.points.len());
        let of_chunks = parallel::map(adjacency.n_chunks(), &|chunk| {
            let (cells, mut sides) = adjacency.chunk(chunk);
            let (mut nodes, mut outer) = (Vec::new(), Vec::new());
            for run in mesh.volume_runs_in(cells) {
                for cell in run.cell_refs() {
                    for_each_side(&mesh.cells, &cell, |face, corners| {
                        if let Across::Outside(_) = sides.across()
                            && holds(corners)
                        {
                            nodes.extend_from_slice(corners);
                            if run.kind.is_curved() {
                                let all = side(&mesh.cells, &cell, face);
                                nodes.extend(all.map_or(cell.nodes.to_vec(), |(_, all)| all));
                            }
                            outer.push((cell.index as u32, face as u16));
                        }
                    });
                }
            }
            (nodes, outer)
        });
        for (nodes, outer) in of_chunks {
            for node in nodes {
                freedom.fixed[node as usize] = true;
            }
            freedom.outer.extend(outer);
        }
        let dimension = mesh.dimension();
        for run in mesh
            .cells
            .runs()
            .filter(|run| run.kind.dimension() < dimension)
        {
            for cell in run.cell_refs().filter(|cell| holds(cell.nodes)) {
                for &node in cell.nodes {
                    freedom.fixed[node as usize] = true;
                }
            }
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

/// The part of a displacement that a node may make.
pub(super) fn allowed(held: Option<&Constraint>, by: Vector) -> Vector {
    held.map_or(by, |held| held.remove(by))
}
