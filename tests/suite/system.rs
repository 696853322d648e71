//! A system that refuses: full disks and devices; standard input and output, quiet runs.

use crate::support::{airfoil, azimesh, succeed};
use assert_cmd::Command;
use azimesh::ErrorKind as AzimeshErrorKind;
use azimesh::sample;
use azimesh_io::formats::{Compression, Encoding, Out, WriteOptions, written};
use std::io::{Error, ErrorKind, Write};

/// A disk with room for so many bytes.
struct Disk(usize);

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.0 == 0 {
            return Err(Error::from(ErrorKind::StorageFull));
        }
        let n = bytes.len().min(self.0);
        self.0 -= n;
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Out for Disk {}

#[test]
fn a_disk_that_fills_up_anywhere_is_the_systems_failure_in_every_format() {
    let mesh = sample::block(1).unwrap().mesh;
    let encodings = [Encoding::Raw, Encoding::Base64, Encoding::Ascii];
    let compressions = [
        Compression::None,
        Compression::Zlib,
        Compression::Lz4,
        Compression::Lzma,
    ];
    for format in written() {
        for (encoding, compression) in encodings.iter().flat_map(|e| compressions.map(|c| (*e, c)))
        {
            let options = WriteOptions {
                encoding,
                compression,
                ..WriteOptions::default()
            };
            let mut whole = Vec::new();
            if format
                .write_file(&mesh.view(), &mut whole, &options)
                .is_err()
            {
                continue; // an encoding the format does not have is refused elsewhere
            }
            let room = (0..whole.len()).step_by(whole.len() / 50 + 1);
            for room in room.chain([whole.len() - 1]) {
                let written = format.write_file(&mesh.view(), &mut Disk(room), &options);
                let error = written.expect_err("the disk is full");
                let what = format!("{} {encoding:?} {compression:?} {room}", format.name);
                assert_eq!(error.kind, AzimeshErrorKind::System, "{what}: {error}");
                assert!(
                    error.to_string().contains("no storage space"),
                    "{what}: {error}"
                );
            }
            let exact = format.write_file(&mesh.view(), &mut Disk(whole.len()), &options);
            exact.expect("all of it fits");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_gives_exit_code_3() {
    let folder = airfoil();
    for format in written() {
        // Written in pieces, without a place for plane meshes, or with notes: not the disk alone is told of.
        let name = format.name;
        if matches!(name, "pvtu" | "openfoam" | "stl" | "vtp") || name.starts_with("ugrid") {
            continue;
        }
        let convert = ["convert", "n.vtu", "/dev/full", "--format", format.name];
        let run = azimesh(folder.path(), convert);
        assert_eq!((run.code, run.out.as_str()), (3, ""), "{run:?}");
        assert!(run.err.starts_with("error: /dev/full: "), "{}", run.err);
        assert!(run.err.contains("No space left on device"), "{}", run.err);
        assert_eq!(run.err.lines().count(), 1, "{}", run.err);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_where_nothing_may_be_made_gives_exit_code_3() {
    let folder = airfoil();
    // The kernel's own file systems refuse folders of anyone, root too.
    let run = azimesh(folder.path(), "deform n.vtu n.toml -q -o /sys/out");
    assert_eq!((run.code, run.out.as_str()), (3, ""), "{run:?}");
    assert!(run.err.starts_with("error: /sys/out: "), "{}", run.err);
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
}

#[test]
fn a_mesh_goes_through_standard_input_and_output() {
    let folder = airfoil();
    let folder = folder.path();
    let mut bytes = std::fs::read(folder.join("n.vtu")).unwrap();
    for format in ["msh", "msh22", "su2", "vtu"] {
        let output = Command::cargo_bin("azimesh")
            .unwrap()
            .args(["convert", "-", "-", "--format", format])
            .write_stdin(bytes)
            .output()
            .unwrap();
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{output:?}"
        );
        bytes = output.stdout;
    }
    std::fs::write(folder.join("back.vtu"), bytes).unwrap();
    succeed(folder, "diff n.vtu back.vtu");
}

#[test]
fn a_quiet_run_prints_nothing() {
    let folder = airfoil();
    for args in [
        "sample block -o b.vtu",
        "convert n.vtu n.msh",
        "select n.vtu n.toml -o base.toml",
        "deform n.vtu n.toml -o out",
        "deform n.vtu n.toml --base base.toml -o again",
    ] {
        let run = succeed(folder.path(), format!("{args} -q"));
        assert_eq!((run.out.as_str(), run.err.as_str()), ("", ""), "{args:?}");
    }
    let same = ["out/n_0009.vtu", "again/n_0009.vtu"].map(|name| folder.path().join(name));
    assert!(std::fs::read(&same[0]).unwrap() == std::fs::read(&same[1]).unwrap());
}
