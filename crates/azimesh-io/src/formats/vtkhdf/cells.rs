//! The cells of all parts of a step, and rows of datasets, window by window.

use super::super::Notes;
use super::super::hdf5::{Dataset, Group};
use super::super::number::Chunk;
use super::super::vtk::cells::{Built, CellTable};
use super::super::vtk::polyhedra::{PieceNodes, SharedFaces};
use super::extent::{FaceRows, PartRows};
use crate::mesh::{CellKind, Values, too_many};
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// Rows that are in memory twice while they are converted: so few that it is the same memory for all windows, which the
/// system clears once.
pub(super) const WINDOW: u64 = 1 << 17;

/// A number of nodes or cells, which must fit in an index of 32 bits.
pub(super) fn count(rows: &Range<u64>) -> Result<usize> {
    match rows.end - rows.start {
        n if n < u64::from(u32::MAX) => Ok(n as usize),
        n => Err(Error::input(format!(
            "{n} rows are more than the 4294967294 nodes or cells that a mesh can have"
        ))),
    }
}

/// A dataset of one value per row.
pub(super) fn column(grid: &Group, name: &str) -> Result<Dataset> {
    let dataset = grid.need(name)?;
    match dataset.row()? {
        1 => Ok(dataset),
        n => Err(Error::input(format!("its rows have {n} values; they must have 1")).dataset(name)),
    }
}

/// Hands some rows of a dataset to `take`, part by part.
pub(super) fn windows(
    dataset: &Dataset,
    rows: &Range<u64>,
    mut take: impl FnMut(Values) -> Result<()>,
) -> Result<()> {
    dataset.check_rows(rows)?;
    // A chunk is decoded anew for each window that has some of it.
    let n = dataset.whole_chunks(WINDOW);
    let mut start = rows.start;
    while start < rows.end {
        let end = rows.end.min(start.saturating_add(n));
        take(dataset.rows(start..end)?)?;
        start = end;
    }
    Ok(())
}

/// The values of a dataset that must hold integers.
fn integers<'a>(values: &'a Values, name: &str) -> Result<Chunk<'a>> {
    let chunk = Chunk::of(values).filter(|chunk| chunk.element.is_integer());
    chunk.ok_or_else(|| no_integers(name))
}

fn no_integers(name: &str) -> Error {
    Error::input("it must hold integers").dataset(name)
}

/// Reads the cells of all parts, with nodes counted through.
pub(super) fn read(
    grid: &Group,
    parts: &[PartRows],
    all: &Range<u64>,
    notes: &mut Notes,
) -> Result<Built> {
    let mut table = CellTable::new("Types");
    count(all)?;
    let mut base = 0_u32;
    for part in parts {
        let limit = count(&part.points)? as u64;
        let nodes = PieceNodes { base, limit };
        let next = u32::try_from(limit).ok().and_then(|n| base.checked_add(n));
        base = next.ok_or_else(|| Error::input(too_many("nodes")))?;
        if part.cells.is_empty() {
            continue;
        }
        let types = types(grid, &part.cells)?;
        append(grid, part, nodes, &types, &mut table)?;
        if types.contains(&CellKind::Polyhedron.vtk()) {
            let missing =
                || Error::input("the file has polyhedra but no faces").dataset("NumberOfFaces");
            let faces = part.faces.as_ref().ok_or_else(missing)?;
            append_faces(grid, part, faces, nodes, &types, &mut table)?;
        }
    }
    table.finish(notes)
}

/// VTK's types of some cells.
pub(super) fn types(grid: &Group, rows: &Range<u64>) -> Result<Vec<u8>> {
    let mut types = Vec::new();
    windows(&column(grid, "Types")?, rows, |values| {
        let start = types.len();
        types.resize(start + values.len(), 0);
        integers(&values, "Types")?.narrow(&mut types[start..], u8::MAX);
        Ok(())
    })?;
    Ok(types)
}

