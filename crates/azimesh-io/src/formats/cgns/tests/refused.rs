//! Refused files.

use super::*;
use crate::testing::assert_says;

#[test]
fn a_link_to_a_missing_file_is_named() {
    let bytes = std::fs::read(path("linked_families.cgns")).expect("the file is there");
    let message = refused(&bytes).to_string();
    assert!(
        message.contains("linked_grid.cgns") && message.contains("/Base/Zone/"),
        "{message}"
    );
}

#[test]
fn files_that_link_to_themselves_end() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let itself = folder.path().join("linked_grid.cgns");
    std::fs::copy(path("linked_families.cgns"), &itself).expect("it is copied");
    let source = Source::open(&itself).expect("it is there");
    let read = CGNS.read_file(&source, &ReadOptions::default(), &mut Notes::default());
    let message = read.expect_err("it has no coordinates").to_string();
    assert_says(&message, "/Base/Zone/GridCoordinates");
}

/// Replaces the last occurrence of these numbers, in four bytes each: values follow headers.
fn patched(mut bytes: Vec<u8>, from: &[i32], to: &[i32]) -> Vec<u8> {
    let from: &[u8] = bytemuck::cast_slice(from);
    let at = memchr::memmem::rfind(&bytes, from).expect("it is there");
    bytes[at..at + from.len()].copy_from_slice(bytemuck::cast_slice(to));
    bytes
}

#[test]
fn wrong_numbers_are_told_with_their_place() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3]; 7]);
    mesh.cells.push(CellKind::Pyramid, &[4, 3, 2, 1, 0]);
    let (good, _) = written(&mesh);
    let node = patched(good.clone(), &[5, 4, 3, 2, 1], &[5, 4, 3, 2, 8]);
    let message = refused(&node).to_string();
    let expected =
        "/Base/Zone/PYRA_5/ElementConnectivity: it has node 8; the zone has nodes 1 to 7";
    assert_says(&message, expected);
    let range = patched(good.clone(), &[12, 0], &[17, 0]);
    let message = refused(&range).to_string();
    assert!(
        message.contains("5 entries; it must have 8 for 1 element of type HEXA_8"),
        "{message}"
    );
    let unknown = patched(good.clone(), &[12, 0], &[99, 0]);
    assert!(
        refused(&unknown).to_string().contains("type 99"),
        "an element type of the future"
    );
    let size = patched(good, &[7, 1, 0], &[2_000_000_000, 1, 0]);
    let message = refused(&size).to_string();
    assert_says(&message, "the zone has 2000000000 nodes");
}

#[test]
fn cells_in_space_without_a_third_coordinate_are_refused() {
    let mut mesh = Mesh::of_points(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    let (plane, _) = written(&mesh);
    assert_eq!(
        parse(&CGNS, &plane, &ReadOptions::default())
            .expect("it is good")
            .points,
        mesh.points
    );
    // Dimensions of cells and of space.
    let message = refused(&patched(plane, &[2, 2], &[3, 3])).to_string();
    let expected = "it has no CoordinateZ; cells of dimension 3 need 3 coordinates";
    assert_says(&message, expected);
}
