//! Round trips, and the oddities of real files.

use super::super::{Notes, Source};
use super::super::{ReadOptions, WriteOptions};
use super::{SU2, write_surface};
use crate::mesh::{CellKind, Group, Mesh, Values};
use crate::testing::assert_says;
use std::path::Path;

fn read_with_notes(text: &str) -> (Mesh, Notes) {
    let source = Source::from_bytes(Path::new("mesh.su2"), text.into());
    assert!((SU2.detect)(&source));
    let mut notes = Notes::default();
    let mesh = SU2.read_file(&source, &ReadOptions::default(), &mut notes);
    let mesh = mesh.expect("a good file");
    mesh.validate().expect("a good mesh");
    (mesh, notes)
}

fn read(text: &str) -> Mesh {
    let (mesh, notes) = read_with_notes(text);
    assert!(notes.is_empty(), "{notes:?}");
    mesh
}

fn write(mesh: &Mesh) -> (String, Notes) {
    let mut file = Vec::new();
    let notes = SU2
        .write_file(&mesh.view(), &mut file, &WriteOptions::default())
        .expect("SU2 holds it");
    (String::from_utf8(file).expect("text"), notes)
}

fn tag(dimension: u8, name: &str, cells: std::ops::Range<usize>) -> Group {
    Group::new(dimension, name, None, cells.into())
}

fn solid() -> Mesh {
    let mut mesh = Mesh::of_points((0..8).map(|i| [f64::from(i) / 3.0, 1e-7, -0.0]).collect());
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
    mesh.groups[0].condition = Some("BCWallViscousHeatFlux".into());
    let (file, notes) = write(&mesh);
    assert_eq!(notes.len(), 6, "{notes:?}");
    assert!(notes.has("conditions_left_out"), "{notes:?}");
    assert_eq!(read(&file).groups[0].name, "upper_wall");
    mesh.cells.push(CellKind::Tetrahedron10, &[0; 10]);
    let error = SU2
        .write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default())
        .expect_err("second order");
    assert_says(&error, "tetrahedron10");
}

#[test]
fn a_plane_mesh_loses_no_shape() {
    let mut mesh = Mesh::of_points(vec![[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]]);
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    let (file, notes) = write(&mesh);
    assert!(file.starts_with("NDIME= 2\n"));
    assert_eq!(notes.len(), 1, "{notes:?}");
    mesh.points[2][2] = 2.1;
    let refused = SU2.write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default());
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
fn text_that_only_su2_understands_comes_back_as_it_was() {
    let file = "NDIME= 2\nAOA_OFFSET= 1.5\nNELEM= 1\n5 0 1 2 0\nNPOIN= 3 2\n0.0 0.0 0\n1.0 0.0 1\n\
         0.0 1.0 2\nNMARK= 3\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n3 0 1\n\
         MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_RECV= 1\n1 0 1\n\
         MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_RECV= -1\n1 2 1\n\
         NPERIODIC= 1\nPERIODIC_INDEX= 0\n0 0 0\n0 0 0\n0 0 0\n\
         FFD_NBOX= 1\nFFD_CORNER_POINTS= 1\n0.1 0.2\nFFD_SURFACE_POINTS= 1\nwall 0 0.1 0.2 0.3\n";
    let mesh = read(file);
    assert_eq!(mesh.cells.len(), 2);
    assert_eq!(mesh.groups, [tag(1, "wall", 1..2)]);
    let names = mesh.field_arrays.iter().map(|array| array.name.as_str());
    let expected = [
        "su2:OFFSET",
        "su2:SEND_RECEIVE",
        "su2:PERIODIC",
        "su2:FFD",
        "su2:NPOIN",
    ];
    assert!(names.eq(expected));
    let (back, notes) = write(&mesh);
    assert_eq!(back, file);
    assert!(notes.is_empty(), "{notes:?}");
}

/// Two triangles that share no node, each a zone, with a marker of one name on both.
const ZONES: &str = "NDIME= 2\nNZONE= 2\n\
    IZONE= 1\nNDIME= 2\nNELEM= 1\n5 0 1 2 0\nNPOIN= 3\n0.0 0.0 0\n1.0 0.0 1\n0.0 1.0 2\n\
    NMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= spare\nMARKER_ELEMS= 0\n\
    IZONE= 2\nNDIME= 2\nNELEM= 1\n5 0 1 2 0\nNPOIN= 4\n5.0 0.0 0\n6.0 0.0 1\n5.0 1.0 2\n\
    7.0 7.0 3\nNMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n3 0 1\n1 2\n";

#[test]
fn zones_follow_one_another_and_are_written_apart() {
    let mesh = read(ZONES);
    assert_eq!(mesh.points.len(), 7);
    assert_eq!(mesh.cells.get(2).nodes, [3, 4, 5]);
    let zones: Vec<&str> = mesh.zones().map(|zone| zone.name.as_str()).collect();
    assert_eq!(zones, ["1", "2"]);
    let wall = &mesh.groups[0];
    assert_eq!(wall.cells.iter().collect::<Vec<_>>(), [1, 3]);
    let (back, notes) = write(&mesh);
    assert_eq!(back, ZONES);
    assert!(notes.is_empty(), "{notes:?}");
}

