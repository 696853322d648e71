//! Steps with folded cells are repaired together with the steps around them: the same bytes whoever asks for which of
//! them, and no jumps on the way.

use crate::support::{Args, azimesh, files, succeed, without_seconds};
use azimesh::{Deformation, Mesh, Schedule};
use std::collections::BTreeMap;
use std::path::Path;

type Vector = [f64; 3];

/// The last step.
const LAST: usize = 24;

/// A block that turns by 170 degrees in its square, goes aside, and comes back: `b.vtu`, `b.toml` with `output`.
fn swing(output: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    succeed(path, "-q sample block -o b.vtu");
    let mut table = "time_s,dx,dy,dz,rot_x_deg,rot_y_deg,rot_z_deg\n".to_owned();
    for i in 0..=LAST {
        let part = (std::f64::consts::PI * i as f64 / LAST as f64).sin();
        let (x, y, angle) = (-0.1 * part, -0.15 * part, 170.0 * part);
        table += &format!("{},{x},{y},0,0,0,{angle}\n", 0.1 * i as f64);
    }
    std::fs::write(path.join("swing.csv"), table).unwrap();
    let schedule = format!(
        "time = {{ stop = {}, step = 0.1 }}\nboundaries.fixed = [\"left\", \"right\", \"bottom\", \"top\"]\n\
         rbf.support_radius = 5.0\nselection.method = \"all\"\noutput = {{ {output} }}\n\
         [[body]]\nname = \"block\"\ntags = [\"block\"]\n\
         table = {{ file = \"swing.csv\", origin = [0.5, 0.5, 0.0], interpolation = \"cubic\" }}\n",
        0.1 * LAST as f64
    );
    std::fs::write(path.join("b.toml"), schedule).unwrap();
    folder
}

fn deform(folder: &Path, out: &str, options: impl Args) {
    let args = ["-q", "deform", "b.vtu", "b.toml", "-o", out];
    succeed(folder, [&args[..], &options.words()].concat());
}

fn record(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.join("run.json")).unwrap()).unwrap()
}

/// Files of meshes, and the table without its seconds.
fn outcome(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(folder);
    let table = String::from_utf8(files["steps.csv"].clone()).unwrap();
    let rows: Vec<String> = table.lines().map(without_seconds).collect();
    files.retain(|name, _| name.ends_with(".vtu") || name.ends_with(".vtkhdf"));
    files.insert("steps.csv".to_owned(), rows.join("\n").into_bytes());
    files
}

fn assert_same(folder: &Path, found: &str, wanted: &str) {
    let (left, right) = (outcome(&folder.join(found)), outcome(&folder.join(wanted)));
    assert!(left.keys().eq(right.keys()), "{found}: {:?}", left.keys());
    for (name, content) in right {
        // Not assert_eq: nobody wants to read the bytes.
        assert!(left[&name] == content, "{found}: {name} is another");
    }
    let repairs = |of: &str| record(&folder.join(of))["repairs"].clone();
    assert_eq!(repairs(found), repairs(wanted), "{found}");
}

