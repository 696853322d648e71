//! The list of pieces and the files that it names.

use super::super::vtk::{order, tags};
use super::super::vtu::read::{Raw, raw};
use super::super::vtu::xml::{Child, Parser, as_utf8};
use super::merge::{self, Piece};
use super::{CELL_IDS, NODE_IDS, ghosts};
use crate::formats::{Notes, ReadOptions, Source};
use crate::mesh::{DataArray, Mesh};
use azimesh_core::error::{Error, Result};
use std::path::Path;

/// Reads every piece and joins them.
pub(super) fn read(source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let folder = source.path().parent().unwrap_or(Path::new(""));
    let mut pieces = Vec::new();
    let mut are_marked = true;
    for name in piece_names(&as_utf8(source.bytes(), notes))? {
        let path = folder.join(&name);
        let piece = open(&path)
            .and_then(|source| raw(source.bytes(), notes))
            .and_then(|raw| {
                raw.mesh.validate()?;
                are_marked &= raw.has_marked_wedges;
                Ok(ghosts::left_out(piece_of(raw), notes))
            })
            .map_err(|error| error.file(&path).dataset("Piece"))?;
        pieces.push(piece);
    }
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
pub(super) fn piece_names(bytes: &[u8]) -> Result<Vec<String>> {
    const GRID: &str = "PUnstructuredGrid";
    let mut parser = Parser::open(bytes)?;
    let root = parser.root()?;
    let kind = parser.attribute(&root, "type")?.unwrap_or_default();
    if kind != GRID {
        return Err(parser.error(format!(
            "the file has the VTK type {kind}; it must be {GRID}"
        )));
    }
    let mut names = Vec::new();
    while let Some(child) = parser.child("VTKFile")? {
        match child {
            Child::Element(grid) if grid.name().as_ref() == GRID => {
                while let Some(child) = parser.child(GRID)? {
                    if let Child::Element(piece) = &child
                        && piece.name().as_ref() == "Piece"
                    {
                        let name = parser.attribute(piece, "Source")?;
                        let missing = || parser.error("a Piece has no Source");
                        names.push(name.ok_or_else(missing)?);
                    }
                    parser.skip(child)?;
                }
            }
            other => parser.skip(other)?,
        }
    }
    if names.is_empty() {
        return Err(parser.error("the file has no Piece"));
    }
    Ok(names)
}

/// A piece with the numbers of its nodes and cells in the whole mesh, where it has them.
fn piece_of(raw: Raw) -> Piece {
    let nodes = raw.global_nodes.unwrap_or_else(|| NODE_IDS.into());
    let cells = raw.global_cells.unwrap_or_else(|| CELL_IDS.into());
    let has = |arrays: &[DataArray], name: &String| {
        arrays.iter().any(|array| {
            array.name == *name && array.n_components == 1 && array.values.is_integer()
        })
    };
    Piece {
        node_ids: Some(nodes).filter(|name| has(&raw.mesh.point_arrays, name)),
        cell_ids: Some(cells).filter(|name| has(&raw.mesh.cell_arrays, name)),
        mesh: raw.mesh,
    }
}
