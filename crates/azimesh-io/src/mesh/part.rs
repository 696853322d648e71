//! One rank's part of a distributed mesh.
//!
//! Each rank owns consecutive cells of the whole mesh. It also holds the cells that share a face with them and the boundary
//! faces that touch them, so that computations on own cells need no messages. Nodes and cells of a part are in the order of
//! the whole mesh, so ties that go to the lowest index have the same result.
//!
//! Each rank also owns consecutive nodes of the whole mesh. It holds them even if no cell of its part has them.
//!
//! A part that was read by slabs ([`Mesh::from_slabs`]) has no groups until it gets them by [`Mesh::set_whole_groups`].

use super::from_slabs::Owners;
use super::{CellKind, CellSet, Cells, Group, Mesh};
use azimesh_core::error::Result;
use azimesh_core::ranks::Ranks;
use azimesh_core::ranks::raw;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Own cells begin at multiples of this, so that no block of a sum is divided between ranks.
pub const SLAB: usize = 1 << 15;
/// Own nodes begin at multiples of this.
const NODE_SLAB: usize = 256;

/// Data of a part about the whole mesh.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct RankPart {
    /// All ranks; each has a part.
    #[serde(skip)]
    pub ranks: Ranks,
    /// Number of nodes of the whole mesh.
    pub n_nodes: usize,
    /// Number of cells of the whole mesh.
    pub n_cells: usize,
    /// The groups of the whole mesh, with its numbers of cells.
    pub groups: Vec<Group>,
    /// For each rank its own nodes, by their numbers in the whole mesh.
    pub owners: Vec<Range<usize>>,
    /// True if all nodes of the whole mesh have the same z.
    pub is_level: bool,
    /// For each node here its number in the whole mesh, ascending.
    #[serde(with = "raw")]
    pub nodes: Vec<u32>,
    /// For each cell here its number in the whole mesh, ascending.
    #[serde(with = "raw")]
    pub cells: Vec<u32>,
    /// The own cells among those here.
    pub own_cells: Range<usize>,
    /// The own nodes among those here.
    pub own_nodes: Range<usize>,
}

impl PartialEq for RankPart {
    fn eq(&self, other: &Self) -> bool {
        self.own_cells == other.own_cells
            && self.own_nodes == other.own_nodes
            && self.nodes == other.nodes
            && self.cells == other.cells
    }
}

/// The own nodes of each of `n` ranks, of `n_nodes` in the whole mesh.
pub(crate) fn node_slab(n_nodes: usize, rank: usize, n: usize) -> Range<usize> {
    let start = |rank: usize| (rank * n_nodes.div_ceil(NODE_SLAB) / n * NODE_SLAB).min(n_nodes);
    start(rank)..start(rank + 1)
}

/// The own nodes of all of `n` ranks.
pub(super) fn node_slabs(n_nodes: usize, n: usize) -> Vec<Range<usize>> {
    (0..n).map(|rank| node_slab(n_nodes, rank, n)).collect()
}

/// The rank that owns a node of the whole mesh.
pub(super) fn owner_of(node: u32, owners: &[Range<usize>]) -> usize {
    owners.partition_point(|own| own.end <= node as usize)
}

/// Positions of consecutive nodes of the whole mesh among `nodes`, which ascend and contain all of them.
pub(super) fn places_of(slab: &Range<usize>, nodes: &[u32]) -> Range<usize> {
    let start = nodes.partition_point(|&node| (node as usize) < slab.start);
    start..start + slab.len()
}

/// The own cells of each of `n` ranks.
pub(super) fn slab(n_cells: usize, rank: usize, n: usize) -> Range<usize> {
    let n_slabs = n_cells.div_ceil(SLAB);
    let start = |rank: usize| (rank * n_slabs / n * SLAB).min(n_cells);
    start(rank)..start(rank + 1)
}