/// As after a kill while a step was written: some whole rows and a piece of the next.
fn interrupt(folder: &Path, from: &str, to: &str, rows: usize) {
    std::fs::create_dir(folder.join(to)).unwrap();
    for (name, content) in files(&folder.join(from)) {
        std::fs::write(folder.join(to).join(name), content).unwrap();
    }
    let table = folder.join(to).join("steps.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at + 1).collect();
    std::fs::write(&table, &text[..ends[rows] + 9]).unwrap();
}

#[test]
fn repaired_steps_are_the_same_on_any_threads_in_parts_and_when_resumed() {
    let folder = swing("velocity = true");
    let folder = folder.path();
    deform(folder, "whole", "--threads 1");
    let repairs = record(&folder.join("whole"))["repairs"].clone();
    let repairs = repairs.as_array().unwrap();
    assert!(repairs.iter().any(|repair| repair["weight"] == 1.0));
    assert!(
        repairs
            .iter()
            .any(|repair| repair["weight"].as_f64() < Some(1.0))
    );
    deform(folder, "five", "--threads 5");
    assert_same(folder, "five", "whole");
    // Borders before the folded steps and among them.
    for steps in ["0..3", "3..12", "12..25"] {
        deform(folder, "parts", ["--steps", steps, "--threads", "2"]);
    }
    succeed(folder, "-q finish parts");
    assert_same(folder, "parts", "whole");
    for rows in [3, 14] {
        let out = format!("after_{rows}");
        interrupt(folder, "whole", &out, rows);
        deform(folder, &out, "--resume");
        assert_same(folder, &out, "whole");
    }
    let in_one = "--format vtkhdf";
    deform(folder, "one", in_one);
    interrupt(folder, "one", "one_after", 13);
    deform(folder, "one_after", format!("{in_one} --resume"));
    assert_same(folder, "one_after", "one");
}

#[test]
fn a_step_below_improve_is_raised_and_steps_far_from_it_keep_their_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let sample = "-q sample naca0012 --nodes 1200 -o b.vtu";
    succeed(folder, sample);
    let schedule = |output: &str| {
        let text = format!(
            "azimuth = {{ stop = 55, step = 5 }}\nboundaries.fixed = [\"farfield\"]\n{output}\n\
             [[body]]\nname = \"airfoil\"\ntags = [\"airfoil\"]\n\
             rigid = {{ ramp = true, rotate = {{ axis = [0, 0, 1], angle = 55 }} }}\n"
        );
        std::fs::write(folder.join("b.toml"), text).unwrap();
    };
    let least = |of: &str| -> Vec<f64> {
        let table = std::fs::read_to_string(folder.join(of).join("steps.csv")).unwrap();
        let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let at = names.iter().position(|name| *name == "min_scaled_jacobian");
        let rows = table.lines().skip(1);
        rows.map(|row| row.split(',').nth(at.unwrap()).unwrap().parse().unwrap())
            .collect()
    };
    schedule("");
    deform(folder, "plain", []);
    let before = least("plain");
    // The last two steps are low.
    let wanted = 0.5 * (before[9] + before[10]);
    assert!(before[9] > wanted && before[10] > before[11] && before[11] > 0.0);
    schedule(&format!("output.improve = {wanted}"));
    deform(folder, "improved", "--threads 1");
    let after = least("improved");
    assert!(
        after[10] > before[10] && after[11] > 1.05 * before[11],
        "{after:?}"
    );
    let pairs = || std::iter::zip(&before, &after);
    assert!(
        pairs().all(|(before, after)| after >= before),
        "{before:?} {after:?}"
    );
    let (plain, improved) = (
        outcome(&folder.join("plain")),
        outcome(&folder.join("improved")),
    );
    for step in 0..=11 {
        let name = format!("b_{step:04}.vtu");
        assert_eq!(plain[&name] == improved[&name], step < 5, "{name}");
    }
    let repairs = record(&folder.join("improved"))["repairs"].clone();
    assert_eq!(repairs[0]["step"], 5);
    assert!(repairs[6]["low_before"].as_u64() > Some(0));
    assert_eq!(repairs[0]["low_before"], serde_json::Value::Null);
    deform(folder, "three", "--threads 3");
    assert_same(folder, "three", "improved");
    interrupt(folder, "improved", "after", 8);
    deform(folder, "after", "--resume");
    assert_same(folder, "after", "improved");
    // On the way the nodes make no jump.
    let step =
        |index: usize| azimesh::Mesh::read(folder.join(format!("improved/b_{index:04}.vtu")));
    let meshes: Vec<Mesh> = (0..=11).map(|index| step(index).unwrap()).collect();
    let jump = |k: usize| {
        let nodes = 0..meshes[k].points.len();
        largest(nodes.map(|node| {
            let at = |k: usize| meshes[k].points[node];
            [0, 1, 2].map(|axis| at(k + 1)[axis] - 2.0 * at(k)[axis] + at(k - 1)[axis])
        }))
    };
    let jumps: Vec<f64> = (1..11).map(jump).collect();
    assert!(jumps.iter().all(|jump| *jump < 0.1), "{jumps:?}");
}

#[test]
fn no_step_of_a_window_with_folded_cells_is_worse_with_improve_than_without() {
    let rows = |output: &str| {
        let folder = swing(output);
        deform(folder.path(), "out", []);
        let table = std::fs::read_to_string(folder.path().join("out/steps.csv")).unwrap();
        let rows = table
            .lines()
            .map(|row| row.split(',').map(str::to_owned).collect());
        rows.collect::<Vec<Vec<String>>>()
    };
    let (plain, improved) = (rows(""), rows("improve = 0.4"));
    for name in ["min_scaled_jacobian", "min_volume", "inverted", "unproven"] {
        let at = plain[0].iter().position(|column| column == name).unwrap();
        let sign = if name.starts_with("min") { 1.0 } else { -1.0 };
        let values = |of: &[Vec<String>]| -> Vec<f64> {
            of[1..]
                .iter()
                .map(|row| sign * row[at].parse::<f64>().unwrap())
                .collect()
        };
        let (before, after) = (values(&plain), values(&improved));
        let mut pairs = std::iter::zip(&before, &after);
        assert!(
            pairs.all(|(before, after)| after >= before),
            "{name}: {before:?} {after:?}"
        );
        assert_eq!(before != after, sign > 0.0, "{name}: some steps are better");
    }
}

