//! Cells of all pieces of a file: which arrays hold them.

use super::super::vtk::cells::{Built, CellTable};
use super::super::vtk::number::need_integers;
use super::super::vtk::polyhedra::{PieceNodes, SharedFaces};
use super::super::vtk::split::polygonal;
use super::collect::{collect, count};
use super::document::Piece;
use super::stored::Stored;
use super::xml::{Array, Layout};
use crate::formats::Notes;
use crate::mesh::CellKind;
use azimesh_core::error::{Error, Result};

/// The cells of all pieces, with nodes counted through.
pub(super) fn read(pieces: &[Piece], layout: &Layout, notes: &mut Notes) -> Result<Built> {
    let mut table = CellTable::new("types");
    let mut n_points = 0;
    for piece in pieces {
        let limit = count(piece.n_points)? as u64;
        let nodes = PieceNodes {
            base: n_points,
            limit,
        };
        n_points = count(u64::from(n_points) + limit)? as u32;
        let types = read_piece(piece, layout, nodes, &mut table)?;
        if types.contains(&CellKind::Polyhedron.vtk()) {
            faces(&piece.cells, layout, nodes, &types, &mut table)?;
        }
        count(table.n_cells() as u64)?;
    }
    table.finish(notes)
}

/// The cells of polygonal data; sets the number of cells of each piece.
pub(super) fn read_lists(
    pieces: &mut [Piece],
    layout: &Layout,
    notes: &mut Notes,
) -> Result<Built> {
    let mut table = CellTable::default();
    let mut n_points = 0;
    for piece in pieces {
        let limit = count(piece.n_points)? as u64;
        let nodes = PieceNodes {
            base: n_points,
            limit,
        };
        n_points = count(u64::from(n_points) + limit)? as u32;
        piece.n_cells = 0;
        for ((n_cells, arrays), list) in piece.lists.iter().zip(0..) {
            let n_cells = count(*n_cells)?;
            piece.n_cells += n_cells as u64;
            if n_cells > 0 {
                list_cells(arrays, list, n_cells, layout, nodes, &mut table)?;
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
    layout: &Layout,
    nodes: PieceNodes,
    table: &mut CellTable,
) -> Result<()> {
    let ends = integers(named(arrays, "offsets")?, layout, Some(n_cells))?;
    let mut before = 0;
    for end in &ends {
        let n_nodes = end
            .checked_sub(before)
            .and_then(|n| usize::try_from(n).ok());
        let n_nodes = n_nodes.ok_or_else(|| {
            Error::input(format!(
                "a cell ends at {end}, before the cell before it, which ends at {before}"
            ))
            .dataset("offsets")
        })?;
        let added = table.append_run(polygonal(list, n_nodes), n_nodes, 1);
        added.map_err(|error| error.dataset("offsets"))?;
        before = *end;
    }
    let array = named(arrays, "connectivity")?;
    let expected = usize::try_from(before).ok();
    let (base, limit) = (nodes.base, nodes.limit);
    indices(
        array,
        layout,
        base,
        limit,
        expected,
        &mut table.connectivity,
    )
}

/// Appends cells of one piece; gives their types.
fn read_piece(
    piece: &Piece,
    layout: &Layout,
    nodes: PieceNodes,
    table: &mut CellTable,
) -> Result<Vec<u8>> {
    let n_cells = count(piece.n_cells).map_err(|error| error.dataset("types"))?;
    if n_cells == 0 {
        return Ok(Vec::new());
    }
    let types = types(&piece.cells, layout, n_cells)?;
    let before = table.connectivity.len();
    let array = named(&piece.cells, "connectivity")?;
    let (base, limit) = (nodes.base, nodes.limit);
    indices(array, layout, base, limit, None, &mut table.connectivity)?;
    let end = offsets(&piece.cells, layout, &types, table)?;
    let found = table.connectivity.len() - before;
    if end != found as u64 {
        return Err(Error::input(format!(
            "the last cell ends at {end}, but there are {found} node indices"
        ))
        .dataset("connectivity"));
    }
    Ok(types)
}

fn types(arrays: &[Array], layout: &Layout, n_cells: usize) -> Result<Vec<u8>> {
    let array = named(arrays, "types")?;
    let mut types = Vec::new();
    collect(
        array,
        layout,
        1,
        Some(n_cells),
        &mut types,
        &|chunk, out| {
            chunk.types(out);
            Ok(())
        },
    )?;
    Ok(types)
}

/// The array of this name among the arrays of a piece's cells.
pub(super) fn named<'p, 'a>(arrays: &'p [Array<'a>], name: &str) -> Result<&'p Array<'a>> {
    let array = arrays.iter().find(|array| array.name == name);
    let array = array.ok_or_else(|| Error::input("the array is missing").dataset(name))?;
    need_integers(name, array.element)?;
    Ok(array)
}

/// Appends the indices in an array, which must be below `limit`, plus `base`.
pub(super) fn indices(
    array: &Array,
    layout: &Layout,
    base: u32,
    limit: u64,
    expected: Option<usize>,
    out: &mut Vec<u32>,
) -> Result<()> {
    let done = std::cell::Cell::new(0);
    collect(array, layout, 1, expected, out, &|chunk, out| {
        chunk
            .indices(out, (0, limit), base)
            .map_err(|(at, value)| not_a_node(done.get() + at, &value, limit))?;
        done.set(done.get() + out.len());
        Ok(())
    })
}

/// The refusal of an entry that is no index below `limit`.
pub(super) fn not_a_node(at: usize, value: &str, limit: u64) -> Error {
    let highest = limit as i64 - 1;
    Error::input(format!(
        "entry {at} is {value}; it must be from 0 to {highest}"
    ))
}

/// Appends the cells of a piece; gives the last offset.
fn offsets(arrays: &[Array], layout: &Layout, types: &[u8], table: &mut CellTable) -> Result<u64> {
    let array = named(arrays, "offsets")?;
    let stored = Stored::open(array, layout)?;
    let (mut done, mut last) = (0, 0);
    let wrong = |found: usize| {
        let n = types.len();
        Error::input(format!(
            "it has {found} values; it must have one for each of {n} cells"
        ))
    };
    let result = stored.for_each(array.element.size(), &mut |chunk| {
        let n = chunk.n_values();
        let types = types.get(done..done + n).ok_or_else(|| wrong(done + n))?;
        table.append_ends(types, chunk, last)?;
        last = chunk.integer(n - 1) as u64;
        done += n;
        Ok(())
    });
    result
        .and_then(|()| {
            if done == types.len() {
                Ok(last)
            } else {
                Err(wrong(done))
            }
        })
        .map_err(|error| error.dataset("offsets"))
}

/// Appends the faces of the polyhedra of a piece, whose cells have these types.
fn faces(
    arrays: &[Array],
    layout: &Layout,
    nodes: PieceNodes,
    types: &[u8],
    table: &mut CellTable,
) -> Result<()> {
    let list = |name: &str, limit: u64| -> Result<Vec<u32>> {
        let mut list = Vec::new();
        indices(named(arrays, name)?, layout, 0, limit, None, &mut list)?;
        Ok(list)
    };
    let ends = |name: &str, n| integers(named(arrays, name)?, layout, n);
    let is_new = arrays.iter().any(|a| a.name == "polyhedron_offsets");
    if !is_new {
        let faces = list("faces", u32::MAX.into())?;
        let ends = ends("faceoffsets", Some(types.len()))?;
        return table.streams.read_streams(&faces, &ends, nodes, types);
    }
    let face_nodes = list("face_connectivity", nodes.limit)?;
    let face_ends = ends("face_offsets", None)?;
    let cell_faces = list("polyhedron_to_faces", face_ends.len() as u64)?;
    let cell_ends = ends("polyhedron_offsets", Some(types.len()))?;
    let shared = SharedFaces {
        face_nodes: &face_nodes,
        face_ends: &face_ends,
        cell_faces: &cell_faces,
        cell_ends: &cell_ends,
    };
    table.streams.read_shared(&shared, nodes, types)
}

fn integers(array: &Array, layout: &Layout, expected: Option<usize>) -> Result<Vec<i64>> {
    let mut out = Vec::new();
    collect(array, layout, 1, expected, &mut out, &|chunk, out| {
        chunk.integers(out);
        Ok(())
    })?;
    Ok(out)
}
