//! Makes the parts of a mesh from slabs of its nodes and cells. Each rank reads its own slab; no rank has the whole mesh.
//!
//! Every node has an owner, the rank that reads its coordinates. Ranks report to owners the nodes at which they have cells, and
//! learn which other ranks have cells there; so each rank knows which of its cells others need. Memory per rank grows with its
//! part.

use super::node_bits::NodeBits;
use super::numbering::Numbering;
use super::part::{self, RankPart, SLAB};
use super::{Cells, Mesh, first_where};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel;
use azimesh_core::ranks::{Ranks, raw};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// A mesh whose nodes and cells are available by ranges.
pub struct MeshByRanges<'a> {
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of cells.
    pub n_cells: usize,
    /// [`Mesh::space`] of it.
    pub space: Option<u8>,
    /// The coordinates of some nodes.
    pub points: &'a dyn Fn(Range<usize>) -> Result<Vec<[f64; 3]>>,
    /// Some cells.
    pub cells: &'a dyn Fn(Range<usize>) -> Result<Cells>,
}

/// Cells of a part that another rank has, with their numbers in the whole mesh, ascending.
#[derive(Default, Serialize, Deserialize)]
struct Needed {
    #[serde(with = "raw")]
    numbers: Vec<u32>,
    cells: Cells,
}

impl Mesh {
    /// The part of each rank, as [`Mesh::shared`] cuts it from the whole, but without groups. All ranks call it.
    ///
    /// # Errors
    /// On all ranks, where one cannot read, a mesh of these nodes and cells would not be [valid](Mesh::validate) or, with
    /// `faces_once`, boundary faces have the same nodes.
    pub fn from_slabs(slabs: &MeshByRanges, faces_once: bool, ranks: &Ranks) -> Result<Self> {
        let owners = Owners::new(part::node_slabs(slabs.n_nodes, ranks.n()), ranks);
        let own = part::slab(slabs.n_cells, ranks.rank(), ranks.n());
        let cells = ranks.all_ok(own_cells(slabs, own.clone()))?;
        let here = cells.dimension().max(slabs.space.unwrap_or(0));
        let dimension = ranks.allgather(here).into_iter().max().unwrap_or(0);
        if faces_once {
            owners.check_faces(&cells, dimension)?;
        }
        let points = ranks.all_ok(own_points(slabs, owners.own()))?;
        Ok(owners.mesh(points, cells, own, dimension, slabs.n_cells))
    }
}

fn own_cells(slabs: &MeshByRanges, own: Range<usize>) -> Result<Cells> {
    let cells = (slabs.cells)(own.clone())?;
    let wrong = |message: String| Err(Error::input(message));
    if cells.len() != own.len() {
        return wrong(format!("{} of cells {own:?} are there", cells.len()));
    }
    let n_nodes = slabs.n_nodes;
    let outside = |node: &u32| *node as usize >= n_nodes;
    match first_where(cells.connectivity(), outside) {
        Some(at) => wrong(format!("there is no node {}", cells.connectivity()[at])),
        None => Ok(cells),
    }
}

/// The nodes of cells and the nodes of a range, each once, ascending.
fn nodes_of(cells: &Cells, and: Range<usize>) -> Vec<u32> {
    let listed = cells.connectivity();
    let ends = parallel::map_blocks(listed.len(), SLAB, &|block| {
        let (mut low, mut high) = (u32::MAX, 0);
        for &node in &listed[block] {
            (low, high) = (low.min(node), high.max(node));
        }
        low as usize..high as usize + 1
    });
    let ends = ends
        .into_iter()
        .chain((!and.is_empty()).then(|| and.clone()));
    let all = ends.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
    let all = all.unwrap_or(0..0);
    if all.len() / 64 > listed.len() + and.len() {
        let mut nodes = listed.to_vec();
        nodes.extend(and.map(|node| node as u32));
        parallel::sort(&mut nodes);
        nodes.dedup();
        return nodes;
    }
    let bits = NodeBits::new(&all);
    bits.add_nodes_of(cells, std::slice::from_ref(&(0..cells.len())));
    bits.add_all(&and);
    bits.take()
}