fn deformation(folder: &Path) -> Deformation {
    let mesh = Mesh::read(folder.join("b.vtu")).unwrap();
    Deformation::new(mesh, Schedule::read(folder.join("b.toml")).unwrap()).unwrap()
}

fn largest(vectors: impl Iterator<Item = Vector>) -> f64 {
    let size = |v: Vector| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    vectors.map(size).fold(0.0, f64::max)
}

#[test]
fn the_library_repairs_the_steps_that_are_asked_for_in_any_order() {
    let folder = swing("velocity = true");
    let folder = folder.path();
    let forward = deformation(folder);
    let all: Vec<Vec<Vector>> = forward
        .steps()
        .iter()
        .map(|step| forward.points_at(step).unwrap())
        .collect();
    for (step, points) in forward.steps().iter().zip(&all) {
        let quality = forward.quality_of(points).unwrap();
        assert_eq!(quality.inverted, 0, "{step}");
    }
    let other = deformation(folder);
    for at in [20, 3, 12, 0] {
        let step = other.steps()[at];
        assert!(other.points_at(&step).unwrap() == all[at], "{step}");
        let velocities = forward.velocities_at(&forward.steps()[at]).unwrap();
        assert!(other.velocities_at(&step).unwrap() == velocities, "{step}");
    }
    deform(folder, "out", []);
    for at in [2, 12, 17] {
        let mesh = Mesh::read(folder.join(format!("out/b_{at:04}.vtu"))).unwrap();
        assert!(mesh.points() == all[at], "{at}");
    }
}

#[test]
fn nodes_do_not_jump_where_a_repair_begins_and_ends() {
    let folder = swing("velocity = true");
    let deformation = deformation(folder.path());
    let steps = deformation.steps();
    let all: Vec<Vec<Vector>> = steps
        .iter()
        .map(|step| deformation.points_at(step).unwrap())
        .collect();
    let nodes = 0..all[0].len();
    let way = |from: usize, to: usize, node: usize| {
        let (a, b) = (all[from][node], all[to][node]);
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
    };
    let mut widest: f64 = 0.0;
    for at in 1..LAST {
        let fastest = largest(nodes.clone().map(|node| way(at - 1, at, node)));
        widest = widest.max(fastest);
    }
    // The wall goes 0.17 in the first step; folded and untangled by itself, a step would throw nodes as far as 0.3.
    assert!(widest < 0.2, "{widest}");
    for at in [3, 6, 9, 12, 15] {
        let velocities = deformation.velocities_at(&steps[at]).unwrap();
        let off = largest(nodes.clone().map(|node| {
            let way = way(at - 1, at + 1, node);
            let v = velocities[node];
            [0, 1, 2].map(|k| v[k] - way[k] / 0.2)
        }));
        let fastest = largest(velocities.iter().copied());
        assert!(
            off < 0.15 * fastest.max(0.3),
            "step {at}: {off} of {fastest}"
        );
    }
}

#[test]
fn repair_is_what_happens_unless_something_else_is_said() {
    let said = |output: &str| {
        let folder = swing(output);
        let run = azimesh(folder.path(), "deform b.vtu b.toml -o out");
        let repairs = record(&folder.path().join("out"))["repairs"].clone();
        (run.code, repairs.is_array())
    };
    assert_eq!(said(""), (0, true));
    assert_eq!(said("on_inverted = \"warn\""), (1, false));
    // Where nothing is judged nothing is repaired.
    assert_eq!(said("quality = \"none\""), (0, false));
}

#[test]
fn a_mesh_of_one_layer_is_repaired_in_its_plane() {
    let folder = swing("format = \"vtu\"");
    let folder = folder.path();
    let case = ["--extrude", "0.1", "--format", "openfoam"];
    let convert = ["-q", "convert", "b.vtu", "layer"];
    succeed(folder, [&convert[..], &case].concat());
    let text = std::fs::read_to_string(folder.join("b.toml")).unwrap();
    let steps = format!("step = {}", 0.05 * LAST as f64);
    let text = text.replace("step = 0.1", &steps);
    std::fs::write(folder.join("layer.toml"), text).unwrap();
    succeed(folder, "-q deform layer layer.toml -o out");
    let repair = record(&folder.join("out"))["repairs"][1].clone();
    assert!(repair["inverted"].as_u64() > Some(0), "{repair}");
    assert_eq!(repair["unrepaired"], 0, "{repair}");
    let [before, after] =
        ["layer", "out/layer_0001.vtu"].map(|file| Mesh::read(folder.join(file)).unwrap());
    for (from, to) in before.points().iter().zip(after.points()) {
        assert_eq!(from[2], to[2]);
    }
}
