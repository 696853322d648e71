//! Parts of a sequence, written separately, joined to what one run leaves.

#![allow(clippy::unwrap_used)]

mod support;

use std::path::Path;
use support::{airfoil, azimesh, files, names, rewrite, succeed};

const PARTS: [&str; 3] = ["0..3", "3..4", "4..7"];

fn deform(folder: &Path, format: &str, options: &[&str]) {
    let args = ["-q", "deform", "n.vtu", "case.toml", "--format", format];
    succeed(folder, &[&args[..], options].concat());
}

/// A folder with a case of seven steps.
fn seven_steps() -> tempfile::TempDir {
    let folder = airfoil();
    rewrite(
        folder.path(),
        "n.toml",
        "case.toml",
        &[("step = 10.0", "step = 60.0")],
    );
    folder
}

fn in_parts(folder: &Path, format: &str) {
    for part in PARTS {
        deform(folder, format, &["-o", "out", "--steps", part]);
    }
}

#[test]
fn parts_of_a_mesh_with_tags_of_another_name_are_joined() {
    let folder = seven_steps();
    let folder = folder.path();
    let ascii = [
        "-q",
        "convert",
        "n.vtu",
        "n.vtu",
        "--force",
        "--encoding",
        "ascii",
    ];
    succeed(folder, &ascii);
    let names = [
        ("\"BoundaryTag\"", "\"Face\""),
        ("\"BoundaryTagNames\"", "\"Other\""),
    ];
    rewrite(folder, "n.vtu", "n.vtu", &names);
    let tags = [("\"airfoil\"", "\"1\""), ("\"farfield\"", "\"2\"")];
    rewrite(folder, "case.toml", "case.toml", &tags);
    for part in PARTS {
        let options = ["-o", "out", "--steps", part, "--tag-array", "Face"];
        deform(folder, "vtkhdf", &options);
    }
    succeed(folder, &["finish", "out"]);
    let told = support::json(folder, &["report", "out"]);
    assert_eq!(told["notes"], serde_json::json!([]));
}

/// steps.csv without its seconds.
fn table(folder: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("steps.csv")).unwrap();
    text.lines()
        .map(|row| row.rsplit_once(',').unwrap().0.to_owned())
        .collect()
}

#[test]
fn parts_are_joined_to_the_files_of_one_run() {
    let folder = seven_steps();
    let folder = folder.path();
    for format in ["vtu", "vtk", "vtkhdf", "cgns"] {
        deform(folder, format, &["-o", "whole"]);
        in_parts(folder, format);
        let run = succeed(folder, &["finish", "out"]);
        assert!(run.out.starts_with("out: 7 steps from "), "{run:?}");
        let (whole, out) = (folder.join("whole"), folder.join("out"));
        assert_eq!(table(&out), table(&whole), "{format}");
        let joined = files(&out);
        for (name, content) in files(&whole) {
            if !name.starts_with("steps") && !name.starts_with("run") {
                assert!(joined[&name] == content, "{format}: {name} is another");
            }
        }
        let record: serde_json::Value = serde_json::from_slice(&joined["run.json"]).unwrap();
        assert_eq!(record["outcome"], "complete");
        assert_eq!(record["parts"], serde_json::json!(PARTS));
        let part = |name: &str| -> serde_json::Value {
            serde_json::from_slice(&joined[&format!("run_{name}.json")]).unwrap()
        };
        let seconds = |of: &serde_json::Value, stage: &str| of["seconds"][stage].as_f64().unwrap();
        let parts = PARTS.map(|steps| part(&steps.replace("..", "-")));
        for stage in ["selection", "modes", "steps", "writing", "total"] {
            let sum: f64 = parts.iter().map(|part| seconds(part, stage)).sum();
            assert!(sum > 0.0 && seconds(&record, stage) >= sum, "{stage}");
        }
        // What is joined is a sequence like any other.
        let args = [
            "deform",
            "n.vtu",
            "case.toml",
            "--format",
            format,
            "-o",
            "out",
            "--resume",
        ];
        let run = succeed(folder, &args);
        assert!(run.out.starts_with("complete already"), "{format}: {run:?}");
        let again = azimesh(folder, &["finish", "out"]);
        assert!(
            again.code == 2 && again.err.contains("exists already; --force"),
            "{again:?}"
        );
        succeed(folder, &["finish", "out", "--force", "-q"]);
        for out in [whole, out] {
            std::fs::remove_dir_all(out).unwrap();
        }
    }
}