/// The own nodes of each rank, which are consecutive.
pub(super) struct Owners<'a> {
    ranks: &'a Ranks,
    nodes: Vec<Range<usize>>,
}

impl<'a> Owners<'a> {
    pub fn new(nodes: Vec<Range<usize>>, ranks: &'a Ranks) -> Self {
        Self { ranks, nodes }
    }

    fn own(&self) -> Range<usize> {
        self.nodes[self.ranks.rank()].clone()
    }

    /// The part of this rank of a mesh of this dimension with `n_cells`, from its own nodes and its own cells, whose numbers
    /// are `own`. All ranks call it.
    pub fn mesh(
        &self,
        points: Vec<[f64; 3]>,
        cells: Cells,
        own: Range<usize>,
        dimension: u8,
        n_cells: usize,
    ) -> Mesh {
        let (cells, part) = self.part(cells, own, dimension, n_cells);
        let (points, is_level) = self.points(points, &part.nodes);
        Mesh {
            points,
            cells,
            space: (dimension > 0).then_some(dimension),
            part: Some(Arc::new(RankPart { is_level, ..part })),
            ..Mesh::default()
        }
    }

    /// Gives the cells of a part and what it knows of the whole, from its own cells: consecutive ones of a mesh of this dimension
    /// with `n_cells`, with the numbers of nodes of that mesh. All ranks call it.
    fn part(
        &self,
        cells: Cells,
        own: Range<usize>,
        dimension: u8,
        n_cells: usize,
    ) -> (Cells, RankPart) {
        let others = self.others(nodes_of(&cells, 0..0));
        let needed = needed(&cells, dimension, &others, self.ranks.n());
        drop(others);
        let (numbers, own_cells, mut cells) = with_needed(cells, own, needed, self.ranks);
        let own_nodes = self.own();
        let nodes = nodes_of(&cells, own_nodes.clone());
        let numbering = Numbering::new(&nodes);
        let (first, own_places) = (own_nodes.start as u32, part::places_of(&own_nodes, &nodes));
        cells.renumber_nodes_by(|node| {
            if own_nodes.contains(&(node as usize)) {
                own_places.start as u32 + (node - first)
            } else {
                numbering.of(node)
            }
        });
        let part = RankPart {
            ranks: self.ranks.clone(),
            n_nodes: self.nodes.last().map_or(0, |last| last.end),
            n_cells,
            groups: Vec::new(),
            owners: self.nodes.clone(),
            is_level: false,
            own_nodes: own_places,
            nodes,
            cells: numbers,
            own_cells,
        };
        (cells, part)
    }

    /// Nodes, ascending, by their owners.
    fn split(&self, nodes: &[u32]) -> Vec<Vec<u32>> {
        let before = |end: usize| nodes.partition_point(|&node| (node as usize) < end);
        let of_rank = |rank: usize| {
            let Range { start, end } = self.nodes[rank];
            nodes[before(start)..before(end)].to_vec()
        };
        (0..self.ranks.n()).map(of_rank).collect()
    }

    /// For some of the nodes of this rank, those where others have cells, each of these; ascending.
    fn others(&self, nodes: Vec<u32>) -> Vec<[u32; 2]> {
        let of_owners = self.split(&nodes);
        drop(nodes);
        let asked = self.ranks.alltoallv(of_owners);
        let own = self.own();
        let mut n_ranks = vec![0u32; own.len()];
        for &node in asked.iter().flatten() {
            n_ranks[node as usize - own.start] += 1;
        }
        let is_shared = |node: &u32| n_ranks[*node as usize - own.start] > 1;
        let shared = (0u32..).zip(&asked).flat_map(|(rank, nodes)| {
            let nodes = nodes.iter().filter(|node| is_shared(node));
            nodes.map(move |&node| [node, rank])
        });
        let mut shared: Vec<[u32; 2]> = shared.collect();
        parallel::sort(&mut shared);
        let mut answers = vec![Vec::new(); self.ranks.n()];
        for of_node in shared.chunk_by(|a, b| a[0] == b[0]) {
            for &[_, rank] in of_node {
                let others = of_node.iter().filter(|other| other[1] != rank);
                answers[rank as usize].extend(others);
            }
        }
        self.ranks.alltoallv(answers).concat()
    }

