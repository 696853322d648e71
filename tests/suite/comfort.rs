//! What spares a user a second command: parts of a mesh, several files at once, what a folder lacks.

use crate::support::{airfoil, assert_says, azimesh, json, rewrite, succeed};
use serde_json::json as value;
use std::path::Path;

/// Two squares, the second folded over; tags low, up, side and rest; one edge is in low and in both.
const SQUARES: &str = "NDIME= 2\nNELEM= 2\n9 0 1 2 3 0\n9 3 2 5 4 1\nNPOIN= 6\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n0 2 4\n1 2 5\n\
NMARK= 4\nMARKER_TAG= low\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= up\nMARKER_ELEMS= 1\n3 4 5\nMARKER_TAG= side\n\
MARKER_ELEMS= 2\n3 1 2\n3 2 5\nMARKER_TAG= rest\nMARKER_ELEMS= 2\n3 0 3\n3 3 4\n";

fn squares() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.su2"), SQUARES).unwrap();
    folder
}

fn tags(path: &Path, mesh: &str) -> Vec<(String, u64)> {
    let found = json(path, ["info", mesh]);
    let tags = found["boundary_tags"].as_array().unwrap();
    let told = |tag: &serde_json::Value| {
        let name = tag["name"].as_str().unwrap().to_owned();
        (name, tag["faces"].as_u64().unwrap())
    };
    tags.iter().map(told).collect()
}

fn named(tags: &[(&str, u64)]) -> Vec<(String, u64)> {
    tags.iter()
        .map(|(name, n)| ((*name).to_owned(), *n))
        .collect()
}

#[test]
fn tags_are_dropped_kept_and_merged() {
    let folder = squares();
    let path = folder.path();
    let run = succeed(path, "convert m.su2 drop.vtu --drop-tag up --drop-tag side");
    assert_says(&run.err, &["--drop-tag: 3 boundary faces are removed"]);
    assert_eq!(tags(path, "drop.vtu"), named(&[("low", 1), ("rest", 2)]));
    assert_eq!(json(path, "info drop.vtu")["cells"], 5);
    succeed(path, "convert m.su2 keep.vtu --keep-tag side");
    assert_eq!(tags(path, "keep.vtu"), named(&[("side", 2)]));
    assert_eq!(json(path, "info keep.vtu")["open_faces"], 4);
    let merge = [
        "convert",
        "m.su2",
        "merge.vtu",
        "--merge-tags",
        "wall=low,up",
        "--merge-tags",
        "side=side,rest",
    ];
    succeed(path, merge);
    assert_eq!(tags(path, "merge.vtu"), named(&[("wall", 2), ("side", 4)]));
    for (arguments, told) in [
        (
            ["--drop-tag", "lo"],
            "--drop-tag: there is no tag \"lo\" (did you mean \"low\"?); there are: low, up, side, rest",
        ),
        (
            ["--keep-tag", "wing"],
            "--keep-tag: there is no tag \"wing\"; there are: low, up, side, rest",
        ),
        (
            ["--merge-tags", "rest=low,up"],
            "--merge-tags: there is a tag \"rest\" already; name it among those that are merged",
        ),
        (["--merge-tags", "rest"], "write NEW=A,B"),
    ] {
        let run = azimesh(
            path,
            [&["convert", "m.su2", "no.vtu"][..], &arguments[..]].concat(),
        );
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &[told]);
        assert!(!path.join("no.vtu").exists());
    }
}

