//! Files in the layouts of real writers, round trips, sequences, refusals.

use super::CGNS;
use crate::formats::{Begin, Notes, ReadOptions, Source, WriteOptions, parse, read};
use crate::mesh::{CellKind, DataArray, Difference, Group, Mesh, Tolerance, Values};
use crate::testing::assert_says;
use azimesh_core::error::Error;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

mod adf;
mod odd;
mod refused;
mod regions;
mod sequence;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("testdata/cgns")
        .join(name)
}

fn load(name: &str, step: Option<usize>) -> (Mesh, Notes) {
    let options = ReadOptions {
        step,
        ..ReadOptions::default()
    };
    let source = Source::open(&path(name)).expect("the file is there");
    let loaded = read(&source.into(), &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.format.name, "cgns");
    (loaded.mesh, loaded.notes)
}

fn written(mesh: &Mesh) -> (Vec<u8>, Notes) {
    let mut bytes = Vec::new();
    let notes = CGNS.write_file(&mesh.view(), &mut bytes, &WriteOptions::default());
    (bytes, notes.unwrap_or_else(|error| panic!("{error}")))
}

fn refused(bytes: &[u8]) -> Error {
    parse(&CGNS, bytes, &ReadOptions::default()).expect_err("it should be refused")
}

/// Faces of each tag as sets of nodes.
fn faces(mesh: &Mesh) -> BTreeMap<String, BTreeSet<BTreeSet<u32>>> {
    let of = |group: &Group| {
        let faces = group.cells.iter().map(|cell| mesh.cells.get(cell).nodes);
        faces.map(|nodes| nodes.iter().copied().collect()).collect()
    };
    mesh.boundary_tags()
        .map(|tag| (tag.name.clone(), of(tag)))
        .collect()
}

fn set(nodes: &[u32]) -> BTreeSet<u32> {
    nodes.iter().copied().collect()
}

fn group(dimension: u8, name: &str, cells: std::ops::Range<usize>) -> Group {
    Group::new(dimension, name, None, cells.collect())
}

#[test]
fn every_layout_holds_the_same_two_cells_and_three_tags() {
    let all = [
        "polyhedra_offsets.cgns",
        "polyhedra_counts.cgns",
        "parents_only.cgns",
        "linked_families.cgns",
        "structured_rind.cgns",
    ];
    for name in all {
        let (mesh, notes) = load(name, None);
        assert!(notes.is_empty(), "{name}: {notes:?}");
        assert_eq!(mesh.points.len(), 12, "{name}");
        assert_eq!(mesh.points[11], [2.0, 1.0, 1.0], "{name}");
        let cells: Vec<BTreeSet<u32>> = mesh
            .cells
            .iter()
            .filter(|cell| cell.kind.dimension() == 3)
            .map(|cell| set(cell.nodes))
            .collect();
        let expected = [
            set(&[0, 1, 3, 4, 6, 7, 9, 10]),
            set(&[1, 2, 4, 5, 7, 8, 10, 11]),
        ];
        assert_eq!(cells, expected, "{name}");
        let tags = faces(&mesh);
        assert_eq!(tags.len(), 3, "{name}: {tags:?}");
        assert_eq!(tags["low"], [set(&[0, 3, 6, 9])].into(), "{name}");
        assert_eq!(tags["high"], [set(&[2, 5, 8, 11])].into(), "{name}");
        assert_eq!(tags["sides"].len(), 8, "{name}");
        assert!(tags["sides"].contains(&set(&[7, 8, 10, 11])), "{name}");
        for (tag, condition) in [
            ("low", "BCInflow"),
            ("high", "BCOutflow"),
            ("sides", "BCWallViscous"),
        ] {
            let group = mesh.boundary_tags().find(|group| group.name == tag);
            let found = group.and_then(|group| group.condition.as_deref());
            assert_eq!(found, Some(condition), "{name}: {tag}");
        }
    }
}

