//! Finds the cells that have a node of a set, without a pass over all of them.
//!
//! Cells are looked at in blocks, and nodes are known by pages of consecutive ones. Where neighbours have near numbers,
//! as most programs write them, a block has nodes of few pages; a block of many is looked at always.

use azimesh_core::parallel;
use azimesh_io::mesh::Mesh;

/// Cells of a block.
const BLOCK: usize = 512;
/// Nodes of a page.
const PAGE: usize = 64;
/// A block with more pages than this is looked at always.
const MOST_PAGES: usize = 256;
/// Blocks that are looked at by one thread.
const TOGETHER: usize = 32;

/// The pages of each block.
pub(super) struct Nearby<'a> {
    mesh: &'a Mesh,
    /// Ascending; `None` for a block of many.
    pages: Vec<Option<Vec<u32>>>,
}

/// A set of nodes.
pub(super) struct Marked {
    nodes: Vec<bool>,
    pages: Vec<bool>,
}

impl Marked {
    /// The empty set.
    pub(super) fn new(n_nodes: usize) -> Self {
        Self {
            nodes: vec![false; n_nodes],
            pages: vec![false; n_nodes.div_ceil(PAGE)],
        }
    }

    pub(super) fn insert(&mut self, node: u32) {
        self.nodes[node as usize] = true;
        self.pages[node as usize / PAGE] = true;
    }

    #[inline]
    pub(super) fn has(&self, node: u32) -> bool {
        self.nodes[node as usize]
    }
}

impl<'a> Nearby<'a> {
    /// Looks at all cells once.
    pub(super) fn new(mesh: &'a Mesh) -> Self {
        let n_blocks = mesh.cells.len().div_ceil(BLOCK);
        let pages = parallel::map_blocks(n_blocks, TOGETHER, &|blocks| {
            let of = |block| pages_of(mesh, parallel::block(mesh.cells.len(), BLOCK, block));
            blocks.map(of).collect::<Vec<_>>()
        });
        Self {
            mesh,
            pages: pages.into_iter().flatten().collect(),
        }
    }

    pub(super) fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// The cells of the mesh's dimension with a node in `marked` for which `wanted` holds, ascending.
    pub(super) fn cells_with(
        &self,
        marked: &Marked,
        wanted: &(dyn Fn(u32) -> bool + Sync),
    ) -> Vec<u32> {
        let is_near = |block: &usize| match &self.pages[*block] {
            Some(pages) => pages.iter().any(|&page| marked.pages[page as usize]),
            None => true,
        };
        let near: Vec<usize> = (0..self.pages.len()).filter(is_near).collect();
        let n_cells = self.mesh.cells.len();
        parallel::concat_blocks(near.len(), TOGETHER, &|range| {
            let mut found = Vec::new();
            for &block in &near[range] {
                for run in self
                    .mesh
                    .volume_runs_in(parallel::block(n_cells, BLOCK, block))
                {
                    for (i, nodes) in run.cells().enumerate() {
                        let mut own = nodes.iter();
                        if own.any(|&node| marked.has(node) && wanted(node)) {
                            found.push((run.first_cell + i) as u32);
                        }
                    }
                }
            }
            found
        })
    }

    /// The cells that have one of these nodes, ascending.
    pub(super) fn cells_of(&self, nodes: &[u32]) -> Vec<u32> {
        let mut marked = Marked::new(self.mesh.points.len());
        nodes.iter().for_each(|&node| marked.insert(node));
        self.cells_with(&marked, &|_| true)
    }
}

/// The pages of the nodes of some cells.
fn pages_of(mesh: &Mesh, cells: std::ops::Range<usize>) -> Option<Vec<u32>> {
    let mut pages: Vec<u32> = Vec::new();
    for run in mesh.volume_runs_in(cells) {
        // A corner is mostly in the same page as the corner of the last cell.
        let mut last = [u32::MAX; 8];
        for nodes in run.cells() {
            for (i, &node) in nodes.iter().enumerate() {
                let page = node / PAGE as u32;
                if std::mem::replace(&mut last[i % 8], page) != page {
                    pages.push(page);
                }
            }
        }
    }
    pages.sort_unstable();
    pages.dedup();
    (pages.len() <= MOST_PAGES).then_some(pages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repair::tests::grid;
    use azimesh_io::mesh::{CellKind, CellRef};

    #[test]
    fn the_cells_of_nodes_are_those_of_a_look_at_all() {
        let ordered = grid(CellKind::Quadrilateral, 60);
        // The same with far nodes side by side: blocks of many pages.
        let n = ordered.points.len() as u32;
        let mut shuffled = Mesh {
            points: ordered.points.clone(),
            ..Mesh::default()
        };
        for cell in ordered.cells.iter() {
            let nodes: Vec<u32> = cell.nodes.iter().map(|&node| node * 1001 % n).collect();
            shuffled.cells.push(cell.kind, &nodes);
        }
        let few = |nearby: &Nearby<'_>| nearby.pages.iter().filter(|pages| pages.is_some()).count();
        assert_eq!(few(&Nearby::new(&ordered)), 8);
        for mesh in [&ordered, &shuffled] {
            let nodes = [0, 5, 700, n - 1];
            let has = |cell: &CellRef<'_>| cell.nodes.iter().any(|node| nodes.contains(node));
            let wanted = mesh.cells.iter().filter(has).map(|cell| cell.index as u32);
            let found = Nearby::new(mesh).cells_of(&nodes);
            assert_eq!(found, wanted.collect::<Vec<_>>());
            assert!(found.len() > 6);
        }
    }
}
