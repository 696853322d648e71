//! Small files that announce huge sizes are refused in little memory.

use std::process::Command;

/// Address space the program may take, in kB: enough to run, not for the sizes announced.
const LIMIT: &str = "700000";

fn vtu(compressor: &str, points: u64, data: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\"{compressor}><UnstructuredGrid><Piece NumberOfPoints=\"{points}\" \
         NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" Name=\"Points\" \
         NumberOfComponents=\"3\" {data}</DataArray></Points><Cells><DataArray type=\"Int64\" \
         Name=\"connectivity\" format=\"ascii\">0</DataArray><DataArray type=\"Int64\" \
         Name=\"offsets\" format=\"ascii\">1</DataArray><DataArray type=\"UInt8\" Name=\"types\" \
         format=\"ascii\">1</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"
    )
}

/// Inline base64 of little-endian 64-bit numbers.
fn base64(numbers: &[u64]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let digits = |group: &[u8]| {
        let byte = |i: usize| u32::from(*group.get(i).unwrap_or(&0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        (0..4)
            .map(move |i| bits >> (18 - 6 * i) & 63)
            .collect::<Vec<_>>()
    };
    bytes
        .chunks(3)
        .flat_map(|group| {
            let shown = group.len() + 1;
            let text = digits(group).into_iter().enumerate();
            text.map(move |(i, digit)| {
                if i < shown {
                    char::from(DIGITS[digit as usize])
                } else {
                    '='
                }
            })
        })
        .collect()
}

fn huge_promises() -> Vec<(String, String)> {
    let billions = 4_000_000_000;
    let bytes = 24 * billions;
    let mut files = vec![
        (
            "ascii.vtu".into(),
            vtu("", billions, "format=\"ascii\">0 0 0"),
        ),
        (
            "a.su2".into(),
            "NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 99999999999\n0 0\n".into(),
        ),
        (
            "b.su2".into(),
            "NDIME= 2\nNELEM= 9223372036854775807\n5 0 1 2\n".into(),
        ),
        (
            "a.msh".into(),
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 99999999999 1 1\n2 1 0 99999999999\n"
                .into(),
        ),
        (
            "b.msh".into(),
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999\n1 0 0 0\n".into(),
        ),
    ];
    let raw = format!("format=\"binary\">{}", base64(&[bytes, 0, 0]));
    files.push(("raw.vtu".into(), vtu("", billions, &raw)));
    for name in ["ZLib", "LZ4", "LZMA"] {
        let compressor = format!(" compressor=\"vtk{name}DataCompressor\"");
        for (what, header) in [
            ("one", [1, bytes, 0, 16]),
            ("many", [1 << 40, 1 << 20, 0, 16]),
        ] {
            let data = format!("format=\"binary\">{}{}", base64(&header), base64(&[1, 2]));
            let file = vtu(&compressor, billions, &data);
            files.push((format!("{name}_{what}.vtu"), file));
        }
    }
    files
}

#[test]
fn sizes_that_a_file_cannot_hold_are_refused_in_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    let limited = format!("ulimit -v {LIMIT} && exec \"$0\" --threads 1 info \"$1\"");
    for (name, content) in huge_promises() {
        std::fs::write(folder.path().join(&name), content).unwrap();
        let output = Command::new("sh")
            .current_dir(folder.path())
            .args(["-c", &limited])
            .arg(assert_cmd::cargo::cargo_bin("azimesh"))
            .arg(&name)
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.starts_with(&format!("error: {name}:")), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}
