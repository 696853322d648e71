//! Velocities of the points of a body: its exact map differentiated by time.

use super::motions::Link;
use azimesh_core::geometry::Moving;
use azimesh_core::geometry::vector::{Vector, add};

/// How fast the points of a body move at a step, in the rotating frame.
#[derive(Debug, Clone)]
pub struct BodyVelocity<'a> {
    /// Its own motions, then those of its parents.
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

    /// What a rigid body does, one transform after another; none where its points move in different ways.
    pub fn rigid(&self) -> Option<Vec<Moving>> {
        let of_link = |link: &Link<'_, Moving>| match link {
            Link::Rigid(moving) => Some(*moving),
            Link::Sections(_) | Link::Nodes(_) => None,
        };
        self.links.iter().map(of_link).collect()
    }
}