#[test]
fn the_boundary_alone_and_the_volume_alone() {
    let folder = squares();
    let path = folder.path();
    succeed(path, "convert m.su2 edge.vtu --boundary-only");
    let edge = json(path, "info edge.vtu");
    assert_eq!((&edge["cells"], &edge["nodes"]), (&value!(6), &value!(6)));
    succeed(path, "convert m.su2 inside.vtu --volume-only");
    let inside = json(path, "info inside.vtu");
    assert_eq!(
        (&inside["cells"], &inside["boundary_tags"]),
        (&value!(2), &value!([]))
    );
    let both = azimesh(path, "convert m.su2 no.vtu --boundary-only --volume-only");
    assert_eq!(both.code, 2);
    let ball = crate::support::sequence::testdata("sphere_in_box_raw.vtu");
    let ball = ball.to_str().unwrap();
    let run = succeed(path, ["convert", ball, "skin.su2", "--boundary-only"]);
    assert_says(&run.err, &["--boundary-only: ", "inner nodes are removed"]);
    // Tags stay tags of a surface in space, which can be deformed.
    assert_eq!(tags(path, "skin.su2"), tags(path, ball));
    let run = azimesh(path, "convert inside.vtu no.vtu --boundary-only");
    assert_says(&run.err, &["the mesh has no boundary faces to keep"]);
}

#[test]
fn a_name_behind_o_that_ends_as_a_format_is_a_file() {
    let folder = squares();
    let path = folder.path();
    succeed(path, "convert m.su2 -o out.vtk");
    assert!(path.join("out.vtk").is_file());
    assert!(
        succeed(path, "diff m.su2 out.vtk --match position")
            .out
            .starts_with("same")
    );
    succeed(path, "convert m.su2 out.vtk -o both.pvd");
    assert!(path.join("both.pvd").is_file());
    succeed(path, "convert m.su2 -o folder --format msh");
    assert!(path.join("folder/m.msh").is_file());
    std::fs::create_dir(path.join("old.vtu")).unwrap();
    succeed(path, "convert m.su2 -o old.vtu --format vtu");
    assert!(path.join("old.vtu/m.vtu").is_file());
    let run = azimesh(path, "convert m.su2 -o plain");
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["-o DIR needs --format"]);
}

#[test]
fn info_tells_of_several_files_and_goes_on_past_a_bad_one() {
    let folder = squares();
    let path = folder.path();
    succeed(path, "convert m.su2 m.vtu");
    let run = azimesh(path, "info m.su2 none.vtu m.vtu");
    assert_eq!(run.code, 2);
    assert_says(&run.out, &["m.su2:\n", "m.vtu:\n", "boundary tags    4"]);
    assert_says(&run.err, &["none.vtu"]);
    let found = json(path, "info m.su2 m.vtu");
    assert_eq!(found["meshes"][1]["file"], "m.vtu");
    assert_eq!(found["meshes"][0]["nodes"], 6);
}

#[test]
fn info_flags_cells_that_no_solver_takes() {
    let folder = squares();
    let path = folder.path();
    std::fs::write(
        path.join("f.su2"),
        SQUARES.replace("9 3 2 5 4 1", "9 3 4 5 2 1"),
    )
    .unwrap();
    let text = succeed(path, "info f.su2").out;
    assert_says(
        &text,
        &["negative", "1 cell of negative volume (the first is cell"],
    );
    std::fs::write(
        path.join("d.su2"),
        SQUARES.replace("0 2 4", "0 1 4").replace("1 2 5", "1 1 5"),
    )
    .unwrap();
    let found = json(path, "info d.su2");
    assert_eq!(
        (&found["degenerate_cells"], &found["negative_cells"]),
        (&value!(1), &value!(0))
    );
    let good = json(path, "info m.su2");
    assert_eq!(
        (
            &good["degenerate_cells"],
            &good["negative_cells"],
            &good["folded_cells"]
        ),
        (&value!(0), &value!(0), &value!(0))
    );
}

