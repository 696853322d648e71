//! Shared parts of the files of VTK: legacy, XML and HDF.
//!
//! Knows VTK's cells, numbers and names of arrays; nothing of how a file is laid out.
//!
//! ```text
//! number     types of numbers, words -> numbers and back
//! cells      types, ends and node indices -> runs; split: collections of cells; polyhedra: faces
//! order      hexahedra of high order in files before VTK 9
//! structured cells of blocks that list none
//! list       cells as legacy files list them
//! ghosts     copies of cells of other pieces, hidden cells
//! tags       integer cell arrays <-> groups
//! arrays     mesh -> list of arrays to be written
//! ```

pub mod arrays;
pub mod cells;
#[cfg(test)]
pub(super) mod fixtures;
pub mod ghosts;
pub mod list;
pub mod number;
pub mod order;
pub mod polyhedra;
pub mod split;
pub mod structured;
pub mod tags;
