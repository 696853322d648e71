//! The commands on CGNS files in ADF, written by the CGNS library: what they give is that of the same mesh in HDF5.

use crate::support::sequence::testdata;
use crate::support::{azimesh, json, succeed};
use std::path::Path;
use tempfile::TempDir;

const SCHEDULE: &str = "[time]\nstart = 0.0\nstop = 1.0\nstep = 0.5\nfrequency = 1.0\n\n[[body]]\nname = \"low\"\n\
tags = [\"low\"]\n\n[body.rigid]\nramp = true\ntranslate = [0.0, 0.1, 0.0]\n\n[boundaries]\nfixed = [\"high\"]\n\
others = \"free\"\n\n[rbf]\nsupport_radius = 3.0\n";

/// A folder with the same mesh in ADF and in HDF5.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let copy = |from: &str, to: &str| {
        std::fs::copy(testdata(&format!("cgns/{from}")), folder.path().join(to)).unwrap();
    };
    copy("adf_version_b.cgns", "adf.cgns");
    copy("polyhedra_offsets.cgns", "hdf5.cgns");
    copy("adf_fragmented_big_endian.cgns", "old.cgns");
    copy("structured_rind.cgns", "new.cgns");
    std::fs::write(folder.path().join("low.toml"), SCHEDULE).unwrap();
    folder
}

fn same(folder: &Path, one: &str, other: &str) {
    let run = succeed(folder, ["diff", one, other]);
    assert!(run.out.contains("same"), "{run:?}");
}

#[test]
fn every_command_takes_a_file_in_adf() {
    let folder = folder();
    let folder = folder.path();
    same(folder, "adf.cgns", "hdf5.cgns");
    same(folder, "old.cgns", "new.cgns");
    for command in ["info", "quality"] {
        let of = |name: &str| json(folder, format!("{command} {name}"));
        let (adf, mut hdf5) = (of("old.cgns"), of("new.cgns"));
        for name in ["mesh", "file", "format"] {
            if hdf5.get(name).is_some() {
                hdf5[name] = adf[name].clone();
            }
        }
        assert_eq!(adf, hdf5, "{command:?}");
    }
    succeed(folder, "convert old.cgns copy.vtu");
    same(folder, "copy.vtu", "new.cgns");
    for name in ["adf", "hdf5"] {
        let mesh = format!("{name}.cgns");
        succeed(folder, ["check", &mesh, "low.toml"]);
        succeed(folder, ["deform", &mesh, "low.toml", "-o", name]);
    }
    for step in 0..3 {
        let of = |name: &str| format!("{name}/{name}_000{step}.vtu");
        same(folder, &of("adf"), &of("hdf5"));
    }
}

#[test]
fn a_copy_as_cgns_is_in_hdf5_and_that_is_told() {
    let folder = folder();
    let run = succeed(folder.path(), "convert adf.cgns copy.cgns");
    assert!(
        run.err
            .contains("was read from a CGNS file in ADF and is written in HDF5"),
        "{run:?}"
    );
    let bytes = std::fs::read(folder.path().join("copy.cgns")).unwrap();
    assert!(bytes.starts_with(b"\x89HDF"));
    same(folder.path(), "copy.cgns", "adf.cgns");
}

#[test]
fn damage_is_told_with_file_and_byte() {
    let folder = folder();
    let bytes = std::fs::read(folder.path().join("adf.cgns")).unwrap();
    std::fs::write(folder.path().join("cut.cgns"), &bytes[..5000]).unwrap();
    let run = azimesh(folder.path(), "info cut.cgns");
    assert_eq!(run.code, 2);
    assert!(run.err.contains("cut.cgns: byte "), "{run:?}");
    assert!(run.err.contains("but the file has 5000 bytes"), "{run:?}");
}
