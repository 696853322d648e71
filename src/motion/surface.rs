//! The role of every surface node: with which body it moves, or that it stays.

use super::body::Body;
use super::names::list;
use super::options::{Boundaries, Others};
use super::zones::DeformingZone;
use crate::error::{Error, Result};
use crate::mesh::{Group, Mesh};

/// What a surface node does. In the order of strength: a node on two tags takes the first of their
/// roles in this order, and on two bodies that of the body named first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// It moves with the body of this index.
    Moving(u16),
    /// It stays where it is.
    Fixed,
    /// It stays on its boundary.
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

/// Boundary faces with a role. Faces of an interface are in [`DeformingZone::interface_faces`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SurfaceFaces {
    /// Cell indices of the mesh, ascending.
    pub cells: Vec<u32>,
    /// Role of each.
    pub roles: Vec<Role>,
}

/// A tag with what the schedule makes of it; for `azimesh check`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TagRole {
    /// Name of the tag.
    pub tag: String,
    /// What its nodes do; `None` when they are free, or when the tag is unnamed and lies outside
    /// the zones that deform.
    pub role: Option<Role>,
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
}

impl Surface {
    pub(super) fn find(
        bodies: &[Body],
        boundaries: &Boundaries,
        zone: Option<&DeformingZone>,
        mesh: &Mesh,
    ) -> Result<Self> {
        let tags: Vec<&Group> = mesh.boundary_tags().collect();
        if tags.is_empty() {
            return Err(Error::input(
                "the mesh has no boundary tags, so nothing says which nodes move; tag its boundary faces",
            ));
        }
        if bodies.len() > usize::from(u16::MAX) {
            return Err(Error::input(format!(
                "at most {} bodies are possible",
                u16::MAX
            )));
        }
        let roles = tag_roles(&tags, bodies, boundaries, zone, mesh)?;
        check_bodies(&tags, &roles, bodies, zone, mesh)?;
        let surface = Self {
            nodes: surface_nodes(&tags, &roles, zone, mesh),
            faces: surface_faces(&tags, &roles, zone, mesh),
            tags: tags
                .iter()
                .zip(&roles)
                .map(|(tag, &role)| TagRole {
                    tag: tag.name.clone(),
                    role,
                })
                .collect(),
        };
        Ok(surface)
    }
}

/// What each tag does; `None` for a free one.
fn tag_roles(
    tags: &[&Group],
    bodies: &[Body],
    boundaries: &Boundaries,
    zone: Option<&DeformingZone>,
    mesh: &Mesh,
) -> Result<Vec<Option<Role>>> {
    let names: Vec<&str> = tags.iter().map(|tag| tag.name.as_str()).collect();
    let mut roles: Vec<Option<Role>> = vec![None; tags.len()];
    let moving = bodies.iter().enumerate().flat_map(|(i, body)| {
        let role = Role::Moving(i as u16);
        body.tags.iter().map(move |pattern| (pattern, role))
    });
    let fixed = boundaries
        .fixed
        .iter()
        .map(|pattern| (pattern, Role::Fixed));
    for (pattern, role) in moving.chain(fixed) {
        for tag in pattern.find("tag", &names)? {
            if let Some(before) = roles[tag].replace(role)
                && before != role
            {
                return Err(Error::input(format!(
                    "tag \"{}\" is {} and {}; a tag has one role",
                    names[tag],
                    role_name(before, bodies),
                    role_name(role, bodies)
                ))
                .line(pattern.line));
            }
        }
    }
    let unnamed: Vec<usize> = (0..tags.len())
        .filter(|&i| roles[i].is_none() && touches(tags[i], zone, mesh))
        .collect();
    match boundaries.others {
        Some(Others::Free) => {}
        Some(Others::Fixed) => unnamed.iter().for_each(|&i| roles[i] = Some(Role::Fixed)),
        None if unnamed.is_empty() => {}
        None => {
            let error = Error::input(format!(
                "the schedule does not say what these tags do: {}; name them under a body or `fixed`, or set others = \"fixed\" or \"free\" in [boundaries]",
                list(unnamed.iter().map(|&i| names[i]))
            ));
            return Err(match boundaries.line {
                Some(line) => error.line(line),
                None => error,
            });
        }
    }
    Ok(roles)
}

