//! Nodes at one place: the copies of a node that parts of a mesh, structured blocks or the two sides of a cut have.

use super::connected::UnionFind;
use super::near::Grid;
use super::nodes::for_each_shared_place;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::parallel::concat_blocks;
use std::collections::BTreeMap;

/// Largest distance of copies, as a part of the largest coordinate: rounding in 64 bits.
const ROUNDING: f64 = 1e-14;
/// Edge of a box of the search, in such distances.
const BOX: f64 = 4.0;
/// Distinct places in the boxes around a node at most: more are no copies, but a mesh of no size.
const MOST: usize = 64;
/// Nodes per block of a parallel search.
const CHUNK: usize = 1 << 14;

/// The nodes at one place, within rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Coincident {
    /// The first node at the place of each node; empty if all places differ.
    first: Vec<u32>,
    /// Nodes at a place of several.
    is_shared: Vec<bool>,
}

impl Coincident {
    /// Finds the nodes at one place. Nodes of two `class`es are different nodes. The result is the same on any number of
    /// threads.
    pub fn of(points: &[Vector], class: impl Fn(u32) -> u32 + Sync) -> Self {
        let mut first = UnionFind::new(points.len());
        let mut copies: Vec<u32> = Vec::new();
        for_each_shared_place(points, &mut |nodes| {
            let mut first_of_class = BTreeMap::new();
            for &node in nodes {
                let one = *first_of_class.entry(class(node)).or_insert(node);
                if one != node {
                    first.join(&[one, node]);
                    copies.extend([one, node]);
                }
            }
        });
        // Only the first of each exact place is searched for near ones: thousands of nodes may be at a pole.
        let distinct = (0..points.len() as u32).filter(|&node| first.of(node) == node);
        let distinct: Vec<u32> = distinct.collect();
        let coordinates = points.iter().flatten().map(|x| x.abs());
        let finite = coordinates.filter(|x| x.is_finite());
        let within = (ROUNDING * finite.fold(0.0, f64::max)).max(f64::MIN_POSITIVE);
        let grid = Grid::of(points, &distinct, within, BOX, MOST);
        let near = concat_blocks(distinct.len(), CHUNK, &|range| {
            let mut near = Vec::new();
            for &node in &distinct[range] {
                let at = points[node as usize];
                grid.visit(at, |other| {
                    let is_near = distance(at, points[other as usize]) <= within;
                    if other < node && is_near && class(other) == class(node) {
                        near.push([other, node]);
                    }
                });
            }
            near
        });
        near.iter().for_each(|pair| first.join(pair));
        copies.extend(near.into_iter().flatten());
        if copies.is_empty() {
            return Self::default();
        }
        let mut is_shared = vec![false; points.len()];
        for node in copies {
            is_shared[node as usize] = true;
        }
        Self {
            first: (0..points.len() as u32)
                .map(|node| first.of(node))
                .collect(),
            is_shared,
        }
    }

    /// Returns whether no two nodes are at one place.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// The first node at the place of a node: the node itself where it has no copy.
    pub fn first(&self, node: u32) -> u32 {
        self.first.get(node as usize).copied().unwrap_or(node)
    }

    /// Returns whether another node is at the place of a node.
    pub fn is_shared(&self, node: u32) -> bool {
        self.is_shared.get(node as usize) == Some(&true)
    }

    /// The nodes behind the first at their place, ascending, each with the first.
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        let nodes = (0..).zip(self.first.iter().copied());
        nodes.filter(|(node, first)| node != first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_at_one_place_are_found_within_rounding_only() {
        let x = 0.1 + 0.2;
        let points = [
            [x, 5.0, 0.0],
            [1.0, 5.0, 0.0],
            [0.3, 5.0, -0.0],
            [x, 5.0 + 1e-15, 0.0],
            [x, 5.0 + 1e-12, 0.0],
            [1.0, 5.0, 0.0],
        ];
        let found = Coincident::of(&points, |_| 0);
        let pairs: Vec<_> = found.pairs().collect();
        assert_eq!(pairs, [(2, 0), (3, 0), (5, 1)]);
        assert_eq!((found.first(3), found.first(4)), (0, 4));
        assert!(found.is_shared(0) && found.is_shared(5) && !found.is_shared(4));
        let found = Coincident::of(&points, |node| node.min(1));
        assert_eq!(found.pairs().collect::<Vec<_>>(), [(3, 2), (5, 1)]);
        assert!(Coincident::of(&points[3..5], |_| 0).is_empty());
    }

    #[test]
    fn points_at_the_origin_or_nowhere_are_no_error() {
        let points = [[0.0; 3], [f64::NAN; 3], [-0.0; 3], [f64::INFINITY; 3]];
        let found = Coincident::of(&points, |_| 0);
        assert_eq!(found.pairs().collect::<Vec<_>>(), [(2, 0)]);
        let none = Coincident::of(&[[0.0; 3]; 100_000], |node| node);
        assert!(none.is_empty());
        let all = Coincident::of(&[[0.0; 3]; 100_000], |_| 0);
        assert!((0..100_000).all(|node| all.first(node) == 0 && all.is_shared(node)));
        assert_eq!(Coincident::of(&[], |_| 0), Coincident::default());
    }
}
