//! Notes of `preflight`: what a motion does on its mesh, and what a format or a disk cannot hold.

use std::fmt;

/// What is told before work starts.
#[derive(Debug, Clone, PartialEq)]
pub enum PreflightNote {
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
    },
    /// A body moves at no step.
    BodyStays {
        /// Its name.
        body: String,
    },
    /// The interface of the turning zones is no surface of revolution.
    TurnsOut {
        /// The step at which its nodes are farthest off.
        step: usize,
        /// How far, in mesh units.
        distance: f64,
    },
    /// Velocities are asked for, and nothing moves.
    NoVelocity,
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
    },
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
    },
    /// An option of the output that its format does not know.
    NoEffect {
        /// Key of the schedule, in `output`.
        key: &'static str,
        /// Name of the format.
        format: &'static str,
    },
    /// Arrays are asked for that the format does not hold.
    NoArrays {
        /// Name of the format.
        format: &'static str,
    },
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
    },
}

impl fmt::Display for PreflightNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeavesPlane {
                body,
                nodes,
                distance,
                step,
            } => write!(
                f,
                "{nodes} nodes of body \"{body}\" lie in a plane that slides and are moved out of it, by up to \
                 {distance:.3e} at step {step}; that boundary does not stay plane"
            ),
            Self::BodyStays { body } => write!(
                f,
                "body \"{body}\" stays where it is at every step of the schedule"
            ),
            Self::TurnsOut { step, distance } => write!(
                f,
                "the zones that are carried round meet the rest of the mesh in a surface that is none of revolution \
                 about the shaft: at step {step} its nodes are up to {distance:.3e} off where it was, so cells overlap \
                 there or leave holes"
            ),
            Self::NoVelocity => f.write_str("the velocities of all bodies are 0 at every step"),
            Self::LeavesBox {
                body,
                steps,
                looked_at,
                first,
            } => write!(
                f,
                "body \"{body}\" leaves the box around the mesh at {steps} of {looked_at} steps looked at, step \
                 {first} first"
            ),
            Self::SurfacesMeet {
                bodies,
                steps,
                looked_at,
                first,
                place,
            } => {
                let [one, other] = bodies.each_ref().map(|body| match body {
                    Some(name) => format!("body \"{name}\""),
                    None => "a fixed boundary".to_owned(),
                });
                write!(
                    f,
                    "the surfaces of {one} and {other} cut through each other at {steps} of {looked_at} steps looked \
                     at, step {first} first, near {place:?}"
                )
            }
            Self::NoEffect { key, format } => write!(
                f,
                "output.{key} has no effect on files of format = \"{format}\""
            ),
            Self::NoArrays { format } => write!(
                f,
                "output.format = \"{format}\" holds no arrays: displacement, velocity and cell quality are left out"
            ),
            Self::LittleRoom {
                steps,
                needed,
                each,
                free,
            } => write!(
                f,
                "unpacked, {steps} steps take {} ({} each), and {} are free",
                amount(*needed),
                amount(*each),
                amount(*free)
            ),
        }
    }
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
