//! Periodic pairs of the mesh of a schedule: images of base points, and nodes that follow their partners
//! to the last bit.

use super::sharing::Holder;
use super::surface::SurfacePoints;
use crate::diagnostic::Diagnostic;
use crate::diagnostic::deform::DeformNote;
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, add, cross, distance, dot, scale, sub, unit};
use crate::geometry::{Bounds, Transform};
use crate::mesh::sides::for_each_side;
use crate::mesh::{Mesh, Numbering, Slots};
use crate::motion::periodic::{Axis, Follower, Periodic, Side, followers, images};
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
    /// Finds the pairs of a motion on its mesh, with the images within `radius`; `holder` has the mesh where this is its
    /// outline.
    pub(crate) fn find(
        mesh: &Mesh,
        motion: &Motion,
        surface: &SurfacePoints,
        radius: f64,
        holder: Option<&dyn Holder>,
    ) -> Result<Self> {
        let tags = &motion.periodic;
        if tags.is_empty() {
            return Ok(Self::default());
        }
        let bounds = mesh.extent();
        let axis = Axis {
            origin: motion.rotor.hub,
            direction: motion.rotor.axis_of_sectors(),
        };
        let mut pairs = Vec::new();
        let mut found = Vec::new();
        for pair in tags {
            let [nodes_a, nodes_b] = motion.periodic_nodes(pair, mesh);
            let [name_a, name_b] = [&pair.a, &pair.b].map(|tags| names(motion, tags));
            let inward_a = inward(mesh, &nodes_a, holder)?;
            let inward_b = inward(mesh, &nodes_b, holder)?;
            let side = |name, nodes, inward| Side {
                name,
                nodes,
                inward,
            };
            let a = side(&name_a, &nodes_a, &inward_a);
            let b = side(&name_b, &nodes_b, &inward_b);
            let periodic = Periodic::find(&|node| mesh.place(node), a, b, Some(axis))
                .map_err(|error| error.at(pair.place.clone()))?;
            let note = DeformNote::PeriodicPair {
                sides: [name_a, name_b],
                pairs: periodic.pairs.len(),
                map: (&periodic.symmetry).into(),
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

/// Gives the direction into the mesh, normal to its faces, at each of the nodes of a side, which are ascending; zero where the side has
/// no face.
///
/// # Errors
/// Of the holder, which has the mesh where this is its outline.
pub(super) fn inward(
    mesh: &Mesh,
    nodes: &[u32],
    holder: Option<&dyn Holder>,
) -> Result<Vec<Vector>> {
    let numbers = Numbering::new(nodes);
    let is_on = |node: &u32| numbers.place(*node).is_some();
    let mut inward = vec![[0.0; 3]; nodes.len()];
    let mut take = |corners: &[u32], inside: Vector| {
        let places: Vec<Vector> = corners.iter().map(|&node| mesh.place(node)).collect();
        let normal = normal_towards(inside, &places);
        for at in corners.iter().filter_map(|&node| numbers.place(node)) {
            inward[at] = add(inward[at], normal);
        }
    };
    if let (Some(holder), Some(_)) = (holder, &mesh.outline) {
        // Edges that leave the side go into the mesh.
        let (edges, ends) = holder.edges_off_walls(nodes)?;
        let mut off = vec![[0.0; 3]; nodes.len()];
        for ((node, ..), end) in edges.into_iter().zip(ends) {
            off[numbers.of(node) as usize] = sub(end, mesh.place(node));
        }
        let dimension = mesh.dimension();
        let faces = mesh
            .cells
            .runs()
            .filter(|run| run.kind.dimension() + 1 == dimension);
        for face in faces.flat_map(|run| {
            run.cells()
                .map(move |nodes| &nodes[..run.kind.n_corners(run.n_nodes)])
        }) {
            if face.iter().all(is_on) {
                let ends = face.iter().map(|&node| off[numbers.of(node) as usize]);
                take(face, ends.fold([0.0; 3], add));
            }
        }
        return Ok(inward);
    }
    for cell in mesh.volume_runs().flat_map(|run| run.cell_refs()) {
        if cell.nodes.iter().any(is_on) {
            let places = cell.nodes.iter().map(|&node| mesh.place(node));
            let middle = scale(places.fold([0.0; 3], add), 1.0 / cell.nodes.len() as f64);
            for_each_side(&mesh.cells, &cell, |_, corners| {
                if corners.iter().all(is_on) {
                    take(corners, sub(middle, mesh.place(corners[0])));
                }
            });
        }
    }
    Ok(inward)
}

/// The normal of a face between these corners, as long as twice its area, or of an edge of a plane mesh, on the side of a direction.
fn normal_towards(inside: Vector, corners: &[Vector]) -> Vector {
    if let [a, b] = corners {
        let along = unit(sub(*b, *a)).unwrap_or_default();
        return sub(inside, scale(along, dot(along, inside)));
    }
    let from_first = |at: usize| sub(corners[at], corners[0]);
    let parts = (2..corners.len()).map(|at| cross(from_first(at - 1), from_first(at)));
    let area = parts.fold([0.0; 3], add);
    scale(area, dot(area, inside).signum())
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
