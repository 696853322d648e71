//! Sequences through `convert` and the commands that read them: all of an output or nothing, standard output,
//! lists that are out of order, folders with parts.

use crate::support::exodus::small;
use crate::support::{airfoil, assert_says, azimesh, files, json, names, rewrite, short, succeed};
use azimesh_io::mesh::{DataArray, Mesh, Values};
use std::path::Path;
use std::process::{Command, Stdio};

/// Three meshes of a sequence, `p_1.vtu` to `p_3.vtu`, their list `s.pvd`, `other.vtu` with more nodes, and
/// `list.pvd`, which names a file that is not there.
fn parts() -> tempfile::TempDir {
    let folder = airfoil();
    let path = folder.path();
    for step in ["1", "2", "3"] {
        let name = format!("p_{step}.vtu");
        succeed(path, ["convert", "n.vtu", &name, "--scale", step]);
    }
    let finer = "-q sample naca0012 --nodes 900 -o";
    succeed(path, format!("{finer} other.vtu"));
    succeed(path, "convert p_1.vtu p_2.vtu p_3.vtu s.pvd");
    let missing = [("s_0002.vtu", "s_9.vtu")];
    rewrite(path, "s.pvd", "list.pvd", &missing);
    folder
}

#[test]
fn wrong_input_leaves_everything_as_it_was() {
    let folder = parts();
    let path = folder.path();
    for good in ["keep.vtkhdf", "keep.cgns"] {
        succeed(path, ["convert", "s.pvd", good]);
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
        let run = azimesh(path, [&["convert"], args].concat());
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
                [&["convert", "--force"], inputs, &[&expected]].concat(),
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
    let run = succeed(path, "info unordered.pvd");
    assert!(run.out.contains("3, times 0 to 1;"), "{run:?}");
    for args in [
        "info unordered.pvd",
        "convert unordered.pvd u.vtkhdf",
        "info u.vtkhdf",
    ] {
        let run = succeed(path, args);
        assert_says(&run.err, &["times", "step 1 is at 1", "step 2 at 0.5"]);
    }
    let note = json(path, "info unordered.pvd")["diagnostics"][0].clone();
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
        let args = format!("deform n.vtu again.toml -o {format}");
        let run = succeed(path, format!("{args} --format {format}"));
        assert_says(&run.err, &["steps 0 and 1", "same time, 0"]);
        let times = &json(path, ["info", format])["times"];
        assert_eq!(times.as_array().map(Vec::len), Some(5), "{format}: {times}");
        succeed(path, ["quality", format]);
        succeed(path, ["diff", format, format]);
        let one = format!("{format}.vtkhdf");
        succeed(path, ["convert", format, &one]);
        succeed(path, ["diff", format, &one]);
    }
}

#[test]
fn in_a_folder_the_joined_file_is_the_sequence() {
    let folder = short();
    let path = folder.path();
    for format in ["vtkhdf", "cgns"] {
        for steps in ["0..2", "2..5"] {
            let args = format!("deform n.vtu few.toml -o {format} --format");
            succeed(path, format!("{args} {format} --steps {steps}"));
        }
        let run = azimesh(path, ["quality", format]);
        assert!(
            run.code == 2 && run.err.contains("not joined, steps 0..2, 2..5 of 5"),
            "{run:?}"
        );
        succeed(path, ["finish", format]);
        let times = &json(path, ["info", format])["times"];
        assert_eq!(times.as_array().map(Vec::len), Some(5), "{format}: {times}");
        succeed(path, ["quality", format]);
        succeed(path, ["diff", format, format]);
    }
}

#[test]
#[cfg(unix)]
fn a_sequence_may_have_more_files_than_can_be_open() {
    let folder = airfoil();
    let path = folder.path();
    succeed(path, "deform n.vtu n.toml -o out");
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
    for (signal, code, out) in [
        ("-TERM", 143, "all.vtkhdf"),
        ("-INT", 130, "all.cgns"),
        ("-HUP", 129, "all.vtkhdf"),
        ("-TERM", 143, "all.pvd"),
    ] {
        if signal == "-HUP" && is_hangup_ignored() {
            continue;
        }
        let mut child = Command::new(env!("CARGO_BIN_EXE_azimesh"))
            .current_dir(path)
            .args(["convert", "p_1.vtu", "late.vtu"])
            .arg(out)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        until_under_work(path);
        std::thread::sleep(std::time::Duration::from_millis(500));
        let id = child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{out:?}");
        assert_eq!(names(path), before, "{out:?}");
    }
}

