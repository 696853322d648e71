//! Inputs are never lost: no output takes their place, and a run records what it has read of them.

use crate::support::sequence::testdata;
use crate::support::{Args, airfoil, assert_says, azimesh, files, rewrite, short, succeed};
use azimesh_io::formats::files_in;
use std::fs;
use std::path::Path;

/// Runs a command that must be refused since `input` would be replaced, and changes no file of the folder.
fn assert_refused(folder: &Path, args: impl Args, input: &str) {
    let before = files(folder);
    let run = azimesh(folder, &args);
    assert_eq!(run.code, 2, "{args:?}: {run:?}");
    assert_says(&run.err, &[input, "input", "would replace"]);
    assert!(files(folder) == before, "{args:?}: {run:?}");
}

#[cfg(unix)]
#[test]
fn no_command_replaces_a_file_that_it_reads() {
    let folder = short();
    let folder = folder.path();
    std::os::unix::fs::symlink("n.vtu", folder.join("link.vtu")).unwrap();
    fs::hard_link(folder.join("n.vtu"), folder.join("second.vtu")).unwrap();
    succeed(folder, "deform n.vtu few.toml -o out");
    for out in ["n.vtu", "link.vtu", "second.vtu", "./n.vtu"] {
        assert_refused(folder, ["convert", "n.vtu", out, "--force"], out);
        assert_refused(folder, ["repair", "n.vtu", "-o", out, "--force"], out);
        assert_refused(folder, ["quality", "n.vtu", "-o", out, "--force"], out);
    }
    let of_reference = ["out/n_0000.vtu", "--reference", "n.vtu", "-o", "n.vtu"];
    for command in ["repair", "quality"] {
        let args = [&[command][..], &of_reference, &["--force"]].concat();
        assert_refused(folder, &args, "n.vtu");
    }
    for out in ["few.toml", "n.vtu"] {
        let select = format!("select n.vtu few.toml -o {out} --force");
        assert_refused(folder, &select, out);
    }
    let out = folder.join("out");
    for page in [
        "steps.csv",
        "run.json",
        "n_0001.vtu",
        "base.toml",
        "base.vtp",
        "n.pvd",
    ] {
        assert_refused(&out, ["report", ".", "-o", page, "--force"], page);
    }
    assert_refused(&out, "convert n.pvd n.pvd --force", "n.pvd");
    let same = "convert n.pvd -o . --format vtu --force";
    assert_refused(&out, same, "n_0000.vtu");
}

/// A case with time folders, of which a conversion reads the last, and another one with a link to its mesh.
#[cfg(unix)]
#[test]
fn no_command_replaces_a_file_of_a_case_that_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let case = testdata("openfoam/ascii");
    let names = files_in(&case).unwrap();
    for name in &names {
        let path = at.join("case").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::copy(case.join(name), path).unwrap();
    }
    fs::create_dir(at.join("linked")).unwrap();
    for name in ["constant", "1"] {
        std::os::unix::fs::symlink(format!("../case/{name}"), at.join("linked").join(name))
            .unwrap();
    }
    let schedule = "steps = 2\n[[body]]\nname = \"floor\"\ntags = [\"floor\"]\n\
                    [body.rigid]\ntranslate = [0.0, 0.0, 0.01]\n[boundaries]\nothers = \"free\"\n";
    fs::write(at.join("s.toml"), schedule).unwrap();
    let points = "case/constant/polyMesh/points";
    for command in [
        format!("convert case {points} --format vtu"),
        format!("convert case/case.foam {points} --format vtu"),
        "convert case case/0.5/polyMesh/points --format vtu --step 0".to_owned(),
        format!("repair case -o {points} --format vtu"),
        format!("quality case/1 -o {points} --format vtu"),
        format!("select case s.toml -o {points}"),
        "convert case linked --format openfoam --scale 2".to_owned(),
        "convert case linked --format openfoam --step 0".to_owned(),
        "deform case s.toml -o linked".to_owned(),
    ] {
        assert_refused(at, format!("{command} --force"), "polyMesh");
        for name in &names {
            let content = |case: &Path| fs::read(case.join(name)).unwrap();
            assert!(
                content(&case) == content(&at.join("case")),
                "{command}: {name}"
            );
        }
    }
    fs::remove_dir_all(at.join("case/1")).unwrap();
    fs::remove_dir_all(at.join("case/0.5")).unwrap();
    assert_refused(at, "deform case s.toml -o linked --force", "polyMesh");
}

