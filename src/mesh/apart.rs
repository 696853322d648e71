//! Node coordinates that lie with several ranks, each of which writes its own.

use crate::diagnostic::point;
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::ranks::hash::HashedBytes;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::path::Path;

/// The coordinates of all nodes, with the ranks.
pub trait PointsApart: Debug + Send + Sync {
    /// Has all ranks write numbers into a file, which lie one after another from a byte of it on; none writes nothing.
    /// Gives what the ranks tell of them, in the order in which they lie there; they are hashed from byte `hash_from` on.
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>>;
}

/// Which numbers of nodes are written, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Numbers {
    /// The coordinate; `None` for all three of each node.
    pub axis: Option<usize>,
    /// Whether they have 32 bits; else 64.
    pub is_single: bool,
}

/// Numbers of all nodes of a mesh that ranks write.
#[derive(Debug, Clone, Copy)]
pub struct NumbersApart<'a> {
    pub points: &'a dyn PointsApart,
    pub numbers: Numbers,
    pub n_nodes: usize,
}

impl Numbers {
    /// Bytes of a node.
    pub fn size(self) -> usize {
        let n = if self.axis.is_some() { 1 } else { 3 };
        n * if self.is_single { 4 } else { 8 }
    }

    /// Appends the bytes of nodes.
    pub fn append(self, points: &[Vector], bytes: &mut Vec<u8>) {
        fn push<T: bytemuck::NoUninit>(numbers: impl Iterator<Item = T>, bytes: &mut Vec<u8>) {
            let numbers: Vec<T> = numbers.collect();
            bytes.extend_from_slice(bytemuck::cast_slice(&numbers));
        }
        let all = points.as_flattened();
        match (self.axis, self.is_single) {
            (None, false) => bytes.extend_from_slice(bytemuck::cast_slice(all)),
            (None, true) => push(all.iter().map(|x| *x as f32), bytes),
            (Some(axis), false) => push(points.iter().map(|x| x[axis]), bytes),
            (Some(axis), true) => push(points.iter().map(|x| x[axis] as f32), bytes),
        }
    }
}

/// Refuses nodes that numbers of 32 bits do not hold; the first has the number `first`.
pub fn check_in_32_bits(points: &[Vector], first: usize) -> Result<()> {
    let too_large = |point: &Vector| point.iter().any(|x| x.abs() > f64::from(f32::MAX));
    match points.iter().position(too_large) {
        Some(at) => Err(Error::input(format!(
            "node {} is at {}, too large for 32 bits; write 64 bits",
            first + at,
            point(&points[at])
        ))),
        None => Ok(()),
    }
}

impl NumbersApart<'_> {
    /// Their bytes, all together.
    pub fn n_bytes(&self) -> u64 {
        (self.n_nodes * self.numbers.size()) as u64
    }
}
