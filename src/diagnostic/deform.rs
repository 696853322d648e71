//! Notes of `deform`: values that it chose, and errors that base points leave.

use super::notes::notes;
use super::{in_digits, named_step, point, short};
use crate::error::counted;
use std::fmt;

notes! {
/// What the user should know of a deformation.
DeformNote as Deform {
    /// The support radius that was chosen.
    SupportRadius {
        /// In mesh units.
        radius: f64,
    } => ("support_radius = {} (chosen)", short(*radius))

    /// The tolerance that was chosen.
    Tolerance {
        /// In mesh units.
        tolerance: f64,
    } => ("selection.tolerance = {} (chosen)", short(*tolerance))

    /// The format of the output that was chosen.
    OutputFormat {
        /// Its name.
        format: &'static str,
    } => ("output.format = \"{format}\" (chosen, since the mesh is of that format)")

    /// A key of the selection that method `all` does not use.
    UnusedKey {
        /// The key.
        key: &'static str,
    } => ("selection.{key} is not used: method = \"all\" takes every surface node")

    /// Two steps of one time.
    OneTime {
        /// The steps.
        steps: [usize; 2],
        /// Their time.
        time: f64,
    } => ("steps {} and {} have the same time, {}; ParaView cannot tell them apart", steps[0], steps[1], short(*time))

    /// The nodes of a periodic pair of sides.
    PeriodicPair {
        /// The tags of both sides.
        sides: [String; 2],
        /// Number of pairs of nodes.
        pairs: usize,
        /// What takes one side to the other.
        map: PeriodicMap,
        /// How far the nodes of a pair are apart at most after that, in mesh units.
        distance: f64,
    } => ("{} and {}: {pairs} pairs of nodes by {map}, which match within {distance:.1e}", sides[0], sides[1])

    /// Two surfaces are so near each other that the correction fades out early.
    NarrowGap {
        /// How near, in mesh units.
        width: f64,
        /// A node there.
        node: u32,
        /// Tolerances that a gap should be wide at least.
        tolerances: f64,
        /// What the correction would fade out over elsewhere.
        fade_radius: f64,
    } => (
        "two surfaces are {} apart at node {node}, less than {} times the tolerance; the correction \
         fades out over half of that instead of {}, and a smaller tolerance would give better \
         cells there",
        in_digits(*width, 3), short(*tolerances), in_digits(*fade_radius, 3)
    )

    /// Base points leave too large an error in the velocities.
    Velocities {
        /// How many there are.
        base_points: usize,
        /// Velocities that they leave at the surface.
        error: f64,
        /// The largest velocity of the surface.
        speed: f64,
    } => (
        "{base_points} base points leave an error of {error:.1e} in the velocities of the surface, which are up \
         to {}; the surface is corrected, but velocities in the volume have errors of that size",
        in_digits(*speed, 3)
    )

    /// A step misses the tolerance that its base points were chosen by.
    Misses {
        /// The step.
        step: usize,
        /// What the base points leave, in mesh units.
        error: f64,
        /// The tolerance.
        tolerance: f64,
    } => ("step {step}: the base points leave an error of {error:.3e}, more than the tolerance {}", short(*tolerance))

    /// A step with inverted cells was repeated in substeps.
    Substeps {
        /// The step.
        step: usize,
        /// Its azimuth in degrees; `None` where the schedule has times alone.
        azimuth_deg: Option<f64>,
        /// Its time in seconds, where it is known.
        time_s: Option<f64>,
        /// Inverted cells before.
        before: usize,
        /// Substeps of the result; none where they did not help.
        substeps: Option<usize>,
        /// Inverted cells with them.
        after: usize,
        /// Patches that were untangled then; none where that was not asked for.
        patches: Option<usize>,
        /// Inverted and unproven cells after all.
        left: usize,
    } => (
        "{} had {}{}",
        named_step(*step, *azimuth_deg, *time_s), outcome(*before, *substeps, *after), untangled(*patches, *left)
    )
}}

/// What takes one side of a periodic pair to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PeriodicMap {
    /// A translation.
    Translation([f64; 3]),
    /// A rotation.
    Rotation {
        /// Angle in degrees.
        angle_deg: f64,
        /// Direction of the axis.
        direction: [f64; 3],
        /// A point of it.
        origin: [f64; 3],
    },
}

impl fmt::Display for PeriodicMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation(by) => write!(f, "a translation by {}", point(by)),
            Self::Rotation {
                angle_deg,
                direction,
                origin,
            } => write!(
                f,
                "a rotation by {} degrees about the direction {} through {}",
                short(*angle_deg),
                point(direction),
                point(origin)
            ),
        }
    }
}

/// What substeps have done about inverted cells.
fn outcome(before: usize, substeps: Option<usize>, after: usize) -> String {
    let had = counted(before, "inverted cell");
    match (before, substeps, after) {
        (0, ..) => "no inverted cell, but cells that are not proven valid".to_owned(),
        (_, None, _) => format!("{had}: substeps do not reduce them"),
        (_, Some(n), 0) => format!("{had}: {n} substeps leave none"),
        (_, Some(n), after) => format!("{had}: {n} substeps leave {after}"),
    }
}

/// What untangling has done after that.
fn untangled(patches: Option<usize>, left: usize) -> String {
    let Some(patches) = patches else {
        return String::new();
    };
    let patches = match patches {
        1 => "1 patch".to_owned(),
        n => format!("{n} patches"),
    };
    match left {
        0 => format!("; {patches} moved, and none is left"),
        left => format!("; {patches} moved, and {left} are left"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn substeps_are_told_with_what_they_leave() {
        let told = |azimuth_deg, substeps, after| {
            let note = DeformNote::Substeps {
                step: 1,
                azimuth_deg,
                time_s: Some(0.5),
                before: 43,
                substeps,
                after,
                patches: None,
                left: after,
            };
            note.to_string()
        };
        let start = "step 1 (azimuth 120 degrees) had 43 inverted cells: ";
        let by_azimuth = |substeps, after| told(Some(120.0), substeps, after);
        assert_eq!(
            by_azimuth(None, 43),
            format!("{start}substeps do not reduce them")
        );
        assert_eq!(
            by_azimuth(Some(4), 0),
            format!("{start}4 substeps leave none")
        );
        assert_eq!(by_azimuth(Some(8), 2), format!("{start}8 substeps leave 2"));
        assert_eq!(
            told(None, Some(4), 0),
            "step 1 (0.5 s) had 43 inverted cells: 4 substeps leave none"
        );
    }
}