impl Mesh {
    /// The ranks that hold the mesh: this one alone, unless it is a part.
    pub fn ranks(&self) -> Ranks {
        self.part
            .as_ref()
            .map_or_else(Ranks::alone, |part| part.ranks.clone())
    }

    /// Returns whether all nodes of the whole mesh have the same z.
    pub fn is_level(&self) -> bool {
        let is_here = || self.points.windows(2).all(|pair| pair[0][2] == pair[1][2]);
        self.part
            .as_ref()
            .map_or_else(is_here, |part| part.is_level)
    }

    /// The cells that this rank owns; all if the mesh is not a part.
    pub fn own_cells(&self) -> Range<usize> {
        match &self.part {
            None => 0..self.cells.len(),
            Some(part) => part.own_cells.clone(),
        }
    }

    /// Number of nodes of the whole mesh.
    pub(crate) fn n_nodes_of_all(&self) -> usize {
        let part = self.part.as_ref();
        part.map_or(self.points.len(), |part| part.n_nodes)
    }

    /// By how much the number of an own cell in the whole mesh is larger than here.
    pub fn own_offset(&self) -> usize {
        let Some(part) = &self.part else { return 0 };
        let first = part.own_cells.start;
        part.cells
            .get(first)
            .map_or(0, |&number| number as usize - first)
    }

    /// Number of cells of the whole mesh.
    pub fn n_cells_of_all(&self) -> usize {
        let part = self.part.as_ref();
        part.map_or(self.cells.len(), |part| part.n_cells)
    }

    /// The groups of the whole mesh, with its numbers of cells.
    pub fn groups_of_all(&self) -> &[Group] {
        let part = self.part.as_ref();
        part.map_or(&self.groups, |part| &part.groups)
    }

    /// Sets the groups of the whole mesh. A part also gets the cells of each group that it has.
    pub fn set_whole_groups(&mut self, groups: Vec<Group>) {
        let Some(part) = &mut self.part else {
            self.groups = groups;
            return;
        };
        let place = |cell: usize| part.cells.partition_point(|&here| (here as usize) < cell);
        let here = |group: &Group| {
            let mut cells = CellSet::new();
            for range in group.cells.ranges() {
                cells.push_range(place(range.start)..place(range.end));
            }
            Group {
                cells,
                ..group.clone()
            }
        };
        self.groups = groups.iter().map(here).collect();
        Arc::make_mut(part).groups = groups;
    }

    /// The nodes that this rank owns: all, or the own nodes of its part.
    pub fn own_nodes(&self) -> Range<usize> {
        match &self.part {
            None => 0..self.points.len(),
            Some(part) => part.own_nodes.clone(),
        }
    }

    /// The number of the first own node in the whole mesh.
    pub fn first_own_node(&self) -> usize {
        let part = self.part.as_ref();
        part.map_or(0, |part| part.owners[part.ranks.rank()].start)
    }

    /// Reports if this rank owns a node.
    pub fn owns_node(&self, node: u32) -> bool {
        self.own_nodes().contains(&(node as usize))
    }

    /// The number of a node in the whole mesh.
    #[inline]
    pub fn number_of_node(&self, node: u32) -> u32 {
        match &self.part {
            None => node,
            Some(part) => part.nodes[node as usize],
        }
    }

    /// The node here that has this number in the whole mesh.
    pub fn node_here(&self, number: u32) -> Option<u32> {
        match &self.part {
            None => ((number as usize) < self.points.len()).then_some(number),
            Some(part) => place_in(&part.nodes, &part.own_nodes, number),
        }
    }

    /// The number of a cell in the whole mesh.
    #[inline]
    pub fn number_of_cell(&self, cell: u32) -> u32 {
        match &self.part {
            None => cell,
            Some(part) => part.cells[cell as usize],
        }
    }

