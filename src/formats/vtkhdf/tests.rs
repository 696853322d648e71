//! What is written is read back; what VTK's writer and h5py have written is read as it is. That VTK
//! reads what we write is checked in scripts/verify/vtkhdf.py.

use super::*;
use crate::formats::{Begin, Precision, SequenceFile, parse};
use crate::mesh::{CellKind, DataArray, Group, Values};
use std::path::Path;

pub(super) fn mesh() -> Mesh {
    let mut mesh = Mesh {
        points: (0..14)
            .map(|i| [f64::from(i % 3), f64::from(i) / 3.0, -0.1])
            .collect(),
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh.cells
        .push(CellKind::Hexahedron, &[2, 3, 4, 5, 6, 7, 8, 9]);
    let stream = [
        4, 3, 10, 11, 12, 3, 10, 11, 13, 3, 11, 12, 13, 3, 10, 12, 13,
    ];
    mesh.cells.push_polyhedron(&stream).expect("a good stream");
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    mesh.cells.push(CellKind::Polygon, &[2, 3, 4, 5, 6]);
    let group = |dimension, name: &str, number, cells: &[usize]| Group {
        dimension,
        name: name.into(),
        number: Some(number),
        condition: None,
        cells: cells.iter().copied().collect(),
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

pub(super) fn written(mesh: &Mesh, options: &WriteOptions) -> (Vec<u8>, Vec<String>) {
    let mut bytes = Vec::new();
    let notes = VtkHdf
        .write(mesh, &mut bytes, options)
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
    let mesh = VtkHdf.read(source, &options, &mut Notes::default());
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
    assert!(VtkHdf.recognizes_file(&source));
    assert_same(&read(&source, None), &mesh());
    assert!(VtkHdf.steps(&source).expect("it can be asked").is_empty());
}

#[test]
fn an_empty_mesh_and_nodes_without_cells_come_back() {
    let nodes = Mesh {
        points: vec![[1.0, 2.0, 3.0]],
        ..Mesh::default()
    };
    for mesh in [Mesh::default(), nodes] {
        let (bytes, _) = written(&mesh, &WriteOptions::default());
        let found = parse(&VtkHdf, &bytes, &ReadOptions::default()).expect("it can be read");
        assert_same(&found, &mesh);
    }
}

#[test]
fn a_face_in_two_tags_is_written_once_for_each() {
    let mut twice = mesh();
    twice.groups[1].cells = [4].into_iter().collect();
    let (bytes, _) = written(&twice, &WriteOptions::default());
    let found = parse(&VtkHdf, &bytes, &ReadOptions::default()).expect("it can be read");
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
    let found = parse(&VtkHdf, &bytes, &ReadOptions::default()).expect("it can be read");
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
    for name in ["\"node name\" is left out", "\"cell name\" is left out"] {
        assert!(notes.iter().any(|note| note.contains(name)), "{notes:?}");
    }
    let found = parse(&VtkHdf, &bytes, &ReadOptions::default()).expect("it can be read");
    assert_same(&found, &mesh());
}

#[test]
fn names_that_hdf5_does_not_allow_are_changed_and_told() {
    let mut odd = mesh();
    odd.point_arrays[0].name = "p/p0".into();
    odd.point_arrays[1].name = "p_p0".into();
    let (_, notes) = written(&odd, &WriteOptions::default());
    assert!(
        notes[0].contains("\"p/p0\" is called \"p_p0\""),
        "{notes:?}"
    );
    assert!(notes[1].contains("\"p_p0\" is not written"), "{notes:?}");
}

#[test]
fn files_of_vtk_are_read_as_the_same_mesh_in_vtu() {
    for (name, twin) in [
        ("mixed_cells_by_vtk", "mixed_cells_inline"),
        ("polyhedra_by_vtk", "polyhedra_ascii"),
    ] {
        let wanted = file(&format!("{twin}.vtu"));
        let wanted = crate::formats::read(&wanted, &ReadOptions::default())
            .expect("it is read")
            .mesh;
        let found = file(&format!("{name}.vtkhdf"));
        let found = crate::formats::read(&found, &ReadOptions::default())
            .expect("it is read")
            .mesh;
        assert_same(&found, &wanted);
    }
}

#[test]
fn the_steps_of_vtk_are_read_one_by_one() {
    let source = file("moving_by_vtk.vtkhdf");
    assert_eq!(
        VtkHdf.steps(&source).expect("it has steps"),
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
    let error = VtkHdf
        .read(&source, &options, &mut Notes::default())
        .expect_err("there are three");
    assert_eq!(error.to_string(), " Steps: step 3 of 3; steps count from 0");
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

/// Three steps of the mesh: nodes move, one array changes at the last step.
fn moving(step: usize) -> Mesh {
    let mut mesh = mesh();
    for point in &mut mesh.points {
        point[2] += step as f64;
    }
    if let (2, Values::U8(values)) = (step, &mut mesh.point_arrays[1].values) {
        values[3] = 99;
    }
    mesh
}

fn sequence(folder: &Path) -> (Box<dyn SequenceFile>, std::path::PathBuf) {
    let path = folder.join("moving.vtkhdf");
    let create = VtkHdf.sequence().expect("it has sequences");
    let sequence = create(&path, &WriteOptions::default(), Begin::Anew).expect("it can be made");
    (sequence, path)
}

#[test]
fn a_sequence_is_whole_under_its_name_after_each_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut sequence, path) = sequence(folder.path());
    assert!(!path.exists());
    let mut sizes = Vec::new();
    for step in 0..3 {
        sequence
            .append(step as f64 * 0.25, &moving(step))
            .expect("it is appended");
        let source = Source::open(&path).expect("it has its name");
        let times: Vec<f64> = (0..=step).map(|i| i as f64 * 0.25).collect();
        assert_eq!(VtkHdf.steps(&source).expect("it has steps"), times);
        for earlier in 0..=step {
            assert_same(&read(&source, Some(earlier)), &moving(earlier));
        }
        sizes.push(source.bytes().len());
    }
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        1
    );
    assert!(
        sizes[1] - sizes[0] < sizes[0],
        "what stays is written once: {sizes:?}"
    );
}

#[test]
fn a_sequence_is_gone_on_with_to_the_same_bytes_wherever_it_ended_or_was_damaged() {
    let folder = tempfile::tempdir().expect("a folder");
    let append = |sequence: &mut Box<dyn SequenceFile>, steps: std::ops::Range<usize>| {
        let mut append = |step| sequence.append(step as f64, &moving(step));
        steps
            .map(|step| append(step).expect("it is appended"))
            .collect::<Vec<_>>()
    };
    let (mut whole, path) = sequence(folder.path());
    let mut hashes = append(&mut whole, 0..1);
    let first = std::fs::read(&path).expect("it is there");
    hashes.extend(append(&mut whole, 1..3));
    drop(whole);
    let wanted = std::fs::read(&path).expect("it is there");
    let create = VtkHdf.sequence().expect("it has sequences");
    let retrace = || create(&path, &WriteOptions::default(), Begin::Retrace).expect("it opens");
    let check = |content: &[u8], what: &str| {
        std::fs::write(&path, content).expect("it can be written");
        let mut sequence = retrace();
        assert_eq!(append(&mut sequence, 0..3), hashes, "{what}");
        assert!(
            std::fs::read(&path).expect("it is there") == wanted,
            "{what}"
        );
        sequence.is_retracing()
    };
    assert!(check(&wanted, "whole"));
    for end in (first.len()..wanted.len()).step_by(97) {
        // As a kill leaves it: the start is that of the first step.
        let content = [&first[..48], &wanted[48..end]].concat();
        assert!(!check(&content, &format!("{end} bytes")));
    }
    for at in (48..wanted.len()).step_by(131) {
        let mut content = wanted.clone();
        content[at] ^= 1;
        assert!(!check(&content, &format!("damaged at {at}")));
    }
    std::fs::remove_file(&path).expect("it is there");
    assert_eq!(append(&mut retrace(), 0..3), hashes, "from nothing");
    // A file damaged in its second step keeps the first while it is written again.
    let mut content = wanted.clone();
    content[first.len() + 80] ^= 1;
    std::fs::write(&path, content).expect("it can be written");
    let mut sequence = retrace();
    append(&mut sequence, 0..1);
    let mut lacking = moving(1);
    lacking.point_arrays.clear();
    assert!(
        sequence.append(1.0, &lacking).is_err(),
        "arrays are missing"
    );
    drop(sequence);
    let source = Source::open(&path).expect("it is there");
    assert_same(&read(&source, Some(0)), &moving(0));
}

#[test]
fn a_step_too_large_for_a_chunk_is_cut() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.vtkhdf");
    let sequence = sequence::Sequence::create(&path, &WriteOptions::default(), Begin::Anew);
    let mut sequence = sequence.expect("it can be made");
    // 14 nodes of 24 bytes: four chunks of four, the last one half filled.
    sequence.chunk_limit = 100;
    for step in 0..3 {
        sequence
            .append(step as f64, &moving(step))
            .expect("it is appended");
    }
    let source = Source::open(&path).expect("it is there");
    let points = grid(&source)
        .expect("it is HDF5")
        .expect("it is VTK's")
        .need("Points");
    assert_eq!(points.expect("it has points").shape(), [3 * 16, 3]);
    for step in 0..3 {
        assert_same(&read(&source, Some(step)), &moving(step));
    }
}

#[test]
fn a_sequence_has_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut hashes = Vec::new();
    for _ in 0..2 {
        let (mut sequence, path) = sequence(folder.path());
        let step = |i| {
            sequence
                .append(i as f64, &moving(i))
                .expect("it is appended")
        };
        let of_steps: Vec<blake3::Hash> = (0..3).map(step).collect();
        hashes.push((of_steps, std::fs::read(path).expect("it is there")));
    }
    assert!(hashes[0] == hashes[1]);
    assert!(hashes[0].0[1] != hashes[0].0[2]);
}

