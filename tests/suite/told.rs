//! Nothing is wrong in silence: what the whole program says and refuses, each with what would be right.

use crate::support::{airfoil, assert_says, azimesh, rewrite, short, succeed};
use std::fs;
use std::path::Path;

const PITCH: (&str, &str) = ("step = 10.0", "step = 90.0");

#[test]
fn steps_of_a_schedule_of_times_have_no_azimuth() {
    let folder = airfoil();
    let body = "[[body]]\nname = \"a\"\ntags = [\"airfoil\"]\nrigid = { translate = [0.1, 0.0, 0.0], ramp = true }\n";
    let schedule = format!(
        "time = {{ stop = 0.2, step = 0.1 }}\nboundaries.others = \"fixed\"\nrbf.support_radius = 10.0\n{body}"
    );
    fs::write(folder.path().join("t.toml"), schedule).unwrap();
    succeed(folder.path(), "-q deform n.vtu t.toml -o out");
    let table = fs::read_to_string(folder.path().join("out/steps.csv")).unwrap();
    let starts: Vec<String> = table
        .lines()
        .map(|line| line.split(',').take(3).collect::<Vec<_>>().join(","))
        .collect();
    assert_eq!(
        starts,
        ["step,azimuth_deg,time_s", "0,,0", "1,,0.1", "2,,0.2"]
    );
    let resumed = "-q deform n.vtu t.toml -o out --resume";
    succeed(folder.path(), resumed);
}

#[test]
fn base_points_that_miss_the_tolerance_of_another_schedule_are_told_to_be_chosen_anew() {
    let folder = airfoil();
    rewrite(
        folder.path(),
        "n.toml",
        "few.toml",
        &[PITCH, ("tolerance = 1e-4", "tolerance = 1e-2")],
    );
    succeed(folder.path(), "-q select n.vtu few.toml -o base.toml");
    rewrite(
        folder.path(),
        "few.toml",
        "tight.toml",
        &[("tolerance = 1e-2", "tolerance = 1e-5")],
    );
    let with = "-q deform n.vtu tight.toml --base base.toml -o out --force";
    let run = azimesh(folder.path(), with);
    assert_eq!(run.code, 1, "{run:?}");
    assert!(
        run.err.contains("leave out --base") && !run.err.contains("max_points"),
        "{run:?}"
    );
    // What the sentence advises.
    succeed(folder.path(), "-q deform n.vtu tight.toml -o out --force");
}

#[test]
fn a_wall_that_is_called_fixed_and_moves_is_told_of_in_check_and_deform() {
    let folder = airfoil();
    let mesh = "su2/n.su2";
    fs::create_dir(folder.path().join("su2")).unwrap();
    succeed(folder.path(), ["-q", "convert", "n.vtu", mesh]);
    let text = fs::read_to_string(folder.path().join(mesh)).unwrap();
    // The faces of the airfoil once more, as a tag of their own.
    let at = text.find("MARKER_TAG= airfoil").unwrap();
    let end = text[at + 1..]
        .find("MARKER_TAG=")
        .map_or(text.len(), |n| at + 1 + n);
    let again = text[at..end].replace("airfoil", "wall");
    let text = text.replace("NMARK= 2", "NMARK= 3") + &again;
    fs::write(folder.path().join(mesh), text).unwrap();
    rewrite(
        folder.path(),
        "n.toml",
        "few.toml",
        &[PITCH, ("[\"farfield\"]", "[\"farfield\", \"wall\"]")],
    );
    for command in [
        &["check", mesh, "few.toml"][..],
        &["deform", mesh, "few.toml", "-o", "out"],
    ] {
        let run = succeed(folder.path(), command);
        let told = format!("{}{}", run.out, run.err);
        assert!(
            told.contains("of tag \"wall\", which is fixed, move with body \"airfoil\""),
            "{told}"
        );
    }
}

