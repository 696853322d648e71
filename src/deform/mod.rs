//! A mesh and a schedule to node positions at every step: base points once, mode fields once.
//!
//! ```text
//! Plan ──> Selection ──> Interval ──> points at a step
//! ```
//!
//! Owns what is refused of a mesh or a motion, what is interpolated and where nodes are at a step. Knows
//! no clock, prints nothing and writes nothing.

mod base_points;
mod checks;
mod choose;
mod deformation;
mod fields;
mod first_cells;
mod interval;
mod layer;
mod measures;
mod mesh_file;
mod morph;
mod numbers_file;
mod periodic;
mod plan;
mod positions;
mod prepare;
mod repair;
mod repair_rate;
mod ring;
mod round_off;
mod sections;
mod sharing;
mod sliding;
mod step_memory;
mod substeps;
mod surface;
mod surface_displacements;
mod team;
mod tolerance;
mod untangle;
mod velocity;
mod wall_angles;
mod window;
mod zone;

pub use base_points::BasePoints;
pub use choose::choose;
pub(crate) use choose::from_nodes;
pub(crate) use deformation::Evaluated;
pub use deformation::{Deformation, DeformationBuilder};
pub use interval::Interval;
pub use layer::{Layer, LayerKind};
pub use mesh_file::MeshFile;
pub use morph::{Morph, MorphOptions, MorphReport, Nodes};
pub use plan::Plan;
pub(crate) use repair::Repair;
pub(crate) use step_memory::Rounding;

pub use sharing::Sharing;
pub use team::{Team, dismiss, serve};
pub(crate) use tolerance::missed_at_step;
pub use tolerance::{BaseOrigin, check_tolerance, missed, missed_layers};

#[cfg(test)]
mod precision_tests;
#[cfg(test)]
mod tests;
