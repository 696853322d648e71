//! Deformation of meshes: a mesh and a schedule of motions in, node positions at every step out.
//!
//! Owns: the schedule and its keys; rigid and elastic motions; checks of a schedule on a mesh; selection of base points for
//! all steps at once; mode fields at every node; positions, velocities and quality at a step; sliding, periodic and rotating
//! zones; the repair of folded cells over several steps; morphing by displacements that are not known beforehand. All of it
//! runs on one process or on several that share a mesh and write one file together.
//!
//! Other crates have mesh files (`azimesh-io`), interpolation (`azimesh-rbf`), metrics and the repair of one mesh
//! (`azimesh-quality`), folders of runs, reports and the command line (`azimesh`). This crate prints nothing and reads no
//! clock.
//!
//! ```text
//! Mesh, Schedule ──> Plan ──> choose ──> Selection (base points) ──> StepEvaluator ──> positions at a step
//!                     │ checks, layers, modes                          fields, exact surface    │
//!                     └──────────────── Deformation owns all of it ─────────────────────────────┘
//!                                       steps(), points_at(step), velocities_at(step), quality_of(points)
//!
//! Mesh, MorphOptions ──> Morph ──> points(displacements), pull_back(gradient)
//! ```
//!
//! ```
//! use azimesh_deform::{Deformation, Mesh, Schedule};
//! use std::path::Path;
//!
//! # fn main() -> azimesh_deform::Result<()> {
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! let schedule = Schedule::read(Path::new("testdata/naca0012.toml"))?; // it pitches by 10 degrees
//! let deformation = Deformation::new(mesh, schedule)?;
//!
//! let step = &deformation.steps()[9]; // azimuth 90 degrees
//! let points = deformation.points_at(step)?;
//! let (mesh, quality) = (deformation.mesh(), deformation.quality_of(&points)?);
//! assert_eq!(quality.inverted, 0);
//! let farfield = mesh.tag_nodes("farfield")?[0] as usize;
//! assert_eq!(points[farfield], mesh.points()[farfield]); // fixed
//! # Ok(())
//! # }
//! ```

mod base;
mod deformation;
mod fields;
mod morph;
pub mod motion;
mod part;
#[cfg(test)]
mod part_tests;
mod plan;
mod step;
mod whole;
mod write;

pub use azimesh_core::{Error, ErrorKind, Progress, Result, Stop};
pub use azimesh_io::{
    CellKind, Cells, Compression, DataArray, Mesh, MeshView, Precision, ReadOptions, WriteOptions,
};
pub use base::base_points::BasePoints;
pub use base::choose::choose;
pub use base::choose::from_nodes;
pub use deformation::Evaluated;
pub use deformation::{Deformation, DeformationBuilder};
pub use morph::{Morph, MorphOptions, MorphReport, Nodes};
pub use motion::{
    AxisRotation, Beam, Body, Cyclic, Interpolate, KernelName as Kernel, MapMethod, Modes,
    OnInverted, Others, Polynomial, QualityOutput, RotationForm, Rotor, Schedule,
    SelectionCriterion, SelectionMethod, Step, Steps, SurfaceMotion, SurfaceOutput, Table,
    TableMotion, Translation,
};
pub use part::Part;
pub use plan::Plan;
pub use plan::layer::{Layer, LayerKind};
pub use plan::zone::{Mover, Seam};
pub use step::evaluator::StepEvaluator;
pub use step::repair::Repair;
pub use step::step_memory::Rounding;
pub use whole::ReadWhole;
pub use write::{OwnValues, write_together};

pub use base::tolerance::missed_at_step;
pub use base::tolerance::{BaseOrigin, check_tolerance, missed, missed_layers};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod precision_tests;
#[cfg(test)]
mod tests;
