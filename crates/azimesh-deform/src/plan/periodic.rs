//! Periodic pairs of the mesh of a schedule: images of base points, and nodes that follow their partners
//! to the last bit.

use super::Plan;
use super::surface::SurfacePoints;
use crate::motion::periodic::{Axis, Follower, Periodic, Side, followers, images};
use crate::motion::{Motion, Role, ToInertial};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add, cross, distance, dot, scale, sub, unit};
use azimesh_core::ranks::raw::List;
use azimesh_core::{Note, note};
use azimesh_io::mesh::sides::for_each_side;
use azimesh_io::mesh::{Boundary, Mesh, Numbering};
use azimesh_rbf::images::Images;
use std::sync::Arc;

/// Allowed mismatch of a body on both sides of a pair at any step, as a part of the extent.
const EQUIVARIANT: f64 = 1e-9;

/// The periodic pairs of a mesh; empty without pairs.
#[derive(Debug, Clone, Default)]
pub struct PeriodicNodes {
    /// Images of the base points, without the identity.
    pub images: Arc<Vec<Transform>>,
    /// Nodes that follow others, ascending.
    followers: Vec<Follower>,
    /// For each surface point, whether it is the image of another; empty without images.
    pub is_image: Vec<bool>,
    /// For each surface point the point that it is the image of, or itself; empty without images.
    leaders: Vec<u32>,
    /// A note for each pair.
    pub found: Vec<Note>,
}

impl PeriodicNodes {
    /// Finds the pairs of a motion on its mesh, with the images within `radius`.
    pub(crate) fn find(
        mesh: &Mesh,
        boundary: &Boundary,
        motion: &Motion,
        surface: &SurfacePoints,
        radius: f64,
    ) -> Result<Self> {
        let tags = &motion.periodic;
        if tags.is_empty() {
            return Ok(Self::default());
        }
        let bounds = boundary.extent;
        let axes = &motion.rotors[0].axes;
        let axis = Axis {
            origin: axes.hub,
            direction: axes.axis_of_sectors(),
        };
        let mut pairs = Vec::new();
        let mut found = Vec::new();
        for pair in tags {
            let [nodes_a, nodes_b] = motion.periodic_nodes(pair, boundary);
            let [name_a, name_b] = [&pair.a, &pair.b].map(|tags| names(motion, tags));
            let inward_a = inward(mesh, &nodes_a);
            let inward_b = inward(mesh, &nodes_b);
            let side = |name, nodes, inward| Side {
                name,
                nodes,
                inward,
            };
            let a = side(&name_a, &nodes_a, &inward_a);
            let b = side(&name_b, &nodes_b, &inward_b);
            let periodic = Periodic::find(&|node| boundary.position(node), a, b, Some(axis))
                .map_err(|error| error.at(pair.place.clone()))?;
            found.push(note!(
                "periodic_pair",
                "{name_a} and {name_b}: {} pairs of nodes by {}, which match within {:.1e}",
                periodic.pairs.len(),
                periodic.symmetry,
                periodic.mismatch
            ));
            pairs.push(periodic);
        }
        let place = || tags[0].place.clone();
        let followers = followers(&pairs, &bounds).map_err(|error| error.at(place()))?;
        let images = images(&pairs, radius, &bounds).map_err(|error| error.at(place()))?;
        let leaders = leaders(&motion.surface.nodes.nodes, surface, &followers);
        let nodes = Self {
            is_image: is_image(&leaders),
            leaders,
            images: Arc::new(images),
            followers,
            found,
        };
        nodes.check(boundary, motion)?;
        Ok(nodes)
    }

    /// The images of the surface points.
    pub fn of_surface(&self) -> Images {
        Images {
            maps: self.images.clone(),
            leaders: self.leaders.clone(),
        }
    }

