//! Damaged MSH files: always an error with a place or a mesh, never a panic, a hang or a huge
//! allocation.

use azimesh::formats::{Encoding, Format, ReadOptions, WriteOptions, gmsh, parse};
use azimesh::mesh::{CellKind, DataArray, Group, Mesh, Values};
use proptest::prelude::*;

fn small_mesh() -> Mesh {
    let mut mesh = Mesh {
        points: (0..12)
            .map(|i| [f64::from(i), f64::from(i * i), 0.5])
            .collect(),
        ..Mesh::default()
    };
    let second_order = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
    mesh.cells.push(CellKind::Tetrahedron10, &second_order);
    mesh.cells.push(CellKind::Tetrahedron, &[2, 3, 10, 11]);
    mesh.cells.push(CellKind::Triangle, &[2, 3, 10]);
    mesh.cells.push(CellKind::Triangle, &[3, 10, 11]);
    for (dimension, name, cells) in [(2, "upper wall", 2..4), (3, "air", 0..2), (2, "hub", 3..4)] {
        mesh.groups.push(Group {
            dimension,
            name: name.into(),
            number: None,
            condition: None,
            cells: cells.collect(),
        });
    }
    let values = Values::F64((0..24).map(f64::from).collect());
    let velocity = DataArray::tuples("velocity", 2, values);
    mesh.point_arrays.push(velocity);
    let numbers = Values::I64(vec![7, 3, 4, 9]);
    mesh.cell_arrays
        .push(DataArray::scalar("cell_number", numbers));
    mesh.cell_arrays
        .push(DataArray::scalar("q", Values::F32(vec![0.5; 4])));
    mesh
}

/// The small mesh in both versions, as text and binary.
fn flavours() -> Vec<Vec<u8>> {
    let formats: [&dyn Format; 2] = [&gmsh::MSH41, &gmsh::MSH22];
    let mut files = Vec::new();
    for format in formats {
        for encoding in [Encoding::Raw, Encoding::Ascii] {
            let options = WriteOptions {
                encoding,
                ..WriteOptions::default()
            };
            let mut file = Vec::new();
            format
                .write_file(&small_mesh().view(), &mut file, &options)
                .expect("MSH holds this mesh");
            files.push(file);
        }
    }
    files
}

fn read(bytes: &[u8]) -> azimesh::error::Result<Mesh> {
    parse(&gmsh::MSH41, bytes, &ReadOptions::default())
}

/// Reads; an error must say where.
fn read_or_place(bytes: &[u8]) {
    if let Err(error) = read(bytes) {
        assert!(error.position.is_some(), "no place: {error}");
        assert!(!error.message.is_empty());
    }
}

#[test]
fn good_files_of_each_flavour_are_read() {
    for file in flavours() {
        assert_eq!(read(&file).expect("a good file").points.len(), 12);
    }
}

#[test]
fn every_truncation_is_an_error_with_a_place_or_a_mesh() {
    for file in flavours() {
        for length in 0..file.len() {
            read_or_place(&file[..length]);
        }
    }
}

#[test]
fn promised_billions_are_not_allocated() {
    for start in [
        "4.1 0 8\n$EndMeshFormat\n$Nodes\n1 99999999999 1 1\n2 1 0",
        "2.2 0 8\n$EndMeshFormat\n$Nodes\n",
        "4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0",
        "2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n",
        "2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n",
    ] {
        let file = format!("$MeshFormat\n{start} 99999999999\n1 0 0 0\n");
        let error = read(file.as_bytes()).expect_err("the file is short");
        assert!(error.position.is_some(), "{error}");
    }
}

#[test]
fn a_wrong_line_is_named_with_what_would_be_right() {
    let file = "$MeshFormat\r\n2.2 0 8\r\n$EndMeshFormat\r\n$Nodes\r\n3\r\n1 0 0 0\r\n2 1 0 0\r\n\
                3 0 1 0\r\n$EndNodes\r\n$Elements\r\n1\r\n1 2 2 1 1 1 2\r\n$EndElements\r\n";
    let error = read(file.as_bytes()).expect_err("two nodes are too few");
    assert_eq!(
        error.to_string(),
        "line 12: a triangle needs 3 nodes, found 2"
    );
    let error = read(file.replace("1 1 1 2\r", "1 1 1 2 7\r").as_bytes());
    assert_eq!(
        error.expect_err("there is no node 7").to_string(),
        "line 12: a triangle has node 7, which is not in $Nodes"
    );
}

#[test]
fn other_versions_are_refused_in_a_sentence() {
    for version in ["0", "4.2", "5"] {
        let file = format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n");
        let error = read(file.as_bytes()).expect_err("not read");
        assert!(error.to_string().contains("versions 1 to 4.1"), "{error}");
    }
}

proptest! {
    #[test]
    fn random_bytes_are_no_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        read_or_place(&bytes);
        for head in [
            "$MeshFormat\n4.1 1 8\n\u{1}\0\0\0\n$EndMeshFormat\n$Nodes\n",
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n",
        ] {
            read_or_place(&[head.as_bytes(), &bytes].concat());
        }
    }

    #[test]
    fn flipped_bytes_are_no_panic(
        flavour in 0usize..4,
        flips in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut file = flavours().swap_remove(flavour);
        for (at, byte) in flips {
            let at = at.index(file.len());
            file[at] = byte;
        }
        read_or_place(&file);
    }
}