#[test]
fn a_sequence_refuses_other_cells_and_other_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut sequence, path) = sequence(folder.path());
    sequence.append(0.0, &mesh()).expect("it is appended");
    let mut other = mesh();
    other.cells.push(CellKind::Triangle, &[0, 1, 3]);
    for array in &mut other.cell_arrays {
        array.values = array.values.select(1, &[0, 1, 2, 3, 4, 4]);
    }
    let error = sequence
        .append(1.0, &other)
        .expect_err("it has another cell")
        .to_string();
    assert!(error.contains("other nodes, cells"), "{error}");
    let mut other = mesh();
    other
        .point_arrays
        .push(DataArray::scalar("new", Values::U8(vec![0; 14])));
    let error = sequence
        .append(1.0, &other)
        .expect_err("it has another array")
        .to_string();
    assert!(
        error.contains("\"new\" is not in the first step"),
        "{error}"
    );
    drop(sequence);
    let source = Source::open(&path).expect("the first step is there");
    assert_eq!(VtkHdf.steps(&source).expect("it has a step"), [0.0]);
}

#[test]
fn a_sequence_given_up_before_its_first_step_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    drop(sequence(folder.path()));
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        0
    );
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
    assert!(!VtkHdf.recognizes_file(&other));
    let image = bytes(Some("ImageData"));
    let error = parse(&VtkHdf, &image, &ReadOptions::default()).expect_err("it is no grid");
    assert!(error.to_string().contains("type ImageData"), "{error}");
}
