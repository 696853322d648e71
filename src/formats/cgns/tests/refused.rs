//! What is refused, and damaged files.

use super::*;

#[test]
fn adf_files_are_refused_with_the_tool_that_converts_them() {
    let mut bytes = b"\xc0\xa8\xa3\xa9ADF Database Version A02011>".to_vec();
    bytes.resize(4096, 0);
    assert!(Cgns.recognizes_start(&bytes));
    assert!(refused(&bytes).to_string().contains("adf2hdf"));
}

#[test]
fn a_link_to_a_missing_file_is_named() {
    let bytes = std::fs::read(path("linked_families.cgns")).expect("the file is there");
    let message = refused(&bytes).to_string();
    assert!(
        message.contains("linked_grid.cgns") && message.contains("/Base/Zone/"),
        "{message}"
    );
}

/// Replaces the last place where these numbers stand, in four bytes each: values follow headers.
fn patched(mut bytes: Vec<u8>, from: &[i32], to: &[i32]) -> Vec<u8> {
    let from: &[u8] = bytemuck::cast_slice(from);
    let at = memchr::memmem::rfind(&bytes, from).expect("it is there");
    bytes[at..at + from.len()].copy_from_slice(bytemuck::cast_slice(to));
    bytes
}

#[test]
fn wrong_numbers_are_told_with_their_place() {
    let mut mesh = Mesh {
        points: vec![[0.0; 3]; 7],
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Pyramid, &[4, 3, 2, 1, 0]);
    let (good, _) = written(&mesh);
    let node = patched(good.clone(), &[5, 4, 3, 2, 1], &[5, 4, 3, 2, 8]);
    let message = refused(&node).to_string();
    let expected =
        "/Base/Zone/PYRA_5/ElementConnectivity: it has node 8; the zone has nodes 1 to 7";
    assert!(message.contains(expected), "{message}");
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
    assert!(
        message.contains("the zone has 2000000000 nodes"),
        "{message}"
    );
}

#[test]
fn damaged_files_give_an_error_or_a_mesh() {
    let mut state = 7_u64;
    let mut random = move |n: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % n
    };
    let names = [
        "polyhedra_offsets.cgns",
        "structured_rind.cgns",
        "sequence.cgns",
    ];
    let files = names.map(|name| std::fs::read(path(name)).expect("the file is there"));
    let (own, _) = written(&rich_mesh());
    for good in files.iter().chain([&own]) {
        for _ in 0..120 {
            let mut bytes = good.clone();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                bytes[at] = match random(3) {
                    0 => 0xff,
                    1 => 0,
                    _ => bytes[at] ^ (1 << random(8)),
                };
            }
            let _ = parse(&Cgns, &bytes, &ReadOptions::default()).map(|mesh| mesh.validate());
            bytes.truncate(random(bytes.len()));
            let _ = parse(&Cgns, &bytes, &ReadOptions::default()).map(|mesh| mesh.validate());
        }
    }
}
