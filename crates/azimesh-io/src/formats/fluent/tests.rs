//! The same small meshes in every way that Fluent stores them; what is refused.

use super::fixtures::{Small, Stored, house, refined, zone};
use super::*;
use crate::formats::{Notes, ReadOptions, Source};
use crate::mesh::{CellKind, Mesh};
use crate::testing::assert_says;
use azimesh_core::error::Result;
use std::path::Path;

fn load(bytes: impl Into<Vec<u8>>) -> Result<(Mesh, Vec<String>)> {
    let source = Source::from_bytes(Path::new("m.msh"), bytes.into());
    assert!((FLUENT.detect)(&source));
    let loaded = crate::formats::read(&source.into(), &ReadOptions::default())?;
    assert_eq!(loaded.format.name, "fluent");
    let notes = loaded.notes.iter().map(ToString::to_string).collect();
    Ok((loaded.mesh, notes))
}

fn read(bytes: impl Into<Vec<u8>>) -> Mesh {
    load(bytes).unwrap_or_else(|error| panic!("{error}")).0
}

fn refused(text: &str) -> String {
    load(text).map(|_| ()).expect_err(text).to_string()
}

/// The mesh in every way that it can be stored.
fn in_every_way(small: &Small) -> Mesh {
    let mesh = read(small.text(true));
    assert_eq!(read(small.text(false)), mesh);
    for (is_double, is_big_endian) in [(true, false), (true, true), (false, false), (false, true)] {
        let stored = Stored {
            is_double,
            is_big_endian,
        };
        for says_size in [true, false] {
            assert_eq!(read(small.binary(stored, says_size)), mesh, "{stored:?}");
        }
    }
    mesh
}

fn cells(mesh: &Mesh) -> Vec<(CellKind, Vec<u32>)> {
    let all = mesh.cells.iter();
    all.map(|cell| (cell.kind, cell.nodes.to_vec())).collect()
}

/// Groups: dimension, name, type, cells.
fn groups(mesh: &Mesh) -> Vec<(u8, &str, Option<&str>, Vec<usize>)> {
    let all = mesh.groups.iter();
    all.map(|group| {
        let cells = group.cells.ranges().flatten().collect();
        (
            group.dimension,
            &*group.name,
            group.condition.as_deref(),
            cells,
        )
    })
    .collect()
}

#[test]
fn cells_of_a_solid_mesh_come_from_their_faces_in_every_storage() {
    let mesh = in_every_way(&house());
    assert_eq!(read(house().hdf5()), mesh);
    assert_eq!(mesh.points, house().points);
    let found = cells(&mesh);
    let kinds: Vec<CellKind> = found.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds[..2], [CellKind::Hexahedron, CellKind::Pyramid]);
    let above =
        |nodes: &[u32], apex: usize| nodes[..4].iter().all(|node| (*node < 4) == (apex == 0));
    assert!(above(&found[0].1, 0) || above(&found[0].1, 1));
    assert_eq!(found[1].1[4], 8);
    assert_eq!(
        groups(&mesh),
        [
            (2, "sides", Some("velocity-inlet"), vec![2, 3, 4, 5]),
            (2, "floor", Some("wall"), vec![6]),
            (2, "tiles", Some("symmetry"), vec![7, 8, 9, 10]),
            (3, "room", None, vec![0]),
            (3, "roof", Some("solid"), vec![1]),
        ]
    );
    // Faces on the boundary point out of the mesh.
    assert_eq!(found[6].1, [0, 3, 2, 1]);
    assert_eq!(found[3].1, [5, 1, 2, 6]);
}

#[test]
fn faces_that_make_no_simple_cell_make_a_polyhedron() {
    let mut small = house();
    small.faces.remove(0);
    small.cells = vec![[1, 1, 1, 1]];
    let all = small.faces.iter_mut().flat_map(|zone| &mut zone.faces);
    for (_, cells) in all {
        *cells = cells.map(|cell| cell.min(1));
    }
    let mesh = in_every_way(&small);
    assert_eq!(read(small.hdf5()), mesh);
    assert_eq!(mesh.cells.get(0).kind, CellKind::Polyhedron);
    assert_eq!(mesh.cells.polyhedron_faces(0).count(), 9);
}

#[test]
fn hanging_nodes_make_polygons_and_what_was_refined_is_left_out() {
    let mesh = in_every_way(&refined());
    let (_, notes) = load(refined().text(true)).expect("it is read");
    let refined_by =
        "the mesh was refined with hanging nodes: 1 refined cell and faces are left out";
    assert!(
        notes.iter().any(|note| note.starts_with(refined_by)),
        "{notes:?}"
    );
    let found = cells(&mesh);
    assert_eq!(found[0], (CellKind::Polygon, vec![1, 6, 2, 3, 0]));
    assert_eq!(found[1], (CellKind::Quadrilateral, vec![6, 1, 4, 7]));
    assert_eq!(found[2], (CellKind::Quadrilateral, vec![2, 6, 7, 5]));
    assert_eq!(found.len(), 3 + 7);
    let found = groups(&mesh);
    assert_eq!(found[0], (1, "box", Some("wall"), (3..10).collect()));
    assert_eq!(found[1], (2, "air", None, vec![0, 1, 2]));
    assert_eq!(
        read(refined().hdf5()),
        mesh,
        "without trees, by the types of zones"
    );
}

