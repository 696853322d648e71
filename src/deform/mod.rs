//! A mesh and a schedule to node positions at every step: base points once, mode fields once.
//!
//! ```text
//! Plan ──> Selection ──> StepEvaluator ──> points at a step
//! ```
//!
//! Owns what is refused of a mesh or a motion, what is interpolated and where nodes are at a step. Knows
//! no clock, prints nothing and writes nothing.

mod base;
mod deformation;
mod fields;
mod follow;
mod morph;
mod part;
mod plan;
mod step;
mod whole;
mod write;

pub use base::base_points::BasePoints;
pub use base::choose::choose;
pub(crate) use base::choose::from_nodes;
pub(crate) use deformation::Evaluated;
pub use deformation::{Deformation, DeformationBuilder};
pub use morph::{Morph, MorphOptions, MorphReport, Nodes};
pub use part::Part;
pub use plan::Plan;
pub use plan::layer::{Layer, LayerKind};
pub use step::evaluator::StepEvaluator;
pub(crate) use step::repair::Repair;
pub(crate) use step::step_memory::Rounding;
pub use whole::ReadWhole;
pub(crate) use write::{OwnValues, write_together};

pub(crate) use base::tolerance::missed_at_step;
pub use base::tolerance::{BaseOrigin, check_tolerance, missed, missed_layers};

#[cfg(test)]
mod precision_tests;
#[cfg(test)]
mod tests;
