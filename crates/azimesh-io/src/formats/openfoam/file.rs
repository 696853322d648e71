//! One file of OpenFOAM: opened, decompressed, its header read; the blocks of a collated file; single entries of
//! dictionaries.

use super::text::Text;
use crate::formats::Source;
use crate::formats::by_faces::Labels;
use crate::formats::names::decoded;
use crate::formats::source::check_file;
use azimesh_core::error::{Error, Result};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file, or the block of one piece in a collated file.
#[derive(Clone)]
pub(super) struct FoamFile {
    /// Bytes on the disk.
    pub stored: Source,
    content: Source,
    /// Content of its header.
    pub header: Header,
    /// Bytes after the header.
    body: Range<usize>,
}

impl FoamFile {
    pub fn open(path: &Path) -> Result<Self> {
        check_file(path).map_err(|error| Error::io(path, &error))?;
        Self::of(Source::stored(path)?)
    }

    pub fn of(stored: Source) -> Result<Self> {
        let content = stored.content();
        let content = content.map_err(|error| error.dataset("compressed data"))?;
        let mut text = Text::new(content.bytes(), 0);
        let header = Header::read(&mut text).and_then(|header| {
            header.ok_or_else(|| {
                text.error("the file has no header (FoamFile), so it is none of OpenFOAM")
            })
        });
        Ok(Self {
            header: header.map_err(|error| error.file(stored.path()))?,
            body: text.at..text.bytes.len(),
            stored,
            content,
        })
    }

    /// The text after the header. Errors have the byte if lists are binary.
    pub fn text(&self) -> Text<'_> {
        let content = &self.content.bytes()[..self.body.end];
        Text {
            is_binary: self.header.is_binary,
            ..Text::new(content, self.body.start)
        }
    }

    /// The labels in these bytes, where they are as the machine has them.
    pub fn labels(&self, bytes: Range<usize>) -> Labels {
        Labels::stored(self.content.clone(), bytes)
    }

    /// Lets go of the memory of a file that has been read.
    pub fn release(&self) {
        self.content.release();
    }

    pub fn path(&self) -> &Path {
        self.stored.path()
    }

    /// A result with the path in its error.
    pub fn checked<T>(&self, result: Result<T>) -> Result<T> {
        result.map_err(|error| self.refuse(error))
    }

    /// An error with the path.
    pub fn refuse(&self, error: Error) -> Error {
        error.file(self.path())
    }

    /// The blocks of a collated file, one for each piece. All have the header of the first that has none of their own.
    pub fn blocks(&self) -> Result<Vec<Self>> {
        self.checked(self.blocks_in())
    }

    fn blocks_in(&self) -> Result<Vec<Self>> {
        const CLASS: &str = "decomposedBlockData";
        let mut text = self.text();
        text.is_binary = true;
        if self.header.class != CLASS {
            return Err(text.error(format!(
                "the class is \"{}\"; in a collated folder it must be {CLASS}",
                self.header.class
            )));
        }
        let mut blocks: Vec<Self> = Vec::new();
        while text.peek().is_some() {
            let n = text.integer("the number of bytes of a block")?;
            text.expect(b'(', "before a block")?;
            let start = text.at;
            let end = usize::try_from(n).ok().and_then(|n| start.checked_add(n));
            let is_whole = |end: &usize| text.bytes.get(*end) == Some(&b')');
            let end = end.filter(is_whole).ok_or_else(|| {
                text.error(format!(
                    "the block of {n} bytes does not end at a closing bracket: the file is cut off or damaged"
                ))
            })?;
            let mut block = Text::new(&text.bytes[..end], start);
            let header = Header::read(&mut block)?;
            let header = header.or_else(|| blocks.first().map(|first| first.header.clone()));
            blocks.push(Self {
                header: header
                    .ok_or_else(|| block.error("the first block has no header (FoamFile)"))?,
                body: block.at..end,
                ..self.clone()
            });
            text.at = end + 1;
        }
        if blocks.is_empty() {
            let message = "the file has no block of any piece: it is cut off or damaged";
            return Err(text.error(message));
        }
        Ok(blocks)
    }
}

/// The path of a file that is there, compressed or not.
pub(super) fn path_of(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut paths = ["", ".gz"]
        .map(|ending| folder.join(format!("{name}{ending}")))
        .into_iter();
    paths.find(|path| path.is_file())
}