#[test]
fn a_face_between_polyhedra_goes_round_outward_for_both() {
    for name in [
        "polyhedra_offsets.cgns",
        "polyhedra_counts.cgns",
        "parents_only.cgns",
    ] {
        let (mesh, _) = load(name, None);
        let between: Vec<Vec<u32>> = mesh
            .cells
            .iter()
            .filter(|cell| cell.kind == CellKind::Polyhedron)
            .flat_map(|cell| mesh.cells.polyhedron_faces(cell.index))
            .filter(|face| set(face) == set(&[1, 4, 7, 10]))
            .map(<[u32]>::to_vec)
            .collect();
        assert_eq!(between, [[1, 4, 10, 7], [1, 7, 10, 4]], "{name}");
    }
}

#[test]
fn boundaries_given_by_nodes_get_the_faces_that_the_file_lacks() {
    let (mesh, notes) = load("by_nodes_big_endian_packed.cgns", None);
    assert!(notes.is_empty());
    let tags = faces(&mesh);
    assert_eq!(tags["low"], [set(&[0, 3, 6, 9])].into());
    assert_eq!(tags["high"], [set(&[2, 5, 8, 11])].into());
    assert_eq!(tags["all"].len(), 10);
    assert_eq!(mesh.cells.len(), 12, "a face in two tags is one cell");
}

#[test]
fn links_lead_on_from_linked_files() {
    let (mesh, notes) = load("linked_twice.cgns", None);
    let (grid, _) = load("linked_grid.cgns", None);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(mesh, grid);
}

#[test]
fn ghost_layers_are_left_out() {
    let (mesh, _) = load("structured_rind.cgns", None);
    let pressure = &mesh.cell_arrays[0];
    let Values::F64(values) = &pressure.values else {
        panic!("pressure is of 64 bits");
    };
    assert_eq!(values[..2], [7.0, 8.0]);
    // Faces take the value of the cell that they bound.
    for face in mesh.cells.iter().skip(2) {
        let has = |cell: usize| set(mesh.cells.get(cell).nodes).is_superset(&set(face.nodes));
        let cell = (0..2).find(|&cell| has(cell)).expect("it bounds one");
        assert_eq!(values[face.index], values[cell], "face {}", face.index);
    }
    assert!(values[2..].contains(&7.0) && values[2..].contains(&8.0));
}

#[test]
fn zones_of_one_name_are_told_apart_and_their_tags_are_one() {
    let (mesh, _) = load("two_bases.cgns", None);
    let zones: Vec<&str> = mesh.zones().map(|zone| zone.name.as_str()).collect();
    assert_eq!(zones, ["Zone", "Right/Zone"]);
    let tags = faces(&mesh);
    assert_eq!(tags["wall"].len(), 2);
    assert_eq!(mesh.points[12][0], 5.0);
}

#[test]
fn each_step_has_its_own_positions_and_arrays() {
    let source = Source::open(&path("sequence.cgns")).expect("the file is there");
    assert_eq!(
        (CGNS.steps)(&source).expect("it has steps"),
        [0.0, 0.5, 1.0]
    );
    for (step, y) in [(Some(0), 0.0), (Some(1), 10.0), (Some(2), 0.0), (None, 0.0)] {
        let (mesh, _) = load("sequence.cgns", step);
        assert_eq!(mesh.points[0][1], y);
        let pressure = vec![step.unwrap_or(2) as f64; 12];
        assert_eq!(
            mesh.point_arrays,
            [DataArray::scalar("Pressure", Values::F64(pressure))]
        );
    }
    let beyond = ReadOptions {
        step: Some(3),
        ..ReadOptions::default()
    };
    let error = CGNS.read_file(&source, &beyond, &mut Notes::default());
    let message = error.expect_err("there is no such step").to_string();
    assert_says(&message, "steps 0 to 2");
}

