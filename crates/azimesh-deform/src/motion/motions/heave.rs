//! A motion of a test, to show what a new one takes: this file and a line of `MOTIONS`.
//!
//! `body.heave = { amplitude, axis }` moves a body along an axis by `amplitude sin(azimuth)`.

use super::link::{Link, RigidLink};
use super::{At, BodyMotion, FromSchedule, OnMesh, ResolvedMotion};
use crate::motion::body::Body;
use crate::motion::reader::{AngleUnit, Entry};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, scale};
use std::sync::Arc;

#[derive(Debug, Clone)]
pub(super) struct Heave {
    amplitude: f64,
    axis: Vector,
}

impl FromSchedule for Heave {
    const KEY: &'static str = "heave";

    fn read(entry: &Entry<'_>, _: AngleUnit) -> Result<Self> {
        let section = entry.section("[body.heave]", &["amplitude", "axis"])?;
        Ok(Self {
            amplitude: section.require("amplitude", "amplitude = 0.1")?.number()?,
            axis: section
                .require("axis", "axis = [0.0, 1.0, 0.0]")?
                .numbers()?,
        })
    }
}

impl BodyMotion for Heave {
    fn order(&self) -> u8 {
        7
    }

    fn has_harmonics(&self) -> bool {
        true
    }

    fn check(&self, body: &Body) -> Result<()> {
        body.places.positive("heave.amplitude", self.amplitude)
    }

    fn resolve(&self, _: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        Ok(Arc::new(self.clone()))
    }
}

impl ResolvedMotion for Heave {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let (sin, cos) = at.step.azimuth.sin_cos();
        let rate = at.step.azimuth_rate.unwrap_or(0.0);
        let by =
            [at.part * sin, rate * cos].map(|factor| scale(self.axis, self.amplitude * factor));
        Some(Link::Rigid(RigidLink {
            rotations: Vec::new(),
            translation: Some(by),
        }))
    }
}
