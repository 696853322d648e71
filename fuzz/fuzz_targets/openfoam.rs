//! Any bytes in one file of an OpenFOAM case, whose others are good. The first byte says which file: of a whole case, of
//! one in pieces, of one whose pieces are collated, of one that has nothing but tetrahedra.

#![no_main]

use azimesh_io::Mesh;
use azimesh_io::formats::openfoam::OPENFOAM;
use azimesh_io::formats::{Location, Notes, OutputSet, ReadOptions, WriteOptions};
use libfuzzer_sys::fuzz_target;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const FILES: [&str; 6] = ["points", "faces", "owner", "neighbour", "boundary", "cellZones"];
/// Numbers of a piece in the whole.
const NUMBERS: [&str; 4] = ["pointProcAddressing", "faceProcAddressing", "cellProcAddressing", "boundaryProcAddressing"];
/// Cases of `testdata/`, and the folder of one of their meshes.
const CASES: [(&str, &str); 3] = [
    ("binary", "constant/polyMesh"),
    ("decomposed", "processor1/constant/polyMesh"),
    ("collated", "processors2/constant/polyMesh"),
];

/// Copies of the cases for this process, and the files that are replaced: the case and the path of each.
static PLACES: LazyLock<Vec<(PathBuf, PathBuf)>> = LazyLock::new(|| {
    let good = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../testdata/openfoam"));
    let own = std::env::temp_dir().join(format!("azimesh_fuzz_{}", std::process::id()));
    let mut places = Vec::new();
    for (case, mesh) in CASES {
        copy(&good.join(case), &own.join(case));
        let names = FILES.iter().chain(NUMBERS.iter().filter(|_| case != "binary"));
        places.extend(names.map(|name| (own.join(case), own.join(case).join(mesh).join(name))));
    }
    // A mesh of tetrahedra, in binary files.
    let testdata = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../testdata"));
    let case = own.join("tetrahedra");
    let mesh = Mesh::read(testdata.join("sphere_in_box_raw_zlib.vtu")).expect("a mesh");
    fs::create_dir_all(&case).expect("a folder");
    mesh.write(case.join("case.foam")).expect("it is written");
    places.extend(FILES[..5].iter().map(|name| (case.clone(), case.join("constant/polyMesh").join(name))));
    places
});

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let to = to.join(entry.file_name());
        match entry.path().is_dir() {
            true => copy(&entry.path(), &to),
            false => drop(fs::copy(entry.path(), to).expect("a file")),
        }
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((which, bytes)) = bytes.split_first() else {
        return;
    };
    let (case, path) = &PLACES[usize::from(*which) % PLACES.len()];
    let good = fs::read(path).expect("a file");
    fs::write(path, bytes).expect("it is written");
    let location = Location::open(case).expect("it is there");
    let read = OPENFOAM.read(&location, &ReadOptions::default(), &mut Notes::default());
    match read {
        Ok(mesh) => {
            if mesh.validate().is_ok() {
                // What the format cannot hold is an error of its own; a panic is a bug.
                let mut out = OutputSet::nowhere(Path::new("out"));
                let _ = OPENFOAM.write(&mesh.view(), &mut out, &WriteOptions::default());
            }
        }
        Err(error) => assert!(error.position.is_some(), "no place: {error}"),
    }
    fs::write(path, good).expect("it is written");
});
