//! Any bytes given to these readers: a mesh that can be written, or an error that says where.
//! The first byte chooses the flavour.

#![no_main]

use azimesh::formats::{parse, ugrid, Format, ReadOptions, WriteOptions};
use libfuzzer_sys::fuzz_target;

static FLAVOURS: &[&ugrid::Ugrid] = &[
    &ugrid::TEXT,
    &ugrid::B8,
    &ugrid::LB8,
    &ugrid::B4,
    &ugrid::LB4,
    &ugrid::R8,
    &ugrid::LR8,
    &ugrid::R4,
    &ugrid::LR4,
    &ugrid::B8L,
    &ugrid::LB8L,
];

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else {
        return;
    };
    let flavour = FLAVOURS[usize::from(*first) % FLAVOURS.len()];
    match parse(flavour, bytes, &ReadOptions::default()) {
        Ok(mut mesh) => {
            if mesh.validate().is_ok() {
                mesh.merge_repeated_faces();
                for flavour in FLAVOURS {
                    // What a format cannot hold is an error of its own; a panic is a bug.
                    let _ = flavour.write(&mesh, &mut std::io::sink(), &WriteOptions::default());
                }
            }
        }
        Err(error) => assert!(error.position.is_some(), "no place: {error}"),
    }
});
