//! Round trips through every flavour, the file's own order of nodes, and the names in the `.mapbc`.

use super::super::{Commit, FORMATS, Notes, ReadOptions, Source, WriteOptions, save};
use super::*;
use crate::mesh::{CellKind, Group, Mesh};
use crate::testing::assert_says;
use azimesh_core::error::Result;

fn tag(name: &str, number: Option<i32>, cells: std::ops::Range<usize>) -> Group {
    Group::new(2, name, number, cells.into())
}

/// A hexahedron with a pyramid on top, a tetrahedron next to it and a wedge, in the order of UGRID;
/// coordinates that 32 bits hold.
fn solid() -> Mesh {
    let mut mesh = Mesh::of_points(
        [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [0.0, 1.0, 1.0],
            [0.5, 0.5, 2.0],
            [2.0, 0.0, 0.0],
            [2.0, 0.0, 1.25],
            [-0.0, 2.0, 2.5],
        ]
        .to_vec(),
    );
    let cells = &mut mesh.cells;
    cells.push(CellKind::Triangle, &[4, 5, 8]);
    cells.push(CellKind::Triangle, &[5, 6, 8]);
    cells.push(CellKind::Quadrilateral, &[0, 3, 2, 1]);
    cells.push(CellKind::Quadrilateral, &[0, 1, 5, 4]);
    cells.push(CellKind::Tetrahedron, &[7, 6, 8, 11]);
    cells.push(CellKind::Pyramid, &[4, 5, 6, 7, 8]);
    cells.push(CellKind::Wedge, &[1, 2, 9, 5, 6, 10]);
    cells.push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
    mesh.groups = vec![tag("2", Some(2), 0..3), tag("7", Some(7), 3..4)];
    mesh
}

fn written(flavour: &Format, mesh: &Mesh) -> (Vec<u8>, Notes) {
    let mut file = Vec::new();
    let notes = flavour.write_file(&mesh.view(), &mut file, &WriteOptions::default());
    (file, notes.expect("UGRID holds it"))
}

fn saved(mesh: &Mesh, path: &Path, flavour: &Format) -> Notes {
    let options = WriteOptions::default();
    let notes = save(&mesh.view(), path, flavour, &options, Commit::REPLACE);
    notes.expect("it can be written")
}

fn read(flavour: &Format, file: &[u8]) -> Result<(Mesh, Notes)> {
    let source = Source::from_bytes(Path::new("mesh.ugrid"), file.to_vec());
    let mut notes = Notes::default();
    let mesh = flavour.read_file(&source, &ReadOptions::default(), &mut notes)?;
    mesh.validate().expect("a good mesh");
    Ok((mesh, notes))
}

fn refusal(flavour: &Format, mesh: &Mesh) -> String {
    let result = flavour.write_file(&mesh.view(), &mut Vec::new(), &WriteOptions::default());
    result.expect_err("UGRID does not hold it").to_string()
}

#[test]
fn a_mesh_comes_back_from_every_flavour_and_is_known_by_its_content() {
    let all = || FORMATS.iter().filter(|f| f.name.starts_with("ugrid"));
    for flavour in all() {
        let (file, notes) = written(flavour, &solid());
        assert!(notes.is_empty(), "{}: {notes:?}", flavour.name);
        let (mesh, notes) = read(flavour, &file).expect("it was written");
        assert_eq!(mesh, solid(), "{}", flavour.name);
        assert!(notes.is_empty(), "{}: {notes:?}", flavour.name);
        assert!(mesh.points[11][0].is_sign_negative());
        let source = Source::from_bytes(Path::new("mesh"), file);
        let knowing = all().filter(|f| (f.detect)(&source));
        assert_eq!(knowing.map(|f| f.name).collect::<Vec<_>>(), [flavour.name]);
    }
}

