//! Which format a name, a file or a folder is of.

use super::{
    FORMATS, Format, Location, Source, foreign, with_flavours, without_compression, written,
};
use azimesh_core::error::{Error, Result, option};
use std::path::Path;

/// The format that is written in pieces.
pub fn in_pieces() -> &'static dyn Format {
    let found = FORMATS.iter().find(|format| format.is_in_pieces());
    *found.expect("one format has pieces")
}

/// The format with this name.
pub fn by_name(name: &str) -> Result<&'static dyn Format> {
    with_flavours()
        .find(|format| format.name() == name)
        .ok_or_else(|| {
            let known = with_flavours().map(|format| format.name());
            let known = known.collect::<Vec<_>>().join(", ");
            Error::input(format!(
                "format \"{name}\" is not known; known formats: {known}"
            ))
        })
}

/// The format for a file name, for writing.
pub fn by_extension(path: &Path) -> Result<&'static dyn Format> {
    if path.as_os_str() == "-" {
        return Err(Error::input(format!(
            "standard output has no file name to tell the format; give {}",
            option("format")
        )));
    }
    let name = file_name(path);
    let inside = without_compression(&name);
    let of_case = || {
        let mut all = FORMATS.iter().copied();
        all.find(|format| format.case().is_some_and(|case| case.is_case(path)))
    };
    let format = with_extension(&name).or_else(of_case);
    if let Some(format) = format.filter(|format| !format.is_written()) {
        return Err(read_only(format.title()).file(path));
    }
    format.ok_or_else(|| {
        if inside != name && with_extension(inside).is_some() {
            return Error::input(format!(
                "compressed files are read but not written; write {inside} and compress it"
            ))
            .file(path);
        }
        let mut known = written()
            .map(|format| format!(".{}", format.extensions()[0]))
            .collect::<Vec<_>>();
        known.dedup();
        let known = known.join(", ");
        Error::input(format!(
            "the file name does not tell the format; known endings: {known}"
        ))
        .file(path)
    })
}

/// Refuses to write a format.
pub(super) fn read_only(title: &str) -> Error {
    let names = |surfaces: bool| {
        let formats = written().filter(|format| format.is_surface() == surfaces);
        let names: Vec<&str> = formats.map(|format| format.name()).collect();
        names.join(", ")
    };
    Error::input(format!(
        "{title} is read, not written; formats that are written: {}; of surfaces alone: {}",
        names(false),
        names(true)
    ))
}

/// The format, where meshes are written in it.
pub fn to_write(format: &'static dyn Format) -> Result<&'static dyn Format> {
    match format.is_written() {
        true => Ok(format),
        false => Err(read_only(format.title())),
    }
}

/// Whether the ending of a file name is that of a format that is only read.
pub fn is_only_read(path: &Path) -> bool {
    with_extension(&file_name(path)).is_some_and(|format| !format.is_written())
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn with_extension(name: &str) -> Option<&'static dyn Format> {
    let name = name.to_ascii_lowercase();
    let matches = |extension: &&&str| {
        let stem = name.strip_suffix(**extension);
        stem.is_some_and(|stem| stem.ends_with('.'))
    };
    let length = |format: &&dyn Format| {
        let extensions = format.extensions().iter();
        extensions.filter(matches).map(|e| e.len()).max()
    };
    let (_, format) = with_flavours()
        .filter_map(|format| Some((length(&format)?, format)))
        .rev()
        .max_by_key(|(length, _)| *length)?;
    Some(format)
}

/// A file name without the extensions of compression and format, which the files of one case share. The whole name
/// where its extension is not that of a format.
pub fn case_name(name: &str) -> &str {
    let inside = without_compression(name);
    let from = |extension: &str| inside.len().checked_sub(extension.len() + 1);
    let extensions = with_flavours().flat_map(|format| format.extensions());
    let starts = extensions.filter_map(|extension| {
        let start = from(extension)?;
        let ending = inside.get(start..)?.strip_prefix('.')?;
        ending.eq_ignore_ascii_case(extension).then_some(start)
    });
    starts.min().map_or(name, |start| &inside[..start])
}

/// The format of a file or folder by its content.
pub fn recognize(location: &Location) -> Option<&'static dyn Format> {
    with_flavours().find(|format| format.recognizes(location))
}

/// The format of a file or folder, by its content or, where that does not tell, by its name.
pub fn of(location: &Location) -> Result<&'static dyn Format> {
    let by_name = || with_extension(without_compression(&file_name(location.path())));
    match recognize(location) {
        Some(format) => Ok(format),
        None => by_name().ok_or_else(|| match location.file() {
            Ok(source) => foreign::refusal(source).unwrap_or_else(|| unknown_content(source)),
            Err(folder) => folder,
        }),
    }
}

fn unknown_content(source: &Source) -> Error {
    let titles = with_flavours()
        .map(|format| format.title())
        .collect::<Vec<_>>()
        .join(", ");
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