#[test]
fn nothing_is_shown_of_a_file_that_a_list_names_and_that_is_no_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("notes.txt"), "root:secret:words").unwrap();
    let list = "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"notes.txt\"/></Collection></VTKFile>";
    std::fs::write(folder.join("all.pvd"), list).unwrap();
    for args in ["info all.pvd", "convert all.pvd a.vtu"] {
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

/// Ways to write a sequence: the name of the output, and `--format` where the name does not say it.
const SEQUENCES: [(&str, &[&str]); 5] = [
    ("s.pvd", &[]),
    ("s.vtk.series", &[]),
    ("s.vtkhdf", &[]),
    ("s.cgns", &[]),
    ("s_case", &["--format", "openfoam"]),
];

/// Two steps `NAME_0.vtu` and `NAME_1.vtu` of a mesh of testdata, the second of twice the size, with the position of each node as a vector
/// `r` and its products as a tensor `rr`, and the sequence of them in every format.
fn steps_with_arrays(path: &Path, testdata: &str, name: &str) {
    let mesh = Mesh::read(format!("testdata/{testdata}")).unwrap();
    for step in [0, 1] {
        let mut mesh = mesh.clone();
        let size = f64::from(step + 1);
        mesh.points
            .iter_mut()
            .for_each(|x| *x = x.map(|x| x * size));
        mesh.point_arrays = arrays_of(&mesh);
        mesh.write(path.join(format!("{name}_{step}.vtu"))).unwrap();
    }
    let steps = [format!("{name}_0.vtu"), format!("{name}_1.vtu")];
    for (sequence, format) in SEQUENCES {
        let out = sequence.replacen('s', name, 1);
        let args = ["convert", &steps[0], &steps[1], &out];
        succeed(path, [&args[..], format].concat());
    }
}

fn arrays_of(mesh: &Mesh) -> Vec<DataArray> {
    let products = |x: &[f64; 3]| [0, 1, 2].map(|i| x.map(|y| x[i] * y)).concat();
    let tensors = mesh.points.iter().flat_map(products).collect();
    vec![
        DataArray::tuples("r", 3, Values::F64(mesh.points.concat())),
        DataArray::tuples("rr", 9, Values::F64(tensors)),
    ]
}

/// Checks that the vectors and tensors of a mesh are those of its nodes.
fn check_arrays(mesh: &Mesh) {
    for expected in arrays_of(mesh) {
        let found = mesh.point_arrays.iter();
        // CGNS writes tensors as nine arrays, which keep their values.
        let Some(found) = found.clone().find(|array| array.name == expected.name) else {
            assert!(mesh.point_arrays.iter().any(|array| array.name == "rr_9"));
            continue;
        };
        let [found, expected] =
            [found, &expected].map(|array| array.values.to_f64().expect("they are reals"));
        let largest = expected.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let mut values = found.iter().zip(&expected);
        assert!(values.all(|(a, b)| (a - b).abs() < 1e-12 * largest));
    }
}

#[test]
fn every_change_is_made_at_every_step_of_every_kind_of_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, testdata, all_changes) in [
        (
            "half",
            "wing_on_plane.vtu",
            &[
                &["--mirror", "z"][..],
                &["--translate", "1,2,3"],
                &["--rotate", "0,1,1,50"],
            ][..],
        ),
        (
            "sector",
            "rotor_sector.vtu",
            &[
                &["--repeat", "4", "--axis", "z"],
                &["--repeat", "3", "--axis", "z,-90"],
            ],
        ),
    ] {
        steps_with_arrays(path, testdata, name);
        for changes in all_changes {
            let one = format!("{name}_1.vtu");
            succeed(
                path,
                [&["convert", "--force", &one, "one.vtu"], *changes].concat(),
            );
            let expected = Mesh::read(path.join("one.vtu")).unwrap();
            if changes[0] != "--translate" {
                check_arrays(&expected);
            }
            for (sequence, _) in SEQUENCES {
                let sequence = sequence.replacen('s', name, 1);
                let args = ["convert", "--force", &sequence, "all.pvd"];
                let run = succeed(path, [&args[..], changes].concat());
                let joined = run.err.lines().filter(|line| line.contains("joined"));
                assert_eq!(
                    joined.count(),
                    usize::from(changes.len() != 2 || changes[0] == "--mirror"),
                    "{run:?}"
                );
                let times = &json(path, ["info", "all.pvd"])["times"];
                assert_eq!(*times, serde_json::json!([0.0, 1.0]), "{sequence}");
                let found = Mesh::read(path.join("all_0001.vtu")).unwrap();
                assert_eq!(found.points, expected.points, "{sequence} {changes:?}");
                let counts = |mesh: &Mesh| {
                    let tags = mesh.boundary_tags();
                    let tags = tags.map(|tag| (tag.name.clone(), tag.cells.len()));
                    (mesh.cells.len(), tags.collect::<Vec<_>>())
                };
                assert_eq!(counts(&found), counts(&expected), "{sequence} {changes:?}");
                if changes[0] != "--translate" && !sequence.ends_with("case") {
                    check_arrays(&found);
                }
            }
        }
    }
    let mirrored_tensor = ["convert", "half.cgns", "m.vtu", "--mirror", "z"];
    let run = succeed(path, mirrored_tensor);
    assert_says(&run.err, &["keep them: rr_1, rr_2"]);
}

