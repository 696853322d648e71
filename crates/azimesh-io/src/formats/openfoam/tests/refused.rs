//! Files that do not fit, with their places.

use super::super::fixtures::{ASCII, BINARY, small};
use super::{case_of, change, refused};
use crate::testing::assert_says;
use std::fs;

#[test]
fn a_file_that_does_not_fit_is_refused_with_its_place() {
    let mut wrong = Vec::new();
    for (name, from, to, expected) in [
        (
            "points",
            "(0.0 0.0 0.0)",
            "(0.0 x 0.0)",
            "points:12: expected a finite number, found \"x 0.0)\"",
        ),
        (
            "points",
            "13\n(",
            "14\n(",
            "points:11: the list is said to have 14 values, but it has 13",
        ),
        (
            "points",
            ")\n\n// **** //",
            "",
            "points:24: expected ) after three numbers, found \")\"",
        ),
        (
            "points",
            "FoamFile",
            "Foam",
            "points:1: the file has no header (FoamFile), so it is none of OpenFOAM",
        ),
        (
            "faces",
            " 1 4 10 7 ",
            " 1 4 10 70 ",
            "faces: face 0 has node 70, but the mesh has 13 nodes (from 0)",
        ),
        (
            "faces",
            "4 ( 1 ",
            "5 ( 1 ",
            "faces:12: expected a face with as many nodes as it says, found \"5 ( 1 4 10 7 ) 4 ( 7 8 11 10 ) 4 ( 0 6 9...\"",
        ),
        (
            "owner",
            "15\n(",
            "13\n(",
            "owner:11: the list is said to have 13 values, but it has 15",
        ),
        (
            "owner",
            "15\n(\n0",
            "14\n(",
            "owner: 14 faces have an owner, but there are 15",
        ),
        (
            "owner",
            "0\n1\n",
            "0\n-1\n",
            "owner:13: expected an index, found \"-1\"",
        ),
        (
            "owner",
            "\n2\n2\n",
            "\n2\n7000\n",
            "owner: the last cell is 7000, but there are 15 faces, too few for so many cells",
        ),
        (
            "owner",
            "\n2\n2\n",
            "\n2\n3\n",
            "faces: cell 3 has 1 face; it must have at least 4",
        ),
        (
            "neighbour",
            "(\n1\n2",
            "(\n0\n2",
            "neighbour: face 0 has cell 0 on both sides",
        ),
        (
            "neighbour",
            "(\n1\n2",
            "(\n-1\n2",
            "neighbour: face 0 has no neighbour, but face 1 after it has one",
        ),
        (
            "boundary",
            "startFace 2",
            "startFace 1",
            "boundary: patch \"left\" starts at face 1, which is between two cells",
        ),
        (
            "boundary",
            "nFaces 10",
            "nFaces 11",
            "boundary: patch \"far\" ends at face 16, but there are 15",
        ),
        (
            "boundary",
            "startFace 3",
            "startFace 2",
            "boundary: patch \"bottom\" starts at face 2, which is in a patch before it",
        ),
        (
            "cellZones",
            "(\n1\n2\n)",
            "(\n1\n3\n)",
            "cellZones: zone \"top\" has cell 3, but the mesh has 3 cells (from 0)",
        ),
        (
            "boundary",
            "far\n{",
            "#include \"far\"\n{",
            "boundary:30: the directive #include is not followed; write what it stands for in its place",
        ),
    ] {
        let case = case_of(&small(), ASCII);
        change(&case, name, from, to);
        let error = refused(case.path());
        let found = error
            .trim_start_matches("CASE/constant/polyMesh/")
            .trim_start_matches("CASE: ");
        let found = found.replace(&format!("{name}: {name}: "), &format!("{name}: "));
        if found != expected {
            wrong.push(format!("{name} {to}: {found}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_binary_list_that_ends_elsewhere_is_refused_with_its_byte() {
    for name in ["points", "faces", "owner"] {
        let case = case_of(&small(), BINARY);
        let path = case.path().join("constant/polyMesh").join(name);
        let bytes = fs::read(&path).expect("a file");
        fs::write(&path, &bytes[..bytes.len() - 20]).expect("it is written");
        let error = refused(case.path());
        assert_says(&error, &format!("polyMesh/{name}: byte "));
        assert_says(&error, "the file is cut off or damaged");
    }
}
