//! The search for the facet closest to one point: boxes by their distance, the nearest first.

use super::super::bounds::Bounds;
use super::super::facet::ClosestPoints;
use super::super::oriented::LANES;
use super::super::vector::Vector;
use super::{ClosestPoint, ClosestSurface, LEAF};
use multiversion::multiversion;

/// Most groups that a front is walked down to.
pub(super) const MOST_GROUPS: usize = 24;
/// Boxes that wait in a search: the boxes of a front, and three for each of at most 16 levels.
const DEPTH: usize = MOST_GROUPS * LANES + 48;

/// Groups of one level that hold all that may be closest to some point.
#[derive(Debug, Clone)]
pub(super) struct Front {
    pub(super) level: usize,
    pub(super) groups: Vec<u32>,
}

/// A box that waits in a search; at level 0 the box of a leaf.
#[derive(Clone, Copy)]
struct Waiting {
    distance_squared: f64,
    level: u32,
    node: u32,
}

/// The nearest boxes first, from a front and leaf `hint` where there is one. The closest point comes with its leaf.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(super) fn search(
    query: &Query<'_>,
    front: &Front,
    limit: f64,
    hint: Option<usize>,
    waiting: &mut Stack,
) -> Option<(usize, ClosestPoint)> {
    let mut best = Best {
        limit: limit * limit,
        found: None,
    };
    if let Some(leaf) = hint {
        best.consider(query, leaf);
    }
    waiting.n = 0;
    for &group in &front.groups {
        waiting.open(query, front.level, group as usize, best.limit, 0);
    }
    while let Some(next) = waiting.pop() {
        if next.distance_squared > best.limit {
            continue;
        }
        let (level, node) = (next.level as usize, next.node as usize);
        if level > 0 {
            let first = waiting.n;
            waiting.open(query, level - 1, node, best.limit, first);
            continue;
        }
        best.consider(query, node);
    }
    best.found
}

/// Checks if the box of a leaf is within a distance of `block`, whose square is `limit`.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(super) fn is_leaf_within(surface: &ClosestSurface<'_>, limit: f64, block: &Bounds) -> bool {
    let Some(top) = surface.levels.len().checked_sub(1) else {
        return false;
    };
    // Groups that wait, each with its level: three for each level, and the first.
    let mut waiting = [(0u32, 0u32); 64];
    waiting[0] = (top as u32, 0);
    let mut n = 1;
    while n > 0 {
        n -= 1;
        let (level, group) = (waiting[n].0 as usize, waiting[n].1 as usize);
        let distances = surface.levels[level][group].distances_to(block);
        let n_boxes = surface.n_boxes(level);
        for lane in 0..LANES {
            let node = LANES * group + lane;
            if distances[lane] > limit || node >= n_boxes {
                continue;
            }
            if level == 0 {
                return true;
            }
            waiting[n] = (level as u32 - 1, node as u32);
            n += 1;
        }
    }
    false
}

/// Target of a search.
pub(super) struct Query<'a> {
    pub(super) surface: &'a ClosestSurface<'a>,
    pub(super) point: &'a Vector,
    /// The component that is left out.
    pub(super) apart: Option<u32>,
}

/// The boxes that wait in a search.
pub(super) struct Stack {
    boxes: [Waiting; DEPTH],
    n: usize,
}

impl Stack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let boxes = [Waiting {
            distance_squared: 0.0,
            level: 0,
            node: 0,
        }; DEPTH];
        Self { boxes, n: 0 }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Waiting> {
        self.n = self.n.checked_sub(1)?;
        Some(self.boxes[self.n])
    }

    /// Adds the boxes of a group that may be near enough; those from `first` on stay in order, the
    /// nearest last.
    #[inline(always)]
    fn open(&mut self, query: &Query<'_>, level: usize, group: usize, limit: f64, first: usize) {
        let surface = query.surface;
        let distances = surface.levels[level][group].distances_squared(query.point);
        let n_boxes = surface.n_boxes(level);
        for lane in 0..LANES {
            let distance_squared = distances[lane];
            let node = LANES * group + lane;
            if distance_squared > limit || node >= n_boxes {
                continue;
            }
            if query
                .apart
                .is_some_and(|own| surface.owners[level][node] == own)
            {
                continue;
            }
            let mut at = self.n;
            while at > first && self.boxes[at - 1].distance_squared < distance_squared {
                self.boxes[at] = self.boxes[at - 1];
                at -= 1;
            }
            self.boxes[at] = Waiting {
                distance_squared,
                level: level as u32,
                node: node as u32,
            };
            self.n += 1;
        }
    }
}

/// Best result so far: the leaf, and the closest point on one of its facets.
struct Best {
    limit: f64,
    found: Option<(usize, ClosestPoint)>,
}

impl Best {
    /// Looks at the facets of a leaf.
    #[inline(always)]
    fn consider(&mut self, query: &Query<'_>, leaf: usize) {
        let surface = query.surface;
        let closest = surface.leaves[leaf].closest(query.point);
        let mut near = 0u32;
        for lane in 0..LEAF {
            near |= u32::from(closest.distances_squared[lane] <= self.limit) << lane;
        }
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            self.take(query, leaf, lane, &closest);
        }
    }

    /// Takes a facet if it is the closest so far.
    #[inline(always)]
    fn take(&mut self, query: &Query<'_>, leaf: usize, lane: usize, closest: &ClosestPoints) {
        let (surface, at) = (query.surface, LEAF * leaf + lane);
        let distance_squared = closest.distances_squared[lane];
        let corners = surface.facets[at];
        let owner = || surface.components[corners[0] as usize];
        if distance_squared > self.limit || query.apart.is_some_and(|own| owner() == own) {
            return;
        }
        let facet = surface.origin[at] as usize;
        let first = |(_, found): &(usize, ClosestPoint)| facet < found.facet;
        if distance_squared == self.limit && !self.found.as_ref().is_some_and(first) {
            return;
        }
        self.limit = distance_squared;
        let weights = &closest.weights;
        let foot = ClosestPoint {
            facet,
            corners,
            weights: [weights[0][lane], weights[1][lane], weights[2][lane]],
            distance_squared,
        };
        self.found = Some((leaf, foot));
    }
}
