//! Cells from faces, for formats that list the faces of a mesh with the cells on their two sides: OpenFOAM, Fluent.
//!
//! Owns faces as lists of nodes, which faces each cell has, and what kind of cell they make. Places of the lists in a file,
//! and what their faces are called, is left to the formats.

mod cells;
mod faces;
mod shapes;
mod uniform;

pub(super) use self::{
    cells::{NONE, assemble},
    faces::{Faces, Label, Labels, regular_size},
};
