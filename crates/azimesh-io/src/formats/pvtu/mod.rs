//! VTK XML grids in several files (.pvtu): pieces that are read into one mesh, and a mesh cut into
//! pieces.
//!
//! Reading leaves out ghost cells and joins the nodes that pieces share.
//!
//! ```
//! use azimesh_io::{Mesh, WriteOptions};
//! use std::num::NonZeroUsize;
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("airfoil.pvtu");
//!
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! let options = WriteOptions { pieces: NonZeroUsize::new(4), ..WriteOptions::default() };
//! mesh.view().write_with(&path, &options)?;
//! assert!(path.with_file_name("airfoil").join("airfoil_3.vtu").exists());
//!
//! // The pieces have global numbers of nodes and cells: the mesh has its order again.
//! let read = Mesh::read(&path)?;
//! assert_eq!(read.points, mesh.points);
//! assert_eq!(read.cells, mesh.cells);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module: `subset` takes cells out of a mesh, `merge` makes one mesh of pieces,
//! `write` cuts a mesh into pieces.

pub mod merge;
mod subset;
mod write;

use super::vtk::{ghosts, order, tags};
use super::vtu::read::{Raw, raw};
use super::vtu::xml::{Parser, as_utf8};
use super::{Encoding, Format, Holds, Notes, ReadOptions, Source};
use crate::mesh::{DataArray, Mesh};
use azimesh_core::error::{Error, Result, option};
use merge::Piece;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes in which a file says what it is.
const HEAD: usize = 4096;
/// Point array with the number of each node in the whole mesh.
const NODE_IDS: &str = "GlobalNodeIds";
/// Cell array with the number of each cell in the whole mesh.
const CELL_IDS: &str = "GlobalCellIds";

/// The names of the pieces that a file lists, from its folder; none where it is no list of pieces.
pub fn pieces_of(path: &Path) -> std::io::Result<Vec<String>> {
    let mut head = Vec::new();
    File::open(path)?.take(HEAD as u64).read_to_end(&mut head)?;
    if !is_list(&head) {
        return Ok(Vec::new());
    }
    let bytes = std::fs::read(path)?;
    let text = as_utf8(&bytes, &mut Notes::default());
    Ok(piece_names(&text).unwrap_or_default())
}

/// VTK XML grid in several files (.pvtu).
pub static PVTU: Format = Format {
    name: "pvtu",
    title: "VTK XML grid in pieces (.pvtu)",
    extensions: &["pvtu"],
    holds: Holds {
        tag_names: true,
        ..Holds::NOTHING
    },
    is_in_pieces: true,
    encodings: &[Encoding::Raw, Encoding::Base64, Encoding::Ascii],
    compresses: true,
    detect: |source| is_list(source.bytes()),
    read,
    write_files: Some(|mesh, out, options| {
        let n = options.pieces.ok_or_else(|| {
            let pieces = option("pieces");
            Error::input(format!(
                "a .pvtu lists several files; write it with convert {pieces} N"
            ))
            .file(out.path())
        })?;
        write::write(mesh, n.get(), out, options)
    }),
    ..Format::NEW
};

fn is_list(head: &[u8]) -> bool {
    let head = &head[..head.len().min(HEAD)];
    let finds = |what: &str| memchr::memmem::find(head, what.as_bytes()).is_some();
    finds("<VTKFile") && (finds("\"PUnstructuredGrid\"") || finds("'PUnstructuredGrid'"))
}

/// Reads every piece and joins them.
fn read(source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let folder = source.path().parent().unwrap_or(Path::new(""));
    let mut pieces = Vec::new();
    let mut are_marked = true;
    for name in piece_names(&as_utf8(source.bytes(), notes))? {
        let path = folder.join(&name);
        let piece = open(&path)
            .and_then(|source| raw(source.bytes(), None, notes))
            .and_then(|raw| {
                raw.mesh.validate()?;
                are_marked &= raw.has_marked_wedges;
                Ok(piece_of(raw))
            })
            .map_err(|error| error.file(&path).dataset("Piece"))?;
        pieces.push(piece);
    }
    ghosts::leave_out(pieces.iter_mut().map(|piece| &mut piece.mesh), notes);
    let mut mesh = merge::merge(pieces, notes)?;
    order::turn_wedges(&mut mesh, are_marked, notes);
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    Ok(mesh)
}

/// Opens a file, which a list may not send elsewhere: to a pipe or to standard input.
fn open(path: &Path) -> Result<Source> {
    let found = std::fs::metadata(path).map_err(|error| Error::io(path, &error))?;
    if !found.is_file() || path.as_os_str() == "-" {
        return Err(Error::input("a piece must be a regular file"));
    }
    Source::open(path)
}

/// Names of the files of the pieces.
fn piece_names(bytes: &[u8]) -> Result<Vec<String>> {
    const GRID: &str = "PUnstructuredGrid";
    let mut parser = Parser::open(bytes)?;
    let root = parser.root()?;
    let kind = parser.attribute(&root, "type")?.unwrap_or_default();
    if kind != GRID {
        let message = format!("the file has the VTK type {kind}; it must be {GRID}");
        return Err(parser.error(message));
    }
    let mut names = Vec::new();
    parser.each("VTKFile", |parser, name, _| {
        if name != GRID {
            return Ok(false);
        }
        parser.each(GRID, |parser, name, piece| {
            if name == "Piece" {
                let name = parser.attribute(piece, "Source")?;
                let missing = || parser.error("a Piece has no Source");
                names.push(name.ok_or_else(missing)?);
            }
            Ok(false)
        })?;
        Ok(true)
    })?;
    if names.is_empty() {
        return Err(parser.error("the file has no Piece"));
    }
    Ok(names)
}

/// A piece with the numbers of its nodes and cells in the whole mesh, where it has them.
fn piece_of(raw: Raw) -> Piece {
    let nodes = raw.global_nodes.unwrap_or_else(|| NODE_IDS.into());
    let cells = raw.global_cells.unwrap_or_else(|| CELL_IDS.into());
    let is_ids = |array: &DataArray| array.n_components == 1 && array.values.is_integer();
    let has = |arrays: &[DataArray], name: &String| {
        let mut named = arrays.iter().filter(|array| array.name == *name);
        named.any(is_ids)
    };
    Piece {
        node_ids: Some(nodes).filter(|name| has(&raw.mesh.point_arrays, name)),
        cell_ids: Some(cells).filter(|name| has(&raw.mesh.cell_arrays, name)),
        mesh: raw.mesh,
    }
}

#[cfg(test)]
mod tests;
