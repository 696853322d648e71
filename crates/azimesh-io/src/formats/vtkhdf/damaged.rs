//! Files whose parts do not fit.

use super::*;
use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Tree};
use crate::formats::notes::too_long;
use crate::formats::{Notes, ReadOptions, parse};
use crate::mesh::Mesh;
use crate::testing::assert_says;
use std::path::Path;

/// A file of two steps of one vertex each, with these offsets of points and this shape of
/// `Connectivity`.
fn two_vertices(point_offsets: &[i64], connectivity: &[u64]) -> Result<Mesh> {
    let mut tree = Tree::new();
    let root = tree.group(Tree::ROOT, ROOT);
    tree.text_attribute(root, "Type", "UnstructuredGrid");
    tree.number_attribute(root, "Version", &[2_i64, 0], false);
    for name in ["NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"] {
        tree.numbers(root, name, &[1_i64, 1]);
    }
    let points = Data::owned(&[0.0_f64, 0.0, 0.0, 1.0, 1.0, 1.0]);
    tree.dataset(root, "Points", Element::Float64, &[2, 3], points);
    let nodes = vec![0_u8; 8 * connectivity.iter().product::<u64>() as usize];
    let nodes = Data::owned(&nodes);
    tree.dataset(root, "Connectivity", Element::Int64, connectivity, nodes);
    tree.numbers(root, "Offsets", &[0_i64, 1, 0, 1]);
    tree.numbers(root, "Types", &[1_u8, 1]);
    let steps = tree.group(root, "Steps");
    tree.numbers(steps, "Values", &[0.0_f64, 1.0]);
    tree.numbers(steps, "PartOffsets", &[0_i64, 1]);
    tree.numbers(steps, "PointOffsets", point_offsets);
    for name in ["CellOffsets", "ConnectivityIdOffsets"] {
        tree.numbers(steps, name, &[0_i64, 1]);
    }
    let mut bytes = Vec::new();
    tree.write(&mut bytes).expect("it can be written");
    parse(&VTKHDF, &bytes, &ReadOptions::default())
}

#[test]
fn less_offsets_than_steps_are_refused() {
    let mesh = two_vertices(&[0, 1], &[2]).expect("a good file");
    assert_eq!(mesh.points, [[1.0; 3]]);
    let error = two_vertices(&[0], &[2]).expect_err("one offset for two steps");
    let error = error.to_string();
    assert_says(&error, "PointOffsets");
    assert_says(&error, "1 value for 2 steps");
}

#[test]
fn indices_of_several_columns_are_refused_without_a_panic() {
    for shape in [[2, 2], [2, 0]] {
        let error = two_vertices(&[0, 1], &shape).expect_err("two columns");
        let error = error.to_string();
        assert_says(&error, "Connectivity");
        assert!(error.contains("values; they must have 1"), "{error}");
    }
}

/// A file of a mesh of two vertices with an array of so many values at nodes, at cells, and so many
/// points as it says.
fn with_arrays(point: usize, cell: usize, n_points: i64) -> Result<(Mesh, Notes)> {
    let mut tree = Tree::new();
    let root = tree.group(Tree::ROOT, ROOT);
    tree.text_attribute(root, "Type", "UnstructuredGrid");
    tree.number_attribute(root, "Version", &[2_i64, 0], false);
    tree.numbers(root, "NumberOfPoints", &[n_points]);
    for name in ["NumberOfCells", "NumberOfConnectivityIds"] {
        tree.numbers(root, name, &[2_i64]);
    }
    let points = Data::owned(&[0.0_f64, 0.0, 0.0, 1.0, 1.0, 1.0]);
    tree.dataset(root, "Points", Element::Float64, &[2, 3], points);
    tree.numbers(root, "Connectivity", &[0_i64, 1]);
    tree.numbers(root, "Offsets", &[0_i64, 1, 2]);
    tree.numbers(root, "Types", &[1_u8, 1]);
    for (group, name, n) in [("PointData", "p", point), ("CellData", "c", cell)] {
        let group = tree.group(root, group);
        tree.numbers(group, name, &vec![0.5_f64; n]);
    }
    let mut bytes = Vec::new();
    tree.write(&mut bytes).expect("it can be written");
    let source = Source::from_bytes(Path::new("x"), bytes);
    let mut notes = Notes::default();
    let mesh = VTKHDF.read_file(&source, &ReadOptions::default(), &mut notes)?;
    Ok((mesh, notes))
}

#[test]
fn a_long_array_is_left_out_with_a_note_and_a_short_one_refused() {
    let (mesh, notes) = with_arrays(2, 2, 2).expect("a good file");
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!((mesh.point_arrays.len(), mesh.cell_arrays.len()), (1, 1));
    let (mesh, notes) = with_arrays(3, 4, 2).expect("arrays that can be left out");
    assert_eq!((mesh.point_arrays.len(), mesh.cell_arrays.len()), (0, 0));
    for (what, name) in [("point", "p"), ("cell", "c")] {
        let mut notes = notes.iter();
        assert!(notes.any(|note| *note == too_long(what, name)), "{notes:?}");
    }
    for ((point, cell, n_points), refusal) in [
        (
            (1, 2, 2),
            "PointData/p: it has 1 row; it must have 2, one for each point",
        ),
        (
            (2, 1, 2),
            "CellData/c: it has 1 row; it must have 2, one for each cell",
        ),
        (
            (2, 2, 3),
            "Points: it has 2 rows, but NumberOfPoints asks for 3",
        ),
    ] {
        let error = with_arrays(point, cell, n_points).err();
        let error = error.expect("something is missing").to_string();
        assert_says(&error, refusal);
    }
}
