//! Pipes and links under names that the program opens.

use crate::support::{Args, assert_says, names, short, succeed};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

/// Runs the program, which must end soon.
fn ended(folder: &Path, args: impl Args) -> Output {
    let mut command = assert_cmd::Command::cargo_bin("azimesh").unwrap();
    let command = command.current_dir(folder).args(args.words());
    command.timeout(Duration::from_secs(60)).output().unwrap()
}

fn make_pipe(path: &Path) {
    let _ = fs::remove_file(path);
    let made = Command::new("mkfifo").arg(path).status().unwrap();
    assert!(made.success());
}

/// Copies a folder of files.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for name in names(from) {
        fs::copy(from.join(&name), to.join(&name)).unwrap();
    }
}

#[test]
fn a_pipe_under_the_name_of_a_file_of_a_run_is_refused() {
    let folder = short();
    let run = "-q deform n.vtu few.toml -o";
    succeed(folder.path(), format!("{run} whole"));
    for steps in ["0..2", "2..5"] {
        succeed(folder.path(), format!("{run} parts --steps {steps}"));
    }
    let resumed = ["deform", "n.vtu", "few.toml", "-o", "o", "--resume"];
    let part = ["deform", "n.vtu", "few.toml", "-o", "o", "--steps", "4..5"];
    let (joined, page) = (["finish", "o"], ["report", "o", "-o", "page.html"]);
    for (of, pipe, args, code) in [
        ("whole", ".azimesh_0-5.lock", &resumed[..], 2),
        ("whole", "base.toml", &resumed, 2),
        ("whole", "base.vtp", &resumed, 2),
        ("whole", "n.pvd", &resumed, 2),
        ("whole", "n_0003.vtu", &resumed, 2),
        ("whole", "n_0003.vtu", &page, 0),
        ("empty", "base.toml", &part, 2),
        ("parts", ".azimesh_0-5.lock", &joined, 2),
        ("parts", "n_0003.vtu", &joined, 2),
        ("parts", "n.pvd", &joined, 2),
        ("parts", "steps.csv", &joined, 2),
    ] {
        let (from, to) = (folder.path().join(of), folder.path().join("o"));
        let _ = fs::create_dir(folder.path().join("empty"));
        let _ = fs::remove_dir_all(&to);
        copy(&from, &to);
        make_pipe(&to.join(pipe));
        let before = names(&to);
        let found = ended(folder.path(), args);
        let told = String::from_utf8(found.stderr).unwrap();
        assert_eq!(found.status.code(), Some(code), "{pipe} {args:?}: {told}");
        if code == 2 {
            assert_says(&told, &[&format!("o/{pipe}"), "pipe"]);
            assert_eq!(names(&to), before, "{pipe} {args:?}");
        }
    }
}

#[test]
fn a_pipe_under_the_name_of_a_companion_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Path::new("testdata/sphere_in_box_raw.vtu").canonicalize();
    let mesh = mesh.unwrap();
    make_pipe(&folder.path().join("b.mapbc"));
    let args = ["convert", mesh.to_str().unwrap(), "b.b8.ugrid"];
    let found = ended(folder.path(), args);
    let told = String::from_utf8(found.stderr).unwrap();
    assert_eq!(found.status.code(), Some(2), "{told}");
    assert_says(&told, &["b.mapbc", "pipe"]);
    assert!(!folder.path().join("b.b8.ugrid").exists());
}

#[test]
fn a_link_in_place_of_a_lock_file_is_refused_and_makes_no_file() {
    let folder = short();
    let output = folder.path().join("o");
    fs::create_dir(&output).unwrap();
    let lock = output.join(".azimesh_0-5.lock");
    for aim in ["elsewhere", "n.vtu"] {
        let aim = folder.path().join(aim);
        let was_there = aim.exists();
        symlink(&aim, &lock).unwrap();
        let found = ended(folder.path(), "deform n.vtu few.toml -o o");
        let told = String::from_utf8(found.stderr).unwrap();
        assert_eq!(found.status.code(), Some(2), "{told}");
        assert_says(&told, &["o/.azimesh_0-5.lock", "link"]);
        assert_eq!(aim.exists(), was_there);
        fs::remove_file(&lock).unwrap();
    }
}

/// Runs the program under a limit of `ulimit`.
fn limited(folder: &Path, limit: &str, args: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_azimesh");
    let command = format!("ulimit {limit} && exec {program} {args}");
    let mut shell = Command::new("sh");
    let shell = shell.current_dir(folder).args(["-c", &command]);
    shell.output().unwrap()
}

#[test]
fn a_staged_folder_is_removed_where_no_more_files_can_be_opened() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "-q sample block -o b.vtu");
    let before = names(folder.path());
    let args = "-q --threads 1 convert b.vtu x.pvtu --pieces 5";
    let found = (4..16).map(|n| limited(folder.path(), &format!("-n {n}"), args));
    let failed = found.filter(|found| found.status.code() == Some(3));
    let n_failed = failed
        .map(|_| assert_eq!(names(folder.path()), before))
        .count();
    assert!(n_failed > 2, "{n_failed}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_small_stack_is_enough() {
    let folder = tempfile::tempdir().unwrap();
    let sample = limited(folder.path(), "-s 256", "-q sample naca0012 -o n.vtu");
    assert!(sample.status.success(), "{sample:?}");
    let checked = limited(folder.path(), "-s 256", "check n.vtu n.toml");
    assert!(checked.status.success(), "{checked:?}");
}
