//! The section of the samples: NACA 0012 of chord one, its trailing edge rounded.
//!
//! Half thickness `t(s) = 0.6 (0.2969 sqrt s - 0.1260 s - 0.3516 s^2 + 0.2843 s^3 - 0.1015 s^4)`,
//! `s` the distance from the leading edge (Abbott and von Doenhoff). It ends 0.252% of the chord
//! thick; a half circle tangent to both sides closes it at `s = 1`. A sharp edge would leave an
//! O-grid two cells with corners of 172 degrees.

/// Radius of the leading edge.
pub const NOSE_RADIUS: f64 = 1.1019 * 0.12 * 0.12;

/// Intervals of the table of arc length, on either part of the curve.
const TABLE: usize = 4000;

/// The upper half of the section as a curve from leading to trailing edge.
///
/// The parameter runs over `0..=2`: `s = joint v^2` up to the joint at one, the angle of the
/// trailing edge's circle beyond.
#[derive(Debug, Clone)]
pub struct Section {
    joint: f64,
    centre: f64,
    radius: f64,
    joint_angle: f64,
    thickest: f64,
    /// Arc length at equal steps of the parameter.
    arc: Vec<f64>,
}

/// A point of the upper half and the outward normal there, as (chordwise, thicknesswise).
#[derive(Debug, Clone, Copy)]
pub struct SectionPoint {
    /// Distance from the leading edge and half thickness.
    pub at: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
}

/// Half of the section on either side of its largest thickness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Half {
    /// From the leading edge to the largest thickness.
    Front,
    /// From the largest thickness to the trailing edge.
    Rear,
}

impl Section {
    /// The section with its tables.
    pub fn new() -> Self {
        // Circle through (s, t) tangent to the curve there, centred on the chord line.
        let circle = |s: f64| {
            let (t, slope) = (half_thickness(s), half_thickness_slope(s));
            (s + t * slope, t * slope.hypot(1.0))
        };
        let joint = bisect(0.99, 1.0, |s| circle(s).0 + circle(s).1 > 1.0);
        let (centre, radius) = circle(joint);
        let thickest = bisect(0.2, 0.4, |s| half_thickness_slope(s) < 0.0);
        let mut section = Self {
            joint,
            centre,
            radius,
            joint_angle: half_thickness(joint).atan2(joint - centre),
            thickest: (thickest / joint).sqrt(),
            arc: vec![0.0],
        };
        let mut length = 0.0;
        let mut last = [0.0; 2];
        for i in 1..=2 * TABLE {
            let at = section.point(i as f64 / TABLE as f64).at;
            length += (at[0] - last[0]).hypot(at[1] - last[1]);
            section.arc.push(length);
            last = at;
        }
        section
    }

    /// Radius of the trailing edge.
    pub fn trailing_radius(&self) -> f64 {
        self.radius
    }

    /// The parameter of the largest half thickness.
    pub fn thickest(&self) -> f64 {
        self.thickest
    }

    /// Largest half thickness.
    pub fn largest(&self) -> f64 {
        self.point(self.thickest).at[1]
    }

    /// Arc length from leading to trailing edge.
    pub fn length(&self) -> f64 {
        self.arc[2 * TABLE]
    }

    /// The point at a parameter.
    pub fn point(&self, parameter: f64) -> SectionPoint {
        if parameter >= 1.0 {
            let angle = (2.0 - parameter).max(0.0) * self.joint_angle;
            let (sin, cos) = angle.sin_cos();
            return SectionPoint {
                at: [self.centre + self.radius * cos, self.radius * sin],
                normal: [cos, sin],
            };
        }
        let s = self.joint * parameter * parameter;
        // d(s, t) / d(parameter), free of the root that makes the slope infinite at the nose.
        let ds = 2.0 * self.joint * parameter;
        let dt = 0.6 * 0.2969 * self.joint.sqrt() + smooth_slope(s) * ds;
        let length = ds.hypot(dt);
        SectionPoint {
            at: [s, half_thickness(s)],
            normal: [-dt / length, ds / length],
        }
    }

    /// The parameter at an arc length from the leading edge.
    pub fn parameter_at_arc(&self, arc: f64) -> f64 {
        let after = self.arc.partition_point(|&length| length <= arc);
        let i = after.clamp(1, 2 * TABLE) - 1;
        let part = (arc - self.arc[i]) / (self.arc[i + 1] - self.arc[i]);
        ((i as f64 + part) / TABLE as f64).clamp(0.0, 2.0)
    }

    /// The parameter at which one half of the section has this half thickness.
    pub fn parameter_at_thickness(&self, half: Half, thickness: f64) -> f64 {
        let reached = |parameter: f64| self.point(parameter).at[1] >= thickness;
        match half {
            Half::Front => bisect(0.0, self.thickest, reached),
            Half::Rear => bisect(self.thickest, 2.0, |parameter| !reached(parameter)),
        }
    }
}

/// Half thickness at a distance `s` from the leading edge, before the rounding.
fn half_thickness(s: f64) -> f64 {
    0.6 * (0.2969 * s.sqrt() + s * (-0.1260 + s * (-0.3516 + s * (0.2843 - s * 0.1015))))
}

/// Its derivative.
fn half_thickness_slope(s: f64) -> f64 {
    0.6 * 0.5 * 0.2969 / s.sqrt() + smooth_slope(s)
}

/// The derivative without the term of the root.
fn smooth_slope(s: f64) -> f64 {
    0.6 * (-0.1260 + s * (-2.0 * 0.3516 + s * (3.0 * 0.2843 - s * 4.0 * 0.1015)))
}

/// Finds the value between `low` and `high` at which `beyond` becomes true.
fn bisect(mut low: f64, mut high: f64, beyond: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *if beyond(middle) { &mut high } else { &mut low } = middle;
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_section_is_12_percent_thick_and_one_long() {
        let section = Section::new();
        assert!((section.largest() - 0.06).abs() < 2e-5);
        let end = section.point(2.0);
        assert!((end.at[0] - 1.0).abs() < 1e-12 && end.at[1] == 0.0);
        assert_eq!(section.point(0.0).normal, [-1.0, 0.0]);
    }

    #[test]
    fn the_rounded_edge_is_tangent_to_the_sides() {
        let section = Section::new();
        let (before, after) = (section.point(1.0 - 1e-9), section.point(1.0 + 1e-9));
        for i in 0..2 {
            assert!((before.at[i] - after.at[i]).abs() < 1e-8);
            assert!((before.normal[i] - after.normal[i]).abs() < 1e-6);
        }
    }

    #[test]
    fn thickness_and_arc_length_find_their_parameters() {
        let section = Section::new();
        for (half, thickness) in [(Half::Front, 0.01), (Half::Rear, 0.001)] {
            let parameter = section.parameter_at_thickness(half, thickness);
            assert!((section.point(parameter).at[1] - thickness).abs() < 1e-12);
        }
        let parameter = section.parameter_at_arc(0.5 * section.length());
        assert!((section.point(parameter).at[0] - 0.5).abs() < 0.03);
    }
}
