//! `[body.rigid]`: a rotation, then a translation, constant or growing linearly over the steps.

use super::link::{Link, RigidLink};
use super::{At, AxisRotation, BodyMotion, FromSchedule, OnMesh, ResolvedMotion};
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, scale};
use crate::motion::body::Body;
use crate::motion::reader::{AngleUnit, Entry};
use crate::motion::steps::Step;
use std::sync::Arc;

/// A translation, in mesh units.
///
/// ```
/// use azimesh::{Body, Translation};
///
/// let store = Body::new("store", ["store"]).translate(Translation::new([0.0, 0.0, -0.5])).ramp();
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Translation {
    by: Vector,
}

impl Translation {
    /// By a vector, in mesh units.
    pub fn new(by: Vector) -> Self {
        Self { by }
    }
}

/// A rotation about an axis, then a translation.
#[derive(Debug, Clone, Default)]
pub(in crate::motion) struct Rigid {
    pub rotate: Option<AxisRotation>,
    pub translate: Option<Translation>,
    /// From nothing at the first step to the whole at the last.
    pub ramp: bool,
}

impl FromSchedule for Rigid {
    const KEY: &'static str = "rigid";

    fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[body.rigid]", &["rotate", "translate", "ramp"])?;
        Ok(Self {
            rotate: section.optional("rotate", |entry| read_rotation(entry, unit))?,
            translate: (section.optional("translate", Entry::numbers)?).map(Translation::new),
            ramp: section.optional("ramp", Entry::boolean)?.unwrap_or(false),
        })
    }
}

fn read_rotation(entry: &Entry<'_>, unit: AngleUnit) -> Result<AxisRotation> {
    let keys = ["axis", "origin", "angle"];
    let section = entry.section("rotate = { axis, origin, angle }", &keys)?;
    let axis = section.require("axis", "axis = [0.0, 0.0, 1.0]")?;
    let mut rotation = AxisRotation::new(axis.numbers()?);
    rotation.angle = section.require("angle", "angle = 20.0")?.angle(unit)?;
    section.set("origin", &mut rotation.origin, Entry::numbers)?;
    Ok(rotation)
}

impl BodyMotion for Rigid {
    fn order(&self) -> u8 {
        3
    }

    fn has_harmonics(&self) -> bool {
        false
    }

    fn check(&self, body: &Body) -> Result<()> {
        if self.rotate.is_none() && self.translate.is_none() {
            let message = "[body.rigid] has neither `rotate` nor `translate`; give one of them";
            return Err(body.places.error("rigid", message));
        }
        if let Some(rotation) = self.rotate {
            body.places.direction("rigid.rotate.axis", rotation.axis)?;
            body.places
                .finite("rigid.rotate.origin", &rotation.origin)?;
            body.places.angle("rigid.rotate.angle", rotation.angle)?;
        }
        let by = self
            .translate
            .map_or([0.0; 3], |translation| translation.by);
        body.places.finite("rigid.translate", &by)
    }

    fn check_plane(&self, body: &Body) -> Result<()> {
        let axis = self.rotate.map(|rotation| rotation.axis);
        let tilts = axis.is_some_and(|axis| (axis[0], axis[1]) != (0.0, 0.0));
        let lifts = self
            .translate
            .is_some_and(|translation| translation.by[2] != 0.0);
        let keys = [("rigid.rotate", tilts), ("rigid.translate", lifts)];
        let leaves = keys.iter().filter(|(_, leaves)| *leaves);
        let leaves: Vec<&str> = leaves.map(|(key, _)| *key).collect();
        if leaves.is_empty() {
            return Ok(());
        }
        let message = format!(
            "body \"{}\" leaves the plane of the 2D mesh; turn it about [0, 0, 1] and translate it in x and y",
            body.name
        );
        Err(Error::input(message).at(body.places.first_of(&leaves)))
    }

    fn resolve(&self, _: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        Ok(Arc::new(self.clone()))
    }
}

impl ResolvedMotion for Rigid {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let reached = self.reached(at.step, at.clock.steps.len());
        let rate = if self.ramp {
            at.clock.steps_a_second(at.step) / n_intervals(at.clock.steps.len())
        } else {
            0.0
        };
        let part = at.part * reached;
        let rotation = self.rotate.map(|rotation| AxisRotation {
            rate: rotation.angle * rate,
            ..rotation.part(part)
        });
        let by = self
            .translate
            .map_or([0.0; 3], |translation| translation.by);
        Some(Link::Rigid(RigidLink {
            rotations: rotation.into_iter().collect(),
            translation: Some([scale(by, part), scale(by, rate)]),
        }))
    }

    fn centre(&self) -> Option<Vector> {
        let turns = self.rotate.filter(|rotation| rotation.angle != 0.0);
        turns.map(|rotation| rotation.origin)
    }
}

impl Rigid {
    /// How much of the motion a step has: a ramp goes from 0 at the first step to 1 at the last. It is 1
    /// when there is one step.
    fn reached(&self, step: &Step, n_steps: usize) -> f64 {
        if self.ramp && n_steps > 1 {
            step.index as f64 / n_intervals(n_steps)
        } else {
            1.0
        }
    }
}

fn n_intervals(n_steps: usize) -> f64 {
    n_steps.saturating_sub(1).max(1) as f64
}