#[test]
fn a_sequence_of_layers_becomes_plane_and_an_exodus_sequence_moves() {
    let folder = parts();
    let path = folder.path();
    let layers = ["convert", "s.pvd", "layers.vtkhdf", "--extrude", "0.1"];
    succeed(path, layers);
    succeed(path, ["convert", "layers.vtkhdf", "flat.cgns", "--flatten"]);
    succeed(path, ["diff", "s.pvd", "flat.cgns"]);
    std::fs::write(path.join("a.exo"), small(5)).unwrap();
    succeed(path, ["convert", "a.exo", "b.pvd", "--translate", "1,2,3"]);
    let back = ["convert", "b.pvd", "c.pvd", "--translate", "-1,-2,-3"];
    succeed(path, back);
    let found = json(path, ["diff", "a.exo", "c.pvd", "--tolerance", "1e-12"]);
    let same = &json(path, ["diff", "a.exo", "a.exo"])["steps"];
    assert_eq!(found["steps"], *same, "{found}");
}

#[test]
fn sequences_of_the_same_times_are_merged_step_by_step_and_others_refused() {
    let folder = parts();
    let path = folder.path();
    let away = ["convert", "s.pvd", "away.vtkhdf", "--translate", "100,0,0"];
    succeed(path, away);
    let two = ["convert", "p_1.vtu", "p_2.vtu", "two.pvd"];
    succeed(path, two);
    let late = [("timestep=\"2\"", "timestep=\"2.5\"")];
    rewrite(path, "s.pvd", "late.pvd", &late);
    let before = names(path);
    for (other, said) in [
        ("two.pvd", "two.pvd: 2 steps, 3 steps in away.vtkhdf"),
        ("late.pvd", "late.pvd: step 2 is at 2.5, 2 in away.vtkhdf"),
    ] {
        let args = ["convert", "--merge", "away.vtkhdf", other, "m.pvd"];
        let run = azimesh(path, args);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &[said, "--step I merges one step of each"]);
        assert_eq!(names(path), before);
    }
    let missing = ["--step", "2"];
    let args = ["convert", "--merge", "away.vtkhdf", "two.pvd", "m.vtu"];
    let run = azimesh(path, [&args[..], &missing].concat());
    assert_says(
        &run.err,
        &["two.pvd: --step 2: the sequence has steps 0 to 1"],
    );
    succeed(path, [&args[..], &["--step", "1"]].concat());
    for out in [
        &["m.pvd"][..],
        &["m.cgns"],
        &["-o", "m", "--format", "vtkhdf"],
    ] {
        let args = ["convert", "--merge", "s.pvd", "away.vtkhdf", "p_1.vtu"];
        let mut changes = args.to_vec();
        changes.extend(out);
        succeed(path, &changes);
    }
    for merged in ["m.pvd", "m.cgns", "m/merged.vtkhdf"] {
        for (step, size) in [(0, 1.0), (2, 3.0)] {
            let name = format!("step_{step}.vtu");
            let number = step.to_string();
            let args = ["convert", "--force", merged, &name, "--step", &number];
            succeed(path, args);
            let [one, found] = ["p_1.vtu", &name].map(|name| Mesh::read(path.join(name)).unwrap());
            let n = one.points.len();
            assert_eq!(found.points.len(), 3 * n);
            let scaled = one.points[5].map(|x| x * size);
            assert_eq!(found.points[5], scaled, "{merged}");
            assert_eq!(found.points[n + 5][0], scaled[0] + 100.0);
            assert_eq!(found.points[2 * n + 5], one.points[5]);
        }
    }
}

#[test]
fn in_several_formats_a_sequence_is_one_file_where_the_format_has_sequences() {
    let folder = parts();
    let path = folder.path();
    let args = [
        "convert",
        "s.pvd",
        "-o",
        "out",
        "--format",
        "cgns,vtkhdf,su2",
    ];
    succeed(path, args);
    let su2 = (0..3).map(|step| format!("s_000{step}.su2"));
    let mut expected: Vec<String> = su2.collect();
    expected.extend(["s.cgns", "s.vtkhdf", "s.su2.pvd"].map(str::to_owned));
    expected.sort();
    assert_eq!(names(&path.join("out")), expected);
    for one in ["out/s.cgns", "out/s.vtkhdf", "out/s.su2.pvd"] {
        succeed(path, ["diff", "s.pvd", one, "--tolerance", "1e-12"]);
    }
    let other = ["convert", "p_1.vtu", "other.vtu", "varying.pvd"];
    succeed(path, other);
    let into = ["convert", "varying.pvd", "-o", "no", "--format", "cgns"];
    let run = azimesh(path, into);
    assert!(run.code == 2 && !path.join("no").exists(), "{run:?}");
    assert_says(&run.err, &["other nodes or cells", "a list (OUT.pvd)"]);
}
