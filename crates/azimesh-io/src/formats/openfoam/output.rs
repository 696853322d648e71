//! Files of a case that are written: headers, and lists of numbers, binary in the machine's own order of bytes, or text.
//! A file at a time is written once for the whole or, where the mesh is written in the pieces of a decomposed case, for
//! each of them: in the folder of the piece, or as a block of a collated file.

use super::case::Place;
use super::topology::{StoredFile, StoredPiece, StoredPieces};
use crate::formats::records::{push_integer, push_real, write_all, write_records};
use crate::formats::{Encoding, Out, OutputSet, WriteOptions};
use azimesh_core::error::{Error, Result};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Writer of the files of a mesh in its case.
pub(super) struct CaseFiles<'a, 'b> {
    pub out: &'a mut OutputSet<'b>,
    pub place: &'a Place<'a>,
    /// Numbers are binary.
    pub is_binary: bool,
}

/// Writes what follows the header, of a piece or of the whole.
type Content<'a> = &'a dyn Fn(&mut dyn Write, Option<&StoredPiece>) -> Result<()>;

impl<'a, 'b> CaseFiles<'a, 'b> {
    /// Of a mesh at a place.
    pub fn new(out: &'a mut OutputSet<'b>, place: &'a Place<'a>, options: &WriteOptions) -> Self {
        Self {
            out,
            place,
            is_binary: options.encoding != Encoding::Ascii,
        }
    }

    /// Writes a file of the whole or of every piece, with its header: the class of its content, such as `vectorField`, and a
    /// remark. `path` is its path in the folder of the case or of a piece.
    pub fn write(&mut self, path: &str, class: &str, note: &str, content: Content) -> Result<()> {
        let is_binary = self.is_binary && class != "polyBoundaryMesh";
        let own = header(path, class, note, is_binary);
        let with_header = |out: &mut dyn Write, piece: Option<&StoredPiece>| {
            write_all(out, own.as_bytes())?;
            content(out, piece)
        };
        let place = self.place;
        if place.pieces.is_empty() {
            return self.raw(path, &mut |out| with_header(out, None));
        }
        for folder in place.pieces {
            self.raw(&format!("{}/{path}", folder.folder), &mut |out| {
                let mut pieces = folder.pieces.iter();
                if folder.is_collated {
                    let of_all = header(path, "decomposedBlockData", note, true);
                    return collated(out, &of_all, folder, &own, content);
                }
                pieces.try_for_each(|piece| with_header(out, Some(piece)))
            })?;
        }
        Ok(())
    }

    /// Writes points.
    pub fn points(&mut self, points: &[[f64; 3]], time: &str) -> Result<()> {
        let path = format!("{}/points", self.place.path.folder(time));
        let is_binary = self.is_binary;
        self.write(&path, "vectorField", "", &|out, piece| {
            vectors(out, points, piece, is_binary)
        })
    }

    /// Writes the bytes of a file that was read. The system refuses to write bytes of a mapped file beyond its end.
    pub fn stored(&mut self, folder: &str, file: &StoredFile) -> Result<()> {
        self.raw(&format!("{folder}/{}", file.name), &mut |out| {
            let written = write_all(out, file.stored.bytes());
            written.map_err(|error| file.stored.check_whole().err().unwrap_or(error))
        })
    }

    /// Copies a file. Errors name `named`.
    pub fn copy(&mut self, mut file: File, name: &str, named: &Path) -> Result<()> {
        self.raw(name, &mut |out| {
            let copied = io::copy(&mut file, out).map(|_| ());
            copied.map_err(|error| Error::io(named, &error))
        })
    }

    /// Writes a file, by its path in the case.
    pub fn raw(
        &mut self,
        name: &str,
        write: &mut dyn FnMut(&mut dyn Out) -> Result<()>,
    ) -> Result<()> {
        self.out.in_folder(&self.place.path.root, name, write)
    }

    /// Writes the empty file by which ParaView opens a case, unless it is there.
    pub fn mark(&mut self, name: &str) -> Result<()> {
        if self.place.path.root.join(name).exists() {
            return Ok(());
        }
        self.raw(name, &mut |_| Ok(()))
    }
}

/// Writes a block for each piece, behind its number of bytes; the first has the header `own`.
fn collated(
    out: &mut dyn Write,
    of_all: &str,
    folder: &StoredPieces,
    own: &str,
    content: Content,
) -> Result<()> {
    write_all(out, of_all.as_bytes())?;
    let mut block = own.as_bytes().to_vec();
    for (i, piece) in folder.pieces.iter().enumerate() {
        content(&mut block, Some(piece))?;
        let before = format!("\n// Processor{i}\n\n{}\n(", block.len());
        write_all(out, before.as_bytes())?;
        write_all(out, &block)?;
        write_all(out, b")\n")?;
        block.clear();
    }
    Ok(())
}