#[test]
fn zones_between_two_cells_are_tags_unless_they_are_interior() {
    let mut small = house();
    small.faces[0].kind = 14;
    small.names[5] = (10, "fan", "rotor");
    let mesh = in_every_way(&small);
    assert_eq!(read(small.hdf5()), mesh);
    assert_eq!(groups(&mesh)[0], (2, "rotor", Some("fan"), vec![11]));
    assert_eq!(mesh.cells.get(11).nodes, [4, 5, 6, 7]);
    small.names[5] = (10, "interior", "internal-10");
    let (_, notes) = load(small.text(true)).expect("it is read");
    assert!(notes.is_empty(), "{notes:?}");
    small.names[5] = (10, "interior", "window");
    let (mesh, notes) = load(small.text(true)).expect("it is read");
    assert_eq!(mesh.groups[0].name, "sides");
    let named = "zones of faces inside of the mesh are not kept: \"window\"";
    assert_eq!(notes, [named]);
    // Without names, by the numbers of types.
    small.names.clear();
    let mesh = in_every_way(&small);
    let names: Vec<&str> = mesh.groups.iter().map(|group| &*group.name).collect();
    let wanted = [
        "fan-10",
        "velocity-inlet-3",
        "wall-4",
        "symmetry-17",
        "fluid-1",
        "fluid-2",
    ];
    assert_eq!(names, wanted);
}

#[test]
fn periodic_pairs_are_told_and_overlaps_of_interfaces_left_out() {
    let mut small = house();
    small.faces[1].kind = 12;
    small.faces[2].kind = 8;
    small
        .faces
        .push(zone(20, 1012, &[(&[], [1, 0]), (&[], [2, 0])]));
    small.more = "(18 (1 1 3 4)(\n2 6))\n(18 (1 1 14 3)(\nb 6))\n(61 (b c)(1 2 3 4))\n".to_owned();
    let (mesh, notes) = load(small.text(false)).expect("it is read");
    let told = [
        "2 faces where the two sides of an interface overlap are left out: the faces of its sides are read",
        "pairs of periodic zones: \"sides\" and \"floor\"",
    ];
    assert_eq!(notes, told);
    assert_eq!(mesh, read(house().text(true)));
}

#[test]
fn faces_on_no_cell_are_left_out_and_told() {
    let mut small = house();
    small.faces.push(zone(21, 3, &[(&[1, 2, 9], [0, 0])]));
    let (mesh, notes) = load(small.text(true)).expect("it is read");
    assert_eq!(mesh, read(house().text(true)));
    assert_says(&notes[0], "faces on no cell");
}

#[test]
fn gmsh_and_fluent_share_an_ending_and_are_told_apart_by_their_content() {
    for (start, is_fluent) in [
        ("(0 \"x\")", true),
        ("\n( 10 (0 1 2 0))", true),
        ("(2 3)", true),
        ("(13(0 1 2 0))", true),
        ("$MeshFormat\n2.2 0 8\n", false),
        ("(a 1)", false),
        ("10 2 3", false),
        ("(1234567 8)", false),
        ("(2", false),
    ] {
        assert_eq!(is_text(start.as_bytes()), is_fluent, "{start}");
    }
}

/// A change in the text of the house, the new text, and the message.
const DAMAGED: &[(&str, &str, &str)] = &[
    (
        "(2 3)",
        "(2 4)",
        "m.msh:2: the dimension of the mesh must be 2 or 3",
    ),
    (
        "0.5 0.5 1.5",
        "0.5 x 1.5",
        "m.msh:13: expected a number as a coordinate, found \"x\"",
    ),
    (
        "0.5 0.5 1.5",
        "0.5 0.5",
        "m.msh:13: expected a number as a coordinate",
    ),
    (
        "(10 (1 1 9 1 3)",
        "(10 (1 1 8 1 3)",
        "m.msh:4: the section says that it has 8 nodes, but it has 9",
    ),
    (
        "(10 (1 1 9 1 3)",
        "(10 (1 1 ffffff 1 3)",
        "has 16777215 nodes of 3 numbers, but it has only",
    ),
    (
        "(10 (0 1 9 0))",
        "(10 (0 1 a 0))",
        "says that it has 10 nodes, but its sections have 9",
    ),
    (
        "(10 (1 1 9 1 3)",
        "(10 (1 2 a 1 3)",
        "nodes 1 to 1 are in no section",
    ),
    (
        "(12 (2 2 2 1 0)",
        "(12 (2 1 2 1 0)",
        "cell 1 is in two sections",
    ),
    (
        "(12 (2 2 2 1 0)",
        "(12 (2 3 3 1 0)",
        "cells 2 to 2 are in no section",
    ),
    ("(12 (2 2 2 1 0)", "(12 (2 2 1 1 0)", ""),
    (
        "(12 (2 2 2 1 0)",
        "(12 (2 2 ff 1 0)",
        "too many for its 10 faces",
    ),
    ("(12 (2 2 2 1 0)", "(12 (2 2 3 1 0)", "cell 3 has 0 faces"),
    (
        "5 6 7 8 2 1",
        "5 6 7 a 2 1",
        "face 1 has node 10, but the mesh has 9 nodes, counted from 1",
    ),
    (
        "5 6 7 8 2 1",
        "5 6 7 0 2 1",
        "face 1 has node 0, but the mesh has 9 nodes, counted from 1",
    ),
    (
        "5 6 7 8 2 1",
        "5 6 7 8 3 1",
        "face 1 has cells 3 and 1, but the mesh has 2 cells",
    ),
    (
        "5 6 7 8 2 1",
        "5 6 7 8 2 2",
        "face 1 has cell 2 on both sides",
    ),
    ("5 6 7 8 2 1", "5 6 7 8 2 100000000", "found \"100000000\""),
    (
        "5 6 7 8 2 1",
        "5 6 7 8 2",
        "expected a cell as a hexadecimal number of 32 bits",
    ),
    (
        "(13(a 1 1 2 4)",
        "(13(a 1 1 2 9)",
        "the type of the faces is 9",
    ),
    ("(13(a 1 1 2 4)", "(13(a 0 1 2 4)", "the first item is 1"),
    ("(13(a 1 1 2 4)", "(13(a 1)", "begins with a zone"),
    (
        "(39 (1 ",
        "(39 (x ",
        "the number of a zone is a decimal number",
    ),
    (
        "(39 (1 ",
        ")(39 (1 ",
        "expected a section, which starts with \"(\"",
    ),
];

