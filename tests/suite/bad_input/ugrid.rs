//! What is wrong in UGRID files, with its place.

use super::{Wrong, line, refusal, refused};
use crate::support::assert_says;
use azimesh_core::error::Position;
use azimesh_io::formats::{FORMATS, Format, ReadOptions, WriteOptions, parse, ugrid};

const GOOD: &str = "5 2 1 1 1 0 0\n0.0 0.0 0.0\n1.0 0.0 0.0\n1.0 1.0 0.0\n0.0 1.0 0.0\n\
                    0.5 0.5 1.5e0\n1 2 5\n2 3 5\n1 4 3 2\n3\n3\n7\n1 2 3 5\n2 1 5 3 4\n";

/// The good mesh as bytes.
fn written(flavour: &Format) -> Vec<u8> {
    let mesh = parse(&ugrid::TEXT, GOOD.as_bytes(), &ReadOptions::default()).unwrap();
    let mut file = Vec::new();
    let written = flavour.write_file(&mesh.view(), &mut file, &WriteOptions::default());
    written.unwrap();
    file
}

#[test]
fn a_wrong_number_is_named_with_what_would_be_right() {
    let wrong: [Wrong; 6] = [
        (
            "2 3 5\n",
            "2 3 6\n",
            line(8),
            &["triangle", "node 6", "5 nodes", "1"],
        ),
        (
            "2 1 5 3 4",
            "2 0 5 3 4",
            line(14),
            &["pyramid", "node 0", "5 nodes"],
        ),
        ("0.5 0.5", "0.5 x", line(6), &["coordinate", "\"x\""]),
        ("5 2 1", "5 999999999 1", line(15), &["4000000025", "37"]),
        ("5 2 1", "5 -2 1", line(1), &["triangles", "-2"]),
        ("5 2 1", "99999999999 2 1", line(1), &["4294967294"]),
    ];
    refused(&ugrid::TEXT, GOOD, &wrong);
    let mut file = written(&ugrid::B8);
    file[28 + 120 + 3] = 9;
    let error = refusal(&ugrid::B8, &file);
    assert_eq!(error.position, Some(Position::Byte(148)), "{error}");
    assert_says(&error.message, &["triangle", "node 9", "5 nodes"]);
    let mut file = written(&ugrid::R8);
    file[39] ^= 1;
    file.pop();
    assert_says(&refusal(&ugrid::R8, &file).message, &["Fortran"]);
}

#[test]
fn a_file_that_lacks_its_last_bytes_is_refused() {
    let flavours = FORMATS.iter().filter(|f| f.name.starts_with("ugrid"));
    for flavour in flavours {
        let file = written(flavour);
        refusal(flavour, &file[..file.len() - 2]);
    }
}
