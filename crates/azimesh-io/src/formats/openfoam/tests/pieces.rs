//! The small mesh in two pieces, and pieces that do not fit.

use super::super::fixtures::{ASCII, BINARY, Way, small};
use super::super::topology::Topology;
use super::{case_of, loaded, mesh, refused};
use crate::formats::{ReadOptions, read, step_in_case};
use crate::mesh::Mesh;
use crate::testing::assert_says;
use std::fs;
use tempfile::TempDir;

/// Writes the mesh in two pieces, with their numbers in the whole or without.
fn decomposed(way: Way, is_collated: bool, has_numbers: bool) -> TempDir {
    let case = tempfile::tempdir().expect("a folder");
    let mut blocks: Vec<Vec<(&str, Vec<u8>)>> = Vec::new();
    for (number, cells) in [&[0][..], &[1, 2]].into_iter().enumerate() {
        let (piece, numbers) = small().piece(cells, number, 1 - number);
        let mut files = way.files(&piece);
        let names = [
            "pointProcAddressing",
            "faceProcAddressing",
            "cellProcAddressing",
        ];
        for (name, numbers) in names.into_iter().zip(numbers).filter(|_| has_numbers) {
            files.push((
                name,
                [way.header("labelList").into_bytes(), way.labels(&numbers)].concat(),
            ));
        }
        let folder = case
            .path()
            .join(format!("processor{number}/constant/polyMesh"));
        if !is_collated {
            way.write(&folder, &files);
        }
        blocks.push(files);
    }
    if is_collated {
        let [first, second] = <[_; 2]>::try_from(blocks).expect("two pieces");
        let files: Vec<(&str, Vec<u8>)> = first
            .into_iter()
            .zip(second)
            .map(|((name, one), (_, two))| {
                let start =
                    memchr::memmem::find(&two, b"// * * //\n").expect("the end of the header") + 10;
                let mut file = way.header("decomposedBlockData").into_bytes();
                // Blocks after the first have no header.
                for (i, block) in [&one[..], &two[start..]].into_iter().enumerate() {
                    file.extend(format!("// Processor{i}\n{}\n(", block.len()).bytes());
                    file.extend(block);
                    file.extend(b")\n");
                }
                (name, file)
            })
            .collect();
        way.write(&case.path().join("processors2/constant/polyMesh"), &files);
    }
    case
}

#[test]
fn pieces_with_their_numbers_are_joined_to_the_mesh_that_was_decomposed() {
    let expected = mesh(case_of(&small(), ASCII).path());
    for way in [
        ASCII,
        BINARY,
        Way {
            label: 8,
            arch: None,
            ..BINARY
        },
        Way {
            is_packed: true,
            ..ASCII
        },
    ] {
        for is_collated in [false, true] {
            let case = decomposed(way, is_collated, true);
            let found = loaded(case.path()).expect("it is read");
            assert_eq!(found.mesh, expected, "{way:?} {is_collated}");
            let joined = "the mesh is joined from 2 pieces by the numbers of the whole";
            assert!(found.notes.says(joined), "{:?}", found.notes);
            let topology = found.mesh.origin.get::<Topology>().expect("it is left");
            assert!(topology.files.is_empty() && topology.has_cells_of(&found.mesh.view()));
        }
    }
    let collated = decomposed(BINARY, true, true);
    assert_eq!(mesh(&collated.path().join("processors2")), expected);
}

#[test]
fn pieces_without_numbers_are_joined_at_the_faces_that_they_share() {
    let expected = mesh(case_of(&small(), ASCII).path());
    for is_collated in [false, true] {
        let joined = mesh(decomposed(BINARY, is_collated, false).path());
        assert_eq!(joined.points.len(), expected.points.len());
        let cells = |mesh: &Mesh| {
            let places = mesh.cells.iter().map(|cell| {
                let at = cell
                    .nodes
                    .iter()
                    .map(|node| mesh.points[*node as usize].map(f64::to_bits));
                let mut at: Vec<_> = at.collect();
                at.sort_unstable();
                (cell.kind, at)
            });
            let mut places: Vec<_> = places.collect();
            places.sort();
            places
        };
        assert_eq!(cells(&joined), cells(&expected));
        let tags = |mesh: &Mesh| -> Vec<_> {
            let tags = mesh.boundary_tags();
            tags.map(|tag| (tag.name.clone(), tag.condition.clone(), tag.cells.len()))
                .collect()
        };
        assert_eq!(tags(&joined), tags(&expected));
        assert_eq!(joined.zones().next().map(|zone| zone.cells.len()), Some(2));
    }
}

#[test]
fn pieces_that_do_not_fit_are_refused() {
    let case = decomposed(ASCII, false, false);
    fs::remove_dir_all(case.path().join("processor1")).expect("it was there");
    let error = refused(case.path());
    assert!(
        error.ends_with("patch \"procBoundary0to1\" is shared with piece 1, which is not there"),
        "{error}"
    );
    let case = decomposed(ASCII, false, true);
    fs::remove_dir_all(case.path().join("processor0")).expect("it was there");
    assert_eq!(
        refused(case.path()),
        "CASE: the case is decomposed, but piece 0 is missing"
    );
    let case = decomposed(ASCII, false, true);
    let path = case
        .path()
        .join("processor1/constant/polyMesh/cellProcAddressing");
    let text = fs::read_to_string(&path).expect("a file");
    fs::write(&path, text.replace("\n2\n)", "\n7\n)")).expect("it is written");
    let error = refused(case.path());
    assert_says(
        &error,
        "a cell has number 7 in the whole, but all pieces have only 3 cells together",
    );
}

#[test]
fn a_collated_file_without_blocks_is_refused() {
    let case = decomposed(BINARY, true, true);
    let path = case.path().join("processors2/constant/polyMesh/points");
    fs::write(&path, BINARY.header("decomposedBlockData")).expect("it is written");
    let error = refused(case.path());
    assert!(
        error.ends_with("the file has no block of any piece: it is cut off or damaged"),
        "{error}"
    );
}

#[test]
fn a_region_that_only_the_pieces_have_is_read_as_a_whole() {
    let expected = mesh(case_of(&small(), ASCII).path());
    for is_collated in [false, true] {
        let case = decomposed(BINARY, is_collated, true);
        let folders = if is_collated {
            vec!["processors2"]
        } else {
            vec!["processor0", "processor1"]
        };
        for folder in &folders {
            let constant = case.path().join(folder).join("constant");
            fs::create_dir(constant.join("solid")).expect("a folder");
            fs::rename(constant.join("polyMesh"), constant.join("solid/polyMesh"))
                .expect("it is there");
        }
        assert_eq!(
            refused(case.path()),
            "CASE: the case has no mesh of its own but regions; give one of constant/solid"
        );
        let region = case.path().join("constant/solid");
        fs::create_dir_all(&region).expect("a folder");
        assert_eq!(mesh(&region), expected);
        let points = case.path().join(folders[folders.len() - 1]);
        let points = points.join("constant/solid/polyMesh/points");
        let (location, step) = step_in_case(&points).expect("it is one of a step");
        let found = read(&location, &ReadOptions::default()).expect("it is read");
        assert_eq!((found.mesh, step), (expected.clone(), 0));
    }
}
