//! A rotation about an axis, as users declare it and as the motions are made of it.

use crate::geometry::vector::{Vector, unit};
use crate::geometry::{Moving, Transform};
use crate::motion::setters::setters;

/// A right-handed rotation about an axis.
///
/// ```
/// use azimesh::{AxisRotation, Body};
///
/// let about = AxisRotation::new([0.0, 0.0, 1.0]).origin([0.25, 0.0, 0.0]).angle_deg(20.0);
/// let airfoil = Body::new("airfoil", ["airfoil"]).rotate(about);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisRotation {
    /// Unit axis; zero where a direction of no length was given.
    pub(in crate::motion) axis: Vector,
    /// A point of the axis, in mesh units.
    pub(in crate::motion) origin: Vector,
    /// In radians.
    pub(in crate::motion) angle: f64,
    /// In radians a second; 0 where the schedule has no time.
    pub(in crate::motion) rate: f64,
}

impl AxisRotation {
    /// About an axis through the origin in this direction, of any length; by no angle yet.
    pub fn new(axis: Vector) -> Self {
        Self {
            axis: unit(axis).unwrap_or_default(),
            origin: [0.0; 3],
            angle: 0.0,
            rate: 0.0,
        }
    }

    /// The part, from 0 to 1, of the angle.
    pub(super) fn part(self, part: f64) -> Self {
        Self {
            angle: part * self.angle,
            ..self
        }
    }

    pub(super) fn map(&self) -> Transform {
        Transform::rotation(self.axis, self.origin, self.angle)
    }

    /// The rotation with its velocity.
    pub(super) fn moving(&self) -> Moving {
        Moving::rotation(self.axis, self.origin, self.angle, self.rate)
    }
}

setters! { AxisRotation {
    /// A point of the axis, in mesh units.
    origin(origin: Vector) |self| self.origin = origin;
    /// The angle, in degrees.
    angle_deg(angle: f64) |self| self.angle = angle.to_radians();
} }
