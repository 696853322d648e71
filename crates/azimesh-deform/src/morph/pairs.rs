//! Periodic pairs of a morph: nodes that follow their partners, and images of base points.

use super::options::Nodes;
use crate::motion::Role;
use crate::motion::periodic::{Follower, Periodic, Side, followers, images};
use crate::plan::periodic::{inward, is_image, leaders};
use crate::plan::surface::SurfacePoints;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::transform::Matrix;
use azimesh_core::geometry::vector::{Vector, add, sub};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_io::mesh::Mesh;

/// The periodic pairs of a mesh; empty without pairs.
#[derive(Debug, Clone, Default)]
pub struct Pairs {
    periodic: Vec<Periodic>,
    bounds: Option<Bounds>,
    /// Nodes that follow others, ascending; without fixed ones.
    followers: Vec<Follower>,
    /// For each surface point, whether it is the image of another; empty without images.
    pub is_image: Vec<bool>,
    /// For each surface point the point that it is the image of, or itself; empty without images.
    pub leaders: Vec<u32>,
}

impl Pairs {
    /// Finds the pairs; `surface` has the surface nodes, ascending, with their roles.
    ///
    /// # Errors
    /// Sides that no translation or rotation makes equal, and partners with different roles.
    pub fn find(
        mesh: &Mesh,
        sides: &[[Nodes; 2]],
        points: &SurfacePoints,
        surface: (&[u32], &[Role]),
    ) -> Result<Self> {
        if sides.is_empty() {
            return Ok(Self::default());
        }
        let bounds = Bounds::around(&mesh.points);
        let find = |[a, b]: &[Nodes; 2]| {
            let mut nodes = [a.find("periodic", mesh)?, b.find("periodic", mesh)?];
            nodes.iter_mut().for_each(|side| side.sort_unstable());
            let names = [a.name(), b.name()];
            let directions = [inward(mesh, &nodes[0]), inward(mesh, &nodes[1])];
            let [a, b] = [0, 1].map(|side: usize| Side {
                name: &names[side],
                nodes: &nodes[side],
                inward: &directions[side],
            });
            Periodic::find(&|node| mesh.points[node as usize], a, b, None)
        };
        let periodic = sides.iter().map(find).collect::<Result<Vec<_>>>()?;
        let mut followers = followers(&periodic, &bounds)?;
        let role = |node: u32| {
            let at = surface.0.binary_search(&node).ok();
            at.map(|at| surface.1[at])
        };
        let differs = |of: &&Follower| role(of.node) != role(of.leader);
        if let Some(follower) = followers.iter().find(differs) {
            return Err(Error::input(format!(
                "nodes {} and {} are a periodic pair with different roles; let both move, be fixed, slide or be \
                 free",
                follower.leader, follower.node
            )));
        }
        let leaders = leaders(surface.0, points, &followers);
        let is_image = is_image(&leaders);
        followers.retain(|follower| role(follower.node) != Some(Role::Fixed));
        Ok(Self {
            periodic,
            bounds: Some(bounds),
            followers,
            is_image,
            leaders,
        })
    }

    /// Returns the images of base points that the support radius reaches, without the identity.
    pub fn images(&self, radius: f64) -> Result<Vec<Transform>> {
        match &self.bounds {
            None => Ok(Vec::new()),
            Some(bounds) => images(&self.periodic, radius, bounds),
        }
    }

    /// Returns the leader of a node, or the node itself if it has none, and the rotation of its displacement.
    pub fn leader(&self, node: u32) -> (u32, Matrix) {
        let at = self.followers.binary_search_by_key(&node, |of| of.node);
        at.map_or((node, Transform::IDENTITY.rotation), |at| {
            let follower = &self.followers[at];
            (follower.leader, follower.map.rotation)
        })
    }

    /// Returns the nodes that follow others.
    pub fn following(&self) -> impl Iterator<Item = u32> {
        self.followers.iter().map(|follower| follower.node)
    }

    /// Sets the displacement of every follower to its leader's, turned.
    pub fn follow(&self, displacements: &mut [Vector]) {
        for follower in &self.followers {
            let of_leader = displacements[follower.leader as usize];
            displacements[follower.node as usize] = follower.map.turn(of_leader);
        }
    }

    /// Applies the transpose of [`follow`](Self::follow).
    pub fn pull_back(&self, gradient: &mut [Vector]) {
        for follower in self.followers.iter().rev() {
            let of_node = std::mem::take(&mut gradient[follower.node as usize]);
            let leader = &mut gradient[follower.leader as usize];
            *leader = add(*leader, follower.map.inverse().turn(of_node));
        }
    }

    /// Sets every follower to the image of its leader, with the offset of the reference mesh.
    pub fn place(&self, reference: &[Vector], points: &mut [Vector]) {
        for follower in &self.followers {
            let [leader, node] = [follower.leader, follower.node].map(|i| i as usize);
            let offset = sub(reference[node], follower.map.apply(reference[leader]));
            points[node] = add(follower.map.apply(points[leader]), offset);
        }
    }
}