    /// Checks that paired nodes have one role, and that bodies on both sides move identically.
    fn check(&self, boundary: &Boundary, motion: &Motion) -> Result<()> {
        let limit = EQUIVARIANT * boundary.extent.diagonal();
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
            let [leader, node] =
                [follower.leader, follower.node].map(|node| boundary.position(node));
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

    /// Returns the nodes that follow others, ascending.
    pub(crate) fn followers(&self) -> &[Follower] {
        &self.followers
    }

    /// Sets every follower to the image of its leader. If the relation is exact to the last bit in the reference mesh, it
    /// is in `out`. All ranks call it.
    pub(crate) fn follow(
        &self,
        plan: &Plan,
        mesh: &Mesh,
        to_inertial: Option<&ToInertial<'_>>,
        out: &mut [Vector],
    ) {
        let to_inertial = |node: u32| to_inertial.and_then(|to| to.of_node(node));
        let place = |follower: &Follower, x: Vector| {
            let pair = [follower.leader, follower.node];
            let [at_leader, at_rest] = pair.map(|node| plan.boundary.position(node));
            let offset = sub(at_rest, follower.map.apply(at_leader));
            let [of_leader, own] = pair.map(to_inertial);
            let x = of_leader.map_or(x, |to_inertial| to_inertial.inverse().apply(x));
            let x = add(follower.map.apply(x), offset);
            own.map_or(x, |to_inertial| to_inertial.apply(x))
        };
        let moves = |follower: &&Follower| role(&plan.motion, follower.node) != Some(Role::Fixed);
        self.set_followers(mesh, moves, place, out);
    }

    /// Sets the direction of every follower to the image of its leader's.
    pub(crate) fn follow_directions(&self, mesh: &Mesh, out: &mut [Vector]) {
        let turn = |follower: &Follower, v: Vector| follower.map.turn(v);
        self.set_followers(mesh, |_| true, turn, out);
    }

    /// Sets the values of some followers of this rank from their leaders, which may be on other ranks.
    fn set_followers(
        &self,
        mesh: &Mesh,
        wanted: impl Fn(&&Follower) -> bool,
        value: impl Fn(&Follower, Vector) -> Vector,
        out: &mut [Vector],
    ) {
        if self.followers.is_empty() {
            return;
        }
        let mut leaders: Vec<u32> = self.followers.iter().map(|of| of.leader).collect();
        leaders.sort_unstable();
        leaders.dedup();
        let values = mesh.values_of_nodes(&leaders, |node| out[node]);
        for follower in self.followers.iter().filter(wanted) {
            if let Some(node) = mesh.node_here(follower.node) {
                let leader = leaders.partition_point(|&leader| leader < follower.leader);
                out[node as usize] = value(follower, values[leader]);
            }
        }
    }
}

/// Computes the inward normal of the mesh at each of the ascending nodes of a side; zero where the side has no face.
/// Nodes have the numbers of the whole mesh. All ranks that share the mesh call it and get the same result.
pub(crate) fn inward(mesh: &Mesh, nodes: &[u32]) -> Vec<Vector> {
    let numbers = Numbering::new(nodes);
    let place = |node: u32| numbers.place(mesh.number_of_node(node));
    let is_on = |node: &u32| place(*node).is_some();
    let point = |node: u32| mesh.points[node as usize];
    let mut normals: Vec<(usize, Vector)> = Vec::new();
    let own = mesh.volume_runs_in(mesh.own_cells());
    for cell in own.flat_map(|run| run.cell_refs()) {
        if cell.nodes.iter().any(is_on) {
            let places = cell.nodes.iter().map(|&node| point(node));
            let middle = scale(places.fold([0.0; 3], add), 1.0 / cell.nodes.len() as f64);
            for_each_side(&mesh.cells, &cell, |_, corners| {
                if corners.iter().all(is_on) {
                    let places: Vec<Vector> = corners.iter().map(|&node| point(node)).collect();
                    let normal = normal_towards(sub(middle, places[0]), &places);
                    let at = corners.iter().filter_map(|&node| place(node));
                    normals.extend(at.map(|at| (at, normal)));
                }
            });
        }
    }
    let take = |List(sums): &mut List<Vector>, normals: Vec<(usize, Vector)>| {
        for (at, normal) in normals {
            sums[at] = add(sums[at], normal);
        }
    };
    let zeros = List(vec![[0.0; 3]; nodes.len()]);
    mesh.ranks().ordered_fold(zeros, normals, take).0
}

/// Returns the normal of a face between these corners, on the side of a direction; its length is twice the area. In a
/// plane mesh it is the normal of an edge.
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

/// Returns the leader of each surface point among the surface points; the point itself where it follows none. `nodes` are
/// all surface nodes.
pub(crate) fn leaders(nodes: &[u32], surface: &SurfacePoints, followers: &[Follower]) -> Vec<u32> {
    let point = |node: u32| {
        let at = nodes.binary_search(&node).ok()?;
        Some(surface.point_of[at])
    };
    let mut leaders: Vec<u32> = (0..surface.nodes.len() as u32).collect();
    for follower in followers {
        if let (Some(image), Some(leader)) = (point(follower.node), point(follower.leader))
            && image != leader
        {
            leaders[image as usize] = leader;
        }
    }
    leaders
}

/// Marks the points that follow another.
pub(crate) fn is_image(leaders: &[u32]) -> Vec<bool> {
    let leaders = leaders.iter().zip(0..);
    leaders.map(|(&leader, at)| leader != at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::ranks::on_threads;
    use azimesh_io::mesh::cubes::{cubes, shuffled};

    #[test]
    #[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
    fn directions_into_the_mesh_are_those_of_the_whole_on_every_rank() {
        let mesh = cubes(40);
        for mesh in [shuffled(&mesh), mesh] {
            let bits = |values: Vec<Vector>| -> Vec<u64> {
                values.into_iter().flatten().map(f64::to_bits).collect()
            };
            for tag in ["front", "left"] {
                let nodes = mesh.tag_nodes(tag).expect("it is there");
                let wanted = inward(&mesh, &nodes);
                assert!(wanted.iter().all(|of| distance(*of, [0.0; 3]) > 0.0));
                let wanted = bits(wanted);
                for n in [1, 2, 3, 5] {
                    let found = on_threads(n, |ranks| {
                        let part = Mesh::shared_of(ranks.is_first().then_some(&mesh), &ranks);
                        bits(inward(&part, &nodes))
                    });
                    assert!(found.into_iter().all(|found| found == wanted));
                }
            }
        }
    }
}
