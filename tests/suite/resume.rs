//! A run that did not come to its end, or whose files were damaged since, is gone on with to the same
//! bytes.

use crate::support::{
    Args, Run, airfoil, assert_says, azimesh, files, json, names, rewrite, succeed,
};
use std::collections::BTreeMap;
use std::path::Path;

/// Files of a folder by name; steps.csv without its seconds, and without run.json, which tells of each
/// run.
fn left(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(folder);
    for (name, content) in &mut files {
        if name.starts_with("steps") {
            let text = std::str::from_utf8(content).unwrap();
            let rows = text.lines().map(crate::support::without_seconds);
            *content = rows.collect::<Vec<_>>().join("\n").into_bytes();
        }
    }
    files.retain(|name, _| !name.starts_with("run"));
    files
}

fn assert_same(found: &Path, wanted: &Path, what: &str) {
    let (found, wanted) = (left(found), left(wanted));
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        wanted.keys().collect::<Vec<_>>(),
        "{what}"
    );
    for (name, content) in wanted {
        // Not assert_eq: nobody wants to read the bytes.
        assert!(found[&name] == content, "{what}: {name} is another");
    }
}

fn copy(from: &Path, to: &Path) {
    let _ = std::fs::remove_dir_all(to);
    std::fs::create_dir(to).unwrap();
    for (name, content) in files(from) {
        std::fs::write(to.join(name), content).unwrap();
    }
}

/// Leaves `n` whole rows in a table and a piece of the next.
fn cut_table(table: &Path, n: usize) {
    let text = std::fs::read_to_string(table).unwrap();
    let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at + 1).collect();
    std::fs::write(table, &text[..ends[n] + 17]).unwrap();
}

fn record(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("run.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// A pitching airfoil in seven steps, with more lines in some sections.
fn case(folder: &Path, changes: &[(&str, &str)]) {
    let all = [&[("step = 10.0", "step = 60.0")], changes].concat();
    rewrite(folder, "n.toml", "case.toml", &all);
}

fn deform(folder: &Path, out: &str, options: impl Args) -> Run {
    let args = ["deform", "n.vtu", "case.toml", "-o", out];
    azimesh(folder, [&args[..], &options.words()].concat())
}

#[test]
fn a_run_is_gone_on_with_to_the_same_bytes_in_every_format() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[]);
    let (whole, out) = (folder.join("whole"), folder.join("out"));
    for (format, file) in [
        ("vtu", "n_0004.vtu"),
        ("su2", "n_0004.su2"),
        ("vtk", "n_0004.vtk"),
        ("vtkhdf", "n.vtkhdf"),
        ("cgns", "n.cgns"),
    ] {
        let format = format!("--format {format}");
        let run = deform(folder, "whole", &format);
        assert_eq!(run.code, 0, "{run:?}");
        let resume = |what: &str| {
            let run = deform(folder, "out", format!("{format} --resume"));
            assert_eq!(run.code, 0, "{what}: {run:?}");
            assert_same(&out, &whole, &format!("{format:?}, {what}"));
            run
        };
        copy(&whole, &out);
        let run = resume("complete");
        assert!(run.out.starts_with("complete already: "), "{run:?}");
        assert_eq!(record(&out)["outcome"], "complete");
        cut_table(&out.join("steps.csv"), 3);
        std::fs::write(out.join(".azimesh_77-0.part"), "half").unwrap();
        std::fs::remove_file(out.join("n.pvd")).ok();
        let run = resume("four rows lost");
        assert!(
            run.out.starts_with("3 steps were finished before"),
            "{run:?}"
        );
        let mut bytes = std::fs::read(out.join(file)).unwrap();
        let middle = bytes.len() * 2 / 3;
        bytes[middle] ^= 1;
        std::fs::write(out.join(file), bytes).unwrap();
        let run = resume("damaged");
        assert!(run.err.starts_with("warning: "), "{run:?}");
        assert!(run.err.contains("step"), "{run:?}");
        let mut bytes = std::fs::read(out.join(file)).unwrap();
        bytes.extend(b"junk\n");
        std::fs::write(out.join(file), bytes).unwrap();
        let run = resume("longer than it was");
        assert!(run.err.starts_with("warning: "), "{run:?}");
        std::fs::remove_file(out.join(file)).unwrap();
        resume("lost");
        std::fs::remove_file(out.join("steps.csv")).unwrap();
        resume("no table");
        std::fs::remove_file(out.join("base.toml")).unwrap();
        cut_table(&out.join("steps.csv"), 5);
        resume("no base points");
        std::fs::remove_dir_all(&whole).unwrap();
    }
}

