//! The nodes of cells as files list them, for ranks that write the nodes of their own cells.

use super::column::{Sink, stream_integers};
use super::vtk::order;
use super::{cgns, ugrid};
use crate::mesh::reverse_each;
use crate::mesh::{Cells, Listing, NodesOfCells};
use azimesh_core::error::Result;
use std::ops::Range;

/// Numbers made at a time: so few that no loop over them starts threads.
const BLOCK: usize = 1 << 16;

/// Passes the bytes of the nodes of some `cells` to `sink`, by this thread alone; `number` gives the number of a node from 0.
pub fn list_nodes(
    cells: &Cells,
    range: Range<usize>,
    wanted: &NodesOfCells,
    number: &(dyn Fn(u32) -> u32 + Sync),
    sink: Sink,
) -> Result<()> {
    let is_wide = wanted.is_wide;
    let mut swapped = Vec::new();
    let mut swap = |bytes: &[u8]| {
        swapped.clear();
        swapped.extend_from_slice(bytes);
        reverse_each(&mut swapped, wanted.size());
        sink(&swapped)
    };
    let sink: Sink = if wanted.is_big_endian {
        &mut swap
    } else {
        sink
    };
    for run in cells.runs_in(range).filter(|run| wanted.lists(run.kind)) {
        let step = (BLOCK / run.n_nodes).max(1);
        for start in run.range().step_by(step) {
            let some = start..run.range().end.min(start + step);
            match wanted.listing {
                Listing::Vtk => {
                    for nodes in cells.runs_in(some) {
                        let nodes = order::listed(nodes.kind, nodes.connectivity);
                        as_integers(&nodes, is_wide, number, sink)?;
                    }
                }
                Listing::Ugrid => {
                    for nodes in cells.runs_in(some) {
                        let nodes = ugrid::in_order(nodes.kind, nodes.connectivity);
                        as_integers(&nodes, is_wide, &|node| number(node) + 1, sink)?;
                    }
                }
                Listing::Cgns => cgns::list_elements(cells, some, is_wide, number, sink)?,
                Listing::CgnsMixed => cgns::list_mixed(cells, some, is_wide, number, sink)?,
            }
        }
    }
    Ok(())
}

fn as_integers(
    nodes: &[u32],
    is_wide: bool,
    number: &dyn Fn(u32) -> u32,
    sink: Sink,
) -> Result<()> {
    let numbers = nodes.iter().map(|&node| i64::from(number(node)));
    stream_integers(numbers, is_wide, sink)
}