#[test]
fn zones_that_share_a_node_are_one_and_a_note_says_so() {
    let mut mesh = read(ZONES);
    mesh.groups.retain(|group| group.dimension > 0);
    let mut cells = crate::mesh::Cells::new();
    for cell in mesh.cells.iter() {
        let nodes: Vec<u32> = cell
            .nodes
            .iter()
            .map(|&n| if n == 3 { 1 } else { n })
            .collect();
        cells.push(cell.kind, &nodes);
    }
    mesh.cells = cells;
    let (back, notes) = write(&mesh);
    assert!(!back.contains("ZONE"));
    let left_out = "SU2 holds zones only where two or more make up the mesh and share no nodes; left out: \"1\", \"2\"";
    assert!(notes.says(left_out), "{notes:?}");
}

#[test]
fn a_zone_keeps_its_own_text_and_loses_its_name_with_a_note() {
    let text = ZONES.to_owned() + "FFD_NBOX= 1\n";
    let mut mesh = read(&text);
    let boxes = Values::Text(vec![String::new(), "FFD_NBOX= 1\n".into()]);
    assert_eq!(mesh.field_arrays[0].values, boxes);
    assert_eq!(write(&mesh).0, text);
    let zone = mesh.groups.iter_mut().find(|group| group.name == "2");
    zone.expect("the second zone").name = "solid".into();
    let (back, notes) = write(&mesh);
    assert_eq!(back, text);
    assert_eq!(notes, ["zone_names"]);
    let names = "zones are written as IZONE= 1 to 2; names left out: \"1\", \"solid\"";
    assert!(notes.says(names), "{notes:?}");
    mesh.groups.retain(|group| group.dimension < 2);
    let (_, notes) = write(&mesh);
    let boxes = "SU2 holds no field arrays; left out: \"su2:FFD\"";
    assert!(notes.says(boxes), "{notes:?}");
}

#[test]
fn keywords_without_a_meaning_are_noted_once_each() {
    let (_, notes) = read_with_notes(
        "NDIME= 2\nNELEM= 1\n5 0 1 2 0\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 7 % seven\n\
         NCHUNK= 2\n1 2\n3 4\nNCORNERS= 0\nNCHUNK= 1\n5 6\n",
    );
    let texts: Vec<&str> = notes.iter().map(|note| &*note.text).collect();
    assert_eq!(
        texts,
        [
            "NCHUNK= is not kept (5 lines)",
            "NCORNERS= is not kept (1 line)",
            "NMARK= 7, but the file has 0 markers; all are read",
        ]
    );
}

#[test]
fn curved_cells_of_the_discontinuous_galerkin_solver_are_read_and_not_written() {
    let nodes: String = (0..10)
        .map(|i| format!("{}.0 {}.0\n", i % 4, i / 4))
        .collect();
    let (mesh, notes) = read_with_notes(&format!(
        "NDIME= 2\nNELEM= 1\n40205 0 1 2 3 4 5 6 7 8 9 0\nNPOIN= 10\n{nodes}NMARK= 1\n\
         MARKER_TAG= wall\nMARKER_ELEMS= 1\n203 0 1 2 3\n"
    ));
    assert_eq!(mesh.cells.get(0).kind, CellKind::LagrangeTriangle);
    assert_eq!(mesh.cells.get(0).nodes, [0, 3, 9, 1, 2, 6, 8, 7, 4, 5]);
    assert_eq!(mesh.cells.get(1).kind, CellKind::LagrangeCurve);
    assert_eq!(mesh.cells.get(1).nodes, [0, 3, 1, 2]);
    assert_eq!(notes, ["solution_degrees"]);
    let refused = SU2.write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default());
    let message = refused.expect_err("it is curved").to_string();
    assert_says(&message, "`linearize`");
}

#[test]
fn a_surface_file_has_the_index_and_the_place_of_each_node() {
    let mesh = Mesh::read("testdata/airfoil_hybrid.su2").expect("it is there");
    let nodes = [3, 0, 7];
    let mut text = Vec::new();
    write_surface(&mesh.view(), &nodes, &mut text).expect("it can be written");
    let text = String::from_utf8(text).expect("it is text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3);
    for (line, node) in lines.iter().zip(nodes) {
        let numbers: Vec<f64> = line
            .split(' ')
            .map(|x| x.parse().expect("a number"))
            .collect();
        let [x, y, _] = mesh.points[node as usize];
        assert_eq!(numbers, [f64::from(node), x, y]);
    }
}

#[test]
fn a_solid_has_three_coordinates() {
    let mesh = Mesh::read("testdata/mixed_cells.su2").expect("it is there");
    let mut text = Vec::new();
    write_surface(&mesh.view(), &[1], &mut text).expect("it can be written");
    assert_eq!(text.iter().filter(|byte| **byte == b' ').count(), 3);
}
