//! Damaged SU2 files: always an error with a place or a mesh, never a panic, a hang or a huge
//! allocation.

use azimesh::error::Result;
use azimesh::formats::{ReadOptions, parse, su2};
use azimesh::mesh::Mesh;
use proptest::prelude::*;

const GOOD: &str = "% a plane mesh\nNDIME= 2\nNELEM= 2\n5 0 1 2 0\n9 1 3 4 2 1\nNPOIN= 5 5\n\
                    0 0 0\n1 0 1\n0 1 2\n2 0 3\n1.5e0 1 4\nNMARK= 2\nMARKER_TAG= wall\n\
                    MARKER_ELEMS= 2\n3 0 1\n3 1 3\nMARKER_TAG= far\nMARKER_ELEMS= 0\n";

fn read(bytes: &[u8]) -> Result<Mesh> {
    parse(&su2::Su2, bytes, &ReadOptions::default())
}

fn read_or_place(bytes: &[u8]) {
    if let Err(error) = read(bytes) {
        assert!(error.position.is_some(), "no place: {error}");
    }
}

fn refusal(file: &str) -> String {
    read(file.as_bytes()).expect_err("it is wrong").to_string()
}

#[test]
fn every_truncation_is_an_error_with_a_place_or_a_mesh() {
    read(GOOD.as_bytes()).expect("a good file");
    for length in 0..GOOD.len() {
        read_or_place(&GOOD.as_bytes()[..length]);
    }
}

#[test]
fn a_wrong_line_is_named_with_what_would_be_right() {
    assert_eq!(
        refusal(&GOOD.replace("5 0 1 2 0", "5 0 1")),
        "line 4: a triangle needs 3 node indices, found 2"
    );
    assert_eq!(
        refusal(&GOOD.replace("3 1 3\n", "3 1 5\n")),
        "line 16: a line has node 5, but the mesh has 5 nodes, counted from 0"
    );
    assert_eq!(
        refusal(&GOOD.replace("2 0 3", "2 x 3")),
        "line 10: expected a number as a coordinate, found \"x\""
    );
    assert_eq!(
        refusal(&GOOD.replace("3 1 3\n", "5 0 1 3\n")),
        "line 16: a triangle cannot be on the boundary \"wall\" with NDIME= 2"
    );
    assert_eq!(
        refusal(&GOOD.replace("5 0 1 2 0", "10 0 1 2 3")),
        "line 4: a tetrahedron cannot be in a mesh with NDIME= 2"
    );
    assert_eq!(
        refusal(&GOOD.replace("MARKER_ELEMS= 0", "MARKER_ELEMS= 99999999999")),
        "line 19: the file ends after 0 of 99999999999 lines of boundary elements"
    );
    let zones = format!(
        "IZONE= 1\n{GOOD}IZONE= 2\n{}",
        GOOD.replace("NDIME= 2", "NDIME= 3")
    );
    assert!(refusal(&zones).starts_with("line 22: the zones have dimensions 2 and 3"));
    assert!(refusal(&GOOD.replace("NDIME= 2", "NZONE= 3")).contains("the file has 1 zone"));
    assert!(
        refusal(&GOOD.replace("NDIME= 2", "IZONE= 1\nIZONE= 1")).contains("IZONE= 1 appears twice")
    );
    assert_eq!(
        refusal(&GOOD.replace("5 0 1 2 0", "2012 0 1 2 0")),
        "line 4: element type 2012 is a hexahedron of degree 21; degrees up to 10 are read"
    );
    assert!(refusal(&GOOD.replace("5 0 1 2 0", "206 0 1 2 0")).contains("206"));
    assert!(refusal(&GOOD.replace("NPOIN= 5 5", "NPOIN= -5")).contains("negative"));
}

#[test]
fn a_wrong_count_is_named_where_it_stands() {
    for (right, wrong, refused) in [
        (
            "NELEM= 2",
            "NELEM= 1",
            "line 3: NELEM= 1, but there are more lines before the next keyword: \"9 1 3 4 2 1\"",
        ),
        (
            "NELEM= 2",
            "NELEM= 3",
            "line 3: NELEM= 3, but only 2 lines before \"NPOIN= 5 5\"",
        ),
        (
            "NELEM= 2",
            "NELEM= 9",
            "line 3: NELEM= 9, but only 2 lines before \"NPOIN= 5 5\"",
        ),
        (
            "NPOIN= 5 5",
            "NPOIN= 6",
            "line 6: NPOIN= 6, but only 5 lines before \"NMARK= 2\"",
        ),
        (
            "ELEMS= 2",
            "ELEMS= 1",
            "line 14: MARKER_ELEMS= 1, but there are more lines before the next keyword: \"3 1 3\"",
        ),
        (
            "ELEMS= 2",
            "ELEMS= 3",
            "line 14: MARKER_ELEMS= 3, but only 2 lines before \"MARKER_TAG= far\"",
        ),
        (
            "ELEMS= 2",
            "ELEMS= 70",
            "line 14: MARKER_ELEMS= 70, but only 2 lines before \"MARKER_TAG= far\"",
        ),
    ] {
        assert_eq!(refusal(&GOOD.replace(right, wrong)), refused);
    }
}

proptest! {
    #[test]
    fn random_bytes_are_no_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        read_or_place(&bytes);
        read_or_place(&[b"NDIME= 2\nNELEM= ", &bytes[..]].concat());
    }

    #[test]
    fn flipped_bytes_are_no_panic(
        flips in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut file = GOOD.as_bytes().to_vec();
        for (at, byte) in flips {
            let at = at.index(file.len());
            file[at] = byte;
        }
        read_or_place(&file);
    }
}
