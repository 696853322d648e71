//! What the files of VTK share: legacy, XML and HDF.
//!
//! Knows VTK's cells, numbers and names of arrays; nothing of how a file is laid out.
//!
//! ```text
//! number     types of numbers, words -> numbers; chunk: bytes -> numbers, many at a time
//! cells      types, ends and node indices -> runs; split: collections of cells; polyhedra: faces
//! order      hexahedra of high order in files before VTK 9
//! structured cells of blocks that list none
//! list       cells as legacy files list them
//! tags       integer cell arrays <-> groups
//! arrays     mesh -> list of arrays to be written; text: numbers as text
//! ```

pub mod arrays;
pub mod cells;
pub mod list;
pub mod number;
pub mod order;
pub mod polyhedra;
pub mod split;
pub mod structured;
pub mod tags;
pub mod text;

pub(in crate::formats) use super::number as chunk;
