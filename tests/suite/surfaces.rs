//! STL and VTP: the surface of a mesh out, and in again.

use crate::support::sequence::testdata;
use crate::support::{airfoil, assert_says, azimesh, json, rewrite, succeed};
use serde_json::json as value;
use std::path::Path;

fn told(folder: &Path, mesh: &str) -> (u64, u64, Vec<(String, u64)>) {
    let found = json(folder, ["info", mesh]);
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
        format!("convert {mesh} b.vtu --boundary-only"),
    );
    (folder, mesh)
}

#[test]
fn vtp_is_the_boundary_with_tags_and_arrays() {
    let (folder, mesh) = solid();
    let folder = folder.path();
    let expected = told(folder, "b.vtu");
    for encoding in ["raw", "ascii"] {
        let args = format!("convert {mesh} b.vtp --force --encoding {encoding}");
        let run = succeed(folder, &args);
        assert_says(
            &run.err,
            &["VTP holds surfaces: the boundary alone is written"],
        );
        assert_eq!(told(folder, "b.vtp"), expected);
        // Faces turn outwards; nodes, tags and arrays are those of the boundary.
        let only = ["diff", "b.vtu", "b.vtp"];
        for part in ["nodes", "tags", "arrays"] {
            succeed(folder, [&only[..], &["--only", part]].concat());
        }
    }
    // Again, from the surface: the same.
    succeed(folder, "convert b.vtp c.vtp");
    succeed(folder, "diff b.vtp c.vtp");
}

#[test]
fn faces_of_tags_that_are_removed_are_in_no_surface() {
    let (folder, mesh) = solid();
    let folder = folder.path();
    let (_, _, tags) = told(folder, "b.vtu");
    // The sides: a part in one plane would be a plane mesh.
    let (kept, n) = tags[2].clone();
    let only = format!("--keep-tag {kept} --boundary-only");
    succeed(folder, format!("convert {mesh} k.vtu {only}"));
    let expected = told(folder, "k.vtu");
    assert_eq!((expected.1, &expected.2), (n, &vec![(kept.clone(), n)]));
    let keep = ["convert", &mesh, "k.vtp", "--keep-tag", &kept];
    let run = succeed(folder, keep);
    assert_says(&run.err, &["--keep-tag", "are left out ("]);
    assert_eq!(told(folder, "k.vtp"), expected);
    let drop: Vec<&str> = tags[..2].iter().map(|(name, _)| name.as_str()).collect();
    let drop = drop.iter().flat_map(|name| ["--drop-tag", *name]);
    let drop: Vec<&str> = ["convert", &mesh, "d.vtp"]
        .into_iter()
        .chain(drop)
        .collect();
    succeed(folder, &drop);
    assert_eq!(told(folder, "d.vtp"), expected);
    succeed(
        folder,
        format!("convert {mesh} k.stl --encoding ascii --keep-tag {kept}"),
    );
    let (nodes, _, found) = told(folder, "k.stl");
    assert_eq!((nodes, found.len(), &found[0].0), (expected.0, 1, &kept));
    // Nothing is left.
    let all = tags
        .iter()
        .flat_map(|(name, _)| ["--drop-tag", name.as_str()]);
    let all: Vec<&str> = ["convert", &mesh, "n.stl"].into_iter().chain(all).collect();
    let run = azimesh(folder, &all);
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["no boundary face is left"]);
}

#[test]
fn stl_is_the_boundary_in_triangles_with_tags_in_text() {
    let (folder, mesh) = solid();
    let folder = folder.path();
    let (nodes, _, tags) = told(folder, "b.vtu");
    let text = format!("convert {mesh} t.stl --encoding ascii");
    let run = succeed(folder, &text);
    assert_says(&run.err, &["cut into triangles (63)", "the boundary alone"]);
    let (n, triangles, found) = told(folder, "t.stl");
    assert_eq!((n, triangles), (nodes, 270 + 2 * 63));
    let names = |tags: &[(String, u64)]| tags.iter().map(|tag| tag.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&found), names(&tags));
    let run = succeed(folder, ["convert", "-o", "b.stl", &mesh]);
    assert_says(&run.err, &["binary STL has no tags", "--encoding ascii"]);
    assert_eq!(told(folder, "b.stl"), (nodes, triangles, Vec::new()));
    let size = std::fs::metadata(folder.join("b.stl")).unwrap().len();
    assert_eq!(size, 84 + 50 * triangles);
    let told = json(folder, ["convert", &mesh, "j.stl"]);
    assert_eq!(told["cells"], value!(triangles));
    let near = "diff t.stl b.stl --match position --only nodes";
    succeed(folder, format!("{near} --tolerance 1e-6"));
}

#[test]
fn the_surface_of_a_run_is_converted_and_is_no_format_of_a_run() {
    let folder = airfoil();
    let folder = folder.path();
    let stl = ("[rbf]", "[output]\nformat = \"stl\"\n[rbf]");
    rewrite(folder, "n.toml", "stl.toml", &[stl]);
    let deform = ["deform", "n.vtu", "stl.toml", "-o", "out"];
    let run = azimesh(folder, deform);
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["output.format", "convert DIR"]);
    succeed(folder, "deform n.vtu n.toml -o out --steps 0..2");
    let convert = "convert out/n_0000.vtu out/n_0001.vtu -o vtp --format vtp";
    succeed(folder, convert);
    assert_eq!(
        told(folder, "vtp/n_0001.vtp"),
        told(folder, "out/n_0001.vtu")
    );
    let quality = azimesh(folder, "quality vtp/n_0001.vtp");
    assert_eq!(quality.code, 0, "{quality:?}");
}