#[test]
fn the_layout_is_that_of_aflr3() {
    let (file, _) = written(&TEXT, &solid());
    let text = String::from_utf8(file).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "12 2 2 1 1 1 1");
    assert_eq!(lines[12], "-0.0 2.0 2.5");
    assert_eq!(lines[13..15], ["5 6 9", "6 7 9"]);
    assert_eq!(lines[15..17], ["1 4 3 2", "1 2 6 5"]);
    assert_eq!(lines[17..21], ["2", "2", "2", "7"]);
    assert_eq!(lines[21], "8 7 9 12");
    // The third node is the apex; the base goes round by the first, fourth, fifth and second.
    assert_eq!(lines[22], "6 5 9 7 8");
    assert_eq!(lines[23], "2 3 10 6 7 11");
    assert_eq!(lines[24], "1 2 3 4 5 6 7 8");
    assert_eq!(lines.len(), 25);
    let (file, _) = written(&B8, &solid());
    assert_eq!(
        file.len(),
        28 + 12 * 24 + 4 * (2 * 3 + 2 * 4 + 4 + 4 + 5 + 6 + 8)
    );
    assert_eq!(file[..8], [0, 0, 0, 12, 0, 0, 0, 2]);
    let (file, _) = written(&LR4, &solid());
    assert_eq!(file[..8], [28, 0, 0, 0, 12, 0, 0, 0]);
    assert_eq!(file[32..40], [28, 0, 0, 0, 52, 1, 0, 0]);
}

#[test]
fn a_pyramid_is_not_turned_inside_out() {
    let (mesh, _) = read(&TEXT, &written(&TEXT, &solid()).0).expect("it was written");
    let nodes = mesh.cells.get(5).nodes;
    let point = |i: usize| mesh.points[nodes[i] as usize];
    let along = |a: usize, b: usize| -> [f64; 3] {
        std::array::from_fn(|axis| point(b)[axis] - point(a)[axis])
    };
    let (u, v, w) = (along(0, 1), along(0, 3), along(0, 4));
    let up = u[0] * v[1] - u[1] * v[0];
    assert!(up * w[2] > 0.0);
}

#[test]
fn names_and_conditions_are_beside_the_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mesh = solid();
    mesh.groups = vec![
        tag("upper", None, 0..2),
        tag("far field", Some(1), 2..3),
        tag("spare", Some(9), 0..0),
        tag("plane", None, 3..4),
    ];
    mesh.groups[0].condition = Some("BCWallViscous".into());
    mesh.groups[1].condition = Some("6100".into());
    mesh.groups[3].condition = Some("BCSymmetryPlane".into());
    let path = folder.path().join("wing.lb8.ugrid");
    let notes = saved(&mesh, &path, &LB8);
    assert_eq!(notes, ["renamed", "condition_missing"]);
    let renamed = "tag \"far field\" is written as \"far_field\": names in a .mapbc have no spaces";
    assert!(notes.says(renamed), "{notes:?}");
    let missing = "tags without a boundary condition have number 0 in the .mapbc: \"spare\"";
    assert!(notes.says(missing), "{notes:?}");
    let mapbc = folder.path().join("wing.mapbc");
    let text = std::fs::read_to_string(&mapbc).expect("it is there");
    assert_eq!(
        text,
        "4\n2 4000 upper\n1 6100 far_field\n9 0 spare\n3 6662 plane\n"
    );
    let source = Source::open(&path).expect("it is there");
    let mut notes = Notes::default();
    let options = ReadOptions::default();
    let back = LB8
        .read_file(&source, &options, &mut notes)
        .expect("it was written");
    let groups: Vec<_> = back
        .groups
        .iter()
        .map(|g| (g.name.as_str(), g.number))
        .collect();
    let expected = [("far_field", 1), ("upper", 2), ("plane", 3), ("spare", 9)];
    assert_eq!(groups, expected.map(|(name, number)| (name, Some(number))));
    assert_eq!(back.groups[1].condition.as_deref(), Some("BCWallViscous"));
    assert_eq!(back.groups[0].condition.as_deref(), Some("6100"));
    std::fs::write(&mapbc, "1\nwall 4000\n").expect("it can be replaced");
    let back = LB8
        .read_file(&source, &options, &mut notes)
        .expect("the mesh is whole");
    assert_eq!(back.groups[0].name, "1");
    let note = notes.iter().next().expect("it is noted");
    assert_eq!(note.code, "conditions_unused");
    assert_says(&note.text, "wing.mapbc:2: expected an integer");
}

