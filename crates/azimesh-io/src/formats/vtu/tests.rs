use super::*;
use crate::formats::vtk::fixtures::rich_mesh;
use crate::formats::{Notes, ReadOptions, WriteOptions, parse};
use crate::mesh::{CellKind, CellSet, Mesh, Values};

fn written(mesh: &Mesh, options: &WriteOptions) -> (Vec<u8>, Notes) {
    let mut bytes = Vec::new();
    let notes = VTU
        .write_file(&mesh.view(), &mut bytes, options)
        .expect("it can be written");
    (bytes, notes)
}

fn read(bytes: &[u8]) -> Mesh {
    let mut mesh = parse(&VTU, bytes, &ReadOptions::default()).expect("it can be read");
    mesh.validate().expect("it is a good mesh");
    mesh.merge_repeated_faces();
    mesh
}

fn all_options() -> Vec<WriteOptions> {
    use Compression::{Lz4, Lzma, None, Zlib};
    let mut all = Vec::new();
    for encoding in [Encoding::Raw, Encoding::Base64, Encoding::Ascii] {
        for compression in [None, Zlib, Lz4, Lzma] {
            for precision in [Precision::F64, Precision::F32] {
                all.push(WriteOptions {
                    pieces: Default::default(),
                    encoding,
                    compression,
                    precision,
                    tag_names: true,
                });
            }
        }
    }
    all
}

#[test]
fn everything_in_a_mesh_survives_every_way_of_writing_it() {
    for options in all_options() {
        let mut expected = rich_mesh();
        let (bytes, notes) = written(&expected, &options);
        assert_eq!(notes, []);
        if options.precision == Precision::F32 {
            let coordinates = expected.points.as_flattened_mut().iter_mut();
            coordinates.for_each(|x| *x = f64::from(*x as f32));
        }
        assert_eq!(read(&bytes), expected, "{options:?}");
    }
}

#[test]
fn a_mesh_larger_than_a_block_survives_every_way_of_writing_it() {
    let n = 70_000u32;
    let mut mesh = Mesh::of_points(
        (0..n)
            .map(|i| [f64::from(i).sqrt(), -f64::from(i), 1.0 / f64::from(i + 1)])
            .collect(),
    );
    for i in 3..n {
        match i % 7 {
            0 => mesh.cells.push(CellKind::Triangle, &[i, i - 1, i - 2]),
            _ => mesh
                .cells
                .push(CellKind::Tetrahedron, &[i, i - 1, i - 2, i - 3]),
        }
    }
    let is_double = |options: &WriteOptions| options.precision == Precision::F64;
    for options in all_options().into_iter().filter(is_double) {
        assert_eq!(read(&written(&mesh, &options).0), mesh, "{options:?}");
    }
}

#[test]
fn an_empty_mesh_survives_every_way_of_writing_it() {
    for options in all_options() {
        let mesh = Mesh::default();
        assert_eq!(read(&written(&mesh, &options).0), mesh, "{options:?}");
    }
}

#[test]
fn without_names_tags_keep_their_numbers() {
    let mut mesh = rich_mesh();
    mesh.groups.retain(|group| group.dimension == 2);
    mesh.groups[0].number = Some(17);
    let options = WriteOptions {
        tag_names: false,
        ..WriteOptions::default()
    };
    let (bytes, notes) = written(&mesh, &options);
    assert_eq!(notes.len(), 3, "{notes:?}");
    let names: Vec<_> = read(&bytes).groups.iter().map(|g| g.name.clone()).collect();
    assert_eq!(names, ["3", "17"]);
}

#[test]
fn a_cell_in_two_zones_keeps_the_first_and_is_noted() {
    let mut mesh = rich_mesh();
    mesh.groups[4].cells = [1, 2].into_iter().collect();
    let (bytes, notes) = written(&mesh, &WriteOptions::default());
    assert_eq!(notes, ["several_groups"]);
    let several = "cells are in more than one group (1, the first is cell 1); the array Zone holds the first group of each";
    assert!(notes.says(several), "{notes:?}");
    assert!(read(&bytes).groups[4].cells == CellSet::from(2..3));
}

/// A grid in ASCII with one quadrilateral, its edges, and the given cell data.
fn square(cell_data: &str) -> String {
    format!(
        r#"<?xml version="1.0"?><!-- made by hand -->
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="3"><CellData>{cell_data}</CellData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 1 1 0</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3 0 1 1 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4 6 8</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">8 3 3</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>"#
    )
}

