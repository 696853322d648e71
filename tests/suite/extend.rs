//! Steps that are added to a finished run, and files of other programs under the names that a run writes.

use crate::support::{
    Args, Run, all_files, assert_says, azimesh, rewrite, succeed, without_seconds,
};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const FOREIGN: &[u8] = b"of another program";

/// `b.vtu`, a square with a block in it, and `v.vtu`, one layer of it.
fn block() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "-q sample block -o b.vtu");
    succeed(folder.path(), "-q convert b.vtu b.su2");
    succeed(folder.path(), "-q convert b.vtu v.vtu --extrude 0.1");
    folder
}

/// Writes `s.toml`: the block turns and moves until this time, in steps of 0.25 s.
fn until(folder: &Path, stop: f64, output: &str) {
    let schedule = format!(
        "time = {{ stop = {stop}, step = 0.25, frequency = 1.0 }}\nboundaries.others = \"fixed\"\nselection.tolerance = 1e-3\n\
         output = {{ {output} }}\n[[body]]\nname = \"block\"\ntags = [\"block\"]\n\
         rigid.translate = {{ vector = [0.01, 0, 0], harmonics = [{{ sin = 1.0 }}] }}\n\
         rigid.rotate = {{ axis = [0, 0, 1], origin = [0.5, 0.5, 0], angle = 2.0, harmonics = [{{ sin = 10.0, cos = 3.0 }}] }}\n"
    );
    fs::write(folder.join("s.toml"), schedule).unwrap();
}

fn deform(folder: &Path, mesh: &str, options: impl Args) -> Run {
    let args = ["-q", "deform", mesh, "s.toml", "-o", "o"];
    azimesh(folder, [&args[..], &options.words()].concat())
}

fn assert_code(run: &Run, code: i32, what: &str) {
    assert_eq!(run.code, code, "{what}: {run:?}");
}

/// All files below a folder; tables without seconds, and without the records of runs and lists.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = all_files(folder);
    for content in found
        .values_mut()
        .filter(|content| content.starts_with(b"step,"))
    {
        let text = String::from_utf8(std::mem::take(content)).unwrap();
        *content = text.lines().map(without_seconds).collect::<String>().into();
    }
    found
}

/// The files that hold meshes, and the table.
fn meshes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = files(folder);
    found.retain(|name, _| !name.ends_with("run.json") && !name.ends_with(".pvd"));
    found
}

fn put(path: &Path) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, FOREIGN).unwrap();
}

#[test]
fn added_steps_replace_no_file_of_another_program() {
    let folder = block();
    let folder = folder.path();
    let (o, last) = (folder.join("o"), ("0.5", "0.75"));
    for (mesh, options, foreign) in [
        ("b.vtu", "--format vtu", "b_0003.vtu"),
        ("b.vtu", "--format su2", "b_surface_00003.dat"),
        ("v.vtu", "--format ugrid", "v_0003.mapbc"),
        ("b.vtu", "--format vtk", "b_0003.vtk"),
        ("b.su2", "--format vtkhdf", "b_surface_00003.dat"),
        ("v.vtu", "--format openfoam", "0.75/polyMesh/points"),
        ("v.vtu", "--format openfoam", "0.75/polyMesh/faces"),
        ("v.vtu", "--format openfoam", "0.75/wantedDisplacement"),
    ] {
        let what = format!("{options}: {foreign}");
        let has_surface = foreign.ends_with(".dat");
        let surface = if has_surface {
            ", surface = \"su2\""
        } else {
            ""
        };
        let output = format!("displacement = true{surface}");
        let stop = |stop: &str| until(folder, stop.parse().unwrap(), &output);
        // A first run, and a part.
        put(&o.join(foreign));
        stop(last.1);
        for steps in ["", " --steps 1..4"] {
            let run = deform(folder, mesh, format!("{options}{steps}"));
            assert_code(&run, 2, &what);
            assert_says(&run.err, &[foreign, "--force", "another folder"]);
            assert_eq!(fs::read(o.join(foreign)).unwrap(), FOREIGN, "{what}");
        }
        fs::remove_dir_all(&o).unwrap();
        stop(last.0);
        assert_code(&deform(folder, mesh, options), 0, &what);
        put(&o.join(foreign));
        let before = files(&o);
        stop(last.1);
        let resume = format!("{options} --resume");
        let run = deform(folder, mesh, &resume);
        assert_code(&run, 2, &what);
        assert_says(&run.err, &[foreign, "--force", "another folder"]);
        assert!(files(&o) == before, "{what}");
        fs::remove_file(o.join(foreign)).unwrap();
        assert_code(&deform(folder, mesh, &resume), 0, &what);
        let after = meshes(&o);
        let table = |name: &str| name.ends_with("steps.csv");
        for (name, content) in before.iter().filter(|(name, _)| !table(name)) {
            let grows = ["run.json", ".pvd", ".series", ".vtkhdf"];
            let grows = grows.iter().any(|end| name.ends_with(end));
            assert!(
                grows || name == foreign || after[name] == *content,
                "{what}: {name}"
            );
        }
        fs::remove_dir_all(&o).unwrap();
    }
}

