//! Real MSH and SU2 files, from the folder that AZIMESH_TESTDATA names.

use azimesh_io::formats::{self, Encoding, Format, ReadOptions, Source, WriteOptions, gmsh, su2};
use azimesh_io::mesh::{Group, Mesh};
use std::path::{Path, PathBuf};

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    for entry in entries {
        let path = entry.expect("a readable entry").path();
        let name = path.to_string_lossy();
        if path.is_dir() {
            files_below(&path, found);
        } else if name.ends_with(".msh") || name.ends_with(".su2") || name.ends_with(".su2.gz") {
            found.push(path);
        }
    }
}

/// Empty where the folder is not given, which is said loudly.
fn real_meshes() -> Vec<(PathBuf, Mesh)> {
    let Some(folder) = std::env::var_os("AZIMESH_TESTDATA") else {
        eprintln!("AZIMESH_TESTDATA is not set: NO REAL MESH IS TESTED");
        return Vec::new();
    };
    let mut files = Vec::new();
    files_below(Path::new(&folder), &mut files);
    files.sort();
    let mut meshes = Vec::new();
    for path in files {
        match Mesh::read_with(&path, &ReadOptions::default()) {
            Ok(loaded) => meshes.push((path, loaded.mesh)),
            Err(error) => assert!(
                error.position.is_some()
                    || error.message.contains("the mesh format is not known")
                    || error.message.contains("the file is empty"),
                "no place: {error}"
            ),
        }
    }
    assert!(meshes.len() > 200, "only {} meshes are read", meshes.len());
    meshes
}

fn back(format: &'static Format, mesh: &Mesh, encoding: Encoding) -> Option<Mesh> {
    let options = WriteOptions {
        encoding,
        ..WriteOptions::default()
    };
    let mut file = Vec::new();
    format.write_file(&mesh.view(), &mut file, &options).ok()?;
    let source = Source::from_bytes(Path::new("written"), file);
    let loaded = formats::read_as(format, &source.into(), &ReadOptions::default());
    Some(loaded.expect("what was written").mesh)
}

/// Groups without what MSH does not hold: conditions, and that a group has no number.
fn named(groups: &[Group]) -> Vec<Group> {
    let mut groups = groups.to_vec();
    for group in &mut groups {
        group.number = None;
        group.condition = None;
    }
    groups.sort_by_key(|group| (group.dimension, group.name.clone()));
    groups
}

#[test]
fn real_meshes_come_back_from_every_flavour_of_msh() {
    for (path, mesh) in real_meshes() {
        for format in [&gmsh::MSH41 as &'static Format, &gmsh::MSH22] {
            for encoding in [Encoding::Raw, Encoding::Ascii] {
                let back = back(format, &mesh, encoding).expect("MSH holds it");
                let place = path.display();
                assert_eq!(back.points, mesh.points, "{place}");
                assert_eq!(back.cells, mesh.cells, "{place}");
                assert_eq!(named(&back.groups), named(&mesh.groups), "{place}");
            }
        }
    }
}

#[test]
fn tags_of_real_meshes_come_back_from_su2() {
    for (path, mesh) in real_meshes() {
        let Some(back) = back(&su2::SU2, &mesh, Encoding::Raw) else {
            continue;
        };
        let n_cells = |mesh: &Mesh| -> Vec<(String, usize)> {
            let tags = mesh.boundary_tags();
            tags.map(|tag| (tag.name.clone(), tag.cells.len()))
                .collect()
        };
        let mut tags = n_cells(&mesh);
        for tag in &mut tags {
            tag.0 = tag.0.replace(' ', "_");
        }
        assert_eq!(n_cells(&back), tags, "{}", path.display());
    }
}
