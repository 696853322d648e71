//! Periodic pairs of the mesh of a schedule: images of base points, and nodes that follow their partners
//! to the last bit.

use super::surface::SurfacePoints;
use crate::diagnostic::Diagnostic;
use crate::diagnostic::deform::{DeformNote, PeriodicMap};
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, add, distance, sub};
use crate::geometry::{Bounds, Transform};
use crate::mesh::{Mesh, Slots};
use crate::motion::periodic::{Axis, Follower, Periodic, Side, Symmetry, followers, images};
use crate::motion::{Motion, Role};
use std::sync::Arc;

/// A body on both sides of a pair may be this part of the extent off at any step.
const EQUIVARIANT: f64 = 1e-9;

/// The periodic pairs of a mesh; empty without pairs.
#[derive(Debug, Clone, Default)]
pub struct PeriodicNodes {
    /// Images of the base points, the identity left out.
    pub images: Arc<Vec<Transform>>,
    /// Nodes that follow others, ascending.
    followers: Vec<Follower>,
    /// For each surface point whether the point of another is its image; empty when there are none.
    pub is_image: Vec<bool>,
    /// A note for each pair.
    pub found: Vec<Diagnostic>,
}

impl PeriodicNodes {
    /// Finds the pairs of a motion on its mesh, with the images within `radius`.
    pub fn find(
        mesh: &Mesh,
        motion: &Motion,
        surface: &SurfacePoints,
        radius: f64,
    ) -> Result<Self> {
        let tags = &motion.periodic;
        if tags.is_empty() {
            return Ok(Self::default());
        }
        let bounds = mesh.extent();
        let axis = Axis {
            origin: motion.rotor.hub,
            direction: motion.rotor.e_z,
        };
        let mut pairs = Vec::new();
        let mut found = Vec::new();
        for pair in tags {
            let [nodes_a, nodes_b] = motion.periodic_nodes(pair, mesh);
            let [name_a, name_b] = [&pair.a, &pair.b].map(|tags| names(motion, tags));
            let [a, b] = [(&name_a, &nodes_a), (&name_b, &nodes_b)]
                .map(|(name, nodes)| Side { name, nodes });
            let periodic = Periodic::find(&|node| mesh.place(node), a, b, Some(axis))
                .map_err(|error| error.at(pair.place.clone()))?;
            let note = DeformNote::PeriodicPair {
                sides: [name_a, name_b],
                pairs: periodic.pairs.len(),
                map: periodic_map(&periodic.symmetry),
                distance: periodic.mismatch,
            };
            found.push(note.into());
            pairs.push(periodic);
        }
        let place = || tags[0].place.clone();
        let followers = followers(&pairs, &bounds).map_err(|error| error.at(place()))?;
        let images = images(&pairs, radius, &bounds).map_err(|error| error.at(place()))?;
        let nodes = Self {
            is_image: is_image(&motion.surface.nodes.nodes, surface, &followers),
            images: Arc::new(images),
            followers,
            found,
        };
        nodes.check(mesh, motion, &bounds)?;
        Ok(nodes)
    }

    /// Paired nodes have one role, and bodies on both sides move alike.
    fn check(&self, mesh: &Mesh, motion: &Motion, bounds: &Bounds) -> Result<()> {
        let limit = EQUIVARIANT * bounds.diagonal();
        for follower in &self.followers {
            let roles = [follower.leader, follower.node].map(|node| role(motion, node));
            if roles[0] != roles[1] {
                return Err(Error::input(format!(
                    "nodes {} and {} are a periodic pair with different roles; give the tags on both sides the \
                     same role",
                    follower.leader, follower.node
                )));
            }
            let Some(Role::Moving(body)) = roles[0] else {
                continue;
            };
            let body = usize::from(body);
            let [leader, node] = [follower.leader, follower.node].map(|node| mesh.place(node));
            let offset = sub(node, follower.map.apply(leader));
            for step in &motion.steps {
                let pose = motion.pose(body, step);
                let followed = add(
                    follower.map.apply(pose.place(follower.leader, leader)),
                    offset,
                );
                if distance(followed, pose.place(follower.node, node)) > limit {
                    return Err(Error::input(format!(
                        "body \"{}\" is on both sides of a periodic pair, but its motion at step {} differs \
                         between them",
                        motion.bodies[body].name, step.index
                    )));
                }
            }
        }
        Ok(())
    }

    /// The nodes that follow others, ascending.
    pub(super) fn followers(&self) -> &[Follower] {
        &self.followers
    }

    /// Puts every follower where its leader's image is. Where the reference mesh has them in the same
    /// relation to the last bit, so has `out`, in which nodes have `slots`.
    pub(super) fn follow(
        &self,
        motion: &Motion,
        reference: &Mesh,
        to_inertial: Option<&Transform>,
        (slots, out): (Slots<'_>, &mut [Vector]),
    ) {
        for follower in &self.followers {
            if role(motion, follower.node) == Some(Role::Fixed) {
                continue;
            }
            let pair = [follower.leader, follower.node];
            let [at_leader, at_rest] = pair.map(|node| reference.place(node));
            let offset = sub(at_rest, follower.map.apply(at_leader));
            let [leader, node] = pair.map(|node| slots.of(node));
            out[node] = match to_inertial {
                None => add(follower.map.apply(out[leader]), offset),
                Some(to_inertial) => {
                    let back = to_inertial.inverse().apply(out[leader]);
                    to_inertial.apply(add(follower.map.apply(back), offset))
                }
            };
        }
    }
}

impl PeriodicNodes {
    /// Gives every follower the direction that its leader's image has.
    pub(super) fn follow_directions(&self, (slots, out): (Slots<'_>, &mut [Vector])) {
        for follower in &self.followers {
            let direction = follower.map.turn(out[slots.of(follower.leader)]);
            out[slots.of(follower.node)] = direction;
        }
    }
}

fn periodic_map(symmetry: &Symmetry) -> PeriodicMap {
    match symmetry {
        Symmetry::Translation(by) => PeriodicMap::Translation(*by),
        Symmetry::Rotation { axis, angle } => PeriodicMap::Rotation {
            angle_deg: angle.to_degrees(),
            direction: axis.direction,
            origin: axis.origin,
        },
    }
}

fn names(motion: &Motion, tags: &[usize]) -> String {
    let names = tags
        .iter()
        .map(|&tag| motion.surface.tags[tag].tag.as_str());
    names.collect::<Vec<_>>().join(", ")
}

fn role(motion: &Motion, node: u32) -> Option<Role> {
    let surface = &motion.surface.nodes;
    let at = surface.nodes.binary_search(&node).ok()?;
    Some(surface.roles[at])
}

/// Marks the surface points whose leader is a surface point too; `nodes` are all surface nodes.
pub(super) fn is_image(
    nodes: &[u32],
    surface: &SurfacePoints,
    followers: &[Follower],
) -> Vec<bool> {
    let point = |node: u32| {
        let at = nodes.binary_search(&node).ok()?;
        Some(surface.point_of[at] as usize)
    };
    let mut is_image = vec![false; surface.nodes.len()];
    for follower in followers {
        if let (Some(image), Some(leader)) = (point(follower.node), point(follower.leader))
            && image != leader
        {
            is_image[image] = true;
        }
    }
    is_image
}
