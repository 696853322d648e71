//! The motion schedule, and what it means on a mesh.
//!
//! ```text
//! schedule.toml ── Schedule::read ──> Schedule ── resolve(&mesh) ──> Motion
//!                                     options                        steps, poses, roles of nodes
//! ```
//!
//! Owns the keys of the schedule, the rotor's conventions, the exact rigid map of every body at
//! every step and the role of every surface node. Leaves to others how the displacements are
//! interpolated into the volume.

mod body;
mod boundaries;
mod driven;
mod names;
mod options;
mod output;
mod pace;
pub mod periodic;
mod placed;
mod pose;
mod reader;
mod resolved;
mod rotor;
mod schedule;
mod seams;
mod steps;
mod surface;
pub mod table;
mod tags;
mod turn;
mod twist;
mod zones;

pub use body::{
    BeamMotion, Body, Cyclic, Harmonic, Matching, ModesMotion, Rigid, Series, SurfaceMotion,
    TableMotion,
};
pub use boundaries::{Boundaries, Others, PeriodicPair};
pub use driven::CentreLine;
pub use names::Pattern;
pub use options::{
    Interpolate, KernelName, Polynomial, RbfOptions, Refresh, SelectionCriterion, SelectionMethod,
    SelectionOptions,
};
pub use output::{OnInverted, OutputOptions, QualityOutput};
pub use pace::Pace;
pub use placed::Pose;
pub use resolved::Motion;
pub use rotor::{Frame, Rotor, RotorAxes, Signs};
pub use schedule::Schedule;
pub use steps::{MAX_STEPS, Step};
pub use surface::{Role, Surface, SurfaceFaces, SurfaceNodes};
pub use tags::{PeriodicTags, TagRole};
pub use zones::DeformingZone;

#[cfg(test)]
mod tests;
