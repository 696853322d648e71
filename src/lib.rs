//! Moves unstructured meshes with rotors, wings and anything else that turns, by radial basis
//! functions.
//!
//! ```text
//! mesh file ── formats ──> Mesh ─┐
//!                                ├─ motion: roles of surface nodes, poses per step
//! schedule.toml ── motion ───────┘        │
//!                          modes: D (N_s, 3K) = U (N_s, r) C (r, 3K)
//!                                         │
//!                          rbf: base points, weights W (n, r), field M (N_v, r) = Phi_vb W,
//!                               corrected so that the surface is exact
//!                                         │
//!                            deform: x_k = x + M C_k, quality; run: one file a step
//! ```
//!
//! | module | owns |
//! |---|---|
//! | [`error`] | the one error type, with its place in a file |
//! | [`diagnostic`] | what a user should know, as kinds with numbers |
//! | [`progress`] | how far a run is, and how it is asked to end |
//! | [`geometry`] | vectors, transforms, boxes, space-filling order, closest points |
//! | [`linear`] | factors and products of dense matrices |
//! | [`mesh`] | nodes, cells, groups, arrays; how two meshes differ |
//! | [`formats`] | reading and writing mesh files |
//! | [`modes`] | any motion as a few fields times coefficients per step |
//! | [`motion`] | the schedule, roles of nodes, poses per step |
//! | [`rbf`] | kernels, base points, evaluation, correction |
//! | [`quality`] | cell metrics and their summary |
//! | [`sample`] | meshes to try things on |
//! | [`deform`] | a mesh and a schedule to positions at every step |
//! | [`preflight`] | warnings, memory and disk, before work starts |
//! | [`record`] | what a run leaves behind besides meshes |
//! | [`run`] | a deformation written to a folder |
//! | [`report`] | one page of a sequence |
//! | [`cli`] | the commands; the only module that prints |
//!
//! Further reading in the repository: `ARCHITECTURE.md`, and `docs/method.md` for the equations.

#[cfg(feature = "cli")]
pub mod cli;
pub mod deform;
pub mod diagnostic;
pub mod error;
pub mod formats;
pub mod geometry;
pub mod linear;
pub mod mesh;
pub mod modes;
pub mod motion;
pub mod preflight;
pub mod progress;
pub mod quality;
pub mod rbf;
pub mod record;
pub mod report;
pub mod run;
pub mod sample;

pub use deform::{Morph, MorphOptions, MorphReport, Nodes};
