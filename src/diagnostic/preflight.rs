//! Notes of `preflight`: what a motion does on its mesh, and what a format or a disk cannot hold.

use super::notes::notes;
use super::{amount, in_digits, point, with_verb};
use crate::error::counted;

notes! {
/// What is told before work starts.
PreflightNote as Preflight {
    /// Nodes of a body in a sliding plane are moved out of it.
    LeavesPlane {
        /// Name of the body.
        body: String,
        /// How many nodes.
        nodes: usize,
        /// How far at most, in mesh units.
        distance: f64,
        /// The step of that.
        step: usize,
    } => (
        "body \"{body}\" moves {} of a sliding plane out of it, by up to {} at step {step}; that boundary does not stay \
         plane",
        counted(*nodes, "node"), in_digits(*distance, 4)
    )

    /// A body moves at no step.
    BodyStays {
        /// Its name.
        body: String,
    } => ("body \"{body}\" does not move at any step of the schedule")

    /// The interface of the turning zones is no surface of revolution.
    TurnsOut {
        /// The step at which its nodes are farthest off.
        step: usize,
        /// How far, in mesh units.
        distance: f64,
    } => (
        "the interface between the rotating zones and the rest of the mesh is not a surface of revolution about the \
         shaft: at step {step} its nodes are up to {} away from it, so cells overlap there or leave gaps",
        in_digits(*distance, 4)
    )

    /// Velocities are asked for, and nothing moves.
    NoVelocity => ("output.velocity is set, but the velocities of all bodies are 0 at every step")

    /// A body leaves the box around the mesh.
    LeavesBox {
        /// Its name.
        body: String,
        /// At how many steps.
        steps: usize,
        /// Of how many.
        looked_at: usize,
        /// The first of them.
        first: usize,
    } => (
        "body \"{body}\" leaves the bounding box of the mesh at {steps} of the {} checked, first at step {first}",
        counted(*looked_at, "step")
    )

    /// Two surfaces cut through each other.
    SurfacesMeet {
        /// Their bodies; none for a fixed boundary.
        bodies: [Option<String>; 2],
        /// At how many steps.
        steps: usize,
        /// Of how many.
        looked_at: usize,
        /// The first of them.
        first: usize,
        /// A point near there.
        place: [f64; 3],
    } => (
        "the surfaces of {} and {} intersect at {steps} of the {} checked, first at step {first}, near {}",
        owner(&bodies[0]), owner(&bodies[1]), counted(*looked_at, "step"), point(place)
    )

    /// The surfaces are moved at step 0, and a solver begins with the mesh.
    BeginsMoved {
        /// How far at most, in mesh units.
        distance: f64,
    } => (
        "output.surface = \"su2\": step 0 has moved the surfaces by up to {}; SU2 begins with its mesh as it is, so that its \
         first iteration moves them by that within one TIME_STEP", in_digits(*distance, 4)
    )

    /// An option of the output that its format does not know.
    NoEffect {
        /// Key of the schedule, in `output`.
        key: &'static str,
        /// Name of the format.
        format: &'static str,
    } => ("output.{key} has no effect on files of format = \"{format}\"")

    /// Arrays are asked for that the format does not hold.
    NoArrays {
        /// Name of the format.
        format: &'static str,
        /// The arrays, one at least.
        arrays: Vec<&'static str>,
    } => (
        "output.format = \"{format}\" holds no arrays: {} left out", listed(arrays)
    )

    /// A disk that has room for the steps only if they are compressed well.
    LittleRoom {
        /// Steps that are to be written.
        steps: usize,
        /// Bytes of all of them, without compression.
        needed: u64,
        /// Bytes of each.
        each: u64,
        /// Bytes that are free.
        free: u64,
    } => (
        "without compression {} {} ({} each), and {} are free",
        with_verb(*steps, "step", "takes"), amount(*needed), amount(*each), amount(*free)
    )
}}

fn owner(body: &Option<String>) -> String {
    let named = |name: &String| format!("body \"{name}\"");
    body.as_ref().map_or("a fixed boundary".to_owned(), named)
}

/// Names as a subject with its verb: `a is`, `a, b and c are`.
fn listed(names: &[&str]) -> String {
    match names {
        [first @ .., last] if !first.is_empty() => format!("{} and {last} are", first.join(", ")),
        names => format!("{} is", names.concat()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_that_are_left_out_are_named() {
        let told = |arrays: &[&'static str]| {
            let note = PreflightNote::NoArrays {
                format: "su2",
                arrays: arrays.to_vec(),
            };
            note.to_string()
        };
        let start = "output.format = \"su2\" holds no arrays: ";
        assert_eq!(told(&["velocity"]), format!("{start}velocity is left out"));
        let three = told(&["displacement", "velocity", "cell quality"]);
        let wanted = "displacement, velocity and cell quality are left out";
        assert_eq!(three, format!("{start}{wanted}"));
    }
}