#[cfg(unix)]
#[test]
fn standard_input_is_an_input_under_its_own_name_too() {
    let folder = airfoil();
    let at = folder.path();
    let before = files(at);
    let run = |command: &str, to: std::process::Stdio| {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_azimesh"));
        program.current_dir(at).args(command.split(' ')).stdout(to);
        program.stdin(fs::File::open(at.join("n.vtu")).unwrap());
        let output = program.output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{command}: {err}");
        assert_says(&err, &["would replace"]);
        assert!(files(at) == before, "{command}");
    };
    for input in ["-", "/dev/stdin", "/proc/self/fd/0"] {
        for command in [
            "convert IN n.vtu --scale 2",
            "repair IN -o n.vtu",
            "quality IN -o ./n.vtu",
        ] {
            if cfg!(target_os = "linux") || input == "-" {
                run(
                    &format!("{} --force", command.replace("IN", input)),
                    std::process::Stdio::null(),
                );
            }
        }
    }
    let append = fs::File::options()
        .append(true)
        .open(at.join("n.vtu"))
        .unwrap();
    run("convert n.vtu - --format vtu", append.into());
}

/// A schedule of few steps whose motion is in a table, `table.toml` and the table at this path.
fn with_table(folder: &Path, table: &str) {
    let text = fs::read_to_string(folder.join("few.toml")).unwrap();
    let start = text.find("[body.cyclic]").unwrap();
    let rest = &text[start + 1..];
    let end = rest.find("\n[").map_or(text.len(), |at| start + 1 + at);
    let body = format!("[body.table]\nfile = \"{table}\"\n");
    let text = format!("{}{body}{}", &text[..start], &text[end..]);
    fs::write(folder.join("table.toml"), text).unwrap();
    let rows = "azimuth_deg,dx,dy\n0,0,0\n180,0.01,0.02\n360,0,0\n";
    fs::write(folder.join(table), rows).unwrap();
}

#[test]
fn a_run_never_takes_an_input_for_a_file_of_an_earlier_run() {
    let folder = short();
    let folder = folder.path();
    succeed(folder, "-q convert n.vtu n.cgns");
    let deform = |mesh, schedule, more: &[&str]| {
        let args = [&["deform", mesh, schedule, "-o", "."], more].concat();
        for force in [&["--force"][..], &[], &["--steps", "0..2"]] {
            assert_refused(folder, [&args[..], force].concat(), "input");
        }
    };
    deform("n.cgns", "few.toml", &["--format", "cgns"]);
    fs::copy(folder.join("few.toml"), folder.join("base.toml")).unwrap();
    deform("n.vtu", "base.toml", &[]);
    fs::remove_file(folder.join("base.toml")).unwrap();
    with_table(folder, "steps.csv");
    deform("n.vtu", "table.toml", &[]);
}

#[test]
fn finish_does_not_replace_the_mesh_of_its_parts() {
    let folder = short();
    let folder = folder.path();
    succeed(folder, "-q convert n.vtu n.cgns");
    for part in ["0..2", "2..5"] {
        let args = "deform n.cgns few.toml -o out --format cgns";
        succeed(folder, format!("{args} -q --steps {part}"));
    }
    // A mesh that has come to the folder since: known by its hash, whatever the path in the records.
    let mesh = fs::read(folder.join("n.cgns")).unwrap();
    fs::rename(folder.join("n.cgns"), folder.join("out/n.cgns")).unwrap();
    for force in [&[][..], &["--force"]] {
        let run = azimesh(folder, [&["finish", "out"], force].concat());
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["n.cgns", "input", "would replace"]);
        assert!(fs::read(folder.join("out/n.cgns")).unwrap() == mesh);
    }
}

#[test]
fn base_points_that_lie_among_the_outputs_stay_as_they_are() {
    let folder = short();
    let folder = folder.path();
    fs::create_dir(folder.join("out")).unwrap();
    succeed(folder, "-q select n.vtu few.toml -o out/base.toml");
    let mut base = fs::read_to_string(folder.join("out/base.toml")).unwrap();
    base += "# mine\n";
    fs::write(folder.join("out/base.toml"), &base).unwrap();
    let deform = "deform n.vtu few.toml -o out --base out/base.toml";
    succeed(folder, deform);
    succeed(folder, format!("{deform} --resume"));
    succeed(folder, format!("{deform} --force"));
    assert!(fs::read_to_string(folder.join("out/base.toml")).unwrap() == base);
}

/// Writes the schedule with another step as many.toml.
fn with_step(folder: &Path, step: &str) {
    let changes = [("step = 10.0", &*format!("step = {step}"))];
    rewrite(folder, "n.toml", "many.toml", &changes);
}

