//! Finds nodes within a distance of a position.

use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel::{collect, sort};

/// Keys of boxes with the nodes in them.
pub type Keys = Vec<(u64, u32)>;

/// A well-mixed number for each number: the finalizer of SplitMix64 (Steele, Lea and Flood, 2014).
pub fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Nodes in boxes of a grid, by a key of the box.
pub(super) struct Grid {
    within: f64,
    /// Largest number of nodes that one search visits.
    most: usize,
    edge: f64,
    keys: Keys,
    /// First keys with each value of the leading bits.
    starts: Vec<u32>,
    shift: u32,
}

impl Grid {
    /// Builds a grid for searches `within` a distance, with boxes of `size` such distances.
    pub fn of(points: &[Vector], nodes: &[u32], within: f64, size: f64, most: usize) -> Self {
        let sizes = nodes.iter().flat_map(|&node| points[node as usize]);
        let largest = sizes.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        // Boxes so small that their numbers are no whole numbers would hold everything at once.
        let edge = (size * within).max(1e-12 * largest);
        let mut keys: Keys = collect(nodes.len(), |i| {
            let corner = points[nodes[i] as usize].map(|x| (x / edge).floor());
            (key(corner), nodes[i])
        });
        sort(&mut keys);
        let n_leading = nodes.len().max(1).ilog2().clamp(1, 24);
        let shift = 64 - n_leading;
        let mut starts = vec![0; (1 << n_leading) + 1];
        for (key, _) in &keys {
            starts[(key >> shift) as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        Self {
            within,
            most,
            edge,
            keys,
            starts,
            shift,
        }
    }

    /// Calls `visit` for each node in the boxes that are at most `within` from a position. Returns `false`, after some of
    /// the calls, if there are too many nodes.
    pub fn visit(&self, at: Vector, mut visit: impl FnMut(u32)) -> bool {
        let low = at.map(|x| ((x - self.within) / self.edge).floor());
        let high = at.map(|x| ((x + self.within) / self.edge).floor());
        let mut n_seen = 0;
        for corner in 0..8 {
            let takes_high = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            if (0..3).any(|axis| takes_high[axis] && low[axis] == high[axis]) {
                continue;
            }
            let place = [0, 1, 2].map(|axis| {
                if takes_high[axis] {
                    high[axis]
                } else {
                    low[axis]
                }
            });
            let nodes = self.in_box(key(place));
            n_seen += nodes.len();
            if n_seen > self.most {
                return false;
            }
            nodes.iter().for_each(|(_, node)| visit(*node));
        }
        true
    }

    fn in_box(&self, key: u64) -> &[(u64, u32)] {
        let leading = (key >> self.shift) as usize;
        let alike = &self.keys[self.starts[leading] as usize..self.starts[leading + 1] as usize];
        let from = alike.partition_point(|(other, _)| *other < key);
        // One more than the search visits is enough to end it.
        let most = alike[from..].iter().take(self.most.saturating_add(1));
        let n = most.take_while(|(other, _)| *other == key);
        &alike[from..from + n.count()]
    }
}

fn key(corner: [f64; 3]) -> u64 {
    let corner = corner.map(|x| (x + 0.0).to_bits());
    corner.into_iter().fold(0, |key, x| mixed(key ^ x))
}