fn error(text: &str, tag_array: Option<&str>) -> String {
    let options = ReadOptions {
        tag_array: tag_array.map(str::to_owned),
        ..ReadOptions::default()
    };
    let result = parse(&VTU, text.as_bytes(), &options);
    result.expect_err("it cannot be read").to_string()
}

#[test]
fn a_pixel_becomes_a_quadrilateral() {
    assert_eq!(read(square("").as_bytes()).cells.get(0).nodes, [0, 1, 3, 2]);
}

#[test]
fn numbers_of_other_programs_become_tags_and_zones() {
    for name in ["gmsh:physical", "CellEntityIds", "medit:ref"] {
        let array =
            format!(r#"<DataArray type="Int16" Name="{name}" format="ascii">9 5 5</DataArray>"#);
        let mesh = read(square(&array).as_bytes());
        let groups: Vec<_> = mesh
            .groups
            .iter()
            .map(|g| (&g.name[..], g.dimension, g.cells.len()))
            .collect();
        assert_eq!(groups, [("5", 1, 2), ("9", 2, 1)]);
        assert!(mesh.cell_arrays.is_empty());
    }
}

#[test]
fn the_users_tag_array_is_taken_and_a_missing_one_is_named() {
    let array = r#"<DataArray type="Float64" Name="wall id" format="ascii">0 5 7</DataArray>"#;
    let text = square(array);
    let options = ReadOptions {
        tag_array: Some("wall id".into()),
        ..ReadOptions::default()
    };
    let mesh = parse(&VTU, text.as_bytes(), &options).expect("it can be read");
    assert_eq!(mesh.boundary_tags().count(), 2);
    let message = error(&text, Some("wall_id"));
    assert!(message.contains("did you mean wall id") && message.contains("cell arrays: wall id"));
}

#[test]
fn errors_say_where_and_what() {
    let good = square("");
    let cases = [
        (
            "0 1 2 3 0 1",
            "0 1 2 x 0 1",
            "line 5: \"x\" is not a number of type Int32",
        ),
        (
            "0 1 2 3 0 1",
            "0 1 2 4 0 1",
            " connectivity: entry 3 is 4; it must be from 0 to 3",
        ),
        (
            "4 6 8",
            "4 6 9",
            "cell 2 is a line with 3 nodes; it must have 2",
        ),
        (
            "4 6 8",
            "4 3 8",
            " offsets: cell 1 ends at 3, before the cell before it, which ends at 4",
        ),
        ("8 3 3", "8 3 44", "VTK type 44"),
        ("8 3 3", "8 3", " types: "),
        ("1 1 0</", "1 1</", " Points: "),
        (
            "type=\"UnstructuredGrid\"",
            "type=\"Table\"",
            "line 2: the file has the VTK type Table",
        ),
        ("</Cells>", "", "line 8"),
    ];
    for (from, to, expected) in cases {
        let message = error(&good.replacen(from, to, 1), None);
        assert!(message.contains(expected), "{message} / {expected}");
    }
}

#[test]
fn pieces_are_joined_and_keep_arrays_that_all_have() {
    let piece = |x: i32, arrays: &str| {
        format!(
            r#"<Piece NumberOfPoints="3" NumberOfCells="1"><PointData>{arrays}</PointData>
<Points><DataArray type="Int32" NumberOfComponents="3" format="ascii">{x} 0 0 {x} 1 0 {x} 0 1</DataArray></Points>
<Cells><DataArray type="UInt64" Name="connectivity" format="ascii">2 1 0</DataArray>
<DataArray type="UInt16" Name="offsets" format="ascii">3</DataArray>
<DataArray type="Int32" Name="types" format="ascii">5</DataArray></Cells></Piece>"#
        )
    };
    let array = |name: &str| {
        format!(r#"<DataArray type="Int8" Name="{name}" format="ascii">1 2 3</DataArray>"#)
    };
    let text = format!(
        r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid>{}<Piece NumberOfPoints="0" NumberOfCells="0"/>{}</UnstructuredGrid></VTKFile>"#,
        piece(0, &(array("a") + &array("b"))),
        piece(7, &array("b")),
    );
    let mesh = read(text.as_bytes());
    assert_eq!(mesh.points[5], [7.0, 0.0, 1.0]);
    assert_eq!(mesh.cells.connectivity(), [2, 1, 0, 5, 4, 3]);
    assert_eq!(mesh.point_arrays.len(), 1);
    assert_eq!(
        mesh.point_arrays[0].values,
        Values::I8(vec![1, 2, 3, 1, 2, 3])
    );
}

#[test]
fn the_version_is_not_that_of_xml() {
    let head = b"<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"2.1\">";
    assert_eq!((VTU.version)(head).as_deref(), Some("2.1"));
    assert_eq!((VTU.version)(b"<?xml version=\"1.0\"?>"), None);
}

/// A point and a vertex at z = 10 for each of `z`, with its values of step `i`.
fn steps(z: &[u8], step_of: impl Fn(usize) -> usize, one_piece: bool) -> String {
    let array = |i: usize, kind: &str, name: &str, values: &str| {
        let n = if name == "Points" { 3 } else { 1 };
        let step = step_of(i);
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{n}\" TimeStep=\"{step}\">{values}</DataArray>"
        )
    };
    let each = |make: &dyn Fn(usize) -> String| (0..z.len()).map(make).collect::<String>();
    let piece = |points: String, cells: String| {
        format!(
            "<Piece NumberOfPoints=\"1\" NumberOfCells=\"1\"><Points>{points}</Points><Cells>{cells}</Cells></Piece>"
        )
    };
    let points = |i: usize| array(i, "Float64", "Points", &format!("0 0 {}", z[i]));
    let cells = |i: usize| {
        array(i, "Int64", "connectivity", "0")
            + &array(i, "Int64", "offsets", "1")
            + &array(i, "UInt8", "types", "1")
    };
    let pieces = if one_piece {
        piece(each(&points), each(&cells))
    } else {
        each(&|i| piece(points(i), cells(i)))
    };
    let times: String = (0..z.len())
        .map(|i| format!("{} ", 0.5 * i as f64))
        .collect();
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid TimeValues=\"\n{times}\n\">{pieces}</UnstructuredGrid></VTKFile>"
    )
}

