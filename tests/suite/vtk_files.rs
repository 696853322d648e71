//! Legacy, structured and partitioned files written by VTK (`testdata/vtk/`): files of one grid are one mesh.

use crate::support::sequence::{read, testdata};
use crate::support::{azimesh, json};
use azimesh::{CellKind, Encoding, Mesh, WriteOptions};
use azimesh_core::geometry::vector::{cross, dot, sub};
use azimesh_io::mesh::difference::{Difference, Tolerance};
use std::path::Path;

/// How the mesh of one file differs from that of another: at all, or where one is text by more than
/// the digits that VTK writes, eleven, and six of single precision.
fn difference(names: [&str; 2]) -> Difference {
    let [a, b] = names.map(|name| read(&testdata("vtk").join(name)));
    assert!(!a.cells.is_empty());
    let has = |part: &str| names.iter().any(|name| name.contains(part));
    let value = match (has("ascii"), has("mixed")) {
        (false, _) => 0.0,
        (true, false) => 1e-10,
        (true, true) => 1e-5,
    };
    let tolerance = Tolerance {
        value,
        relative: true,
    };
    Difference::between(&a, &b, tolerance)
}

#[test]
fn every_legacy_version_in_text_and_binary_is_the_same_mesh() {
    for version in ["2.0", "3.0", "4.2", "5.1"] {
        for kind in ["ascii", "binary"] {
            let name = format!("tetrahedra_{version}_{kind}.vtk");
            let found = difference(["tetrahedra_5.1_binary.vtk", &name]);
            assert!(found.is_same(), "{name}: {found:?}");
        }
    }
    let found = difference(["mixed_4.2_ascii.vtk", "mixed_5.1_binary.vtk"]);
    assert!(found.is_same(), "{found:?}");
}

#[test]
fn structured_and_rectilinear_grids_are_the_same_in_xml_and_legacy_files() {
    for (name, xml) in [
        ("structured", "structured.vts"),
        ("rectilinear", "rectilinear.vtr"),
        ("surface", "surface.vtp"),
    ] {
        let found = difference([&format!("{name}_ascii.vtk"), xml]);
        assert!(found.is_same(), "{name}: {found:?}");
    }
}

#[test]
fn pieces_are_joined_at_the_nodes_that_they_share() {
    let whole = read(&testdata("vtk").join("tetrahedra_5.1_binary.vtk"));
    let joined = read(&testdata("vtk").join("tetrahedra.pvtu"));
    assert_eq!(joined.points.len(), whole.points.len());
    assert_eq!(joined.cells.len(), whole.cells.len());
    let place = |mesh: &azimesh_io::mesh::Mesh, cell: usize| -> Vec<[f64; 3]> {
        let nodes = mesh.cells.get(cell).nodes.iter();
        nodes.map(|&node| mesh.points[node as usize]).collect()
    };
    for cell in 0..whole.cells.len() {
        assert_eq!(place(&joined, cell), place(&whole, cell), "cell {cell}");
    }
    let faces = |mesh: &azimesh_io::mesh::Mesh| -> Vec<(String, usize)> {
        let tags = mesh.boundary_tags();
        tags.map(|tag| (tag.name.clone(), tag.cells.len()))
            .collect()
    };
    assert_eq!(faces(&joined), faces(&whole));
}

/// A column of two wedges of positive volume in the order of a mesh, or in the other orientation.
fn wedges(is_inverted: bool) -> Mesh {
    let corner = |i: u32| [f64::from(i % 3 % 2), f64::from(i % 3 / 2), f64::from(i / 3)];
    let mut mesh = Mesh {
        points: (0..9).map(corner).collect(),
        ..Mesh::default()
    };
    for first in [0, 3] {
        let nodes = if is_inverted {
            [0, 2, 1, 3, 5, 4]
        } else {
            [0, 1, 2, 3, 4, 5]
        };
        let nodes = nodes.map(|node: u32| first + node);
        mesh.cells.push(CellKind::Wedge, &nodes);
    }
    mesh
}

/// The signs of the volumes of the cells of a file, and what the reader notes.
fn volumes(path: &Path) -> (Vec<bool>, String) {
    let loaded = Mesh::read_with(path, &Default::default()).unwrap();
    let mesh = loaded.mesh;
    let positive = mesh.cells.iter().map(|cell| {
        let at = |i: usize| mesh.points[cell.nodes[i] as usize];
        let [a, b, c, d] = [0, 1, 2, 3].map(at);
        dot(cross(sub(b, a), sub(c, a)), sub(d, a)) > 0.0
    });
    let notes: Vec<String> = loaded.notes.iter().map(ToString::to_string).collect();
    (positive.collect(), notes.join("\n"))
}

#[test]
fn written_wedges_have_the_order_of_vtk_9_6_and_keep_their_sign() {
    let folder = tempfile::tempdir().unwrap();
    for is_inverted in [false, true] {
        let mesh = wedges(is_inverted);
        for name in ["m.vtu", "m.vtk", "m.vtkhdf", "ascii.vtu", "ascii.vtk"] {
            let path = folder.path().join(name);
            let options = WriteOptions {
                encoding: if name.contains("ascii") {
                    Encoding::Ascii
                } else {
                    Encoding::Raw
                },
                ..WriteOptions::default()
            };
            mesh.view().write_with(&path, &options).unwrap();
            if name.contains("ascii") {
                let text = std::fs::read_to_string(&path).unwrap();
                let words: Vec<&str> = text.split_whitespace().collect();
                let wanted = if is_inverted {
                    ["0", "1", "2", "3", "4", "5", "3", "4", "5"]
                } else {
                    ["0", "2", "1", "3", "5", "4", "3", "5", "4"]
                };
                assert!(words.windows(9).any(|some| some == wanted), "{text}");
            }
            let (positive, notes) = volumes(&path);
            assert_eq!(positive, [!is_inverted; 2], "{name}");
            assert_eq!(notes, "", "{name}");
            assert_eq!(read(&path).cells, mesh.cells, "{name}");
        }
    }
}