#[test]
fn what_is_read_is_written_and_read_again() {
    for name in [
        "polyhedra_offsets.cgns",
        "by_nodes_big_endian_packed.cgns",
        "linked_families.cgns",
        "structured_rind.cgns",
        "sequence.cgns",
        "two_bases.cgns",
    ] {
        let (mesh, _) = load(name, None);
        let (bytes, notes) = written(&mesh);
        let n_renamed = if name == "two_bases.cgns" { 2 } else { 0 };
        assert_eq!(notes.len(), n_renamed, "{name}: {notes:?}");
        let mut again = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read again");
        again.merge_repeated_faces();
        let difference = Difference::between(&mesh, &again, Tolerance::default());
        assert!(difference.is_same(), "{name}: {difference:?}");
        let conditions = |mesh: &Mesh| -> Vec<_> {
            let groups = mesh.boundary_tags();
            groups
                .map(|g| (g.name.clone(), g.condition.clone()))
                .collect()
        };
        assert_eq!(conditions(&mesh), conditions(&again), "{name}");
    }
}

/// A mesh with everything that CGNS puts in a place of its own.
fn rich_mesh() -> Mesh {
    let mut mesh = Mesh::of_points(
        (0..40)
            .map(|i| [f64::from(i), f64::from(i % 7), 0.5])
            .collect(),
    );
    let nodes: Vec<u32> = (0..40).collect();
    mesh.cells.push(CellKind::Triangle6, &nodes[3..9]);
    mesh.cells.push(CellKind::Hexahedron27, &nodes[..27]);
    mesh.cells.push(CellKind::Wedge18, &nodes[7..25]);
    mesh.cells.push(CellKind::Quadrilateral9, &nodes[9..18]);
    mesh.cells.push(CellKind::Quadrilateral9, &nodes[12..21]);
    mesh.cells.push(CellKind::Line, &[4, 8]);
    mesh.cells.push(CellKind::Vertex, &[39]);
    mesh.cells
        .push(CellKind::LagrangeTetrahedron, &nodes[5..25]);
    let long = "a boundary whose name has more than thirty-two characters";
    mesh.groups = vec![
        group(3, "rotor", 1..2),
        group(2, long, 3..5),
        group(2, "a/b", 0..1),
        group(1, "edge", 5..6),
        group(0, "probe", 6..7),
    ];
    mesh.groups[2].condition = Some("BCSymmetryPlane".into());
    let velocity: Vec<f32> = (0..120_i16).map(f32::from).collect();
    mesh.point_arrays = vec![
        DataArray::tuples("velocity", 3, Values::F32(velocity)),
        DataArray::scalar("node_number", Values::I64((1..=40).rev().collect())),
        DataArray::scalar(long, Values::I32((0..40).collect())),
    ];
    let nan = f64::NAN;
    let quality = vec![nan, 0.5, 0.25, nan, nan, nan, nan, 1.0];
    mesh.cell_arrays = vec![DataArray::scalar("quality", Values::F64(quality))];
    let lines = vec![
        "NBOX= 1\n  % a box".to_owned(),
        String::new(),
        "é".to_owned(),
    ];
    mesh.field_arrays = vec![
        DataArray::scalar("su2:FFD", Values::Text(lines)),
        DataArray::tuples("hub", 3, Values::F32(vec![1.0, 2.0, 3.0])),
    ];
    mesh
}

#[test]
fn long_names_curved_cells_groups_of_any_dimension_and_arrays_come_back() {
    let mesh = rich_mesh();
    mesh.validate().expect("a good mesh");
    let (bytes, notes) = written(&mesh);
    assert_eq!(notes.len(), 3, "{notes:?}");
    let why = "names in CGNS have at most 32 characters of ASCII and no slash";
    assert!(
        notes.iter().all(|note| note.text.contains(why)),
        "{notes:?}"
    );
    let again = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read again");
    let difference = Difference::between(&mesh, &again, Tolerance::default());
    assert!(difference.is_same(), "{difference:?}");
    let tag = again
        .groups
        .iter()
        .find(|g| g.name == "a/b")
        .expect("it keeps its name");
    assert_eq!(tag.condition.as_deref(), Some("BCSymmetryPlane"));
}

