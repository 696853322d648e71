//! Cuts the deforming zone from the rest of the mesh where it is to turn: interface nodes are
//! duplicated, and the zone's cells take the copies.

use crate::error::Result;
use crate::mesh::{Doubled, Mesh};
use crate::motion::Motion;

/// Duplicates the interface nodes of the motion's zone in `mesh`, or in its outline, and makes the motion speak of the
/// copies.
pub fn detach(mesh: &mut Mesh, motion: &mut Motion) -> Result<Option<Doubled>> {
    let Some(zone) = &mut motion.zone else {
        return Ok(None);
    };
    let doubled = Doubled::between(mesh, &zone.cells, &zone.sides)?;
    doubled.apply(mesh);
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
    Ok(Some(doubled))
}
