//! Meshes to try things on, at any size, each with a motion schedule that suits it.
//!
//! Owns the shapes and the grids. Writes no file; knows nothing of motion but the text of the
//! schedules.

mod airfoil;
pub mod blade;
pub mod block;
pub mod extrude;
pub mod naca0012;
mod ray;
pub mod size;
mod spacing;

pub use blade::{BladeOptions, BladeShape, blade, rotor, rotor_of};
pub use block::block;
pub use extrude::CellShape;
pub use naca0012::naca0012;
pub use size::SizeOptions;

use azimesh_io::mesh::{CellSet, Group, Mesh};
use std::ops::Range;

/// A mesh and a motion schedule for it.
#[derive(Debug, Clone)]
pub struct Sample {
    /// The mesh.
    pub mesh: Mesh,
    /// The schedule, as TOML.
    pub schedule: String,
}

/// A group of consecutive cells.
fn tag(name: &str, dimension: u8, range: Range<usize>) -> Group {
    let mut cells = CellSet::new();
    cells.push_range(range);
    Group {
        dimension,
        name: name.to_owned(),
        number: None,
        condition: None,
        cells,
    }
}

#[cfg(test)]
mod tests;
