//! The exact map of every body at every step.

use super::body::{Body, Rigid};
use super::placed::Pose;
use super::resolved::Motion;
use super::rotor::Frame;
use super::steps::Step;
use super::turn::{Displaced, Turn, cyclic_turns, rigid_displaced};
use crate::geometry::Transform;

impl Motion {
    /// The exact map `x -> x'` of a body from the reference mesh, in the rotating frame: its rigid
    /// motion, then its cyclic motion, then the motion of its parent.
    ///
    /// # Panics
    /// When there is no such body.
    pub fn pose(&self, body: usize, step: &Step) -> Pose {
        self.pose_part(body, step, 1.0)
    }

    /// The part, from 0 to 1, of a body's [`pose`](Self::pose): every angle and translation of its
    /// motions times `part`. The whole is `pose`, bit for bit.
    ///
    /// # Panics
    /// When there is no such body.
    pub fn pose_part(&self, body: usize, step: &Step, part: f64) -> Pose {
        let mut pose = Pose::of_rigid(self.own_pose(body, step, part));
        let mut child = body;
        while let Some(parent) = self.bodies[child].parent {
            pose = pose.then(&self.own_pose(parent, step, part));
            child = parent;
        }
        pose
    }

    /// The part of the [`pose`](Self::pose) of every body.
    pub fn poses(&self, step: &Step, part: f64) -> Vec<Pose> {
        let bodies = 0..self.bodies.len();
        bodies
            .map(|body| self.pose_part(body, step, part))
            .collect()
    }

    /// The part of a body's motion that is its own, its parent left out.
    fn own_pose(&self, body: usize, step: &Step, part: f64) -> Transform {
        let body = &self.bodies[body];
        let rigid = match &body.rigid {
            Some(rigid) => rigid.part(part * self.reached(rigid, step)),
            None => Transform::IDENTITY,
        };
        let Some(turns) = self.cyclic_turns(body, step) else {
            return rigid;
        };
        let [pitch, flap, lag] = turns.map(|turn| turn.part(part));
        rigid.then(&pitch.then(&flap).then(&lag))
    }

    /// The rotations of a body at a step, in their order, those of its parent after its own.
    pub(super) fn turns(&self, body: usize, step: &Step) -> Vec<Turn> {
        let mut turns = Vec::new();
        let mut next = Some(body);
        while let Some(at) = next {
            let body = &self.bodies[at];
            turns.extend(self.displaced(body, step).into_iter().flat_map(|r| r.turns));
            turns.extend(self.cyclic_turns(body, step).into_iter().flatten());
            next = body.parent;
        }
        turns
    }

    fn displaced(&self, body: &Body, step: &Step) -> Option<Displaced> {
        let rigid = body.rigid.as_ref()?;
        let reached = self.reached(rigid, step);
        Some(rigid_displaced(rigid, reached, 0.0))
    }

    fn cyclic_turns(&self, body: &Body, step: &Step) -> Option<[Turn; 3]> {
        let blade = self.rotor.blade(body.azimuth_offset);
        let psi = step.azimuth + body.azimuth_offset;
        let rate = self.azimuth_rate.unwrap_or(0.0);
        Some(cyclic_turns(body.cyclic.as_ref()?, &blade, psi, rate))
    }

    /// In the inertial frame, the azimuth rotation `Rz(psi)` that carries the whole deforming zone
    /// round after it has deformed; `None` in the rotating frame.
    pub fn carry(&self, step: &Step) -> Option<Transform> {
        (self.rotor.frame == Frame::Inertial).then(|| self.rotor.turn(step.azimuth))
    }

    /// How much of a rigid motion a step has: a ramp goes from 0 at the first step to 1 at the last.
    /// It is 1 when there is one step.
    fn reached(&self, rigid: &Rigid, step: &Step) -> f64 {
        match self.steps.len() {
            _ if !rigid.ramp => 1.0,
            0 | 1 => 1.0,
            n => step.index as f64 / (n - 1) as f64,
        }
    }
}
