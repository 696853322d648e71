//! The blade's surface and the cylinder around it, node by node.
//!
//! Blade frame: span +x, leading edge +y, shaft +z, pitch axis at the quarter chord on the x axis.
//! Both ends of the blade are half bodies of revolution about the chord line: at every chordwise
//! station a half circle joins the upper to the lower side, so the surface is smooth all over.
//!
//! On an end, seen along the chord, a point has coordinates (outward, up) = (X, Z) in chords. Its distance `r` from the
//! chord line is the half thickness of its station. Far from the edges the nodes of one chordwise station are on a circle
//! `r = t`. Towards the leading and trailing band the circles become squares, so that the patch's corners have angles of 90
//! and 135 degrees.

use super::geometry::Geometry;
use super::sector::Sector;
use super::tube::{End, Place, Tube};
use crate::sample::airfoil::{Half, NOSE_RADIUS, Section};
use crate::sample::spacing::{LineEnd, graded_from_ends};
use azimesh_core::geometry::vector::Vector;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Half of the angle that the leading band takes on the cylinder.
const BAND_ANGLE: f64 = 0.66;

/// Half width of the bands on the blade, in radii of the leading and the trailing edge.
const BAND_REACH: f64 = 0.45;

/// Positions of the patch's corners on the cylinder's ends, in its radius.
const PATCH_CORNER: f64 = 0.55;

/// Positions of the nodes of a [`Tube`] on the blade and on the cylinder.
pub struct Shape<'a> {
    geometry: &'a Geometry,
    tube: Tube,
    section: Section,
    /// Parameter of each node of half a loop, from leading to trailing edge.
    parameters: Vec<f64>,
    /// Half thickness of each node of half a loop.
    thickness: Vec<f64>,
    /// Span of each node along the wrap, in mesh units.
    stations: Vec<f64>,
}

impl<'a> Shape<'a> {
    /// Distributes the nodes.
    pub fn new(geometry: &'a Geometry, tube: Tube) -> Self {
        let section = Section::new();
        let ring = (tube.band / 2) as f64;
        let half_loop = tube.side + tube.band;
        let end = |radius: f64, hold: f64| LineEnd {
            size: BAND_REACH * radius / ring,
            hold: hold * radius,
        };
        let ends = [end(NOSE_RADIUS, 0.45), end(section.trailing_radius(), 1.0)];
        let parameters: Vec<f64> = graded_from_ends(section.length(), half_loop, ends)
            .into_iter()
            .map(|arc| section.parameter_at_arc(arc))
            .collect();
        let thickness = parameters
            .iter()
            .map(|&parameter| section.point(parameter).at[1])
            .collect();
        // The ends' circles are cut into 2 band cells; the span starts with the same size.
        let cap = geometry.chord * section.largest();
        let size = PI * cap / (2 * tube.band) as f64;
        let length = geometry.radius - geometry.root - 2.0 * cap;
        let stations = graded_from_ends(length, tube.span, [LineEnd { size, hold: 0.0 }; 2])
            .into_iter()
            .map(|x| geometry.root + cap + x)
            .collect();
        Self {
            geometry,
            tube,
            section,
            parameters,
            thickness,
            stations,
        }
    }

    /// At a node of the tube: the point of the blade, its outward unit normal, and the point of the boundary of the
    /// sector, or of the cylinder, opposite to it.
    pub fn ends(&self, sector: Option<&Sector>, node: usize) -> [Vector; 3] {
        let place = self.tube.place(node);
        let (wall, normal) = self.blade(place);
        let outer = match sector {
            Some(sector) => sector.node(&self.tube, place, |along| self.part(along)),
            None => self.cylinder(place),
        };
        [wall, normal, outer]
    }

    /// The part of the way out of nodes opposite to the nodes of a loop, 0 to 1: between equal steps and the
    /// blade's own.
    fn part(&self, along: usize) -> f64 {
        let last = self.stations.len() - 1;
        let share = along as f64 / last as f64;
        let part =
            (self.stations[along] - self.stations[0]) / (self.stations[last] - self.stations[0]);
        0.5 * (share + part)
    }

    fn blade(&self, place: Place) -> (Vector, Vector) {
        match place {
            Place::Wrap(around, along) => {
                let (i, side) = self.tube.folded(around);
                self.placed(self.stations[along], 0.0, side, self.parameters[i])
            }
            Place::Ring(end, around, part) => {
                let (i, side) = self.tube.folded(around);
                let [x, z] = self.ring_point(i, part);
                self.on_end(end, [x, side * z], i)
            }
            Place::Patch(end, i, j) => {
                let i = i + self.tube.band / 2;
                self.on_end(end, self.patch_point(i, j), i)
            }
        }
    }

    /// The half of the section that node `i` of half a loop belongs to, the index of its band's
    /// last node, and how square its station is, 0 to 1.
    fn squareness(&self, i: usize) -> (Half, usize, f64) {
        let ring = self.tube.band / 2;
        let thickest = self.section.thickest();
        let (half, corner) = if self.parameters[i] <= thickest {
            (Half::Front, ring)
        } else {
            (Half::Rear, self.tube.side + ring)
        };
        let h = self.thickness[corner];
        // Not before the patch's corner, at 1.4 h, is well inside the last square.
        let last = match half {
            Half::Front => 3.0 * h,
            Half::Rear => 0.97 * self.section.trailing_radius(),
        };
        let last = last.min(0.95 * self.section.largest());
        let reach = (last / h - 1.0).max(1.0);
        let square = 1.0 - (self.thickness[i] / h - 1.0) / reach;
        (half, corner, square.clamp(0.0, 1.0))
    }

