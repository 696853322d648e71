//! Cells as VTK lists them: types, ends and node indices, turned into runs of the mesh's kinds.
//!
//! Ends are checked window by window as they are read and never held as an array. Cells that a mesh
//! does not have are put into its kinds at the end: see `split`.

use super::polyhedra::Streams;
use super::split::{self, TypeRun, kind, type_name};
use crate::formats::Notes;
use crate::formats::number::Chunk;
use crate::mesh::too_many;
use crate::mesh::{CellKind, Cells};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{block, try_map};

/// Cells of one task.
const WINDOW: usize = 1 << 15;

/// Cells of one piece after another.
#[derive(Debug, Default)]
pub struct CellTable {
    /// Node indices of all cells.
    pub connectivity: Vec<u32>,
    /// Faces of the polyhedra.
    pub streams: Streams,
    runs: Vec<TypeRun>,
    n_cells: usize,
    /// Name of the array of types in the file.
    types_array: &'static str,
}

/// The cells of a mesh, and where they come from.
pub struct Built {
    /// The cells.
    pub cells: Cells,
    /// For each cell its index in the file; `None` when they are the same cells.
    pub origin: Option<Vec<usize>>,
}

impl CellTable {
    /// No cells yet; what the file calls the array of their types, for messages.
    pub fn new(types_array: &'static str) -> Self {
        Self {
            types_array,
            ..Self::default()
        }
    }

    /// Number of cells so far.
    pub fn n_cells(&self) -> usize {
        self.n_cells
    }

    /// Appends cells of these types; `ends` has where the nodes of each end, the cell before them
    /// ending at `last`.
    pub fn append_ends(&mut self, types: &[u8], ends: Chunk, last: u64) -> Result<()> {
        let window = Window {
            chunk: ends,
            types,
            types_array: self.types_array,
            first_cell: self.n_cells,
            last,
        };
        let parts = try_map(types.len().div_ceil(WINDOW), &|i| {
            window.runs(block(types.len(), WINDOW, i))
        })?;
        for run in parts.into_iter().flatten() {
            extend(&mut self.runs, run.vtk, run.n_nodes, run.n_cells);
        }
        self.n_cells += types.len();
        Ok(())
    }

    /// Appends cells of one type and one number of nodes.
    pub fn append_run(&mut self, vtk: u8, n_nodes: usize, n_cells: usize) -> Result<()> {
        let before = self.runs.last().copied();
        let fitting = u32::try_from(n_nodes).ok();
        let fitting = fitting.filter(|n| fits_after(before, vtk, *n));
        let n_nodes =
            fitting.ok_or_else(|| misfit(self.n_cells, vtk, n_nodes as u64, self.types_array))?;
        let n_cells = u32::try_from(n_cells).map_err(|_| Error::input(too_many("cells")))?;
        self.n_cells += n_cells as usize;
        extend(&mut self.runs, vtk, n_nodes, n_cells);
        Ok(())
    }

    /// The cells of the mesh; a note for those that had to be split or left out.
    pub fn finish(mut self, notes: &mut Notes) -> Result<Built> {
        let origin = split::split(&mut self.connectivity, &mut self.runs, notes);
        let kinds = cell_kinds(&self.runs, &mut self.connectivity);
        let cells = if self.streams.is_empty() {
            Cells::from_connectivity(self.connectivity, kinds)
        } else {
            with_polyhedra(&self.connectivity, &kinds, &self.streams)?
        };
        Ok(Built { cells, origin })
    }
}

/// Ends and types of some cells.
struct Window<'a> {
    chunk: Chunk<'a>,
    types: &'a [u8],
    types_array: &'static str,
    first_cell: usize,
    /// End of the previous cell.
    last: u64,
}

impl Window<'_> {
    fn runs(&self, cells: std::ops::Range<usize>) -> Result<Vec<TypeRun>> {
        let mut runs = Vec::new();
        let mut before = match cells.start {
            0 => self.last,
            start => self.chunk.integer(start - 1) as u64,
        };
        let mut ends = vec![0; cells.len()];
        self.chunk.part(cells.clone()).integers(&mut ends);
        for (cell, end) in cells.zip(ends) {
            let end = end as u64;
            let n_nodes = end.checked_sub(before).and_then(|n| u32::try_from(n).ok());
            let vtk = self.types[cell];
            let last = runs.last().copied();
            let n_nodes = n_nodes.filter(|n| fits_after(last, vtk, *n));
            let n_nodes = n_nodes.ok_or_else(|| self.refused(cell, before, end))?;
            extend(&mut runs, vtk, n_nodes, 1);
            before = end;
        }
        Ok(runs)
    }

    fn refused(&self, cell: usize, before: u64, end: u64) -> Error {
        let vtk = self.types[cell];
        let cell = self.first_cell + cell;
        let (before, end) = (before as i64, end as i64);
        match end.checked_sub(before).filter(|n| *n >= 0) {
            Some(n) => misfit(cell, vtk, n as u64, self.types_array),
            None => Error::input(format!(
                "cell {cell} ends at {end}, before the cell before it, which ends at {before}"
            )),
        }
    }
}

fn misfit(cell: usize, vtk: u8, n: u64, types_array: &'static str) -> Error {
    if kind(vtk).is_none() && !split::is_collection(vtk) {
        let error = format!("cell {cell} has the VTK type {vtk}, which is not read");
        return match types_array {
            "" => Error::input(error),
            name => Error::input(error).dataset(name),
        };
    }
    let name = type_name(vtk);
    match CellKind::from_vtk(vtk).map(CellKind::n_nodes) {
        Some(Some(expected)) => Error::input(format!(
            "cell {cell} is a {name} with {n} nodes; it must have {expected}"
        )),
        _ => Error::input(format!(
            "cell {cell} is a {name} with {n} nodes (VTK type {vtk}), which cannot be used"
        )),
    }
}

fn extend(runs: &mut Vec<TypeRun>, vtk: u8, n_nodes: u32, n_cells: u32) {
    match runs.last_mut() {
        Some(last) if (last.vtk, last.n_nodes) == (vtk, n_nodes) => last.n_cells += n_cells,
        _ => runs.push(TypeRun {
            vtk,
            n_nodes,
            n_cells,
        }),
    }
}

/// Returns whether a cell of this type and number of nodes can be held or split; the cells of the
/// run before are.
fn fits_after(before: Option<TypeRun>, vtk: u8, n_nodes: u32) -> bool {
    if before.is_some_and(|run| (run.vtk, run.n_nodes) == (vtk, n_nodes)) {
        return true;
    }
    let n_nodes = n_nodes as usize;
    split::is_collection(vtk) || kind(vtk).is_some_and(|kind| kind.can_have(n_nodes))
}

/// Runs by kind; pixels and voxels get the node order of quadrilaterals and hexahedra.
fn cell_kinds(runs: &[TypeRun], connectivity: &mut [u32]) -> Vec<(CellKind, usize, usize)> {
    let mut at = 0;
    let mut kinds = Vec::with_capacity(runs.len());
    for run in runs {
        let (n_nodes, n_cells) = (run.n_nodes as usize, run.n_cells as usize);
        let entries = &mut connectivity[at..at + n_nodes * n_cells];
        if matches!(run.vtk, split::PIXEL | split::VOXEL) {
            for face in entries.chunks_exact_mut(4) {
                face.swap(2, 3);
            }
        }
        at += entries.len();
        kinds.push((kind(run.vtk).expect("it was checked"), n_nodes, n_cells));
    }
    kinds
}

fn with_polyhedra(
    connectivity: &[u32],
    kinds: &[(CellKind, usize, usize)],
    streams: &Streams,
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
