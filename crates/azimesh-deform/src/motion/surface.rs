//! The role of every surface node: moving with a body, fixed or sliding.

use super::zones::DeformingZone;
use azimesh_core::parallel;
use azimesh_io::mesh::{Boundary, Coincident, Group};

/// Role of a surface node, strongest first. A node on two tags takes the stronger role. A node on two bodies moves
/// with the body named first: with the parent, of a parent and its child.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// It moves with the body of this index.
    Moving(u16),
    /// It stays where it is.
    Fixed,
    /// It moves along its boundary and never leaves it.
    Sliding,
}

/// Surface nodes: those with a prescribed position, interface nodes of the deforming zone included.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SurfaceNodes {
    /// Node indices of the mesh, ascending.
    pub nodes: Vec<u32>,
    /// Role of each.
    pub roles: Vec<Role>,
}

/// Boundary faces with a role. The faces of an interface are in [`ZoneSides`](azimesh_io::mesh::ZoneSides).
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SurfaceFaces {
    /// Cell indices of the mesh, ascending.
    pub cells: Vec<u32>,
    /// Role of each.
    pub roles: Vec<Role>,
    /// Tag of each, as an index into [`Surface::tags`]; the first of several tags with its role.
    pub tags: Vec<u32>,
}

/// A boundary tag with its role by the schedule; for `azimesh check`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TagRole {
    /// Name of the tag.
    pub tag: String,
    /// Role of its nodes; `None` when they are free or periodic, or when the tag is unnamed and outside the zones
    /// that deform.
    pub role: Option<Role>,
    /// True if it is a side of a periodic pair.
    pub periodic: bool,
}

/// The surface of the deforming part of a mesh.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Surface {
    /// Nodes with a prescribed position.
    pub nodes: SurfaceNodes,
    /// Boundary faces with a role.
    pub faces: SurfaceFaces,
    /// Every boundary tag of the mesh, in file order.
    pub tags: Vec<TagRole>,
    /// Nodes that are also on tags of another body, ascending, with that body.
    pub shared: Vec<(u32, u16)>,
}

impl Surface {
    pub(super) fn find(
        tags: &[&Group],
        named: Vec<TagRole>,
        zone: Option<&DeformingZone>,
        boundary: &Boundary,
    ) -> Self {
        let roles: Vec<Option<Role>> = named.iter().map(|tag| tag.role).collect();
        let nodes = surface_nodes(tags, &roles, zone, boundary);
        Self {
            shared: shared_nodes(tags, &roles, &nodes, boundary),
            nodes,
            faces: surface_faces(tags, &roles, zone, boundary),
            tags: named,
        }
    }
}

/// Returns the nodes of the boundary tags with these indices in file order, ascending; with zones, only nodes in
/// the zones.
pub(super) fn nodes_of_tags(
    tags: &[usize],
    zone: Option<&DeformingZone>,
    boundary: &Boundary,
) -> Vec<u32> {
    let wanted = boundary.boundary_tags().enumerate();
    let wanted = wanted.filter(|(i, _)| tags.contains(i));
    let mut nodes: Vec<u32> = wanted.flat_map(|(_, tag)| boundary.nodes_of(tag)).collect();
    nodes.retain(|&node| is_in(zone, node));
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

fn is_in(zone: Option<&DeformingZone>, node: u32) -> bool {
    zone.is_none_or(|zone| zone.sides.nodes.has(node))
}

fn surface_nodes(
    tags: &[&Group],
    roles: &[Option<Role>],
    zone: Option<&DeformingZone>,
    boundary: &Boundary,
) -> SurfaceNodes {
    let interface = zone.iter().flat_map(|zone| &zone.sides.interface_nodes);
    let mut all: Vec<(u32, Role)> = interface.map(|&node| (node, Role::Fixed)).collect();
    for (tag, role) in tags.iter().zip(roles) {
        let Some(role) = *role else { continue };
        let nodes = boundary.nodes_of(tag).filter(|&node| is_in(zone, node));
        all.extend(nodes.map(|node| (node, role)));
    }
    // The strongest role of a node comes first.
    parallel::sort(&mut all);
    all.dedup_by_key(|of| of.0);
    let (nodes, roles) = all.into_iter().unzip();
    let mut surface = SurfaceNodes { nodes, roles };
    let is_on_interface = |node: &u32| {
        zone.is_some_and(|zone| zone.sides.interface_nodes.binary_search(node).is_ok())
    };
    surface.unite_copies(is_on_interface, boundary);
    surface
}

impl SurfaceNodes {
    /// Lets sliding nodes move or stay with their copies: nodes at one place, as blocks of a structured grid have where they meet.
    /// Other nodes at one place keep their roles: they may be two walls that touch, and are refused later.
    fn unite_copies(&mut self, is_on_interface: impl Fn(&u32) -> bool, boundary: &Boundary) {
        let own = (0..self.nodes.len()).filter(|at| !is_on_interface(&self.nodes[*at]));
        let own: Vec<usize> = own.collect();
        let place = |i: usize| boundary.position(self.nodes[own[i]]);
        let places = parallel::collect(own.len(), place);
        let copies = Coincident::of(&places, |_| 0);
        let pairs = || {
            let pairs = copies.pairs();
            pairs.map(|(at, first)| (own[at as usize], own[first as usize]))
        };
        // From each to the first, then from the first to each.
        for (at, first) in pairs() {
            if self.roles[first] == Role::Sliding {
                self.roles[first] = self.roles[at];
            }
        }
        for (at, first) in pairs() {
            if self.roles[at] == Role::Sliding {
                self.roles[at] = self.roles[first];
            }
        }
    }
}

/// Returns nodes on the tags of two bodies, with the body that they do not move with.
fn shared_nodes(
    tags: &[&Group],
    roles: &[Option<Role>],
    nodes: &SurfaceNodes,
    boundary: &Boundary,
) -> Vec<(u32, u16)> {
    let mut shared = Vec::new();
    for (tag, role) in tags.iter().zip(roles) {
        // Nodes of the first body in the schedule never belong to another one.
        let &Some(Role::Moving(body @ 1..)) = role else {
            continue;
        };
        let own = |node: &u32| {
            let at = nodes.nodes.binary_search(node);
            at.is_ok_and(|at| nodes.roles[at] == Role::Moving(body))
        };
        let others = boundary.nodes_of(tag).filter(|node| !own(node));
        shared.extend(others.map(|node| (node, body)));
    }
    shared.sort_unstable();
    shared.dedup();
    shared
}

/// Returns faces of the tags with a role whose nodes are all in the zone.
fn surface_faces(
    tags: &[&Group],
    roles: &[Option<Role>],
    zone: Option<&DeformingZone>,
    boundary: &Boundary,
) -> SurfaceFaces {
    let mut faces: Vec<(u32, Role, u32)> = Vec::new();
    for ((tag, role), index) in tags.iter().zip(roles).zip(0..) {
        let Some(role) = *role else { continue };
        for cell in tag.cells.iter() {
            let nodes = boundary.face(cell).nodes;
            if nodes.iter().all(|&node| is_in(zone, node)) {
                faces.push((cell as u32, role, index));
            }
        }
    }
    faces.sort_unstable();
    faces.dedup_by_key(|face| face.0);
    let mut surface = SurfaceFaces::default();
    for (cell, role, tag) in faces {
        surface.cells.push(cell);
        surface.roles.push(role);
        surface.tags.push(tag);
    }
    surface
}