#[test]
fn arrays_precision_and_substeps_are_gone_on_with() {
    let folder = airfoil();
    let folder = folder.path();
    for (more, format) in [
        ("[rbf]\nsubsteps = 2", "vtkhdf"),
        ("[rbf]\nsubsteps = 2", "cgns"),
        ("[rbf]\nsubsteps = 2", "vtu"),
        (
            "[output]\nquality = \"cells\"\ndisplacement = true\n[rbf]",
            "vtkhdf",
        ),
        (
            "[output]\nquality = \"cells\"\nvelocity = true\n[rotor]\nrpm = 60.0\n[rbf]",
            "cgns",
        ),
        (
            "[output]\nprecision = \"f32\"\n[rbf]\nsubsteps = 2",
            "vtkhdf",
        ),
    ] {
        case(folder, &[("[rbf]", more)]);
        let format = format!("--format {format}");
        let run = deform(folder, "whole", format!("{format} --force"));
        assert_eq!(run.code, 0, "{more}: {run:?}");
        copy(&folder.join("whole"), &folder.join("out"));
        cut_table(&folder.join("out/steps.csv"), 4);
        let run = deform(folder, "out", format!("{format} --resume"));
        assert_eq!(run.code, 0, "{more}: {run:?}");
        assert!(!run.err.contains("written again"), "{more}: {run:?}");
        assert_same(&folder.join("out"), &folder.join("whole"), more);
    }
}

#[test]
fn base_points_chosen_along_the_way_are_taken_up_again() {
    let folder = airfoil();
    let folder = folder.path();
    case(
        folder,
        &[(
            "[selection]",
            "[selection]\nmethod = \"real\"\nrefresh = 120.0",
        )],
    );
    let (whole, out) = (folder.join("whole"), folder.join("out"));
    assert_eq!(deform(folder, "whole", []).code, 0);
    copy(&whole, &out);
    cut_table(&out.join("steps.csv"), 3);
    assert_eq!(deform(folder, "out", "--resume").code, 0);
    assert_same(&out, &whole, "real");
    let (now, then) = (record(&out), record(&whole));
    assert_eq!(now["selections"], then["selections"]);
    assert_eq!(now["base_files"], then["base_files"]);
    assert_eq!(
        (&now["resumed"], &now["steps_kept"]),
        (&1.into(), &3.into())
    );
    // Points that are not those of the run are chosen anew.
    let base = out.join("base_0004.toml");
    let other = std::fs::read_to_string(&base).unwrap();
    let other = other.replace("error = ", "error = 1");
    std::fs::write(&base, other).unwrap();
    cut_table(&out.join("steps.csv"), 3);
    assert_eq!(deform(folder, "out", "--resume").code, 0);
    assert_same(&out, &whole, "real, with other base points");
}

#[test]
fn a_part_is_gone_on_with_alone() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[]);
    for format in ["vtu", "vtkhdf"] {
        let part = format!("--format {format} --steps 2..6");
        assert_eq!(deform(folder, "whole", format!("{part} --force")).code, 0);
        copy(&folder.join("whole"), &folder.join("out"));
        cut_table(&folder.join("out/steps_2-6.csv"), 2);
        assert_eq!(deform(folder, "out", format!("{part} --resume")).code, 0);
        assert_same(&folder.join("out"), &folder.join("whole"), format);
        std::fs::remove_dir_all(folder.join("whole")).unwrap();
    }
}

