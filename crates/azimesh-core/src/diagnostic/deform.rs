//! Notes of `deform`: values that it chose, and errors that base points leave.

use super::notes::notes;
use super::{in_digits, named_step, point, short};
use crate::error::{counted, option};
use std::fmt;

notes! {
/// What the user should know of a deformation.
DeformNote as Deform {
    /// The support radius that was chosen.
    SupportRadius {
        /// In mesh units.
        radius: f64,
    } => ("support_radius = {} (chosen)", short(*radius))

    /// Where zones turn, both sides of their interface are boundaries.
    Interface {
        /// The tags of these, each with the number of its faces.
        tags: Vec<String>,
    } => (
        "{}",
        match tags.is_empty() {
            true => format!(
                "the interface of the turning zones has no tags, since their cells are curved (convert {} makes them linear)",
                option("linearize")
            ),
            false => format!("the interface of the turning zones has the tags {}", tags.join(", ")),
        }
    )

    /// The tolerance that was chosen.
    Tolerance {
        /// In mesh units.
        tolerance: f64,
    } => ("selection.tolerance = {} (chosen)", short(*tolerance))

    /// A body turns in a ring without other surfaces.
    TurnsInRing {
        /// Its name.
        body: String,
        /// The radii of the body and of the ring, in mesh units.
        radii: [f64; 2],
    } => (
        "body \"{body}\" turns about one axis with no other surface between the radii {} and {}: its rotation falls with \
         the logarithm of the radius",
        in_digits(radii[0], 3), in_digits(radii[1], 3)
    )

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

    /// Method `all` has left surface nodes out.
    NotAll {
        /// How many it takes.
        base_points: usize,
        /// Of how many.
        surface: usize,
        /// Name of the kernel.
        kernel: &'static str,
        /// Support radius, in mesh units.
        radius: f64,
        /// What is left at the surface before the correction, in mesh units.
        error: f64,
    } => (
        "method = \"all\" takes {base_points} of {surface} surface nodes: with {kernel} and a support radius of {} double \
         precision cannot tell the others from them; they are reproduced within {error:.1e} before the correction",
        short(*radius)
    )

    /// Large weights cancel, and what round-off leaves changes first cells.
    RoundOff {
        /// How large it is, in mesh units.
        noise: f64,
        /// The smallest first cell, in mesh units.
        first_cell: f64,
        /// Name of the kernel.
        kernel: &'static str,
        /// Support radius, in mesh units.
        radius: f64,
        /// A smaller support radius that was tried, and the round-off with it.
        works: Option<(f64, f64)>,
    } => (
        "round-off moves nodes by about {noise:.1e}, which is {} of the smallest first cell {}: the weights of {kernel} \
         with a support radius of {} are large and cancel; {}",
        percent(noise / first_cell), in_digits(*first_cell, 3), short(*radius), less_round_off(works, *first_cell)
    )

    /// Base points that were added for the velocities of a body at rest leave too large an error.
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
        /// Inverted and unproven cells before.
        before: (usize, usize),
        /// The part that the step takes of the repair of steps near it, where it is repaired with these.
        weight: Option<f64>,
        /// Substeps of the result; none where they did not help.
        substeps: Option<usize>,
        /// Their kernel, where it is not that of the schedule.
        kernel: Option<String>,
        /// Inverted cells with them.
        after: usize,
        /// Patches that were untangled then; none where that was not asked for.
        patches: Option<usize>,
        /// Inverted and unproven cells after all.
        left: usize,
    } => (
        "{} {}",
        named_step(*step, *azimuth_deg, *time_s), repaired(*before, *weight, &[outcome(*substeps, kernel.as_deref(), *after, *patches), untangled(*patches, *left)])
    )
}}

fn percent(part: f64) -> String {
    format!("{}%", in_digits(100.0 * part, 2))
}

fn less_round_off(works: &Option<(f64, f64)>, first_cell: f64) -> String {
    match works {
        Some((radius, noise)) => format!(
            "the same base points with `support_radius` = {} make it {}",
            in_digits(*radius, 3),
            percent(noise / first_cell)
        ),
        None => "no smaller support radius was found that would help; a kernel of lower order may"
            .to_owned(),
    }
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

/// What a step had, and what was done about it.
fn repaired((inverted, unproven): (usize, usize), weight: Option<f64>, done: &[String]) -> String {
    if let Some(weight) = weight.filter(|_| inverted + unproven == 0) {
        let percent = (100.0 * weight).round();
        return format!("takes {percent}% of the repair of folded steps near it");
    }
    let cells = match (inverted, unproven) {
        (0, n) if n > 0 => counted(n, "unproven cell"),
        (n, _) => counted(n, "inverted cell"),
    };
    let done: Vec<&str> = done
        .iter()
        .map(String::as_str)
        .filter(|what| !what.is_empty())
        .collect();
    format!("had {cells}: {}", done.join("; "))
}

/// What substeps have done about inverted cells.
fn outcome(
    substeps: Option<usize>,
    kernel: Option<&str>,
    after: usize,
    patches: Option<usize>,
) -> String {
    let with = kernel.map_or_else(String::new, |kernel| format!(" with the kernel {kernel}"));
    match (substeps, after) {
        (None, _) if patches.is_some_and(|n| n > 0) => String::new(),
        (None, _) => "substeps do not reduce them".to_owned(),
        (Some(n), 0) => format!("{n} substeps{with} leave none"),
        (Some(n), after) => format!("{n} substeps{with} leave {after}"),
    }
}

/// What untangling has done after that.
fn untangled(patches: Option<usize>, left: usize) -> String {
    let moved = match patches {
        None | Some(0) => return String::new(),
        Some(1) => "1 patch moved".to_owned(),
        Some(n) => format!("{n} patches moved"),
    };
    match left {
        0 => format!("{moved}, and none is left"),
        left => format!("{moved}, and {left} are left"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn substeps_are_told_with_what_they_leave() {
        let told = |azimuth_deg, substeps, kernel: Option<&str>, after| {
            let note = DeformNote::Substeps {
                step: 1,
                azimuth_deg,
                time_s: Some(0.5),
                before: (43, 0),
                weight: None,
                substeps,
                kernel: kernel.map(str::to_owned),
                after,
                patches: None,
                left: after,
            };
            note.to_string()
        };
        let start = "step 1 (azimuth 120 degrees) had 43 inverted cells: ";
        let by_azimuth = |substeps, after| told(Some(120.0), substeps, None, after);
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
            told(None, Some(4), None, 0),
            "step 1 (0.5 s) had 43 inverted cells: 4 substeps leave none"
        );
        assert_eq!(
            told(None, Some(8), Some("wendland-c0"), 3),
            "step 1 (0.5 s) had 43 inverted cells: 8 substeps with the kernel wendland-c0 leave 3"
        );
    }
}
