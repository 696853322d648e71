//! What run.json and the program tell of a run that was gone on with, of what was not judged, and of what
//! a format cannot hold.

use crate::support::{Args, Run, airfoil, assert_says, azimesh, files, json, rewrite};
use serde_json::Value;
use std::path::Path;

/// `case.toml`: a pitching airfoil in seven steps, with more lines in some sections.
fn case(folder: &Path, changes: &[(&str, &str)]) {
    let all = [&[("step = 10.0", "step = 60.0")], changes].concat();
    rewrite(folder, "n.toml", "case.toml", &all);
}

fn deform(folder: &Path, options: impl Args) -> Run {
    let args = ["deform", "n.vtu", "case.toml", "-o", "out"];
    azimesh(folder, [&args[..], &options.words()].concat())
}

fn record(folder: &Path) -> Value {
    let text = std::fs::read(folder.join("out/run.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

#[test]
fn a_run_gone_on_with_keeps_what_is_known_of_it() {
    let folder = airfoil();
    let folder = folder.path();
    let substeps = ("[rbf]", "[output]\non_inverted = \"substeps\"\n[rbf]");
    case(folder, &[("sin = 10.0", "sin = 170.0"), substeps]);
    let first = deform(folder, "--fail-on max_skew>0.1");
    assert_eq!(first.code, 1, "{first:?}");
    let then = record(folder);
    assert!(!then["repairs"].as_array().unwrap().is_empty());
    assert!(!then["failures"].as_array().unwrap().is_empty());
    let same = |now: &Value| {
        for key in [
            "repairs",
            "failures",
            "fail_on",
            "selections",
            "options",
            "motion",
            "base_files",
        ] {
            // As texts: not even the last digit of a number changes.
            assert_eq!(now[key].to_string(), then[key].to_string(), "{key}");
        }
    };
    let again = deform(folder, "--resume");
    assert_eq!(again.code, 1, "the exit code that the run had: {again:?}");
    let now = record(folder);
    same(&now);
    for repair in then["repairs"].as_array().unwrap() {
        let told = repair["sentence"].as_str().unwrap();
        assert!(again.err.contains(told), "{told}: {again:?}");
    }
    let seconds = |of: &Value, stage: &str| of["seconds"][stage].as_f64().unwrap();
    for stage in ["selection", "modes", "steps", "writing"] {
        assert_eq!(seconds(&now, stage), seconds(&then, stage), "{stage}");
    }
    assert!(seconds(&now, "total") > seconds(&then, "total"));
    std::fs::remove_file(folder.join("out/n_0005.vtu")).unwrap();
    assert_eq!(deform(folder, "--resume").code, 1);
    same(&record(folder));
    assert!(seconds(&record(folder), "steps") > seconds(&then, "steps"));
    // Other conditions take the place of those.
    let lenient = deform(folder, "--resume --fail-on max_skew>10");
    let now = record(folder);
    assert_eq!(now["failures"], serde_json::json!([]), "{lenient:?}");
    assert_eq!(now["fail_on"], serde_json::json!(["max_skew>10"]));
}

#[test]
fn base_points_of_a_complete_run_are_restored() {
    let folder = airfoil();
    let folder = folder.path();
    let real = "[selection]\nmethod = \"real\"\nrefresh = 120.0";
    for selection in ["[selection]", real] {
        case(folder, &[("[selection]", selection)]);
        assert_eq!(deform(folder, "--force").code, 0);
        let then = files(&folder.join("out"));
        let bases: Vec<&String> = then
            .keys()
            .filter(|name| name.starts_with("base"))
            .collect();
        assert!(
            bases.len() == if selection == real { 8 } else { 2 },
            "{bases:?}"
        );
        for (at, name) in bases.iter().enumerate() {
            let path = folder.join("out").join(name);
            match at % 2 {
                0 => std::fs::remove_file(&path).unwrap(),
                _ => std::fs::write(&path, "junk").unwrap(),
            }
            let run = deform(folder, "--resume");
            assert_eq!(run.code, 0, "{name}: {run:?}");
            assert!(
                run.err.contains(&format!("warning: {name} ")),
                "{name}: {run:?}"
            );
            assert!(run.out.starts_with("complete already"), "{name}: {run:?}");
            let now = files(&folder.join("out"));
            for (name, content) in then.iter().filter(|(name, _)| *name != "run.json") {
                assert!(now[name] == *content, "{name}");
            }
        }
    }
}

#[test]
fn cells_that_were_not_judged_are_not_called_sound() {
    let folder = airfoil();
    let folder = folder.path();
    let none = ("[rbf]", "[output]\nquality = \"none\"\n[rbf]");
    case(folder, &[none]);
    let run = deform(folder, []);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.out.contains("cell quality was not computed"), "{run:?}");
    assert!(!run.out.contains("inverted"), "{run:?}");
    assert_eq!(record(folder)["inverted_steps"], Value::Null);
    let args = "deform n.vtu case.toml -o out --force";
    let told = json(folder, args);
    let told = (&told["inverted_steps"], &told["max_inverted"]);
    assert_eq!(told, (&Value::Null, &Value::Null));
}

#[test]
fn what_a_format_cannot_hold_is_told_once_a_run() {
    let folder = airfoil();
    let folder = folder.path();
    let output = "[output]\ndisplacement = true\nencoding = \"base64\"\n[rbf]";
    case(folder, &[("[rbf]", output)]);
    for (format, about, told) in [
        (
            "vtk",
            "encoding",
            "output.encoding has no effect on files of format = \"vtk\"",
        ),
        (
            "su2",
            "arrays",
            "output.format = \"su2\" holds no arrays: displacement is left out",
        ),
    ] {
        let run = deform(folder, ["--force", "--format", format]);
        assert_eq!(run.code, 0, "{format}: {run:?}");
        let warnings = record(folder)["diagnostics"].clone();
        let warnings = warnings.as_array().unwrap().iter();
        let warnings = warnings.map(|warning| warning["text"].as_str().unwrap());
        let about = warnings.filter(|warning| warning.contains(about));
        assert_eq!(about.collect::<Vec<_>>(), [told], "{format}");
        assert_eq!(run.err.matches(told).count(), 1, "{format}: {run:?}");
    }
    // MSH holds them.
    let run = deform(folder, "--force --format msh");
    assert!(!run.err.contains("arrays"), "{run:?}");
    let mesh = files(&folder.join("out"))["n_0006.msh"].clone();
    assert!(String::from_utf8_lossy(&mesh).contains("\"Displacement\""));
}

#[test]
fn conditions_that_are_lost_with_a_record_are_said_to_be() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[]);
    assert_eq!(deform(folder, "--fail-on max_skew>0.1").code, 1);
    let then = record(folder);
    std::fs::write(folder.join("out/run.json"), "{\n").unwrap();
    let run = deform(folder, "--resume");
    assert_eq!(run.code, 0, "{run:?}");
    assert_says(&run.err, &["warning: ", "run.json is damaged"]);
    assert_says(&run.err, &["--fail-on", "lost"]);
    let now = record(folder);
    for key in [
        "inputs",
        "options",
        "selections",
        "base_files",
        "steps_written",
    ] {
        assert_eq!(now[key], then[key], "{key}");
    }
    assert_eq!(
        (&now["outcome"], &now["steps_kept"]),
        (&"complete".into(), &7.into())
    );
}

/// `ulimit -f` counts kilobytes.
#[cfg(unix)]
#[test]
fn a_limit_on_the_size_of_files_is_the_systems_failure() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[]);
    let limited = "ulimit -f 24 && exec \"$0\" deform n.vtu case.toml -o out";
    let output = std::process::Command::new("bash")
        .current_dir(folder)
        .args(["-c", limited, env!("CARGO_BIN_EXE_azimesh")])
        .output()
        .unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("File too large"), "{told}");
    assert_eq!(deform(folder, "--resume").code, 0);
}
