//! The format of a name, a file or a folder.

use super::{FORMATS, Format, Location, Source, hdf5, without_compression};
use azimesh_core::error::{Error, Result, option};
use std::path::Path;

/// The format that is written in pieces.
pub fn in_pieces() -> &'static Format {
    let found = all().find(|format| format.is_in_pieces);
    found.expect("one format has pieces")
}

fn all() -> impl DoubleEndedIterator<Item = &'static Format> + Clone {
    FORMATS.iter().copied()
}

/// Formats that are written.
pub fn written() -> impl DoubleEndedIterator<Item = &'static Format> + Clone {
    all().filter(|format| format.is_written())
}

/// Words with commas between them.
fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.collect::<Vec<_>>().join(", ")
}

/// The format with this name.
pub fn by_name(name: &str) -> Result<&'static Format> {
    all().find(|format| format.name == name).ok_or_else(|| {
        let known = listed(all().map(|format| format.name));
        Error::input(format!(
            "format \"{name}\" is not known; known formats: {known}"
        ))
    })
}

/// The format for a file name, for writing.
pub fn by_extension(path: &Path) -> Result<&'static Format> {
    if path.as_os_str() == "-" {
        return Err(Error::input(format!(
            "standard output has no file name from which to choose the format; give {}",
            option("format")
        )));
    }
    let name = file_name(path);
    let inside = without_compression(&name);
    let is_case = |format: &&Format| format.case.is_some_and(|case| case.is_case(path));
    if let Some(format) = with_extension(&name).or_else(|| all().find(is_case)) {
        return to_write(format).map_err(|error| error.file(path));
    }
    let message = if inside != name && with_extension(inside).is_some() {
        format!("compressed files are read but not written; write {inside} and compress it")
    } else {
        let mut known: Vec<&str> = written().map(|format| format.extensions[0]).collect();
        known.dedup();
        let known = known.join(", .");
        format!("the file name does not determine the format; known endings: .{known}")
    };
    Err(Error::input(message).file(path))
}

/// Refuses to write a format.
pub(super) fn read_only(title: &str) -> Error {
    let names = |surfaces: bool| {
        let formats = written().filter(|format| format.is_surface == surfaces);
        listed(formats.map(|format| format.name))
    };
    Error::input(format!(
        "{title} is read, not written; formats that are written: {}; of surfaces alone: {}",
        names(false),
        names(true)
    ))
}

/// The format, where meshes are written in it.
pub fn to_write(format: &'static Format) -> Result<&'static Format> {
    let written = format.is_written().then_some(format);
    written.ok_or_else(|| read_only(format.title))
}

/// Checks if a format with the ending of this file name is only read.
pub fn is_only_read(path: &Path) -> bool {
    with_extension(&file_name(path)).is_some_and(|format| !format.is_written())
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The name before a dot and this extension.
fn stem<'n>(name: &'n str, extension: &str) -> Option<&'n str> {
    let start = name.len().checked_sub(extension.len() + 1)?;
    let ending = name.get(start..)?.strip_prefix('.')?;
    ending
        .eq_ignore_ascii_case(extension)
        .then_some(&name[..start])
}

fn with_extension(name: &str) -> Option<&'static Format> {
    let length = |format: &Format| {
        let extensions = format.extensions.iter();
        let matching = extensions.filter(|extension| stem(name, extension).is_some());
        matching.map(|extension| extension.len()).max()
    };
    let lengths = all().filter_map(|format| Some((length(format)?, format)));
    let longest = lengths.rev().max_by_key(|(length, _)| *length);
    longest.map(|(_, format)| format)
}

/// A file name without the extensions of compression and format, which the files of one case share. The whole name
/// if no format has its extension.
pub fn case_name(name: &str) -> &str {
    let inside = without_compression(name);
    let extensions = all().flat_map(|format| format.extensions);
    let stems = extensions.filter_map(|extension| stem(inside, extension));
    stems.min_by_key(|stem| stem.len()).unwrap_or(name)
}

/// The format of a file or folder by its content.
pub fn recognize(location: &Location) -> Option<&'static Format> {
    all().find(|format| format.recognizes(location))
}

/// The format of a file or folder, by its content or, if that is ambiguous, by its name.
pub fn of(location: &Location) -> Result<&'static Format> {
    let by_name = || with_extension(without_compression(&file_name(location.path())));
    recognize(location).or_else(by_name).ok_or_else(|| {
        location.file().map_or_else(
            |folder| folder,
            |source| refusal(source).unwrap_or_else(|| unknown_content(source)),
        )
    })
}

fn unknown_content(source: &Source) -> Error {
    if stem(&file_name(source.path()), "toml").is_some() {
        let message = "this is a TOML file, such as a motion schedule; a mesh belongs here";
        return Error::input(message).file(source.path());
    }
    let titles = listed(all().map(|format| format.title));
    let found = match source.bytes() {
        [] => "the file is empty".to_owned(),
        bytes => {
            let head: Vec<u8> = bytes.iter().copied().take(24).collect();
            format!("it starts with \"{}\"", head.escape_ascii())
        }
    };
    Error::input(format!(
        "the mesh format is not known: {found}; known formats: {titles}"
    ))
    .file(source.path())
}

/// An error that names what a file is, where it is of a kind that is often given by mistake.
pub(super) fn refusal(source: &Source) -> Option<Error> {
    let named = kind(source.bytes()).map(Error::input);
    let error = named.or_else(|| hdf5::cut_off(source.bytes()))?;
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
