//! Text in braces: the header of a file, the patches in `boundary`, and single entries of other dictionaries.

use super::text::Text;
use super::topology::Patch;
use crate::formats::names::decoded;
use azimesh_core::error::{Error, Result};

/// What the header of a file says, `FoamFile { ... }`.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Header {
    /// What the file holds: `vectorField`, `faceCompactList` ...
    pub class: String,
    /// Whether lists are binary.
    pub is_binary: bool,
    /// How its numbers are stored, where it says so: `LSB;label=32;scalar=64`.
    pub arch: Option<String>,
}

impl Header {
    /// Reads the header; leaves the text after it. `None` where there is none.
    pub fn read(text: &mut Text) -> Result<Option<Self>> {
        let mut start = text.clone();
        if !matches!(start.peek(), Some(b'F')) || start.word("a header")? != b"FoamFile" {
            return Ok(None);
        }
        start.expect(b'{', "after FoamFile")?;
        let mut header = Self::default();
        while !start.take(b'}') {
            let place = start.at;
            let key = start.word("an entry of the header")?;
            if start.peek() == Some(b'{') {
                start.braces()?;
                continue;
            }
            let value = decoded(unquoted(start.value()?)).into_owned();
            match key {
                b"class" => header.class = value,
                b"arch" => header.arch = Some(value),
                b"format" => {
                    header.is_binary = match value.as_str() {
                        "ascii" => false,
                        "binary" => true,
                        other => {
                            return Err(start.error_at(
                                place,
                                format!("the format is \"{other}\"; it must be ascii or binary"),
                            ));
                        }
                    }
                }
                _ => {}
            }
        }
        *text = start;
        Ok(Some(header))
    }

    /// Whether numbers have their highest byte first.
    pub fn is_big_endian(&self) -> bool {
        let arch = self.arch.as_deref().unwrap_or_default();
        arch.trim_start().starts_with("MSB")
    }

    /// Bytes of a `label` or `scalar`, where the header says it.
    pub fn width(&self, of: &str) -> Option<usize> {
        let parts = self.arch.as_deref()?.split(';');
        let mut bits = parts.filter_map(|part| part.trim().strip_prefix(of)?.strip_prefix('='));
        match bits.next()?.trim() {
            "32" => Some(4),
            "64" => Some(8),
            _ => None,
        }
    }
}

/// A value without the quotes around it.
fn unquoted(value: &[u8]) -> &[u8] {
    let inside = value
        .strip_prefix(b"\"")
        .and_then(|rest| rest.strip_suffix(b"\""));
    inside.unwrap_or(value)
}

/// The patches in `boundary`, after its header.
pub(super) fn patches(text: &mut Text) -> Result<Vec<Patch>> {
    let n = match text.peek() {
        Some(byte) if byte.is_ascii_digit() => Some(text.integer("the number of patches")?),
        _ => None,
    };
    text.expect(b'(', "before the patches")?;
    let mut patches = Vec::new();
    while !text.take(b')') {
        patches.push(patch(text)?);
    }
    match n {
        Some(n) if usize::try_from(n) != Ok(patches.len()) => Err(text.error(format!(
            "the number of patches is given as {n}, but there are {}",
            patches.len()
        ))),
        _ => Ok(patches),
    }
}

fn patch(text: &mut Text) -> Result<Patch> {
    text.skip();
    let place = text.at;
    let name = text.word("the name of a patch")?;
    check_plain(text, place, name)?;
    let name = decoded(name).into_owned();
    text.expect(b'{', &format!("after the name of patch \"{name}\""))?;
    let mut entries = Vec::new();
    while !text.take(b'}') {
        entries.push(entry(text)?);
    }
    let number = |key: &str| {
        let value = value_of(&entries, key)
            .ok_or_else(|| text.error(format!("patch \"{name}\" has no {key}")))?;
        value.parse::<u32>().map(|n| n as usize).map_err(|_| {
            text.error(format!(
                "{key} of patch \"{name}\" is {value}; it must be a number of faces"
            ))
        })
    };
    let kind = value_of(&entries, "type")
        .ok_or_else(|| text.error(format!("patch \"{name}\" has no type")))?;
    Ok(Patch {
        kind: kind.to_owned(),
        n_faces: number("nFaces")?,
        start_face: number("startFace")?,
        name,
        entries,
    })
}

/// The last entry with this key counts.
fn value_of<'e>(entries: &'e [(String, String)], key: &str) -> Option<&'e str> {
    let mut entries = entries.iter().rev();
    let (_, value) = entries.find(|(known, _)| known == key)?;
    Some(value)
}

fn entry(text: &mut Text) -> Result<(String, String)> {
    text.skip();
    let place = text.at;
    let key = text.word("an entry of a patch")?;
    check_plain(text, place, key)?;
    let value = match text.peek() {
        Some(b'{') => text.braces()?,
        _ => {
            let place = text.at;
            let value = text.value()?;
            check_plain(text, place, value)?;
            value
        }
    };
    Ok((decoded(key).into_owned(), decoded(value).into_owned()))
}

