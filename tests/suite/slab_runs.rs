//! Slabs of a mesh, each moved by a run of its own, joined to what one run leaves.

use crate::support::{Run, assert_says, azimesh, files, rewrite, succeed, without_seconds};
use std::collections::BTreeMap;
use std::path::Path;

const NARROW: (&str, &str) = ("support_radius = 5.625", "support_radius = 0.35");

/// A folder with a blade of several slabs, `b.vtkhdf`, and `b.toml` with four steps.
fn blade() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let size = [
        "--nodes",
        "16000",
        "--surface-nodes",
        "1500",
        "--cells",
        "tet",
    ];
    let sample = ["-q", "sample", "blade", "-o", "b.vtkhdf"];
    succeed(path, &[&sample[..], &size].concat());
    std::fs::rename(path.join("b.toml"), path.join("all.toml")).unwrap();
    let steps = [
        ("step = 10.0", "step = 100.0"),
        ("tolerance = 3e-5", "tolerance = 1e-3"),
    ];
    rewrite(path, "all.toml", "b.toml", &steps);
    folder
}

fn slab(folder: &Path, slab: &str, more: &[&str]) -> Run {
    let args = [
        "-q", "deform", "b.vtkhdf", "b.toml", "-o", "out", "--slab", slab,
    ];
    azimesh(folder, &[&args[..], more].concat())
}

/// What a run leaves that does not depend on how long it takes.
fn left(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(folder);
    files.retain(|name, _| name != "run.json" && !name.starts_with("slabs_"));
    let table = String::from_utf8(files.remove("steps.csv").unwrap()).unwrap();
    let rows: Vec<String> = table.lines().map(without_seconds).collect();
    files.insert("steps.csv".to_owned(), rows.join("\n").into_bytes());
    files
}

