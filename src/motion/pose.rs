//! The exact map of every body at every step.

use super::body::{Body, Rigid};
use super::driven::{CentreLine, Clock, Sections};
use super::placed::{Pose, Shift};
use super::resolved::Motion;
use super::rotor::Frame;
use super::steps::Step;
use super::turn::{Displaced, Turn, cyclic_turns};
use crate::geometry::Transform;
use crate::geometry::vector::Vector;
use std::borrow::Cow;

impl Motion {
    /// The exact map `x -> x'` of a body from the reference mesh, in the rotating frame: its
    /// surface, modes and rigid motion, its table, its beam and cyclic motion, then the motion of its parent.
    ///
    /// # Panics
    /// When there is no such body.
    pub fn pose(&self, body: usize, step: &Step) -> Pose<'_> {
        self.pose_part(body, step, 1.0)
    }

    /// The part, from 0 to 1, of a body's [`pose`](Self::pose): every angle and translation of its
    /// motions times `part`. The whole is `pose`, bit for bit.
    ///
    /// # Panics
    /// When there is no such body.
    pub fn pose_part(&self, body: usize, step: &Step, part: f64) -> Pose<'_> {
        let pose = self.own_pose(body, step, part);
        let pose = pose.after_shift(self.shift(body, step, part));
        match self.bodies[body].parent {
            Some(parent) => pose.then_pose(self.pose_part(parent, step, part)),
            None => pose,
        }
    }

    /// The part of the [`pose`](Self::pose) of every body.
    pub fn poses(&self, step: &Step, part: f64) -> Vec<Pose<'_>> {
        let bodies = 0..self.bodies.len();
        bodies
            .map(|body| self.pose_part(body, step, part))
            .collect()
    }

    /// Whether every point of a body has one rigid map.
    pub fn is_rigid(&self, body: usize) -> bool {
        let parent = self.bodies[body].parent;
        let driven = &self.driven[body];
        let alone = driven.beam.is_none() && !driven.has_displacements();
        alone && parent.is_none_or(|parent| self.is_rigid(parent))
    }

    /// Whether every point of a body has a rotation: not where nodes have displacements alone.
    pub fn has_rotations(&self, body: usize) -> bool {
        let parent = self.bodies[body].parent;
        !self.driven[body].has_displacements()
            && parent.is_none_or(|parent| self.has_rotations(parent))
    }

    /// The lifting line of a body that is a beam, held within the span of `points` of it.
    pub fn centre_line(&self, body: usize, points: &[Vector]) -> Option<CentreLine> {
        let beam = self.driven[body].beam.as_ref()?;
        let blade = self.rotor.blade(self.bodies[body].azimuth_offset);
        Some(beam.centre_line(blade, points))
    }

    /// The part of the displacements that nodes of a body have of their own.
    fn shift(&self, body: usize, step: &Step, part: f64) -> Option<Shift<'_>> {
        let driven = &self.driven[body];
        let offset = self.bodies[body].azimuth_offset;
        let surface = driven.surface.as_ref();
        let modes = driven.modes.as_ref();
        Some(Shift {
            nodes: driven.nodes.as_deref()?,
            surface: surface.map(|surface| Cow::Borrowed(surface.at(step, offset))),
            modes: modes.map(|modes| (modes, modes.coordinates(step, offset))),
            part,
        })
    }

    /// Rates of those displacements, by seconds.
    pub(super) fn shift_rates(&self, body: usize, step: &Step) -> Option<Shift<'_>> {
        let driven = &self.driven[body];
        let (offset, clock) = (self.bodies[body].azimuth_offset, self.clock());
        let surface = driven.surface.as_ref();
        let modes = driven.modes.as_ref();
        Some(Shift {
            nodes: driven.nodes.as_deref()?,
            surface: surface.map(|surface| Cow::Owned(surface.rates(step, offset, &clock))),
            modes: modes.map(|modes| (modes, modes.rates(step, offset, &clock))),
            part: 1.0,
        })
    }

    /// The displacements that nodes of a body have of their own at a step.
    pub(super) fn whole_shift(&self, body: usize, step: &Step) -> Option<Shift<'_>> {
        self.shift(body, step, 1.0)
    }

    /// The part of a body's motion that is its own, its parent left out.
    fn own_pose(&self, index: usize, step: &Step, part: f64) -> Pose<'_> {
        let body = &self.bodies[index];
        let mut base = match &body.rigid {
            Some(rigid) => rigid.part(part * self.reached(rigid, step)),
            None => Transform::IDENTITY,
        };
        if let Some(table) = self.table(index, step) {
            base = base.then(&table.part(part));
        }
        let base = Pose::of_rigid(base);
        if let Some(sections) = self.sections(index, step, part) {
            return base.then_sections(sections);
        }
        match self.cyclic_turns(body, step) {
            Some(turns) => {
                let [pitch, flap, lag] = turns.map(|turn| turn.part(part));
                base.then(&pitch.then(&flap).then(&lag))
            }
            None => base,
        }
    }

    /// The beam of a body at a part of a step, its cyclic motion included.
    pub(super) fn sections(&self, body: usize, step: &Step, part: f64) -> Option<Sections<'_>> {
        let beam = self.driven[body].beam.as_ref()?;
        let body = &self.bodies[body];
        let blade = self.rotor.blade(body.azimuth_offset);
        let frame = (blade, self.cyclic_turns(body, step));
        Some(beam.at(step, body.azimuth_offset, part, frame, &self.clock()))
    }

    /// The rotations of a body at a step, in their order, those of its parent after its own; of the
    /// sections that `x` of the reference mesh is in, where beams bend.
    pub(super) fn turns(&self, index: usize, step: &Step, x: Vector) -> Vec<Turn> {
        let body = &self.bodies[index];
        let mut turns = Vec::new();
        if let Some((rigid, (axis, origin, angle))) = body
            .rigid
            .as_ref()
            .and_then(|rigid| Some((rigid, rigid.rotate?)))
        {
            turns.push(Turn {
                axis,
                origin,
                angle: angle * self.reached(rigid, step),
                rate: 0.0,
            });
        }
        turns.extend(self.table(index, step).into_iter().flat_map(|t| t.turns));
        match self.sections(index, step, 1.0) {
            Some(sections) => turns.extend(sections.turns(x)),
            None => turns.extend(self.cyclic_turns(body, step).into_iter().flatten()),
        }
        if let Some(parent) = body.parent {
            turns.extend(self.turns(parent, step, x));
        }
        turns
    }

    /// Pitch, flap and lag of a body's cyclic motion at a step, in radians, positive in the sense that
    /// the signs of the rotor give them; `None` where it has none.
    pub fn cyclic_angles(&self, body: usize, step: &Step) -> Option<[f64; 3]> {
        let body = &self.bodies[body];
        let cyclic = body.cyclic.as_ref()?;
        let psi = step.azimuth + body.azimuth_offset;
        let series = [&cyclic.pitch, &cyclic.flap, &cyclic.lag];
        Some(series.map(|series| series.at(psi, cyclic.phase)))
    }

    /// What the table of a body does at a step.
    pub(super) fn table(&self, body: usize, step: &Step) -> Option<Displaced> {
        let table = self.driven[body].table.as_ref()?;
        Some(table.at(step, self.bodies[body].azimuth_offset, &self.clock()))
    }

    pub(super) fn clock(&self) -> Clock<'_> {
        Clock {
            steps: &self.steps,
            azimuth_rate: self.azimuth_rate,
            neighbours: &self.neighbours,
        }
    }

    pub(super) fn cyclic_turns(&self, body: &Body, step: &Step) -> Option<[Turn; 3]> {
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
    pub(super) fn reached(&self, rigid: &Rigid, step: &Step) -> f64 {
        match self.steps.len() {
            _ if !rigid.ramp => 1.0,
            0 | 1 => 1.0,
            n => step.index as f64 / (n - 1) as f64,
        }
    }
}