#[test]
fn force_leaves_the_files_of_the_new_run_alone() {
    let folder = short();
    let folder = folder.path();
    with_step(folder, "45.0");
    let deform = |schedule: &str, out: &str| {
        let args = format!("deform n.vtu {schedule} -o {out} --force");
        succeed(folder, &args);
    };
    deform("many.toml", "out");
    deform("few.toml", "out");
    deform("few.toml", "alone");
    let names = |out: &str| files(&folder.join(out)).into_keys().collect::<Vec<_>>();
    assert_eq!(names("out"), names("alone"));
}

#[test]
fn force_over_a_decomposed_case_keeps_every_piece_of_the_new_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let case = testdata("openfoam/decomposed");
    fs::write(
        folder.join("s.toml"),
        "[azimuth]\nvalues = [0, 90]\n[[body]]\nname = \"b\"\ntags = [\"inlet\"]\n\
         rigid = { ramp = true, translate = [1e-3, 0, 0] }\n[boundaries]\nothers = \"fixed\"\n",
    )
    .unwrap();
    let case = case.to_str().unwrap();
    let deform = format!("deform {case} s.toml -o out --force -q");
    let pieces = || {
        let has_points = |piece: &str| {
            folder
                .join("out")
                .join(piece)
                .join("90/polyMesh/points")
                .is_file()
        };
        ["processor0", "processor1"].map(has_points)
    };
    for _ in 0..2 {
        azimesh(folder, &deform);
        assert_eq!(pieces(), [true, true]);
    }
}

