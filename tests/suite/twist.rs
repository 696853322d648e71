//! `interpolate = "twist"`: large rotations against a fixed boundary, in one step.

use crate::support::sequence::{Sequence, distance, nodes_of, same, testdata, write};
use crate::support::{azimesh, rewrite, succeed};
use azimesh_io::mesh::{CellKind, Group, Mesh};
use std::fmt::Write as _;
use std::path::Path;

const STEPS: &str = "[azimuth]\nstart = 0.0\nstop = 270.0\nstep = 30.0\n";

/// A body turned evenly from 0 to 270 degrees, in steps of 30.
/// Folded cells stay as they are: what interpolation alone does is looked at here.
fn schedule(tag: &str, axis: &str, fixed: &str, rbf: &str) -> String {
    format!(
        "output.on_inverted = \"warn\"\n{STEPS}[[body]]\nname = \"body\"\ntags = [\"{tag}\"]\n\
         rigid = {{ rotate = {{ axis = {axis}, angle = 270.0 }}, ramp = true }}\n\
         [boundaries]\nfixed = [\"{fixed}\"]\n[rbf]\n{rbf}\n[selection]\ntolerance = 1e-4\n"
    )
}

/// Runs the program, which may find inverted cells.
fn deform(folder: &Path, mesh: &str, text: &str, out: &str) -> Sequence {
    std::fs::write(folder.join("s.toml"), text).unwrap();
    let run = azimesh(folder, ["-q", "deform", mesh, "s.toml", "-o", out]);
    assert!(run.code <= 1, "{run:?}");
    Sequence::left_in(&folder.join(out), &folder.join(mesh))
}

/// Inverted cells at 120, 180 and 270 degrees.
fn inverted(sequence: &Sequence) -> [f64; 3] {
    let inverted = sequence.numbers("inverted");
    assert_eq!(sequence.numbers("azimuth_deg")[4], 120.0);
    [4, 6, 9].map(|step| inverted[step])
}

/// An O-grid of quadrilaterals round a NACA 0012 with its middle at the origin, to a circle of 2.5
/// chords: first cells of 1e-5, growing to 0.05, rays straight from the wall to the circle. A cell folds
/// where the layers beside it turn against each other by more than sqrt(2 height / radius), so cells
/// far out must not be long.
fn ogrid(around: usize) -> Mesh {
    let mut heights = vec![1e-5f64];
    while heights.iter().sum::<f64>() < 2.5 {
        heights.push((heights[heights.len() - 1] * 1.2).min(0.05));
    }
    let total: f64 = heights.iter().sum();
    let layers = heights.len() + 1;
    let mut mesh = Mesh::default();
    for layer in 0..layers {
        let part = heights[..layer].iter().sum::<f64>() / total;
        for i in 0..around {
            let angle = std::f64::consts::TAU * i as f64 / around as f64;
            let (sin, cos) = angle.sin_cos();
            let x = 0.5 * (1.0 + cos);
            let half = 0.6 * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x)
                + 0.6 * (0.2843 * x.powi(3) - 0.1036 * x.powi(4));
            let wall = [x - 0.5, half.copysign(sin)];
            let to = |wall: f64, circle: f64| (1.0 - part) * wall + part * 2.5 * circle;
            mesh.points.push([to(wall[0], cos), to(wall[1], sin), 0.0]);
        }
    }
    let node = |layer: usize, i: usize| (layer * around + i % around) as u32;
    for layer in 0..layers - 1 {
        for i in 0..around {
            let corners = [
                (layer, i),
                (layer + 1, i),
                (layer + 1, i + 1),
                (layer, i + 1),
            ];
            let nodes = corners.map(|(layer, i)| node(layer, i));
            mesh.cells.push(CellKind::Quadrilateral, &nodes);
        }
    }
    for (name, layer) in [("airfoil", 0), ("farfield", layers - 1)] {
        let first = mesh.cells.len();
        for i in 0..around {
            mesh.cells
                .push(CellKind::Line, &[node(layer, i), node(layer, i + 1)]);
        }
        mesh.groups.push(Group {
            dimension: 1,
            name: name.into(),
            number: None,
            condition: None,
            cells: (first..mesh.cells.len()).collect(),
        });
    }
    mesh
}

#[test]
fn an_airfoil_turns_by_270_degrees_without_inverted_cells_where_displacement_folds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(&ogrid(128), &path.join("n.vtu"));
    let text = |interpolate: &str| {
        let rbf = format!("support_radius = 10.0\ninterpolate = \"{interpolate}\"");
        schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", &rbf)
    };
    let straight = deform(path, "n.vtu", &text("displacement"), "straight");
    let [at_120, at_180, _] = inverted(&straight);
    assert!(at_120 > 100.0 && at_180 > 1000.0, "{at_120} {at_180}");

    let twist = deform(path, "n.vtu", &text("twist"), "twist");
    twist.assert_sound();
    let ratios = twist.numbers("min_first_cell_ratio");
    assert!(ratios.iter().all(|ratio| *ratio > 0.9), "{ratios:?}");
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
fn inside_a_circle_a_rotation_is_not_interpolated_but_falls_with_the_logarithm_of_the_radius() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(&ogrid(128), &path.join("n.vtu"));
    let rbf = "support_radius = 10.0\ninterpolate = \"twist\"";
    let text = schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", rbf);
    let rings = deform(path, "n.vtu", &text, "rings");
    rings.assert_sound();
    assert!(rings.numbers("base_points").iter().all(|n| *n == 0.0));
    // What is no farther from the axis than the body turns with it.
    for ratio in rings.numbers("min_first_cell_ratio") {
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
    // Between the radii 0.5 and 2.5 the angle falls with the logarithm.
    let points = rings.points(9);
    let mut n_between = 0;
    for (node, x) in rings.reference.points.iter().enumerate() {
        let (before, after) = (x[0].hypot(x[1]), points[node][0].hypot(points[node][1]));
        assert!((before - after).abs() < 1e-13, "every circle is kept");
        let part = ((before / 0.5).ln() / 5.0f64.ln()).clamp(0.0, 1.0);
        let weight = if part < 0.5 {
            1.0 - 4.0 / 3.0 * part * part
        } else {
            4.0 / 3.0 * (1.0 - part)
        };
        let (s, c) = (270f64.to_radians() * weight).sin_cos();
        let wanted = [c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]];
        assert!(distance(points[node], wanted) < 1e-6, "node {node}");
        n_between += usize::from(weight > 0.0 && weight < 1.0);
    }
    assert!(n_between > 1000);
}

