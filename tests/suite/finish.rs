//! Parts of a sequence, written separately, joined to what one run leaves.

use crate::support::{Args, airfoil, assert_says, azimesh, files, names, rewrite, succeed};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

const PARTS: [&str; 3] = ["0..3", "3..4", "4..7"];

fn deform(folder: &Path, format: &str, options: impl Args) {
    let args = ["-q", "deform", "n.vtu", "case.toml", "--format", format];
    succeed(folder, [&args[..], &options.words()].concat());
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
        deform(folder, format, ["-o", "out", "--steps", part]);
    }
}

#[test]
fn a_format_that_nothing_is_written_in_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["finish", "report"] {
        let run = azimesh(folder.path(), [command, "out", "--format", "cgns"]);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["--format"]);
    }
}

#[test]
fn parts_of_a_mesh_with_tags_of_another_name_are_joined() {
    let folder = seven_steps();
    let folder = folder.path();
    let ascii = "-q convert n.vtu text.vtu --encoding ascii";
    succeed(folder, ascii);
    let names = [
        ("\"BoundaryTag\"", "\"Face\""),
        ("\"BoundaryTagNames\"", "\"Other\""),
    ];
    rewrite(folder, "text.vtu", "n.vtu", &names);
    let tags = [("\"airfoil\"", "\"1\""), ("\"farfield\"", "\"2\"")];
    rewrite(folder, "case.toml", "case.toml", &tags);
    for part in PARTS {
        let options = format!("-o out --steps {part} --tag-array Face");
        deform(folder, "vtkhdf", &options);
    }
    succeed(folder, "finish out");
    let told = crate::support::json(folder, ["report", "out"]);
    assert_eq!(told["diagnostics"], serde_json::json!([]));
}

/// The file of the first mesh, or of all.
fn first_mesh(format: &str) -> String {
    match format {
        "vtkhdf" | "cgns" => format!("n.{format}"),
        _ => format!("n_0000.{format}"),
    }
}

/// When each file of a folder was written.
fn written(folder: &Path) -> BTreeMap<String, SystemTime> {
    let modified = |name: String| {
        let found = std::fs::metadata(folder.join(&name)).unwrap();
        (name, found.modified().unwrap())
    };
    names(folder).into_iter().map(modified).collect()
}

/// Files of a folder; of records what two runs have in common.
fn left(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(folder);
    for (name, content) in &mut files {
        if name.ends_with(".json") {
            let mut record: serde_json::Value = serde_json::from_slice(content).unwrap();
            record["seconds"] = serde_json::Value::Null;
            *content = record.to_string().into_bytes();
        }
    }
    files
}

fn assert_same(found: &Path, wanted: &BTreeMap<String, Vec<u8>>, what: &str) {
    let found = left(found);
    assert!(found.keys().eq(wanted.keys()), "{what}: {:?}", found.keys());
    for (name, content) in wanted {
        assert!(found[name] == *content, "{what}: {name} is another");
    }
}

#[test]
fn what_is_joined_already_is_left_as_it_is() {
    let folder = seven_steps();
    let folder = folder.path();
    // Two of the steps have inverted cells.
    let warn = ("[rbf]", "[output]\non_inverted = \"warn\"\n[rbf]");
    let far = [("sin = 10.0", "sin = 170.0"), warn];
    rewrite(folder, "case.toml", "far.toml", &far);
    for (format, schedule, code) in [
        ("vtu", "case.toml", 0),
        ("vtkhdf", "case.toml", 0),
        ("cgns", "far.toml", 1),
        ("vtk", "far.toml", 1),
    ] {
        let args = format!("deform n.vtu {schedule} --format {format} -o out");
        let part = |part: &str| {
            let run = azimesh(folder, format!("{args} --resume --steps {part}"));
            assert!(run.code <= code, "{run:?}");
        };
        PARTS.into_iter().for_each(part);
        let first = azimesh(folder, "finish out");
        assert_eq!(first.code, code, "{first:?}");
        let out = folder.join("out");
        let (before, content) = (written(&out), files(&out));
        let again = azimesh(folder, "finish out");
        assert_eq!(again.code, code, "{again:?}");
        assert_says(&again.out, &["complete already", "7 steps"]);
        assert_eq!(written(&out), before, "{format}");
        assert!(files(&out) == content, "{format}");
        // A job that is requeued says all of it again.
        PARTS.into_iter().for_each(part);
        let again = azimesh(folder, "finish out");
        assert!(
            again.code == code && again.out.starts_with("complete already"),
            "{again:?}"
        );
        let resumed = azimesh(folder, format!("{args} --resume"));
        assert_eq!(resumed.code, code, "{resumed:?}");
        let again = azimesh(folder, "finish out");
        assert!(
            again.code == code && again.out.starts_with("complete already"),
            "{again:?}"
        );
        for (name, bytes) in &content {
            assert!(
                name.ends_with(".json") || files(&out)[name] == *bytes,
                "{name}"
            );
        }
        std::fs::remove_dir_all(out).unwrap();
    }
}

