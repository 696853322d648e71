//! Pairs of nodes or cells of two meshes.

use azimesh_core::parallel::map_blocks;
use std::ops::Range;

/// No partner.
pub const NONE: u32 = u32::MAX;

/// Nodes or cells that are looked at in one go.
const CHUNK: usize = 1 << 16;

/// The partner of each node, or of each cell, of the first mesh.
#[derive(Debug)]
pub enum Partners {
    /// Partners of the same index, for as many as both meshes have.
    InOrder(usize),
    /// An index of the second mesh each, or [`NONE`].
    Listed(Vec<u32>),
}

impl Partners {
    /// Index i and index i.
    pub fn in_order(n_first: usize, n_second: usize) -> Self {
        Partners::InOrder(n_first.min(n_second))
    }

    /// The partner of index `i`, if it has one.
    pub fn of(&self, i: usize) -> Option<usize> {
        match self {
            Partners::InOrder(n) => (i < *n).then_some(i),
            Partners::Listed(list) => match list[i] {
                NONE => None,
                partner => Some(partner as usize),
            },
        }
    }

    /// Returns whether the partner of every index is the same index.
    pub fn is_in_order(&self) -> bool {
        matches!(self, Partners::InOrder(_))
    }
}

/// Does `work` on ranges of `0..n` on all threads and joins what comes of it in order.
pub fn in_chunks<T: Send + Default>(
    n: usize,
    work: &(dyn Fn(Range<usize>) -> T + Sync),
    join: impl Fn(T, T) -> T,
) -> T {
    let parts = map_blocks(n, CHUNK, work);
    parts.into_iter().fold(T::default(), join)
}