#[test]
fn only_the_same_run_is_gone_on_with() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[]);
    let fresh = deform(folder, "out", "--resume");
    assert_eq!(fresh.code, 0, "there is nothing yet: {fresh:?}");
    let before = files(&folder.join("out"));
    let refused = |options: &str, reason: &[&str]| {
        let run = deform(folder, "out", format!("{options} --resume"));
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, reason);
        assert!(
            files(&folder.join("out")) == before,
            "nothing is written: {reason:?}"
        );
    };
    refused("--format su2", &["format", "\"vtu\"", "\"su2\"", "--force"]);
    refused(
        "--tag-array BoundaryTag",
        &["tag_array", "null", "\"BoundaryTag\""],
    );
    succeed(folder, "-q select n.vtu case.toml -o b.toml");
    refused("--base b.toml", &["input files"]);
    case(folder, &[("sin = 10.0", "sin = 9.0")]);
    refused("", &["schedule case.toml", "changed"]);
    case(folder, &[]);
    let mesh = std::fs::read(folder.join("n.vtu")).unwrap();
    let sample = "-q sample naca0012 --nodes 900 -o n.vtu --force";
    succeed(folder, sample);
    case(folder, &[]);
    refused("", &["mesh n.vtu", "changed"]);
    std::fs::write(folder.join("n.vtu"), mesh).unwrap();
    let both = deform(folder, "out", "--resume --force");
    assert_eq!(both.code, 2, "{both:?}");
    std::fs::remove_file(folder.join("out/run.json")).unwrap();
    std::fs::remove_file(folder.join("out/steps.csv")).unwrap();
    let run = deform(folder, "out", "--resume");
    assert!(
        run.code == 2 && run.err.contains("but no whole run.json"),
        "{run:?}"
    );
}

/// A pitching airfoil over so much time, 51 steps in a second.
fn timed(folder: &Path, stop: &str) {
    rewrite(
        folder,
        "n.toml",
        "case.toml",
        &[
            ("[azimuth]", "[time]"),
            ("stop = 360.0", &format!("stop = {stop}\nfrequency = 1.0")),
            ("step = 10.0", "step = 0.02"),
        ],
    );
}

