//! Written files are read back; files of VTK's writer and h5py are read unchanged. That VTK
//! reads what we write is checked in scripts/verify/vtkhdf.py.

mod sequence;

use super::*;
use crate::formats::{Notes, ReadOptions, WriteOptions, parse};
use crate::mesh::{CellKind, DataArray, Group, Mesh, Values};
use crate::testing::assert_says;
use std::path::Path;

pub(super) fn mesh() -> Mesh {
    let mut mesh = Mesh::of_points(
        (0..14)
            .map(|i| [f64::from(i % 3), f64::from(i) / 3.0, -0.1])
            .collect(),
    );
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh.cells
        .push(CellKind::Hexahedron, &[2, 3, 4, 5, 6, 7, 8, 9]);
    let stream = [
        4, 3, 10, 11, 12, 3, 10, 11, 13, 3, 11, 12, 13, 3, 10, 12, 13,
    ];
    mesh.cells.push_polyhedron(&stream).expect("a good stream");
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    mesh.cells.push(CellKind::Polygon, &[2, 3, 4, 5, 6]);
    let group = |dimension, name: &str, number, cells: &[usize]| {
        Group::new(
            dimension,
            name,
            Some(number),
            cells.iter().copied().collect(),
        )
    };
    mesh.groups = vec![
        group(2, "wall ä", 1, &[3, 4]),
        group(2, "unused", 2, &[]),
        group(3, "rotor", 1, &[0, 1, 2]),
    ];
    let numbers = |n: i32| (0..n).map(|i| f64::from(i) / 7.0).collect();
    mesh.point_arrays = vec![
        DataArray::tuples("velocity", 3, Values::F64(numbers(42))),
        DataArray::scalar("u8", Values::U8((0..14).collect())),
    ];
    mesh.cell_arrays = vec![DataArray::scalar(
        "quality",
        Values::F32(vec![0.5, f32::NAN, 1.0, -0.0, 3.5]),
    )];
    mesh.field_arrays = vec![
        DataArray::tuples("rate", 2, Values::I64(vec![1, 2, 3, 4])),
        DataArray::scalar("name", text(["a", "", "ö", "d", "e"])),
    ];
    mesh
}

fn text<const N: usize>(words: [&str; N]) -> Values {
    Values::Text(words.map(String::from).to_vec())
}

pub(super) fn written(mesh: &Mesh, options: &WriteOptions) -> (Vec<u8>, Notes) {
    let mut bytes = Vec::new();
    let notes = VTKHDF
        .write_file(&mesh.view(), &mut bytes, options)
        .expect("it can be written");
    (bytes, notes)
}

fn file(name: &str) -> Source {
    Source::open(&Path::new("testdata").join(name)).expect("it is in testdata")
}

fn read(source: &Source, step: Option<usize>) -> Mesh {
    let options = ReadOptions {
        step,
        ..ReadOptions::default()
    };
    let mesh = VTKHDF.read_file(source, &options, &mut Notes::default());
    mesh.expect("it can be read")
}

/// The bits of NaN are compared too.
fn assert_same(found: &Mesh, wanted: &Mesh) {
    assert_eq!(format!("{found:?}"), format!("{wanted:?}"));
}

#[test]
fn a_mesh_comes_back_with_everything() {
    let (bytes, notes) = written(&mesh(), &WriteOptions::default());
    assert!(notes.is_empty(), "{notes:?}");
    let source = Source::from_bytes(Path::new("x"), bytes);
    assert!((VTKHDF.detect)(&source));
    assert_same(&read(&source, None), &mesh());
    assert!((VTKHDF.steps)(&source).expect("it can be asked").is_empty());
}

#[test]
fn an_empty_mesh_and_nodes_without_cells_come_back() {
    let nodes = Mesh::of_points(vec![[1.0, 2.0, 3.0]]);
    for mesh in [Mesh::default(), nodes] {
        let (bytes, _) = written(&mesh, &WriteOptions::default());
        let found = parse(&VTKHDF, &bytes, &ReadOptions::default()).expect("it can be read");
        assert_same(&found, &mesh);
    }
}

#[test]
fn a_face_in_two_tags_is_written_once_for_each() {
    let mut twice = mesh();
    twice.groups[1].cells = [4].into_iter().collect();
    let (bytes, _) = written(&twice, &WriteOptions::default());
    let found = parse(&VTKHDF, &bytes, &ReadOptions::default()).expect("it can be read");
    assert_eq!(found.cells.len(), 6);
    assert_eq!(found.cells.get(5).nodes, [2, 3, 4, 5, 6]);
    let faces: Vec<usize> = found.groups.iter().map(|group| group.cells.len()).collect();
    assert_eq!(faces, [2, 1, 3]);
}

#[test]
fn coordinates_of_32_bits_are_the_nearest() {
    let options = WriteOptions {
        precision: Precision::F32,
        ..WriteOptions::default()
    };
    let (bytes, _) = written(&mesh(), &options);
    let found = parse(&VTKHDF, &bytes, &ReadOptions::default()).expect("it can be read");
    let nearest = |point: &[f64; 3]| point.map(|x| f64::from(x as f32));
    assert_eq!(
        found.points,
        mesh().points.iter().map(nearest).collect::<Vec<_>>()
    );
}

