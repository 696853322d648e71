//! The exit code of every command for every class of ending: 0 done, 1 a check failed, 2 wrong
//! arguments or input, 3 the system failed.

use crate::support::{Args, airfoil, azimesh, json, short, succeed};
use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

/// A folder with `n.vtu`, `n.toml`, `moved.vtu`, and schedules that fail checks.
fn folder() -> tempfile::TempDir {
    let folder = short();
    let path = folder.path();
    let strict = "\n[selection]\ntolerance = 1e-12\nmax_points = 4\n";
    let text = std::fs::read_to_string(path.join("few.toml")).unwrap();
    let text = text.split("[selection]").next().unwrap().to_owned();
    std::fs::write(path.join("missed.toml"), text + strict).unwrap();
    let args = "convert n.vtu moved.vtu --scale 2";
    succeed(path, args);
    folder
}

#[test]
fn what_is_done_ends_with_0() {
    let folder = folder();
    for args in [
        "info n.vtu",
        "convert n.vtu c.su2",
        "quality n.vtu",
        "check n.vtu few.toml",
        "select n.vtu few.toml -o b.toml",
        "deform n.vtu few.toml -o out",
        "diff n.vtu c.su2",
        "sample block -o s.vtu",
        "completions bash",
        "man",
        "man -o pages",
        "help",
        "--version",
    ] {
        let run = azimesh(folder.path(), args);
        assert_eq!(run.code, 0, "{args:?}: {run:?}");
    }
}

#[test]
fn a_check_that_failed_ends_with_1() {
    let folder = folder();
    for args in [
        "quality n.vtu --fail-on max_edge_ratio>1",
        "select n.vtu missed.toml -o b.toml",
        "deform n.vtu missed.toml -o missed",
        "deform n.vtu few.toml -o out --fail-on max_edge_ratio>1",
        "diff n.vtu moved.vtu",
        "diff --match position n.vtu moved.vtu",
    ] {
        let run = azimesh(folder.path(), args);
        assert_eq!(run.code, 1, "{args:?}: {run:?}");
    }
}

#[test]
fn wrong_arguments_and_wrong_input_end_with_2_and_a_sentence() {
    let folder = folder();
    std::fs::write(folder.path().join("no.vtu"), "nothing of a mesh").unwrap();
    for args in [
        "info missing.vtu",
        "info no.vtu",
        "convert n.vtu",
        "convert n.vtu x.unknown",
        "convert n.vtu - --format su2 --json",
        "quality n.vtu --fail-on nothing>1",
        "check n.vtu missing.toml",
        "select n.vtu no.vtu -o b.toml",
        "deform no.vtu few.toml -o out",
        "deform n.vtu few.toml -o out --max-memory 1M",
        "deform n.vtu few.toml -o out --max-memory much",
        "diff n.vtu missing.vtu",
        "diff n.vtu n.vtu --tolerance -1",
        "diff n.vtu n.vtu --match-tolerance 1",
        "sample block -o x.unknown",
        "sample cube -o x.vtu",
        "sample block -o - --format su2 --json",
        "completions sh",
        "man --threads 0",
        "nonsense",
        "",
    ] {
        let run = azimesh(folder.path(), args);
        assert_eq!(run.code, 2, "{args:?}: {run:?}");
        let is_told = run.out.is_empty() != args.contains("--json");
        assert!(is_told && !run.err.is_empty(), "{args:?}: {run:?}");
    }
    assert!(!folder.path().join("out").exists());
}

/// Runs the program with its standard output on a full device.
#[cfg(target_os = "linux")]
fn into_the_full(folder: &Path, args: impl Args) -> Option<i32> {
    let full = File::create("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_azimesh"));
    let output = command
        .current_dir(folder)
        .args(args.words())
        .stdout(full)
        .output();
    let output = output.unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("No space left on device"), "{args:?}: {said}");
    output.status.code()
}

#[test]
#[cfg(target_os = "linux")]
fn a_failure_of_the_system_ends_with_3() {
    let folder = folder();
    for args in [
        "info n.vtu",
        "convert n.vtu - --format su2",
        "quality n.vtu",
        "check n.vtu few.toml",
        "select n.vtu few.toml -o b.toml",
        "deform n.vtu few.toml -o out",
        "diff n.vtu n.vtu",
        "sample block -o - --format su2",
        "completions zsh",
        "man",
    ] {
        assert_eq!(into_the_full(folder.path(), args), Some(3), "{args:?}");
    }
}

#[test]
fn a_command_that_fails_prints_its_error_as_json() {
    let folder = airfoil();
    let folder = folder.path();
    fs::write(folder.join("bad.su2"), "NDIME= 2\nNELEM= x\n").unwrap();
    let error = |args: &str| {
        assert_eq!(azimesh(folder, args).code, 2, "{args:?}");
        let told = json(folder, args);
        assert_eq!(told["version"], 1, "{told}");
        told["error"].clone()
    };
    let found = error("info bad.su2");
    let place = (&found["kind"], &found["path"], &found["line"]);
    assert_eq!(place, (&"input".into(), &"bad.su2".into(), &2.into()));
    let convert = "convert n.vtu bad.su2 -o out --format msh";
    assert_eq!(error(convert)["path"], "bad.su2");
    let found = error("info --wrong");
    let text = found["text"].as_str().unwrap();
    assert!(text.starts_with("unexpected argument '--wrong'"), "{found}");
    let several = json(folder, "info n.vtu bad.su2");
    assert_eq!(several["meshes"][0]["file"], "n.vtu");
    assert_eq!(several["errors"][0]["line"], 2);
}

#[test]
fn the_command_of_a_report_is_the_one_that_was_given() {
    let folder = airfoil();
    let folder = folder.path();
    let args = [
        "-q",
        "deform",
        "n.vtu",
        "n.toml",
        "-o",
        "out",
        "--keep-going",
        "--steps",
        "0..2",
    ];
    assert_eq!(azimesh(folder, args).code, 0);
    succeed(folder, "report out");
    let html = fs::read_to_string(folder.join("out/report.html")).unwrap();
    let shown = format!("azimesh {}", args.join(" "));
    assert!(html.contains(&shown), "{shown}");
    let note = json(folder, "report out --force")["diagnostics"].to_string();
    let command = "azimesh deform n.vtu n.toml -o out --keep-going --steps 2..37";
    assert!(note.contains(command), "{note}");
}
