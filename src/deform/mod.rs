//! A mesh and a schedule to node positions at every step: base points once, mode fields once.
//!
//! ```text
//! Plan ──> Selection ──> Interval ──> points at a step
//! ```
//!
//! Owns what is refused of a mesh or a motion, what is interpolated and where nodes are at a step. Knows
//! no clock, prints nothing and writes nothing.

mod checks;
mod choose;
mod deformation;
mod fields;
mod first_cells;
mod interval;
mod layer;
mod measures;
mod morph;
mod periodic;
mod plan;
mod repair;
mod sections;
mod sliding;
mod substeps;
mod surface;
mod surface_displacements;
mod velocity;
mod wall_angles;
mod zone;

pub use choose::{check_tolerance, choose, constant};
pub(crate) use choose::{from_nodes, missed};
pub(crate) use deformation::Evaluated;
pub use deformation::{BasePoints, Deformation, DeformationBuilder};
pub use first_cells::FirstCells;
pub use interval::Interval;
pub use layer::{Centre, Kind, Layer};
pub use morph::{Morph, MorphOptions, MorphReport, Nodes};
pub use plan::Plan;
pub use surface::SurfacePoints;
pub use wall_angles::WallAngles;

#[cfg(test)]
mod tests;
