//! Nodes that two bodies share: they move with the body that the schedule names first; the other body may move them
//! to other positions.

use super::body_map::BodyMap;
use super::resolved::Motion;
use super::surface::Role;
use azimesh_core::geometry::vector::distance;
use azimesh_core::numbers::{in_digits, with_verb};
use azimesh_core::{Note, note};
use azimesh_io::mesh::Boundary;
use std::collections::BTreeMap;

/// Largest difference of the positions that two bodies give a shared node, as a part of the extent.
const ALIKE: f64 = 1e-9;

/// Nodes that two bodies share.
#[derive(Default)]
struct Shared {
    n_nodes: usize,
    /// Largest distance between the positions that both give a node, at any step.
    gap: f64,
    /// The step of that distance.
    step: usize,
}

impl Motion {
    /// Returns a note for each pair of bodies that move their shared nodes to different positions.
    pub fn shared_nodes(&self, boundary: &Boundary) -> Vec<Note> {
        let mut shared: BTreeMap<(u16, u16), Shared> = BTreeMap::new();
        if self.surface.shared.is_empty() {
            return Vec::new();
        }
        for step in &self.steps {
            let poses = self.poses(step, 1.0);
            for &(node, other) in &self.surface.shared {
                let Some(own) = self.body_of(node) else {
                    continue;
                };
                let pair = shared.entry((own, other)).or_default();
                let place = |pose: &BodyMap<'_>| pose.place(node, boundary.position(node));
                let gap = distance(
                    place(&poses[usize::from(own)]),
                    place(&poses[usize::from(other)]),
                );
                pair.n_nodes += usize::from(step.index == self.steps[0].index);
                if gap > pair.gap {
                    (pair.gap, pair.step) = (gap, step.index);
                }
            }
        }
        let least = ALIKE * boundary.extent.diagonal();
        let apart = shared.into_iter().filter(|(_, pair)| pair.gap > least);
        let note = |((own, other), pair): ((u16, u16), Shared)| {
            let name = |body: u16| &self.bodies[usize::from(body)].name;
            note!(
                "shared_nodes",
                "{} on tags of both body \"{}\" and body \"{}\"; they move with the first, up to {} from \
                 where the second would put them (step {})",
                with_verb(pair.n_nodes, "node", "is"),
                name(own),
                name(other),
                in_digits(pair.gap, 3),
                pair.step
            )
        };
        apart.map(note).collect()
    }

    /// Returns the body that a node moves with.
    fn body_of(&self, node: u32) -> Option<u16> {
        let nodes = &self.surface.nodes;
        match nodes.roles[nodes.nodes.binary_search(&node).ok()?] {
            Role::Moving(body) => Some(body),
            Role::Fixed | Role::Sliding => None,
        }
    }
}
