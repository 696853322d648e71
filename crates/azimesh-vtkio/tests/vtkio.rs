//! The crate vtkio as a second reader of what is written, and meshes in its model.

use azimesh_io::formats::{
    Compression, Encoding, Format, Notes, Precision, ReadOptions, WriteOptions, by_name, parse,
};
use azimesh_io::mesh::{CellKind, DataArray, Group, Mesh, Values};
use azimesh_vtkio::{from_vtkio, to_vtkio};
use vtkio::model::Vtk;

/// Mixed cells with tagged faces, a face in two tags, zones and arrays. vtkio has no strings.
fn mesh() -> Mesh {
    let mut mesh = Mesh {
        points: (0..40u32)
            .map(|i| {
                [
                    f64::from(i % 4),
                    f64::from(i) / 3.0,
                    -0.1 * f64::from(i * i),
                ]
            })
            .collect(),
        ..Mesh::default()
    };
    let cells = &mut mesh.cells;
    cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
    cells.push(CellKind::Hexahedron, &[2, 3, 4, 5, 6, 7, 8, 9]);
    // Of positive volume, which says what its order is in a model.
    cells.push(CellKind::Wedge, &[10, 12, 11, 13, 15, 14]);
    cells.push(CellKind::Pyramid, &[16, 17, 18, 19, 20]);
    cells.push(
        CellKind::Tetrahedron10,
        &[21, 22, 23, 24, 25, 26, 27, 28, 29, 30],
    );
    cells.push(CellKind::Triangle, &[0, 1, 2]);
    cells.push(CellKind::Polygon, &[2, 3, 4, 5, 6]);
    cells.push(CellKind::Quadrilateral, &[2, 3, 4, 5]);
    let group = |dimension, number: i32, cells: &[usize]| Group {
        dimension,
        name: number.to_string(),
        number: Some(number),
        condition: None,
        cells: cells.iter().copied().collect(),
    };
    mesh.groups = vec![
        group(2, 1, &[6, 7]),
        group(2, 2, &[7, 8]),
        group(3, 1, &[0, 1, 2]),
        group(3, 2, &[3, 4, 5]),
    ];
    let number = |i: u8| f64::from(i) / 7.0;
    mesh.cell_arrays = vec![
        DataArray::scalar("short", Values::I16((0..9).map(|i| i * -3000).collect())),
        DataArray::scalar("int", Values::I32((0..9).map(|i| i << 27).collect())),
        DataArray::scalar("byte", Values::U8((0..9).map(|i| i * 28).collect())),
    ];
    mesh.point_arrays = vec![
        DataArray::scalar("p", Values::F64((0..40).map(number).collect())),
        DataArray::tuples(
            "u",
            3,
            Values::F32((0..120).map(|i| number(i) as f32).collect()),
        ),
    ];
    mesh
}

fn read_by_vtkio(bytes: &[u8]) -> Vtk {
    let read = if bytes.starts_with(b"# vtk") {
        Vtk::parse_legacy_be(bytes)
    } else {
        Vtk::parse_xml(bytes)
    };
    read.expect("vtkio reads it")
}

fn written(mesh: &Mesh, format: &Format, options: &WriteOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    let notes = format.write_file(&mesh.view(), &mut bytes, options);
    notes.expect("it can be written");
    bytes
}

/// Names of tags are strings, which vtkio refuses; appended raw values and LZMA it does not know.
fn options_that_vtkio_knows() -> Vec<(&'static str, WriteOptions)> {
    let mut all = Vec::new();
    let mut add = |name, encoding, compression| {
        for precision in [Precision::F64, Precision::F32] {
            let options = WriteOptions {
                pieces: None,
                encoding,
                compression,
                precision,
                tag_names: false,
            };
            all.push((name, options));
        }
    };
    for name in ["vtk42", "vtk"] {
        add(name, Encoding::Ascii, Compression::None);
        add(name, Encoding::Raw, Compression::None);
    }
    add("vtu", Encoding::Ascii, Compression::None);
    for compression in [Compression::None, Compression::Zlib, Compression::Lz4] {
        add("vtu", Encoding::Base64, compression);
    }
    all
}

