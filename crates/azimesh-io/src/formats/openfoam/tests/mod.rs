//! The small mesh read from every kind of file, at every time.

mod pieces;
mod refused;

use super::fixtures::{ASCII, BINARY, PATCHES, Small, Way, small};
use super::topology::Topology;
use crate::formats::{Loaded, Location, ReadOptions, read};
use crate::mesh::{CellKind, Mesh};
use crate::testing::assert_says;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

fn loaded(path: &Path) -> azimesh_core::error::Result<Loaded> {
    read(&Location::open(path)?, &ReadOptions::default())
}

fn mesh(path: &Path) -> Mesh {
    loaded(path).unwrap_or_else(|error| panic!("{error}")).mesh
}

fn refused(path: &Path) -> String {
    let error = loaded(path).err().expect("it is refused").to_string();
    error.replace(&path.display().to_string(), "CASE")
}

fn step(path: &Path, step: usize) -> Mesh {
    let options = ReadOptions {
        step: Some(step),
        ..ReadOptions::default()
    };
    let location = Location::open(path).expect("it is there");
    read(&location, &options).expect("it is read").mesh
}

fn case_of(mesh: &Small, way: Way) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    mesh.write(folder.path(), way);
    folder
}

/// Replaces the text of one file.
fn change(case: &TempDir, name: &str, from: &str, to: &str) {
    let path = case.path().join("constant/polyMesh").join(name);
    let text = fs::read_to_string(&path).expect("a text");
    assert_says(&text, from);
    fs::write(path, text.replacen(from, to, 1)).expect("it is written");
}

#[test]
fn a_mesh_has_the_cells_faces_tags_and_zones_of_its_files() {
    let case = case_of(&small(), ASCII);
    let found = loaded(case.path()).expect("it is read");
    assert_eq!(found.format.name, "openfoam");
    let mesh = found.mesh;
    assert_eq!(mesh.points, small().points);
    let cells: Vec<_> = mesh
        .cells
        .iter()
        .map(|cell| (cell.kind, cell.nodes.to_vec()))
        .collect();
    assert_eq!(cells.len(), 3 + 13);
    let kinds = [
        CellKind::Hexahedron,
        CellKind::Hexahedron,
        CellKind::Pyramid,
    ];
    assert_eq!([0, 1, 2].map(|i| cells[i].0), kinds);
    let mut nodes = cells[1].1.clone();
    nodes.sort_unstable();
    assert_eq!(nodes, [1, 2, 4, 5, 7, 8, 10, 11]);
    assert_eq!(cells[2].1[4], 12, "the apex");
    // Boundary faces follow the cells, in their order and as they are.
    for (cell, face) in cells[3..].iter().zip(&small().faces[2..]) {
        let face: Vec<u32> = face.iter().map(|node| *node as u32).collect();
        assert_eq!(cell.1, face);
    }
    let tags: Vec<_> = mesh.boundary_tags().collect();
    assert_eq!(tags.len(), PATCHES.len());
    for (tag, (name, kind, faces)) in tags.iter().zip(PATCHES) {
        assert_eq!(tag.name, name);
        assert_eq!(tag.condition.as_deref().unwrap_or("patch"), kind);
        let expected: Vec<usize> = faces.map(|face| face + 1).collect();
        assert_eq!(tag.cells.iter().collect::<Vec<_>>(), expected);
    }
    let zone = mesh.zones().next().expect("a zone");
    assert_eq!(
        (zone.name.as_str(), zone.cells.iter().collect()),
        ("top", vec![1, 2])
    );
}

#[test]
fn every_way_to_store_the_lists_gives_the_same_mesh() {
    let expected = mesh(case_of(&small(), ASCII).path());
    let mut n = 0;
    for label in [4, 8] {
        for scalar in [4, 8] {
            for is_big_endian in [false, true] {
                for is_compact in [false, true] {
                    for arch in [
                        None,
                        Some("LSB;label=32;scalar=64"),
                        Some("LSB;label=64;scalar=32"),
                    ] {
                        let arch = if is_big_endian {
                            Some("MSB;label=64")
                        } else {
                            arch
                        };
                        let way = Way {
                            label,
                            scalar,
                            is_big_endian,
                            is_compact,
                            arch,
                            ..BINARY
                        };
                        assert_eq!(mesh(case_of(&small(), way).path()), expected, "{way:?}");
                        n += 1;
                    }
                }
            }
        }
    }
    assert_eq!(n, 48);
    for way in [
        Way {
            is_packed: true,
            ..ASCII
        },
        Way {
            is_packed: true,
            ..BINARY
        },
        Way {
            is_compact: true,
            ..ASCII
        },
    ] {
        assert_eq!(mesh(case_of(&small(), way).path()), expected, "{way:?}");
    }
}

