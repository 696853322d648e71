//! Any bytes given to this reader: a mesh that can be written, or an error that says where.

#![no_main]

use azimesh::formats::{parse, su2::Su2, Format, ReadOptions, WriteOptions};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match parse(&Su2, bytes, &ReadOptions::default()) {
        Ok(mut mesh) => {
            if mesh.validate().is_ok() {
                mesh.merge_repeated_faces();
                // What a format cannot hold is an error of its own; a panic is a bug.
                let _ = Su2.write(&mesh, &mut std::io::sink(), &WriteOptions::default());
            }
        }
        Err(error) => assert!(error.position.is_some(), "no place: {error}"),
    }
});