#[test]
fn a_file_without_a_row_is_replaced_if_the_run_has_written_it() {
    let folder = block();
    let folder = folder.path();
    let o = folder.join("o");
    for (options, mesh, names) in [
        ("", "b.su2", &["b_0004.vtu", "b_surface_00004.dat"][..]),
        ("--format openfoam", "v.vtu", &["1/polyMesh/points"]),
    ] {
        let surface = if mesh == "b.su2" {
            "surface = \"su2\""
        } else {
            ""
        };
        until(folder, 1.0, surface);
        let resume = format!("{options} --resume");
        assert_code(&deform(folder, mesh, options), 0, options);
        let whole = meshes(&o);
        let records = if mesh == "b.su2" { "" } else { "azimesh" };
        let table = o.join(records).join("steps.csv");
        let without_last = |table: &Path| {
            let text = fs::read_to_string(table).unwrap();
            let end = text.trim_end().rfind('\n').unwrap() + 1;
            fs::write(table, &text[..end]).unwrap();
        };
        without_last(&table);
        assert_code(&deform(folder, mesh, &resume), 0, options);
        assert!(meshes(&o) == whole, "{options}");
        for name in names {
            without_last(&table);
            let own = fs::read(o.join(name)).unwrap();
            put(&o.join(name));
            let run = deform(folder, mesh, &resume);
            assert_code(&run, 2, name);
            assert_says(
                &run.err,
                &[name.rsplit('/').next().unwrap(), "another program"],
            );
            assert_eq!(fs::read(o.join(name)).unwrap(), FOREIGN, "{name}");
            fs::write(o.join(name), own).unwrap();
            assert_code(&deform(folder, mesh, &resume), 0, name);
            assert!(meshes(&o) == whole, "{name}");
        }
        fs::remove_dir_all(&o).unwrap();
    }
}

#[test]
fn lost_steps_of_an_extended_run_are_computed_as_by_the_run_that_wrote_them() {
    let folder = block();
    let folder = folder.path();
    let o = folder.join("o");
    for (mesh, options, lost) in [
        (
            "b.vtu",
            "--format vtu",
            &["b_0001.vtu", "b_0005.vtu", "b_0007.vtu"][..],
        ),
        ("b.vtu", "--format vtkhdf", &["b.vtkhdf"]),
        ("b.vtu", "--format cgns", &["b.cgns"]),
        (
            "v.vtu",
            "--format openfoam",
            &["0.25/polyMesh/points", "1.25/polyMesh/points"],
        ),
    ] {
        let velocity = if mesh == "b.vtu" {
            "velocity = true"
        } else {
            ""
        };
        let resume = format!("{options} --resume");
        for stop in [1.0, 1.5, 2.0] {
            until(folder, stop, velocity);
            let run = deform(folder, mesh, &resume);
            assert_code(&run, 0, options);
            assert_eq!(run.err, "", "{options}");
        }
        let whole = meshes(&o);
        for name in lost {
            fs::remove_file(o.join(name)).unwrap();
            assert_code(&deform(folder, mesh, &resume), 0, name);
            assert!(meshes(&o) == whole, "{options}: {name}");
        }
        let damaged = fs::read(o.join(lost[0])).unwrap();
        fs::write(o.join(lost[0]), &damaged[..damaged.len() * 2 / 3]).unwrap();
        assert_code(&deform(folder, mesh, &resume), 0, options);
        assert!(meshes(&o) == whole, "{options}: damaged");
        fs::remove_dir_all(&o).unwrap();
    }
}