#[test]
fn steps_are_added_to_a_finished_run() {
    let folder = airfoil();
    let folder = folder.path();
    let out = folder.join("out");
    for format in ["vtu", "vtkhdf", "cgns"] {
        let format = format!("--format {format}");
        let resume = || deform(folder, "out", format!("{format} --resume"));
        timed(folder, "1.0");
        assert_eq!(deform(folder, "out", &format).code, 0);
        cut_table(&out.join("steps.csv"), 20);
        assert_eq!(resume().code, 0, "{format:?}");
        let before = files(&out);
        timed(folder, "1.4");
        let run = resume();
        assert_eq!(run.code, 0, "{format:?}: {run:?}");
        assert_eq!(run.err, "", "{format:?}");
        assert!(
            run.out.starts_with("51 steps were finished before"),
            "{run:?}"
        );
        let after = left(&out);
        let meshes = before.keys().filter(|name| name.ends_with(".vtu"));
        for name in meshes.chain([&"base.toml".to_owned()]) {
            assert!(before[name] == after[name], "{format:?}: {name}");
        }
        let table = |files: &BTreeMap<String, Vec<u8>>| {
            String::from_utf8(files["steps.csv"].clone()).unwrap()
        };
        assert!(table(&files(&out)).starts_with(&table(&before)));
        assert_eq!(table(&after).lines().count(), 72);
        let record = record(&out);
        assert_eq!(
            (&record["outcome"], &record["steps"], &record["extended"]),
            (&"complete".into(), &71.into(), &serde_json::json!([51]))
        );
        assert_eq!(record["selections"][0]["steps"], 71);
        // An addition that was interrupted.
        cut_table(&out.join("steps.csv"), 60);
        let run = resume();
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{format:?}");
        assert!(left(&out) == after, "{format:?}");
        let judged = json(folder, "quality out");
        assert_eq!(judged["steps"].as_array().unwrap().len(), 71);
        let run = azimesh(folder, "report out -o r.html --force");
        assert!(run.out.contains("71 steps"), "{run:?}");
        assert!(!run.err.contains("not finished"), "{run:?}");
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn steps_that_cannot_be_added_are_refused_with_numbers() {
    let folder = airfoil();
    let folder = folder.path();
    timed(folder, "0.04");
    assert_eq!(deform(folder, "out", []).code, 0);
    let before = files(&folder.join("out"));
    let refused = |options: &str, code: i32, reason: &[&str]| {
        let run = deform(folder, "out", options);
        assert_eq!((run.code, run.out.as_str()), (code, ""), "{run:?}");
        assert_says(&run.err, reason);
        assert!(files(&folder.join("out")) == before, "{reason:?}");
    };
    timed(folder, "0.02");
    refused("--resume", 2, &["3 steps", "2 now"]);
    timed(folder, "0.4");
    refused(
        "--steps 3..21",
        2,
        &["0..3", "--resume without --steps", "3..21"],
    );
    rewrite(
        folder,
        "case.toml",
        "case.toml",
        &[("step = 0.02", "step = 0.01")],
    );
    refused(
        "--resume",
        2,
        &["step 1 (azimuth 7.2", "step 1 (azimuth 3.6"],
    );
    timed(folder, "0.4");
    std::fs::rename(folder.join("out/base.toml"), folder.join("b")).unwrap();
    let run = deform(folder, "out", "--resume");
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(
        &run.err,
        &["base.toml", "base points of the finished steps"],
    );
    std::fs::rename(folder.join("b"), folder.join("out/base.toml")).unwrap();
    // Chosen for a pitch of 2.5 degrees, they do not serve one of ten.
    let numbers = [
        "tolerance 1e-4",
        "base points leave an error of",
        "the added steps need more",
    ];
    refused("--resume", 1, &numbers);
    // A comment is no change of the motion.
    timed(folder, "0.04");
    let text = std::fs::read_to_string(folder.join("case.toml")).unwrap();
    std::fs::write(folder.join("case.toml"), text + "# a comment\n").unwrap();
    let run = deform(folder, "out", "--resume");
    assert!(
        run.code == 0 && run.out.starts_with("complete already"),
        "{run:?}"
    );
}

/// A file without what a power cut has taken of it.
fn lose(path: &Path, how: &str) {
    let content = std::fs::read(path).unwrap();
    match how {
        "empty" => std::fs::write(path, "").unwrap(),
        "cut" => std::fs::write(path, &content[..content.len() / 2]).unwrap(),
        "zeros" => std::fs::write(path, vec![0; content.len()]).unwrap(),
        _ => std::fs::remove_file(path).unwrap(),
    }
}

#[test]
fn a_record_that_is_lost_costs_no_finished_step() {
    let folder = airfoil();
    let folder = folder.path();
    let (whole, out) = (folder.join("whole"), folder.join("out"));
    let arrays = "[output]\nquality = \"cells\"\ndisplacement = true\n[rbf]";
    let real = "[selection]\nmethod = \"real\"\nrefresh = 120.0";
    for (format, more) in [
        ("vtu", arrays),
        ("su2", "[rbf]\nsubsteps = 2"),
        ("msh", "[rbf]"),
        ("vtkhdf", arrays),
        ("cgns", "[rbf]\nsubsteps = 2"),
        ("vtu", real),
    ] {
        let section = if more == real { "[selection]" } else { "[rbf]" };
        case(folder, &[(section, more)]);
        let format = format!("--format {format}");
        assert_eq!(deform(folder, "whole", &format).code, 0);
        for how in ["empty", "cut", "zeros", "missing"] {
            copy(&whole, &out);
            cut_table(&out.join("steps.csv"), 4);
            lose(&out.join("run.json"), how);
            if how == "zeros" {
                let mut names = names(&out).into_iter();
                let base = names.find(|name| name.starts_with("base")).unwrap();
                lose(&out.join(base), "empty");
                let table = std::fs::read(out.join("steps.csv")).unwrap();
                let with_tail = [&table[..], &[0; 99], b"\n4,\xff\n3,nonsense\n"].concat();
                std::fs::write(out.join("steps.csv"), with_tail).unwrap();
            }
            let first = names(&out)
                .into_iter()
                .find(|name| name.starts_with("n_0003"))
                .map(|name| out.join(name));
            let modified = || {
                first
                    .as_ref()
                    .map(|path| std::fs::metadata(path).unwrap().modified().unwrap())
            };
            let before = modified();
            let run = deform(folder, "out", format!("{format} --resume"));
            let what = format!("{format:?}, {how}");
            assert_eq!(run.code, 0, "{what}: {run:?}");
            assert!(
                run.out.starts_with("4 steps were finished before"),
                "{what}: {run:?}"
            );
            assert!(
                run.err.contains("finished steps are computed again"),
                "{what}: {run:?}"
            );
            assert!(!run.err.contains("is computed again:"), "{what}: {run:?}");
            assert_eq!(modified(), before, "{what}");
            assert_same(&out, &whole, &what);
            let run = deform(folder, "out", format!("{format} --resume"));
            assert!(run.out.starts_with("complete already"), "{what}: {run:?}");
        }
        // Without a table nothing is known to be finished.
        copy(&whole, &out);
        lose(&out.join("run.json"), "empty");
        lose(&out.join("steps.csv"), "empty");
        let run = deform(folder, "out", format!("{format} --resume"));
        assert_eq!(run.code, 0, "{format:?}: {run:?}");
        assert_same(&out, &whole, "no rows");
        std::fs::remove_dir_all(&whole).unwrap();
    }
}

#[test]
fn a_lost_record_lets_no_other_inputs_in() {
    let folder = airfoil();
    let folder = folder.path();
    for format in ["vtu", "cgns"] {
        case(folder, &[]);
        let options = format!("--format {format}");
        let resume = || deform(folder, "out", format!("{options} --resume"));
        assert_eq!(deform(folder, "out", &options).code, 0);
        let before = left(&folder.join("out"));
        std::fs::write(folder.join("out/run.json"), "").unwrap();
        case(folder, &[("sin = 10.0", "sin = 9.0")]);
        assert_eq!(deform(folder, "whole", &options).code, 0);
        let run = resume();
        if format == "vtu" {
            // Whole files of another run are not written over unasked.
            assert_eq!(run.code, 2, "{run:?}");
            assert_says(&run.err, &["n_0001.vtu", "step 1", "--force"]);
            let after = left(&folder.join("out"));
            let kept = |name: &&String| name.ends_with(".vtu") || name.ends_with(".csv");
            assert!(
                before
                    .keys()
                    .filter(kept)
                    .all(|name| after[name] == before[name])
            );
            assert!(before.keys().eq(after.keys()));
            case(folder, &[("step = 60.0", "step = 45.0")]);
            let run = resume();
            assert_eq!(run.code, 2, "{run:?}");
            assert_says(&run.err, &["step 1", "azimuth 60", "45", "--force"]);
            case(folder, &[]);
            assert_eq!(resume().code, 0);
            assert!(left(&folder.join("out")) == before);
        } else {
            assert_eq!(run.code, 0, "{run:?}");
            assert_says(&run.err, &["written again"]);
            assert_same(&folder.join("out"), &folder.join("whole"), "other inputs");
        }
        for name in ["out", "whole"] {
            std::fs::remove_dir_all(folder.join(name)).unwrap();
        }
    }
}

#[test]
fn repaired_steps_outlive_the_loss_of_the_record() {
    let folder = airfoil();
    let folder = folder.path();
    let substeps = ("[rbf]", "[output]\non_inverted = \"substeps\"\n[rbf]");
    case(folder, &[("sin = 10.0", "sin = 100.0"), substeps]);
    for format in ["vtu", "vtkhdf"] {
        let format = format!("--format {format}");
        let first = deform(folder, "whole", &format);
        assert!(first.err.contains("inverted cells: "), "{first:?}");
        copy(&folder.join("whole"), &folder.join("out"));
        cut_table(&folder.join("out/steps.csv"), 5);
        lose(&folder.join("out/run.json"), "empty");
        let run = deform(folder, "out", format!("{format} --resume"));
        assert_eq!(run.code, first.code, "{run:?}");
        assert!(
            !run.err.contains("again from there") && !run.err.contains("is computed again:"),
            "{run:?}"
        );
        assert_same(&folder.join("out"), &folder.join("whole"), "repaired");
        let repairs = |out: &str| record(&folder.join(out))["repairs"].clone();
        assert_eq!(repairs("out"), repairs("whole"));
        std::fs::remove_dir_all(folder.join("whole")).unwrap();
    }
}

#[test]
fn a_mesh_that_was_renamed_since_is_told_of() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[]);
    for format in ["vtu", "cgns"] {
        assert_eq!(deform(folder, "out", ["--format", format]).code, 0);
        let out = folder.join("out");
        cut_table(&out.join("steps.csv"), 4);
        std::fs::rename(folder.join("n.vtu"), folder.join("m.vtu")).unwrap();
        let resume = |mesh: &str| {
            let args = format!("deform {mesh} case.toml -o out --resume --format {format}");
            azimesh(folder, args)
        };
        let before = files(&out);
        let (old, new) = match format {
            "vtu" => ("n_0000.vtu", "m_0000.vtu"),
            _ => ("n.cgns", "m.cgns"),
        };
        let run = resume("m.vtu");
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, &["n.vtu", "step 0", old, new]);
        assert!(files(&out) == before);
        lose(&out.join("run.json"), "empty");
        let run = resume("m.vtu");
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["step 0", old, new]);
        std::fs::rename(folder.join("m.vtu"), folder.join("n.vtu")).unwrap();
        assert_eq!(resume("n.vtu").code, 0);
        std::fs::remove_dir_all(out).unwrap();
    }
}

