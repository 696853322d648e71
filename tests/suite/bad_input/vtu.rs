//! What is wrong in VTU files, with its place.

use super::good::Good;
use super::{Wrong, dataset, line, refusal, refused};
use azimesh_io::formats::vtu::VTU;
use azimesh_io::formats::{Notes, ReadOptions, Source};

/// Padding is right for base64, but leaves fewer bytes than the header or the blocks have.
#[test]
fn base64_padded_too_early_is_refused_with_a_place() {
    let all = Good::all();
    let mut refused = 0;
    let is_base64 = |file: &&Good| {
        let has = |text: &str| memchr::memmem::find(&file.bytes, text.as_bytes()).is_some();
        file.format.name == "vtu" && (has("base64") || has("format=\"binary\""))
    };
    for file in all.files[all.own].iter().filter(is_base64) {
        // Every third: all places of a group of four.
        for at in (0..file.bytes.len() - 1).step_by(3) {
            let mut bytes = file.bytes.clone();
            bytes[at..at + 2].copy_from_slice(b"==");
            refused += usize::from(!file.check(&bytes, &at).unwrap());
        }
    }
    assert!(refused > 100, "only {refused}");
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
    let points = || dataset("Points");
    let wrong: [Wrong; 10] = [
        ("0 1 0<", "0 1<", points(), &["8", "3", "Float32"]),
        ("0 1 0<", "0 1 0 5<", points(), &["10", "3"]),
        ("0 1 0<", "0 1 0 5 5 5<", points(), &["12", "3"]),
        ("7 8", "7 8 9", dataset("i"), &["3", "2"]),
        ("1 0 0", "1 nan 0", line(6), &["node 1", "NaN"]),
        (">5<", ">99<", dataset("types"), &["0", "99"]),
        (">5<", "><", dataset("types"), &["0", "1"]),
        (
            "Points=\"3\"",
            "Points=\"4000000000\"",
            points(),
            &["4000000000"],
        ),
        (
            "Cells=\"1\"",
            "Cells=\"18446744073709551615\"",
            dataset("types"),
            &[],
        ),
        (
            "Components=\"3\"",
            "Components=\"9223372036854775807\"",
            points(),
            &[],
        ),
    ];
    refused(&VTU, TRIANGLE, &wrong);
}

#[test]
fn raw_data_of_fewer_bytes_than_a_value_has_is_refused() {
    let appended = "<AppendedData encoding=\"raw\">_\u{4}\0\0\0abcd</AppendedData></VTKFile>";
    let file = TRIANGLE
        .replace(
            "\"offsets\">3</DataArray>",
            "\"offsets\" format=\"appended\" offset=\"0\"/>",
        )
        .replace("</VTKFile>", appended);
    let error = refusal(&VTU, file.as_bytes());
    assert_eq!(error.position, Some(dataset("offsets")), "{error}");
}

#[test]
fn an_array_of_too_many_tuples_is_left_out_of_text_too() {
    let file = TRIANGLE.replace("7 8", "7 8 9 10").into_bytes();
    let source = Source::from_bytes("long.vtu".as_ref(), file);
    let mut notes = Notes::default();
    let mesh = VTU.read_file(&source, &ReadOptions::default(), &mut notes);
    assert!(mesh.expect("a good file").cell_arrays.is_empty());
    let mut found = notes.iter();
    let is_noted = found.any(|note| note.code == "array_too_long" && note.get("name") == "i");
    assert!(is_noted, "{notes:?}");
}