#[test]
fn one_of_the_steps_in_a_file_is_read() {
    let z = [0, 10, 20];
    for text in [
        steps(&z, |i| i, true),
        steps(&z, |i| i, false),
        steps(&z, |_| 0, false),
    ] {
        let bytes = text.as_bytes();
        assert_eq!(document::times(bytes).expect("times"), [0.0, 0.5, 1.0]);
        for (step, expected) in [(None, 20.0), (Some(0), 0.0), (Some(1), 10.0)] {
            let options = ReadOptions {
                step,
                ..ReadOptions::default()
            };
            let mesh = parse(&VTU, bytes, &options).expect("it can be read");
            assert_eq!(
                (mesh.points, mesh.cells.len()),
                (vec![[0.0, 0.0, expected]], 1)
            );
        }
        let none = ReadOptions {
            step: Some(3),
            ..ReadOptions::default()
        };
        assert!(parse(&VTU, bytes, &none).is_err());
    }
}

/// A field array of so many bytes 1, 2, 3 ... in base64, behind a header of `width` bytes, which may be encoded alone.
fn in_base64(n: u8, width: usize, is_alone: bool) -> String {
    let encode = |bytes: &[u8]| base64_simd::STANDARD.encode_to_string(bytes);
    let header = &u64::from(n).to_le_bytes()[..width];
    let values: Vec<u8> = (1..=n).collect();
    let text = match is_alone {
        true => encode(header) + &encode(&values),
        false => encode(&[header, &values[..]].concat()),
    };
    format!(
        "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt{}\"><UnstructuredGrid><FieldData><DataArray type=\"UInt8\" \
         Name=\"f\" NumberOfTuples=\"{n}\" format=\"binary\">\n{text}\n</DataArray></FieldData>\
         <Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"/></UnstructuredGrid></VTKFile>",
        8 * width
    )
}

#[test]
fn arrays_of_a_few_bytes_are_read_from_base64() {
    for n in 0..10 {
        for (width, is_alone) in [(4, false), (4, true), (8, false), (8, true)] {
            let mesh = read(in_base64(n, width, is_alone).as_bytes());
            let expected = Values::U8((1..=n).collect());
            assert_eq!(
                mesh.field_arrays[0].values, expected,
                "{n} {width} {is_alone}"
            );
        }
    }
}