#[test]
fn text_may_have_comments_and_lists_of_one_value() {
    let expected = mesh(case_of(&small(), ASCII).path());
    let case = case_of(&small(), ASCII);
    change(&case, "points", "(\n(0.0", "( /* ( 1 */ // )\n(\n0.0");
    change(&case, "points", "// **** //", "/* ) */ // ) ( 5");
    change(&case, "faces", "(\n4", "( // 3 ( 0 1 2 )\n4");
    change(&case, "owner", "0", "0 // 9 )\n");
    change(
        &case,
        "neighbour",
        "2\n(\n1\n2\n)",
        "15 (1 2 -1 -1 -1 -1 -1 -1 -1 -1 -1 -1 -1 -1 -1)",
    );
    change(&case, "cellZones", "List<label> 2\n(\n1\n2\n)", "2(1 2)");
    assert_eq!(mesh(case.path()), expected);
    // All cells in one zone.
    let case = case_of(
        &Small {
            zone: vec![2, 2],
            ..small()
        },
        ASCII,
    );
    change(&case, "cellZones", "2\n(\n2\n2\n)", "2{2}");
    let zone = mesh(case.path());
    assert_eq!(
        zone.zones()
            .next()
            .expect("a zone")
            .cells
            .iter()
            .collect::<Vec<_>>(),
        [2]
    );
    // An empty binary list has no brackets.
    let empty = mesh(
        case_of(
            &Small {
                zone: Vec::new(),
                ..small()
            },
            BINARY,
        )
        .path(),
    );
    assert!(
        empty
            .zones()
            .next()
            .is_some_and(|zone| zone.cells.is_empty())
    );
}

#[test]
fn a_case_is_a_sequence_of_the_times_at_which_its_mesh_is() {
    let case = case_of(&small(), ASCII);
    let moved = |by: f64| {
        let points = small()
            .points
            .iter()
            .map(|[x, y, z]| [x + by, *y, *z])
            .collect();
        Small { points, ..small() }
    };
    for (name, by) in [("0.5", 0.5), ("10", 10.0), ("2", 2.0)] {
        let files = BINARY.files(&moved(by));
        BINARY.write(&case.path().join(name).join("polyMesh"), &files[..1]);
    }
    // A time with fields alone has no mesh; folders whose names are not times are ignored.
    fs::create_dir_all(case.path().join("5")).expect("a folder");
    fs::create_dir_all(case.path().join("0.org/polyMesh")).expect("a folder");
    fs::write(case.path().join("5/U"), "x").expect("a file");
    let location = Location::open(case.path()).expect("it is there");
    let times = crate::formats::by_name("openfoam")
        .expect("a format")
        .steps(&location);
    assert_eq!(times.expect("times"), [0.0, 0.5, 2.0, 10.0]);
    let firsts: Vec<f64> = (0..4).map(|i| step(case.path(), i).points[0][0]).collect();
    assert_eq!(firsts, [0.0, 0.5, 2.0, 10.0]);
    assert_eq!(mesh(case.path()).points, moved(10.0).points);
    assert_eq!(
        mesh(&case.path().join("2/polyMesh")).points,
        moved(2.0).points
    );
    assert_eq!(
        mesh(&case.path().join("constant/polyMesh")).points,
        small().points
    );
    let notes = loaded(case.path()).expect("it is read").notes;
    assert!(notes.says("the fields of 1 time are not read"));
    fs::write(case.path().join("any.foam"), "").expect("a file");
    assert_eq!(mesh(&case.path().join("any.foam")), mesh(case.path()));
    // A mesh with other cells at a time: its own files count from then on.
    let mut other = moved(3.0);
    other.zone = Vec::new();
    BINARY.write(&case.path().join("3/polyMesh"), &BINARY.files(&other));
    let zone = |i: usize| {
        step(case.path(), i)
            .zones()
            .next()
            .map(|zone| zone.cells.len())
    };
    assert_eq!(
        [0, 1, 2, 3, 4].map(zone),
        [Some(2), Some(2), Some(2), Some(0), Some(0)]
    );
}

