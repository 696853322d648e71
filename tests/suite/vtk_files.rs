//! Legacy, structured and partitioned files written by VTK (`testdata/vtk/`): files of one grid are one mesh.

use crate::support::sequence::{read, testdata};
use azimesh::mesh::difference::{Difference, Tolerance};

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
    let place = |mesh: &azimesh::mesh::Mesh, cell: usize| -> Vec<[f64; 3]> {
        let nodes = mesh.cells.get(cell).nodes.iter();
        nodes.map(|&node| mesh.points[node as usize]).collect()
    };
    for cell in 0..whole.cells.len() {
        assert_eq!(place(&joined, cell), place(&whole, cell), "cell {cell}");
    }
    let faces = |mesh: &azimesh::mesh::Mesh| -> Vec<(String, usize)> {
        let tags = mesh.boundary_tags();
        tags.map(|tag| (tag.name.clone(), tag.cells.len()))
            .collect()
    };
    assert_eq!(faces(&joined), faces(&whole));
}
