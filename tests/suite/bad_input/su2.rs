//! What is wrong in SU2 files, with its place.

use super::{Wrong, line, refusal, refused};
use crate::support::assert_says;
use azimesh_io::formats::su2::SU2;

const GOOD: &str = "% a plane mesh\nNDIME= 2\nNELEM= 2\n5 0 1 2 0\n9 1 3 4 2 1\nNPOIN= 5 5\n\
                    0 0 0\n1 0 1\n0 1 2\n2 0 3\n1.5e0 1 4\nNMARK= 2\nMARKER_TAG= wall\n\
                    MARKER_ELEMS= 2\n3 0 1\n3 1 3\nMARKER_TAG= far\nMARKER_ELEMS= 0\n";

#[test]
fn a_wrong_line_is_named_with_what_would_be_right() {
    let wrong: [Wrong; 11] = [
        ("5 0 1 2 0", "5 0 1", line(4), &["triangle", "3 node", "2"]),
        (
            "3 1 3\n",
            "3 1 5\n",
            line(16),
            &["line", "node 5", "5 nodes"],
        ),
        ("2 0 3", "2 x 3", line(10), &["coordinate", "\"x\""]),
        (
            "3 1 3\n",
            "5 0 1 3\n",
            line(16),
            &["triangle", "\"wall\"", "NDIME= 2"],
        ),
        (
            "5 0 1 2 0",
            "10 0 1 2 3",
            line(4),
            &["tetrahedron", "NDIME= 2"],
        ),
        (
            "MARKER_ELEMS= 0",
            "MARKER_ELEMS= 99999999999",
            line(19),
            &["0", "99999999999"],
        ),
        (
            "NDIME= 2",
            "NZONE= 3\nNDIME= 2",
            line(20),
            &["zone", "1", "3"],
        ),
        ("NDIME= 2", "IZONE= 1\nIZONE= 1", line(3), &["IZONE"]),
        (
            "5 0 1 2 0",
            "2012 0 1 2 0",
            line(4),
            &["2012", "hexahedron", "21", "10"],
        ),
        ("5 0 1 2 0", "206 0 1 2 0", line(4), &["206"]),
        ("NPOIN= 5 5", "NPOIN= -5", line(6), &["NPOIN", "negative"]),
    ];
    refused(&SU2, GOOD, &wrong);
    let solid = GOOD.replace("NDIME= 2", "NDIME= 3");
    let error = refusal(
        &SU2,
        format!("IZONE= 1\n{GOOD}IZONE= 2\n{solid}").as_bytes(),
    );
    assert_eq!(error.position, Some(line(22)), "{error}");
    assert_says(&error.message, &["2", "3"]);
}

#[test]
fn a_wrong_count_is_named_where_it_stands() {
    let wrong: [Wrong; 7] = [
        (
            "NELEM= 2",
            "NELEM= 1",
            line(3),
            &["NELEM= 1", "\"9 1 3 4 2 1\""],
        ),
        (
            "NELEM= 2",
            "NELEM= 3",
            line(3),
            &["NELEM= 3", "2 lines", "\"NPOIN= 5 5\""],
        ),
        (
            "NELEM= 2",
            "NELEM= 9",
            line(3),
            &["NELEM= 9", "2 lines", "\"NPOIN= 5 5\""],
        ),
        (
            "NPOIN= 5 5",
            "NPOIN= 6",
            line(6),
            &["NPOIN= 6", "5 lines", "\"NMARK= 2\""],
        ),
        (
            "ELEMS= 2",
            "ELEMS= 1",
            line(14),
            &["MARKER_ELEMS= 1", "\"3 1 3\""],
        ),
        (
            "ELEMS= 2",
            "ELEMS= 3",
            line(14),
            &["MARKER_ELEMS= 3", "2 lines", "\"MARKER_TAG= far\""],
        ),
        (
            "ELEMS= 2",
            "ELEMS= 70",
            line(14),
            &["MARKER_ELEMS= 70", "2 lines", "\"MARKER_TAG= far\""],
        ),
    ];
    refused(&SU2, GOOD, &wrong);
}