#[test]
fn a_region_is_chosen_by_its_path() {
    let case = tempfile::tempdir().expect("a folder");
    for (region, z) in [("fluid", 0.0), ("solid", 5.0)] {
        let points = small()
            .points
            .iter()
            .map(|[x, y, h]| [*x, *y, h + z])
            .collect();
        let mesh = Small { points, ..small() };
        BINARY.write(
            &case.path().join("constant").join(region).join("polyMesh"),
            &BINARY.files(&mesh),
        );
        BINARY.write(
            &case.path().join("1").join(region).join("polyMesh"),
            &BINARY.files(&small())[..1],
        );
    }
    let error = refused(case.path());
    assert_eq!(
        error,
        "CASE: the case has no mesh of its own but regions; give one of constant/fluid, constant/solid"
    );
    let z = |path: &str| mesh(&case.path().join(path)).points[0][2];
    assert_eq!(z("constant/solid/polyMesh"), 5.0);
    assert_eq!(z("constant/solid"), 0.0, "the latest time");
    assert_eq!(
        step(&case.path().join("constant/solid"), 0).points[0][2],
        5.0
    );
    fs::write(case.path().join("x{solid}.foam"), "").expect("a file");
    assert_eq!(
        step(&case.path().join("x{solid}.foam"), 0).points[0][2],
        5.0
    );
}

#[test]
fn two_faces_at_one_place_stay_two() {
    // A wall without thickness: both cells have it on their boundary.
    let mut baffle = small();
    let face = baffle.faces.remove(0);
    baffle.owner.remove(0);
    baffle.neighbour = vec![2];
    baffle.faces.extend([
        face.clone(),
        [
            &face[..1],
            &face.iter().skip(1).rev().copied().collect::<Vec<_>>()[..],
        ]
        .concat(),
    ]);
    baffle.owner.extend([0, 1]);
    for patch in &mut baffle.patches {
        patch.2 -= 1;
    }
    baffle
        .patches
        .push(("one side".to_owned(), "type wall;".to_owned(), 14, 1));
    baffle
        .patches
        .push(("other side".to_owned(), "type wall;".to_owned(), 15, 1));
    for patch in &mut baffle.patches {
        patch.0 = format!("\"{}\"", patch.0);
    }
    let found = mesh(case_of(&baffle, ASCII).path());
    assert_eq!(found.cells.len(), 3 + 15);
    let n = |name: &str| {
        found
            .boundary_tags()
            .find(|tag| tag.name == name)
            .map(|tag| tag.cells.len())
    };
    assert_eq!([n("one side"), n("other side")], [Some(1), Some(1)]);
    let topology = found.origin.get::<Topology>().expect("it is left");
    assert!(topology.has_cells_of(&found.view()));
}

#[test]
fn the_files_are_left_for_the_writer_as_they_are() {
    let case = case_of(
        &small(),
        Way {
            is_packed: true,
            ..ASCII
        },
    );
    let mut found = mesh(case.path());
    let topology = found.origin.get::<Topology>().expect("it is left");
    let names: Vec<&str> = topology
        .files
        .iter()
        .map(|file| file.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "faces.gz",
            "owner.gz",
            "neighbour.gz",
            "boundary.gz",
            "cellZones.gz"
        ]
    );
    for file in &topology.files {
        let path = case.path().join("constant/polyMesh").join(&file.name);
        assert_eq!(file.stored.bytes(), fs::read(path).expect("a file"));
    }
    assert_eq!(topology.patches[1].entry("type"), Some("symmetryPlane"));
    assert!(topology.has_cells_of(&found.view()) && topology.has_groups_of(&found.view()));
    found.groups[0].name = "wall".to_owned();
    let topology = found.origin.get::<Topology>().expect("it is left");
    assert!(topology.has_cells_of(&found.view()) && !topology.has_groups_of(&found.view()));
}

#[test]
fn a_tag_between_two_cells_is_written_as_a_zone_of_faces_and_not_as_a_patch() {
    let mut mesh = Mesh::of_points(vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
    ]);
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
    for face in [[2, 1, 3], [0, 2, 1], [1, 3, 2]] {
        mesh.cells.push(CellKind::Triangle, &face);
    }
    for (name, faces) in [("disk", vec![2]), ("low", vec![3]), ("none", vec![])] {
        mesh.add_tag(name, faces).expect("they are faces");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.foam");
    let options = crate::WriteOptions {
        encoding: crate::Encoding::Ascii,
        ..Default::default()
    };
    let notes = mesh
        .view()
        .write_with(&path, &options)
        .expect("it is written");
    assert!(
        notes.has("face_zone") && !notes.has("not_outside"),
        "{notes:?}"
    );
    let tags = self::mesh(&path);
    let tags: Vec<_> = tags
        .boundary_tags()
        .map(|tag| (&*tag.name, tag.cells.len()))
        .collect();
    assert_eq!(tags, [("low", 1), ("none", 0), ("defaultFaces", 5)]);
    let zones =
        fs::read_to_string(folder.path().join("constant/polyMesh/faceZones")).expect("a file");
    assert_says(&zones, "disk");
    // The one inner face is the first.
    let compact: String = zones.split_whitespace().collect();
    assert_says(&compact, "faceLabelsList<label>1(0);");
    assert_says(&compact, "flipMapList<bool>1(1);");
}