/// What the record of a run tells of its selections.
fn selections(folder: &Path) -> serde_json::Value {
    let text = std::fs::read(folder.join("run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&text).unwrap();
    record["selections"].clone()
}

#[test]
fn slabs_joined_are_the_files_of_one_run() {
    let folder = blade();
    let path = folder.path();
    for (format, change) in [("vtu", None), ("vtkhdf", Some(NARROW)), ("cgns", None)] {
        rewrite(
            path,
            "all.toml",
            "b.toml",
            &[
                ("step = 10.0", "step = 100.0"),
                ("tolerance = 3e-5", "tolerance = 1e-3"),
            ],
        );
        rewrite(path, "b.toml", "b.toml", &Vec::from_iter(change));
        succeed(
            path,
            &[
                "-q", "deform", "b.vtkhdf", "b.toml", "-o", "one", "--format", format,
            ],
        );
        for n in [1, 3] {
            // In any order.
            for i in (1..=n).rev() {
                let run = slab(path, &format!("{i}/{n}"), &["--format", format]);
                assert_eq!(run.code, 0, "{run:?}");
            }
            succeed(path, &["-q", "finish", "out"]);
            assert!(
                left(&path.join("out")) == left(&path.join("one")),
                "{format}, {n} slabs"
            );
            assert_eq!(selections(&path.join("out")), selections(&path.join("one")));
            // Once more: all is there.
            succeed(path, &["-q", "finish", "out"]);
            assert!(
                left(&path.join("out")) == left(&path.join("one")),
                "{format}, {n} slabs"
            );
            std::fs::remove_dir_all(path.join("out")).unwrap();
        }
        std::fs::remove_dir_all(path.join("one")).unwrap();
    }
}

#[test]
fn displacements_and_velocities_are_those_of_one_run() {
    let folder = blade();
    let path = folder.path();
    let output = [
        (
            "[rbf]",
            "[output]\ndisplacement = true\nvelocity = true\n[rbf]",
        ),
        ("frame = \"rotating\"", "rpm = 300.0\nframe = \"inertial\""),
    ];
    rewrite(path, "b.toml", "b.toml", &output);
    // Of the SU2 file each process has the whole mesh.
    succeed(path, &["-q", "convert", "b.vtkhdf", "b.su2"]);
    for (mesh, format) in [
        ("b.vtkhdf", "vtkhdf"),
        ("b.vtkhdf", "cgns"),
        ("b.vtkhdf", "vtu"),
        ("b.su2", "vtkhdf"),
    ] {
        let args = ["-q", "deform", mesh, "b.toml", "--format", format, "-o"];
        succeed(path, &[&args[..], &["one"]].concat());
        for slab in ["1/2", "2/2"] {
            succeed(path, &[&args[..], &["out", "--slab", slab]].concat());
        }
        succeed(path, &["-q", "finish", "out"]);
        let (one, out) = (left(&path.join("one")), left(&path.join("out")));
        assert!(one == out, "{mesh} to {format}");
        std::fs::remove_dir_all(path.join("out")).unwrap();
        std::fs::remove_dir_all(path.join("one")).unwrap();
    }
}

#[test]
fn slabs_may_have_no_nodes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let testdata = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata");
    std::fs::copy(testdata.join("body_in_duct.toml"), path.join("b.toml")).unwrap();
    let mesh = testdata.join("body_in_duct.vtu");
    succeed(path, &["-q", "convert", mesh.to_str().unwrap(), "b.vtkhdf"]);
    succeed(path, &["-q", "deform", "b.vtkhdf", "b.toml", "-o", "one"]);
    for i in 1..=9 {
        let run = slab(path, &format!("{i}/9"), &[]);
        assert_eq!(run.code, 0, "{run:?}");
    }
    succeed(path, &["-q", "finish", "out"]);
    assert!(left(&path.join("out")) == left(&path.join("one")));
}

#[test]
fn a_slab_is_resumed_and_a_damaged_step_written_again() {
    let folder = blade();
    let path = folder.path();
    for i in ["1/2", "2/2"] {
        assert_eq!(slab(path, i, &[]).code, 0);
    }
    let step = path.join("out/slabs_2/slab_2/step_0001.slab");
    let whole = std::fs::read(&step).unwrap();
    let last = path.join("out/slabs_2/slab_2/step_0003.slab");
    std::fs::remove_file(&last).unwrap();
    let run = azimesh(path, &["report", "out"]);
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["not joined", "azimesh finish out"]);
    // Another process works on it.
    let lock = path.join("out/slabs_2/slab_2/.azimesh_0-4.lock");
    let held = std::fs::File::create(&lock).unwrap();
    held.lock().unwrap();
    let run = azimesh(path, &["finish", "out"]);
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["slab_2", "another run is writing steps 0..4"]);
    drop(held);
    std::fs::remove_file(lock).unwrap();
    let run = azimesh(path, &["finish", "out"]);
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["slab 2/2 has no step 3", "--slab 2/2 --resume"]);
    let again = slab(path, "2/2", &[]);
    assert_eq!(again.code, 2);
    assert_says(
        &again.err,
        &["holds 3 steps of this slab", "--resume", "--force"],
    );
    assert_eq!(slab(path, "2/2", &["--resume"]).code, 0);
    // A bit of the coordinates, and one of what is told of the cells.
    for at in [whole.len() - 9, 40] {
        let mut other = whole.clone();
        other[at] ^= 4;
        std::fs::write(&step, &other).unwrap();
        let run = azimesh(path, &["finish", "out"]);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(
            &run.err,
            &["step_0001.slab", "not a step of a slab as it was written"],
        );
        assert_eq!(slab(path, "2/2", &["--resume"]).code, 0);
        assert!(std::fs::read(&step).unwrap() == whole);
        let run = slab(path, "2/2", &["--force"]);
        assert_eq!(run.code, 0);
        assert!(std::fs::read(&step).unwrap() == whole);
    }
    succeed(path, &["-q", "finish", "out"]);
    succeed(path, &["-q", "deform", "b.vtkhdf", "b.toml", "-o", "one"]);
    assert!(left(&path.join("out")) == left(&path.join("one")));
    let run = azimesh(path, &["finish", "one"]);
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["the sequence in this folder is complete"]);
    assert_eq!(selections(&path.join("out")), selections(&path.join("one")));
}