fn header(path: &str, class: &str, note: &str, is_binary: bool) -> String {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    let (format, arch) = match (is_binary, cfg!(target_endian = "little")) {
        (false, _) => ("ascii", ""),
        (true, true) => ("binary", "    arch        \"LSB;label=32;scalar=64\";\n"),
        (true, false) => ("binary", "    arch        \"MSB;label=32;scalar=64\";\n"),
    };
    let note = match note {
        "" => String::new(),
        note => format!("    note        \"{note}\";\n"),
    };
    format!(
        "FoamFile\n{{\n    version     2.0;\n    format      {format};\n{arch}    class       {class};\n{note}    \
         location    \"{folder}\";\n    object      {name};\n}}\n\n"
    )
}

/// Writes a list of vectors at the nodes of a piece or of the whole.
pub(super) fn vectors(
    out: &mut dyn Write,
    values: &[[f64; 3]],
    piece: Option<&StoredPiece>,
    is_binary: bool,
) -> Result<()> {
    let of_piece = piece.map(|piece| piece.of(values));
    let values = of_piece.as_deref().unwrap_or(values);
    let bytes = is_binary.then(|| bytemuck::cast_slice(values));
    list(out, values.len(), bytes, |i, buffer| {
        for (x, before) in values[i].iter().zip(*b"(  ") {
            buffer.push(before);
            push_number(buffer, *x);
        }
        buffer.extend_from_slice(b")\n");
    })
}

/// Writes a list of labels.
pub(super) fn labels(out: &mut dyn Write, labels: &[u32], is_binary: bool) -> Result<()> {
    let bytes = is_binary.then(|| bytemuck::cast_slice(labels));
    list(out, labels.len(), bytes, |i, buffer| {
        push_integer(buffer, u64::from(labels[i]));
        buffer.push(b'\n');
    })
}

/// Writes a list of `bool`.
pub(super) fn flags(out: &mut dyn Write, flags: &[bool], is_binary: bool) -> Result<()> {
    let bytes = is_binary.then(|| bytemuck::cast_slice(flags));
    list(out, flags.len(), bytes, |i, buffer| {
        buffer.extend_from_slice(&[b'0' + u8::from(flags[i]), b'\n']);
    })
}

/// Writes a list of length `n`: in parentheses its `bytes` or the text that `push` appends for each index.
pub(super) fn list(
    out: &mut dyn Write,
    n: usize,
    bytes: Option<&[u8]>,
    push: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> Result<()> {
    match bytes {
        // An empty binary list has no parentheses.
        Some(_) if n == 0 => return write_all(out, b"0\n"),
        Some(bytes) => {
            write_all(out, format!("{n}\n(").as_bytes())?;
            write_all(out, bytes)?;
        }
        None => {
            write_all(out, format!("{n}\n(\n").as_bytes())?;
            write_records(out, n, &|range, buffer| range.for_each(|i| push(i, buffer)))?;
        }
    }
    write_all(out, b")\n")
}

/// A number as the shortest text that reads back to the same bits; whole ones without a point.
fn push_number(buffer: &mut Vec<u8>, value: f64) {
    let from = buffer.len();
    push_real(buffer, value);
    if buffer[from..].ends_with(b".0") {
        buffer.truncate(buffer.len() - 2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(write: impl Fn(&mut dyn Write) -> Result<()>) -> Vec<u8> {
        let mut out = Vec::new();
        write(&mut out).expect("a vector takes all");
        out
    }

    #[test]
    fn lists_are_text_or_binary() {
        let points = [[0.0, -1.5, 1e-300], [0.1, 2.0, 3.0]];
        assert_eq!(
            text(|out| vectors(out, &points, None, false)),
            b"2\n(\n(0 -1.5 1e-300)\n(0.1 2 3)\n)\n"
        );
        let mut expected = b"2\n(".to_vec();
        expected.extend(points.as_flattened().iter().flat_map(|x| x.to_ne_bytes()));
        expected.extend(b")\n");
        assert_eq!(text(|out| vectors(out, &points, None, true)), expected);
        assert_eq!(text(|out| labels(out, &[], true)), b"0\n");
        assert_eq!(text(|out| labels(out, &[], false)), b"0\n(\n)\n");
        assert_eq!(
            text(|out| labels(out, &[7, 12], false)),
            b"2\n(\n7\n12\n)\n"
        );
    }
}
