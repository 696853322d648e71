//! `deform --max-memory` with less than a run needs: large arrays lie in files, and nothing else differs.

use crate::support::{Args, Run, assert_says, files, names, rewrite, succeed, without_seconds};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// The least memory that a run with arrays in files may have.
const LIMIT: &str = "64M";

/// A mesh that needs more than that, with two steps.
fn large() -> TempDir {
    of_nodes("250000")
}

fn of_nodes(n: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = format!("-q sample naca0012 --nodes {n} -o");
    succeed(path, format!("{sample} n.vtu"));
    let few = [
        ("stop = 360.0", "stop = 120.0"),
        ("step = 10.0", "step = 120.0"),
    ];
    rewrite(path, "n.toml", "few.toml", &few);
    folder
}

/// The files of a run, without what differs between any two.
fn result(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let of_result = |(name, bytes): (String, Vec<u8>)| match name.as_str() {
        "run.json" => None,
        "steps.csv" => {
            let text = String::from_utf8(bytes).unwrap();
            let rows: Vec<String> = text.lines().map(without_seconds).collect();
            Some((name, rows.concat().into_bytes()))
        }
        _ => Some((name, bytes)),
    };
    files(folder).into_iter().filter_map(of_result).collect()
}

fn assert_in_files(run: &Run) {
    assert_says(&run.err, &["--max-memory", "files without a name"]);
    let most = run
        .err
        .lines()
        .find_map(|line| line.strip_prefix("in files at most: "));
    assert!(most.is_some_and(|most| most.ends_with(" MB")), "{run:?}");
}

#[test]
fn a_run_with_arrays_in_files_leaves_the_same_bytes() {
    let folder = large();
    let path = folder.path();
    for format in ["vtu", "vtkhdf", "cgns"] {
        let deform = ["deform", "n.vtu", "few.toml", "--format", format, "-o"];
        succeed(path, [&deform[..], &["whole"]].concat());
        let limited = [&deform[..], &["limited", "-v", "--max-memory", LIMIT]].concat();
        assert_in_files(&succeed(path, &limited));
        let [whole, limited] = ["whole", "limited"].map(|name| result(&path.join(name)));
        assert!(whole.len() > 2, "{format}");
        assert!(whole == limited, "{format}");
        for run in ["whole", "limited"] {
            fs::remove_dir_all(path.join(run)).unwrap();
        }
    }
    let left = names(path);
    assert!(!left.iter().any(|name| name.starts_with('.')), "{left:?}");
}

#[test]
fn parts_with_arrays_in_files_are_joined_with_others() {
    let folder = large();
    let path = folder.path();
    let deform = ["deform", "n.vtu", "few.toml", "-o"];
    succeed(path, [&deform[..], &["whole"]].concat());
    succeed(path, [&deform[..], &["part", "--steps", "0..1"]].concat());
    let part = ["part", "--steps", "1..2", "-v", "--max-memory", LIMIT];
    assert_in_files(&succeed(path, [&deform[..], &part].concat()));
    succeed(path, "finish part");
    let meshes = |folder: &str| {
        let all = result(&path.join(folder));
        all.into_iter()
            .filter(|(name, _)| name.ends_with(".vtu"))
            .collect::<Vec<_>>()
    };
    assert_eq!(meshes("whole").len(), 2);
    assert!(meshes("whole") == meshes("part"));
}

/// The most bytes that a run had in memory, as the system counts them.
fn peak(folder: &Path, args: impl Args) -> usize {
    let mut run = Command::new(assert_cmd::cargo::cargo_bin("azimesh"))
        .current_dir(folder)
        .args(args.words())
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", run.id());
    let mut peak = 0;
    loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let found = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse().ok());
        peak = found.unwrap_or(0).max(peak);
        if let Some(ended) = run.try_wait().unwrap() {
            assert!(ended.success());
            return 1024 * peak;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

#[test]
fn resident_memory_keeps_to_the_limit() {
    let folder = of_nodes("1000000");
    let deform = ["deform", "n.vtu", "few.toml", "-q", "--force", "-o", "out"];
    let whole = peak(folder.path(), deform);
    let limited = [&deform[..], &["--max-memory", LIMIT]].concat();
    // A little more may be there between two looks, and on a busy machine they may be late.
    let most = (64 << 20) / 2 * 3;
    let mut peaks = (0..3).map(|_| peak(folder.path(), &limited));
    assert!(whole > most / 2 * 3, "{whole} bytes without a limit");
    assert!(peaks.any(|peak| peak <= most), "{whole} without a limit");
}

#[test]
fn a_mesh_is_converted_with_arrays_in_files_to_the_same_bytes() {
    let folder = large();
    let path = folder.path();
    let convert = "convert n.vtu --reorder -v";
    succeed(path, format!("{convert} whole.cgns"));
    let run = succeed(path, format!("{convert} limited.cgns --max-memory 16M"));
    assert_says(&run.err, &["in files at most", "MB"]);
    let [whole, limited] =
        ["whole", "limited"].map(|name| fs::read(path.join(name).with_extension("cgns")).unwrap());
    assert!(whole == limited);
}
