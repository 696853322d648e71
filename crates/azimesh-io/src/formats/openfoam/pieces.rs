//! A file of the mesh at some time, written once for the whole or, where the mesh is written in the pieces of a decomposed
//! case, for each of them: in the folder of the piece, or as a block of a collated file.

use super::place::Place;
use super::points::{Header, is_binary};
use super::topology::{StoredPiece, StoredPieces};
use crate::formats::records::write_all;
use crate::formats::{OutputSet, WriteOptions};
use azimesh_core::error::Result;
use std::io::Write;

/// What a file is called and what its header says.
pub(super) struct Named<'a> {
    /// Path in the folder of the case or of a piece.
    pub path: &'a str,
    /// Class of what is in it, such as `vectorField`.
    pub class: &'a str,
    /// Folder that the header tells.
    pub location: &'a str,
    /// Name that the header tells.
    pub object: &'a str,
}

/// Writes what follows the header, of a piece or of the whole.
pub(super) type Content<'a> = &'a dyn Fn(&mut dyn Write, Option<&StoredPiece>) -> Result<()>;

/// Writes a file of the whole or of every piece.
pub(super) fn write(
    out: &mut OutputSet,
    place: &Place,
    named: &Named,
    options: &WriteOptions,
    content: Content,
) -> Result<()> {
    let header = named.header(named.class, is_binary(options));
    let with_header = |out: &mut dyn Write, piece: Option<&StoredPiece>| {
        write_all(out, header.as_bytes())?;
        content(out, piece)
    };
    if place.pieces.is_empty() {
        return out.in_folder(&place.case, named.path, |out| with_header(out, None));
    }
    for folder in place.pieces {
        let path = format!("{}/{}", folder.folder, named.path);
        out.in_folder(&place.case, &path, |out| match folder.is_collated {
            true => collated(out, folder, named, &header, content),
            false => {
                let mut pieces = folder.pieces.iter();
                pieces.try_for_each(|piece| with_header(out, Some(piece)))
            }
        })?;
    }
    Ok(())
}

/// A block for each piece, behind its number of bytes; the first has the header of all.
fn collated(
    out: &mut dyn Write,
    folder: &StoredPieces,
    named: &Named,
    header: &str,
    content: Content,
) -> Result<()> {
    write_all(out, named.header("decomposedBlockData", true).as_bytes())?;
    let mut block = Vec::new();
    for (i, piece) in folder.pieces.iter().enumerate() {
        block.clear();
        if i == 0 {
            block.extend_from_slice(header.as_bytes());
        }
        content(&mut block, Some(piece))?;
        let before = format!("\n// Processor{i}\n\n{}\n(", block.len());
        write_all(out, before.as_bytes())?;
        write_all(out, &block)?;
        write_all(out, b")\n")?;
    }
    Ok(())
}

impl Named<'_> {
    fn header(&self, class: &str, is_binary: bool) -> String {
        let header = Header {
            class,
            location: self.location,
            object: self.object,
            note: None,
        };
        header.text(is_binary)
    }
}