fn role_name(role: Role, bodies: &[Body]) -> String {
    match role {
        Role::Moving(body) => format!("in body \"{}\"", bodies[usize::from(body)].name),
        Role::Fixed => "fixed".into(),
        Role::Sliding => "sliding".into(),
    }
}

/// Nodes of the faces of a tag, a node once for each face.
fn nodes_of<'m>(tag: &'m Group, mesh: &'m Mesh) -> impl Iterator<Item = u32> + 'm {
    let runs = tag
        .cells
        .ranges()
        .flat_map(|range| mesh.cells.runs_in(range));
    runs.flat_map(|run| run.connectivity.iter().copied())
}

/// Whether a tag has a node in the zone that its interface does not hold fixed anyway.
fn touches(tag: &Group, zone: Option<&DeformingZone>, mesh: &Mesh) -> bool {
    nodes_of(tag, mesh)
        .any(|node| zone.is_none_or(|zone| zone.nodes[node as usize] && !zone.is_interface(node)))
}

fn is_in(zone: Option<&DeformingZone>, node: u32) -> bool {
    zone.is_none_or(|zone| zone.nodes[node as usize])
}

/// Every body has faces, and none of its nodes is where it could not move.
fn check_bodies(
    tags: &[&Group],
    roles: &[Option<Role>],
    bodies: &[Body],
    zone: Option<&DeformingZone>,
    mesh: &Mesh,
) -> Result<()> {
    for (i, body) in bodies.iter().enumerate() {
        let role = Some(Role::Moving(i as u16));
        let own = || (0..tags.len()).filter(|&tag| roles[tag] == role);
        if own().all(|tag| tags[tag].cells.is_empty()) {
            return Err(Error::input(format!(
                "the tags of body \"{}\" have no faces in the mesh; it needs at least one",
                body.name
            ))
            .line(body.line));
        }
        let Some(zone) = zone else { continue };
        for tag in own() {
            let free_to_move = |node: u32| zone.nodes[node as usize] && !zone.is_interface(node);
            if let Some(node) = nodes_of(tags[tag], mesh).find(|&node| !free_to_move(node)) {
                let place = match zone.nodes[node as usize] {
                    true => {
                        "on the interface to the other zones, which stays fixed; name those zones as well"
                    }
                    false => "outside the zones that deform; name its zone as well",
                };
                return Err(Error::input(format!(
                    "tag \"{}\" moves with body \"{}\", but its node {node} is {place}",
                    tags[tag].name, body.name
                ))
                .line(body.line));
            }
        }
    }
    Ok(())
}

fn surface_nodes(
    tags: &[&Group],
    roles: &[Option<Role>],
    zone: Option<&DeformingZone>,
    mesh: &Mesh,
) -> SurfaceNodes {
    let mut strongest: Vec<Option<Role>> = vec![None; mesh.points.len()];
    let interface = zone.iter().flat_map(|zone| &zone.interface_nodes);
    for &node in interface {
        strongest[node as usize] = Some(Role::Fixed);
    }
    for (tag, role) in tags.iter().zip(roles) {
        let Some(role) = *role else { continue };
        for node in nodes_of(tag, mesh).filter(|&node| is_in(zone, node)) {
            let strongest = &mut strongest[node as usize];
            *strongest = Some(strongest.map_or(role, |before| before.min(role)));
        }
    }
    let mut surface = SurfaceNodes::default();
    for (node, role) in strongest.into_iter().enumerate() {
        if let Some(role) = role {
            surface.nodes.push(node as u32);
            surface.roles.push(role);
        }
    }
    surface
}

/// Faces of the tags with a role whose nodes are all in the zone.
fn surface_faces(
    tags: &[&Group],
    roles: &[Option<Role>],
    zone: Option<&DeformingZone>,
    mesh: &Mesh,
) -> SurfaceFaces {
    let mut faces: Vec<(u32, Role)> = Vec::new();
    for (tag, role) in tags.iter().zip(roles) {
        let Some(role) = *role else { continue };
        for cell in tag.cells.iter() {
            let nodes = mesh.cells.get(cell).nodes;
            if nodes.iter().all(|&node| is_in(zone, node)) {
                faces.push((cell as u32, role));
            }
        }
    }
    faces.sort_unstable();
    faces.dedup_by_key(|face| face.0);
    let (cells, roles) = faces.into_iter().unzip();
    SurfaceFaces { cells, roles }
}
