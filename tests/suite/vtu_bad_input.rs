//! Damaged .vtu files give an error with a place in the file, or a mesh; never a panic.

use azimesh::formats::vtu::Vtu;
use azimesh::formats::{
    Compression, Encoding, Format, Notes, Precision, ReadOptions, Source, WriteOptions, parse,
};
use azimesh::mesh::{CellKind, DataArray, Group, Mesh, Values};
use proptest::prelude::*;
use std::sync::LazyLock;

/// The same small mesh with tags, names, arrays and a polyhedron, written in every way.
static GOOD_FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let mesh = small_mesh();
    let mut files = Vec::new();
    for encoding in [Encoding::Raw, Encoding::Base64, Encoding::Ascii] {
        for compression in [
            Compression::None,
            Compression::Zlib,
            Compression::Lz4,
            Compression::Lzma,
        ] {
            let options = WriteOptions {
                pieces: None,
                encoding,
                compression,
                precision: Precision::F64,
                tag_names: true,
            };
            let mut bytes = Vec::new();
            Vtu.write_file(&mesh.view(), &mut bytes, &options)
                .expect("it can be written");
            files.push(bytes);
        }
    }
    files
});

fn small_mesh() -> Mesh {
    let mut mesh = Mesh {
        points: (0..9)
            .map(|i| [f64::from(i), 0.5, -f64::from(i * i)])
            .collect(),
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    mesh.cells.push(CellKind::Wedge, &[0, 1, 2, 3, 4, 5]);
    let stream = [4, 3, 5, 6, 7, 3, 5, 6, 8, 3, 6, 7, 8, 3, 5, 7, 8];
    mesh.cells.push_polyhedron(&stream).expect("a good stream");
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    for (dimension, name, cells) in [(2, "wall", 3..4), (3, "zone", 0..2)] {
        mesh.groups.push(Group {
            dimension,
            name: name.into(),
            number: Some(1),
            condition: None,
            cells: cells.collect(),
        });
    }
    mesh.point_arrays = vec![DataArray::scalar("p", Values::F32(vec![0.25; 9]))];
    mesh.cell_arrays = vec![DataArray::scalar("id", Values::I64(vec![-1, 2, 3, 4]))];
    mesh
}

/// Reads what may be damaged. What reads without error passes the checks or fails them in words.
fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    match parse(&Vtu, bytes, &ReadOptions::default()) {
        Ok(mesh) => drop(mesh.validate()),
        Err(error) => prop_assert!(error.position.is_some(), "no place: {error}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn random_bytes_are_refused_with_a_place(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(parse(&Vtu, &bytes, &ReadOptions::default()).is_err());
        check(&bytes)?;
        let xml = [b"<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece".as_slice(), &bytes];
        check(&xml.concat())?;
    }

    #[test]
    fn a_truncated_file_is_an_error_with_a_place(file in 0usize..12, part in 0.0f64..1.0) {
        let bytes = &GOOD_FILES[file];
        check(&bytes[..(bytes.len() as f64 * part) as usize])?;
    }

    #[test]
    fn flipped_bytes_never_panic(
        file in 0usize..12,
        flips in prop::collection::vec((0.0f64..1.0, 1u8..), 1..6),
    ) {
        let mut bytes = GOOD_FILES[file].clone();
        for (part, flip) in flips {
            let at = (bytes.len() as f64 * part) as usize;
            bytes[at] ^= flip;
        }
        check(&bytes)?;
    }

    #[test]
    fn changed_digits_never_panic(
        file in 0usize..12,
        changes in prop::collection::vec((any::<prop::sample::Index>(), b'0'..=b'9'), 1..4),
    ) {
        let mut bytes = GOOD_FILES[file].clone();
        let digits: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i].is_ascii_digit()).collect();
        for (index, digit) in changes {
            bytes[*index.get(&digits)] = digit;
        }
        check(&bytes)?;
    }
}

