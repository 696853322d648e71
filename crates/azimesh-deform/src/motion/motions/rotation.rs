//! A rotation about an axis at a step: what the motions are made of.

use azimesh_core::geometry::vector::Vector;
use azimesh_core::geometry::{Moving, Transform};

/// A right-handed rotation about an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::motion) struct Rotation {
    /// Unit axis.
    pub axis: Vector,
    /// A point of the axis, in mesh units.
    pub origin: Vector,
    /// In radians.
    pub angle: f64,
    /// In radians a second; 0 where the schedule has no time.
    pub rate: f64,
}

impl Rotation {
    /// The part, from 0 to 1, of the angle.
    pub fn part(self, part: f64) -> Self {
        Self {
            angle: part * self.angle,
            ..self
        }
    }

    pub fn map(&self) -> Transform {
        Transform::rotation(self.axis, self.origin, self.angle)
    }

    /// The rotation with its velocity.
    pub fn moving(&self) -> Moving {
        Moving::rotation(self.axis, self.origin, self.angle, self.rate)
    }
}
