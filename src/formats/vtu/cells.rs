//! Cells of all pieces: types, offsets and node indices as runs.
//!
//! Offsets are checked window by window as they are read and never held as an array.

use super::number::{Chunk, Element, Number, need_integers, with_type};
use super::polyhedra;
use super::read::{collect, count};
use super::stored::Stored;
use super::xml::{Array, Layout, Piece};
use crate::error::{Error, Result};
use crate::mesh::{CellKind, Cells};
use rayon::prelude::*;

/// Cells of one task.
const WINDOW: usize = 1 << 15;

const PIXEL: u8 = 8;
const VOXEL: u8 = 11;
const POLYHEDRON: u8 = 42;

/// Consecutive cells of one VTK type and one number of nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TypeRun {
    vtk: u8,
    n_nodes: u32,
    n_cells: u32,
}

/// The cells of all pieces, with nodes counted through.
pub(super) fn read(pieces: &[Piece], layout: &Layout) -> Result<Cells> {
    let mut connectivity = Vec::new();
    let mut runs = Vec::new();
    let mut streams = polyhedra::Streams::default();
    let (mut n_points, mut n_cells) = (0, 0);
    for piece in pieces {
        let limit = count(piece.n_points)? as u64;
        let nodes = Nodes {
            base: n_points,
            limit,
        };
        n_points = count(u64::from(n_points) + limit)? as u32;
        let types = piece_runs(piece, layout, nodes, n_cells, &mut connectivity, &mut runs)?;
        if types.contains(&POLYHEDRON) {
            streams.read(&piece.cells, layout, nodes, &types)?;
        }
        n_cells = count(n_cells as u64 + piece.n_cells)?;
    }
    let kinds = cell_kinds(&runs, &mut connectivity)?;
    if streams.is_empty() {
        return Ok(Cells::from_connectivity(connectivity, kinds));
    }
    with_polyhedra(&connectivity, &kinds, &streams)
}

/// How node indices of a piece become those of the mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nodes {
    /// Nodes of the pieces before.
    pub base: u32,
    /// Nodes of this piece.
    pub limit: u64,
}

/// Appends connectivity and runs of one piece; gives its cell types.
fn piece_runs(
    piece: &Piece,
    layout: &Layout,
    nodes: Nodes,
    first_cell: usize,
    connectivity: &mut Vec<u32>,
    runs: &mut Vec<TypeRun>,
) -> Result<Vec<u8>> {
    let n_cells = count(piece.n_cells).map_err(|error| error.dataset("types"))?;
    if n_cells == 0 {
        return Ok(Vec::new());
    }
    let array = named(&piece.cells, "types")?;
    let mut types = Vec::new();
    // No type is larger than 255, and 255 is none.
    let narrow = |vtk| u8::try_from(vtk).unwrap_or(u8::MAX);
    with_type!(array.element, T => collect(array, layout, 1, Some(n_cells), &mut types, |chunk, out| {
        chunk.convert::<T, u8>(out, |x| narrow(x.as_index()));
        Ok(())
    })?);
    let before = connectivity.len();
    let array = named(&piece.cells, "connectivity")?;
    indices(array, layout, nodes.base, nodes.limit, None, connectivity)?;
    let end = offsets(&piece.cells, layout, &types, first_cell, runs)?;
    let found = connectivity.len() - before;
    if end != found as u64 {
        return Err(Error::input(format!(
            "the last cell ends at {end}, but there are {found} node indices"
        ))
        .dataset("connectivity"));
    }
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
    let mut done = 0;
    let done = std::cell::Cell::from_mut(&mut done);
    with_type!(array.element, T => collect(array, layout, 1, expected, out, |chunk, out| {
        chunk.indices::<T>(out, limit, base).map_err(|(at, value)| {
            let at = done.get() + at;
            let highest = limit as i64 - 1;
            Error::input(format!("entry {at} is {value}; it must be from 0 to {highest}"))
        })?;
        done.set(done.get() + out.len());
        Ok(())
    }))
}

/// Appends the runs of a piece; gives the last offset.
fn offsets(
    arrays: &[Array],
    layout: &Layout,
    types: &[u8],
    first_cell: usize,
    runs: &mut Vec<TypeRun>,
) -> Result<u64> {
    let array = named(arrays, "offsets")?;
    let stored = Stored::open(array, layout)?;
    let (mut done, mut last) = (0, 0);
    let wrong = |found: usize| {
        let n = types.len();
        Error::input(format!(
            "{found} values found; there must be one for each of {n} cells"
        ))
    };
    let result = with_type!(array.element, T => stored.for_each(size_of::<T>(), &mut |chunk| {
        let n = chunk.len::<T>();
        let types = types.get(done..done + n).ok_or_else(|| wrong(done + n))?;
        let cells = Window { chunk, types, first_cell: first_cell + done, last };
        cells.append_runs::<T>(runs)?;
        last = chunk.get::<T>(n - 1).as_index();
        done += n;
        Ok(())
    }));
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

/// Offsets and types of some cells.
struct Window<'a> {
    chunk: Chunk<'a>,
    types: &'a [u8],
    first_cell: usize,
    /// Where the cell before ends.
    last: u64,
}

