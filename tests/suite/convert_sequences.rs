//! Sequences through `convert` and the commands that read them: all of an output or nothing, standard output,
//! lists that are out of order, folders with parts.

use crate::support::{airfoil, assert_says, azimesh, files, json, names, rewrite, short, succeed};
use std::path::Path;
use std::process::{Command, Stdio};

/// Three meshes of a sequence, `p_1.vtu` to `p_3.vtu`, their list `s.pvd`, `other.vtu` with more nodes, and
/// `list.pvd`, which names a file that is not there.
fn parts() -> tempfile::TempDir {
    let folder = airfoil();
    let path = folder.path();
    for step in ["1", "2", "3"] {
        let name = format!("p_{step}.vtu");
        succeed(path, &["convert", "n.vtu", &name, "--scale", step]);
    }
    let finer = ["-q", "sample", "naca0012", "--nodes", "900", "-o"];
    succeed(path, &[&finer[..], &["other.vtu"]].concat());
    succeed(path, &["convert", "p_1.vtu", "p_2.vtu", "p_3.vtu", "s.pvd"]);
    let missing = [("s_0002.vtu", "s_9.vtu")];
    rewrite(path, "s.pvd", "list.pvd", &missing);
    folder
}

#[test]
fn wrong_input_leaves_everything_as_it_was() {
    let folder = parts();
    let path = folder.path();
    for good in ["keep.vtkhdf", "keep.cgns"] {
        succeed(path, &["convert", "s.pvd", good]);
    }
    std::fs::write(path.join("broken.su2"), "NDIME= 2\n").unwrap();
    let before = files(path);
    let no_9 = "list.pvd:6: ";
    for (args, said) in [
        (&["--force", "list.pvd", "keep.vtkhdf"][..], no_9),
        (&["list.pvd", "new.pvd"], no_9),
        (&["list.pvd", "-o", "new", "--format", "su2"], no_9),
        (&["--force", "p_1.vtu", "no.vtu", "keep.vtkhdf"], "no.vtu: "),
        (
            &["--force", "p_1.vtu", "other.vtu", "keep.vtkhdf"],
            "keep.vtkhdf: ",
        ),
        (
            &["--force", "p_1.vtu", "other.vtu", "keep.cgns"],
            "keep.cgns: ",
        ),
        (&["--force", "p_1.vtu", "broken.su2", "s.pvd"], "broken.su2"),
        (
            &["p_1.vtu", "broken.su2", "-o", "new", "--format", "vtk"],
            "broken.su2",
        ),
        (
            &[
                "n.vtu",
                "broken.su2",
                "-o",
                "new",
                "--format",
                "vtu",
                "--pieces",
                "2",
            ],
            "broken.su2",
        ),
    ] {
        let run = azimesh(path, &[&["convert"], args].concat());
        assert_eq!(run.code, 2, "{args:?}: {run:?}");
        assert!(run.err.contains(said), "{args:?}: {run:?}");
        assert!(!run.err.contains(".part"), "{args:?}: {run:?}");
        assert!(files(path) == before, "{args:?}: {:?}", names(path));
    }
}

#[test]
fn a_sequence_goes_to_standard_output() {
    let folder = parts();
    let path = folder.path();
    for inputs in [&["s.pvd"][..], &["p_1.vtu", "p_2.vtu", "p_3.vtu"]] {
        for format in ["vtkhdf", "cgns"] {
            let before = names(path);
            let mut command = Command::new(env!("CARGO_BIN_EXE_azimesh"));
            let command = command.current_dir(path).arg("convert").args(inputs);
            let output = command.args(["-", "--format", format]).output().unwrap();
            assert!(output.status.success(), "{output:?}");
            assert_eq!(names(path), before);
            let expected = format!("expected.{format}");
            succeed(
                path,
                &[&["convert", "--force"], inputs, &[&expected]].concat(),
            );
            let expected = std::fs::read(path.join(&expected)).unwrap();
            assert!(output.stdout == expected, "{inputs:?} {format}");
        }
    }
}

#[test]
fn times_that_do_not_rise_are_noted() {
    let folder = parts();
    let path = folder.path();
    let earlier = [("timestep=\"2\"", "timestep=\"0.5\"")];
    rewrite(path, "s.pvd", "unordered.pvd", &earlier);
    let run = succeed(path, &["info", "unordered.pvd"]);
    assert!(run.out.contains("3, times 0 to 1;"), "{run:?}");
    for args in [
        &["info", "unordered.pvd"][..],
        &["convert", "unordered.pvd", "u.vtkhdf"],
        &["info", "u.vtkhdf"],
    ] {
        let run = succeed(path, args);
        assert_says(&run.err, &["times", "step 1 is at 1", "step 2 at 0.5"]);
    }
    let note = json(path, &["info", "unordered.pvd"])["diagnostics"][0].clone();
    let found = (&note["code"], &note["path"]);
    assert_eq!(
        found,
        (&"times_not_increasing".into(), &"unordered.pvd".into())
    );
}

