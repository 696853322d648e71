use super::*;
use crate::formats::vtk::fixtures::rich_mesh;
use crate::formats::{Encoding, Notes, ReadOptions, Source, WriteOptions, parse};
use crate::mesh::{CellKind, Mesh, Values};

fn read_with_notes(bytes: &[u8]) -> (Mesh, Notes) {
    let source = Source::from_bytes(std::path::Path::new("<memory>"), bytes.to_vec());
    let mut notes = Notes::default();
    let mesh = VTK51.read_file(&source, &ReadOptions::default(), &mut notes);
    let mut mesh = mesh.expect("it can be read");
    mesh.validate().expect("it is a good mesh");
    mesh.merge_repeated_faces();
    (mesh, notes)
}

fn read(text: &str) -> Mesh {
    read_with_notes(text.as_bytes()).0
}

fn error(bytes: &[u8]) -> String {
    let result = parse(&VTK51, bytes, &ReadOptions::default());
    result.expect_err("it cannot be read").to_string()
}

#[test]
fn everything_in_a_mesh_survives_both_versions_as_text_and_binary() {
    for format in [&VTK51, &VTK42] {
        for encoding in [Encoding::Raw, Encoding::Ascii] {
            for precision in [Precision::F64, Precision::F32] {
                let options = WriteOptions {
                    encoding,
                    precision,
                    ..WriteOptions::default()
                };
                let mut expected = rich_mesh();
                let mut bytes = Vec::new();
                let notes = format.write_file(&expected.view(), &mut bytes, &options);
                assert_eq!(notes.expect("it can be written"), []);
                if precision == Precision::F32 {
                    let coordinates = expected.points.as_flattened_mut().iter_mut();
                    coordinates.for_each(|x| *x = f64::from(*x as f32));
                }
                let (mesh, notes) = read_with_notes(&bytes);
                assert_eq!(notes, []);
                assert_eq!(mesh, expected, "{} {options:?}", format.name);
            }
        }
    }
}

#[test]
fn a_large_text_is_read_in_parts() {
    let n = 120_000u32;
    let mut mesh = Mesh::of_points(
        (0..n)
            .map(|i| [f64::from(i).sqrt(), -f64::from(i), 1.0])
            .collect(),
    );
    for i in 3..n {
        let nodes = [i, i - 1, i - 2, i - 3];
        mesh.cells.push(CellKind::Tetrahedron, &nodes);
    }
    let options = WriteOptions {
        encoding: Encoding::Ascii,
        ..WriteOptions::default()
    };
    for format in [&VTK51, &VTK42] {
        let mut bytes = Vec::new();
        format
            .write_file(&mesh.view(), &mut bytes, &options)
            .expect("it can be written");
        assert_eq!(read_with_notes(&bytes).0, mesh);
    }
}

const SQUARE: &str = "# vtk DataFile Version 2.0\nmade by hand\nASCII\nDATASET UNSTRUCTURED_GRID\n\
    POINTS 4 float\n0 0 0 1 0 0\n0 1 0 1 1 0\nCELLS 3 11\n4 0 1 2 3\n2 0 1\n2 1 3\n\
    CELL_TYPES 3\n8 3 3\n";

