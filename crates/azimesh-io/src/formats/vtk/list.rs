//! A list of cells as legacy files have it: a count before the nodes of each cell, or where each
//! ends. A polyhedron has its face stream in the place of its nodes.

use super::cells::CellTable;
use super::polyhedra::PieceNodes;
use crate::mesh::{CellKind, first_where};
use azimesh_core::error::{Error, Result};

/// Cells without their types.
#[derive(Default)]
pub struct List {
    n_cells: usize,
    entries: Vec<u32>,
    /// End of each cell; without them `entries` has a count before each cell.
    ends: Option<Vec<i64>>,
}

impl List {
    /// Cells with a count before the nodes of each.
    pub fn counted(n_cells: usize, entries: Vec<u32>) -> Self {
        Self {
            n_cells,
            entries,
            ends: None,
        }
    }

    /// Cells by the offsets `ends`.
    pub fn ending(ends: Vec<i64>, entries: Vec<u32>) -> Self {
        Self {
            n_cells: ends.len(),
            entries,
            ends: Some(ends),
        }
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.n_cells
    }

    /// Appends the cells to a table; `kind` gives VTK's type of a cell with this index and number
    /// of nodes, `nodes` those that there are.
    pub fn append(
        self,
        table: &mut CellTable,
        nodes: PieceNodes,
        kind: impl Fn(usize, usize) -> u8,
    ) -> Result<()> {
        let polyhedron = CellKind::Polyhedron.vtk();
        let mut entries = self.entries;
        let first = table.connectivity.len();
        let (mut from, mut to) = (0, 0);
        let mut unique: Vec<u32> = Vec::new();
        for cell in 0..self.n_cells {
            let end = match &self.ends {
                Some(ends) => usize::try_from(ends[cell]).ok().filter(|end| *end >= from),
                None => {
                    let length = entries.get(from).map(|n| *n as usize);
                    from += 1;
                    length.and_then(|n| from.checked_add(n))
                }
            };
            let end = end.filter(|end| *end <= entries.len()).ok_or_else(|| {
                let n = entries.len();
                Error::input(format!(
                    "cell {cell} goes beyond the {n} entries of the list"
                ))
            })?;
            let vtk = kind(cell, end - from);
            let mut n_nodes = end - from;
            if vtk == polyhedron {
                let stream = &entries[from..end];
                table.streams.push(stream, nodes, cell)?;
                distinct(stream, &mut unique);
                n_nodes = unique.len();
                entries[to..to + n_nodes].copy_from_slice(&unique);
            } else {
                entries.copy_within(from..end, to);
            }
            table.append_run(vtk, n_nodes, 1)?;
            to += n_nodes;
            from = end;
        }
        if from != entries.len() {
            let (left, n) = (entries.len() - from, entries.len());
            return Err(Error::input(format!(
                "the list of cells has {n} entries, {left} more than its cells need"
            )));
        }
        entries.truncate(to);
        check_nodes(&entries, nodes)?;
        match first {
            0 => table.connectivity = entries,
            _ => table.connectivity.append(&mut entries),
        }
        Ok(())
    }
}

/// Nodes of a face stream, each once, ascending as VTK has them.
fn distinct(stream: &[u32], unique: &mut Vec<u32>) {
    unique.clear();
    let mut at = 1;
    while let Some(&n) = stream.get(at) {
        let face = stream.get(at + 1..).unwrap_or(&[]);
        unique.extend(&face[..face.len().min(n as usize)]);
        at += 1 + n as usize;
    }
    unique.sort_unstable();
    unique.dedup();
}

fn check_nodes(entries: &[u32], nodes: PieceNodes) -> Result<()> {
    let outside = |node: &u32| u64::from(*node) >= nodes.limit;
    if let Some(at) = first_where(entries, outside) {
        let shown = match entries[at] {
            u32::MAX => "an index that is out of range".into(),
            node => format!("node {node}"),
        };
        let n = nodes.limit;
        return Err(Error::input(format!(
            "a cell has {shown}; the file has {n} nodes, counted from 0"
        )));
    }
    Ok(())
}
