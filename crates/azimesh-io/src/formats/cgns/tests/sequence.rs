//! Sequences in one file.

use super::*;
use crate::formats::portable::not_taken;
use crate::testing::assert_says;

/// Arrays of the mesh as a whole: at two steps the same, then others, then none.
fn field_arrays(step: i32) -> Vec<DataArray> {
    let time = DataArray::scalar("TimeValue", Values::F64(vec![f64::from(step / 2)]));
    let hub = DataArray::tuples("hub", 3, Values::F32(vec![1.0, 2.0, 3.0]));
    match step {
        3 => Vec::new(),
        2 => vec![time, hub, DataArray::scalar("new", Values::I32(vec![7]))],
        _ => vec![time, hub],
    }
}

#[test]
fn a_sequence_grows_and_is_whole_after_each_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("moving.cgns");
    let create = CGNS.sequence.expect("CGNS has sequences");
    let mut file =
        create(&path, &WriteOptions::default(), Begin::Create, false).expect("it starts");
    assert!(!path.exists(), "no file before the first step is whole");
    let mut mesh = rich_mesh();
    for step in 0..4 {
        for point in &mut mesh.points {
            point[2] += 1.0;
        }
        if step == 2 {
            mesh.cell_arrays[0].values = Values::F64(vec![f64::from(step); 8]);
        }
        mesh.field_arrays = field_arrays(step);
        file.push(f64::from(step) * 0.25, &mesh.view())
            .expect("it is appended");
        let source = Source::open(&path).expect("it has its name");
        let times: Vec<f64> = (0..=step).map(|i| f64::from(i) * 0.25).collect();
        assert_eq!((CGNS.steps)(&source).expect("steps"), times);
        for earlier in 0..=step {
            let options = ReadOptions {
                step: usize::try_from(earlier).ok(),
                ..ReadOptions::default()
            };
            let found = CGNS
                .read_file(&source, &options, &mut Notes::default())
                .expect("it is read");
            assert_eq!(found.points[5][2], 1.5 + f64::from(earlier));
            assert_eq!(found.point_arrays, mesh.point_arrays);
            assert_eq!(found.field_arrays, field_arrays(earlier));
            let Values::F64(quality) = &found.cell_arrays[0].values else {
                panic!("quality is of 64 bits");
            };
            assert_eq!(quality[1], if earlier < 2 { 0.5 } else { 2.0 });
            assert_eq!(found.groups.len(), 5);
        }
    }
    let mut other = mesh.clone();
    other.cells.push(CellKind::Vertex, &[0]);
    let error = file.push(9.0, &other.view()).expect_err("other cells");
    assert_says(&error, "other nodes or cells");
}

#[test]
fn round_off_does_not_lift_a_plane_sequence_out_of_its_plane() {
    let folder = tempfile::tempdir().expect("a folder");
    let create = CGNS.sequence.expect("CGNS has sequences");
    let path = folder.path().join("m.cgns");
    let mut file =
        create(&path, &WriteOptions::default(), Begin::Create, false).expect("it starts");
    let triangle = |z: f64| {
        let mut mesh = Mesh::of_points(vec![[0.0, 0.0, z], [3.0, 0.0, 0.0], [0.0, 2.0, -z]]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        mesh
    };
    for z in [1e-16, 0.0, 2e-16] {
        file.push(0.0, &triangle(z).view()).expect("a plane step");
    }
    let error = file
        .push(0.0, &triangle(1e-9).view())
        .expect_err("it is lifted");
    assert_says(&error, "not in the plane");
    let bytes = std::fs::read(&path).expect("it is there");
    let back = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read");
    assert_eq!(back.points, triangle(0.0).points);
}

#[test]
fn a_sequence_refuses_polyhedra_of_the_same_nodes_with_other_faces() {
    let folder = tempfile::tempdir().expect("a folder");
    let create = CGNS.sequence.expect("CGNS has sequences");
    let path = folder.path().join("m.cgns");
    let mut file =
        create(&path, &WriteOptions::default(), Begin::Create, false).expect("it starts");
    let pyramid = |apex: u32, [a, b, c, d]: [u32; 4]| {
        let mut mesh = Mesh::of_points(vec![[0.0, 0.0, 1.0]; 5]);
        let faces = [
            &[5, 4, a, b, c, d][..],
            &[3, a, b, apex, 3, b, c, apex, 3, c, d, apex, 3, d, a, apex],
        ];
        mesh.cells
            .push_polyhedron_with_nodes(&[0, 1, 2, 3, 4], &faces.concat())
            .expect("a good polyhedron");
        mesh
    };
    file.push(0.0, &pyramid(4, [0, 1, 2, 3]).view())
        .expect("a step");
    let other = file.push(1.0, &pyramid(0, [1, 2, 3, 4]).view());
    let message = other.expect_err("other faces").to_string();
    assert_says(&message, "other nodes or cells");
}

#[test]
fn arrays_that_are_left_out_are_named_in_a_file_and_in_a_sequence() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mesh = rich_mesh();
    let n = mesh.points.len();
    let large = |n| Values::U64(vec![u64::MAX; n]);
    mesh.point_arrays.push(DataArray::scalar("hash", large(n)));
    mesh.field_arrays = vec![
        DataArray::scalar("seed", large(1)),
        DataArray::scalar("none", Values::F64(Vec::new())),
    ];
    let create = CGNS.sequence.expect("CGNS has sequences");
    let path = folder.path().join("m.cgns");
    let mut file =
        create(&path, &WriteOptions::default(), Begin::Create, false).expect("it starts");
    file.push(0.0, &mesh.view()).expect("a step");
    let (bytes, mut notes) = written(&mesh);
    notes.extend(not_taken(&mesh.view(), "cgns"));
    assert_eq!(notes, *file.notes());
    for text in [
        "array \"hash\" is not written: it has integers above 9223372036854775807, the largest of CGNS",
        "array \"seed\" is not written: it has integers above 9223372036854775807, the largest of CGNS",
        "field array \"none\" is not written: it has no values",
    ] {
        assert!(notes.says(text), "{text}: {notes:?}");
    }
    let back = parse(&CGNS, &bytes, &ReadOptions::default()).expect("it is read");
    assert!(back.point_arrays.iter().all(|array| array.name != "hash"));
    assert!(back.field_arrays.is_empty());
}
