//! The scripts of docs/examples, with Slurm's variables set by hand: a step with inverted cells keeps nothing
//! from being joined, and a signal reaches the run.

use crate::support::{airfoil, assert_says, azimesh, files, names, rewrite, succeed};
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

const STEPS: usize = 7;

/// A folder with `case.toml`, of whose steps the fourth has inverted cells, and its `base.toml`.
fn inverted_in_one_step() -> tempfile::TempDir {
    let folder = airfoil();
    let text = std::fs::read_to_string(folder.path().join("n.toml")).unwrap();
    let (head, rest) = text.split_once("[azimuth]").unwrap();
    let (_, rest) = rest.split_once("step = 10.0").unwrap();
    let values = "[azimuth]\nvalues = [0.0, 2.0, 4.0, 90.0, 176.0, 178.0, 180.0]";
    std::fs::write(
        folder.path().join("n.toml"),
        format!("{head}{values}{rest}"),
    )
    .unwrap();
    let warn = ("[rbf]", "[output]\non_inverted = \"warn\"\n[rbf]");
    let far = [("sin = 10.0", "sin = 170.0"), warn];
    rewrite(folder.path(), "n.toml", "case.toml", &far);
    let select = "-q select n.vtu case.toml -o base.toml";
    succeed(folder.path(), select);
    folder
}

/// A script of the docs with azimesh in its path.
fn script(folder: &Path, name: &str, more: &[&str]) -> Command {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/examples");
    let program = Path::new(env!("CARGO_BIN_EXE_azimesh"));
    let path = std::env::var("PATH").unwrap();
    let mut command = Command::new("bash");
    command
        .current_dir(folder)
        .env(
            "PATH",
            format!("{}:{path}", program.parent().unwrap().display()),
        )
        .arg(examples.join(name))
        .args(["n.vtu", "case.toml", "base.toml"])
        .args(more);
    command
}

fn task(folder: &Path, out: &str, task: usize, tasks: usize) -> Command {
    let mut command = script(folder, "slurm_array.sh", &[out]);
    command
        .env("SLURM_ARRAY_TASK_ID", task.to_string())
        .env("SLURM_ARRAY_TASK_MIN", "0")
        .env("SLURM_ARRAY_TASK_COUNT", tasks.to_string());
    command
}

fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

fn assert_all_there(folder: &Path, out: &str) {
    let names = names(&folder.join(out));
    let meshes = names.iter().filter(|name| name.ends_with(".vtu")).count();
    assert_eq!(meshes, STEPS, "{names:?}");
    assert!(names.contains(&"n.pvd".to_owned()), "{names:?}");
    let record = std::fs::read_to_string(folder.join(out).join("run.json")).unwrap();
    assert!(record.contains("\"inverted_steps\": 1"), "{record}");
}

#[test]
fn a_task_with_inverted_cells_is_finished_and_the_joined_sequence_tells() {
    let folder = inverted_in_one_step();
    let folder = folder.path();
    for again in [false, true] {
        for index in [1, 2, 0] {
            let output = task(folder, "out", index, 3).output().unwrap();
            assert_eq!(code(&output), Some(0), "{output:?}");
            let told = String::from_utf8(output.stderr).unwrap();
            assert_eq!(told.contains("a check failed"), index == 1, "{told}");
        }
        let run = azimesh(folder, "finish out");
        assert_eq!(run.code, 1, "{run:?}");
        assert_eq!(run.out.starts_with("complete already"), again, "{run:?}");
        assert_all_there(folder, "out");
    }
    // Other failures stay failures.
    let output = task(folder, "out/run.json", 1, 3).output().unwrap();
    assert_eq!(code(&output), Some(2), "{output:?}");
}

#[test]
fn a_signal_for_a_task_reaches_the_run() {
    let folder = airfoil();
    let folder = folder.path();
    rewrite(
        folder,
        "n.toml",
        "case.toml",
        &[("step = 10.0", "step = 0.25")],
    );
    let select = "-q select n.vtu case.toml -o base.toml";
    succeed(folder, select);
    let mut child = task(folder, "out", 0, 2)
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let table = folder.join("out/steps_0-720.csv");
    let rows = || std::fs::read_to_string(&table).map_or(0, |text| text.lines().count());
    while rows() < 3 {
        std::thread::sleep(Duration::from_millis(1));
    }
    let asked = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status();
    assert!(asked.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    let record = &files(&folder.join("out"))["run_0-720.json"];
    let record = String::from_utf8_lossy(record);
    assert_says(&record, &["interrupted"]);
    assert!(rows() < 721, "it was ended before its last step");
}

#[test]
fn parts_side_by_side_are_joined_whatever_cells_are_inverted() {
    let there = Command::new("parallel").arg("--version").output();
    if !there.is_ok_and(|output| output.stdout.starts_with(b"GNU")) {
        eprintln!("GNU parallel is not installed: its script is not run");
        return;
    }
    let folder = inverted_in_one_step();
    let folder = folder.path();
    for _ in 0..2 {
        let output = script(folder, "gnu_parallel.sh", &["side by side", "3"])
            .output()
            .unwrap();
        assert_eq!(code(&output), Some(1), "{output:?}");
        assert_all_there(folder, "side by side");
    }
    // Other failures stay failures, and nothing is joined.
    std::fs::write(folder.join("out"), "a file").unwrap();
    let output = script(folder, "gnu_parallel.sh", &["out", "3"])
        .output()
        .unwrap();
    assert_eq!(code(&output), Some(2), "{output:?}");
}