    /// Returns the coordinates of ascending nodes, own nodes included, and whether all nodes of the mesh have the same z.
    /// `points` are the coordinates of the own nodes.
    fn points(&self, mut points: Vec<[f64; 3]>, nodes: &[u32]) -> (Vec<[f64; 3]>, bool) {
        let own = self.own();
        let is_level = points.windows(2).all(|pair| pair[0][2] == pair[1][2]);
        let of_ranks = self
            .ranks
            .allgather((points.first().map(|x| x[2]), is_level));
        let heights: Vec<f64> = of_ranks.iter().filter_map(|(z, _)| *z).collect();
        let is_level = of_ranks.iter().all(|(_, is_level)| *is_level)
            && heights.windows(2).all(|pair| pair[0] == pair[1]);
        let mut of_others = self.split(nodes);
        of_others[self.ranks.rank()] = Vec::new();
        let asked = self.ranks.alltoallv(of_others);
        let places = |nodes: Vec<u32>| {
            let place = |i: usize| points[nodes[i] as usize - own.start];
            parallel::collect(nodes.len(), place)
        };
        let answers = asked.into_iter().map(places).collect();
        let answers = self.ranks.alltoallv(answers);
        let (below, above) = answers.split_at(self.ranks.rank());
        // The others, whose memory is small, go around the own ones, which stay where they are.
        let n_others: usize = answers.iter().map(Vec::len).sum();
        points.reserve_exact(n_others);
        points.splice(0..0, below.concat());
        above.iter().for_each(|above| points.extend(above));
        (points, is_level)
    }

    /// Refuses boundary faces that have the same nodes. They meet at the owner of their lowest node, as numbers that differ where
    /// their nodes do, but once in a very great while.
    fn check_faces(&self, cells: &Cells, dimension: u8) -> Result<()> {
        let mut to_each = vec![Vec::new(); self.ranks.n()];
        number_faces(cells, dimension, |lowest, number| {
            let owner = part::owner_of(lowest, &self.nodes);
            to_each[owner].push(number);
        });
        let faces = self.ranks.alltoallv(to_each).concat();
        self.ranks.all_ok(check_once(faces))
    }
}

/// For each boundary face its lowest node, and a number that all of its nodes make.
fn number_faces(cells: &Cells, dimension: u8, mut take: impl FnMut(u32, u64)) {
    let runs = cells.runs();
    for run in runs.filter(|run| run.kind.dimension() + 1 == dimension) {
        for nodes in run.cells() {
            let mut nodes = nodes.to_vec();
            nodes.sort_unstable();
            let start = u64::from(run.kind.vtk());
            take(
                nodes[0],
                nodes.iter().fold(start, |hash, &node| mixed(hash, node)),
            );
        }
    }
}

fn check_once(mut faces: Vec<u64>) -> Result<()> {
    parallel::sort(&mut faces);
    if faces.windows(2).any(|pair| pair[0] == pair[1]) {
        Err(Error::input("boundary faces have the same nodes"))
    } else {
        Ok(())
    }
}