#[test]
fn steps_are_not_added_to_a_run_that_moved_otherwise() {
    let folder = block();
    let folder = folder.path();
    until(folder, 1.0, "");
    assert_code(&deform(folder, "b.vtu", ""), 0, "first");
    until(folder, 1.5, "");
    rewrite(folder, "s.toml", "s.toml", &[("sin = 10.0", "sin = 9.0")]);
    // As if a key of the steps had changed the motion: the rest of the schedule counts as the same.
    succeed(folder, "-q deform b.vtu s.toml -o other");
    let record = |out: &str| folder.join(out).join("run.json");
    let hash = |out: &str| {
        let text = fs::read_to_string(record(out)).unwrap();
        let record: serde_json::Value = serde_json::from_str(&text).unwrap();
        record["inputs"][1]["but_steps"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    let text = fs::read_to_string(record("o")).unwrap();
    fs::write(record("o"), text.replace(&hash("o"), &hash("other"))).unwrap();
    let before = files(&folder.join("o"));
    let run = deform(folder, "b.vtu", "--resume");
    assert_code(&run, 2, "moved");
    assert_says(
        &run.err,
        &["step 1 ", "otherwise than the finished run", "--force"],
    );
    assert!(files(&folder.join("o")) == before);
}

#[test]
fn a_part_of_another_run_changes_nothing() {
    let folder = block();
    let folder = folder.path();
    let o = folder.join("o");
    succeed(folder, "-q convert v.vtu w.vtu --scale 2");
    for options in ["--format vtu", "--format openfoam", "--format cgns"] {
        until(folder, 1.0, "");
        let first = format!("{options} --steps 0..2");
        assert_code(&deform(folder, "v.vtu", &first), 0, options);
        let before = files(&o);
        let second = format!("{options} --steps 2..5");
        for mesh in ["w.vtu", "v.vtu"] {
            if mesh == "v.vtu" {
                until(folder, 1.25, "");
            }
            let run = deform(folder, mesh, &second);
            assert_code(&run, 2, options);
            assert_says(
                &run.err,
                &["run_0-2.json", "part of another run", "--force"],
            );
            assert!(files(&o) == before, "{options}");
        }
        until(folder, 1.0, "");
        assert_code(&deform(folder, "v.vtu", &second), 0, options);
        assert_code(&azimesh(folder, "-q finish o"), 0, options);
        fs::remove_dir_all(&o).unwrap();
        // Base points and a mesh that no part has written.
        let shared = match options {
            "--format openfoam" => ["azimesh/base.toml", "constant/polyMesh/faces"],
            _ => ["base.toml", "base.vtp"],
        };
        for name in shared {
            put(&o.join(name));
            let before = files(&o);
            let run = deform(folder, "v.vtu", &first);
            assert_code(&run, 2, name);
            assert!(files(&o) == before, "{options}: {name}");
            fs::remove_dir_all(&o).unwrap();
        }
    }
}

#[test]
fn joined_parts_replace_no_file_of_another_program() {
    let folder = block();
    let folder = folder.path();
    until(folder, 0.5, "");
    for (format, name) in [
        ("vtu", "b.pvd"),
        ("vtu", "steps.csv"),
        ("vtkhdf", "b.vtkhdf"),
    ] {
        for steps in ["0..2", "2..3"] {
            let options = format!("--format {format} --steps {steps}");
            assert_code(&deform(folder, "b.vtu", options), 0, name);
        }
        put(&folder.join("o").join(name));
        let before = files(&folder.join("o"));
        let run = azimesh(folder, "-q finish o");
        assert_code(&run, 2, name);
        assert_says(&run.err, &[name, "--force"]);
        assert!(files(&folder.join("o")) == before, "{name}");
        assert_code(&azimesh(folder, "-q finish o --force"), 0, name);
        fs::remove_dir_all(folder.join("o")).unwrap();
    }
}

/// A block that turns in its square, by about 2.6 degrees a step; cells fold from step 40 on.
fn folding(folder: &Path, last: usize) {
    let schedule = format!(
        "azimuth = {{ stop = {}, step = 0.25 }}\nboundaries.others = \"fixed\"\nrbf.support_radius = 5.0\n\
         selection.method = \"all\"\n[[body]]\nname = \"block\"\ntags = [\"block\"]\n\
         rigid.rotate = {{ axis = [0, 0, 1], origin = [0.5, 0.5, 0], harmonics = [{{ sin = 600.0 }}] }}\n",
        0.25 * last as f64
    );
    fs::write(folder.join("s.toml"), schedule).unwrap();
}

/// The largest move of a node from each step to the next.
fn moves(run: &Path, steps: std::ops::Range<usize>) -> Vec<f64> {
    let points = |step: usize| {
        let mesh = azimesh::Mesh::read(run.join(format!("b_{step:04}.vtu"))).unwrap();
        mesh.points().to_vec()
    };
    let largest = |step: usize| {
        let (a, b) = (points(step), points(step + 1));
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    steps.map(largest).collect()
}

#[test]
fn a_window_of_added_steps_begins_at_the_positions_that_are_there() {
    let folder = block();
    let folder = folder.path();
    let o = folder.join("o");
    folding(folder, 46);
    succeed(folder, "-q deform b.vtu s.toml -o whole");
    let largest = |moves: Vec<f64>| moves.into_iter().fold(0.0, f64::max);
    let usual = largest(moves(&folder.join("whole"), 30..46));
    // The last finished step is before the folded ones, or one of them.
    for last in [37, 42] {
        folding(folder, last);
        assert_code(&deform(folder, "b.vtu", ""), 0, "first");
        let before = meshes(&o);
        folding(folder, 46);
        let run = azimesh(folder, "deform b.vtu s.toml -o o --resume");
        assert_code(&run, 0, "added");
        assert_says(&run.err, &["begins at the first step that was added"]);
        let after = meshes(&o);
        for (name, content) in before.iter().filter(|(name, _)| name.ends_with(".vtu")) {
            assert!(after[name] == *content, "{name}");
        }
        let found = moves(&o, last - 1..46);
        assert!(largest(found) < 3.0 * usual);
        for step in [last, last + 1, 46] {
            fs::remove_file(o.join(format!("b_{step:04}.vtu"))).unwrap();
            assert_code(&deform(folder, "b.vtu", "--resume"), 0, "lost");
            assert!(meshes(&o) == after, "{step}");
        }
        fs::remove_dir_all(&o).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_link_into_the_case_of_the_mesh_is_no_place_for_a_sequence() {
    let folder = block();
    let folder = folder.path();
    until(folder, 0.5, "displacement = true");
    succeed(folder, "-q convert v.vtu in --format openfoam");
    succeed(folder, "-q deform v.vtu s.toml -o in2 --format openfoam");
    rewrite(folder, "s.toml", "s.toml", &[("stop = 0.5", "stop = 1")]);
    for from in ["in", "in2"] {
        fs::create_dir_all(folder.join(from).join("0")).unwrap();
        let before = files(&folder.join(from));
        for linked in ["constant", "constant/polyMesh", "0.25", "0"] {
            let link = folder.join("o").join(linked);
            fs::create_dir_all(link.parent().unwrap()).unwrap();
            let there = folder.join(from).join(linked);
            if !there.exists() {
                continue;
            }
            std::os::unix::fs::symlink(there, &link).unwrap();
            let run = deform(folder, from, "--force");
            assert_code(&run, 2, linked);
            assert_says(&run.err, &[linked, "input"]);
            assert!(files(&folder.join(from)) == before, "{from}: {linked}");
            fs::remove_dir_all(folder.join("o")).unwrap();
        }
    }
}

#[test]
fn every_file_of_a_mesh_counts_for_resume() {
    let folder = block();
    let folder = folder.path();
    until(folder, 0.5, "");
    succeed(folder, "-q convert v.vtu p.pvtu --pieces 2");
    succeed(folder, "-q convert v.vtu u.ugrid");
    for (mesh, other) in [("p.pvtu", "p/p_1.vtu"), ("u.ugrid", "u.mapbc")] {
        assert_code(&deform(folder, mesh, ""), 0, mesh);
        assert_code(&deform(folder, mesh, "--resume"), 0, mesh);
        let path = folder.join(other);
        let text = fs::read(&path).unwrap();
        fs::write(&path, [&text[..], b"\n"].concat()).unwrap();
        let run = deform(folder, mesh, "--resume");
        assert_code(&run, 2, mesh);
        assert_says(&run.err, &[other, "has changed since"]);
        fs::remove_dir_all(folder.join("o")).unwrap();
    }
}