#[test]
fn numbers_of_fun3d_come_back_where_words_of_cgns_say_less() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wing.b8.ugrid");
    std::fs::write(&path, written(&B8, &solid()).0).expect("it can be written");
    let mapbc = folder.path().join("wing.mapbc");
    let text = "2\n2 5050 far\n7 6663 plane\n";
    std::fs::write(&mapbc, text).expect("it can be written");
    let source = Source::open(&path).expect("it is there");
    let mesh = B8.read_file(&source, &ReadOptions::default(), &mut Notes::default());
    let mesh = mesh.expect("a good file");
    assert_eq!(mesh.groups[0].condition.as_deref(), Some("BCFarfield"));
    let notes = saved(&mesh, &path, &B8);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(std::fs::read_to_string(&mapbc).expect("it is there"), text);
}

#[test]
fn what_ugrid_does_not_hold_is_said_or_refused() {
    let mut mesh = solid();
    mesh.groups[1] = tag("7", Some(7), 2..3);
    mesh.groups.push(Group {
        dimension: 3,
        ..tag("air", None, 4..8)
    });
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh.points[0][0] = 0.1;
    let (file, notes) = written(&B4, &mesh);
    let texts: Vec<&str> = notes.iter().map(|note| &*note.text).collect();
    assert_eq!(
        texts,
        [
            "coordinates are rounded to 32 bits",
            "UGRID holds no zones; left out: \"air\"",
            "cells of lower dimension are left out (1)",
            "UGRID holds one tag for each face; further tags of faces that have several are left out (1)",
            "boundary faces without a tag (1) get number 8, \"untagged\"",
            "tags without a boundary condition have number 0 in the .mapbc: \"2\", \"7\"",
        ]
    );
    let (back, _) = read(&B4, &file).expect("it was written");
    assert_eq!(back.groups.len(), 2);
    assert_eq!(back.groups[1].name, "8");
    mesh.points[0][0] = 1e300;
    assert!(refusal(&LR4, &mesh).contains("does not fit 32 bits"));
    mesh.cells.push(CellKind::Tetrahedron10, &[0; 10]);
    assert!(refusal(&TEXT, &mesh).contains("tetrahedron10, which UGRID cannot hold; `linearize`"));
    let mut plane = Mesh::default();
    plane.cells.push(CellKind::Triangle, &[0, 1, 2]);
    assert!(refusal(&TEXT, &plane).contains("dimension 2"));
    let single = WriteOptions {
        precision: Precision::F32,
        ..WriteOptions::default()
    };
    let notes = B8
        .write_file(&solid().view(), &mut Vec::new(), &single)
        .expect("it is held");
    assert_eq!(notes, ["coordinates_in_64"]);
}

#[test]
fn a_file_under_a_wrong_name_is_told_apart() {
    let (big, _) = written(&B8, &solid());
    let message = read(&LB8, &big)
        .expect_err("the bytes are swapped")
        .to_string();
    assert!(
        message.contains("(read as ugrid-lb8; it would fit `format` ugrid-b8)"),
        "{message}"
    );
    let message = read(&TEXT, &big).expect_err("it is binary").to_string();
    assert!(
        message.contains("(read as text; it would fit `format` ugrid-b8)"),
        "{message}"
    );
    let (text, _) = written(&TEXT, &solid());
    let message = read(&LR8, &text).expect_err("it is text").to_string();
    assert!(
        message.contains("it would fit `format` ugrid)"),
        "{message}"
    );
    let message = read(&TEXT, &big[..200])
        .expect_err("it is cut off")
        .to_string();
    assert_says(&message, "expected text, found binary data");
}

