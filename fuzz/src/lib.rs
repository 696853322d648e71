//! What every target asks of a reader.

use azimesh_io::formats::{Format, Location, Notes, ReadOptions, Source, WriteOptions};
use std::path::Path;

/// Any bytes are a mesh that can be written, or an error that says where.
pub fn read_and_written(format: &Format, bytes: &[u8]) {
    // Beside files that others name: the pieces of a .pvtu.
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../testdata/vtk/fuzzed"));
    let source = Source::from_bytes(path, bytes.to_vec());
    match format.read_file(&source, &ReadOptions::default(), &mut Notes::default()) {
        Ok(mut mesh) => {
            if mesh.validate().is_ok() {
                mesh.merge_repeated_faces();
                // What a format cannot hold is an error of its own; a panic is a bug.
                let _ = format.write_file(&mesh.view(), &mut std::io::sink(), &WriteOptions::default());
            }
        }
        Err(error) => assert!(error.position.is_some(), "no place: {error}"),
    }
    let _ = format.steps(&Location::from(source));
}