#[test]
fn optional_tags_that_the_mesh_lacks_are_noted() {
    let folder = airfoil();
    let tags = (
        "tags = [\"airfoil\"]",
        "tags = [\"airfoil\"]\noptional_tags = [\"flap_*\", \"air*\"]",
    );
    rewrite(folder.path(), "n.toml", "few.toml", &[PITCH, tags]);
    let run = succeed(folder.path(), "check n.vtu few.toml");
    let told = format!("{}{}", run.out, run.err);
    let note = "no tag of the mesh matches \"flap_*\" in `optional_tags` of body \"airfoil\"";
    assert!(told.contains(note) && !told.contains("air*"), "{told}");
}

#[test]
fn portable_files_leave_out_what_their_readers_do_not_take() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "NDIME= 2\nNELEM= 2\n9 0 1 2 3\n9 1 4 5 2\nNPOIN= 6\n0 0\n1 0\n1 1\n0 1\n2 0\n2 1\nNMARK= 2\nMARKER_TAG= wall\n\
                MARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= inside\nMARKER_ELEMS= 1\n3 1 2\n";
    fs::write(folder.path().join("m.su2"), mesh).unwrap();
    let run = succeed(folder.path(), "convert m.su2 same.su2");
    assert!(
        run.err
            .contains("SU2 takes markers on the boundary only; --portable leaves them out"),
        "{run:?}"
    );
    let run = succeed(folder.path(), "convert m.su2 portable.su2 --portable");
    assert!(
        run.err.contains("faces between two cells left out: 1"),
        "{run:?}"
    );
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(text("same.su2").contains("inside") && !text("portable.su2").contains("inside"));
    assert!(text("portable.su2").contains("wall"));
}

#[test]
fn files_that_are_no_mesh_are_named_for_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let write =
        |name: &str, bytes: &[u8]| fs::write(Path::new(folder.path()).join(name), bytes).unwrap();
    write("a.su2", b"PK\x03\x04\x14\0\0\0");
    write("b", b"BZh91AY&SY");
    for (name, what) in [
        ("a.su2", "this is a zip archive"),
        ("b", "this is a bzip2 file"),
    ] {
        let run = azimesh(folder.path(), ["info", name]);
        assert_eq!(run.code, 2, "{run:?}");
        assert!(
            run.err.contains(what) && !run.err.contains("known formats"),
            "{run:?}"
        );
    }
}

#[test]
fn a_step_that_nobody_asked_for_is_told() {
    let folder = short();
    let path = folder.path();
    let args = ["deform", "n.vtu", "few.toml", "--format", "vtkhdf"];
    succeed(path, [&args[..], &["-o", "out"]].concat());
    let sequence = "out/n.vtkhdf";
    for args in [
        &["deform", sequence, "few.toml", "-o", "again"][..],
        &["check", sequence, "few.toml"],
    ] {
        let run = succeed(path, args);
        let told = run.err.matches("5 steps that it holds").count();
        assert_eq!(told, 1, "{args:?} {run:?}");
    }
    // It says so itself, once.
    let run = succeed(path, ["convert", sequence, "last.vtu"]);
    assert_says(&run.err, &["5 meshes"]);
    assert!(!run.err.contains("5 steps that"), "{run:?}");
}

#[test]
fn what_readers_do_not_take_is_told_of_sequences_in_one_file_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // A tetrahedron with an edge of a group, and values of its cells.
    let mesh = "# vtk DataFile Version 3.0\nm\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n\
                CELLS 2 8\n4 0 1 2 3\n2 0 1\nCELL_TYPES 2\n10\n3\nCELL_DATA 2\nSCALARS p double 1\nLOOKUP_TABLE default\n1 2\n";
    fs::write(path.join("a.vtk"), mesh).unwrap();
    fs::write(path.join("b.vtk"), mesh).unwrap();
    let run = succeed(path, "convert a.vtk b.vtk two.cgns");
    assert!(run.err.contains("ParaView shows no cell array"), "{run:?}");
}