#[test]
fn what_was_wrong_with_finished_steps_is_told_again() {
    let folder = airfoil();
    let folder = folder.path();
    case(folder, &[("sin = 10.0", "sin = 170.0")]);
    let whole = deform(folder, "out", "--json --fail-on max_skew>0.1");
    assert_eq!(whole.code, 1, "{whole:?}");
    let then: serde_json::Value = serde_json::from_str(&whole.out).unwrap();
    cut_table(&folder.join("out/steps.csv"), 4);
    let args = "deform n.vtu case.toml -o out --resume --fail-on max_skew>0.1";
    let now = json(folder, args);
    for key in [
        "steps",
        "inverted_steps",
        "max_inverted",
        "min_scaled_jacobian",
        "failures",
        "base_points",
    ] {
        assert_eq!(now[key], then[key], "{key}");
    }
    assert_eq!(azimesh(folder, args).code, 1);
}

#[test]
fn bad_steps_are_passed_over_when_asked() {
    let folder = airfoil();
    let folder = folder.path();
    let stop = ("[rbf]", "[output]\non_inverted = \"stop\"\n[rbf]");
    case(folder, &[("sin = 10.0", "sin = 170.0"), stop]);
    let stopped = deform(folder, "out", []);
    assert_eq!(stopped.code, 1, "{stopped:?}");
    assert!(
        stopped.err.contains("step 1 (azimuth 60 degrees) has"),
        "{stopped:?}"
    );
    assert!(
        stopped.err.contains("stopped before writing it"),
        "{stopped:?}"
    );
    let went_on = deform(folder, "out", "--resume --keep-going");
    assert_eq!(went_on.code, 1, "{went_on:?}");
    assert!(went_on.err.contains("; skipped"), "{went_on:?}");
    let names: Vec<String> = files(&folder.join("out")).into_keys().collect();
    let meshes: Vec<&String> = names.iter().filter(|name| name.ends_with(".vtu")).collect();
    assert_eq!(meshes, ["n_0000.vtu", "n_0003.vtu", "n_0006.vtu"]);
    let record = record(&folder.join("out"));
    assert_eq!(record["outcome"], "complete but for 4 steps");
    assert_eq!(record["skipped_steps"].as_array().unwrap().len(), 4);
    let table = std::fs::read_to_string(folder.join("out/steps.csv")).unwrap();
    assert_eq!(table.lines().count(), 4);
}

