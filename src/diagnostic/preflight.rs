//! Notes of `preflight`: what a motion does on its mesh, and what a format or a disk cannot hold.

use super::notes::notes;

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
        "{nodes} nodes of body \"{body}\" lie in a plane that slides and are moved out of it, by up to {distance:.3e} \
         at step {step}; that boundary does not stay plane"
    )

    /// A body moves at no step.
    BodyStays {
        /// Its name.
        body: String,
    } => ("body \"{body}\" stays where it is at every step of the schedule")

    /// The interface of the turning zones is no surface of revolution.
    TurnsOut {
        /// The step at which its nodes are farthest off.
        step: usize,
        /// How far, in mesh units.
        distance: f64,
    } => (
        "the zones that are carried round meet the rest of the mesh in a surface that is none of revolution about the \
         shaft: at step {step} its nodes are up to {distance:.3e} off where it was, so cells overlap there or leave holes"
    )

    /// Velocities are asked for, and nothing moves.
    NoVelocity => ("the velocities of all bodies are 0 at every step")

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
    } => ("body \"{body}\" leaves the box around the mesh at {steps} of {looked_at} steps looked at, step {first} first")

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
        "the surfaces of {} and {} cut through each other at {steps} of {looked_at} steps looked at, step {first} first, \
         near {place:?}",
        owner(&bodies[0]), owner(&bodies[1])
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
    } => (
        "output.format = \"{format}\" holds no arrays: displacement, velocity and cell quality are left out"
    )

    /// A disk that has room for the steps only if they are compressed well.
    LittleRoom {
        /// Steps that are to be written.
        steps: u64,
        /// Bytes of all of them, without compression.
        needed: u64,
        /// Bytes of each.
        each: u64,
        /// Bytes that are free.
        free: u64,
    } => (
        "unpacked, {steps} steps take {} ({} each), and {} are free", amount(*needed), amount(*each), amount(*free)
    )
}}

fn owner(body: &Option<String>) -> String {
    let named = |name: &String| format!("body \"{name}\"");
    body.as_ref().map_or("a fixed boundary".to_owned(), named)
}

/// Bytes in a unit that fits.
pub fn amount(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    match unit {
        0 => format!("{bytes} B"),
        _ => format!("{value:.3} {}", UNITS[unit]),
    }
}