#[cfg(unix)]
#[test]
fn a_schedule_that_is_edited_during_a_run_is_not_taken_for_the_one_that_was_read() {
    use std::io::Write;
    let folder = airfoil();
    let folder = folder.path();
    // The table comes from a pipe, so that the run waits for it after it has read the schedule.
    with_table_in(folder);
    let status = std::process::Command::new("mkfifo")
        .arg(folder.join("t.csv"))
        .status();
    assert!(status.unwrap().success());
    let schedule = folder.join("table.toml");
    let first = fs::read_to_string(&schedule).unwrap();
    let child = std::process::Command::new(assert_cmd::cargo::cargo_bin("azimesh"))
        .current_dir(folder)
        .args(["deform", "n.vtu", "table.toml", "-q", "-o", "out"])
        .spawn();
    let mut pipe = fs::OpenOptions::new()
        .write(true)
        .open(folder.join("t.csv"))
        .unwrap();
    fs::write(
        folder.join("new.toml"),
        first.replace("step = 90", "step = 45"),
    )
    .unwrap();
    fs::rename(folder.join("new.toml"), &schedule).unwrap();
    pipe.write_all(b"azimuth_deg,dx,dy\n0,0,0\n180,0.01,0.02\n360,0,0\n")
        .unwrap();
    drop(pipe);
    assert!(child.unwrap().wait().unwrap().success());
    let record = fs::read(folder.join("out/run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    let hash = blake3::hash(first.as_bytes()).to_string();
    assert_eq!(record["inputs"][1]["blake3"], hash.as_str());
}

/// `table.toml`, a schedule of few steps whose motion is in `t.csv`.
#[cfg(unix)]
fn with_table_in(folder: &Path) {
    rewrite(
        folder,
        "n.toml",
        "few.toml",
        &[("step = 10.0", "step = 90.0")],
    );
    with_table(folder, "t.csv");
    fs::remove_file(folder.join("t.csv")).unwrap();
}

/// A folder with the mesh `sphere.vtu` and `few.toml`, a schedule of four steps of which the first moves it.
fn sphere() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "testdata/sphere_in_box_raw.vtu";
    fs::copy(mesh, folder.path().join("sphere.vtu")).unwrap();
    let schedule = "azimuth.values = [0, 30, 60, 90]\nboundaries.fixed = [\"inlet\", \"outlet\", \"walls\"]\n\
        rbf.support_radius = 3.0\n[[body]]\nname = \"sphere\"\ntags = [\"sphere\"]\n\
        rigid = { translate = { vector = [0.1, 0, 0], harmonics = [{ cos = 1.0 }] } }\n";
    fs::write(folder.path().join("few.toml"), schedule).unwrap();
    folder
}

#[test]
fn topology_of_a_case_is_restored_without_its_points() {
    let folder = sphere();
    let folder = folder.path();
    let deform = "deform sphere.vtu few.toml -o c --format openfoam";
    azimesh(folder, format!("{deform} -q"));
    let mesh = folder.join("c/constant/polyMesh");
    let wanted = files(&mesh);
    for (name, content) in [
        ("owner", None),
        ("faces", Some("x")),
        ("boundary", Some("")),
    ] {
        match content {
            None => fs::remove_file(mesh.join(name)).unwrap(),
            Some(content) => fs::write(mesh.join(name), content).unwrap(),
        }
        let run = azimesh(folder, format!("{deform} --resume"));
        assert_says(&run.err, &["constant/polyMesh", "written again"]);
        assert!(files(&mesh) == wanted, "{name}: {run:?}");
    }
}

#[test]
fn finish_wants_the_files_beside_meshes_as_they_were_written() {
    let folder = sphere();
    let folder = folder.path();
    for (format, wanted) in [
        (
            "openfoam",
            [
                "constant/polyMesh/owner",
                "azimesh/base.vtp",
                "azimesh/steps_0-2.csv",
            ],
        ),
        (
            "ugrid-b8",
            ["sphere_0001.mapbc", "base.toml", "steps_2-4.csv"],
        ),
    ] {
        for part in ["0..2", "2..4"] {
            let deform = format!("deform sphere.vtu few.toml -o c --format {format}");
            azimesh(folder, format!("{deform} -q --steps {part}"));
        }
        for name in wanted {
            let path = folder.join("c").join(name);
            let content = fs::read(&path).unwrap();
            let mut changed = content.clone();
            // A digit of a row, or any byte.
            let digit = changed
                .windows(2)
                .rposition(|two| two[0] == b',' && two[1].is_ascii_digit());
            let at = digit.map_or(content.len() / 2, |at| at + 1);
            changed[at] = if changed[at] == b'1' { b'2' } else { b'1' };
            fs::write(&path, changed).unwrap();
            let run = azimesh(folder, "finish c");
            assert_eq!(run.code, 2, "{format} {name}: {run:?}");
            assert_says(&run.err, &["--resume"]);
            if !name.ends_with(".csv") {
                fs::remove_file(&path).unwrap();
                assert_eq!(azimesh(folder, "finish c").code, 2, "{name}");
            }
            fs::write(&path, content).unwrap();
        }
        assert!(azimesh(folder, "finish c").code < 2);
        fs::remove_dir_all(folder.join("c")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_run_whose_files_go_while_it_writes_does_not_end_well() {
    let folder = airfoil();
    let folder = folder.path();
    with_step(folder, "0.5");
    let out = folder.join("out");
    for how in ["folder", "mesh", "table"] {
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("azimesh"))
            .current_dir(folder)
            .args([
                "deform",
                "n.vtu",
                "many.toml",
                "-q",
                "-o",
                "out",
                "--no-sync",
            ])
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        while !out.join("n_0002.vtu").exists() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        match how {
            "folder" => {
                fs::rename(&out, folder.join("old")).unwrap();
                fs::create_dir(&out).unwrap();
            }
            "mesh" => fs::remove_file(out.join("n_0001.vtu")).unwrap(),
            _ => fs::remove_file(out.join("steps.csv")).unwrap(),
        }
        let status = child.wait().unwrap();
        let mut told = String::new();
        std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut told).unwrap();
        assert_eq!(status.code(), Some(3), "{how}: {told}");
        assert_says(&told, &["another program", "--resume"]);
        fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn two_flavours_of_ugrid_share_their_boundary_conditions() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let solid = testdata("mixed_cells_v41_binary.msh");
    succeed(folder, ["convert", solid.to_str().unwrap(), "m.b8.ugrid"]);
    succeed(folder, "convert m.b8.ugrid m.lb8.ugrid --force");
    succeed(folder, "diff m.b8.ugrid m.lb8.ugrid");
    for more in ["", " --force", " --keep-going --force"] {
        succeed(
            folder,
            format!("convert m.b8.ugrid -o both --format ugrid-b8,ugrid-lb8{more}"),
        );
        assert_eq!(files(&folder.join("both")).len(), 3, "{more}");
        succeed(folder, "diff both/m.b8.ugrid both/m.lb8.ugrid");
    }
    // A file of other conditions stays, and so do the meshes.
    fs::write(folder.join("both/m.mapbc"), "0\n").unwrap();
    fs::remove_file(folder.join("both/m.b8.ugrid")).unwrap();
    fs::remove_file(folder.join("both/m.lb8.ugrid")).unwrap();
    let taken = azimesh(
        folder,
        "convert m.b8.ugrid -o both --format ugrid-b8,ugrid-lb8",
    );
    assert_eq!(taken.code, 2, "{taken:?}");
    assert_says(&taken.err, &["m.mapbc", "exists already"]);
    assert_eq!(files(&folder.join("both")).len(), 1);
    let twice = azimesh(folder, "convert m.b8.ugrid m.b8.ugrid -o new --format cgns");
    assert_eq!(twice.code, 2, "{twice:?}");
    assert_says(&twice.err, &["m.b8.ugrid is given twice"]);
}
