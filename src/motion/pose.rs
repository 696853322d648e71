//! The exact rigid map of every body at every step.

use super::body::{Body, Cyclic, Rigid};
use super::rotor::{Frame, RotorAxes};
use super::schedule::Schedule;
use super::steps::Step;
use super::surface::{Surface, nodes_of_tags};
use super::tags::{PeriodicTags, TagRoles};
use super::zones::DeformingZone;
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::geometry::{Bounds, Transform};
use crate::mesh::{Group, Mesh};

/// Extent in z, relative to the diagonal, above which a mesh of 2D cells is not plane.
const PLANE: f64 = 1e-6;

/// A schedule on a mesh.
#[derive(Debug, Clone)]
pub struct Motion {
    /// The steps, at least one.
    pub steps: Vec<Step>,
    /// The rotor's axes.
    pub rotor: RotorAxes,
    /// The moving bodies, in the order of the schedule.
    pub bodies: Vec<Body>,
    /// The surface nodes with their roles, and the faces between them.
    pub surface: Surface,
    /// The periodic pairs, in the order of the schedule.
    pub periodic: Vec<PeriodicTags>,
    /// The part of the mesh that deforms; the whole mesh when `None`.
    pub zone: Option<DeformingZone>,
}

impl Motion {
    pub(super) fn new(schedule: &Schedule, mesh: &Mesh) -> Result<Self> {
        let dimension = mesh.dimension();
        if dimension < 2 {
            return Err(Error::input(
                "the mesh has no cells of two or three dimensions; there is nothing to deform",
            ));
        }
        if dimension == 2 {
            check_plane(mesh, &schedule.bodies)?;
        }
        let rotor = schedule.rotor.axes(dimension)?;
        let zone = DeformingZone::find(&schedule.boundaries.zones, mesh)?;
        let tags: Vec<&Group> = mesh.boundary_tags().collect();
        let named = TagRoles::find(
            &tags,
            &schedule.bodies,
            &schedule.boundaries,
            zone.as_ref(),
            mesh,
        )?;
        let surface = Surface::find(&tags, named.tags, zone.as_ref(), mesh);
        Ok(Self {
            steps: schedule.steps.clone(),
            rotor,
            bodies: schedule.bodies.clone(),
            surface,
            periodic: named.periodic,
            zone,
        })
    }

    /// The nodes of both sides of a periodic pair, ascending; with zones, those in the zones.
    pub fn periodic_nodes(&self, pair: &PeriodicTags, mesh: &Mesh) -> [Vec<u32>; 2] {
        [&pair.a, &pair.b].map(|tags| nodes_of_tags(tags, self.zone.as_ref(), mesh))
    }

    /// The exact map `x -> x'` of a body from the reference mesh, in the rotating frame: its rigid
    /// motion, then its cyclic motion.
    ///
    /// # Panics
    /// When there is no such body.
    pub fn pose(&self, body: usize, step: &Step) -> Transform {
        self.pose_part(body, step, 1.0)
    }

    /// The part, from 0 to 1, of a body's [`pose`](Self::pose): every angle and translation of its
    /// motions times `part`. The whole is `pose`, bit for bit.
    ///
    /// # Panics
    /// When there is no such body.
    pub fn pose_part(&self, body: usize, step: &Step, part: f64) -> Transform {
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

    /// The rotations of a body at a step, in their order.
    pub(super) fn turns(&self, body: usize, step: &Step) -> Vec<Turn> {
        let body = &self.bodies[body];
        let rigid = body.rigid.as_ref().and_then(|rigid| {
            let (axis, origin, angle) = rigid.rotate?;
            Some(Turn {
                axis,
                origin,
                angle: angle * self.reached(rigid, step),
            })
        });
        let cyclic = self.cyclic_turns(body, step);
        rigid
            .into_iter()
            .chain(cyclic.into_iter().flatten())
            .collect()
    }

    fn cyclic_turns(&self, body: &Body, step: &Step) -> Option<[Turn; 3]> {
        let blade = self.rotor.blade(body.azimuth_offset);
        let psi = step.azimuth + body.azimuth_offset;
        let cyclic = body.cyclic.as_ref()?;
        Some(cyclic_turns(cyclic, &blade, psi))
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

/// Equations 2 and 3 of the method without a beam, in the blade's own frame at its azimuth `psi`:
///
/// ```text
/// x_r = Rx(pitch) (x - x_ref),                 x_ref = O + r e_x + pitch_axis
/// x'  = O + h e_x + Rz(lag) Ry(-flap) (x_r + x_ref - O - h e_x)
/// ```
///
/// Its turns, pitch first. The pitch axis is parallel to the span, so that turning about it needs no station `r`.
fn cyclic_turns(cyclic: &Cyclic, blade: &RotorAxes, psi: f64) -> [Turn; 3] {
    let signs = &blade.signs;
    let pitch = signs.pitch * cyclic.pitch.at(psi, cyclic.phase);
    let flap = signs.flap * cyclic.flap.at(psi, cyclic.phase);
    let lag = signs.lag * cyclic.lag.at(psi, cyclic.phase);
    let [chordwise, shaftwise] = cyclic.pitch_axis;
    let pitch_axis = blade.point(0.0, chordwise, shaftwise);
    let hinge = blade.point(cyclic.flap_hinge, 0.0, 0.0);
    let turn = |axis, origin, angle| Turn {
        axis,
        origin,
        angle,
    };
    [
        turn(blade.e_x, pitch_axis, pitch),
        turn(blade.e_y, hinge, -flap),
        turn(blade.e_z, hinge, lag),
    ]
}

/// A rotation about an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// Unit axis.
    pub axis: Vector,
    /// A point of the axis, in mesh units.
    pub origin: Vector,
    /// In radians.
    pub angle: f64,
}

impl Turn {
    fn part(&self, part: f64) -> Transform {
        Transform::rotation(self.axis, self.origin, part * self.angle)
    }
}

/// Refuses what would leave the plane of a 2D mesh.
fn check_plane(mesh: &Mesh, bodies: &[Body]) -> Result<()> {
    let bounds = Bounds::around(&mesh.points);
    let [low, high] = [bounds.low[2], bounds.high[2]];
    if high - low > PLANE * bounds.diagonal() {
        return Err(Error::input(format!(
            "the mesh has 2D cells only, but z runs from {low} to {high}; a 2D mesh must lie in a plane of constant z"
        )));
    }
    for body in bodies {
        if let Some(line) = body.cyclic.as_ref().and_then(|cyclic| cyclic.out_of_plane) {
            return Err(Error::input(format!(
                "body \"{}\" flaps or lags, which needs a 3D mesh; in 2D a cyclic motion is pitch alone",
                body.name
            ))
            .line(line));
        }
        if let Some(line) = body.rigid.as_ref().and_then(|rigid| rigid.out_of_plane) {
            return Err(Error::input(format!(
                "body \"{}\" leaves the plane of the 2D mesh; turn it about [0, 0, 1] and translate it in x and y",
                body.name
            ))
            .line(line));
        }
    }
    Ok(())
}