#[test]
fn what_is_behind_the_last_cell_is_noted() {
    for (flavour, n, what) in [(&B8, 20, "bytes"), (&TEXT, 5, "numbers")] {
        let (mut file, _) = written(flavour, &solid());
        match what {
            "numbers" => file.extend(b"0 1 1 1 1"),
            _ => file.extend([0; 20]),
        }
        let (mesh, notes) = read(flavour, &file).expect("the mesh is whole");
        assert_eq!(mesh, solid());
        assert_eq!(notes, ["rest_not_kept"]);
        let start = format!("{what} after the last cell ({n}),");
        assert!(
            notes.iter().all(|note| note.text.starts_with(&start)),
            "{notes:?}"
        );
    }
}

#[test]
fn wrong_marks_of_records_are_noted_where_the_length_fits() {
    let (mut file, _) = written(&LR8, &solid());
    file[0] = 56;
    let last = file.len() - 1;
    file[last] = 1;
    let (mesh, notes) = read(&LR8, &file).expect("the length fits");
    assert_eq!(mesh, solid());
    assert_eq!(notes, ["wrong_record_marks"]);
    file.pop();
    let message = read(&LR8, &file).expect_err("it is cut off").to_string();
    assert_says(&message, "does not start with a Fortran record");
}

#[test]
fn files_of_a_case_share_its_name() {
    for (path, expected) in [
        ("a/wing.b8.ugrid", "a/wing"),
        ("wing.lb8l.ugrid.gz", "wing"),
        ("wing.v2.UGRID", "wing.v2"),
        ("wing.b8.ugrid64", "wing"),
        ("wing.grid", "wing.grid"),
    ] {
        assert_eq!(case(Path::new(path)), Path::new(expected));
    }
}

#[test]
fn a_large_text_is_read_as_a_small_one() {
    let mut mesh = Mesh::of_points(
        (0..90_000)
            .map(|i| [f64::from(i), 1.0 / f64::from(i + 1), -2.5])
            .collect(),
    );
    let nodes: Vec<u32> = (0..80_000).flat_map(|i| [i, i + 1, i + 2, i + 3]).collect();
    let faces: Vec<u32> = (0..50_000).flat_map(|i| [i, i + 1, i + 2]).collect();
    mesh.cells.push_run(CellKind::Triangle, 3, &faces);
    mesh.cells.push_run(CellKind::Tetrahedron, 4, &nodes);
    mesh.groups = vec![
        tag("1", Some(1), 0..20_000),
        tag("2", Some(2), 20_000..50_000),
    ];
    let (file, _) = written(&TEXT, &mesh);
    assert!(file.len() > 3 << 20);
    assert_eq!(read(&TEXT, &file).expect("it was written").0, mesh);
    let text = String::from_utf8(file).expect("text");
    let wrong = text.replace("\n79999 80000 80001 80002\n", "\n79999 90001 80001 80002\n");
    let line = 1 + wrong
        .lines()
        .position(|line| line.contains(" 90001 "))
        .expect("it is there");
    let message = read(&TEXT, wrong.as_bytes())
        .expect_err("it is wrong")
        .to_string();
    assert_eq!(
        message,
        format!(
            "line {line}: a tetrahedron has node 90001, but the mesh has 90000 nodes, counted from 1"
        )
    );
}

#[test]
fn an_old_mapbc_does_not_rename_the_tags_of_a_new_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wing.b8.ugrid");
    assert!((B8.companions)(&solid().view(), &path).is_empty());
    std::fs::write(folder.path().join("wing.mapbc"), "1\n2 4000 hub\n").expect("a folder");
    saved(&solid(), &path, &B8);
    let source = Source::open(&path).expect("it is there");
    let mesh = B8.read_file(&source, &ReadOptions::default(), &mut Notes::default());
    assert_eq!(mesh.expect("it can be read").groups, solid().groups);
}
