//! Runs of schedules that have times but no azimuth.

use crate::run::{Finished, Request};
use azimesh_core::Note;

const MESH: &str = "testdata/sphere_in_box_raw.vtu";

/// A sphere that moves by `way` in half a second; `keys` are further lines of its schedule.
fn deform(way: f64, keys: &str) -> Finished {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        "time.values = [0.0, 0.5]\n{keys}\n\
         boundaries.fixed = [\"inlet\", \"outlet\", \"walls\"]\nrbf.support_radius = 3.0\n\
         [[body]]\nname = \"sphere\"\ntags = [\"sphere\"]\n\
         rigid = {{ translate = [{way:?}, 0.0, 0.0], ramp = true }}\n"
    );
    let request = Request {
        keep_going: true,
        // The test needs a step with inverted cells.
        allow_outside: true,
        ..Request::default()
    };
    super::deform(folder.path(), MESH, &text, request).expect("it runs")
}

fn only(notes: &[Note]) -> String {
    assert_eq!(notes.len(), 1, "{notes:?}");
    notes[0].to_string()
}

#[test]
fn inverted_cells_are_told_with_the_time_of_their_step() {
    let warned = only(&deform(5.0, "output.on_inverted = \"warn\"").inverted);
    assert!(warned.starts_with("step 1 (0.5 s) has "), "{warned}");
    let passed = only(&deform(5.0, "output.on_inverted = \"stop\"").skipped);
    assert!(passed.starts_with("step 1 (0.5 s) has "), "{passed}");
}

#[test]
fn a_step_that_fails_is_told_with_its_time() {
    let keys = "selection = { method = \"real\", max_points = 1, tolerance = 1e-6 }\noutput.quality = \"none\"";
    let passed = only(&deform(0.1, keys).skipped);
    assert!(passed.starts_with("step 1 (0.5 s): "), "{passed}");
}
