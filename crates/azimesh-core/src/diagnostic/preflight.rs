//! Notes of `preflight`: what a motion does on its mesh, and what a format or a disk cannot hold.

use super::notes::notes;
use super::{amount, in_digits, point, short, with_verb};
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

    /// Nodes of a fixed tag move, since they are on a body as well.
    FixedMoves {
        /// The fixed tag.
        tag: String,
        /// How many of its nodes move, and how many it has.
        nodes: [usize; 2],
        /// How many of its faces move with all of their nodes, and how many it has.
        faces: [usize; 2],
        /// How many of its faces are on tags of the body as well.
        shared: usize,
        /// Name of the body.
        body: String,
        /// How far they move at most, in mesh units.
        distance: f64,
        /// The step of that.
        step: usize,
        /// Whether the tag lies in a plane that they do not leave.
        may_slide: bool,
    } => (
        "{} of tag \"{tag}\", which is fixed, {} with body \"{body}\", by up to {} (step {step}), since they are on its tags \
         too{}{}",
        of(nodes, "node"), if nodes[0] == 1 { "moves" } else { "move" }, in_digits(*distance, 3),
        moving_faces(faces, *shared), fixed_remedy(*may_slide, faces)
    )

    /// Faces of a moving tag bound no cell.
    FacesOnNoCell {
        /// The tag.
        tag: String,
        /// How many of its faces, and how many it has.
        faces: [usize; 2],
        /// The first of them.
        first: u32,
    } => (
        "{} of tag \"{tag}\", which moves, {} on no cell, the first is cell {first}: they move, and no cell of the mesh \
         follows them", of(faces, "face"), if faces[0] == 1 { "is" } else { "are" }
    )

    /// The support radius is small against the motion.
    SmallRadius {
        /// Support radius, in mesh units.
        radius: f64,
        /// Name of the kernel.
        kernel: &'static str,
        /// Name of the body that goes farthest.
        body: String,
        /// How far it goes in one go, in mesh units.
        distance: f64,
        /// The step of that.
        step: usize,
        /// Substeps of each step.
        substeps: usize,
        /// A support radius and a number of substeps of which each would be enough.
        needed: (f64, usize),
    } => (
        "body \"{body}\" moves by up to {}{} (step {step}), which has to fade out within the support radius {}: with {kernel} \
         that has to be about {} times the distance, or cells fold; set rbf.support_radius = {} or more, where the mesh has that room, or \
         rbf.substeps = {}",
        in_digits(*distance, 3), if *substeps > 1 { " in one substep" } else { "" }, short(*radius),
        in_digits(needed.0 / distance, 2), in_digits(needed.0, 3), needed.1
    )

    /// Velocities are asked for, and nothing moves.
    NoVelocity => ("output.velocity is set, but the velocities of all bodies are 0 at every step")

    /// A body with the motion of one blade lies all round the hub.
    SeveralBlades {
        /// Its name.
        body: String,
        /// Its least and its largest station.
        stations: [f64; 2],
        /// How far it reaches beside the span.
        beside: f64,
    } => (
        "body \"{body}\" pitches and flaps about the span of one blade, but lies all round the hub (stations {} to {}, up to {} beside \
         the span); several blades are several bodies, each with its azimuth_offset",
        short(stations[0]), short(stations[1]), short(*beside)
    )

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

/// `3 of the 40 nodes`.
fn of([some, all]: &[usize; 2], what: &str) -> String {
    format!("{some} of the {}", counted(*all, what))
}

fn moving_faces(faces: &[usize; 2], shared: usize) -> String {
    match (faces, shared) {
        ([0, _], _) => String::new(),
        (faces, 0) => format!("; {} move as a whole", of(faces, "face")),
        (faces, shared) => format!(
            "; {} move as a whole, and {} on tags of the body too",
            of(faces, "face"),
            with_verb(shared, "face", "is")
        ),
    }
}

fn fixed_remedy(may_slide: bool, [moving, all]: &[usize; 2]) -> &'static str {
    match (may_slide, 2 * moving > *all) {
        (_, true) => {
            "; most of this tag is not fixed: give it to the body, or take its faces out of the tags of the body"
        }
        (true, _) => "; they stay in the plane of that tag, which could be in `slide`",
        _ => "",
    }
}

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