/// Padding is right for base64, but leaves fewer bytes than the header or the blocks have.
#[test]
fn base64_padded_too_early_is_refused_with_a_place() {
    let mut refused = 0;
    for file in GOOD_FILES.iter() {
        for at in 0..file.len() - 1 {
            let mut bytes = file.clone();
            bytes[at..at + 2].copy_from_slice(b"==");
            check(&bytes).expect("an error has a place");
            refused += usize::from(parse(&Vtu, &bytes, &ReadOptions::default()).is_err());
        }
    }
    assert!(refused > 100, "only {refused}");
}

#[test]
fn announced_sizes_that_the_file_cannot_hold_take_no_memory() {
    let huge = [
        ("NumberOfPoints=\"9\"", "NumberOfPoints=\"4000000000\""),
        (
            "NumberOfCells=\"4\"",
            "NumberOfCells=\"18446744073709551615\"",
        ),
        (
            "NumberOfComponents=\"3\"",
            "NumberOfComponents=\"9223372036854775807\"",
        ),
        ("offset=\"0\"", "offset=\"18446744073709551615\""),
    ];
    for file in GOOD_FILES.iter() {
        let text: Vec<u8> = file.clone();
        for (from, to) in huge {
            let Some(at) = memchr::memmem::find(&text, from.as_bytes()) else {
                continue;
            };
            let changed = [&text[..at], to.as_bytes(), &text[at + from.len()..]].concat();
            let error = parse(&Vtu, &changed, &ReadOptions::default());
            let error = error.expect_err("the size is wrong");
            assert!(error.position.is_some(), "{error}");
        }
    }
}

/// A triangle in text.
const TRIANGLE: &str = "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\">
<UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">
<CellData><DataArray type=\"Int32\" Name=\"i\" NumberOfComponents=\"2\">7 8</DataArray></CellData>
<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">
0 0 0
1 0 0
0 1 0</DataArray></Points>
<Cells><DataArray type=\"Int64\" Name=\"connectivity\">0 1 2</DataArray>
<DataArray type=\"Int64\" Name=\"offsets\">3</DataArray>
<DataArray type=\"UInt8\" Name=\"types\">5</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>";

#[test]
fn what_is_wrong_in_text_is_named_with_its_place() {
    for (right, wrong, refusal) in [
        (
            "0 1 0<",
            "0 1<",
            "Points: it has 8 values; it must have 3 tuples of 3 Float32",
        ),
        (
            "0 1 0<",
            "0 1 0 5<",
            "Points: it has 10 values, which is not a whole number of tuples of 3",
        ),
        (
            "0 1 0<",
            "0 1 0 5 5 5<",
            "Points: it has 12 values; it must have 3 tuples",
        ),
        ("7 8", "7 8 9", "i: it has 3 values; it must have 2 tuples"),
        ("1 0 0", "1 nan 0", "line 6: node 1 is at [1, NaN, 0]"),
        (
            ">5<",
            ">99<",
            "types: cell 0 has the VTK type 99, which is not read",
        ),
        (">5<", "><", "types: it has 0 values; it must have 1 tuple "),
    ] {
        let file = TRIANGLE.replace(right, wrong);
        let error = parse(&Vtu, file.as_bytes(), &ReadOptions::default());
        let error = error.expect_err("it is wrong").to_string();
        assert!(error.trim_start().starts_with(refusal), "{error}");
    }
}

#[test]
fn an_array_of_too_many_tuples_is_left_out_of_text_too() {
    let file = TRIANGLE.replace("7 8", "7 8 9 10").into_bytes();
    let source = Source::from_bytes("long.vtu".as_ref(), file);
    let mut notes = Notes::default();
    let mesh = Vtu.read_file(&source, &ReadOptions::default(), &mut notes);
    assert!(mesh.expect("a good file").cell_arrays.is_empty());
    let noted = "the cell array \"i\" is left out: it has more tuples";
    assert!(
        notes.iter().any(|note| note.to_string().starts_with(noted)),
        "{notes:?}"
    );
}