#[test]
fn what_is_missing_or_damaged_is_named_and_nothing_is_written() {
    let folder = seven_steps();
    let folder = folder.path();
    std::fs::create_dir(folder.join("out")).unwrap();
    let refused = |reason: &str| {
        let before = names(&folder.join("out"));
        let run = azimesh(folder, &["finish", "out"]);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert!(run.err.contains(reason), "{reason}: {run:?}");
        assert_eq!(names(&folder.join("out")), before);
    };
    refused("holds no parts of a sequence");
    deform(folder, "vtu", &["-o", "out", "--steps", "0..3"]);
    deform(folder, "vtu", &["-o", "out", "--steps", "5..6"]);
    refused("steps 3 to 4, 6 are missing");
    deform(folder, "vtu", &["-o", "out", "--steps", "6..7"]);
    deform(folder, "vtu", &["-o", "out", "--steps", "2..5", "--force"]);
    refused("step 2 is in more than one part: 0..3, 2..5; remove the files of one of them");
    for name in ["steps_2-5.csv", "run_2-5.json"] {
        std::fs::remove_file(folder.join("out").join(name)).unwrap();
    }
    let rest = ["-o", "out", "--steps", "3..5", "--force"];
    deform(folder, "vtu", &rest);
    let mesh = folder.join("out/n_0004.vtu");
    let content = std::fs::read(&mesh).unwrap();
    std::fs::write(&mesh, &content[1..]).unwrap();
    refused("step 4 is not there as written");
    std::fs::remove_file(&mesh).unwrap();
    refused("step 4 is not there as written");
    deform(folder, "vtu", &["-o", "out", "--steps", "3..5", "--resume"]);
    assert!(std::fs::read(&mesh).unwrap() == content);
    rewrite(
        folder,
        "case.toml",
        "case.toml",
        &[("sin = 10.0", "sin = 9.0")],
    );
    deform(folder, "vtu", &rest);
    refused("does not belong to the first one: its schedule, case.toml, had another content");
    std::fs::rename(folder.join("case.toml"), folder.join("other.toml")).unwrap();
    let args = ["deform", "n.vtu", "other.toml", "-q", "--format", "vtu"];
    succeed(folder, &[&args[..], &rest].concat());
    refused("its schedule was other.toml, that of the first one case.toml, with another content");
}

#[test]
fn a_damaged_file_of_a_part_is_found() {
    let folder = seven_steps();
    let folder = folder.path();
    in_parts(folder, "vtkhdf");
    let path = folder.join("out/n_4-7.vtkhdf");
    let mut content = std::fs::read(&path).unwrap();
    let at = content.len() - 100;
    content[at] ^= 1;
    std::fs::write(&path, content).unwrap();
    let run = azimesh(folder, &["finish", "out"]);
    assert!(
        run.code == 2 && run.err.contains("step 6 is not there as written"),
        "{run:?}"
    );
    deform(
        folder,
        "vtkhdf",
        &["-o", "out", "--steps", "4..7", "--resume"],
    );
    succeed(folder, &["finish", "out"]);
}

#[test]
fn a_part_that_overlaps_another_is_refused_in_every_format() {
    let folder = seven_steps();
    let folder = folder.path();
    for (format, option) in [
        ("vtu", "-q"),
        ("cgns", "-q"),
        ("vtkhdf", "-q"),
        ("vtu", "--resume"),
        ("cgns", "--resume"),
    ] {
        deform(folder, format, &["-o", "out", "--steps", "0..4"]);
        let before = names(&folder.join("out"));
        let args = ["deform", "n.vtu", "case.toml", "--format", format, option];
        let part = ["-o", "out", "--steps", "3..6"];
        let run = azimesh(folder, &[&args[..], &part].concat());
        assert_eq!(run.code, 2, "{run:?}");
        let said = "some of the steps 3..6 belong to the part 0..4, which run_0-4.json tells of";
        assert!(run.err.contains(said), "{format}: {run:?}");
        assert_eq!(names(&folder.join("out")), before);
        deform(folder, format, &["-o", "out", "--steps", "4..7"]);
        succeed(folder, &["finish", "out", "-q"]);
        std::fs::remove_dir_all(folder.join("out")).unwrap();
    }
}
