//! A rotation about an axis, as users declare it.

use super::TableSource;
use super::oscillation::Oscillation;
use crate::motion::setters::setters;
use crate::motion::table::Interpolation;
use azimesh_core::geometry::vector::{Vector, unit};

/// A right-handed rotation about an axis. The angle is constant, oscillates with the azimuth or at a frequency, or
/// comes from a table.
///
/// ```text
/// angle = mean + sum over m of [ A_m sin(m psi) + B_m cos(m psi) ] + table
/// ```
///
/// with the azimuth `psi` of the body, or `psi = 2 pi f t` where a frequency `f` is given.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{AxisRotation, Body};
///
/// let about = AxisRotation::new([0.0, 0.0, 1.0]).origin([0.25, 0.0, 0.0]).angle_deg(20.0);
/// let airfoil = Body::new("airfoil", ["airfoil"]).rotate(about);
///
/// // 2 degrees, and 10 degrees more to either side, 5 times a second.
/// let hinge = AxisRotation::new([0.0, 1.0, 0.0]).origin([0.7, 0.0, 0.0]);
/// let swing = hinge.angle_deg(2.0).harmonic_deg(1, 10.0, 0.0).frequency_hz(5.0);
/// let flap = Body::new("flap", ["flap"]).rotate(swing);
/// ```
#[derive(Debug, Clone)]
pub struct AxisRotation {
    /// Unit axis; zero for a direction of zero length.
    pub(in crate::motion) axis: Vector,
    /// A point of the axis, in mesh units.
    pub(in crate::motion) origin: Vector,
    pub(in crate::motion) angle: Oscillation,
}

impl AxisRotation {
    /// Creates a rotation about an axis through the origin in this direction, of any length; its angle is zero.
    pub fn new(axis: Vector) -> Self {
        Self {
            axis: unit(axis).unwrap_or_default(),
            origin: [0.0; 3],
            angle: Oscillation::default(),
        }
    }
}

setters! { AxisRotation {
    /// Sets a point of the axis, in mesh units.
    origin(origin: Vector) |self| self.origin = origin;
    /// Sets the angle, in degrees; the mean if it has harmonics.
    angle_deg(angle: f64) |self| self.angle.series.mean = angle.to_radians();
    /// Sets harmonic `m` of the angle, from 1: `sin` and `cos` in degrees.
    harmonic_deg(m: usize, sin: f64, cos: f64) |self| self.angle.series.set_deg(m, sin, cos);
    /// Sets the frequency of the first harmonic in Hz, for steps in time; by default it follows the azimuth.
    frequency_hz(frequency: f64) |self| self.angle.frequency = Some(frequency);
    /// Adds an angle from a table of `azimuth_deg`, `time_s` or `step`, and `angle_deg` (or `angle_rad`).
    table(table: impl Into<TableSource>) |self| self.angle.table = Some(table.into());
    /// Interpolates the table with a cubic spline, which is periodic if the table is.
    cubic() |self| self.angle.interpolation = Interpolation::Cubic;
} }
