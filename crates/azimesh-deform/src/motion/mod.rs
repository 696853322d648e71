//! The motion schedule, and what it means on a mesh.
//!
//! ```text
//! schedule.toml ── Schedule::read ──> Schedule ── resolve(&mesh) ──> Motion
//!                                     options                        steps, poses, roles of nodes
//! ```
//!
//! Owns the keys of the schedule, the rotor's conventions, the exact rigid map of every body at
//! every step and the role of every surface node. Other modules interpolate the displacements into the volume.

mod body;
mod body_map;
mod boundaries;
mod builder;
mod keys;
mod motions;
mod names;
mod options;
mod output;
pub mod periodic;
mod places;
mod pose;
mod ramp;
mod reader;
mod resolved;
mod rotor;
mod schedule;
mod setters;
mod shared_nodes;
mod steps;
mod surface;
pub mod table;
mod tags;
mod twist;
mod zones;

pub use body::Body;
pub use body_map::{BodyMap, BodyVelocity};
pub use boundaries::Others;
pub use motions::{
    AxisRotation, Beam, CentreLine, Cyclic, MapMethod, Modes, Rotation, SurfaceMotion, TableMotion,
    Translation,
};
pub use options::{
    Interpolate, KernelName, Polynomial, SelectionCriterion, SelectionMethod, SelectionOptions,
};
pub use output::{OnInverted, QualityOutput, SurfaceOutput};
pub use pose::RigidAt;
pub use resolved::Motion;
pub use rotor::{Frame, Rotor, RotorAxes, ToInertial, TurningRotor};
pub use schedule::Schedule;
pub use steps::{Step, Steps};
pub use surface::{Role, Surface, SurfaceFaces, SurfaceNodes, TagRole};
pub use table::{RotationForm, Table};
pub use zones::{DeformingZone, RigidPart, ZonePart};

#[cfg(test)]
mod tests;