#[test]
fn zones_that_share_no_nodes_are_told_of_and_joined() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // Two cubes, one on the other, each with its own nodes.
    let points = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let nodes = [0, 1, 1, 2]
        .iter()
        .flat_map(|z| points.map(|[x, y]| format!("{x} {y} {z}\n")));
    let nodes: String = nodes.collect();
    let mesh = format!(
        "NDIME= 3\nNELEM= 2\n12 0 1 2 3 4 5 6 7\n12 8 9 10 11 12 13 14 15\nNPOIN= 16\n{nodes}NMARK= 1\nMARKER_TAG= low\n\
         MARKER_ELEMS= 1\n9 0 1 2 3\n"
    );
    std::fs::write(path.join("m.su2"), mesh).unwrap();
    let told = "of the outer faces without a tag, 2 lie on one another";
    for out in [&["case", "--format", "openfoam"][..], &["m.stl"]] {
        let run = succeed(path, [&["convert", "m.su2"], out].concat());
        assert_says(&run.err, &[told, "--join"]);
    }
    let run = succeed(path, "convert m.su2 one --format openfoam --join");
    assert_says(
        &run.err,
        &["pair by pair (1); 4 nodes are removed", "without a tag (9)"],
    );
    assert!(!run.err.contains("lie on one another"), "{}", run.err);
    let found = json(path, "info one");
    assert_eq!(
        (&found["nodes"], &found["cells"]),
        (&value!(12), &value!(12))
    );
}

#[test]
fn refusals_name_the_option_that_helps() {
    let folder = airfoil();
    let path = folder.path();
    let mesh = testdata("polyhedra_ascii.vtu").display().to_string();
    for out in ["p.su2", "p.msh", "p.ugrid"] {
        let run = azimesh(path, ["convert", &mesh, out]);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["cannot hold; --split-polyhedra makes"]);
        succeed(path, ["convert", &mesh, out, "--split-polyhedra"]);
    }
    // The turn back lays the plane flat again, with positive areas.
    for [away, turn] in [
        ["x,90", "x,-90"],
        ["x,-90", "x,90"],
        ["y,90", "y,-90"],
        ["y,-90", "y,90"],
    ] {
        let turned = |args: &[&str]| azimesh(path, [args, &["--force"]].concat());
        let run = turned(&["convert", "n.vtu", "t.vtu", "--rotate", away]);
        assert_eq!(run.code, 0, "{run:?}");
        let told = format!("; --rotate {turn} turns it into one");
        let run = turned(&["convert", "t.vtu", "t.su2"]);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(&run.err, &["constant z", &told]);
        let extrude = ["convert", "t.vtu", "e.vtu", "--extrude", "1"];
        assert_says(&turned(&extrude).err, &[&told]);
        let rotate = ["--rotate", turn];
        assert_eq!(turned(&[&extrude[..], &rotate].concat()).code, 0);
        let run = turned(&[&["convert", "t.vtu", "t.su2"][..], &rotate].concat());
        assert_eq!(run.code, 0, "{run:?}");
        assert!(!run.err.contains("negative"), "{run:?}");
        let over = format!(
            "{},{}",
            &turn[..1],
            if turn.contains('-') { 90 } else { -90 }
        );
        let run = turned(&["convert", "t.vtu", "t.su2", "--rotate", &over]);
        assert_says(&run.err, &["cells have a negative area", "clockwise"]);
    }
}

#[test]
fn files_that_are_cut_off_or_damaged_at_their_start_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let write = |name: &str, bytes: &[u8]| std::fs::write(path.join(name), bytes).unwrap();
    let hdf5 = std::fs::read(testdata("cgns/two_bases.cgns")).unwrap();
    for name in ["h.cgns", "h", "h.vtkhdf", "h.msh.h5"] {
        write(name, &hdf5[..hdf5.len() / 2]);
        let run = azimesh(path, ["info", name]);
        assert_eq!(run.code, 2, "{run:?}");
        assert_says(
            &run.err,
            &["the HDF5 file is cut off: it has 14897 bytes of the 29794"],
        );
    }
    let adf = std::fs::read(testdata("cgns/adf_version_b.cgns")).unwrap();
    for (mut bytes, at) in [(adf, 6), (hdf5, 1)] {
        bytes[at] ^= 0x55;
        write("d.cgns", &bytes);
        let run = azimesh(path, "info d.cgns");
        assert_eq!(run.code, 2, "{run:?}");
        let told = [
            "this is neither: it begins with",
            "HDF5 begins with",
            "\"ADF Database\"",
        ];
        assert_says(&run.err, &told);
    }
    for (name, told) in [
        ("adf_version_b", "CGNS in ADF"),
        ("two_bases", "CGNS in HDF5"),
    ] {
        let mesh = testdata(&format!("cgns/{name}.cgns")).display().to_string();
        assert_says(&succeed(path, ["info", &mesh]).out, &[told]);
    }
}
