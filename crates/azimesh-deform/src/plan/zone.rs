//! Cuts the deforming zone from the rest of the mesh where it is to turn: interface nodes are
//! duplicated, and the zone's cells take the copies.

use crate::motion::{Motion, Role, TagRole};
use azimesh_core::error::{Result, counted};
use azimesh_io::mesh::{Boundary, Doubled, Mesh};
use std::sync::Arc;

/// Duplicates the interface nodes of the motion's zone in the mesh of this rank, with faces and tags on both sides, and has the
/// motion name the copies. Gives the tags too, each with the number of its faces.
pub fn detach(
    mesh: &mut Arc<Mesh>,
    boundary: &mut Boundary,
    motion: &mut Motion,
) -> Result<Option<(Doubled, Vec<String>)>> {
    let Some(zone) = &mut motion.zone else {
        return Ok(None);
    };
    let doubled = Doubled::between(mesh, &zone.cells, &zone.sides)?;
    doubled.apply(Arc::make_mut(mesh));
    *boundary = Boundary::of(mesh);
    let copy = doubled.copies();
    let sides = &mut zone.sides;
    sides.interface_faces.renumber_nodes_by(&copy);
    let n_copies = sides.interface_nodes.len();
    sides
        .nodes
        .extend(doubled.n_nodes() - n_copies..doubled.n_nodes());
    for node in &mut sides.interface_nodes {
        sides.nodes.remove(*node);
        *node = copy(*node);
    }
    let surface = &mut motion.surface.nodes;
    let mut roles: Vec<_> = surface
        .nodes
        .iter()
        .map(|&node| copy(node))
        .zip(surface.roles.clone())
        .collect();
    roles.sort_unstable_by_key(|entry| entry.0);
    (surface.nodes, surface.roles) = roles.into_iter().unzip();
    drop(copy);
    // Tags of the interface have other names, and new ones come last.
    let tags = &mut motion.surface.tags;
    let mut changed = Vec::new();
    for (at, group) in boundary.boundary_tags().enumerate() {
        let name = &group.name;
        match tags.get_mut(at) {
            Some(tag) if tag.tag == *name => continue,
            Some(tag) => tag.tag.clone_from(name),
            None => tags.push(TagRole {
                tag: name.clone(),
                role: Some(Role::Fixed),
                periodic: false,
            }),
        }
        changed.push(format!("{name} ({})", counted(group.cells.len(), "face")));
    }
    Ok(Some((doubled, changed)))
}
