//! Connected components of facets, so that a search can skip facets of its own surface.

use super::super::oriented::LANES;
use super::LEAF;
use crate::parallel::{self, block};

/// The component of a tree node that holds facets of several.
const MIXED: u32 = u32::MAX;

/// The connected surface of each point, called by its lowest point.
pub(super) fn components(n_points: usize, facets: &[[u32; 3]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..n_points as u32).collect();
    fn root(parent: &mut [u32], mut node: u32) -> u32 {
        while parent[node as usize] != node {
            parent[node as usize] = parent[parent[node as usize] as usize];
            node = parent[node as usize];
        }
        node
    }
    for [a, b, c] in facets {
        for (a, b) in [(*a, *b), (*b, *c)] {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    // A parent has a lower index than its children, so one pass upward finds every root.
    for node in 0..n_points {
        parent[node] = parent[parent[node] as usize];
    }
    parent
}

/// The component of each box, by level; empty where all facets are of one.
pub(super) fn owners(facets: &[[u32; 3]], components: &[u32]) -> Vec<Vec<u32>> {
    let of_facet = |facet: &[u32; 3]| components[facet[0] as usize];
    let join = |a: u32, b: u32| if a == b { a } else { MIXED };
    let leaf = |leaf: &[[u32; 3]]| leaf.iter().map(of_facet).reduce(join).unwrap_or(MIXED);
    let leaf = |i: usize| leaf(&facets[block(facets.len(), LEAF, i)]);
    let mut levels = vec![parallel::collect(facets.len().div_ceil(LEAF), leaf)];
    while levels[levels.len() - 1].len() > LANES {
        let below = levels[levels.len() - 1].chunks(LANES);
        let group = |group: &[u32]| group.iter().copied().reduce(join).unwrap_or(MIXED);
        levels.push(below.map(group).collect());
    }
    let top = levels[levels.len() - 1].iter().copied().reduce(join);
    match top {
        Some(MIXED) => levels,
        _ => Vec::new(),
    }
}
