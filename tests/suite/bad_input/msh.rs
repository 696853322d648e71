//! What is wrong in MSH files, with its place.

use super::{Wrong, line, refusal, refused};
use crate::support::assert_says;
use azimesh_io::formats::gmsh::MSH41;

const GOOD: &str = "$MeshFormat\r\n2.2 0 8\r\n$EndMeshFormat\r\n$Nodes\r\n3\r\n1 0 0 0\r\n2 1 0 0\r\n\
                    3 0 1 0\r\n$EndNodes\r\n$Elements\r\n1\r\n1 2 2 1 1 1 2 3\r\n$EndElements\r\n";

#[test]
fn a_wrong_line_is_named_with_what_would_be_right() {
    let wrong: [Wrong; 2] = [
        (
            "1 1 1 2 3\r",
            "1 1 1 2\r",
            line(12),
            &["triangle", "3 nodes", "2"],
        ),
        (
            "1 1 1 2 3\r",
            "1 1 1 2 7\r",
            line(12),
            &["triangle", "node 7", "$Nodes"],
        ),
    ];
    refused(&MSH41, GOOD, &wrong);
}

#[test]
fn other_versions_are_refused_with_those_that_are_read() {
    for version in ["0", "4.2", "5"] {
        let error = refusal(&MSH41, GOOD.replace("2.2", version).as_bytes());
        assert!(error.position.is_some(), "{error}");
        assert_says(&error.message, &[version, "1", "4.1"]);
    }
}