#[test]
fn scattered_types_share_a_mixed_section() {
    let mut mesh = Mesh::of_points((0..10).map(|i| [f64::from(i), 1.0, 2.0]).collect());
    for i in 0..700 {
        match i % 2 {
            0 => mesh
                .cells
                .push(CellKind::Tetrahedron, &[0, 1, 2, 3 + i % 7]),
            _ => mesh.cells.push(CellKind::Pyramid, &[0, 1, 2, 3, 4 + i % 6]),
        }
    }
    let (bytes, _) = written(&mesh);
    assert!(bytes.len() < 60_000, "one section, {} bytes", bytes.len());
    let again = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read again");
    assert_eq!(again.cells, mesh.cells);
}

#[test]
fn cells_that_cgns_does_not_have_are_refused_with_the_remedy() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3]; 12]);
    let nodes: Vec<u32> = (0..12).collect();
    mesh.cells.push(CellKind::HexagonalPrism, &nodes);
    let error = CGNS.write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default());
    let message = error.expect_err("there is no such element").to_string();
    assert!(
        message.contains("hexagonal_prism") && message.contains("split"),
        "{message}"
    );
}

#[test]
fn a_mixed_section_larger_than_a_block_comes_back() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3]; 9]);
    for i in 0..40_000 {
        mesh.cells.push(CellKind::Triangle, &[i % 7, 7, 8]);
        mesh.cells
            .push(CellKind::Quadrilateral, &[i % 5, 5, 6, 7 + i % 2]);
    }
    let (bytes, notes) = written(&mesh);
    assert_eq!(notes, []);
    let back = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read");
    assert!(back.cells == mesh.cells);
}

#[test]
fn cells_come_first_in_the_file_and_back_in_the_order_of_the_mesh() {
    let mut mesh = Mesh::of_points(
        (0..6)
            .map(|i| [f64::from(i), f64::from(i * i), f64::from(i % 2)])
            .collect(),
    );
    mesh.cells.push(CellKind::Vertex, &[5]);
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh.cells.push(CellKind::Triangle, &[1, 2, 4]);
    mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
    mesh.groups = vec![
        group(2, "all", 1..2),
        group(2, "last", 4..5),
        group(1, "edge", 3..4),
        group(3, "fluid", 2..3),
    ];
    mesh.groups[0].cells = [1, 4].into_iter().collect();
    // Faces already have the value of their cell; edges and points have none.
    let nan = f64::NAN;
    let values = vec![nan, 3.0, 3.0, nan, 7.0, 7.0];
    mesh.cell_arrays = vec![DataArray::scalar("p", Values::F64(values))];
    let (bytes, notes) = written(&mesh);
    assert_eq!(notes, []);
    let back = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read");
    assert!(back.cells == mesh.cells);
    let difference = Difference::between(&mesh, &back, Tolerance::default());
    assert!(difference.is_same(), "{difference:?}");
}

#[test]
fn alternating_hexahedra_and_polyhedra_are_a_section_each() {
    let mut mesh = Mesh::of_points(vec![[0.0, 0.0, 1.0]; 8]);
    let tetrahedron = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
    for _ in 0..300 {
        mesh.cells
            .push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
        mesh.cells
            .push_polyhedron(&tetrahedron)
            .expect("a good stream");
    }
    let id = Values::I32((0..600).collect());
    mesh.cell_arrays.push(DataArray::scalar("id", id));
    mesh.groups = vec![Group {
        cells: (0..600).step_by(2).collect(),
        ..group(3, "even", 0..0)
    }];
    let (bytes, notes) = written(&mesh);
    assert!(notes.has("cells_by_type"), "{notes:?}");
    let back = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read");
    assert_eq!(back.cells.runs().len(), 2);
    let even = back.groups.iter().find(|group| group.name == "even");
    let even: Vec<usize> = even.expect("the group").cells.iter().collect();
    assert_eq!(even, (0..300).collect::<Vec<_>>());
    let expected = (0..600).step_by(2).chain((1..600).step_by(2));
    assert_eq!(back.cell_arrays[0].values, Values::I32(expected.collect()));
}