#[test]
fn what_an_ended_join_has_left_is_completed_without_force() {
    let folder = seven_steps();
    let folder = folder.path();
    for format in ["vtu", "vtkhdf", "cgns"] {
        in_parts(folder, format);
        succeed(folder, "finish out");
        let out = folder.join("out");
        let wanted = left(&out);
        let path = |name: &str| out.join(name);
        let again = |what: &str| {
            let run = succeed(folder, "finish out");
            assert!(!run.out.starts_with("complete already"), "{what}: {run:?}");
            assert_same(&out, &wanted, &format!("{format}, {what}"));
        };
        std::fs::remove_file(path("run.json")).unwrap();
        again("no record");
        std::fs::write(path("run.json"), "").unwrap();
        again("an empty record");
        std::fs::remove_file(path("steps.csv")).unwrap();
        again("no table");
        let table = std::fs::read(path("steps.csv")).unwrap();
        std::fs::write(path("steps.csv"), &table[..table.len() / 2]).unwrap();
        again("half a table");
        if format == "vtu" {
            std::fs::remove_file(path("n.pvd")).unwrap();
            again("no list");
        } else {
            let mesh = path(&first_mesh(format));
            let whole = std::fs::read(&mesh).unwrap();
            for (at, what) in [(20, "the first bytes"), (whole.len() - 90, "the last step")] {
                let mut bytes = whole.clone();
                bytes[at] ^= 1;
                std::fs::write(&mesh, bytes).unwrap();
                again(what);
            }
            std::fs::write(&mesh, &whole[..whole.len() / 2]).unwrap();
            again("half a mesh, and a record that says complete");
            for name in ["run.json", "steps.csv"] {
                std::fs::remove_file(path(name)).unwrap();
            }
            std::fs::write(&mesh, &whole[..whole.len() / 2]).unwrap();
            again("half a mesh alone");
        }
        // A part that is written again, in other seconds.
        let part = "-o out --steps 3..4 --force";
        let text = std::fs::read_to_string(path("steps_3-4.csv")).unwrap();
        deform(folder, format, part);
        if std::fs::read_to_string(path("steps_3-4.csv")).unwrap() != text {
            let run = succeed(folder, "finish out");
            assert!(!run.out.starts_with("complete already"), "{run:?}");
        }
        std::fs::remove_dir_all(out).unwrap();
    }
}

#[test]
fn the_record_of_another_run_is_replaced_by_force_only() {
    let folder = seven_steps();
    let folder = folder.path();
    for format in ["vtu", "vtkhdf"] {
        in_parts(folder, format);
        succeed(folder, "finish out");
        let other = [("sin = 10.0", "sin = 9.0")];
        rewrite(folder, "case.toml", "case.toml", &other);
        for part in PARTS {
            deform(folder, format, ["-o", "out", "--steps", part, "--force"]);
        }
        let out = folder.join("out");
        let before = left(&out);
        let run = azimesh(folder, "finish out");
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, &["schedule case.toml", "content", "--force"]);
        assert_same(&out, &before, format);
        succeed(folder, "finish out --force");
        deform(folder, format, "-o whole");
        assert_eq!(table(&out), table(&folder.join("whole")));
        let run = succeed(folder, "finish out");
        assert!(run.out.starts_with("complete already"), "{run:?}");
        rewrite(
            folder,
            "case.toml",
            "case.toml",
            &[("sin = 9.0", "sin = 10.0")],
        );
        for name in ["out", "whole"] {
            std::fs::remove_dir_all(folder.join(name)).unwrap();
        }
    }
}

/// `ulimit -f` counts kilobytes: the joined file is larger than that of any part.
#[cfg(unix)]
#[test]
fn a_join_without_room_leaves_what_was_there() {
    let folder = seven_steps();
    let folder = folder.path();
    for format in ["vtkhdf", "cgns"] {
        in_parts(folder, format);
        let out = folder.join("out");
        let name = first_mesh(format);
        let limited = |options: &str| {
            let largest = files(&out).into_iter().filter(|(file, _)| *file != name);
            let largest = largest.map(|(_, content)| content.len()).max().unwrap();
            let room = largest / 1024 + 20;
            let script = format!("ulimit -f {room} && exec \"$0\" finish out {options}");
            let program = env!("CARGO_BIN_EXE_azimesh");
            let mut shell = std::process::Command::new("bash");
            let shell = shell.current_dir(folder).args(["-c", &script, program]);
            let output = shell.output().unwrap();
            let told = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(3), "{format}: {told}");
            assert!(told.contains(&format!("{name}: ")), "{format}: {told}");
        };
        let before = left(&out);
        limited("");
        assert_same(&out, &before, "nothing under a final name");
        succeed(folder, "finish out");
        let before = left(&out);
        limited("--force");
        assert_same(&out, &before, "the old file stays");
        let run = succeed(folder, "finish out");
        assert!(run.out.starts_with("complete already"), "{run:?}");
        std::fs::remove_dir_all(out).unwrap();
    }
}

