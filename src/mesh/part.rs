//! A part of a mesh whose other parts lie with other ranks.
//!
//! Each rank answers for consecutive cells of the whole mesh, its own. Beside them it holds the cells that share a face
//! with them and the boundary faces that touch them, so that all that is asked of an own cell can be answered without a
//! message. Nodes and cells of a part are in the order of the whole mesh: what comes first there comes first here, and ties
//! that go to the lowest index go the same way.

use super::{CellSet, Group, Mesh, Origin};
use crate::error::Result;
use crate::parallel;
use crate::ranks::Ranks;
use crate::ranks::raw;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Own cells begin at multiples of this: no block over which sums are taken lies with two ranks.
pub const SLAB: usize = 1 << 15;

/// What a part of a mesh knows of the whole.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Part {
    /// All ranks; each has a part.
    #[serde(skip)]
    pub ranks: Ranks,
    /// Whether all nodes of the whole mesh have the same z.
    pub is_level: bool,
    /// For each node here its number in the whole mesh, ascending.
    #[serde(with = "raw")]
    pub nodes: Vec<u32>,
    /// For each cell here its number in the whole mesh, ascending.
    #[serde(with = "raw")]
    pub cells: Vec<u32>,
    /// The own cells among those here.
    pub own_cells: Range<usize>,
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.own_cells == other.own_cells && self.nodes == other.nodes && self.cells == other.cells
    }
}

/// The own cells of each of `n` ranks.
fn slab(n_cells: usize, rank: usize, n: usize) -> Range<usize> {
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

    /// Whether all nodes have the same z; of a part whether those of the whole mesh have.
    pub fn is_level(&self) -> bool {
        let is_here = || self.points.windows(2).all(|pair| pair[0][2] == pair[1][2]);
        self.part
            .as_ref()
            .map_or_else(is_here, |part| part.is_level)
    }

    /// The cells that this rank answers for: all, or those of its part.
    pub fn own_cells(&self) -> Range<usize> {
        match &self.part {
            None => 0..self.cells.len(),
            Some(part) => part.own_cells.clone(),
        }
    }

    /// By how much the number of an own cell in the whole mesh is larger than here.
    pub fn own_offset(&self) -> usize {
        let Some(part) = &self.part else { return 0 };
        let first = part.own_cells.start;
        part.cells
            .get(first)
            .map_or(0, |&number| number as usize - first)
    }

    /// Gives each rank a part of the mesh that rank 0 has.
    ///
    /// # Errors
    /// That of rank 0, on all ranks, where it has none.
    pub fn shared(of_first: Result<Self>, ranks: &Ranks) -> Result<Self> {
        if ranks.n() == 1 {
            return of_first;
        }
        let of_first = match ranks.is_first() {
            true => of_first.map(Some),
            false => Ok(None),
        };
        let whole = ranks.agree(of_first)?;
        Ok(Self::shared_of(whole.as_ref(), ranks).0)
    }

    /// Gives each rank a part of the mesh that rank 0 has, without its arrays; rank 0 learns the nodes of each part.
    pub(crate) fn shared_of(whole: Option<&Self>, ranks: &Ranks) -> (Self, Vec<Vec<u32>>) {
        let mut nodes = vec![Vec::new(); ranks.n()];
        let mut parcel = |rank: usize| {
            let parcel = whole?.parcel(rank, ranks.n());
            nodes[rank].clone_from(&parcel.part.nodes);
            Some(parcel)
        };
        let Parcel { mut mesh, mut part } = ranks.scatter(&mut parcel);
        part.ranks = ranks.clone();
        mesh.part = Some(Arc::new(part));
        (mesh, nodes)
    }

    /// The part of a rank.
    fn parcel(&self, rank: usize, n: usize) -> Parcel {
        let own = slab(self.cells.len(), rank, n);
        let cells = self.cells_of_part(&own);
        let mut is_here = vec![false; self.points.len()];
        let runs: Vec<Range<usize>> = cells
            .chunk_by(|a, b| a + 1 == *b)
            .map(|run| run[0]..run[run.len() - 1] + 1)
            .collect();
        for run in runs.iter().flat_map(|run| self.cells.runs_in(run.clone())) {
            for &node in run.connectivity {
                is_here[node as usize] = true;
            }
        }
        let nodes = parallel::filter_map(is_here.len(), |node| is_here[node].then_some(node));
        let mut new_index = vec![u32::MAX; self.points.len()];
        for (new, &old) in (0..).zip(&nodes) {
            new_index[old] = new;
        }
        let mut own_cells = self.cells.select_runs(&runs);
        own_cells.renumber_nodes(&new_index);
        let place = |cell: usize| cells.partition_point(|&here| here < cell);
        let group = |group: &Group| Group {
            cells: group
                .cells
                .ranges()
                .flat_map(|range| place(range.start)..place(range.end))
                .collect::<CellSet>(),
            ..group.clone()
        };
        let part = Part {
            ranks: Ranks::alone(),
            is_level: self.is_level(),
            own_cells: place(own.start)..place(own.end),
            nodes: nodes.iter().map(|&node| node as u32).collect(),
            cells: cells.iter().map(|&cell| cell as u32).collect(),
        };
        let mesh = Self {
            points: parallel::collect(nodes.len(), |i| self.points[nodes[i]]),
            groups: self.groups.iter().map(group).collect(),
            point_arrays: Vec::new(),
            cell_arrays: Vec::new(),
            field_arrays: Vec::new(),
            // A rank without cells of that dimension knows it from here.
            space: (self.dimension() > 0).then(|| self.dimension()),
            origin: Origin::default(),
            part: None,
            cells: own_cells,
        };
        Parcel { mesh, part }
    }

    /// Own cells, cells that have as many nodes of them as a face has, and boundary faces that have one; ascending.
    fn cells_of_part(&self, own: &Range<usize>) -> Vec<usize> {
        let mut is_near = vec![false; self.points.len()];
        let dimension = self.dimension();
        for run in self.cells.runs_in(own.clone()) {
            for &node in run.connectivity {
                is_near[node as usize] = true;
            }
        }
        let n_near = |nodes: &[u32]| nodes.iter().filter(|&&node| is_near[node as usize]).count();
        parallel::concat_blocks(self.cells.len(), SLAB, &|range| {
            let mut found = Vec::new();
            for run in self.cells.runs_in(range) {
                let wanted = match run.kind.dimension() {
                    of if of == dimension => usize::from(dimension).max(1),
                    of if of + 1 == dimension => 1,
                    _ => usize::MAX,
                };
                let cells = (run.first_cell..).zip(run.cells());
                let near =
                    cells.filter(|(cell, nodes)| own.contains(cell) || n_near(nodes) >= wanted);
                found.extend(near.map(|(cell, _)| cell));
            }
            found
        })
    }
}

/// A part of a mesh with what it knows of the whole, as it is sent.
#[derive(Serialize, Deserialize)]
struct Parcel {
    mesh: Mesh,
    part: Part,
}
