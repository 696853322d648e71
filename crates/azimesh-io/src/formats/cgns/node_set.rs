//! Sets of nodes of an unstructured zone.

use super::regions::{GridLocation, Region};
use super::zone::Zone;
use std::ops::Range;

/// Some of the nodes of a zone.
pub(super) struct NodeSet {
    bits: Vec<u64>,
    first_node: usize,
}

impl NodeSet {
    /// None of them.
    pub fn none(zone: &Zone) -> Self {
        let n: usize = zone.n_nodes.iter().product();
        Self {
            bits: vec![0; n.div_ceil(64)],
            first_node: zone.first_node,
        }
    }

    /// The nodes of a region of an unstructured zone; `None` for a region of elements, or where the
    /// numbers are too large for nodes.
    pub fn of(region: &Region, zone: &Zone) -> Option<Self> {
        let n = zone.n_nodes.iter().product::<usize>() as i64;
        let ranges = region.ranges();
        let fits = |range: &Range<i64>| range.start >= 1 && range.end <= n + 1;
        if region.place != GridLocation::Nodes || !ranges.iter().all(fits) {
            return None;
        }
        let mut set = Self::none(zone);
        for number in ranges.into_iter().flatten() {
            set.add((number - 1 + zone.first_node as i64) as u32);
        }
        Some(set)
    }

    /// Adds a node of the mesh.
    pub fn add(&mut self, node: u32) {
        let i = node as usize - self.first_node;
        self.bits[i / 64] |= 1 << (i % 64);
    }

    /// Whether it has a node of the mesh.
    pub fn has(&self, node: u32) -> bool {
        let i = node as usize - self.first_node;
        self.bits[i / 64] >> (i % 64) & 1 == 1
    }

    /// Adds the nodes of another set.
    pub fn unite(&mut self, other: &Self) {
        for (bits, more) in self.bits.iter_mut().zip(&other.bits) {
            *bits |= more;
        }
    }

    /// How many they are.
    pub fn count(&self) -> u32 {
        self.bits.iter().map(|bits| bits.count_ones()).sum()
    }
}