impl Window<'_> {
    fn append_runs<T: Number>(&self, runs: &mut Vec<TypeRun>) -> Result<()> {
        let starts: Vec<usize> = (0..self.types.len()).step_by(WINDOW).collect();
        let parts: Result<Vec<Vec<TypeRun>>> = starts
            .into_par_iter()
            .map(|start| self.runs::<T>(start..self.types.len().min(start + WINDOW)))
            .collect();
        for run in parts?.into_iter().flatten() {
            extend(runs, run);
        }
        Ok(())
    }

    fn runs<T: Number>(&self, cells: std::ops::Range<usize>) -> Result<Vec<TypeRun>> {
        let mut runs = Vec::new();
        let mut before = match cells.start {
            0 => self.last,
            start => self.chunk.get::<T>(start - 1).as_index(),
        };
        for cell in cells {
            let end = self.chunk.get::<T>(cell).as_index();
            let n_nodes = end.checked_sub(before).and_then(|n| u32::try_from(n).ok());
            let vtk = self.types[cell];
            let n_nodes = n_nodes.filter(|n| fits(vtk, *n as usize));
            let n_nodes = n_nodes.ok_or_else(|| self.refused(cell, before, end))?;
            extend(
                &mut runs,
                TypeRun {
                    vtk,
                    n_nodes,
                    n_cells: 1,
                },
            );
            before = end;
        }
        Ok(runs)
    }

    fn refused(&self, cell: usize, before: u64, end: u64) -> Error {
        let vtk = self.types[cell];
        let cell = self.first_cell + cell;
        let (before, end) = (before as i64, end as i64);
        let Some(n) = end.checked_sub(before).filter(|n| *n >= 0) else {
            let message = format!("cell {cell} ends at {end}, but the one before it at {before}");
            return Error::input(message);
        };
        let name = type_name(vtk);
        match CellKind::from_vtk(vtk).map(CellKind::n_nodes) {
            Some(Some(expected)) => Error::input(format!(
                "cell {cell} is a {name} of {n} nodes; it must have {expected}"
            )),
            _ => Error::input(format!(
                "cell {cell} is a {name} of {n} nodes (VTK type {vtk}), which cannot be used"
            )),
        }
    }
}

fn extend(runs: &mut Vec<TypeRun>, run: TypeRun) {
    match runs.last_mut() {
        Some(last) if (last.vtk, last.n_nodes) == (run.vtk, run.n_nodes) => {
            last.n_cells += run.n_cells;
        }
        _ => runs.push(run),
    }
}

/// Whether a cell of this type and number of nodes is one that can be held.
fn fits(vtk: u8, n_nodes: usize) -> bool {
    kind(vtk, n_nodes).is_some_and(|kind| kind.can_have(n_nodes))
}

/// The kind of a VTK type. Collections of one point, one line or one triangle count as it.
fn kind(vtk: u8, n_nodes: usize) -> Option<CellKind> {
    match (vtk, n_nodes) {
        (2, 1) => Some(CellKind::Vertex),
        (4, 2) => Some(CellKind::Line),
        (6, 3) => Some(CellKind::Triangle),
        (PIXEL, _) => Some(CellKind::Quadrilateral),
        (VOXEL, _) => Some(CellKind::Hexahedron),
        _ => CellKind::from_vtk(vtk),
    }
}

fn type_name(vtk: u8) -> &'static str {
    match vtk {
        0 => "empty cell",
        2 => "poly-vertex",
        4 => "polyline",
        6 => "triangle strip",
        PIXEL => "pixel",
        VOXEL => "voxel",
        _ => CellKind::from_vtk(vtk).map_or("cell of another type", CellKind::name),
    }
}

/// Runs by kind; pixels and voxels get the node order of quadrilaterals and hexahedra.
fn cell_kinds(runs: &[TypeRun], connectivity: &mut [u32]) -> Result<Vec<(CellKind, usize, usize)>> {
    let mut at = 0;
    let mut kinds = Vec::with_capacity(runs.len());
    for run in runs {
        let (n_nodes, n_cells) = (run.n_nodes as usize, run.n_cells as usize);
        let entries = &mut connectivity[at..at + n_nodes * n_cells];
        if matches!(run.vtk, PIXEL | VOXEL) {
            for face in entries.chunks_exact_mut(4) {
                face.swap(2, 3);
            }
        }
        at += entries.len();
        kinds.push((
            kind(run.vtk, n_nodes).expect("it was checked"),
            n_nodes,
            n_cells,
        ));
    }
    Ok(kinds)
}

fn with_polyhedra(
    connectivity: &[u32],
    kinds: &[(CellKind, usize, usize)],
    streams: &polyhedra::Streams,
) -> Result<Cells> {
    let mut cells = Cells::new();
    cells.reserve(connectivity.len());
    let mut rest = connectivity;
    let mut stream = streams.iter();
    for &(kind, n_nodes, n_cells) in kinds {
        let (entries, tail) = rest.split_at(n_nodes * n_cells);
        rest = tail;
        if kind != CellKind::Polyhedron {
            cells.push_run(kind, n_nodes, entries);
            continue;
        }
        for nodes in entries.chunks_exact(n_nodes) {
            let faces = stream.next().expect("one stream a polyhedron");
            let pushed = cells.push_polyhedron_with_nodes(nodes, faces);
            pushed.map_err(|error| error.dataset("faces"))?;
        }
    }
    Ok(cells)
}
