//! The other choices of a schedule: a linear polynomial, the mean error, a constant displacement.

use crate::support::sequence::{Sequence, distance};
use crate::support::{airfoil, assert_says, json, rewrite};
use serde_json::Value;
use std::path::Path;

/// Runs n.vtu by n.toml with changes.
fn deform(folder: &Path, changes: &[(&str, &str)]) -> Sequence {
    rewrite(folder, "n.toml", "case.toml", changes);
    Sequence::of(
        folder,
        &folder.join("n.vtu"),
        &folder.join("case.toml"),
        "out",
    )
}

/// What `select --json` says of the layer of displacements.
fn select(folder: &Path, selection: &str) -> Value {
    let more = format!("[selection]\n{selection}");
    rewrite(folder, "n.toml", "case.toml", &[("[selection]", &more)]);
    let args = "-q select n.vtu case.toml -o base.toml --force";
    json(folder, args)["layers"][0].clone()
}

#[test]
fn a_linear_polynomial_turns_the_whole_mesh_when_all_surfaces_turn() {
    let folder = airfoil();
    let all = ("tags = [\"airfoil\"]", "tags = [\"airfoil\", \"farfield\"]");
    let none = ("[boundaries]\nfixed = [\"farfield\"]\n", "");
    let turn = "rigid = { rotate = { axis = [0.0, 0.0, 1.0], angle = 50.0 }, translate = [1.0, 2.0, 0.0] }\n";
    let turn = ("[body.cyclic]\npitch = [ { sin = 10.0 } ]\n", turn);
    let one = ("stop = 360.0", "stop = 0.0");
    let linear = ("[rbf]", "[rbf]\npolynomial = \"linear\"");
    let turned = deform(folder.path(), &[all, none, turn, one, linear]);
    let (sin, cos) = 50f64.to_radians().sin_cos();
    let points = turned.points(0);
    for ([x, y, _], found) in turned.reference.points.iter().zip(points) {
        let exact = [1.0 + cos * x - sin * y, 2.0 + sin * x + cos * y, 0.0];
        assert!(distance(found, exact) < 1e-9, "{found:?} {exact:?}");
    }
    // It takes no more base points than fix the polynomial, or few.
    assert!(turned.numbers("base_points")[0] < 10.0);
}

#[test]
fn a_linear_polynomial_beside_a_fixed_boundary_keeps_surfaces_exact() {
    let folder = airfoil();
    let changes = [
        ("[rbf]", "[rbf]\npolynomial = \"linear\""),
        ("step = 10.0", "step = 90.0"),
    ];
    deform(folder.path(), &changes).assert_sound();
}

#[test]
fn the_mean_error_takes_fewer_base_points_than_the_largest() {
    let folder = airfoil();
    let largest = select(folder.path(), "criterion = \"max\"");
    let mean = select(folder.path(), "criterion = \"mean\"");
    let number = |layer: &Value, key: &str| layer[key].as_f64().unwrap();
    assert!(number(&largest, "error") <= 1e-4);
    assert!(number(&mean, "measured") <= 1e-4, "{mean}");
    assert!(
        number(&mean, "error") > 1e-4,
        "the largest is above it: {mean}"
    );
    assert!(number(&mean, "base_points") < number(&largest, "base_points"));
    let changes = [("[selection]", "[selection]\ncriterion = \"mean\"")];
    let out = deform(folder.path(), &changes);
    out.assert_sound();
    assert!(
        { out.numbers("selection_error") }
            .iter()
            .any(|error| *error > 1e-4)
    );
}

#[test]
fn a_constant_selection_does_not_depend_on_the_motion() {
    let folder = airfoil();
    let path = folder.path();
    let constant = (
        "[selection]",
        "[selection]\nmethod = \"constant\"\nconstant = [0.0, 0.2, 0.0]",
    );
    let nodes = |amplitude: &str| {
        rewrite(
            path,
            "n.toml",
            "case.toml",
            &[constant, ("sin = 10.0", amplitude)],
        );
        let args = "-q select n.vtu case.toml -o base.toml --force";
        crate::support::succeed(path, args);
        let text = std::fs::read_to_string(path.join("base.toml")).unwrap();
        text.lines()
            .find(|line| line.starts_with("nodes"))
            .unwrap()
            .to_owned()
    };
    assert_eq!(nodes("sin = 10.0"), nodes("sin = 3.0, cos = -7.0"));
}

#[test]
fn a_constant_selection_by_default_covers_the_largest_displacements() {
    let folder = airfoil();
    let layer = select(folder.path(), "method = \"constant\"");
    assert!(layer["measured"].as_f64().unwrap() <= 1e-4, "{layer}");
    let sequence = select(folder.path(), "method = \"sequence\"");
    let n = |layer: &Value| layer["base_points"].as_u64().unwrap();
    assert!(n(&layer) > 10 && n(&sequence) > 10);
}

#[test]
fn reaching_max_points_is_a_normal_end_of_a_constant_selection_alone() {
    let folder = airfoil();
    let constant = "[selection]\nmethod = \"constant\"\nmax_points = 12";
    let out = deform(
        folder.path(),
        &[("[selection]", constant), ("step = 10.0", "step = 90.0")],
    );
    assert_eq!(out.numbers("base_points"), [12.0; 5]);
    assert!(out.numbers("selection_error")[1] > 1e-4);
    assert!(
        out.numbers("max_surface_error")
            .iter()
            .all(|error| *error < 1e-14)
    );
    let sequence = ("[selection]", "[selection]\nmax_points = 12");
    rewrite(folder.path(), "n.toml", "case.toml", &[sequence]);
    let run = crate::support::azimesh(folder.path(), "deform n.vtu case.toml -o no");
    assert_eq!(run.code, 1, "{run:?}");
    assert_says(&run.err, &["max_points"]);
    assert!(!folder.path().join("no/n_0000.vtu").exists());
}

#[test]
fn a_selection_at_every_step_has_its_own_base_points_and_keeps_the_tolerance() {
    let folder = airfoil();
    let real = ("[selection]", "[selection]\nmethod = \"real\"");
    let out = deform(folder.path(), &[real, ("step = 10.0", "step = 30.0")]);
    out.assert_sound();
    let errors = out.numbers("selection_error");
    assert!(errors.iter().all(|error| *error <= 1e-4), "{errors:?}");
    let mut counts = out.numbers("base_points");
    assert!(counts[3] > 10.0, "{counts:?}");
    counts.dedup();
    assert!(counts.len() > 3, "{counts:?}");
}

#[test]
fn base_points_of_a_selection_at_its_only_step_are_named_after_that_step() {
    let folder = airfoil();
    let path = folder.path();
    let real = ("[selection]", "[selection]\nmethod = \"real\"");
    rewrite(
        path,
        "n.toml",
        "one.toml",
        &[real, ("step = 10.0", "step = 400.0")],
    );
    let run = "-q deform n.vtu one.toml -o out";
    crate::support::succeed(path, run);
    let names = crate::support::names(&path.join("out"));
    for (name, is_there) in [
        ("base_0000.toml", true),
        ("base_0000.vtp", true),
        ("base.toml", false),
    ] {
        assert_eq!(names.contains(&name.to_owned()), is_there, "{names:?}");
    }
    crate::support::succeed(path, format!("{run} --resume"));
}
