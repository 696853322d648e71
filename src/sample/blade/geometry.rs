//! Measures of a blade and of the cylinder around it, checked once.

use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, unit};

/// Options of the shape; lengths in mesh units.
#[derive(Debug, Clone, Copy, Default, PartialEq, clap::Args)]
pub struct BladeShape {
    /// No twist; chord 1, root 1 and radius 6 unless given
    #[arg(long)]
    pub untwisted: bool,
    /// Chord of the blade [default: 0.3]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub chord: Option<f64>,
    /// Radius at which the blade begins [default: 0.9]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub root: Option<f64>,
    /// Radius at which the blade ends [default: 5.625]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Linear twist from hub to tip in degrees, zero at 75% radius [default: -8]
    #[arg(long, value_name = "ANGLE", allow_negative_numbers = true)]
    pub twist: Option<f64>,
    /// Radius of the cylinder around the blade [default: 2 chords or 4/15 of the radius]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub cylinder_radius: Option<f64>,
}

/// Checked measures, lengths in mesh units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// Chord.
    pub chord: f64,
    /// Radius at which the blade begins.
    pub root: f64,
    /// Radius at which the blade ends.
    pub radius: f64,
    /// Twist from hub to tip in radians.
    pub twist: f64,
    /// Around the blade.
    pub cylinder: Cylinder,
}

/// A cylinder about the x axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Its radius.
    pub radius: f64,
    /// Its ends along the span.
    pub ends: [f64; 2],
}

impl Cylinder {
    /// The point of a cylinder three times as wide, and as much longer at either end, that is
    /// opposite to a point of this one's surface.
    pub fn far(&self, [x, y, z]: Vector) -> Vector {
        let middle = 0.5 * (self.ends[0] + self.ends[1]);
        let half = 0.5 * (self.ends[1] - self.ends[0]);
        let stretch = (half + 2.0 * self.radius) / half;
        [middle + stretch * (x - middle), 3.0 * y, 3.0 * z]
    }
}

impl BladeShape {
    /// Checks the measures.
    pub fn resolve(&self) -> Result<Geometry> {
        let [chord, root, radius, twist] = if self.untwisted {
            [1.0, 1.0, 6.0, 0.0]
        } else {
            [0.3, 0.9, 5.625, -8.0]
        };
        let chord = self.chord.unwrap_or(chord);
        let root = self.root.unwrap_or(root);
        let radius = self.radius.unwrap_or(radius);
        let twist = self.twist.unwrap_or(twist);
        for (option, value) in [("--chord", chord), ("--root", root), ("--radius", radius)] {
            if !(value > 0.0 && value < 1e6) {
                return Err(Error::input(format!(
                    "{option} is a length above 0, found {value}"
                )));
            }
        }
        if self.untwisted && self.twist.is_some_and(|twist| twist != 0.0) {
            return Err(Error::input("--untwisted and --twist exclude each other"));
        }
        if !(-30.0..=30.0).contains(&twist) {
            return Err(Error::input(format!(
                "--twist is an angle from -30 to 30 degrees, found {twist}"
            )));
        }
        if radius - root < 0.5 * chord {
            return Err(Error::input(format!(
                "the blade from {root} to {radius} is shorter than half its chord of {chord}"
            )));
        }
        let usual = (2.0 * chord).max(radius * 4.0 / 15.0);
        let around = self.cylinder_radius.unwrap_or(usual);
        if !(around >= 1.25 * chord && around < 1e6) {
            return Err(Error::input(format!(
                "--cylinder-radius is at least 1.25 chords ({}), found {around}",
                1.25 * chord
            )));
        }
        Ok(Geometry {
            chord,
            root,
            radius,
            twist: twist.to_radians(),
            cylinder: Cylinder {
                radius: around,
                ends: [root - around.min(0.75 * root), radius + around],
            },
        })
    }
}

impl Geometry {
    /// A point and a normal of the straight blade, turned about the span by the twist there.
    pub fn twisted(&self, [x, y, z]: Vector, normal: Vector) -> (Vector, Vector) {
        let rate = self.twist / self.radius;
        let (sin, cos) = (rate * (x - 0.75 * self.radius)).sin_cos();
        let turn = |[y, z]: [f64; 2]| [cos * y - sin * z, sin * y + cos * z];
        let [ty, tz] = turn([y, z]);
        let [ny, nz] = turn([normal[1], normal[2]]);
        // The surface shears along the span, so the normal leans: inverse transpose of the map.
        let nx = normal[0] - rate * (ty * nz - tz * ny);
        let normal = unit([nx, ny, nz]).unwrap_or([0.0, 1.0, 0.0]);
        ([x, ty, tz], normal)
    }
}