#[test]
fn damaged_files_are_refused_with_the_place() {
    let text = house().text(true);
    let with = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}\n{text}");
        refused(&text.replacen(from, to, 1))
    };
    for (from, to, told) in DAMAGED {
        let error = with(from, to);
        assert!(error.contains(told), "{from} -> {to}: {error}");
    }
    let cut = refused(&text[..text.len() - 5]);
    assert!(
        cut.contains("section 39 has no end: expected \")\", found the end of the file"),
        "{cut}"
    );
    let surface =
        refused("(2 3)\n(10 (1 1 3 1 3)(0 0 0 1 0 0 0 1 0))\n(13 (1 1 1 3 3)(1 2 3 0 0))\n");
    assert_says(&surface, "it is a surface mesh");
    let stored = Stored {
        is_double: true,
        is_big_endian: false,
    };
    let binary = house().binary(stored, true);
    for n in (20..binary.len()).step_by(7) {
        let source = Source::from_bytes(Path::new("m"), binary[..n].to_vec());
        let read = FLUENT.read_file(&source, &ReadOptions::default(), &mut Notes::default());
        // Names at the end may be missing.
        assert!(read.is_err() || n > 800, "{n} of {}", binary.len());
    }
}

#[test]
fn errors_of_text_name_the_line_of_the_wrong_number() {
    let text = house().text(true);
    let line_of = |at: usize| 1 + text[..at].matches('\n').count();
    let damaged = |section: &str, row: usize, new: &str| {
        let from = text.find(section).expect("the section is there");
        let first = line_of(from);
        let mut lines: Vec<&str> = text.lines().collect();
        lines[first + row - 1] = new;
        (first + row, refused(&lines.join("\n")))
    };
    for (section, row, new, told) in [
        ("(13(3 ", 2, "6 63 3 2 1 0", "face 3 has node 99"),
        ("(13(3 ", 3, "7 8 4 3 1f 0", "face 4 has cells 31 and 0"),
        (
            "(13(3 ",
            2,
            "6 7 3 2 1",
            "expected 6 numbers for a face in this line, found 5",
        ),
        (
            "(13(3 ",
            4,
            "8 5 1 4 1 0 7",
            "expected 6 numbers for a face in this line, found 7",
        ),
        (
            "(10 (1 ",
            3,
            "1 1",
            "expected 3 numbers for a node in this line, found 2",
        ),
        (
            "(10 (0 ",
            0,
            "(10 (0 1 a 0))",
            "the file says that it has 10 nodes, but its sections have 9",
        ),
        (
            "(12 (2 ",
            0,
            "(12 (2 3 3 1 0)(",
            "cells 2 to 2 are in no section",
        ),
    ] {
        let (line, error) = damaged(section, row, new);
        assert!(
            error.contains(&format!("m.msh:{line}: {told}")),
            "{line}: {error}"
        );
    }
    let half = text.find("0 0 1\n").expect("the fifth node");
    let error = refused(&text[..half]);
    let told =
        "the file ends within the section of nodes that begins in line 4: expected 9, found 4";
    assert_says(&error, told);
}

#[test]
fn edges_that_go_round_no_cell_are_refused() {
    let text = refined().text(true).replacen("\n1 2 1 0", "\n2 1 1 0", 1);
    let error = refused(&text);
    assert_says(&error, "cell 1 has edges that do not go round it");
    let error = refused(
        &refined()
            .text(false)
            .replacen("\n2 1 2 1 0", "\n3 1 2 5 1 0", 1),
    );
    assert_says(&error, "in a plane mesh it has 2");
}
