//! Which nodes a rank has fields at: a slab of those that deform, and those of its part of the mesh.

use super::work::Work;
use crate::deform::fields::MeshState;
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::ranks::{Ranks, raw};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Slabs of nodes begin at multiples of this.
const SLAB: usize = 256;
/// The row of a node that does not deform.
pub(super) const NO_ROW: u32 = u32::MAX;

/// The nodes of fields at a rank: some of those that deform, by ascending rows.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Rows {
    #[serde(with = "raw")]
    pub nodes: Vec<Vector>,
    /// Those of the slab, which no other rank has in its own.
    pub own: Range<usize>,
    /// Where each node of the part is among them.
    #[serde(with = "raw")]
    pub of_part: Vec<u32>,
}

/// What the first rank tells another of its rows.
#[derive(Serialize, Deserialize)]
pub(super) enum Told {
    /// All of them.
    Rows(Rows),
    /// Where the nodes of the slab are that are not in the part, of a mesh at rest of which all nodes deform.
    Rest(#[serde(with = "raw")] Vec<Vector>),
}

/// The rows of a rank.
pub(super) fn slab(n: usize, rank: usize, n_ranks: usize) -> Range<usize> {
    let start = |rank: usize| (rank * n.div_ceil(SLAB) / n_ranks * SLAB).min(n);
    start(rank)..start(rank + 1)
}

/// Gives each rank its rows of fields at some nodes, of which there are `n_rows`; the first has these nodes and those of each
/// part.
pub(super) fn give(
    of_first: Option<(MeshState<'_>, &[Vec<u32>])>,
    n_rows: usize,
    work: &Work,
    ranks: &Ranks,
) -> Rows {
    let n_ranks = ranks.n();
    let row_of = of_first.and_then(|(at, _)| Some(rows_by_node(at.deforming?, at.nodes.len())));
    let told = ranks.scatter(&mut |rank| {
        let (at, parts) = of_first?;
        let part = parts.get(rank).map_or(&[][..], Vec::as_slice);
        let slab = slab(n_rows, rank, n_ranks);
        Some(match at.deforming {
            None if at.is_reference => Told::Rest(outside(slab, part, at.nodes)),
            _ => Told::Rows(Rows::of(slab, part, at, row_of.as_deref())),
        })
    });
    match told {
        Told::Rows(rows) => rows,
        Told::Rest(rest) => {
            ranks.together(|| Rows::at_rest(slab(n_rows, ranks.rank(), n_ranks), &rest, work))
        }
    }
}

/// Where the nodes of a slab are that are not among the ascending ones of a part.
fn outside(slab: Range<usize>, part: &[u32], nodes: &[Vector]) -> Vec<Vector> {
    let mut part = part[part.partition_point(|&node| (node as usize) < slab.start)..]
        .iter()
        .peekable();
    let is_outside = |node: &usize| part.next_if(|&&other| other as usize == *node).is_none();
    slab.filter(is_outside).map(|node| nodes[node]).collect()
}

impl Rows {
    /// Of a rank with a slab and a part of a mesh.
    fn of(slab: Range<usize>, part: &[u32], at: MeshState<'_>, row_of: Option<&[u32]>) -> Self {
        let row = |node: u32| row_of.map_or(node, |of| of[node as usize]);
        let of_part = parallel::collect(part.len(), |i| row(part[i]));
        let (own, of_part, rows) = rows_of(slab, &of_part);
        let place = |row: u32| {
            let node = at.deforming.map_or(row, |nodes| nodes[row as usize]);
            at.nodes[node as usize]
        };
        Self {
            nodes: parallel::collect(rows.len(), |i| place(rows[i])),
            own,
            of_part,
        }
    }

    /// Of the mesh at rest, of which the rank knows its part and `rest` of the slab.
    fn at_rest(slab: Range<usize>, rest: &[Vector], work: &Work) -> Self {
        let part = work.part.as_ref();
        let numbers = part.and_then(|part| part.mesh.part.as_ref());
        let numbers = numbers.map_or(&[][..], |part| &part.nodes);
        let (own, of_part, rows) = rows_of(slab, numbers);
        let mut nodes = vec![[f64::NAN; 3]; rows.len()];
        let mut is_known = vec![false; rows.len()];
        let places = part.map_or(&[][..], |part| &part.mesh.points);
        for (&row, &place) in of_part.iter().zip(places) {
            (nodes[row as usize], is_known[row as usize]) = (place, true);
        }
        let unknown = nodes.iter_mut().zip(is_known).filter(|of| !of.1);
        for ((node, _), &place) in unknown.zip(rest) {
            *node = place;
        }
        Self {
            nodes,
            own,
            of_part,
        }
    }
}

/// For each of `n` nodes its row, where those in `nodes` are the ones that deform.
fn rows_by_node(nodes: &[u32], n: usize) -> Vec<u32> {
    let mut row_of = vec![NO_ROW; n];
    for (row, &node) in (0..).zip(nodes) {
        row_of[node as usize] = row;
    }
    row_of
}

/// The rows of a rank, ascending: its slab, and those of its part, of which each node has one or deforms not. Gives which of
/// them are the slab, where each node of the part is among them, and them.
fn rows_of(slab: Range<usize>, of_part: &[u32]) -> (Range<usize>, Vec<u32>, Vec<u32>) {
    let slab = (slab.start as u32)..(slab.end as u32);
    let outside = |i: usize| Some(of_part[i]).filter(|row| *row != NO_ROW && !slab.contains(row));
    let outside = parallel::filter_map(of_part.len(), outside);
    let n_below = outside.partition_point(|&row| row < slab.start);
    let (below, above) = outside.split_at(n_below);
    let own = n_below..n_below + slab.len();
    let place = |row: u32| match row {
        NO_ROW => NO_ROW,
        row if slab.contains(&row) => n_below as u32 + (row - slab.start),
        row => {
            let at = outside.partition_point(|&other| other < row);
            let slab_before = if at < n_below { 0 } else { slab.len() };
            (at + slab_before) as u32
        }
    };
    let of_part = parallel::collect(of_part.len(), |i| place(of_part[i]));
    let below = below.iter().copied();
    let rows = below.chain(slab.clone()).chain(above.iter().copied());
    (own, of_part, rows.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_a_slab_that_are_not_in_the_part_are_told() {
        let nodes: Vec<Vector> = (0..9).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let told = |part: &[u32]| {
            let told = outside(3..7, part, &nodes).into_iter();
            told.map(|x| x[0]).collect::<Vec<_>>()
        };
        assert_eq!(told(&[0, 2, 4, 5, 8]), [3.0, 6.0]);
        assert_eq!(told(&[]), [3.0, 4.0, 5.0, 6.0]);
    }
}
