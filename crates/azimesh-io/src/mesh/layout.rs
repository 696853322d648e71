//! The layout of a distributed mesh, which the first rank writes.

use super::{CellKind, Cells, Mesh};
use azimesh_core::sparse;

impl Mesh {
    /// Gathers the kinds of all cells of the mesh on the first rank. Its nodes and the nodes of its cells are sparse arrays, which
    /// take no memory; ranks write their values. All ranks call it.
    pub(crate) fn layout_of(part: &Self) -> Option<Self> {
        let runs = part.cells.runs_in(part.own_cells());
        let own: Vec<(CellKind, usize, usize)> = runs
            .map(|run| (run.kind, run.n_nodes, run.n_cells()))
            .collect();
        let all = part.ranks().gather(own)?;
        Some(Self {
            points: sparse::zeros(part.n_nodes_of_all(), [0.0; 3]),
            cells: Cells::of_kinds(all.into_iter().flatten(), 0),
            space: part.space,
            ..Self::default()
        })
    }
}
