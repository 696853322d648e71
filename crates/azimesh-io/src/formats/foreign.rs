//! Files that are no mesh that is read, whatever they are called: what they are, and what to do with them.

use super::hdf5::cut_off;
use super::source::Source;
use azimesh_core::error::Error;

/// An error that names what a file is, where it is of a kind that is often given by mistake.
pub(super) fn refusal(source: &Source) -> Option<Error> {
    let named = kind(source.bytes()).map(Error::input);
    let error = named.or_else(|| cut_off(source.bytes()))?;
    Some(error.file(source.path()))
}

fn kind(bytes: &[u8]) -> Option<&'static str> {
    let found = match bytes {
        [b'P', b'K', 3 | 5, 4 | 6, ..] => {
            "this is a zip archive; unpack it and give the mesh in it"
        }
        [b'B', b'Z', b'h', b'1'..=b'9', b'1', b'A', b'Y', b'&', ..] => {
            "this is a bzip2 file; gzip, xz and zstd are read, so decompress it (bunzip2)"
        }
        [b'7', b'z', 0xbc, 0xaf, ..] => "this is a 7z archive; unpack it and give the mesh in it",
        _ if bytes.get(257..262) == Some(b"ustar") => {
            "this is a tar archive; unpack it (tar xf) and give the mesh in it"
        }
        _ if is_utf16(bytes) => "this is UTF-16 text; save it as UTF-8 (iconv -f UTF-16 -t UTF-8)",
        _ => return None,
    };
    Some(found)
}

fn is_utf16(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(64)];
    let is_text = |at: usize| {
        let pairs = head.chunks_exact(2);
        pairs.len() >= 8
            && pairs
                .clone()
                .all(|pair| pair[1 - at] == 0 && pair[at].is_ascii() && pair[at] != 0)
    };
    match head {
        [0xff, 0xfe, rest @ ..] | [0xfe, 0xff, rest @ ..] => {
            rest.len() >= 2 && rest[..rest.len().min(16)].contains(&0)
        }
        _ => is_text(0) || is_text(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn archives_and_wide_text_are_named() {
        let wide = |text: &str, low: usize| -> Vec<u8> {
            let pairs = text.bytes().map(|b| if low == 0 { [b, 0] } else { [0, b] });
            pairs.flatten().collect()
        };
        let text = "NDIME= 2\nNELEM= 1\n";
        let mut tar = vec![0; 512];
        tar[257..262].copy_from_slice(b"ustar");
        let cases: [(&str, Vec<u8>); 7] = [
            ("zip", b"PK\x03\x04\x14\0".to_vec()),
            ("bzip2", b"BZh91AY&SY".to_vec()),
            ("7z", b"7z\xbc\xaf\x27\x1c".to_vec()),
            ("tar", tar),
            ("UTF-16", [b"\xff\xfe".to_vec(), wide(text, 0)].concat()),
            ("UTF-16", [b"\xfe\xff".to_vec(), wide(text, 1)].concat()),
            ("UTF-16", wide(text, 0)),
        ];
        for (what, bytes) in cases {
            let source = Source::from_bytes(std::path::Path::new("m.su2"), bytes);
            let told = refusal(&source)
                .unwrap_or_else(|| panic!("{what} is not seen"))
                .to_string();
            assert!(
                told.starts_with("m.su2: this is ") && told.contains(what),
                "{told}"
            );
        }
        for mesh in [
            text.as_bytes(),
            b"",
            b"$MeshFormat\n",
            b"\xff\xfe",
            &[0; 200],
        ] {
            let source = Source::from_bytes(std::path::Path::new("m"), mesh.to_vec());
            assert!(refusal(&source).is_none(), "{mesh:?}");
        }
    }
}
