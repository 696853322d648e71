//! The cells of all parts of a step.

use super::super::Notes;
use super::super::hdf5::Group;
use super::super::vtk::cells::{Built, CellTable};
use super::super::vtk::chunk::Chunk;
use super::super::vtk::polyhedra::{PieceNodes, SharedFaces};
use super::extent::{FaceRows, PartRows};
use super::rows::{column, count, windows};
use crate::mesh::too_many;
use crate::mesh::{CellKind, Values};
use azimesh_core::error::{Error, Result};
use std::ops::Range;

/// Reads the cells of all parts, with nodes counted through.
pub(super) fn read(
    grid: &Group,
    parts: &[PartRows],
    all: &Range<u64>,
    notes: &mut Notes,
) -> Result<Built> {
    let mut table = CellTable::new("Types");
    count(all)?;
    let mut base = 0;
    for part in parts {
        let n_points = count(&part.points)?;
        let nodes = PieceNodes {
            base,
            limit: n_points as u64,
        };
        base += u32::try_from(n_points)
            .ok()
            .filter(|n| base.checked_add(*n).is_some())
            .ok_or_else(|| Error::input(too_many("nodes")))?;
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
        integers(&values, "Types")?.types(&mut types[start..]);
        Ok(())
    })?;
    Ok(types)
}

fn append(
    grid: &Group,
    part: &PartRows,
    nodes: PieceNodes,
    types: &[u8],
    table: &mut CellTable,
) -> Result<()> {
    let ends = column(grid, "Offsets")?;
    let mut last = None;
    let mut first = 0;
    let mut done = 0;
    windows(&ends, &part.offsets, |values| {
        let mut ends = integers(&values, "Offsets")?;
        let before = last.unwrap_or_else(|| {
            first = ends.integer(0) as u64;
            ends = ends.part(1..ends.n_values());
            first
        });
        let n = ends.n_values();
        table.append_ends(&types[done..done + n], ends, before)?;
        last = Some(
            n.checked_sub(1)
                .map_or(before, |at| ends.integer(at) as u64),
        );
        done += n;
        Ok(())
    })
    .map_err(|error| error.dataset("Offsets"))?;
    let n_entries = part.connectivity.end - part.connectivity.start;
    let end = last.unwrap_or(0).checked_sub(first);
    if end != Some(n_entries) {
        let found = last.unwrap_or(0) as i64;
        return Err(Error::input(format!(
            "the last cell ends at {found}, but {n_entries} node indices start at {first}"
        ))
        .dataset("Offsets"));
    }
    indices(
        grid,
        "Connectivity",
        &part.connectivity,
        nodes,
        &mut table.connectivity,
    )
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
    out.reserve((rows.end - rows.start) as usize);
    let mut done = rows.start;
    windows(&dataset, rows, |values| {
        let start = out.len();
        out.resize(start + values.len(), 0);
        let found =
            integers(&values, name)?.indices(&mut out[start..], (0, nodes.limit), nodes.base);
        found.map_err(|(at, value)| {
            let (at, highest) = (done + at as u64, nodes.limit as i64 - 1);
            Error::input(format!(
                "entry {at} is {value}; it must be from 0 to {highest}"
            ))
            .dataset(name)
        })?;
        done += values.len() as u64;
        Ok(())
    })
}

/// The values of a dataset that must hold integers.
fn integers<'a>(values: &'a Values, name: &str) -> Result<Chunk<'a>> {
    let chunk = Chunk::of(values).filter(|chunk| chunk.element.is_integer());
    chunk.ok_or_else(|| no_integers(name))
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
    // Offsets start with that of the first, which is 0.
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

fn no_integers(name: &str) -> Error {
    Error::input("it must hold integers").dataset(name)
}
