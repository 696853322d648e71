//! Where the points of a body are: an exact map, the same for all of a rigid body and one for each
//! section of a beam.

use crate::geometry::Transform;
use crate::geometry::vector::Vector;

/// The exact map `x -> x'` of the points of a body from the reference mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    links: Vec<Link>,
}

/// A part of a chain of maps.
#[derive(Debug, Clone, PartialEq)]
enum Link {
    /// The same for every point.
    Rigid(Transform),
}

impl Pose {
    /// One map for every point.
    pub fn of_rigid(map: Transform) -> Self {
        Self {
            links: vec![Link::Rigid(map)],
        }
    }

    /// The map of the whole body, where it moves as one.
    pub fn rigid(&self) -> Option<&Transform> {
        match self.links.as_slice() {
            [Link::Rigid(map)] => Some(map),
            _ => None,
        }
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(mut self, next: &Transform) -> Self {
        match self.links.last_mut() {
            Some(Link::Rigid(map)) => *map = map.then(next),
            _ => self.links.push(Link::Rigid(*next)),
        }
        self
    }

    /// The rigid map of what is around the point `x` of the reference mesh.
    #[inline]
    pub fn map(&self, _x: Vector) -> Transform {
        let maps = self.links.iter().map(|link| match link {
            Link::Rigid(map) => *map,
        });
        maps.reduce(|first, next| first.then(&next))
            .unwrap_or(Transform::IDENTITY)
    }

    /// The place of what is at the point `x` of the reference mesh.
    #[inline]
    pub fn apply(&self, x: Vector) -> Vector {
        match self.links.as_slice() {
            [Link::Rigid(map)] => map.apply(x),
            _ => self.map(x).apply(x),
        }
    }

    /// The place of a node whose place in the reference mesh is `x`.
    #[inline]
    pub fn place(&self, _node: u32, x: Vector) -> Vector {
        self.apply(x)
    }
}
