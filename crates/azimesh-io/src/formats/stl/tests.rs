use super::super::{Encoding, ReadOptions, Source, WriteOptions, read};
use super::*;
use crate::mesh::{CellKind, Values};
use crate::testing::assert_says;
use azimesh_core::error::Result;
use std::path::Path;

/// A hexahedron with three of its faces in two tags, one of them in both.
fn cube() -> Mesh {
    let at = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)];
    let mut mesh = Mesh::of_points((0..8).map(at).map(|p| p.map(|x| 0.1 * x)).collect());
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 3, 2, 4, 5, 7, 6]);
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 3, 2]);
    mesh.cells.push(CellKind::Quadrilateral, &[4, 5, 7, 6]);
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 5, 4]);
    mesh.add_tag("floor and wall", [1, 3]).expect("faces");
    mesh.add_tag("top", [2, 3]).expect("faces");
    mesh
}

fn written(mesh: &Mesh, encoding: Encoding) -> (Vec<u8>, Notes) {
    let options = WriteOptions {
        encoding,
        ..WriteOptions::default()
    };
    let mut bytes = Vec::new();
    let notes = STL.write_file(&mesh.view(), &mut bytes, &options);
    (bytes, notes.expect("it can be written"))
}

fn loaded(bytes: Vec<u8>) -> Result<super::super::Loaded> {
    let source = Source::from_bytes(Path::new("m"), bytes);
    read(&source.into(), &ReadOptions::default())
}

/// Six times the volume inside, by the turn of the triangles.
fn volume(mesh: &Mesh) -> f64 {
    use azimesh_core::geometry::vector::{cross, dot};
    let of = |nodes: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.points[nodes[i] as usize]);
        dot(a, cross(b, c))
    };
    mesh.cells.iter().map(|cell| of(cell.nodes)).sum()
}

#[test]
fn text_has_a_solid_for_each_tag_and_reads_back_to_the_last_bit() {
    let (bytes, notes) = written(&cube(), Encoding::Ascii);
    for text in [
        "STL holds surfaces: the boundary alone is written; solid cells left out, with their zones: 1",
        "outer faces without a boundary element are written too, without a tag (3)",
        "faces of four corners or more are cut into triangles (6)",
        "a face is in one solid of STL; further tags of faces that have several are left out (2)",
    ] {
        assert!(notes.says(text), "{text}: {notes:?}");
    }
    let loaded = loaded(bytes).expect("it is a mesh");
    assert_eq!(loaded.format.name, "stl");
    let mesh = loaded.mesh;
    assert_eq!((mesh.points.len(), mesh.cells.len()), (8, 12));
    assert_eq!(mesh.dimension(), 3);
    let of = |point: &[f64; 3]| point.map(f64::to_bits);
    let mut found: Vec<_> = mesh.points.iter().map(of).collect();
    let mut wanted: Vec<_> = cube().points.iter().map(of).collect();
    found.sort_unstable();
    wanted.sort_unstable();
    assert_eq!(found, wanted);
    let tags = mesh.boundary_tags();
    let tags: Vec<_> = tags
        .map(|tag| (tag.name.as_str(), tag.cells.len()))
        .collect();
    assert_eq!(tags, [("floor_and_wall", 4), ("top", 2)]);
    assert!((volume(&mesh) - 6e-3).abs() < 1e-15, "{}", volume(&mesh));
}

#[test]
fn binary_has_32_bits_and_no_tags_and_says_so() {
    let (bytes, notes) = written(&cube(), Encoding::Raw);
    assert_eq!(bytes.len(), 84 + 50 * 12);
    assert!(notes.has("coordinates_rounded"), "{notes:?}");
    let names = "binary STL has no tags; left out: \"floor and wall\", \"top\" (`encoding` ascii writes a solid for each)";
    assert!(notes.says(names), "{notes:?}");
    // Some programs begin their title with the word of text.
    for title in [&b"triang"[..], b"solid "] {
        let mut bytes = bytes.clone();
        bytes[..6].copy_from_slice(title);
        let mesh = loaded(bytes).expect("it is a mesh").mesh;
        assert_eq!((mesh.points.len(), mesh.cells.len()), (8, 12));
        assert_eq!(mesh.groups.len(), 0);
        assert!((volume(&mesh) - 6e-3).abs() < 1e-9);
    }
}

#[test]
fn arrays_and_edges_are_told_of_and_a_plane_mesh_is_its_cells() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh.point_arrays = vec![crate::mesh::DataArray::scalar(
        "p",
        Values::F64(vec![0.0; 3]),
    )];
    let (bytes, notes) = written(&mesh, Encoding::Ascii);
    assert!(
        notes.says("cells of lower dimension are left out (1)"),
        "{notes:?}"
    );
    let arrays = "STL holds no point arrays; left out: \"p\"";
    assert!(notes.says(arrays), "{notes:?}");
    let text = String::from_utf8(bytes.clone()).expect("text");
    assert!(
        text.starts_with("solid\n facet normal 0.0 0.0 1.0\n"),
        "{text}"
    );
    assert_eq!(
        loaded(bytes).expect("it is a mesh").mesh.points,
        mesh.points
    );
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let (bytes, _) = written(&cube(), Encoding::Ascii);
    let text = String::from_utf8(bytes).expect("text");
    let refused = |text: String| loaded(text.into_bytes()).err().expect("it is wrong");
    for (found, put, line, what) in [
        ("vertex", "vertx", 4, "expected \"vertex\", found \"vertx\""),
        ("   vertex 0.0", "   vertex nan", 0, "coordinate"),
        ("endfacet", "", 9, "endfacet"),
        ("endsolid", "endfacet", 0, "facet"),
    ] {
        let error = refused(text.replacen(found, put, 1)).to_string();
        assert_says(&error, what);
        assert!(
            line == 0 || error.contains(&format!("m:{line}: ")),
            "{error}"
        );
    }
    let cut = refused(text[..text.rfind("endsolid").expect("an end")].to_owned());
    assert_says(&cut, "\"endsolid\" is missing");
    let (mut bytes, _) = written(&cube(), Encoding::Raw);
    bytes.pop();
    let cut = STL.read_file(
        &Source::from_bytes(Path::new("m.stl"), bytes.clone()),
        &ReadOptions::default(),
        &mut Notes::default(),
    );
    let told = cut.expect_err("it is cut").to_string();
    assert_says(&told, "12 triangles take 684 bytes, but the file has 683");
    bytes.push(7);
    let noted = loaded(bytes.clone()).expect("it is a mesh");
    let attributes = "attributes of triangles, such as colours, are not kept (1)";
    assert!(noted.notes.says(attributes), "{:?}", noted.notes);
    bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = loaded(bytes).err().expect("it is not finite").to_string();
    assert!(
        error.contains("84") && error.contains("triangle 0 has a coordinate"),
        "{error}"
    );
}