/// A number of 64 bits that all bits of both depend on.
fn mixed(hash: u64, node: u32) -> u64 {
    let mut x = (hash ^ u64::from(node)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

fn own_points(slabs: &MeshByRanges, own: Range<usize>) -> Result<Vec<[f64; 3]>> {
    let points = (slabs.points)(own.clone())?;
    let wrong = |message: String| Err(Error::input(message));
    if points.len() != own.len() {
        return wrong(format!("{} of nodes {own:?} are there", points.len()));
    }
    match first_where(&points, |x| !x.iter().all(|x| x.is_finite())) {
        Some(at) => wrong(format!(
            "a coordinate of node {} is not finite",
            own.start + at
        )),
        None => Ok(points),
    }
}

/// For each rank, ascending, the cells of this one that it needs, by their places among these.
fn needed(cells: &Cells, dimension: u8, others: &[[u32; 2]], n_ranks: usize) -> Vec<Vec<u32>> {
    let shared: Vec<u32> = others.iter().map(|other| other[0]).collect();
    let ends = match (shared.first(), shared.last()) {
        (Some(&first), Some(&last)) => first as usize..last as usize + 1,
        _ => 0..0,
    };
    // Most cells have none of them.
    let is_shared = NodeBits::new(&ends);
    is_shared.add(&shared);
    let shared = Numbering::new(&shared);
    let found = parallel::concat_blocks(cells.len(), SLAB, &|range| {
        let mut found = Vec::new();
        let mut counts: Vec<(u32, u32)> = Vec::new();
        for run in cells.runs_in(range) {
            let Some(wanted) = part::nodes_to_share(run.kind, dimension) else {
                continue;
            };
            for (cell, nodes) in (run.first_cell..).zip(run.cells()) {
                if !nodes.iter().any(|&node| is_shared.has(node)) {
                    continue;
                }
                counts.clear();
                for &node in nodes {
                    let others = shared.places(node).map(|at| others[at][1]);
                    others.for_each(|rank| part::count(&mut counts, rank));
                }
                let sharing = counts.iter().filter(|(_, n)| *n >= wanted);
                found.extend(sharing.map(|(rank, _)| (*rank, cell as u32)));
            }
        }
        found
    });
    let mut needed = vec![Vec::new(); n_ranks];
    for (rank, cell) in found {
        needed[rank as usize].push(cell);
    }
    needed
}

/// The cells of a part with their numbers in the whole mesh, and the own ones among them: cells go to the ranks that need them.
fn with_needed(
    cells: Cells,
    own: Range<usize>,
    needed: Vec<Vec<u32>>,
    ranks: &Ranks,
) -> (Vec<u32>, Range<usize>, Cells) {
    let parcel = |places: Vec<u32>| Needed {
        cells: cells.select(places.iter().map(|&place| place as usize)),
        numbers: places.iter().map(|at| at + own.start as u32).collect(),
    };
    let parcels = needed.into_iter().map(parcel).collect();
    let of_others = ranks.alltoall_values(parcels);
    let mut numbers: Vec<u32> = (own.start as u32..own.end as u32).collect();
    let mut all = cells;
    let (before, after) = of_others.split_at(ranks.rank());
    let mut below = Needed::default();
    for from in before {
        below.numbers.extend(&from.numbers);
        below.cells.append(&from.cells);
    }
    // In the memory of the own ones: what grows is moved, and not copied to memory that has to be cleared.
    all.prepend(&below.cells);
    numbers.splice(0..0, below.numbers.iter().copied());
    for from in after {
        numbers.extend(&from.numbers);
        all.append(&from.cells);
    }
    let first = below.numbers.len();
    (numbers, first..first + own.len(), all)
}

#[cfg(test)]
mod tests {
    use super::super::CellKind;
    use super::*;

    #[test]
    fn every_node_comes_once() {
        for nodes in [
            vec![],
            vec![[5, 5, 5]],
            vec![[70, 3, 64], [3, 63, 128]],
            vec![[u32::MAX, 0, 7], [0, 7, 9]],
        ] {
            let mut cells = Cells::new();
            nodes
                .iter()
                .for_each(|nodes| cells.push(CellKind::Triangle, nodes));
            let mut wanted = nodes.concat();
            wanted.sort_unstable();
            wanted.dedup();
            assert_eq!(nodes_of(&cells, 0..0), wanted);
            wanted.extend(64..131);
            wanted.sort_unstable();
            wanted.dedup();
            assert_eq!(nodes_of(&cells, 64..131), wanted);
        }
    }
}