    /// The cell here that has this number in the whole mesh.
    pub fn cell_here(&self, number: u32) -> Option<u32> {
        match &self.part {
            None => ((number as usize) < self.cells.len()).then_some(number),
            Some(part) => place_in(&part.cells, &part.own_cells, number),
        }
    }

    /// Gives each rank a part of the mesh that rank 0 has.
    ///
    /// # Errors
    /// On all ranks, the error of rank 0 if it has no mesh.
    pub fn shared(of_first: Result<Self>, ranks: &Ranks) -> Result<Self> {
        if ranks.n() == 1 {
            return of_first;
        }
        let of_first = if ranks.is_first() {
            of_first.map(Some)
        } else {
            Ok(None)
        };
        let whole = ranks.all_ok(of_first)?;
        Ok(Self::shared_of(whole.as_ref(), ranks))
    }

    /// Gives each rank a part of the mesh that rank 0 has, without its arrays.
    pub fn shared_of(whole: Option<&Self>, ranks: &Ranks) -> Self {
        let mut own = |rank: usize| {
            let whole = whole?;
            let counts @ [n_nodes, n_cells] = [whole.points.len(), whole.cells.len()];
            Some(Slab {
                points: whole.points[node_slab(n_nodes, rank, ranks.n())].to_vec(),
                cells: whole.cells.select_runs(&[slab(n_cells, rank, ranks.n())]),
                counts,
                dimension: whole.dimension(),
            })
        };
        let own = ranks.scatter(&mut own);
        let owners = Owners::new(node_slabs(own.counts[0], ranks.n()), ranks);
        let [_, n_cells] = own.counts;
        let cells = slab(n_cells, ranks.rank(), ranks.n());
        let mut part = owners.mesh(own.points, own.cells, cells, own.dimension, n_cells);
        part.set_whole_groups(ranks.broadcast(whole.map(|whole| whole.groups.clone())));
        part
    }
}

/// Position of a number among ascending numbers, which have no gaps in the range `own`.
fn place_in(numbers: &[u32], own: &Range<usize>, number: u32) -> Option<u32> {
    if let Some(first) = numbers[own.clone()].first()
        && let Some(at) = number.checked_sub(*first)
        && (at as usize) < own.len()
    {
        return Some(own.start as u32 + at);
    }
    numbers.binary_search(&number).ok().map(|at| at as u32)
}

/// Number of nodes of a cell at which another rank must own cells in order to hold the cell: enough for a face, or one for a
/// boundary face. `None` for cells that other ranks do not need.
pub(super) fn nodes_to_share(kind: CellKind, dimension: u8) -> Option<u32> {
    match kind.dimension() {
        of if of == dimension => Some(u32::from(dimension).max(1)),
        of if of + 1 == dimension => Some(1),
        _ => None,
    }
}

/// Counts a rank once more.
pub(super) fn count(counts: &mut Vec<(u32, u32)>, rank: u32) {
    match counts.iter_mut().find(|of| of.0 == rank) {
        Some((_, n)) => *n += 1,
        None => counts.push((rank, 1)),
    }
}

/// The own nodes and cells of a rank, with the counts of the whole mesh and its dimension.
#[derive(Serialize, Deserialize)]
struct Slab {
    #[serde(with = "raw")]
    points: Vec<[f64; 3]>,
    cells: Cells,
    counts: [usize; 2],
    dimension: u8,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_belongs_to_one_rank() {
        for n_nodes in [1, 255, 256, 257, 1000, 5000] {
            for n in [1, 2, 3, 7, 30] {
                let mut end = 0;
                for rank in 0..n {
                    let slab = node_slab(n_nodes, rank, n);
                    assert_eq!(slab.start, end);
                    end = slab.end;
                    let slabs = node_slabs(n_nodes, n);
                    let rank_of = |node: usize| owner_of(node as u32, &slabs);
                    assert!(slab.into_iter().all(|node| rank_of(node) == rank));
                }
                assert_eq!(end, n_nodes);
            }
        }
    }
}