/// A part with its cells that are among these rows.
pub(super) fn cut(grid: &Group, part: &PartRows, rows: &Range<u64>) -> Result<PartRows> {
    let start = rows.start.clamp(part.cells.start, part.cells.end);
    let cells = start..rows.end.clamp(start, part.cells.end);
    let mut cut = PartRows {
        points: part.points.clone(),
        connectivity: 0..0,
        offsets: 0..0,
        faces: None,
        cells: cells.clone(),
    };
    if cells.is_empty() {
        return Ok(cut);
    }
    let row = |cell: u64| part.offsets.start + (cell - part.cells.start);
    cut.offsets = row(cells.start)..row(cells.end) + 1;
    let offsets = column(grid, "Offsets")?;
    let offset = |cell| {
        let value = offsets.rows(row(cell)..row(cell) + 1)?.to_integers();
        let value = value.and_then(|values| values.first().copied());
        value.ok_or_else(|| no_integers("Offsets"))
    };
    let [first, last] = [offset(part.cells.start)?, offset(part.cells.end)?];
    let [start, end] = [offset(cells.start)?, offset(cells.end)?];
    let n = part.connectivity.end - part.connectivity.start;
    if ![0, first, start, end, last].is_sorted() || last - first != n as i64 {
        return Err(Error::input("they do not fit the node indices").dataset("Offsets"));
    }
    let entry = |offset: i64| part.connectivity.start + (offset - first) as u64;
    cut.connectivity = entry(start)..entry(end);
    Ok(cut)
}

fn append(
    grid: &Group,
    part: &PartRows,
    nodes: PieceNodes,
    types: &[u8],
    table: &mut CellTable,
) -> Result<()> {
    // The first offset, and the last so far.
    let mut ends_at: Option<(u64, u64)> = None;
    let mut done = 0;
    windows(&column(grid, "Offsets")?, &part.offsets, |values| {
        let mut ends = integers(&values, "Offsets")?;
        let (first, before) = ends_at.unwrap_or_else(|| {
            let first = ends.integer(0) as u64;
            ends = ends.part(1..ends.n_values());
            (first, first)
        });
        let n = ends.n_values();
        table.append_ends(&types[done..done + n], ends, before)?;
        let last = n.checked_sub(1).map(|at| ends.integer(at) as u64);
        ends_at = Some((first, last.unwrap_or(before)));
        done += n;
        Ok(())
    })
    .map_err(|error| error.dataset("Offsets"))?;
    let (first, last) = ends_at.unwrap_or_default();
    let n_entries = part.connectivity.end - part.connectivity.start;
    if last.checked_sub(first) != Some(n_entries) {
        let found = last as i64;
        let message =
            format!("the last cell ends at {found}, but {n_entries} node indices start at {first}");
        return Err(Error::input(message).dataset("Offsets"));
    }
    let (rows, out) = (&part.connectivity, &mut table.connectivity);
    indices(grid, "Connectivity", rows, nodes, out)
}

/// Appends some indices of a dataset, which must be below the limit, plus the base.
fn indices(
    grid: &Group,
    name: &str,
    rows: &Range<u64>,
    nodes: PieceNodes,
    out: &mut Vec<u32>,
) -> Result<()> {
    let dataset = column(grid, name)?;
    dataset.check_rows(rows)?;
    let first = out.len();
    out.reserve((rows.end - rows.start) as usize);
    windows(&dataset, rows, |values| {
        let start = out.len();
        out.resize(start + values.len(), 0);
        let (listed, entry) = (
            integers(&values, name)?,
            rows.start as usize + start - first,
        );
        let found = nodes.indices(listed, entry, &mut out[start..]);
        found.map_err(|error| error.dataset(name))
    })
}

fn append_faces(
    grid: &Group,
    part: &PartRows,
    faces: &FaceRows,
    nodes: PieceNodes,
    types: &[u8],
    table: &mut CellTable,
) -> Result<()> {
    let list = |name: &str, rows: &Range<u64>, limit: u64| -> Result<Vec<u32>> {
        let mut list = Vec::new();
        indices(grid, name, rows, PieceNodes { base: 0, limit }, &mut list)?;
        Ok(list)
    };
    let ends = |name: &str, rows: &Range<u64>| -> Result<Vec<i64>> {
        let values = column(grid, name)?.rows(rows.clone())?.to_integers();
        let values = values.ok_or_else(|| no_integers(name))?;
        match values.split_first() {
            Some((0, ends)) => Ok(ends.to_vec()),
            _ => Err(Error::input("the offsets of a part must start at 0").dataset(name)),
        }
    };
    let n_faces = (faces.offsets.end - faces.offsets.start) - 1;
    let shared = SharedFaces {
        face_nodes: &list("FaceConnectivity", &faces.connectivity, nodes.limit)?,
        face_ends: &ends("FaceOffsets", &faces.offsets)?,
        cell_faces: &list("PolyhedronToFaces", &faces.of_cells, n_faces)?,
        cell_ends: &ends("PolyhedronOffsets", &part.offsets)?,
    };
    table.streams.read_shared(&shared, nodes, types)
}
