//! STL and VTP: the surface of a mesh out, and in again.

use crate::support::sequence::testdata;
use crate::support::{airfoil, assert_says, azimesh, json, rewrite, succeed};
use serde_json::json as value;
use std::path::Path;

fn told(folder: &Path, mesh: &str) -> (u64, u64, Vec<(String, u64)>) {
    let found = json(folder, &["info", mesh]);
    let tags = found["boundary_tags"].as_array().unwrap();
    let tag = |tag: &serde_json::Value| {
        let name = tag["name"].as_str().unwrap().to_owned();
        (name, tag["faces"].as_u64().unwrap())
    };
    let count = |key: &str| found[key].as_u64().unwrap();
    (
        count("nodes"),
        count("cells"),
        tags.iter().map(tag).collect(),
    )
}

/// A solid mesh of every kind of cell, and its boundary as another format has it.
fn solid() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let mesh = testdata("mixed_cells_inline.vtu").display().to_string();
    succeed(
        folder.path(),
        &["convert", &mesh, "b.vtu", "--boundary-only"],
    );
    (folder, mesh)
}

#[test]
fn vtp_is_the_boundary_with_tags_and_arrays() {
    let (folder, mesh) = solid();
    let folder = folder.path();
    let expected = told(folder, "b.vtu");
    for encoding in ["raw", "ascii"] {
        let args = ["convert", &mesh, "b.vtp", "--force", "--encoding", encoding];
        let run = succeed(folder, &args);
        assert_says(
            &run.err,
            &["VTP holds surfaces: the boundary alone is written"],
        );
        assert_eq!(told(folder, "b.vtp"), expected);
        // Faces turn outwards; nodes, tags and arrays are those of the boundary.
        let only = ["diff", "b.vtu", "b.vtp"];
        for part in ["nodes", "tags", "arrays"] {
            succeed(folder, &[&only[..], &["--only", part]].concat());
        }
    }
    // Again, from the surface: the same.
    succeed(folder, &["convert", "b.vtp", "c.vtp"]);
    succeed(folder, &["diff", "b.vtp", "c.vtp"]);
}

#[test]
fn stl_is_the_boundary_in_triangles_with_tags_in_text() {
    let (folder, mesh) = solid();
    let folder = folder.path();
    let (nodes, _, tags) = told(folder, "b.vtu");
    let text = ["convert", &mesh, "t.stl", "--encoding", "ascii"];
    let run = succeed(folder, &text);
    assert_says(&run.err, &["cut into triangles (63)", "the boundary alone"]);
    let (n, triangles, found) = told(folder, "t.stl");
    assert_eq!((n, triangles), (nodes, 270 + 2 * 63));
    let names = |tags: &[(String, u64)]| tags.iter().map(|tag| tag.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&found), names(&tags));
    let run = succeed(folder, &["convert", "-o", "b.stl", &mesh]);
    assert_says(&run.err, &["binary STL has no tags", "--encoding ascii"]);
    assert_eq!(told(folder, "b.stl"), (nodes, triangles, Vec::new()));
    let size = std::fs::metadata(folder.join("b.stl")).unwrap().len();
    assert_eq!(size, 84 + 50 * triangles);
    let told = json(folder, &["convert", &mesh, "j.stl"]);
    assert_eq!(told["cells"], value!(triangles));
    let near = [
        "diff", "t.stl", "b.stl", "--match", "position", "--only", "nodes",
    ];
    succeed(folder, &[&near[..], &["--tolerance", "1e-6"]].concat());
}

#[test]
fn the_surface_of_a_run_is_converted_and_is_no_format_of_a_run() {
    let folder = airfoil();
    let folder = folder.path();
    let stl = ("[rbf]", "[output]\nformat = \"stl\"\n[rbf]");
    rewrite(folder, "n.toml", "stl.toml", &[stl]);
    let deform = ["deform", "n.vtu", "stl.toml", "-o", "out"];
    let run = azimesh(folder, &deform);
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["output.format", "convert DIR"]);
    succeed(
        folder,
        &["deform", "n.vtu", "n.toml", "-o", "out", "--steps", "0..2"],
    );
    let convert = [
        "convert",
        "out/n_0000.vtu",
        "out/n_0001.vtu",
        "-o",
        "vtp",
        "--format",
        "vtp",
    ];
    succeed(folder, &convert);
    assert_eq!(
        told(folder, "vtp/n_0001.vtp"),
        told(folder, "out/n_0001.vtu")
    );
    let quality = azimesh(folder, &["quality", "vtp/n_0001.vtp"]);
    assert_eq!(quality.code, 0, "{quality:?}");
}
