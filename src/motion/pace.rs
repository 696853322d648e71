//! Velocities of the points of a body: its exact map differentiated by time.

use super::driven::Sections;
use super::placed::Shift;
use super::resolved::Motion;
use super::rotor::Frame;
use super::steps::Step;
use super::turn::{Turn, rigid_displaced};
use crate::geometry::vector::{Vector, add};
use crate::geometry::{Moving, Transform};

/// How fast the points of a body move at a step, in the rotating frame.
#[derive(Debug, Clone)]
pub struct Pace<'a> {
    /// Displacements that nodes have of their own, and their rates.
    shift: Option<[Shift<'a>; 2]>,
    links: Vec<Link<'a>>,
}

/// One map of a chain, with its velocity.
#[derive(Debug, Clone)]
enum Link<'a> {
    Rigid(Moving),
    Sections(Box<Sections<'a>>),
}

impl Motion {
    /// How fast the points of every body move at a step. Tables give the slope after a row where they
    /// are linear; a ramp that over the steps beside this one.
    pub fn paces(&self, step: &Step) -> Vec<Pace<'_>> {
        let pace = |body: usize| {
            let mut links = Vec::new();
            let mut next = Some(body);
            while let Some(at) = next {
                self.add_own_links(at, step, &mut links);
                next = self.bodies[at].parent;
            }
            let shift = self.whole_shift(body, step);
            let rates = self.shift_rates(body, step);
            let shift = shift.zip(rates).map(<[Shift<'_>; 2]>::from);
            Pace { shift, links }
        };
        (0..self.bodies.len()).map(pace).collect()
    }

    /// The carrying round of the inertial frame, with its velocity.
    pub fn carry_moving(&self, step: &Step) -> Option<Moving> {
        let rate = self.azimuth_rate.unwrap_or(0.0);
        let rotor = &self.rotor;
        (rotor.frame == Frame::Inertial).then(|| {
            let sign = rotor.signs.azimuth;
            Moving::rotation(rotor.e_z, rotor.hub, sign * step.azimuth, sign * rate)
        })
    }

    fn add_own_links<'a>(&'a self, index: usize, step: &Step, links: &mut Vec<Link<'a>>) {
        let body = &self.bodies[index];
        if let Some(rigid) = &body.rigid {
            let intervals = self.steps.len().saturating_sub(1).max(1) as f64;
            let rate = match rigid.ramp {
                true => self.clock().steps_a_second(step) / intervals,
                false => 0.0,
            };
            let displaced = rigid_displaced(rigid, self.reached(rigid, step), rate);
            links.push(Link::Rigid(displaced.moving()));
        }
        if let Some(table) = self.table(index, step) {
            links.push(Link::Rigid(table.moving()));
        }
        if let Some(sections) = self.sections(index, step, 1.0) {
            links.push(Link::Sections(Box::new(sections)));
        } else if let Some(turns) = self.cyclic_turns(body, step) {
            let still = Moving::still(Transform::IDENTITY);
            let moving = |all: Moving, turn: &Turn| all.then(&turn.moving());
            links.push(Link::Rigid(turns.iter().fold(still, moving)));
        }
    }
}

impl Pace<'_> {
    /// The velocity of a node whose place in the reference mesh is `x`, in mesh units a second.
    pub fn velocity(&self, node: u32, x: Vector) -> Vector {
        let (mut place, mut velocity) = match &self.shift {
            Some([shift, rates]) => (add(x, shift.of(node)), rates.of(node)),
            None => (x, [0.0; 3]),
        };
        for link in &self.links {
            let moving = match link {
                Link::Rigid(moving) => *moving,
                Link::Sections(sections) => sections.moving(x),
            };
            velocity = moving.velocity(place, velocity);
            place = moving.map.apply(place);
        }
        velocity
    }
}