#[test]
fn a_rotation_below_the_tolerance_has_no_base_points_and_an_exact_surface() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(&ogrid(64), &path.join("n.vtu"));
    let rbf = "support_radius = 10.0\nrotation_radius = 10.0\ninterpolate = \"twist\"";
    let text = schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", rbf);
    let out = deform(
        path,
        "n.vtu",
        &text.replace("angle = 270.0", "angle = 0.001"),
        "out",
    );
    out.assert_sound();
    assert!(out.numbers("base_points").iter().all(|n| *n == 0.0));
    assert!(out.numbers("max_displacement")[9] > 1e-6);
    assert!(out.numbers("max_surface_error")[9] < 1e-14);
}

#[test]
fn a_blade_turns_about_its_span_by_180_degrees_without_inverted_cells_where_displacement_folds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let shape = "--untwisted --root 11 --radius 12 --cylinder-radius 8 --first-cell 0.02";
    let size = "--nodes 80000 --layers 60 -o b.vtu";
    let sample = format!("-q sample blade {shape} {size}");
    succeed(path, sample.split(' ').collect::<Vec<_>>());
    let text = |interpolate: &str| {
        let rbf = format!("support_radius = 20.0\ninterpolate = \"{interpolate}\"");
        schedule(
            "blade",
            "[1.0, 0.0, 0.0], origin = [11.5, -0.25, 0.0]",
            "outer",
            &rbf,
        )
        .replace("1e-4", "5e-3")
        .replace("270.0", "180.0")
        .replace("30.0", "60.0")
    };
    let straight = deform(path, "b.vtu", &text("displacement"), "straight");
    assert!(straight.numbers("inverted")[3] > 1000.0);
    deform(path, "b.vtu", &text("twist"), "twist").assert_sound();
}

#[test]
fn a_translation_is_interpolated_alike_by_twist_and_displacement() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = "-q sample naca0012 --nodes 1500 -o n.vtu";
    succeed(path, sample);
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
fn twist_and_displacement_are_near_each_other_at_small_angles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let size = ["--nodes", "12000", "--first-cell", "1e-2", "-o", "b.vtu"];
    succeed(path, [&["-q", "sample", "blade"][..], &size].concat());
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
    // The same on the surface; in between one carries w (x - c) and the other interpolates x - c.
    for (a, b) in straight.points(1).into_iter().zip(twist.points(1)) {
        assert!(distance(a, b) < 0.25 * largest, "{a:?} {b:?}");
    }
}

#[test]
fn the_selection_error_of_twist_is_within_the_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = "-q sample naca0012 --nodes 3000 -o n.vtu";
    succeed(path, sample);
    // With a radius of its own the rotation is interpolated; else it would be exact.
    let rbf = "support_radius = 10.0\nrotation_radius = 10.0\ninterpolate = \"twist\"";
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
fn substeps_turn_a_body_once_round_to_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(&ogrid(128), &path.join("n.vtu"));
    let rbf = "support_radius = 10.0\ninterpolate = \"twist\"\nsubsteps = 3";
    let text = schedule("airfoil", "[0.0, 0.0, 1.0]", "farfield", rbf).replace("270.0", "360.0");
    let out = deform(path, "n.vtu", &text, "out");
    assert_eq!(inverted(&out)[..2], [0.0; 2]);
    let last = out.n_steps() - 1;
    assert!(out.numbers("max_surface_error")[last] < 1e-12);
    let points = out.points(last);
    let mut largest: f64 = 0.0;
    for (node, x) in out.reference.points.iter().enumerate() {
        largest = largest.max(distance(points[node], *x));
    }
    assert!(
        largest > 1.0,
        "nodes between the body and the circle have gone round in part"
    );
    for node in nodes_of(&out.reference, &["airfoil"]) {
        assert!(distance(points[node], out.reference.points[node]) < 1e-12);
    }
}

#[test]
fn a_wing_turns_on_its_symmetry_plane_and_the_plane_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::copy(testdata("wing_on_plane.toml"), path.join("w.toml")).unwrap();
    let twist = ("[rbf]", "[rbf]\ninterpolate = \"twist\"");
    let far = ("sin = 15.0", "sin = 60.0");
    rewrite(path, "w.toml", "w.toml", &[twist, far]);
    let mesh = testdata("wing_on_plane.vtu");
    let wing = Sequence::of(path, &mesh, &path.join("w.toml"), "out");
    wing.assert_sound();
    let points = wing.points(2);
    for node in nodes_of(&wing.reference, &["symmetry"]) {
        let z = wing.reference.points[node][2];
        assert_eq!(points[node][2].to_bits(), z.to_bits(), "node {node}");
    }
}
