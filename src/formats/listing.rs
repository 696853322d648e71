//! The nodes of cells as files list them, for ranks that write those of their own cells.

use super::cgns;
use super::hdf5::Sink;
use crate::error::Result;
use crate::mesh::{Cells, Listing, NodesOfCells};
use std::ops::Range;

/// Numbers made at a time: so few that no loop over them starts threads.
const BLOCK: usize = 1 << 16;

/// Passes the bytes of the nodes of some `cells` to `sink`, by this thread alone; `number` gives the number of a node from 0.
pub(crate) fn list_nodes(
    cells: &Cells,
    range: Range<usize>,
    wanted: &NodesOfCells,
    number: &(dyn Fn(u32) -> u32 + Sync),
    sink: Sink,
) -> Result<()> {
    let is_wide = wanted.is_wide;
    for run in cells.runs_in(range) {
        let end = run.first_cell + run.n_cells();
        let step = (BLOCK / run.n_nodes).max(1);
        for start in (run.first_cell..end).step_by(step) {
            let some = start..end.min(start + step);
            match wanted.listing {
                Listing::Vtk => {
                    for nodes in cells.runs_in(some) {
                        in_vtk(nodes.connectivity, is_wide, number, sink)?;
                    }
                }
                Listing::Cgns => cgns::list_elements(cells, some, is_wide, number, sink)?,
                Listing::CgnsMixed => cgns::list_mixed(cells, some, is_wide, number, sink)?,
            }
        }
    }
    Ok(())
}

fn in_vtk(nodes: &[u32], is_wide: bool, number: &dyn Fn(u32) -> u32, sink: Sink) -> Result<()> {
    let numbers = nodes.iter().map(|&node| number(node));
    match is_wide {
        false => sink(bytemuck::cast_slice(&numbers.collect::<Vec<u32>>())),
        true => sink(bytemuck::cast_slice(
            &numbers.map(i64::from).collect::<Vec<i64>>(),
        )),
    }
}