    /// (X, Z) of the upper node `i` on the ring, `part` of the way to the patch.
    fn ring_point(&self, i: usize, part: f64) -> [f64; 2] {
        let (_, corner, square) = self.squareness(i);
        let (t, h) = (self.thickness[i], self.thickness[corner]);
        let x = h * (FRAC_PI_4 * part).tan();
        let ring = self.tube.band / 2;
        if i < ring || i > ring + self.tube.side {
            return [x, t];
        }
        let (sin, cos) = (FRAC_PI_2 - FRAC_PI_4 * part).sin_cos();
        blend([t * cos, t * sin], [t / h * x, t], square)
    }

    /// (X, Z) of a node inside the patch, at node `i` of half a loop and `j` through the band.
    fn patch_point(&self, i: usize, j: usize) -> [f64; 2] {
        let (half, corner, square) = self.squareness(i);
        let (t, h) = (self.thickness[i], self.thickness[corner]);
        let ring = self.tube.band / 2;
        let from_middle = ring.abs_diff(j);
        let side = if j <= ring { 1.0 } else { -1.0 };
        let z = match half {
            Half::Front => self.thickness[from_middle],
            Half::Rear => self.thickness[self.tube.side + self.tube.band - from_middle],
        };
        let (sin, cos) = (FRAC_PI_4 - FRAC_PI_2 * j as f64 / self.tube.band as f64).sin_cos();
        blend([t * cos, t * sin], [t, t / h * side * z], square)
    }

    /// The point of an end at (X, Z); node `i` of half a loop gives the station where the circle
    /// is whole.
    fn on_end(&self, end: End, [x, z]: [f64; 2], i: usize) -> (Vector, Vector) {
        let r = x.hypot(z);
        let (half, _, square) = self.squareness(i);
        let parameter = if square > 0.0 {
            self.section.parameter_at_thickness(half, r)
        } else {
            self.parameters[i]
        };
        let last = self.stations.len() - 1;
        let (station, outward) = match end {
            End::Root => (self.stations[0], -1.0),
            End::Tip => (self.stations[last], 1.0),
        };
        self.placed(station, outward * x / r, z / r, parameter)
    }

    /// The point at a section's parameter, turned about the chord line to the direction (out, up)
    /// and put in its place on the twisted blade; and the normal there.
    fn placed(&self, station: f64, out: f64, up: f64, parameter: f64) -> (Vector, Vector) {
        let point = self.section.point(parameter);
        let chord = self.geometry.chord;
        let radial = chord * point.at[1];
        let straight = [
            station + radial * out,
            chord * (0.25 - point.at[0]),
            radial * up,
        ];
        let [along, across] = point.normal;
        let normal = [across * out, -along, across * up];
        self.geometry.twisted(straight, normal)
    }

    fn cylinder(&self, place: Place) -> Vector {
        let cylinder = &self.geometry.cylinder;
        match place {
            Place::Wrap(around, along) => {
                let part = self.part(along);
                let x = cylinder.ends[0] + part * (cylinder.ends[1] - cylinder.ends[0]);
                let [y, z] = self.rim(around);
                [x, y, z]
            }
            Place::Ring(end, around, part) => {
                let [y, z] = blend(self.rim(around), self.inner_rim(around), part);
                [self.end(end), y, z]
            }
            Place::Patch(end, i, j) => {
                let (sin, cos) = BAND_ANGLE.sin_cos();
                let corner = PATCH_CORNER * cylinder.radius;
                let part = |index: usize, n: usize| 1.0 - 2.0 * index as f64 / n as f64;
                let y = corner * cos * part(i, self.tube.side);
                let z = corner * sin * part(j, self.tube.band);
                [self.end(end), y, z]
            }
        }
    }

    fn end(&self, end: End) -> f64 {
        match end {
            End::Root => self.geometry.cylinder.ends[0],
            End::Tip => self.geometry.cylinder.ends[1],
        }
    }

    /// (y, z) of a loop's node on the cylinder.
    fn rim(&self, around: usize) -> [f64; 2] {
        let (i, side) = self.tube.folded(around);
        let ring = self.tube.band / 2;
        let in_band = |from_middle: usize| BAND_ANGLE * from_middle as f64 / ring as f64;
        let angle = if i < ring {
            in_band(i)
        } else if i > ring + self.tube.side {
            PI - in_band(self.tube.side + self.tube.band - i)
        } else {
            let part = (i - ring) as f64 / self.tube.side as f64;
            BAND_ANGLE + part * (PI - 2.0 * BAND_ANGLE)
        };
        let (sin, cos) = angle.sin_cos();
        let radius = self.geometry.cylinder.radius;
        [radius * cos, side * radius * sin]
    }

    /// (y, z) of a loop's node on the rim of the patch on the cylinder's end.
    fn inner_rim(&self, around: usize) -> [f64; 2] {
        let (i, side) = self.tube.folded(around);
        let ring = self.tube.band / 2;
        let (sin, cos) = BAND_ANGLE.sin_cos();
        let corner = PATCH_CORNER * self.geometry.cylinder.radius;
        let [a, b] = [corner * cos, corner * sin];
        if i < ring {
            [a, side * b * i as f64 / ring as f64]
        } else if i > ring + self.tube.side {
            let from_middle = self.tube.side + self.tube.band - i;
            [-a, side * b * from_middle as f64 / ring as f64]
        } else {
            let part = (i - ring) as f64 / self.tube.side as f64;
            [a * (1.0 - 2.0 * part), side * b]
        }
    }
}

/// `a` for weight zero, `b` for weight one.
fn blend(a: [f64; 2], b: [f64; 2], weight: f64) -> [f64; 2] {
    [0, 1].map(|i| (1.0 - weight) * a[i] + weight * b[i])
}
