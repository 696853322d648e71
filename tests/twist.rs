//! `interpolate = "twist"`: large rotations against a fixed boundary, in one step.

#![allow(clippy::unwrap_used)]

mod support;

use std::fmt::Write as _;
use std::path::Path;
use support::sequence::{Sequence, distance, nodes_of, same};
use support::{azimesh, succeed};

const STEPS: &str = "[azimuth]\nstart = 0.0\nstop = 270.0\nstep = 30.0\n";

/// A body turned evenly from 0 to 270 degrees, in steps of 30.
fn schedule(tag: &str, axis: &str, fixed: &str, rbf: &str) -> String {
    format!(
        "{STEPS}[[body]]\nname = \"body\"\ntags = [\"{tag}\"]\n\
         rigid = {{ rotate = {{ axis = {axis}, angle = 270.0 }}, ramp = true }}\n\
         [boundaries]\nfixed = [\"{fixed}\"]\n[rbf]\n{rbf}\n[selection]\ntolerance = 1e-4\n"
    )
}

/// Runs the program, which may find inverted cells.
fn deform(folder: &Path, mesh: &str, text: &str, out: &str) -> Sequence {
    std::fs::write(folder.join("s.toml"), text).unwrap();
    let run = azimesh(folder, &["-q", "deform", mesh, "s.toml", "-o", out]);
    assert!(run.code <= 1, "{run:?}");
    Sequence::left_in(&folder.join(out), &folder.join(mesh))
}

/// Inverted cells at 120, 180 and 270 degrees.
fn inverted(sequence: &Sequence) -> [f64; 3] {
    let inverted = sequence.numbers("inverted");
    assert_eq!(sequence.numbers("azimuth_deg")[4], 120.0);
    [4, 6, 9].map(|step| inverted[step])
}

#[test]
fn an_airfoil_turns_by_270_degrees_without_inverted_cells_where_displacement_folds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = ["-q", "sample", "naca0012", "--nodes", "8000", "-o", "n.vtu"];
    succeed(path, &sample);
    let text = |interpolate: &str| {
        let rbf = format!("support_radius = 10.0\ninterpolate = \"{interpolate}\"");
        schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", &rbf)
    };
    let straight = deform(path, "n.vtu", &text("displacement"), "straight");
    let [at_120, at_180, _] = inverted(&straight);
    assert!(at_120 > 0.0 && at_180 > 100.0, "{at_120} {at_180}");

    let twist = deform(path, "n.vtu", &text("twist"), "twist");
    twist.assert_sound();
    assert!(twist.numbers("min_scaled_jacobian")[6] > 0.2);
    assert!(
        { twist.numbers("min_first_cell_ratio") }
            .iter()
            .all(|ratio| *ratio > 0.98)
    );
    let points = twist.points(6);
    for node in nodes_of(&twist.reference, &["airfoil"]) {
        let [x, y, z] = twist.reference.points[node];
        assert!(distance(points[node], [-x, -y, z]) < 1e-14, "half a turn");
    }
    for node in nodes_of(&twist.reference, &["farfield"]) {
        assert!(same(points[node], twist.reference.points[node]));
    }
}

#[test]
fn a_blade_turns_about_its_span_by_270_degrees_without_inverted_cells() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let size = ["--nodes", "30000", "--first-cell", "1e-3", "-o", "b.vtu"];
    succeed(path, &[&["-q", "sample", "blade"][..], &size].concat());
    let text = |interpolate: &str| {
        let rbf = format!("support_radius = 5.625\ninterpolate = \"{interpolate}\"");
        schedule("blade", "[1.0, 0.0, 0.0]", "outer", &rbf).replace("1e-4", "1e-3")
    };
    let straight = deform(path, "b.vtu", &text("displacement"), "straight");
    let [at_120, at_180, _] = inverted(&straight);
    assert!(at_120 + at_180 > 100.0, "{at_120} {at_180}");
    deform(path, "b.vtu", &text("twist"), "twist").assert_sound();
}

