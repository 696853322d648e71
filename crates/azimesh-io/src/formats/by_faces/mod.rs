//! Cells from faces, for formats that list the faces of a mesh with the cells on their two sides: OpenFOAM, Fluent.
//!
//! Owns faces as lists of nodes, which faces each cell has, and what kind of cell they make. Where the lists lie in a file,
//! and what their faces are called, is left to the formats.

mod cells;
mod faces;
mod hexahedra;
mod labels;
mod shapes;
mod tetrahedra;

pub(super) use self::{
    cells::{NONE, assemble},
    faces::{Faces, regular_size},
    labels::{Label, Labels},
};
