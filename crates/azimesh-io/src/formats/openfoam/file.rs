//! One file of OpenFOAM: opened, decompressed, its header read; the blocks of a collated file.

use super::dictionary::Header;
use super::text::Text;
use crate::formats::Source;
use crate::formats::by_faces::Labels;
use crate::formats::source::check_file;
use azimesh_core::error::{Error, Result};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file, or the block of one piece in a collated file.
#[derive(Clone)]
pub(super) struct FoamFile {
    /// As it is on the disk.
    pub stored: Source,
    /// Decompressed.
    content: Source,
    /// What its header says.
    pub header: Header,
    /// What comes after the header.
    body: Range<usize>,
}

impl FoamFile {
    /// Opens a file that is not compressed, or with `.gz` behind its name; `None` where there is neither.
    pub fn find(folder: &Path, name: &str) -> Result<Option<Self>> {
        match path_of(folder, name) {
            Some(path) => Self::open(&path).map(Some),
            None => Ok(None),
        }
    }

    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self> {
        check_file(path).map_err(|error| Error::io(path, &error))?;
        Self::of(Source::stored(path)?)
    }

    /// A file in memory.
    pub fn of(stored: Source) -> Result<Self> {
        let content = stored
            .content()
            .map_err(|error| error.dataset("compressed data"))?;
        let mut file = Self {
            header: Header::default(),
            body: 0..content.bytes().len(),
            stored,
            content,
        };
        let mut text = Text::new(file.content.bytes(), file.body.clone());
        let header = file.checked(Header::read(&mut text))?;
        let start = text.at;
        file.header = header.ok_or_else(|| {
            let refuse = text.error("the file has no header (FoamFile), so it is none of OpenFOAM");
            file.refuse(refuse)
        })?;
        file.body.start = start;
        Ok(file)
    }

    /// The text after the header. Errors tell the byte where lists are binary.
    pub fn text(&self) -> Text<'_> {
        Text {
            is_binary: self.header.is_binary,
            ..self.text_of(self.body.clone())
        }
    }

    fn text_of(&self, part: Range<usize>) -> Text<'_> {
        Text::new(self.content.bytes(), part)
    }

    /// The labels in these bytes, where they are as the machine has them.
    pub fn labels(&self, bytes: Range<usize>) -> Labels {
        Labels::stored(self.content.clone(), bytes)
    }

    /// Lets go of the memory of a file that has been read.
    pub fn release(&self) {
        self.content.release();
    }

    /// The path.
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
            let is_whole = |end: &usize| *end < text.end && text.bytes[*end] == b')';
            let end = end.filter(is_whole).ok_or_else(|| {
                text.error_at(
                    start,
                    format!("the block of {n} bytes does not end at a closing bracket: the file is cut off or damaged"),
                )
            })?;
            let mut block = self.text_of(start..end);
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
        match blocks.is_empty() {
            true => Err(text.error("the file has no block of any piece: it is cut off or damaged")),
            false => Ok(blocks),
        }
    }
}

/// The path of a file that is there, compressed or not.
pub(super) fn path_of(folder: &Path, name: &str) -> Option<PathBuf> {
    let plain = folder.join(name);
    if plain.is_file() {
        return Some(plain);
    }
    let packed = folder.join(format!("{name}.gz"));
    packed.is_file().then_some(packed)
}