#[test]
fn text_at_nodes_and_cells_which_vtk_cannot_read_is_left_out() {
    let mut named = mesh();
    let cells = DataArray::scalar("cell name", text(["a", "", "ö", "d", "e"]));
    named.cell_arrays.insert(0, cells);
    named
        .point_arrays
        .push(DataArray::scalar("node name", text(["n"; 14])));
    let (bytes, notes) = written(&named, &WriteOptions::default());
    for name in ["node name", "cell name"] {
        let text = format!("the array \"{name}\" is left out: VTK reads no text at nodes or cells");
        assert!(notes.says(&text), "{notes:?}");
    }
    let found = parse(&VTKHDF, &bytes, &ReadOptions::default()).expect("it can be read");
    assert_same(&found, &mesh());
}

#[test]
fn names_that_hdf5_does_not_allow_are_changed_and_told() {
    let mut odd = mesh();
    odd.point_arrays[0].name = "p/p0".into();
    odd.point_arrays[1].name = "p_p0".into();
    let (bytes, notes) = written(&odd, &WriteOptions::default());
    let renamed = "array \"p/p0\" is written as \"p_p0_2\": names in HDF5 have no slash, and that name is taken";
    assert!(notes.says(renamed), "{notes:?}");
    let found = parse(&VTKHDF, &bytes, &ReadOptions::default()).expect("it can be read");
    odd.point_arrays[0].name = "p_p0_2".into();
    assert_same(&found, &odd);
}

#[test]
fn files_of_vtk_are_read_as_the_same_mesh_in_vtu() {
    for (name, twin) in [
        ("mixed_cells_by_vtk", "mixed_cells_inline"),
        ("polyhedra_by_vtk", "polyhedra_ascii"),
    ] {
        let wanted = file(&format!("{twin}.vtu"));
        let wanted = crate::formats::read(&wanted.into(), &ReadOptions::default())
            .expect("it is read")
            .mesh;
        let found = file(&format!("{name}.vtkhdf"));
        let found = crate::formats::read(&found.into(), &ReadOptions::default())
            .expect("it is read")
            .mesh;
        assert_same(&found, &wanted);
    }
}

#[test]
fn the_steps_of_vtk_are_read_one_by_one() {
    let source = file("moving_by_vtk.vtkhdf");
    assert_eq!(
        (VTKHDF.steps)(&source).expect("it has steps"),
        [0.0, 0.5, 1.0]
    );
    let first = read(&source, Some(0));
    assert!(first.cells.has_polyhedra() && first.groups.iter().any(|g| !g.cells.is_empty()));
    for step in 0..3 {
        let found = read(&source, Some(step));
        assert_eq!((&found.cells, &found.groups), (&first.cells, &first.groups));
        let moved = |x: &[f64; 3]| [x[0], x[1] + step as f64 / 2.0, x[2]];
        assert_eq!(
            found.points,
            first.points.iter().map(moved).collect::<Vec<_>>()
        );
        let x = first
            .points
            .iter()
            .map(|point| point[0] + step as f64)
            .collect();
        assert_eq!(found.point_arrays, [DataArray::scalar("x", Values::F64(x))]);
    }
    assert_same(&read(&source, None), &read(&source, Some(2)));
    let options = ReadOptions {
        step: Some(3),
        ..ReadOptions::default()
    };
    let error = VTKHDF
        .read_file(&source, &options, &mut Notes::default())
        .expect_err("there are three");
    assert_eq!(
        error.to_string(),
        " Steps: there is no step 3: the file has steps 0 to 2"
    );
}

#[test]
fn packed_parts_in_the_other_byte_order_are_joined_at_every_step() {
    let source = file("moving_parts_by_h5py.vtkhdf");
    let one = read(&file("mixed_cells_by_vtk.vtkhdf"), None);
    let (n, n_cells) = (one.points.len(), one.cells.len());
    for step in 0..3 {
        let found = read(&source, Some(step));
        let moved = |x: &[f64; 3]| [x[0], x[1] + step as f64 / 2.0, x[2]];
        let twice = one.points.iter().chain(&one.points);
        assert_eq!(found.points, twice.map(moved).collect::<Vec<_>>());
        for cell in 0..n_cells {
            let (part, second) = (found.cells.get(cell), found.cells.get(n_cells + cell));
            assert_eq!(part.nodes, one.cells.get(cell).nodes);
            let shifted: Vec<u32> = part.nodes.iter().map(|node| node + n as u32).collect();
            assert_eq!((part.kind, &shifted[..]), (second.kind, second.nodes));
        }
        let (Values::F32(radius), Values::F64(wanted)) =
            (&found.point_arrays[0].values, &one.point_arrays[0].values)
        else {
            panic!("{:?}", found.point_arrays);
        };
        let wanted = wanted
            .iter()
            .chain(wanted)
            .map(|r| (r + step as f64) as f32);
        assert!(radius.iter().copied().eq(wanted));
        for (group, twin) in found.groups.iter().zip(&one.groups) {
            assert_eq!(
                (&group.name, group.cells.len()),
                (&twin.name, 2 * twin.cells.len())
            );
        }
    }
}

#[test]
fn other_hdf5_files_are_told_apart() {
    use crate::formats::hdf5::Tree;
    let bytes = |kind: Option<&str>| {
        let mut tree = Tree::new();
        if let Some(kind) = kind {
            let group = tree.group(Tree::ROOT, ROOT);
            tree.text_attribute(group, "Type", kind);
        }
        let mut bytes = Vec::new();
        tree.write(&mut bytes).expect("it can be written");
        bytes
    };
    let other = Source::from_bytes(Path::new("x"), bytes(None));
    assert!(!(VTKHDF.detect)(&other));
    let image = bytes(Some("ImageData"));
    let error = parse(&VTKHDF, &image, &ReadOptions::default()).expect_err("it is no grid");
    assert_says(&error, "type ImageData");
}