#[test]
fn a_translation_is_interpolated_alike_by_twist_and_displacement() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = ["-q", "sample", "naca0012", "--nodes", "1500", "-o", "n.vtu"];
    succeed(path, &sample);
    let text = |interpolate: &str| {
        let rbf = format!("support_radius = 10.0\ninterpolate = \"{interpolate}\"");
        let turned = schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", &rbf);
        turned.replace(
            "rotate = { axis = [0.0, 0.0, 1.0], angle = 270.0 }",
            "translate = [0.2, 0.3, 0.0]",
        )
    };
    let [a, b] = ["displacement", "twist"].map(|i| deform(path, "n.vtu", &text(i), i));
    a.assert_sound();
    for (a, b) in a.points(9).into_iter().zip(b.points(9)) {
        assert!(distance(a, b) < 1e-12);
    }
}

#[test]
fn a_pitching_flapping_blade_is_where_displacement_puts_it_at_small_angles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let size = ["--nodes", "12000", "--first-cell", "1e-2", "-o", "b.vtu"];
    succeed(path, &[&["-q", "sample", "blade"][..], &size].concat());
    let mut text = String::from("[azimuth]\nstop = 270.0\nstep = 90.0\n");
    let _ = write!(
        text,
        "[[body]]\nname = \"b\"\ntags = [\"blade\"]\n\
         cyclic = {{ collective = 0.2, pitch = [{{ sin = 0.4 }}], coning = 0.1, flap = [{{ cos = 0.2 }}], flap_hinge = 0.3 }}\n\
         [boundaries]\nfixed = [\"outer\"]\n[selection]\ntolerance = 1e-5\n[rbf]\nsupport_radius = 5.0\n"
    );
    let straight = deform(path, "b.vtu", &text, "straight");
    straight.assert_sound();
    let twist = deform(
        path,
        "b.vtu",
        &(text + "interpolate = \"twist\"\n"),
        "twist",
    );
    twist.assert_sound();
    let largest = twist.numbers("max_displacement")[1];
    assert!(largest > 0.01);
    // The two differ by the square of the angle, 0.015 at most, and by twice the tolerance.
    for (a, b) in straight.points(1).into_iter().zip(twist.points(1)) {
        assert!(distance(a, b) < 0.03 * largest + 2e-5, "{a:?} {b:?}");
    }
}

#[test]
fn the_selection_error_of_twist_is_within_the_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = ["-q", "sample", "naca0012", "--nodes", "3000", "-o", "n.vtu"];
    succeed(path, &sample);
    let rbf = "support_radius = 10.0\ninterpolate = \"twist\"";
    let text = schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", rbf);
    let moved = text.replace("ramp = true", "translate = [0.3, -0.2, 0.0], ramp = true");
    for text in [text, moved] {
        let out = deform(path, "n.vtu", &(text + "correction = false\n"), "out");
        let errors = out.numbers("selection_error");
        assert!(errors.iter().all(|error| *error <= 1e-4), "{errors:?}");
        assert!(errors[9] > 1e-6);
        // Without a correction that is what is written.
        for (written, chosen) in out.numbers("max_surface_error").iter().zip(&errors) {
            assert!((written - chosen).abs() < 1e-9, "{written} {chosen}");
        }
        std::fs::remove_dir_all(path.join("out")).unwrap();
    }
}

#[test]
fn substeps_turn_a_body_once_round_without_inverted_cells() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = ["-q", "sample", "naca0012", "--nodes", "3000", "-o", "n.vtu"];
    succeed(path, &sample);
    let rbf = "support_radius = 10.0\ninterpolate = \"twist\"\nsubsteps = 4";
    let text = schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", rbf);
    let out = deform(path, "n.vtu", &text.replace("270.0", "360.0"), "out");
    out.assert_sound();
    let points = out.points(out.n_steps() - 1);
    for node in nodes_of(&out.reference, &["airfoil"]) {
        assert!(distance(points[node], out.reference.points[node]) < 1e-12);
    }
}