#[test]
fn every_way_of_giving_data_is_read() {
    let mesh = read(&format!(
        "{SQUARE}CELL_DATA 3\nSCALARS s int\nLOOKUP_TABLE default\n1 2 3\n\
         # a comment\ncolor_scalars c 2\n0 0.5 1 0 0 0\nLOOKUP_TABLE t 1\n0 0 0 1\n\
         POINT_DATA 4\nVECTORS v double\n1 2 3 4 5 6 7 8 9 10 11 12\nNORMALS n%20n float\n\
         0 0 1 0 0 1 0 0 1 0 0 1\nTEXTURE_COORDINATES t 2 float\n0 0 1 0 0 1 1 1\n\
         TENSORS6 t6 short\n{six}\nGLOBAL_IDS g vtkIdType\n7 8 9 10\nPEDIGREE_IDS p string\na\n\n\
         b%20\nc\nFIELD f 2\nbits 1 4 bit\n1 0 0 1\nw 1 4 unsigned_char\n1 2 3 255\nMETADATA\n\
         COMPONENT_NAMES\nweight\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\n\
         DATA 2 0 1\n\nSCALARS two float 2\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n",
        six = "1 2 3 4 5 6 ".repeat(4)
    ));
    let arrays = mesh.cell_arrays.iter().chain(&mesh.point_arrays);
    let found: Vec<_> = arrays
        .map(|a| (&a.name[..], a.n_components, a.values.len()))
        .collect();
    let expected = [
        ("s", 1, 3),
        ("c", 2, 6),
        ("v", 3, 12),
        ("n n", 3, 12),
        ("t", 2, 8),
        ("t6", 6, 24),
        ("g", 1, 4),
        ("p", 1, 4),
        ("bits", 1, 4),
        ("w", 1, 4),
        ("two", 2, 8),
    ];
    assert_eq!(found, expected);
    assert_eq!(
        mesh.cell_arrays[1].values,
        Values::U8(vec![0, 128, 255, 0, 0, 0])
    );
    let names = ["a", "", "b ", "c"].map(String::from).to_vec();
    assert_eq!(mesh.point_arrays[5].values, Values::Text(names));
    assert_eq!(mesh.point_arrays[7].component_names, ["weight"]);
}

#[test]
fn fields_and_metadata_may_stand_before_the_points() {
    let text = SQUARE.replacen(
        "POINTS",
        "FIELD FieldData 1\nTIME 1 1 double\n0.25\nMETADATA\nINFORMATION 0\n\nPOINTS",
        1,
    );
    let mesh = read(&text.replacen("CELLS", "METADATA\nINFORMATION 0\n\nCELLS", 1));
    assert_eq!(mesh.field_arrays[0].values, Values::F64(vec![0.25]));
    assert_eq!(mesh.cells.get(0).nodes, [0, 1, 3, 2]);
}

#[test]
fn collections_are_split_and_their_data_repeated() {
    let text = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 5 double\n\
        0 0 0 1 0 0 2 0 0 3 0 0 4 0 0\nTRIANGLE_STRIPS 1 6\n5 0 1 2 3 4\nVERTICES 1 3\n2 3 4\n\
        POLYGONS 1 4\n3 0 1 2\nLINES 2 7\n3 0 1 2\n2 3 4\nCELL_DATA 5\nSCALARS c int\n\
        LOOKUP_TABLE default\n10 20 30 40 50\n";
    let (mesh, notes) = read_with_notes(text.as_bytes());
    let numbers = vec![10, 10, 20, 20, 30, 40, 50, 50, 50];
    assert_eq!(mesh.cell_arrays[0].values, Values::I32(numbers));
    assert_eq!(mesh.cells.get(7).nodes, [2, 1, 3]);
    let texts: Vec<&str> = notes.iter().map(|note| &*note.text).collect();
    let expected = [
        "1 poly-vertex is split into 2 vertices",
        "1 polyline is split into 2 lines",
        "1 triangle strip is split into 3 triangles",
    ];
    assert_eq!(texts, expected);
    let empty = SQUARE
        .replace("3 11\n4 0 1 2 3", "3 7\n0")
        .replace("8 3 3", "0 3 3");
    let (mesh, notes) = read_with_notes(empty.as_bytes());
    assert_eq!(mesh.cells.len(), 2);
    assert_eq!(notes, ["empty_cells"]);
    assert!(notes.says("1 empty cell is left out"), "{notes:?}");
}