/// Refuses directives and macros, whose meaning depends on other text.
fn check_plain(text: &Text, place: usize, found: &[u8]) -> Result<()> {
    let refuse = |what: &str| -> Error {
        let name = found.split(u8::is_ascii_whitespace).next();
        let name = decoded(name.unwrap_or_default()).into_owned();
        text.error_at(
            place,
            format!("{what} {name} is not followed; write what it stands for in its place"),
        )
    };
    match found.first() {
        Some(b'#') => Err(refuse("the directive")),
        Some(b'$') => Err(refuse("the macro")),
        _ => Ok(()),
    }
}

/// The value of an entry of a dictionary such as `system/controlDict`; entries in braces, directives and what cannot be
/// read are passed over.
pub(crate) fn entry_of(bytes: &[u8], key: &str) -> Option<String> {
    let mut text = Text::new(bytes, 0..bytes.len());
    let mut found = None;
    while let Some(byte) = text.peek() {
        match byte {
            b'{' => {
                text.braces().ok()?;
                continue;
            }
            // A directive takes its line.
            b'#' => {
                let rest = text.rest();
                text.at += memchr::memchr(b'\n', rest).unwrap_or(rest.len());
                continue;
            }
            b';' | b'}' | b')' | b'(' | b'[' | b']' => {
                text.at += 1;
                continue;
            }
            _ => {}
        }
        let word = text.word("a key").ok()?;
        if !matches!(text.peek(), Some(b'{') | None) {
            let value = text.value().ok()?;
            if word == key.as_bytes() {
                found = Some(decoded(unquoted(value)).into_owned());
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patches_in(text: &str) -> Result<Vec<Patch>> {
        patches(&mut Text::new(text.as_bytes(), 0..text.len()))
    }

    #[test]
    fn a_header_says_what_the_file_holds() {
        let text = b"/* banner */\nFoamFile\n{\n format binary; class labelList; // c\n arch \"MSB;label=64;scalar=32\";\n meta { names 1 (a); }\n}\n7";
        let mut text = Text::new(text, 0..text.len());
        let header = Header::read(&mut text).expect("a good one").expect("one");
        assert!(header.is_binary && header.is_big_endian());
        assert_eq!(header.class, "labelList");
        assert_eq!(
            [header.width("label"), header.width("scalar")],
            [Some(8), Some(4)]
        );
        assert_eq!(text.integer("what follows").expect("7"), 7);
        let mut none = Text::new(b"12(", 0..3);
        assert_eq!(Header::read(&mut none).expect("no error"), None);
    }

    #[test]
    fn patches_keep_their_entries_as_they_are() {
        let found = patches_in(
            "2\n(\n left { type cyclic; inGroups 1(cyclic); nFaces 4; startFace 10; neighbourPatch right; }\n\
             \"a b\" { type wall; extra { deep { x 1; } } nFaces 0; startFace 14; } )",
        );
        let found = found.expect("two patches");
        assert_eq!(found[0].kind, "cyclic");
        assert_eq!((found[0].n_faces, found[0].start_face), (4, 10));
        assert_eq!(found[0].entry("inGroups"), Some("1(cyclic)"));
        assert_eq!(found[0].entry("neighbourPatch"), Some("right"));
        assert_eq!(found[1].name, "a b");
        assert_eq!(found[1].entry("extra"), Some("{ deep { x 1; } }"));
        assert_eq!(found[1].n_faces, 0);
    }

    #[test]
    fn directives_and_macros_are_refused_by_name() {
        for (text, expected) in [
            (
                "(\n#include \"patches\"\n)",
                "line 2: the directive #include is not followed; write what it stands for in its place",
            ),
            (
                "(\na { type wall; nFaces $n; startFace 1; } )",
                "line 2: the macro $n is not followed; write what it stands for in its place",
            ),
            (
                "1 ( )",
                "line 1: the number of patches is given as 1, but there are 0",
            ),
            (
                "( a { type wall; nFaces 1; } )",
                "line 1: patch \"a\" has no startFace",
            ),
            (
                "( a { type wall; nFaces -1; startFace 0; } )",
                "line 1: nFaces of patch \"a\" is -1; it must be a number of faces",
            ),
        ] {
            let error = patches_in(text).expect_err("it is wrong").to_string();
            assert_eq!(error, expected);
        }
    }

    #[test]
    fn an_entry_is_found_beside_directives_and_dictionaries() {
        let text = b"#include \"x\"\nfunctions { timePrecision 3; }\nlibs (\"a.so\" \"b.so\");\n\
            application pimpleFoam; timePrecision 8; // 9\n";
        assert_eq!(entry_of(text, "timePrecision").as_deref(), Some("8"));
        assert_eq!(entry_of(text, "startTime"), None);
    }
}