#[test]
fn inverted_cells_are_repaired_by_substeps() {
    let folder = airfoil();
    let folder = folder.path();
    let substeps = ("[rbf]", "[output]\non_inverted = \"substeps\"\n[rbf]");
    for pitch in ["sin = 100.0", "sin = 170.0"] {
        case(folder, &[("sin = 10.0", pitch), substeps]);
        let run = deform(folder, "whole", "--force");
        assert!(run.err.contains("inverted cells: "), "{run:?}");
        let repairs = record(&folder.join("whole"))["repairs"].clone();
        assert!(!repairs.as_array().unwrap().is_empty());
        for repair in repairs.as_array().unwrap() {
            assert!(repair["inverted"].as_u64() <= repair["inverted_before"].as_u64());
        }
        // The same meshes in parts and when gone on with, in one file too.
        copy(&folder.join("whole"), &folder.join("out"));
        cut_table(&folder.join("out/steps.csv"), 3);
        assert_eq!(deform(folder, "out", "--resume").code, run.code);
        assert_same(&folder.join("out"), &folder.join("whole"), pitch);
        assert_eq!(record(&folder.join("out"))["repairs"], repairs);
        deform(folder, "part", "--steps 4..7 --force");
        for (name, content) in files(&folder.join("part")) {
            if name.ends_with(".vtu") {
                assert!(files(&folder.join("whole"))[&name] == content, "{name}");
            }
        }
        let in_one = "--format vtkhdf";
        deform(folder, "one", format!("{in_one} --force"));
        copy(&folder.join("one"), &folder.join("out"));
        cut_table(&folder.join("out/steps.csv"), 5);
        let run = deform(folder, "out", format!("{in_one} --resume"));
        assert!(!run.err.contains("written again"), "{run:?}");
        assert_same(&folder.join("out"), &folder.join("one"), pitch);
    }
}