#[test]
fn structured_grids_become_cells() {
    let head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET ";
    let image =
        format!("{head}STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 1 0 0\nSPACING 0.5 1 2\n");
    let mesh = read(&(image.clone() + "CELL_DATA 2\nSCALARS c char\nLOOKUP_TABLE default\n1 2\n"));
    assert_eq!(mesh.points[11], [2.0, 1.0, 2.0]);
    assert_eq!(mesh.cells.get(1).nodes, [1, 2, 5, 4, 7, 8, 11, 10]);
    let rectilinear = format!(
        "{head}RECTILINEAR_GRID\nDIMENSIONS 2 1 3\nX_COORDINATES 2 float\n0 7\n\
         Y_COORDINATES 1 int\n5\nZ_COORDINATES 3 double\n0 1 3\n"
    );
    let mesh = read(&rectilinear);
    assert_eq!(mesh.points[5], [7.0, 5.0, 3.0]);
    assert_eq!(mesh.cells.get(1).nodes, [2, 3, 5, 4]);
    let huge = image.replace("3 2 2", "3000 2000 2000");
    assert!(
        error(huge.as_bytes()).contains("12000000000") || error(huge.as_bytes()).contains("3000 x")
    );
    let implied = image.replace("3 2 2", "1000 1000 100");
    assert!(error(implied.as_bytes()).contains("cannot have data"));
}

#[test]
fn errors_say_where_and_what() {
    let cases = [
        (
            "ASCII",
            "text",
            "line 3: the third line must be ASCII or BINARY",
        ),
        (
            "UNSTRUCTURED_GRID",
            "TABLE",
            "line 4: the dataset \"TABLE\" is not read",
        ),
        (
            "4 float",
            "5 float",
            "line 8: \"CELLS\" is not a number of type Float32 (after 12 of 15 values)",
        ),
        (
            "1 1 0\n",
            "1 1 x\n",
            "line 7: \"x\" is not a number of type Float32",
        ),
        (
            "4 float",
            "4 complex",
            "line 5: \"complex\" is not a type of values",
        ),
        ("3 11", "3 10", "line 8: CELLS has more values than"),
        (
            "POINTS 4",
            "POINTS 3",
            "line 5: POINTS has more values than",
        ),
        ("3 11", "3 99999999999", "values are needed"),
        (
            "2 1 3",
            "2 1 4",
            "line 8: a cell has node 4; the file has 4 nodes",
        ),
        (
            "2 1 3",
            "9 1 3",
            "line 8: cell 2 goes beyond the 11 entries",
        ),
        (
            "CELL_TYPES 3\n8 3 3",
            "CELL_TYPES 2\n8 3",
            "2 types for 3 cells",
        ),
        (
            "8 3 3",
            "8 3 5",
            "line 8: cell 2 is a triangle with 2 nodes; it must have 3",
        ),
        ("8 3 3", "8 3 44", "line 12: cell 2 has the VTK type 44"),
        (
            "CELL_TYPES",
            "CELL_DATA 4\nCELL_TYPES",
            "line 12: the data are for 4 cells, but there are 3",
        ),
    ];
    for (from, to, expected) in cases {
        let message = error(SQUARE.replacen(from, to, 1).as_bytes());
        assert!(message.contains(expected), "{message} / {expected}");
    }
    let mut bytes = Vec::new();
    let written = VTK51.write_file(&rich_mesh().view(), &mut bytes, &WriteOptions::default());
    written.expect("it can be written");
    assert!(
        error(&bytes[..500]).contains("byte "),
        "{}",
        error(&bytes[..500])
    );
}

#[test]
fn an_array_of_more_components_than_values_is_refused() {
    for names in ["", "METADATA\nCOMPONENT_NAMES\nx\n\n"] {
        let file = format!(
            "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\n\
             a 300000000000 0 double\n\n{names}POINTS 1 double\n0 0 0\n"
        );
        let source = Source::from_bytes(std::path::Path::new("<memory>"), file.into_bytes());
        let read = crate::formats::read(&source.into(), &ReadOptions::default());
        assert!(read.is_err());
    }
}
