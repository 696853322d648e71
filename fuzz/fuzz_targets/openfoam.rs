//! Any bytes in one file of an OpenFOAM case, whose others are good. The first byte says which file.

#![no_main]

use azimesh::formats::openfoam::OpenFoam;
use azimesh::formats::{Format, Location, Notes, ReadOptions};
use libfuzzer_sys::fuzz_target;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const FILES: [&str; 6] = ["points", "faces", "owner", "neighbour", "boundary", "cellZones"];

/// A case of this process, with a copy of the files of `testdata/`.
static CASE: LazyLock<PathBuf> = LazyLock::new(|| {
    let good = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../testdata/openfoam/binary/constant/polyMesh"));
    let case = std::env::temp_dir().join(format!("azimesh_fuzz_{}", std::process::id()));
    let mesh = case.join("constant/polyMesh");
    fs::create_dir_all(&mesh).expect("a folder");
    for name in FILES {
        fs::copy(good.join(name), mesh.join(name)).expect("a file");
    }
    case
});

fuzz_target!(|bytes: &[u8]| {
    let Some((which, bytes)) = bytes.split_first() else {
        return;
    };
    let path = CASE.join("constant/polyMesh").join(FILES[usize::from(*which) % FILES.len()]);
    let good = fs::read(&path).expect("a file");
    fs::write(&path, bytes).expect("it is written");
    let location = Location::open(&CASE).expect("it is there");
    let read = OpenFoam.read(&location, &ReadOptions::default(), &mut Notes::default());
    fs::write(&path, good).expect("it is written");
    match read {
        Ok(mesh) => drop(mesh.validate()),
        Err(error) => assert!(error.position.is_some(), "no place: {error}"),
    }
});