#[test]
fn a_schedule_that_comes_back_to_an_azimuth_leaves_a_sequence_that_is_read() {
    let folder = short();
    let path = folder.path();
    let text = std::fs::read_to_string(path.join("few.toml")).unwrap();
    let is_range = |line: &&str| {
        ["start", "stop", "step"]
            .iter()
            .any(|key| line.starts_with(key))
    };
    let lines: Vec<&str> = text.lines().filter(|line| !is_range(line)).collect();
    let text = lines.join("\n");
    let text = text.replace("[azimuth]", "[azimuth]\nvalues = [0, 0, 350, 10, 10]");
    std::fs::write(path.join("again.toml"), text).unwrap();
    for format in ["vtu", "su2", "vtk"] {
        let args = ["deform", "n.vtu", "again.toml", "-o", format];
        let run = succeed(path, &[&args[..], &["--format", format]].concat());
        assert_says(&run.err, &["steps 0 and 1", "same time, 0"]);
        let times = &json(path, &["info", format])["times"];
        assert_eq!(times.as_array().map(Vec::len), Some(5), "{format}: {times}");
        succeed(path, &["quality", format]);
        succeed(path, &["diff", format, format]);
        let one = format!("{format}.vtkhdf");
        succeed(path, &["convert", format, &one]);
        succeed(path, &["diff", format, &one]);
    }
}

#[test]
fn in_a_folder_the_joined_file_is_the_sequence() {
    let folder = short();
    let path = folder.path();
    for format in ["vtkhdf", "cgns"] {
        for steps in ["0..2", "2..5"] {
            let args = ["deform", "n.vtu", "few.toml", "-o", format, "--format"];
            succeed(path, &[&args[..], &[format, "--steps", steps]].concat());
        }
        let run = azimesh(path, &["quality", format]);
        assert!(
            run.code == 2 && run.err.contains("not joined, steps 0..2, 2..5 of 5"),
            "{run:?}"
        );
        succeed(path, &["finish", format]);
        let times = &json(path, &["info", format])["times"];
        assert_eq!(times.as_array().map(Vec::len), Some(5), "{format}: {times}");
        succeed(path, &["quality", format]);
        succeed(path, &["diff", format, format]);
    }
}

#[test]
#[cfg(unix)]
fn a_sequence_may_have_more_files_than_can_be_open() {
    let folder = airfoil();
    let path = folder.path();
    succeed(path, &["deform", "n.vtu", "n.toml", "-o", "out"]);
    let program = Path::new(env!("CARGO_BIN_EXE_azimesh"));
    let line = format!(
        "ulimit -n 24; {} convert out/n.pvd -o files --format vtk --threads 1",
        program.display()
    );
    let run = Command::new("bash")
        .args(["-c", &line])
        .current_dir(path)
        .output();
    let run = run.unwrap();
    assert!(run.status.success(), "{run:?}");
    assert_eq!(names(&path.join("files")).len(), 37 + 2);
}

/// Waits until a hidden file is there.
#[cfg(unix)]
fn until_under_work(folder: &Path) {
    for _ in 0..600 {
        if names(folder).iter().any(|name| name.ends_with(".part")) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    panic!("no hidden file: {:?}", names(folder));
}

/// True under `nohup`: child processes then ignore SIGHUP too.
#[cfg(unix)]
fn is_hangup_ignored() -> bool {
    let status = Command::new("sh").args(["-c", "kill -HUP $$"]).status();
    status.unwrap().success()
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_conversion_and_leaves_no_hidden_file() {
    let folder = parts();
    let path = folder.path();
    // The program waits for the second mesh until the signal ends it.
    let made = Command::new("mkfifo").arg(path.join("late.vtu")).status();
    assert!(made.unwrap().success());
    let before = names(path);
    for (signal, code, out, kept) in [
        ("-TERM", 143, &["all.vtkhdf"][..], &[][..]),
        ("-INT", 130, &["all.cgns"], &[]),
        ("-HUP", 129, &["all.vtkhdf"], &[]),
        ("-TERM", 143, &["all.pvd"], &["all_0000.vtu"]),
    ] {
        if signal == "-HUP" && is_hangup_ignored() {
            continue;
        }
        let mut child = Command::new(env!("CARGO_BIN_EXE_azimesh"))
            .current_dir(path)
            .args(["convert", "p_1.vtu", "late.vtu"])
            .args(out)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        until_under_work(path);
        std::thread::sleep(std::time::Duration::from_millis(500));
        let id = child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{out:?}");
        let mut expected = before.clone();
        expected.extend(kept.iter().map(|name| (*name).to_owned()));
        expected.sort();
        assert_eq!(names(path), expected, "{out:?}");
    }
}

#[test]
fn nothing_is_shown_of_a_file_that_a_list_names_and_that_is_no_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("notes.txt"), "root:secret:words").unwrap();
    let list = "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"notes.txt\"/></Collection></VTKFile>";
    std::fs::write(folder.join("all.pvd"), list).unwrap();
    for args in [&["info", "all.pvd"][..], &["convert", "all.pvd", "a.vtu"]] {
        let run = azimesh(folder, args);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(
            &run.err,
            &[
                "notes.txt: all.pvd lists this file",
                "not a mesh of a known format",
            ],
        );
        assert!(!run.err.contains("secret"), "{run:?}");
    }
}
