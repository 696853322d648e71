//! Chains of motions: the map, the velocity and the rotations of every body at every step.
//!
//! ```text
//! own motions in their order ── links ──> then those of the parent ──┬─ maps ──────> BodyMap
//!                                                                    ├─ velocities ─> BodyVelocity
//!                                                                    └─ rotations ──> twist
//! ```

use super::body_map::{BodyMap, BodyVelocity};
use super::motions::{At, CentreLine, Clock, Link, MapScope, ResolvedMotion, Rotation};
use super::resolved::{Motion, MovingBody};
use super::steps::Step;
use azimesh_core::geometry::vector::{Vector, add, scale};
use std::sync::Arc;

/// The rigid motions of a body at a step.
#[derive(Debug, Clone, Default)]
pub struct RigidAt {
    /// The rotations, in their order.
    pub rotations: Vec<Rotation>,
    /// The sum of the translations, in mesh units.
    pub translation: Vector,
}

impl Motion {
    /// Returns the exact map `x -> x'` of a body from the reference mesh, in the rotating frame: its own motions in
    /// their order, then the motion of its parent.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn pose(&self, body: usize, step: &Step) -> BodyMap<'_> {
        self.pose_part(body, step, 1.0)
    }

    /// Returns a part, from 0 to 1, of a body's [`pose`](Self::pose): every angle and translation of its motions times
    /// `part`. For 1 it equals `pose`, bit for bit.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn pose_part(&self, body: usize, step: &Step, part: f64) -> BodyMap<'_> {
        let mut map = BodyMap::default();
        for link in self.own_links(body, &self.at(body, step, part)) {
            map.push(link.with_rigid(|rigid| rigid.map()));
        }
        match self.bodies[body].parent {
            Some(parent) => map.then_map(self.pose_part(parent, step, part)),
            None => map,
        }
    }

    /// Returns the part of the [`pose`](Self::pose) of every body.
    pub fn poses(&self, step: &Step, part: f64) -> Vec<BodyMap<'_>> {
        let bodies = 0..self.bodies.len();
        bodies
            .map(|body| self.pose_part(body, step, part))
            .collect()
    }

    /// Returns the exact map of every body at a step, with the rotation to the inertial frame if its rotor has that frame.
    pub fn poses_in_place(&self, step: &Step) -> Vec<BodyMap<'_>> {
        let to_inertial = self.to_inertial(step);
        let to_inertial = |body| to_inertial.as_ref()?.of_body(body);
        let poses = self.poses(step, 1.0).into_iter().enumerate();
        poses
            .map(|(body, pose)| match to_inertial(body) {
                Some(to_inertial) => pose.then(to_inertial),
                None => pose,
            })
            .collect()
    }

    /// Velocities of the points of every body at a step. Linear tables give the slope after a row; a ramp gives the slope
    /// between the neighbouring steps.
    pub fn velocities(&self, step: &Step) -> Vec<BodyVelocity<'_>> {
        let links = |body| {
            let at = At {
                rates: true,
                ..self.at(body, step, 1.0)
            };
            self.family(body)
                .flat_map(move |body| self.own_links(body, &at))
        };
        let velocity = |body| BodyVelocity {
            links: links(body)
                .filter(|link| !link.is_rest())
                .map(|link| link.with_rigid(|rigid| rigid.moving()))
                .collect(),
        };
        (0..self.bodies.len()).map(velocity).collect()
    }

    /// Rotations of a body at a step, in their order, followed by the rotations of its parent. Beams give the rotations of
    /// the sections that contain `x` of the reference mesh.
    pub(super) fn rotations(&self, body: usize, step: &Step, x: Vector) -> Vec<Rotation> {
        let at = self.at(body, step, 1.0);
        let links = self.family(body).flat_map(|body| self.own_links(body, &at));
        links.flat_map(|link| link.rotations(x)).collect()
    }

    /// Rotations of a body's own rigid motions at a step, in their order, and the sum of their translations. Cyclic
    /// motion (see [`cyclic_angles`](Self::cyclic_angles)), beams and displacements of nodes are left out.
    pub fn rigid_parts(&self, body: usize, step: &Step) -> RigidAt {
        let at = self.at(body, step, 1.0);
        let MovingBody { motions, ramp, .. } = &self.bodies[body];
        let ramp = ramp
            .as_ref()
            .map_or([1.0, 0.0], |ramp| ramp.at(step, &at.clock));
        let is_rigid = |motion: &&Arc<dyn ResolvedMotion>| {
            motion.map_scope() == MapScope::Body && motion.cyclic_angles(step).is_none()
        };
        let links = motions
            .iter()
            .filter(is_rigid)
            .filter_map(|motion| motion.link(&at));
        let mut parts = RigidAt::default();
        for link in links {
            if let Link::Rigid(link) = link.ramped(ramp) {
                parts.rotations.extend(link.rotations);
                let [by, _] = link.translation.unwrap_or_default();
                parts.translation = add(parts.translation, by);
            }
        }
        parts
    }

    /// Links of the body's own motions, without its parent's.
    fn own_links<'a>(&'a self, body: usize, at: &At<'_>) -> Vec<Link<'a>> {
        let MovingBody { motions, ramp, .. } = &self.bodies[body];
        let links = motions.iter().filter_map(|motion| motion.link(at));
        match ramp {
            Some(ramp) => {
                let ramp = ramp.at(at.step, &at.clock);
                links.map(|link| link.ramped(ramp)).collect()
            }
            None => links.collect(),
        }
    }

    /// Returns a body, its parent, and so on.
    fn family(&self, body: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(body), |&body| self.bodies[body].parent)
    }

    /// Returns whether all points of a body share one rigid map.
    pub fn is_rigid(&self, body: usize) -> bool {
        self.all_motions(body, |scope| scope == MapScope::Body)
    }

    /// Returns whether every point of a body has a rotation: false where only displacements of nodes are known.
    pub fn has_rotations(&self, body: usize) -> bool {
        self.all_motions(body, |scope| scope != MapScope::Nodes)
    }

    fn all_motions(&self, body: usize, is_so: impl Fn(MapScope) -> bool) -> bool {
        let mut motions = self
            .family(body)
            .flat_map(|body| &self.bodies[body].motions);
        motions.all(|motion| is_so(motion.map_scope()))
    }

    /// Returns the lifting line of a body that is a beam, within the span of `points` of it.
    pub fn centre_line(&self, body: usize, points: &[Vector]) -> Option<CentreLine> {
        let mut motions = self.bodies[body].motions.iter();
        motions.find_map(|motion| motion.centre_line(points))
    }

    /// Returns the size in bytes of the displacements that functions and files give for the nodes of bodies.
    pub fn memory_bytes(&self) -> usize {
        let motions = self.bodies.iter().flat_map(|body| &body.motions);
        motions.map(|motion| motion.memory_bytes()).sum()
    }

    /// Returns pitch, flap and lag of a body's cyclic motion at a step, in radians, with the positive sense given by
    /// the signs of the rotor; `None` if it has none.
    pub fn cyclic_angles(&self, body: usize, step: &Step) -> Option<[f64; 3]> {
        let at = self.at(body, step, 1.0);
        let mut motions = self.bodies[body].motions.iter();
        let angles = motions.find_map(|motion| motion.cyclic_angles(at.step))?;
        Some(scale(angles, self.reached(body, &at)))
    }

    /// Returns the angle of a body's `rigid.rotate` at a step, in radians; `None` if it has none.
    pub fn axis_angle(&self, body: usize, step: &Step) -> Option<f64> {
        let at = self.at(body, step, 1.0);
        let mut motions = self.bodies[body].motions.iter();
        let angle = motions.find_map(|motion| motion.axis_angle(&at))?;
        Some(angle * self.reached(body, &at))
    }

    /// Returns the part of a body's motions that its smooth start has reached.
    fn reached(&self, body: usize, at: &At<'_>) -> f64 {
        let ramp = self.bodies[body].ramp.as_ref();
        ramp.map_or(1.0, |ramp| ramp.at(at.step, &at.clock)[0])
    }

    /// Returns whether a body, or a parent of it, has a blade motion along the rotor's span.
    pub fn is_of_blade(&self, body: usize) -> bool {
        let body = &self.bodies[body];
        let own = body.motions.iter().any(|motion| motion.is_of_blade());
        own || body.parent.is_some_and(|parent| self.is_of_blade(parent))
    }

    /// Returns a part of a step at the azimuth of the body's rotor.
    fn at<'a>(&'a self, body: usize, step: &'a Step, part: f64) -> At<'a> {
        At {
            step: self.rotors[self.bodies[body].rotor].step(step),
            part,
            clock: Clock {
                steps: &self.steps,
                neighbours: &self.neighbours,
            },
            rates: false,
        }
    }
}
