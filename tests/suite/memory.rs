//! Memory that cannot be had, or that may not be taken, in every command that reads meshes; and inputs that
//! have no end.

use crate::support::{Args, Run, assert_says, azimesh, files, names, rewrite, succeed};
use flate2::{Compression, write::GzEncoder};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Runs the program with so many kB of addresses.
fn limited(folder: &Path, limit: usize, args: impl Args) -> std::process::Output {
    Command::new("sh")
        .current_dir(folder)
        .args(["-c", "ulimit -v $0 && exec \"$@\""])
        .arg(limit.to_string())
        .arg(assert_cmd::cargo::cargo_bin("azimesh"))
        .args(args.words())
        .output()
        .unwrap()
}

/// The least kB of addresses with which the system can start the program at all.
fn least() -> usize {
    let starts = |limit| {
        let output = limited(Path::new("."), limit, "--version");
        output.status.code() == Some(0)
    };
    let (mut few, mut enough) = (1, 1 << 20);
    while enough - few > 200 {
        let middle = (few + enough) / 2;
        if starts(middle) {
            enough = middle
        } else {
            few = middle
        }
    }
    enough
}

/// A mesh of a few megabytes as `n.vtu`, `n.toml`, and a finished run of it in `done`.
fn meshes() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let sample = "-q sample naca0012 --nodes 20000 -o";
    succeed(path, format!("{sample} n.vtu"));
    let few = [
        ("stop = 360.0", "stop = 90.0"),
        ("step = 10.0", "step = 45.0"),
    ];
    rewrite(path, "n.toml", "few.toml", &few);
    succeed(path, "deform -q n.vtu few.toml -o done");
    folder
}

/// Every command that reads meshes or makes one, with what it writes.
const COMMANDS: [(&[&str], &str); 9] = [
    (&["info", "n.vtu"], ""),
    (&["convert", "n.vtu", "out", "--format", "su2"], "out"),
    (&["quality", "n.vtu", "--reference", "n.vtu"], ""),
    (&["check", "n.vtu", "few.toml"], ""),
    (&["select", "n.vtu", "few.toml", "-o", "out"], "out"),
    (&["deform", "n.vtu", "few.toml", "-o", "out"], "out"),
    (&["diff", "n.vtu", "n.vtu"], ""),
    (&["report", "done", "-o", "out"], "out"),
    (
        &[
            "sample", "naca0012", "--nodes", "20000", "-o", "out", "--format", "vtu",
        ],
        "out",
    ),
];

fn remove_output(folder: &Path) {
    let out = folder.join("out");
    let _ = fs::remove_dir_all(&out);
    let _ = fs::remove_file(&out);
    for ending in ["toml", "vtp"] {
        let _ = fs::remove_file(out.with_extension(ending));
    }
}

/// Nothing hidden is there, nor half of anything.
fn assert_whole(folder: &Path, command: &str, output: &str, code: i32) {
    let mut found = names(folder);
    let out = folder.join("out");
    if command == "deform" && out.is_dir() {
        let whole = files(&folder.join("done"));
        for (name, mesh) in files(&out)
            .into_iter()
            .filter(|(name, _)| name.ends_with(".vtu"))
        {
            assert!(whole[&name] == mesh, "{name} is not whole");
        }
        found.extend(names(&out));
    } else if code != 0 {
        assert!(!out.exists(), "{command} failed and wrote {output}");
    }
    assert!(!found.iter().any(|name| name.starts_with('.')), "{found:?}");
}

#[test]
fn memory_that_cannot_be_had_ends_every_command_with_code_3_and_a_sentence() {
    let folder = meshes();
    let path = folder.path();
    let least = least();
    let mut n_refused = 0;
    for (args, output) in COMMANDS {
        for more in [
            0, 500, 1000, 3000, 5000, 6000, 7000, 8000, 9000, 11_000, 14_000, 20_000, 40_000,
        ] {
            remove_output(path);
            let run = limited(path, least + more, args);
            let said = String::from_utf8(run.stderr).unwrap();
            let what = format!("{args:?} {more}: {:?} {said}", run.status);
            let code = run.status.code().unwrap_or_else(|| panic!("{what}"));
            assert!(code == 0 || code == 3, "{what}");
            if code == 3 {
                n_refused += 1;
                assert!(said.starts_with("error: "), "{what}");
                assert_eq!(said.lines().count(), 1, "{what}");
            }
            assert_whole(path, args[0], output, code);
        }
    }
    assert!(n_refused > 20, "{n_refused}");
}