#[test]
fn diff_tells_the_worst_step_and_compares_only_what_is_asked() {
    let folder = airfoil();
    let path = folder.path();
    rewrite(
        path,
        "n.toml",
        "few.toml",
        &[("step = 10.0", "step = 90.0")],
    );
    succeed(path, "-q deform n.vtu few.toml -o out");
    succeed(path, "-q convert out/n.pvd all.vtkhdf");
    let scaled = |step: &str, by: &str| {
        let (file, copy) = (format!("out/n_000{step}.vtu"), "scaled.vtu");
        succeed(
            path,
            format!("-q convert {file} {copy} --scale {by} --force"),
        );
        succeed(path, ["-q", "convert", copy, &file, "--force"]);
    };
    scaled("1", "1.001");
    scaled("3", "1.01");
    let run = azimesh(path, "diff out all.vtkhdf");
    assert_eq!(run.code, 1);
    assert_says(
        &run.out,
        &[
            "2 of 5 steps, the first is step 1: ",
            "; the worst is step 3, nodes up to ",
        ],
    );
    let found = json(path, "diff out all.vtkhdf");
    assert_eq!(found["worst_step"], 3);
    assert_eq!(found["max_distance"], found["steps"][3]["max_distance"]);
    assert!(found["max_distance"].as_f64() > found["steps"][1]["max_distance"].as_f64());
    // Its cells and tags are the same.
    for only in ["cells", "tags", "cells,tags,arrays"] {
        let run = succeed(path, ["diff", "out", "all.vtkhdf", "--only", only]);
        assert!(run.out.starts_with("same: 5 steps"), "{run:?}");
    }
    assert_eq!(azimesh(path, "diff out all.vtkhdf --only nodes").code, 1);
    let tagged = "-q convert n.vtu t.vtu --rename-tag airfoil=wing";
    succeed(path, tagged);
    assert_eq!(azimesh(path, "diff n.vtu t.vtu --only tags").code, 1);
    succeed(path, "diff n.vtu t.vtu --only nodes --only cells");
    assert_eq!(azimesh(path, "diff n.vtu t.vtu --only zones").code, 2);
}

#[test]
fn an_unfinished_folder_says_so_and_how_to_go_on() {
    let folder = airfoil();
    let path = folder.path();
    rewrite(
        path,
        "n.toml",
        "few.toml",
        &[("step = 10.0", "step = 90.0")],
    );
    let part = |steps: &str| {
        succeed(
            path,
            format!("-q deform n.vtu few.toml -o parts --steps {steps}"),
        )
    };
    part("0..2");
    part("4..5");
    let how = "steps 0..2, 4..5 of 5 are there; to finish it:  azimesh deform n.vtu few.toml -o parts --steps 2..4 ;  azimesh finish parts";
    for arguments in [
        "quality parts",
        "diff parts parts",
        "info parts",
        "convert parts x.pvd",
    ] {
        let run = azimesh(path, arguments);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(
            &run.err,
            &["the parts of the run in this folder are not joined", how],
        );
    }
    let run = succeed(path, "report parts");
    assert_says(&run.err, &[how]);
    // A run that was killed: its record says that it is running, and there is no list of its meshes.
    succeed(path, "-q deform n.vtu few.toml -o out");
    let record = std::fs::read_to_string(path.join("out/run.json")).unwrap();
    std::fs::write(
        path.join("out/run.json"),
        record.replace("\"steps_written\"", "\"not_written\""),
    )
    .unwrap();
    let how = "not finished, 5 of 5 steps are there: if nothing runs there any more, continue it with  azimesh deform n.vtu few.toml -o out --resume";
    let run = succeed(path, "quality out");
    assert_says(&run.err, &[how]);
    std::fs::remove_file(path.join("out/n.pvd")).unwrap();
    let run = azimesh(path, "quality out");
    assert_eq!(run.code, 2);
    assert_says(&run.err, &[how]);
    let found = json(path, "report out");
    let notes = &found["diagnostics"];
    assert_eq!(notes[0]["code"], "run_not_finished", "{notes:?}");
    let command = "azimesh deform n.vtu few.toml -o out --resume";
    assert_eq!(notes[0]["data"]["commands"][0], command);
}