/// Content of the header of a file, `FoamFile { ... }`.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Header {
    /// Class of the content: `vectorField`, `faceCompactList` ...
    pub class: String,
    /// Lists are binary.
    pub is_binary: bool,
    /// Storage of binary numbers.
    pub layout: Layout,
}

/// Storage of binary numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layout {
    /// Bytes of a label, the likeliest first.
    pub labels: [usize; 2],
    /// Bytes of a scalar, the likeliest first.
    pub scalars: [usize; 2],
    /// Highest byte first.
    pub is_big_endian: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            labels: [4, 8],
            scalars: [8, 4],
            is_big_endian: false,
        }
    }
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
            let value = decoded(unquoted(start.value()?));
            match (key, &*value) {
                (b"class", _) => header.class = value.into_owned(),
                (b"arch", _) => header.layout = Layout::of(&value),
                (b"format", "ascii") => header.is_binary = false,
                (b"format", "binary") => header.is_binary = true,
                (b"format", other) => {
                    let message = format!("the format is \"{other}\"; it must be ascii or binary");
                    return Err(start.error_at(place, message));
                }
                _ => {}
            }
        }
        *text = start;
        Ok(Some(header))
    }
}

impl Layout {
    /// The storage of an entry such as `LSB;label=32;scalar=64`. What it does not have is as usual.
    fn of(arch: &str) -> Self {
        let mut layout = Self {
            is_big_endian: arch.trim_start().starts_with("MSB"),
            ..Self::default()
        };
        for part in arch.split(';').rev() {
            match part
                .trim()
                .split_once('=')
                .map(|(of, bits)| (of, bits.trim()))
            {
                Some(("label", "64")) => layout.labels = [8, 4],
                Some(("label", _)) => layout.labels = [4, 8],
                Some(("scalar", "32")) => layout.scalars = [4, 8],
                Some(("scalar", _)) => layout.scalars = [8, 4],
                _ => {}
            }
        }
        layout
    }
}

/// A value without the quotes around it.
fn unquoted(value: &[u8]) -> &[u8] {
    let inside = value
        .strip_prefix(b"\"")
        .and_then(|rest| rest.strip_suffix(b"\""));
    inside.unwrap_or(value)
}

/// The value of an entry of a dictionary such as `system/controlDict`; entries in braces, directives and what cannot be
/// read are passed over.
pub(super) fn entry_of(bytes: &[u8], key: &str) -> Option<String> {
    let mut text = Text::new(bytes, 0);
    let mut found = None;
    while let Some(byte) = text.peek() {
        match byte {
            b'{' => drop(text.value().ok()?),
            // A directive takes its line.
            b'#' => {
                let rest = text.rest();
                text.at += memchr::memchr(b'\n', rest).unwrap_or(rest.len());
            }
            b';' | b'}' | b')' | b'(' | b'[' | b']' => text.at += 1,
            _ => {
                let word = text.word("a key").ok()?;
                if !matches!(text.peek(), Some(b'{') | None) {
                    let value = text.value().ok()?;
                    if word == key.as_bytes() {
                        found = Some(decoded(unquoted(value)).into_owned());
                    }
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_says_what_the_file_holds() {
        let text = b"/* banner */\nFoamFile\n{\n format binary; class labelList; // c\n arch \"MSB;label=64;scalar=32\";\n meta { names 1 (a); }\n}\n7";
        let mut text = Text::new(text, 0);
        let header = Header::read(&mut text).expect("a good one").expect("one");
        assert!(header.is_binary && header.layout.is_big_endian);
        assert_eq!(header.class, "labelList");
        let layout = header.layout;
        assert_eq!([layout.labels[0], layout.scalars[0]], [8, 4]);
        assert_eq!(text.integer("what follows").expect("7"), 7);
        let mut none = Text::new(b"12(", 0);
        assert_eq!(Header::read(&mut none).expect("no error"), None);
    }

    #[test]
    fn an_entry_is_found_beside_directives_and_dictionaries() {
        let text = b"#include \"x\"\nfunctions { timePrecision 3; }\nlibs (\"a.so\" \"b.so\");\n\
            application pimpleFoam; timePrecision 8; // 9\n";
        assert_eq!(entry_of(text, "timePrecision").as_deref(), Some("8"));
        assert_eq!(entry_of(text, "startTime"), None);
    }
}
