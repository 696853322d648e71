//! Notes of `deform`: what it chose where the schedule says nothing, and what base points leave.

use std::fmt;

/// What the user should know of a deformation.
#[derive(Debug, Clone, PartialEq)]
pub enum DeformNote {
    /// The support radius that was chosen.
    SupportRadius {
        /// In mesh units.
        radius: f64,
    },
    /// The tolerance that was chosen.
    Tolerance {
        /// In mesh units.
        tolerance: f64,
    },
    /// A key of the selection that method `all` does not use.
    UnusedKey {
        /// The key.
        key: &'static str,
    },
    /// Two steps of one time.
    OneTime {
        /// The steps.
        steps: [usize; 2],
        /// Their time.
        time: f64,
    },
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
    },
    /// Two surfaces are so near each other that the correction fades out early.
    NarrowGap {
        /// How near, in mesh units.
        width: f64,
        /// A node there.
        node: u32,
        /// Tolerances that a gap should be wide at least.
        tolerances: f64,
        /// What the correction would fade out over elsewhere.
        reach: f64,
    },
    /// Base points do not serve the velocities.
    Velocities {
        /// How many there are.
        base_points: usize,
        /// Velocities that they leave at the surface.
        error: f64,
        /// The largest velocity of the surface.
        speed: f64,
    },
    /// A step misses the tolerance that its base points were chosen by.
    Misses {
        /// The step.
        step: usize,
        /// What the base points leave, in mesh units.
        error: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// A step with inverted cells was taken again in substeps.
    Substeps {
        /// The step.
        step: usize,
        /// Its azimuth in degrees.
        azimuth_deg: f64,
        /// Inverted cells before.
        before: usize,
        /// Substeps that were taken at last; none where they did not help.
        substeps: Option<usize>,
        /// Inverted cells with them.
        after: usize,
    },
}

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

impl fmt::Display for DeformNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SupportRadius { radius } => write!(f, "support_radius = {radius} (chosen)"),
            Self::Tolerance { tolerance } => {
                write!(f, "selection.tolerance = {tolerance} (chosen)")
            }
            Self::UnusedKey { key } => write!(
                f,
                "selection.{key} is not used: method = \"all\" takes every surface node"
            ),
            Self::OneTime { steps, time } => write!(
                f,
                "steps {} and {} have one time, {time}; ParaView does not tell them apart",
                steps[0], steps[1]
            ),
            Self::PeriodicPair {
                sides: [a, b],
                pairs,
                map,
                distance,
            } => write!(
                f,
                "{a} and {b}: {pairs} pairs of nodes by {map}, {distance:.1e} apart at most"
            ),
            Self::NarrowGap {
                width,
                node,
                tolerances,
                reach,
            } => write!(
                f,
                "two surfaces are {width:.3e} apart at node {node}, which is under {tolerances} tolerances; the \
                 correction fades out over half of that instead of {reach:.3e}, so a smaller tolerance would serve the \
                 cells there"
            ),
            Self::Velocities {
                base_points,
                error,
                speed,
            } => write!(
                f,
                "{base_points} base points leave {error:.1e} of the velocities of the surface, which are up to \
                 {speed:.1e}, before the correction; those of the volume are as far off"
            ),
            Self::Misses {
                step,
                error,
                tolerance,
            } => write!(
                f,
                "step {step}: the base points leave {error:.3e}, more than the tolerance {tolerance}"
            ),
            Self::Substeps {
                step,
                azimuth_deg,
                before,
                substeps,
                after,
            } => {
                write!(
                    f,
                    "step {step} (azimuth {azimuth_deg} degrees) had {before} inverted cells: "
                )?;
                match (substeps, after) {
                    (None, _) => f.write_str("substeps leave no fewer"),
                    (Some(n), 0) => write!(f, "{n} substeps leave none"),
                    (Some(n), after) => write!(f, "{n} substeps leave {after}"),
                }
            }
        }
    }
}

impl fmt::Display for PeriodicMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation(by) => write!(f, "a translation by {by:?}"),
            Self::Rotation {
                angle_deg,
                direction,
                origin,
            } => write!(
                f,
                "a rotation of {angle_deg} degrees about {direction:?} through {origin:?}"
            ),
        }
    }
}
