//! Fluent's files: read in every storage by the program, told apart from Gmsh's, not written.

use crate::support::{assert_says, azimesh, succeed};
use std::fs;
use std::path::Path;

/// A folder with the files of testdata/fluent.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir("testdata/fluent").unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    folder
}

fn info(folder: &Path, file: &str) -> serde_json::Value {
    serde_json::from_str(&succeed(folder, ["info", file, "--json"]).out).unwrap()
}

#[test]
fn a_mesh_is_the_same_from_text_binary_and_hdf5() {
    let folder = folder();
    for other in ["house.cas", "house.cas.h5"] {
        let run = succeed(folder.path(), ["diff", "house.msh", other]);
        assert_eq!((run.code, run.err.as_str()), (0, ""), "{run:?}");
    }
    let run = succeed(folder.path(), "diff polyhedra.cas.gz polyhedra.msh.h5");
    assert_eq!(run.code, 0, "{run:?}");
    let said = info(folder.path(), "house.cas.h5");
    assert_eq!(said["format"], "Fluent mesh or case in HDF5");
    let tags: Vec<_> = said["boundary_tags"].as_array().unwrap().iter().collect();
    let shown: Vec<String> = tags
        .iter()
        .map(|tag| format!("{} {} {}", tag["name"], tag["condition"], tag["faces"]))
        .collect();
    assert_eq!(
        shown,
        [
            "\"sides\" \"velocity-inlet\" 4",
            "\"floor\" \"wall\" 1",
            "\"tiles\" \"symmetry\" 4"
        ]
    );
}

#[test]
fn tags_zones_and_polyhedra_survive_a_conversion() {
    let folder = folder();
    for (file, out) in [
        ("house.msh", "a.vtu"),
        ("house.cas", "b.cgns"),
        ("polyhedra.cas.gz", "c.vtu"),
        ("polyhedra.msh.h5", "d.cgns"),
        ("refined.msh", "e.vtu"),
    ] {
        succeed(folder.path(), ["-q", "convert", file, out]);
        let run = succeed(folder.path(), ["diff", file, out, "--match", "position"]);
        assert_eq!(run.code, 0, "{file} {out}: {run:?}");
    }
    let run = succeed(folder.path(), "info refined.msh");
    assert_says(&run.err, &["refined with hanging nodes", "1 refined cell"]);
}

#[test]
fn a_name_of_gmsh_is_read_by_its_content_and_a_forced_format_says_what_the_file_is() {
    let folder = folder();
    fs::copy("testdata/mixed_cells_v22.msh", folder.path().join("g.msh")).unwrap();
    assert_eq!(
        info(folder.path(), "g.msh")["format"],
        "Gmsh MSH, text (.msh)"
    );
    assert_eq!(
        info(folder.path(), "house.msh")["format"],
        "Fluent mesh or case"
    );
    let run = azimesh(folder.path(), "info house.msh --format msh");
    assert_eq!(run.code, 2);
    assert_says(
        &run.err,
        &["it is a Fluent mesh, which is read as format fluent"],
    );
    let run = azimesh(folder.path(), "info g.msh --format fluent");
    assert_eq!(run.code, 2);
    assert_says(
        &run.err,
        &["g.msh:1: expected a section, which starts with \"(\""],
    );
}

#[test]
fn fluent_is_not_written_and_says_so() {
    let folder = folder();
    for (args, file) in [
        (vec!["convert", "house.msh", "out.cas"], "out.cas"),
        (vec!["convert", "house.msh", "out.cas.h5"], "out.cas.h5"),
        (
            vec!["convert", "house.msh", "out.vtu", "--format", "fluent"],
            "out.vtu",
        ),
    ] {
        let run = azimesh(folder.path(), &args);
        assert_eq!(run.code, 2, "{args:?} {run:?}");
        assert_says(
            &run.err,
            &["is read, not written; formats that are written: ", "cgns"],
        );
        assert!(!folder.path().join(file).exists());
    }
}
