//! Notes of `motion`: what of a schedule or of the files of a motion is likely to be another than was meant.

use std::fmt;
use std::path::PathBuf;

/// Numbers from here on are shown with an exponent.
const LONG: f64 = 1e16;

/// What the user should know of a motion.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionNote {
    /// The last step is not at the stop that was asked for.
    ShortOfStop {
        /// Where the last step is.
        last: f64,
        /// The stop.
        stop: f64,
        /// From one step to the next.
        step: f64,
    },
    /// Two bodies move the nodes that they share apart.
    SharedNodes {
        /// How many nodes.
        nodes: usize,
        /// The body that they move with, and the other.
        bodies: [String; 2],
        /// How far from there the other would put them at most, in mesh units.
        distance: f64,
        /// The step of that.
        step: usize,
    },
    /// A body turns so far in a substep that `twist` folds cells.
    TurnsFar {
        /// Its name.
        body: String,
        /// How far it turns, in degrees.
        angle_deg: f64,
        /// Substeps that it does so in.
        substeps: usize,
        /// The step of that.
        step: usize,
        /// Its azimuth in degrees.
        azimuth_deg: f64,
        /// How far a body may turn in one go, in degrees.
        folds_deg: f64,
        /// Substeps that would serve.
        needed: usize,
    },
    /// Pitch, flap or lag is more than a turn.
    MoreThanATurn {
        /// Name of the body.
        body: String,
        /// Which of the angles.
        angle: &'static str,
        /// What mean and harmonics add up to, in degrees.
        sum_deg: f64,
    },
    /// Where the line is that the sections of a beam turn about.
    BeamLine {
        /// Name of the body.
        body: String,
        /// What the line is called.
        line: &'static str,
        /// Its ends in the mesh.
        ends: [[f64; 3]; 2],
        /// Direction of the leading edge.
        leading_edge: [f64; 3],
    },
    /// A lifting line lies beside its blade.
    LineBeside {
        /// Name of the body.
        body: String,
        /// The point of the line that is farthest from the blade, along the blade's axes from the hub.
        point: [f64; 3],
        /// Its station.
        station: f64,
        /// How far from the blade, in mesh units.
        distance: f64,
        /// The corners of the box around the blade, along the same axes.
        bounds: [[f64; 3]; 2],
    },
    /// A blade goes on far past the stations of its table.
    NoStations {
        /// Name of the body.
        body: String,
        /// The table.
        table: PathBuf,
        /// The stations that it lacks.
        between: [f64; 2],
        /// Whether they come before its first one.
        is_before: bool,
    },
    /// A station of a table lies far off the blade.
    FarStation {
        /// The station.
        station: f64,
        /// Name of the body.
        body: String,
        /// Where it begins and ends along its span.
        span: [f64; 2],
    },
    /// Rows of a table are for nodes that the body does not have.
    OtherNodes {
        /// How many rows.
        rows: usize,
        /// Name of the body.
        body: String,
    },
}

impl fmt::Display for MotionNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShortOfStop { last, stop, step } => write!(
                f,
                "the last step is at {}: `stop` = {} is not a whole number of steps of {} from the first",
                shown(*last),
                shown(*stop),
                shown(*step)
            ),
            Self::SharedNodes {
                nodes,
                bodies: [own, other],
                distance,
                step,
            } => write!(
                f,
                "{nodes} nodes are on tags of body \"{own}\" and of body \"{other}\"; they move with the first, and \
                 the other would put them up to {distance:.3e} elsewhere (step {step})"
            ),
            Self::TurnsFar {
                body,
                angle_deg,
                substeps,
                step,
                azimuth_deg,
                folds_deg,
                needed,
            } => {
                write!(f, "body \"{body}\" turns by {angle_deg:.0} degrees")?;
                if *substeps > 1 {
                    write!(f, " in {substeps} substeps")?;
                }
                write!(
                    f,
                    " at step {step} (azimuth {azimuth_deg} degrees); past about {folds_deg} degrees in one go \
                     interpolate = \"twist\" folds cells: set rbf.substeps = {needed}"
                )
            }
            Self::MoreThanATurn {
                body,
                angle,
                sum_deg,
            } => write!(
                f,
                "body \"{body}\": mean and harmonics of its {angle} add up to {sum_deg:.0} degrees, more than a turn; \
                 is `angle_unit` right?"
            ),
            Self::BeamLine {
                body,
                line,
                ends,
                leading_edge,
            } => {
                let [root, tip] = ends.map(|end| rounded(end, digits_for(ends)));
                let nose = rounded(*leading_edge, 3);
                write!(
                    f,
                    "body \"{body}\": its {line} goes from {root} to {tip}, with the leading edge towards {nose}"
                )
            }
            Self::LineBeside {
                body,
                point,
                station,
                distance,
                bounds: [low, high],
            } => write!(
                f,
                "body \"{body}\": the lifting line is at {point:?} at station {station}, {distance:.3e} beside the \
                 blade, which lies between {low:?} and {high:?}; its points are along the blade's axes from the hub"
            ),
            Self::NoStations {
                body,
                table,
                between: [from, to],
                is_before,
            } => write!(
                f,
                "body \"{body}\": {} has no stations between {from} and {to}; the values of its {} are held there",
                table.display(),
                if *is_before { "first one" } else { "last one" }
            ),
            Self::FarStation {
                station,
                body,
                span: [low, high],
            } => write!(
                f,
                "station {station} lies far off body \"{body}\", which goes from {low} to {high} along its span; \
                 stations are lengths in mesh units from the hub"
            ),
            Self::OtherNodes { rows, body } => write!(
                f,
                "{rows} rows are for nodes that body \"{body}\" does not have, and are not used"
            ),
        }
    }
}

/// A number without hundreds of digits.
pub fn shown(x: f64) -> String {
    if x.abs() < LONG {
        x.to_string()
    } else {
        format!("{x:.1e}")
    }
}

/// Digits after the point that tell the places along a line apart.
fn digits_for([from, to]: &[[f64; 3]; 2]) -> usize {
    let squares = (0..3).map(|axis| (to[axis] - from[axis]).powi(2));
    let length = squares.sum::<f64>().sqrt();
    (4.0 - length.log10().floor()).clamp(0.0, 17.0) as usize
}

fn rounded(x: [f64; 3], digits: usize) -> String {
    // What rounds to zero has no sign.
    let least = 0.5 * 0.1_f64.powi(digits as i32);
    let numbers = x.map(|x| format!("{:.digits$}", if x.abs() < least { 0.0 } else { x }));
    format!("[{}]", numbers.join(", "))
}
