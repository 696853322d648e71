//! Notes of `motion`: input in a schedule or in the files of a motion that is probably a mistake.

use super::notes::notes;
use super::{in_digits, named_step, short, with_verb};
use crate::error::counted;
use std::path::PathBuf;

notes! {
/// What the user should know of a motion.
MotionNote as Motion {
    /// The last step is not at the stop of the schedule.
    ShortOfStop {
        /// Where the last step is.
        last: f64,
        /// The stop.
        stop: f64,
        /// From one step to the next.
        step: f64,
    } => (
        "the last step is at {}; `stop` = {} is not reached, since it is not a whole number of steps of {} from \
         the first",
        short(*last), short(*stop), short(*step)
    )

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
    } => (
        "{} on tags of both body \"{}\" and body \"{}\"; they move with the first, up to {} from \
         where the second would put them (step {step})",
        with_verb(*nodes, "node", "is"), bodies[0], bodies[1], in_digits(*distance, 3)
    )

    /// A body turns so far in a substep that `twist` folds cells.
    TurnsFar {
        /// Its name.
        body: String,
        /// How far it turns, in degrees.
        angle_deg: f64,
        /// Substeps of each step.
        substeps: usize,
        /// The step of that.
        step: usize,
        /// Its azimuth in degrees; `None` where the schedule has times alone.
        azimuth_deg: Option<f64>,
        /// Its time in seconds, where it is known.
        time_s: Option<f64>,
        /// How far a body may turn in one go, in degrees.
        folds_deg: f64,
        /// Substeps that would be enough.
        needed: usize,
    } => (
        "body \"{body}\" turns by {angle_deg:.0} degrees{} at {}; above about {folds_deg} degrees at once \
         interpolate = \"twist\" folds cells: set rbf.substeps = {needed}",
        if *substeps > 1 { format!(" in {substeps} substeps") } else { String::new() },
        named_step(*step, *azimuth_deg, *time_s)
    )

    /// Pitch, flap or lag is more than a turn.
    MoreThanATurn {
        /// Name of the body.
        body: String,
        /// Which of the angles.
        angle: &'static str,
        /// What mean and harmonics add up to, in degrees.
        sum_deg: f64,
    } => (
        "body \"{body}\": mean and harmonics of its {angle} add up to {sum_deg:.0} degrees, more than a full \
         turn; check `angle_unit`"
    )

    /// A table over azimuth does not repeat itself, and its body has an azimuth offset.
    Transient {
        /// Name of the body.
        body: String,
        /// Its azimuth offset, in degrees.
        offset_deg: f64,
        /// Why it does not repeat itself.
        why: String,
    } => (
        "body \"{body}\": the table does not repeat itself ({why}), so it is taken at the azimuth of the rotor; \
         azimuth_offset = {} turns the axes of the blade, and shifts harmonics and tables that repeat themselves",
        in_digits(*offset_deg, 6)
    )

    /// A table over azimuth has no row at the end of its revolution, and a step is past its last row.
    ClosedByStep {
        /// Name of the body.
        body: String,
        /// The first and the last row, in words.
        rows: [String; 2],
        /// Where the revolution ends, in words.
        end: String,
        /// The first such step.
        step: usize,
    } => (
        "body \"{body}\": the table goes from {} to {}, one step before {end}, and so repeats itself; the values of step {step} \
         are between its last and its first row",
        rows[0], rows[1]
    )

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
    } => (
        "body \"{body}\": its {line} goes from {} to {}, with the leading edge towards {}",
        rounded(ends[0], digits_for(ends)), rounded(ends[1], digits_for(ends)), rounded(*leading_edge, 3)
    )

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
    } => (
        "body \"{body}\": the lifting line is at {} at station {}, {} from the blade, which lies \
         between {} and {}; give its points along the blade's axes from the hub",
        super::point(point), short(*station), in_digits(*distance, 3), super::point(&bounds[0]), super::point(&bounds[1])
    )

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
    } => (
        "body \"{body}\": {} has no stations between {} and {}; the values of its {} are used there",
        table.display(), short(between[0]), short(between[1]), if *is_before { "first station" } else { "last station" }
    )

    /// Columns of a table that nothing asks for.
    OtherColumns {
        /// Name of the body.
        body: String,
        /// The columns.
        columns: Vec<String>,
    } => (
        "body \"{body}\": passed over {} that `columns` does not name: {}",
        counted(columns.len(), "column"), columns.join(", ")
    )

    /// Lengths of a table are in a unit, and the schedule does not say what the mesh is in.
    AssumesMetres {
        /// Name of the body.
        body: String,
        /// The lengths with their units.
        lengths: Vec<String>,
    } => (
        "body \"{body}\": {} is converted for a mesh in m; for another write for example  length_unit = \"mm\"  in [output]",
        lengths.join(", ")
    )

    /// Rows of a table are for nodes that the body does not have.
    OtherNodes {
        /// How many rows.
        rows: usize,
        /// Name of the body.
        body: String,
    } => ("ignored {} of nodes that are not on body \"{body}\"", counted(*rows, "row"))
}}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_told_with_its_substeps_where_there_are_several() {
        let turns = |angle_deg: f64, substeps, needed| MotionNote::TurnsFar {
            body: "blade".to_owned(),
            angle_deg,
            substeps,
            step: 2,
            azimuth_deg: Some(90.0),
            time_s: None,
            folds_deg: 300.0,
            needed,
        };
        assert_eq!(
            turns(339.9999, 1, 2).to_string(),
            "body \"blade\" turns by 340 degrees at step 2 (azimuth 90 degrees); above about 300 degrees at once \
             interpolate = \"twist\" folds cells: set rbf.substeps = 2"
        );
        let many = turns(1000.0, 3, 6).to_string();
        assert!(
            many.contains("turns by 1000 degrees in 3 substeps at step 2"),
            "{many}"
        );
    }

    #[test]
    fn the_ends_of_a_line_have_the_digits_that_its_length_asks_for() {
        let line = |tip: [f64; 3]| {
            let note = MotionNote::BeamLine {
                body: "blade".to_owned(),
                line: "quarter chord",
                ends: [[-1e-20, 0.25, 0.0], tip],
                leading_edge: [0.0, -1.0, 0.0],
            };
            note.to_string()
        };
        assert_eq!(
            line([1.0, 0.25, 0.0]),
            "body \"blade\": its quarter chord goes from [0.0000, 0.2500, 0.0000] to [1.0000, 0.2500, 0.0000], with the \
             leading edge towards [0.000, -1.000, 0.000]"
        );
        assert!(line([1000.0, 0.25, 0.0]).contains("to [1000.0, 0.2, 0.0]"));
    }
}
