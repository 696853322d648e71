//! Any bytes given to this reader: a mesh that can be written, or an error that says where.

#![no_main]

use azimesh::formats::{parse, gmsh::Msh, Format, ReadOptions, WriteOptions};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match parse(&Msh, bytes, &ReadOptions::default()) {
        Ok(mut mesh) => {
            if mesh.validate().is_ok() {
                mesh.merge_repeated_faces();
                // What a format cannot hold is an error of its own; a panic is a bug.
                let _ = Msh.write(&mesh, &mut std::io::sink(), &WriteOptions::default());
            }
        }
        Err(error) => assert!(error.position.is_some(), "no place: {error}"),
    }
});