#[test]
fn blades_that_are_one_body_are_told_and_a_mesh_that_is_carried_round_has_velocities() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = "sample rotor --blades 4 --nodes 20000 --first-cell 1e-3 -o r.vtu";
    succeed(path, sample);
    let head = "time = { stop = 0.2, step = 0.1, frequency = 2.0 }\nrbf.support_radius = 5.625\n\
                boundaries.fixed = [\"hub\", \"outer\"]\noutput.velocity = true\n";
    let body = |name: &str, tag: &str| {
        format!("[[body]]\nname = \"{name}\"\ntags = [\"{tag}\"]\ncyclic.collective = 5.0\n")
    };
    let rest = "boundaries.others = \"fixed\"\n";
    let (one, all) = (body("one", "blade_2"), body("all", "blade_*"));
    let one = one.replace("cyclic", "azimuth_offset = 90\ncyclic");
    for (name, text) in [
        (
            "all.toml",
            format!("{head}rotor.frame = \"inertial\"\n{all}"),
        ),
        ("one.toml", format!("{head}{rest}{one}")),
    ] {
        fs::write(path.join(name), text).unwrap();
    }
    let told = |schedule: &str| succeed(path, ["check", "r.vtu", schedule]).err;
    let (all, one) = (told("all.toml"), told("one.toml"));
    assert!(all.contains("several blades are several bodies"), "{all}");
    assert!(!all.contains("velocities of all bodies are 0"), "{all}");
    assert!(!one.contains("several blades"), "{one}");
    assert!(one.contains("velocities of all bodies are 0"), "{one}");
}

#[test]
fn check_tells_of_rotors_and_tips_where_there_are_any_and_how_to_see_all_steps() {
    let folder = airfoil();
    let path = folder.path();
    let schedule = "azimuth = { start = 0, stop = 90, step = 5 }\nboundaries.others = \"fixed\"\n\
                    body = [ { name = \"a\", tags = [\"airfoil\"], rigid = { translate = [0, 0.01, 0] } } ]\n";
    std::fs::write(path.join("t.toml"), schedule).unwrap();
    let told = succeed(path, "check n.vtu t.toml").out;
    assert_says(&told, &["at 10 of 19 steps; --json has them all"]);
    for unwanted in ["hub", "shaft", "pitch_deg", "tip_dx"] {
        assert!(!told.contains(unwanted), "{told}");
    }
    assert_says(
        &told,
        &["body a\nazimuth_deg     largest\n          0   0.0100000\n"],
    );
    let told = succeed(path, "check n.vtu n.toml").out;
    assert_says(
        &told,
        &["shaft", "pitch_deg  flap_deg   lag_deg     largest\n"],
    );
    let turns = schedule.replace(
        "translate = [0, 0.01, 0]",
        "ramp = true, rotate = { axis = [0, 0, 1], angle = 9 }",
    );
    std::fs::write(path.join("r.toml"), turns).unwrap();
    let told = succeed(path, ["check", "n.vtu", "r.toml"]).out;
    let table = "body a\nazimuth_deg angle_deg     largest\n          0     0.000           0\n         10     1.000 ";
    assert_says(&told, &[&table.replace("           0\n", "    0.000000\n")]);
    let found = succeed(path, ["check", "n.vtu", "r.toml", "--json"]).out;
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let last = &found["steps"][18]["bodies"][0];
    assert!((last["angle_deg"].as_f64().unwrap() - 9.0).abs() < 1e-12);
    assert!(last["pitch_deg"].is_null());
    succeed(path, ["-q", "deform", "n.vtu", "r.toml", "-o", "turned"]);
    let record = std::fs::read_to_string(path.join("turned/run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    let angles = &record["motion"]["bodies"][0]["angle_deg"];
    assert_eq!(angles.as_array().map(Vec::len), Some(19));
    succeed(path, ["-q", "report", "turned", "-o", "r.html"]);
    let page = std::fs::read_to_string(path.join("r.html")).unwrap();
    assert_says(&page, &["angle 0° to 9°", "\"Angle\""]);
}