/// A folder with `case.toml`, a schedule of 721 steps.
#[cfg(unix)]
fn long() -> tempfile::TempDir {
    let folder = airfoil();
    let many = [("step = 10.0", "step = 0.5")];
    rewrite(folder.path(), "n.toml", "case.toml", &many);
    folder
}

/// A run under way that has finished a step or two.
#[cfg(unix)]
fn begun(folder: &Path, out: &str) -> std::process::Child {
    let program = std::process::Command::new(assert_cmd::cargo::cargo_bin("azimesh"));
    begun_by(program, folder, out)
}

/// The same by a command that goes before the arguments.
#[cfg(unix)]
fn begun_by(mut command: std::process::Command, folder: &Path, out: &str) -> std::process::Child {
    let args = ["deform", "n.vtu", "case.toml", "-q", "-o", out];
    let child = command.current_dir(folder).args(args).spawn().unwrap();
    let table = folder.join(out).join("steps.csv");
    let rows = || std::fs::read_to_string(&table).map_or(0, |text| text.lines().count());
    while rows() < 3 {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_run_between_two_steps() {
    let folder = long();
    let folder = folder.path();
    assert_eq!(deform(folder, "whole", "-q").code, 0);
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let mut child = begun(folder, "out");
        let asked = std::process::Command::new("kill")
            .args([&format!("-{signal}"), &child.id().to_string()])
            .status();
        assert!(asked.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        let out = folder.join("out");
        let outcome = record(&out)["outcome"].clone();
        assert!(
            outcome.as_str().unwrap().starts_with("interrupted; "),
            "{outcome}"
        );
        let table = std::fs::read_to_string(out.join("steps.csv")).unwrap();
        let names: Vec<String> = files(&out).into_keys().collect();
        let meshes = names.iter().filter(|name| name.ends_with(".vtu")).count();
        assert_eq!(table.lines().count(), 1 + meshes, "a row for each mesh");
        assert!(!names.iter().any(|name| name.starts_with('.')), "{names:?}");
        assert_eq!(deform(folder, "out", "-q --resume").code, 0);
        assert_same(&out, &folder.join("whole"), signal);
        std::fs::remove_dir_all(out).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_run_under_nohup_outlives_its_terminal() {
    let folder = airfoil();
    let folder = folder.path();
    rewrite(folder, "n.toml", "case.toml", &[]);
    let mut nohup = std::process::Command::new("sh");
    nohup.args(["-c", "trap '' HUP; exec \"$0\" \"$@\""]);
    nohup.arg(assert_cmd::cargo::cargo_bin("azimesh"));
    let mut child = begun_by(nohup, folder, "out");
    let asked = std::process::Command::new("kill")
        .args(["-HUP", &child.id().to_string()])
        .status();
    assert!(asked.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(folder.join("out/n_0036.vtu").is_file());
}

#[cfg(unix)]
#[test]
fn two_runs_do_not_write_the_same_steps() {
    let folder = long();
    let folder = folder.path();
    let mut child = begun(folder, "out");
    for options in ["--force", "--resume", "--steps 100..200"] {
        let run = deform(folder, "out", options);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{run:?}");
        assert_says(&run.err, &["another run", "0..721"]);
    }
    let joined = azimesh(folder, "finish out");
    assert_eq!(joined.code, 2, "{joined:?}");
    child.kill().unwrap();
    child.wait().unwrap();
    let run = deform(folder, "out", "-q --resume");
    assert_eq!(run.code, 0, "a killed run holds nothing: {run:?}");
    let names: Vec<String> = files(&folder.join("out")).into_keys().collect();
    assert!(!names.iter().any(|name| name.starts_with('.')), "{names:?}");
}
