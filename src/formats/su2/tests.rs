//! Round trips, and the oddities of real files.

use super::super::{Format, ReadOptions, WriteOptions};
use super::Su2;
use crate::formats::parse;
use crate::mesh::{CellKind, Group, Mesh};

fn read(text: &str) -> Mesh {
    assert!(Su2.recognizes(text.as_bytes()));
    let mesh = parse(&Su2, text.as_bytes(), &ReadOptions::default()).expect("a good file");
    mesh.validate().expect("a good mesh");
    mesh
}

fn write(mesh: &Mesh) -> (String, Vec<String>) {
    let mut file = Vec::new();
    let notes = Su2
        .write(mesh, &mut file, &WriteOptions::default())
        .expect("SU2 holds it");
    (String::from_utf8(file).expect("text"), notes)
}

fn tag(dimension: u8, name: &str, cells: std::ops::Range<usize>) -> Group {
    Group {
        dimension,
        name: name.into(),
        number: None,
        condition: None,
        cells: cells.collect(),
    }
}

fn solid() -> Mesh {
    let mut mesh = Mesh {
        points: (0..8).map(|i| [f64::from(i) / 3.0, 1e-7, -0.0]).collect(),
        ..Mesh::default()
    };
    let n = [0, 1, 2, 3, 4, 5, 6, 7];
    mesh.cells.push(CellKind::Tetrahedron, &n[..4]);
    mesh.cells.push(CellKind::Hexahedron, &n);
    mesh.cells.push(CellKind::Wedge, &n[..6]);
    mesh.cells.push(CellKind::Pyramid, &n[..5]);
    mesh.cells.push(CellKind::Triangle, &n[..3]);
    mesh.cells.push(CellKind::Quadrilateral, &n[..4]);
    mesh.groups = vec![tag(2, "wall", 4..6), tag(2, "spare", 0..0)];
    mesh
}

#[test]
fn solid_cells_and_tags_come_back() {
    let (file, notes) = write(&solid());
    assert_eq!(read(&file), solid());
    assert!(notes.is_empty(), "{notes:?}");
}

#[test]
fn what_is_left_out_is_said() {
    let mut mesh = solid();
    mesh.cells.push(CellKind::Triangle, &[5, 6, 7]);
    mesh.cells.push(CellKind::Line, &[5, 6]);
    mesh.groups.push(tag(3, "air", 0..4));
    mesh.groups.push(tag(1, "edge", 7..8));
    mesh.groups[0].name = "upper wall".into();
    let (file, notes) = write(&mesh);
    assert_eq!(notes.len(), 5, "{notes:?}");
    assert_eq!(read(&file).groups[0].name, "upper_wall");
    mesh.cells.push(CellKind::Tetrahedron10, &[0; 10]);
    let error = Su2
        .write(&mesh, &mut Vec::new(), &WriteOptions::default())
        .expect_err("second order");
    assert!(error.to_string().contains("tetrahedron10"), "{error}");
}

#[test]
fn a_plane_mesh_loses_no_shape() {
    let mut mesh = Mesh {
        points: vec![[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]],
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    let (file, notes) = write(&mesh);
    assert!(file.starts_with("NDIME= 2\n"));
    assert_eq!(notes.len(), 1, "{notes:?}");
    mesh.points[2][2] = 2.1;
    let refused = Su2.write(&mesh, &mut Vec::new(), &WriteOptions::default());
    assert!(refused.is_err());
}

#[test]
fn sections_come_in_any_order_with_whatever_spaces() {
    let mesh = read(
        "% mesh\r\n\r\nNPOIN=4 3\r\n 0 0\r\n1\t0 1\r\n% more\r\n1 1\r\n0 1 3\r\nNMARK = 1\r\n\
         MARKER_TAG= wall\r\nMARKER_ELEMS = 1\r\n3 0 1\r\nNELEM=1\r\n9 0 1 2 3\r\nNDIME= 2\r\n",
    );
    assert_eq!(mesh.points[3], [0.0, 1.0, 0.0]);
    assert_eq!(mesh.cells.get(1).kind, CellKind::Quadrilateral);
    assert_eq!(mesh.groups, [tag(1, "wall", 0..1)]);
}

#[test]
fn periodic_and_deformation_boxes_are_passed_over() {
    let mesh = read(
        "NZONE= 1\nNDIME= 2\nNELEM= 1\n5 0 1 2 0\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 2\n\
         MARKER_TAG= wall\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 2\n\
         SEND_RECV= 1\n1 0 0\n1 2 0\nNPERIODIC= 1\nPERIODIC_INDEX= 0\n0 0 0\n0 0 0\n\
         FFD_NBOX= 1\nFFD_CORNER_POINTS= 1\n0.1 0.2\nFFD_SURFACE_POINTS= 1\nwall 0 0.1 0.2 0.3\n",
    );
    assert_eq!(mesh.cells.len(), 4);
    assert_eq!(
        mesh.groups,
        [tag(1, "wall", 1..2), tag(0, "SEND_RECEIVE", 2..4)]
    );
}