#[test]
fn every_command_keeps_to_max_memory() {
    let folder = meshes();
    let path = folder.path();
    for (args, output) in COMMANDS {
        let run = azimesh(path, [args, &["--max-memory", "500k"]].concat());
        if args[0] == "convert" && run.code == 0 {
            // Its arrays lie in files, where the disk can hold them so.
            let limited = files(path);
            remove_output(path);
            succeed(path, [args, &["-q"]].concat());
            assert!(files(path) == limited, "{args:?}");
            remove_output(path);
            continue;
        }
        // So do those of deform, which refuses as little as that once the mesh is read.
        let (code, bytes) = match (args[0], run.code) {
            ("deform", 2) => (2, "512 kB"),
            _ => (3, "512000"),
        };
        assert_eq!(run.code, code, "{args:?} {run:?}");
        assert_says(&run.err, &["error: ", "memory", "--max-memory", bytes]);
        assert_eq!(run.err.lines().count(), 1, "{run:?}");
        assert_whole(path, args[0], output, code);
        succeed(path, [args, &["-q", "--max-memory", "500M"]].concat());
        remove_output(path);
    }
}

#[test]
fn a_sequence_says_at_which_file_memory_ran_out() {
    let folder = meshes();
    let run = azimesh(folder.path(), "info n.vtu --max-memory 500k");
    assert!(run.err.ends_with("(reading n.vtu)\n"), "{run:?}");
}

/// A file in SU2's format that goes on with so many megabytes of blanks.
fn bomb(megabytes: usize) -> Vec<u8> {
    let mut file = GzEncoder::new(Vec::new(), Compression::fast());
    file.write_all(b"NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\n")
        .unwrap();
    for _ in 0..megabytes {
        file.write_all(&[b' '; 1 << 20]).unwrap();
    }
    file.finish().unwrap()
}

#[test]
fn what_a_small_file_unpacks_to_is_limited() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("bomb.su2"), bomb(40)).unwrap();
    succeed(path, "info bomb.su2 --max-memory 100M");
    for args in ["info bomb.su2", "convert bomb.su2 out.vtu"] {
        let run = azimesh(path, format!("{args} --max-memory 10M"));
        assert_eq!(run.code, 3, "{run:?}");
        assert_says(&run.err, &["bomb.su2", "--max-memory"]);
        assert_eq!(run.err.lines().count(), 1, "{run:?}");
    }
    let most = limited(path, least() + 30_000, "info bomb.su2 --max-memory 10M");
    let said = String::from_utf8(most.stderr).unwrap();
    assert!(
        said.contains("--max-memory"),
        "it takes no more than it may: {said}"
    );
}

#[test]
fn a_pipe_without_end_is_refused_at_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = assert_cmd::Command::cargo_bin("azimesh").unwrap();
    command.current_dir(folder.path());
    command.args(["info", "-", "--max-memory", "20M"]);
    let run = command.write_stdin(vec![b' '; 30 << 20]).output().unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(3), "{said}");
    assert_says(&said, &["--max-memory"]);
}

/// Runs the program, which must end by itself within a minute.
fn ends(folder: &Path, args: impl Args) -> Run {
    let mut command = assert_cmd::Command::cargo_bin("azimesh").unwrap();
    let run = command.current_dir(folder).args(args.words());
    let run = run
        .timeout(std::time::Duration::from_secs(60))
        .output()
        .unwrap();
    Run {
        code: run.status.code().unwrap_or(-1),
        out: String::from_utf8(run.stdout).unwrap(),
        err: String::from_utf8(run.stderr).unwrap(),
    }
}

#[test]
fn a_device_is_no_mesh_no_schedule_and_no_base() {
    let folder = crate::support::short();
    let path = folder.path();
    for args in [
        "info /dev/zero",
        "check n.vtu /dev/zero",
        "deform n.vtu few.toml -o out --base /dev/zero",
        "quality n.vtu --reference /dev/zero",
    ] {
        let run = ends(path, args);
        assert_eq!(run.code, 2, "{args:?} {run:?}");
        assert_says(&run.err, &["/dev/zero: ", "device"]);
    }
}

#[test]
fn files_that_are_looked_for_by_name_are_no_pipes() {
    let folder = crate::support::short();
    let path = folder.path();
    let pipe = |name: &str| {
        let made = Command::new("mkfifo").arg(path.join(name)).status();
        assert!(made.unwrap().success());
    };
    let solid = "4 4 0 1 0 0 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 3 2\n1 2 4\n2 3 4\n3 1 4\n1\n1\n1\n1\n1 2 3 4\n";
    fs::write(path.join("solid.ugrid"), solid).unwrap();
    pipe("solid.mapbc");
    let run = ends(path, "info solid.ugrid");
    assert_eq!(run.code, 0, "{run:?}");
    assert_says(&run.err, &["solid.mapbc: ", "pipe"]);
    pipe("late.vtu");
    let list = "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"late.vtu\"/>\
                </Collection></VTKFile>";
    fs::write(path.join("all.pvd"), list).unwrap();
    for args in ["info all.pvd", "convert all.pvd all.vtkhdf"] {
        let run = ends(path, args);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["late.vtu", "file"]);
    }
    fs::create_dir(path.join("run")).unwrap();
    pipe("run/run.json");
    pipe("run/steps.csv");
    for args in [
        "report run -o r.html",
        "deform n.vtu few.toml -o run --resume",
        "finish run",
    ] {
        let run = ends(path, args);
        assert_eq!(run.code, 2, "{args:?} {run:?}");
    }
}
