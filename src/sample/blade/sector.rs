//! A sector of a rotor: the region around one of several blades.

use super::geometry::Geometry;
use super::tube::{End, Place, Tube};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::f64::consts::PI;

/// Numbers of blades whose sectors are neither too wide nor too narrow for rays from the blade.
const LEAST_BLADES: usize = 3;
const MOST_BLADES: usize = 5;

/// Radius of the hub, in that where the blades begin: a smaller one leaves cells at their roots no space
/// next to the cells of the next blade.
const HUB: f64 = 0.75;

/// Positions of the patch's corners on the hub and on the outer boundary, in half widths.
const PATCH_CORNER: f64 = 0.55;

/// Between two planes through the shaft, two across it, the hub and the outer boundary.
#[derive(Debug, Clone, Copy)]
pub struct Sector {
    /// Angle from the blade to either plane, in radians.
    pub half_angle: f64,
    half_height: f64,
    /// Of the hub and of the outer boundary.
    radii: [f64; 2],
}

impl Sector {
    /// The sector of one of `n_blades` blades: as high as the cylinder around a single one, and as
    /// far out.
    pub fn new(geometry: &Geometry, n_blades: usize) -> Result<Self> {
        if !(LEAST_BLADES..=MOST_BLADES).contains(&n_blades) {
            return Err(Error::input(format!(
                "--blades is a number from {LEAST_BLADES} to {MOST_BLADES}, found {n_blades}; left out, there is one blade in a \
                 cylinder"
            )));
        }
        let half_angle = PI / n_blades as f64;
        let [chord, root] = [geometry.chord, geometry.root];
        // The trailing edge at the root, with half as much again to the next sector.
        if (0.75 * chord).atan2(root) * 1.5 > half_angle {
            return Err(Error::input(format!(
                "{n_blades} blades with a chord of {chord} do not fit around a hub when they begin at {root}; give a \
                 larger --root or a smaller --chord"
            )));
        }
        Ok(Self {
            half_angle,
            half_height: geometry.cylinder.radius,
            radii: [HUB * root, geometry.cylinder.ends[1]],
        })
    }

    /// The node of the sector's boundary opposite to the blade's node at `place`; `part` is how far
    /// out it is, 0 at the hub to 1, where that is not given by the place.
    pub fn node(&self, tube: &Tube, place: Place, part: impl Fn(usize) -> f64) -> Vector {
        let scaled = |[u, v]: [f64; 2], by: f64| [by * u, by * v];
        let (part, [across, up]) = match place {
            Place::Wrap(around, along) => (part(along), rim(tube, around)),
            Place::Ring(end, around, inward) => {
                let by = 1.0 - inward * (1.0 - PATCH_CORNER);
                (end.part(), scaled(rim(tube, around), by))
            }
            Place::Patch(end, i, j) => {
                let at = |index: usize, n: usize| 1.0 - 2.0 * index as f64 / n as f64;
                let inside = [at(i, tube.side), at(j, tube.band)];
                (end.part(), scaled(inside, PATCH_CORNER))
            }
        };
        let r = self.radii[0] + part * (self.radii[1] - self.radii[0]);
        let (sin, cos) = (across * self.half_angle).sin_cos();
        [r * cos, r * sin, up * self.half_height]
    }
}

/// The tag of the face of a sector's boundary on a quadrilateral of the tube; `None` on the plane between two sectors.
/// The outer boundary is above, below and outside.
pub fn boundary_of(tube: &Tube, quad: usize) -> Option<&'static str> {
    match tube.end_of(quad) {
        Some(End::Root) => Some("hub"),
        None if tube.is_in_band(quad % tube.n_loop()) => None,
        Some(End::Tip) | None => Some("outer"),
    }
}

/// A loop's node on the square across the sector: forward and up, -1 to 1. The bands are on the
/// sides, where neighbours meet.
fn rim(tube: &Tube, around: usize) -> [f64; 2] {
    let (i, side) = tube.folded(around);
    let ring = tube.band / 2;
    let in_band = |from_middle: usize| from_middle as f64 / ring as f64;
    if i < ring {
        [1.0, side * in_band(i)]
    } else if i > ring + tube.side {
        [-1.0, side * in_band(tube.n_loop() / 2 - i)]
    } else {
        [1.0 - 2.0 * (i - ring) as f64 / tube.side as f64, side]
    }
}
