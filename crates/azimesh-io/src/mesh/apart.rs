//! Nodes and cells that are distributed over several ranks. Each rank writes its own.

use super::{CellKind, Cells};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::numbers::point;
use azimesh_core::ranks::hash::{HashedBytes, TreeHasher};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;

/// A mesh that is distributed over the ranks.
pub trait Apart: Debug + Send + Sync {
    /// Makes all ranks write their numbers into a file, contiguously from a byte offset; without a file nothing is written.
    /// Returns the hashed parts in the order of the file. Hashing starts at byte `hash_from`.
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>>;
}

/// Numbers to write, with their layout.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Numbers {
    /// Coordinates of all nodes.
    Coordinates(Coordinates),
    /// Displacements of all nodes from the reference mesh, as coordinates.
    Displacements(Coordinates),
    /// Velocities of all nodes, as coordinates.
    Velocities(Coordinates),
    /// The nodes of some cells.
    Nodes(NodesOfCells),
}

/// Coordinates of nodes as they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coordinates {
    /// The coordinate; `None` for all three of each node.
    pub axis: Option<usize>,
    /// True if they have 32 bits; else 64.
    pub is_single: bool,
    /// True if the most significant byte of each comes first.
    pub is_big_endian: bool,
}

/// The nodes of cells as they are written, cell after cell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodesOfCells {
    /// The cells, by their numbers in the whole mesh.
    pub cells: Range<usize>,
    /// The kind of those that are listed; none for all.
    pub kind: Option<CellKind>,
    /// Order and numbering of their nodes.
    pub listing: Listing,
    /// True if numbers have 64 bits; else 32.
    pub is_wide: bool,
    /// True if the most significant byte of each comes first.
    pub is_big_endian: bool,
}

/// Order and numbering of the nodes of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Listing {
    /// In the order of VTK's files, from 0.
    Vtk,
    /// In the order of CGNS, from 1.
    Cgns,
    /// The same, the number of its type before the nodes of each cell.
    CgnsMixed,
    /// In the order of UGRID, from 1.
    Ugrid,
}

/// Numbers of a mesh that ranks write.
#[derive(Debug, Clone)]
pub struct NumbersApart<'a> {
    /// The ranks.
    pub by: &'a dyn Apart,
    /// The numbers.
    pub numbers: Numbers,
    /// Bytes of all of them.
    pub n_bytes: u64,
}

impl NumbersApart<'_> {
    /// The hash of their bytes, which are written nowhere.
    pub fn hash(&self) -> Result<blake3::Hash> {
        let mut hasher = TreeHasher::default();
        let told = self.by.write(None, &self.numbers, 0)?;
        told.iter().for_each(|part| hasher.take(part));
        Ok(hasher.finalize())
    }
}

impl NodesOfCells {
    /// With the least significant byte first.
    pub fn new(cells: Range<usize>, listing: Listing, is_wide: bool) -> Self {
        Self {
            cells,
            kind: None,
            listing,
            is_wide,
            is_big_endian: false,
        }
    }

    /// Returns whether cells of a kind are listed.
    pub fn lists(&self, kind: CellKind) -> bool {
        self.kind.is_none_or(|wanted| wanted == kind)
    }

    /// Bytes of a number.
    pub fn size(&self) -> usize {
        if self.is_wide { 8 } else { 4 }
    }

    /// Counts the numbers that are listed for a range of `cells`.
    pub fn n_numbers(&self, cells: &Cells, range: Range<usize>) -> usize {
        let more = usize::from(self.listing == Listing::CgnsMixed);
        let of_run = |n_cells: usize, n_nodes: usize| n_cells * (n_nodes + more);
        let runs = cells.runs_in(range).filter(|run| self.lists(run.kind));
        runs.map(|run| of_run(run.n_cells(), run.n_nodes)).sum()
    }
}

impl Coordinates {
    /// With the least significant byte first.
    pub fn new(axis: Option<usize>, is_single: bool) -> Self {
        Self {
            axis,
            is_single,
            is_big_endian: false,
        }
    }

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
        let (all, first) = (points.as_flattened(), bytes.len());
        match (self.axis, self.is_single) {
            (None, false) => bytes.extend_from_slice(bytemuck::cast_slice(all)),
            (None, true) => push(all.iter().map(|x| *x as f32), bytes),
            (Some(axis), false) => push(points.iter().map(|x| x[axis]), bytes),
            (Some(axis), true) => push(points.iter().map(|x| x[axis] as f32), bytes),
        }
        if self.is_big_endian {
            reverse_each(&mut bytes[first..], if self.is_single { 4 } else { 8 });
        }
    }
}

/// Reverses the bytes of each value of `size` bytes.
pub fn reverse_each(bytes: &mut [u8], size: usize) {
    fn reverse<const N: usize>(bytes: &mut [u8]) {
        bytes
            .as_chunks_mut::<N>()
            .0
            .iter_mut()
            .for_each(|value| value.reverse());
    }
    match size {
        2 => reverse::<2>(bytes),
        4 => reverse::<4>(bytes),
        8 => reverse::<8>(bytes),
        _ => {}
    }
}

/// A place in numbers of 32 bits.
pub fn in_32_bits(x: Vector) -> Vector {
    x.map(|x| f64::from(x as f32))
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
