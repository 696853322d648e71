//! Damaged UGRID files: always an error with a place or a mesh, never a panic, a hang or a huge
//! allocation.

use azimesh::error::Result;
use azimesh::formats::{Format, ReadOptions, WriteOptions, parse, ugrid};
use azimesh::mesh::Mesh;
use proptest::prelude::*;

const GOOD: &str = "5 2 1 1 1 0 0\n0.0 0.0 0.0\n1.0 0.0 0.0\n1.0 1.0 0.0\n0.0 1.0 0.0\n\
                    0.5 0.5 1.5e0\n1 2 5\n2 3 5\n1 4 3 2\n3\n3\n7\n1 2 3 5\n2 1 5 3 4\n";

static FLAVOURS: &[&ugrid::Ugrid] = &[
    &ugrid::TEXT,
    &ugrid::B8,
    &ugrid::LB4,
    &ugrid::R8,
    &ugrid::LR4,
    &ugrid::B8L,
    &ugrid::LB8L,
];

fn read(flavour: &ugrid::Ugrid, bytes: &[u8]) -> Result<Mesh> {
    parse(flavour, bytes, &ReadOptions::default())
}

fn read_or_place(flavour: &ugrid::Ugrid, bytes: &[u8]) {
    if let Err(error) = read(flavour, bytes) {
        assert!(error.position.is_some(), "no place: {error}");
    }
}

/// The good mesh as bytes.
fn written(flavour: &ugrid::Ugrid) -> Vec<u8> {
    let mesh = read(&ugrid::TEXT, GOOD.as_bytes()).unwrap();
    let mut file = Vec::new();
    flavour
        .write_file(&mesh.view(), &mut file, &WriteOptions::default())
        .unwrap();
    file
}

#[test]
fn every_truncation_is_an_error_with_a_place() {
    for flavour in FLAVOURS {
        let file = written(flavour);
        read(flavour, &file).unwrap();
        for length in 0..file.len() {
            read_or_place(flavour, &file[..length]);
        }
        assert!(read(flavour, &file[..file.len() - 2]).is_err());
    }
}

#[test]
fn a_wrong_number_is_named_with_what_would_be_right() {
    let refusal = |old: &str, new: &str| {
        assert!(GOOD.contains(old));
        let file = GOOD.replace(old, new);
        read(&ugrid::TEXT, file.as_bytes()).unwrap_err().to_string()
    };
    assert_eq!(
        refusal("2 3 5\n", "2 3 6\n"),
        "line 8: a triangle has node 6, but the mesh has 5 nodes, counted from 1"
    );
    assert_eq!(
        refusal("2 1 5 3 4", "2 0 5 3 4"),
        "line 14: a pyramid has node 0, but the mesh has 5 nodes, counted from 1"
    );
    assert_eq!(
        refusal("0.5 0.5", "0.5 x"),
        "line 6: expected a number as a coordinate, found \"x\""
    );
    assert_eq!(
        refusal("5 2 1", "5 999999999 1"),
        "line 15: the counts at the start need 4000000025 numbers, the file ends after 37"
    );
    assert!(refusal("5 2 1", "5 -2 1").contains("the number of triangles is -2"));
    assert!(refusal("5 2 1", "99999999999 2 1").contains("at most 4294967294"));
    let mut file = written(&ugrid::B8);
    file[28 + 120 + 3] = 9;
    assert_eq!(
        read(&ugrid::B8, &file)
            .unwrap_err()
            .to_string()
            .trim_start(),
        "byte 148: a triangle has node 9, but the mesh has 5 nodes, counted from 1"
    );
    let mut file = written(&ugrid::R8);
    file[39] ^= 1;
    file.pop();
    let message = read(&ugrid::R8, &file).unwrap_err().to_string();
    assert!(message.contains("Fortran records are damaged"), "{message}");
}

proptest! {
    #[test]
    fn random_bytes_are_no_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        for flavour in FLAVOURS {
            read_or_place(flavour, &bytes);
            let start = &written(flavour)[..40];
            read_or_place(flavour, &[start, &bytes[..]].concat());
        }
    }

    #[test]
    fn flipped_bytes_are_no_panic(
        flips in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        for flavour in FLAVOURS {
            let mut file = written(flavour);
            for (at, byte) in &flips {
                let at = at.index(file.len());
                file[at] = *byte;
            }
            read_or_place(flavour, &file);
        }
    }
}