#[test]
fn vtkio_reads_what_is_written() {
    for (name, options) in options_that_vtkio_knows() {
        let format = by_name(name).expect("it is known");
        let mut expected = mesh();
        let bytes = written(&expected, format, &options);
        if options.precision == Precision::F32 {
            let coordinates = expected.points.as_flattened_mut().iter_mut();
            coordinates.for_each(|x| *x = f64::from(*x as f32));
        }
        let model = read_by_vtkio(&bytes);
        let mut notes = Notes::default();
        let found = from_vtkio(&model, &ReadOptions::default(), &mut notes);
        assert_eq!(found.expect("a mesh"), expected, "{name} {options:?}");
        assert!(notes.is_empty());
    }
}

#[test]
fn a_mesh_goes_through_vtkios_model_and_comes_back() {
    let expected = mesh();
    let mut notes = Notes::default();
    let model = to_vtkio(&expected.view(), &mut notes).expect("it fits");
    let found = from_vtkio(&model, &ReadOptions::default(), &mut notes).expect("a mesh");
    assert_eq!(found, expected);
    // What vtkio writes of the model, azimesh reads.
    let mut bytes = Vec::new();
    model.write_legacy(&mut bytes).expect("vtkio writes it");
    let format = by_name("vtk").expect("it is known");
    let mut found = parse(format, &bytes, &ReadOptions::default()).expect("it can be read");
    found.merge_repeated_faces();
    assert_eq!(found, expected);
}

#[test]
fn a_polyhedron_is_a_face_stream_in_vtkios_model() {
    let mut mesh = Mesh {
        points: (0..5u8)
            .map(|i| [f64::from(i), f64::from(i * i), 1.0])
            .collect(),
        ..Mesh::default()
    };
    let stream = [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3];
    mesh.cells.push_polyhedron(&stream).expect("a good stream");
    mesh.cells.push(CellKind::Tetrahedron, &[1, 2, 3, 4]);
    mesh.field_arrays = vec![DataArray::scalar("TIME", Values::F64(vec![1.0]))];
    let mut notes = Notes::default();
    let model = to_vtkio(&mesh.view(), &mut notes).expect("it fits");
    let notes_before: Vec<String> = notes.iter().map(ToString::to_string).collect();
    let [note] = &notes_before[..] else {
        panic!("one note: {notes_before:?}");
    };
    for part in ["vtkio", "field arrays", "\"TIME\""] {
        assert!(note.contains(part), "{part:?} is not in: {note}");
    }
    let found = from_vtkio(&model, &ReadOptions::default(), &mut notes).expect("a mesh");
    assert_eq!(found.cells, mesh.cells);
    mesh.cells
        .push(CellKind::PentagonalPrism, &[0, 1, 2, 3, 4, 0, 1, 2, 3, 4]);
    let error = to_vtkio(&mesh.view(), &mut notes).expect_err("vtkio has no such cell");
    assert!(error.to_string().contains("pentagonal_prism"), "{error}");
}

#[test]
fn a_model_that_is_no_mesh_is_refused() {
    let mut model = to_vtkio(&mesh().view(), &mut Notes::default()).expect("it fits");
    let refused = |model: &Vtk| {
        let result = from_vtkio(model, &ReadOptions::default(), &mut Notes::default());
        result.expect_err("it is not a mesh").to_string()
    };
    let vtkio::model::DataSet::UnstructuredGrid { pieces, .. } = &mut model.data else {
        panic!("it is an unstructured grid");
    };
    let vtkio::model::Piece::Inline(piece) = &mut pieces[0] else {
        panic!("it is here");
    };
    piece.cells.types.pop();
    let message = refused(&model);
    assert!(message.contains("types for"), "{message}");
}
