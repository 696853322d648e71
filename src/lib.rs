//! Moves unstructured meshes with rotors, wings and anything else that turns, by radial basis
//! functions.
//!
//! Two types do most of it. A [`Deformation`] takes a mesh and a [`Schedule`] of steps, and gives node
//! positions, velocities and quality at every step. A [`Morph`] takes a mesh alone, and any displacements
//! of its surface, as a flow solver that is coupled to a structure has them.
//!
//! ```
//! use azimesh::{Body, Cyclic, Deformation, Mesh, Schedule, Steps};
//!
//! fn main() -> azimesh::Result<()> {
//!     let mesh = Mesh::read("testdata/naca0012.vtu")?;
//!     let schedule = Schedule::new(Steps::azimuth_deg(0.0, 360.0, 10.0))
//!         .body(Body::new("airfoil", ["airfoil"]).cyclic(Cyclic::new().pitch_deg(1, 5.0, 0.0)))
//!         .fixed(["farfield"]);
//!     let deformation = Deformation::new(mesh, schedule)?;
//!     for step in deformation.steps() {
//!         let points = deformation.points_at(step)?;
//!         let quality = deformation.quality_of(&points)?;
//!         println!("{step}: least scaled Jacobian {:.3}", quality.min_scaled_jacobian);
//!     }
//!     Ok(())
//! }
//! ```
//!
//! In a `Cargo.toml`, `azimesh = { version = "0.1", default-features = false }` gives the library without
//! the program. Lengths are in the mesh's own unit, angles in radians unless a name says degrees. Errors
//! are [`Error`]: what was found, where, and what would be right.
//!
//! | to | see |
//! |---|---|
//! | read, make and write meshes | [`Mesh`], [`MeshView`], [`ReadOptions`], [`WriteOptions`] |
//! | say what moves, and when | [`Schedule`], [`Steps`], [`Body`], [`Rotor`] |
//! | give a body its motion | [`Cyclic`], [`AxisRotation`], [`Translation`], [`TableMotion`], [`Beam`], [`Modes`], [`SurfaceMotion`] |
//! | deform a mesh | [`Deformation`], [`Morph`] |
//! | judge and compare meshes | [`quality`](fn@quality), [`diff`] |
//!
//! Further reading in the repository: programs in `examples/`, `ARCHITECTURE.md`, and `docs/method.md` for
//! the equations.

// The library alone does without what the program takes from its rooms.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod deform;
#[cfg(not(feature = "internals"))]
mod deform;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod diagnostic;
#[cfg(not(feature = "internals"))]
mod diagnostic;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod error;
#[cfg(not(feature = "internals"))]
mod error;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod formats;
#[cfg(not(feature = "internals"))]
mod formats;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod geometry;
#[cfg(not(feature = "internals"))]
mod geometry;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod linear;
#[cfg(not(feature = "internals"))]
mod linear;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod mesh;
#[cfg(not(feature = "internals"))]
mod mesh;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod modes;
#[cfg(not(feature = "internals"))]
mod modes;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod motion;
#[cfg(not(feature = "internals"))]
mod motion;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod parallel;
#[cfg(not(feature = "internals"))]
mod parallel;
#[cfg(all(feature = "cli", feature = "internals"))]
#[doc(hidden)]
pub mod preflight;
#[cfg(all(feature = "cli", not(feature = "internals")))]
mod preflight;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod progress;
#[cfg(not(feature = "internals"))]
mod progress;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod quality;
#[cfg(not(feature = "internals"))]
mod quality;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod ranks;
#[cfg(not(feature = "internals"))]
mod ranks;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod rbf;
#[cfg(not(feature = "internals"))]
mod rbf;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod record;
#[cfg(not(feature = "internals"))]
mod record;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod repair;
#[cfg(not(feature = "internals"))]
mod repair;
#[cfg(all(feature = "cli", feature = "internals"))]
#[doc(hidden)]
pub mod report;
#[cfg(all(feature = "cli", not(feature = "internals")))]
mod report;
#[cfg(all(feature = "cli", feature = "internals"))]
#[doc(hidden)]
pub mod run;
#[cfg(all(feature = "cli", not(feature = "internals")))]
mod run;
#[cfg(all(feature = "cli", feature = "internals"))]
#[doc(hidden)]
pub mod sample;
#[cfg(all(feature = "cli", not(feature = "internals")))]
mod sample;
#[doc(hidden)]
pub mod sparse;

pub use deform::{BasePoints, Deformation, DeformationBuilder};
pub use deform::{Morph, MorphOptions, MorphReport, Nodes};
pub use diagnostic::Diagnostic;
pub use error::{Error, ErrorKind, Result};
#[cfg(feature = "vtkio")]
pub use formats::vtkio;
pub use formats::{Compression, Encoding, Loaded, Notes, Precision, ReadOptions, WriteOptions};
pub use mesh::{
    CellKind, Cells, DataArray, DiffOptions, Difference, Group, Mesh, MeshView, SplitCounts,
    Values, diff,
};
pub use motion::{
    AxisRotation, Beam, Body, Cyclic, Modes, SurfaceMotion, Table, TableMotion, Translation,
};
pub use motion::{
    Interpolate, KernelName as Kernel, OnInverted, Others, Polynomial, QualityOutput, Rotor,
    Schedule, SelectionCriterion, SelectionMethod, Step, Steps, SurfaceOutput,
};
pub use progress::{Progress, Stop};
pub use quality::{Quality, quality};