#[test]
fn a_part_with_a_lost_record_is_named_and_mended_by_resume() {
    let folder = seven_steps();
    let folder = folder.path();
    for format in ["vtu", "cgns"] {
        in_parts(folder, format);
        succeed(folder, "finish out");
        let out = folder.join("out");
        let wanted = files(&out);
        std::fs::write(out.join("run_4-7.json"), "{").unwrap();
        let run = azimesh(folder, "finish out");
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(
            &run.err,
            &["run_4-7.json: ", "record", "--steps 4..7 --resume"],
        );
        std::fs::remove_file(out.join("run_0-3.json")).unwrap();
        for part in ["4..7", "0..3"] {
            deform(folder, format, ["-o", "out", "--steps", part, "--resume"]);
        }
        let run = succeed(folder, "finish out");
        assert!(run.out.starts_with("complete already"), "{run:?}");
        for (name, content) in files(&out) {
            assert!(
                name.ends_with(".json") || wanted[&name] == content,
                "{name}"
            );
        }
        std::fs::remove_dir_all(out).unwrap();
    }
}

/// steps.csv without its seconds.
fn table(folder: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("steps.csv")).unwrap();
    text.lines().map(crate::support::without_seconds).collect()
}

#[test]
fn parts_are_joined_to_the_files_of_one_run() {
    let folder = seven_steps();
    let folder = folder.path();
    for format in ["vtu", "vtk", "vtkhdf", "cgns"] {
        deform(folder, format, "-o whole");
        in_parts(folder, format);
        let run = succeed(folder, "finish out");
        assert!(run.out.starts_with("out: 7 steps, "), "{run:?}");
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
        let args = format!("deform n.vtu case.toml --format {format} -o out --resume");
        let run = succeed(folder, &args);
        assert!(run.out.starts_with("complete already"), "{format}: {run:?}");
        succeed(folder, "finish out --force -q");
        assert!(files(&out)[&first_mesh(format)] == joined[&first_mesh(format)]);
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
    let refused = |reason: &[&str]| {
        let before = names(&folder.join("out"));
        let run = azimesh(folder, "finish out");
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, reason);
        assert_eq!(names(&folder.join("out")), before);
    };
    refused(&["out: ", "no parts"]);
    deform(folder, "vtu", "-o out --steps 0..3");
    deform(folder, "vtu", "-o out --steps 5..6");
    refused(&[
        "steps 3 to 4, 6 are missing",
        "run_0-3.json",
        "run_5-6.json",
        "--steps A..B",
    ]);
    let table = folder.join("out/steps_5-6.csv");
    let rows = std::fs::read_to_string(&table).unwrap();
    std::fs::write(&table, rows.lines().next().unwrap()).unwrap();
    refused(&[
        "steps 3 to 6 are missing",
        "run_5-6.json has not written 5",
        "--steps 5..6 --resume",
        "no part has 3 to 4, 6",
    ]);
    std::fs::write(&table, rows).unwrap();
    deform(folder, "vtu", "-o out --steps 6..7");
    deform(folder, "vtu", "-o out --steps 2..5 --force");
    refused(&["step 2", "0..3", "2..5", "remove"]);
    for name in ["steps_2-5.csv", "run_2-5.json"] {
        std::fs::remove_file(folder.join("out").join(name)).unwrap();
    }
    let rest = ["-o", "out", "--steps", "3..5", "--force"];
    deform(folder, "vtu", rest);
    let mesh = folder.join("out/n_0004.vtu");
    let content = std::fs::read(&mesh).unwrap();
    std::fs::write(&mesh, &content[1..]).unwrap();
    refused(&["step 4", "damaged"]);
    std::fs::remove_file(&mesh).unwrap();
    refused(&["step 4", "damaged"]);
    deform(folder, "vtu", "-o out --steps 3..5 --resume");
    assert!(std::fs::read(&mesh).unwrap() == content);
    rewrite(
        folder,
        "case.toml",
        "case.toml",
        &[("sin = 10.0", "sin = 9.0")],
    );
    deform(folder, "vtu", rest);
    refused(&["first part", "schedule case.toml", "content"]);
    std::fs::rename(folder.join("case.toml"), folder.join("other.toml")).unwrap();
    let args = ["deform", "n.vtu", "other.toml", "-q", "--format", "vtu"];
    succeed(folder, [&args[..], &rest].concat());
    refused(&["first part", "schedule", "other.toml", "case.toml"]);
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
    let run = azimesh(folder, "finish out");
    assert!(
        run.code == 2 && run.err.contains("step 6 is damaged"),
        "{run:?}"
    );
    deform(folder, "vtkhdf", "-o out --steps 4..7 --resume");
    succeed(folder, "finish out");
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
        deform(folder, format, "-o out --steps 0..4");
        let before = names(&folder.join("out"));
        let args = ["deform", "n.vtu", "case.toml", "--format", format, option];
        let part = ["-o", "out", "--steps", "3..6"];
        let run = azimesh(folder, [&args[..], &part].concat());
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["3..6", "0..4", "run_0-4.json"]);
        assert_eq!(names(&folder.join("out")), before);
        deform(folder, format, "-o out --steps 4..7");
        succeed(folder, "finish out -q");
        std::fs::remove_dir_all(folder.join("out")).unwrap();
    }
}
