//! The exact map of the points of a body: one for a rigid body, one for each section of a beam, and
//! displacements of nodes. The velocities of the points: the map differentiated by time.

use super::motions::Link;
use azimesh_core::geometry::vector::{Vector, add};
use azimesh_core::geometry::{Moving, Transform};

/// The exact map `x -> x'` of the points of a body from the reference mesh: maps one after another.
/// A point keeps the section of a beam that it is in in the reference mesh.
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

    /// First `self`, then `next`. Rigid maps become one, and so do displacements of nodes.
    pub(super) fn push(&mut self, next: Link<'a, Transform>) {
        match (self.links.last_mut(), next) {
            (Some(Link::Rigid(map)), Link::Rigid(next)) => *map = map.then(&next),
            (Some(Link::Nodes(all)), Link::Nodes(next)) => all.join(next),
            (_, next) => self.links.push(next),
        }
    }

    /// First `self`, then a rigid map.
    #[must_use]
    pub fn then(mut self, next: &Transform) -> Self {
        self.push(Link::Rigid(*next));
        self
    }

    /// First `self`, then the motion of a parent.
    pub(super) fn then_map(mut self, parent: Self) -> Self {
        parent.links.into_iter().for_each(|link| self.push(link));
        self
    }

    /// The rigid map of what is around the point `x` of the reference mesh.
    pub fn map(&self, x: Vector) -> Transform {
        let maps = self.links.iter().filter_map(|link| match link {
            Link::Rigid(map) => Some(*map),
            Link::Sections(sections) => Some(sections.map(x)),
            Link::Nodes(_) => None,
        });
        maps.reduce(|first, next| first.then(&next))
            .unwrap_or(Transform::IDENTITY)
    }

    /// The place of what is at the point `x` of the reference mesh and has no displacement of its own.
    #[inline]
    pub fn apply(&self, x: Vector) -> Vector {
        self.moved(None, x)
    }

    /// The place of a node whose place in the reference mesh is `x`.
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
    /// The velocity of a node whose place in the reference mesh is `x`, in mesh units a second.
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

    /// Transforms of a rigid body, one after another; none if its points move in different ways.
    pub fn rigid(&self) -> Option<Vec<Moving>> {
        let of_link = |link: &Link<'_, Moving>| match link {
            Link::Rigid(moving) => Some(*moving),
            Link::Sections(_) | Link::Nodes(_) => None,
        };
        self.links.iter().map(of_link).collect()
    }
}