#[test]
fn slabs_of_other_inputs_are_not_joined() {
    let folder = blade();
    let path = folder.path();
    assert_eq!(slab(path, "1/2", &[]).code, 0);
    rewrite(path, "b.toml", "b.toml", &[("sin = -7.65", "sin = -7.6")]);
    assert_eq!(slab(path, "2/2", &[]).code, 0);
    let run = azimesh(path, &["finish", "out"]);
    assert_eq!(run.code, 2);
    assert_says(
        &run.err,
        &[
            "slabs_2/slab_1",
            "slab 1/2 does not go with",
            "its schedule b.toml has changed since",
            "--slab 1/2 --force",
        ],
    );
    let run = slab(path, "1/2", &["--resume"]);
    assert_eq!(run.code, 2);
    assert_says(
        &run.err,
        &["another mesh, schedule, option or version", "--force"],
    );
    assert_eq!(slab(path, "1/2", &["--force"]).code, 0);
    assert_eq!(slab(path, "1/3", &[]).code, 0);
    let run = azimesh(path, &["finish", "out"]);
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["slabs_2 and slabs_3"]);
    std::fs::remove_dir_all(path.join("out/slabs_3")).unwrap();
    std::fs::rename(path.join("b.toml"), path.join("c.toml")).unwrap();
    let run = azimesh(path, &["finish", "out"]);
    assert_eq!(run.code, 2);
    assert_says(
        &run.err,
        &[
            "b.toml",
            "has to run in the folder in which they were written",
        ],
    );
    std::fs::rename(path.join("c.toml"), path.join("b.toml")).unwrap();
    succeed(path, &["-q", "finish", "out"]);
}

#[test]
fn where_an_outline_is_not_enough_slabs_read_the_whole_mesh() {
    let folder = crate::support::airfoil();
    let path = folder.path();
    succeed(path, &["-q", "convert", "n.vtu", "n.su2"]);
    for (mesh, format, reason) in [
        ("n.vtu", "vtu", "it has no solid cells"),
        ("n.su2", "vtkhdf", "not read by slabs"),
        ("n.vtu", "su2", "not written piece by piece"),
    ] {
        let args = ["deform", mesh, "n.toml", "--format", format, "-o"];
        succeed(path, &[&args[..], &["one", "-q"]].concat());
        for slab in ["2/3", "1/3", "3/3"] {
            let run = azimesh(path, &[&args[..], &["out", "--slab", slab]].concat());
            assert_eq!(run.code, 0, "{run:?}");
            assert_says(
                &run.err,
                &[mesh, "read whole, and takes the memory", reason],
            );
        }
        succeed(path, &["-q", "finish", "out"]);
        assert!(left(&path.join("out")) == left(&path.join("one")), "{mesh}");
        std::fs::remove_dir_all(path.join("out")).unwrap();
        std::fs::remove_dir_all(path.join("one")).unwrap();
    }
}

#[test]
fn base_points_of_an_interval_each_are_those_of_the_slabs() {
    let folder = blade();
    let path = folder.path();
    rewrite(
        path,
        "b.toml",
        "b.toml",
        &[("[selection]", "[selection]\nmethod = \"real\"")],
    );
    succeed(path, &["-q", "deform", "b.vtkhdf", "b.toml", "-o", "one"]);
    assert_eq!(slab(path, "1/2", &[]).code, 0);
    assert_eq!(slab(path, "2/2", &[]).code, 0);
    // The first is done again, from what the second has taken from it.
    let first = path.join("out/slabs_2/slab_1");
    std::fs::remove_file(first.join("run.json")).unwrap();
    std::fs::remove_file(first.join("step_0002.slab")).unwrap();
    assert_eq!(slab(path, "1/2", &["--resume"]).code, 0);
    succeed(path, &["-q", "finish", "out"]);
    assert!(left(&path.join("out")) == left(&path.join("one")));
    let of_one = selections(&path.join("one"));
    assert_eq!(selections(&path.join("out")), of_one);
    assert_eq!(of_one.as_array().unwrap().len(), 4);
}

#[test]
fn what_finish_would_refuse_is_not_begun() {
    let folder = blade();
    let path = folder.path();
    let surface = [("[rbf]", "[output]\nsurface = \"su2\"\n[rbf]")];
    rewrite(path, "b.toml", "b.toml", &surface);
    let run = slab(path, "1/2", &[]);
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["SU2 needs those of its own mesh"]);
    assert!(!path.join("out").exists());
}

