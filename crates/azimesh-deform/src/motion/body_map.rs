//! The exact map of the points of a body: one for a rigid body, one per section of a beam, and displacements of
//! nodes. The velocities of the points are its time derivative.

use super::motions::Link;
use azimesh_core::geometry::vector::{Vector, add};
use azimesh_core::geometry::{Moving, Transform};

/// The exact map `x -> x'` of the points of a body from the reference mesh: a chain of maps. A point belongs to the
/// same beam section throughout, found in the reference mesh.
#[derive(Debug, Clone, Default)]
pub struct BodyMap<'a> {
    links: Vec<Link<'a, Transform>>,
}

impl<'a> BodyMap<'a> {
    /// The map of the whole body, where it moves as one.
    pub fn rigid(&self) -> Option<&Transform> {
        match self.links.as_slice() {
            [Link::Rigid(map)] => Some(map),
            _ => None,
        }
    }

    /// Composes `self` and then `next`. Rigid maps are merged, and so are displacements of nodes.
    pub(super) fn push(&mut self, next: Link<'a, Transform>) {
        match (self.links.last_mut(), next) {
            (Some(Link::Rigid(map)), Link::Rigid(next)) => *map = map.then(&next),
            (Some(Link::Nodes(all)), Link::Nodes(next)) => all.join(next),
            (_, next) => self.links.push(next),
        }
    }

    /// Composes `self` and then a rigid map.
    #[must_use]
    pub fn then(mut self, next: &Transform) -> Self {
        self.push(Link::Rigid(*next));
        self
    }

    /// Composes `self` and then the motion of a parent.
    pub(super) fn then_map(mut self, parent: Self) -> Self {
        parent.links.into_iter().for_each(|link| self.push(link));
        self
    }

    /// Returns the rigid map around the point `x` of the reference mesh.
    pub fn map(&self, x: Vector) -> Transform {
        let maps = self.links.iter().filter_map(|link| match link {
            Link::Rigid(map) => Some(*map),
            Link::Sections(sections) => Some(sections.map(x)),
            Link::Nodes(_) => None,
        });
        maps.reduce(|first, next| first.then(&next))
            .unwrap_or(Transform::IDENTITY)
    }

    /// Maps the point `x` of the reference mesh, without displacements of nodes.
    #[inline]
    pub fn apply(&self, x: Vector) -> Vector {
        self.moved(None, x)
    }

    /// Maps a node at `x` of the reference mesh.
    #[inline]
    pub fn place(&self, node: u32, x: Vector) -> Vector {
        self.moved(Some(node), x)
    }

    #[inline]
    fn moved(&self, node: Option<u32>, x: Vector) -> Vector {
        self.links.iter().fold(x, |at, link| match link {
            Link::Rigid(map) => map.apply(at),
            Link::Sections(sections) => sections.place(x, at),
            Link::Nodes(nodes) => node.map_or(at, |node| add(at, nodes.displacement(node))),
        })
    }
}

/// Velocities of the points of a body at a step, in the rotating frame.
#[derive(Debug, Clone)]
pub struct BodyVelocity<'a> {
    /// Its own motions, then the motions of its parents.
    pub(super) links: Vec<Link<'a, Moving>>,
}

impl BodyVelocity<'_> {
    /// Returns the velocity of a node at `x` of the reference mesh, in mesh units per second.
    pub fn velocity(&self, node: u32, x: Vector) -> Vector {
        let (mut place, mut velocity) = (x, [0.0; 3]);
        for link in &self.links {
            let moving = match link {
                Link::Rigid(moving) => *moving,
                Link::Sections(sections) => sections.moving(x),
                Link::Nodes(nodes) => {
                    place = add(place, nodes.displacement(node));
                    velocity = add(velocity, nodes.rate(node));
                    continue;
                }
            };
            (place, velocity) = moving.carry((place, velocity));
        }
        velocity
    }

    /// Transforms of a rigid body, in order; `None` if its points move differently.
    pub fn rigid(&self) -> Option<Vec<Moving>> {
        let of_link = |link: &Link<'_, Moving>| match link {
            Link::Rigid(moving) => Some(*moving),
            Link::Sections(_) | Link::Nodes(_) => None,
        };
        self.links.iter().map(of_link).collect()
    }
}
