//! Node positions at a step: the fields and the exact surface, substeps, and the repair of folded cells.

pub(crate) mod evaluator;
pub(crate) mod measures;
pub(crate) mod positions;
pub(crate) mod repair;
mod repair_rate;
pub(crate) mod segment;
pub(crate) mod step_memory;
mod substeps;
mod untangle;
mod wall_angles;
mod window;