#[test]
fn wrong_slabs_are_refused() {
    let folder = crate::support::airfoil();
    let path = folder.path();
    for (wrong, says) in [
        ("0/2", "\"0/2\" is not a slab"),
        ("3/2", "write I/N"),
        ("x", "write I/N"),
    ] {
        let run = azimesh(
            path,
            &["deform", "n.vtu", "n.toml", "-o", "out", "--slab", wrong],
        );
        assert_eq!(run.code, 2);
        assert!(run.err.contains(says), "{run:?}");
    }
    let both = [
        "deform", "n.vtu", "n.toml", "-o", "out", "--slab", "1/2", "--steps", "0..2",
    ];
    assert_eq!(azimesh(path, &both).code, 2);
    assert!(!path.join("out").exists());
}

#[test]
fn conditions_and_the_array_of_tags_are_those_of_the_slabs() {
    let folder = blade();
    let path = folder.path();
    succeed(path, &["-q", "convert", "b.vtkhdf", "c.vtu"]);
    let bytes = std::fs::read(path.join("c.vtu")).unwrap();
    let changed = replaced(&bytes, b"\"BoundaryTag\"", b"\"BoundaryTug\"");
    let changed = replaced(&changed, b"\"BoundaryTagNames\"", b"\"BoundaryTugNames\"");
    std::fs::write(path.join("d.vtu"), changed).unwrap();
    rewrite(
        path,
        "b.toml",
        "d.toml",
        &[("\"blade\"]", "\"1\"]"), ("\"outer\"", "\"2\"")],
    );
    let args = [
        "-q",
        "deform",
        "d.vtu",
        "d.toml",
        "--tag-array",
        "BoundaryTug",
        "-o",
    ];
    let strict = ["--fail-on", "min_scaled_jacobian<2"];
    assert_eq!(
        azimesh(path, &[&args[..], &["one"], &strict].concat()).code,
        1
    );
    for (slab, more) in [("1/2", &[][..]), ("2/2", &strict), ("2/2", &["--resume"])] {
        let run = azimesh(path, &[&args[..], &["out", "--slab", slab], more].concat());
        assert_eq!(run.code, 0, "{run:?}");
    }
    let run = azimesh(path, &["-q", "finish", "out"]);
    assert_eq!(run.code, 1, "{run:?}");
    assert_says(&run.err, &["min_scaled_jacobian<2 holds"]);
    assert!(left(&path.join("out")) == left(&path.join("one")));
}

/// Bytes with all of one sequence replaced by another.
fn replaced(bytes: &[u8], old: &[u8], new: &[u8]) -> Vec<u8> {
    let mut found = bytes.to_vec();
    let mut at = 0;
    while let Some(next) = found[at..].windows(old.len()).position(|some| some == old) {
        found.splice(at + next..at + next + old.len(), new.iter().copied());
        at += next + new.len();
    }
    found
}

#[test]
fn a_damaged_slab_never_reaches_the_sequence() {
    let folder = blade();
    let path = folder.path();
    // Steps that are repaired, and written from memory.
    rewrite(path, "b.toml", "b.toml", &[NARROW]);
    let format = ["--format", "vtkhdf"];
    for i in ["1/2", "2/2"] {
        assert_eq!(slab(path, i, &format).code, 0);
    }
    let step = path.join("out/slabs_2/slab_2/step_0001.slab");
    let whole = std::fs::read(&step).unwrap();
    let mut other = whole.clone();
    let at = other.len() - 900;
    other[at] ^= 1;
    std::fs::write(&step, &other).unwrap();
    let run = azimesh(path, &["-q", "finish", "out"]);
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["step_0001.slab"]);
    std::fs::write(&step, &whole).unwrap();
    succeed(path, &["-q", "finish", "out"]);
    succeed(
        path,
        &[
            &["-q", "deform", "b.vtkhdf", "b.toml", "-o", "one"],
            &format[..],
        ]
        .concat(),
    );
    assert!(left(&path.join("out")) == left(&path.join("one")));
    std::fs::write(&step, &other).unwrap();
    let _ = azimesh(path, &["-q", "finish", "out"]);
    assert!(left(&path.join("out")) == left(&path.join("one")));
}
