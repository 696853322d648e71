//! Cells of all pieces of a file: which arrays hold them.

use super::super::vtk::cells::{Built, CellTable};
use super::super::vtk::polyhedra::{PieceNodes, SharedFaces};
use super::super::vtk::split::polygonal;
use super::document::Piece;
use super::stored::Stored;
use super::values::{all, collect, count};
use super::xml::Array;
use crate::formats::Notes;
use crate::mesh::CellKind;
use azimesh_core::error::{Error, Result};

/// The cells of all pieces, with nodes counted through. Sets the number of cells of each piece of polygonal data.
pub(super) fn read(pieces: &mut [Piece], is_poly: bool, notes: &mut Notes) -> Result<Built> {
    let mut table = CellTable::new(if is_poly { "" } else { "types" });
    let mut n_points = 0;
    for piece in pieces {
        let (base, limit) = (n_points, count(piece.n_points)? as u64);
        let nodes = PieceNodes { base, limit };
        n_points = count(u64::from(n_points) + limit)? as u32;
        if is_poly {
            piece.n_cells = 0;
            for ((n_cells, arrays), list) in piece.lists.iter().zip(0..) {
                let n_cells = count(*n_cells)?;
                piece.n_cells += n_cells as u64;
                if n_cells > 0 {
                    list_cells(arrays, list, n_cells, nodes, &mut table)?;
                }
            }
        } else {
            let types = read_piece(piece, nodes, &mut table)?;
            if types.contains(&CellKind::Polyhedron.vtk()) {
                faces(&piece.cells, nodes, &types, &mut table)?;
            }
        }
        count(table.n_cells() as u64)?;
    }
    table.finish(notes)
}

/// Appends the cells of one list of polygonal data.
fn list_cells(
    arrays: &[Array],
    list: usize,
    n_cells: usize,
    nodes: PieceNodes,
    table: &mut CellTable,
) -> Result<()> {
    let mut before = 0;
    for end in integers(arrays, "offsets", Some(n_cells))? {
        let n_nodes = end
            .checked_sub(before)
            .and_then(|n| usize::try_from(n).ok());
        let n_nodes = n_nodes.ok_or_else(|| {
            Error::input(format!(
                "a cell ends at {end}, before the cell before it, which ends at {before}"
            ))
        });
        let added = n_nodes.and_then(|n| table.append_run(polygonal(list, n), n, 1));
        added.map_err(|error| error.dataset("offsets"))?;
        before = end;
    }
    let array = named(arrays, "connectivity")?;
    let n_entries = usize::try_from(before).ok();
    indices(array, nodes, n_entries, &mut table.connectivity)
}

fn integers(arrays: &[Array], name: &str, n: Option<usize>) -> Result<Vec<i64>> {
    all(named(arrays, name)?, n, |chunk, out| chunk.integers(out))
}

/// Appends cells of one piece; gives their types.
fn read_piece(piece: &Piece, nodes: PieceNodes, table: &mut CellTable) -> Result<Vec<u8>> {
    let n_cells = count(piece.n_cells).map_err(|error| error.dataset("types"))?;
    if n_cells == 0 {
        return Ok(Vec::new());
    }
    let types = named(&piece.cells, "types")?;
    let types = all(types, Some(n_cells), |chunk, out| {
        chunk.narrow(out, u8::MAX)
    })?;
    let before = table.connectivity.len();
    let array = named(&piece.cells, "connectivity")?;
    indices(array, nodes, None, &mut table.connectivity)?;
    let offsets = named(&piece.cells, "offsets")?;
    let end = append_ends(offsets, &types, table).map_err(|error| error.dataset("offsets"))?;
    let found = table.connectivity.len() - before;
    if end != found as u64 {
        let message = format!("the last cell ends at {end}, but there are {found} node indices");
        return Err(Error::input(message).dataset("connectivity"));
    }
    Ok(types)
}

/// The array of this name among the arrays of a piece's cells.
fn named<'p, 'a>(arrays: &'p [Array<'a>], name: &str) -> Result<&'p Array<'a>> {
    let array = arrays.iter().find(|array| array.name == name);
    let array = array.ok_or_else(|| Error::input("the array is missing").dataset(name))?;
    if array.element.is_integer() {
        return Ok(array);
    }
    let element = array.element.name();
    let message = format!("its values have type {element}; they must be integers");
    Err(Error::input(message).dataset(name))
}

/// Appends the indices in an array, which must be below the limit, plus the base.
fn indices(
    array: &Array,
    nodes: PieceNodes,
    expected: Option<usize>,
    out: &mut Vec<u32>,
) -> Result<()> {
    let done = std::cell::Cell::new(0);
    collect(array, 1, expected, out, &|chunk, out| {
        nodes.indices(chunk, done.get(), out)?;
        done.set(done.get() + out.len());
        Ok(())
    })
}

/// Appends the cells of a piece; gives the last offset.
fn append_ends(array: &Array, types: &[u8], table: &mut CellTable) -> Result<u64> {
    let (mut done, mut last) = (0, 0);
    let wrong = |found: usize| {
        let n = types.len();
        Error::input(format!(
            "it has {found} values; it must have one for each of {n} cells"
        ))
    };
    Stored::open(array)?.for_each(array.element.size(), &mut |chunk| {
        let n = chunk.n_values();
        let types = types.get(done..done + n).ok_or_else(|| wrong(done + n))?;
        table.append_ends(types, chunk, last)?;
        last = chunk.integer(n - 1) as u64;
        done += n;
        Ok(())
    })?;
    if done < types.len() {
        return Err(wrong(done));
    }
    Ok(last)
}

/// Appends the faces of the polyhedra of a piece, whose cells have these types.
fn faces(arrays: &[Array], nodes: PieceNodes, types: &[u8], table: &mut CellTable) -> Result<()> {
    let list = |name: &str, limit: u64| -> Result<Vec<u32>> {
        let (mut list, base) = (Vec::new(), 0);
        let array = named(arrays, name)?;
        indices(array, PieceNodes { base, limit }, None, &mut list)?;
        Ok(list)
    };
    if !arrays.iter().any(|a| a.name == "polyhedron_offsets") {
        let faces = list("faces", u32::MAX.into())?;
        let ends = integers(arrays, "faceoffsets", Some(types.len()))?;
        return table.streams.read_streams(&faces, &ends, nodes, types);
    }
    let face_nodes = list("face_connectivity", nodes.limit)?;
    let face_ends = integers(arrays, "face_offsets", None)?;
    let shared = SharedFaces {
        face_nodes: &face_nodes,
        cell_faces: &list("polyhedron_to_faces", face_ends.len() as u64)?,
        face_ends: &face_ends,
        cell_ends: &integers(arrays, "polyhedron_offsets", Some(types.len()))?,
    };
    table.streams.read_shared(&shared, nodes, types)
}