#[test]
fn pieces_with_wedges_keep_their_sign() {
    let folder = tempfile::tempdir().unwrap();
    for is_inverted in [false, true] {
        let path = folder.path().join("m.vtu");
        wedges(is_inverted).write(&path).unwrap();
        let arguments = "convert m.vtu m.pvtu --pieces 2 --force";
        crate::support::succeed(folder.path(), arguments);
        let (positive, notes) = volumes(&folder.path().join("m.pvtu"));
        assert_eq!(positive, [!is_inverted; 2]);
        assert!(!notes.contains("wedges"), "{notes}");
    }
}

#[test]
fn wedges_of_other_programs_are_read_with_the_order_in_which_most_are_positive() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.vtk");
    let by_vtk_9_6 = "6 0 2 1 3 5 4";
    let by_vtk_9_7 = "6 0 1 2 3 4 5";
    let other_than_most = "6 3 4 5 6 7 8";
    for (cells, positive, is_turned) in [
        (
            [by_vtk_9_6, "6 3 5 4 6 8 7", "6 3 5 4 6 8 7"],
            [true, true, true],
            false,
        ),
        (
            [by_vtk_9_7, "6 3 4 5 6 7 8", "6 3 4 5 6 7 8"],
            [true, true, true],
            true,
        ),
        (
            [by_vtk_9_6, "6 3 5 4 6 8 7", other_than_most],
            [true, true, false],
            false,
        ),
        (
            [by_vtk_9_7, "6 3 5 4 6 8 7", other_than_most],
            [true, false, true],
            true,
        ),
    ] {
        let points: Vec<String> = wedges(false)
            .points
            .iter()
            .map(|point| format!("{point:?}").replace(['[', ']', ','], " "))
            .collect();
        let text = format!(
            "# vtk DataFile Version 3.0\nby others\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double\n{}\n\
             CELLS 3 21\n{}\nCELL_TYPES 3\n13 13 13\n",
            points.join("\n"),
            cells.join("\n")
        );
        std::fs::write(&path, text).unwrap();
        let (found, notes) = volumes(&path);
        assert_eq!(found, positive, "{cells:?}");
        assert_eq!(
            notes.contains("3 wedges are in the node order of VTK 9.7"),
            is_turned,
            "{notes}"
        );
    }
}

#[test]
fn wedges_that_are_all_inverted_are_listed_as_those_of_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, z) in [("reference.vtk", 1.0), ("inverted.vtk", -1.0)] {
        let text = format!(
            "# vtk DataFile Version 3.0\nby others\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 double\n\
             0 0 0\n1 0 0\n0 1 0\n0 0 {z}\n1 0 {z}\n0 1 {z}\nCELLS 1 7\n6 0 2 1 3 5 4\nCELL_TYPES 1\n13\n"
        );
        std::fs::write(folder.join(name), text).unwrap();
    }
    let args = "quality inverted.vtk --reference reference.vtk";
    let found = json(folder, args);
    let cells = &found["inverted"];
    assert_eq!(cells, 1, "{found}");
    let repair = "repair inverted.vtk --reference reference.vtk";
    let run = azimesh(folder, format!("{repair} -o out.vtk"));
    assert!(run.out.contains("invalid cells before        1"), "{run:?}");
}

#[test]
fn volume_cells_alone_are_written_where_the_schedule_leaves_out_boundary_faces() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = testdata("sphere_in_box_raw.vtu");
    let schedule = "azimuth.values = [0, 90]\noutput = { boundary_faces = false, quality = \"cells\", format = \"FORMAT\" }\n\
        boundaries.others = \"fixed\"\nrbf.support_radius = 3.0\n\
        [[body]]\nname = \"sphere\"\ntags = [\"sphere\"]\nrigid = { translate = [0.1, 0.0, 0.0] }\n";
    let run = |out: &str, format: &str, key: &str| {
        let text = schedule
            .replace("FORMAT", format)
            .replace("boundary_faces = false, ", key);
        std::fs::write(folder.path().join("s.toml"), text).unwrap();
        let mesh = mesh.to_str().unwrap();
        azimesh(folder.path(), ["-q", "deform", mesh, "s.toml", "-o", out])
    };
    let key = "boundary_faces = false, ";
    assert_eq!(run("all", "vtu", "").code, 0);
    let all = read(&folder.path().join("all/sphere_in_box_raw_0001.vtu"));
    for (out, format, file) in [
        ("alone", "vtu", "sphere_in_box_raw_0001.vtu"),
        ("file", "vtkhdf", "sphere_in_box_raw.vtkhdf"),
    ] {
        assert_eq!(run(out, format, key).code, 0);
        let alone = read(&folder.path().join(out).join(file));
        assert_eq!(alone.points, all.points);
        let volume = all.cells.runs().filter(|run| run.kind.dimension() == 3);
        let volume: Vec<usize> = volume.flat_map(|run| run.range()).collect();
        assert!(volume.len() < all.cells.len());
        assert_eq!(alone.cells, all.cells.select(volume.iter().copied()));
        let quality = |mesh: &azimesh_io::mesh::Mesh| {
            let mut arrays = mesh.cell_arrays.iter();
            arrays
                .find(|array| array.name == "ScaledJacobian")
                .expect("it has one")
                .clone()
        };
        assert_eq!(quality(&alone), quality(&all).select(&volume));
    }
    let refused = run("msh", "msh", key);
    assert_eq!(refused.code, 2);
    crate::support::assert_says(&refused.err, &["boundary_faces"]);
}
