//! Moves unstructured meshes with rotors, wings and other moving bodies, by radial basis functions.
//!
//! Two types do most of the work. A [`Deformation`] takes a mesh and a [`Schedule`] of steps, and computes node positions,
//! velocities and quality at every step. A [`Morph`] takes only a mesh, and any displacements of its surface, for example
//! from a flow solver that is coupled to a structure.
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
//! In a `Cargo.toml`, `azimesh = { version = "0.1", default-features = false }` selects the library without the program.
//! Lengths are in the mesh's own unit, angles in radians unless a name says degrees. An [`Error`] has the place, the value
//! found and the remedy.
//!
//! | task | see |
//! |---|---|
//! | read, make and write meshes | [`Mesh`], [`MeshView`], [`ReadOptions`], [`WriteOptions`] |
//! | say what moves, and when | [`Schedule`], [`Steps`], [`Body`], [`Rotor`] |
//! | give a body its motion | [`Cyclic`], [`AxisRotation`], [`Translation`], [`TableMotion`], [`Beam`], [`Modes`], [`SurfaceMotion`] |
//! | deform a mesh | [`Deformation`], [`Morph`] |
//! | carry displacements to a surface with other points, and forces back | [`SurfaceMap`] |
//! | evaluate and compare meshes | [`quality`](fn@quality), [`diff`] |
//!
//! Further reading in the repository: programs in `examples/`, `ARCHITECTURE.md`, and `docs/method.md` for
//! the equations.

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod alloc;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod preflight;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod record;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod report;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod run;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod sample;

#[doc(inline)]
pub use azimesh_core::{Error, ErrorKind, Note, Progress, Result, Stop};
#[doc(inline)]
pub use azimesh_deform::{
    AxisRotation, BasePoints, Beam, Body, Cyclic, Deformation, DeformationBuilder, Interpolate,
    Kernel, MapMethod, Modes, Morph, MorphOptions, MorphReport, Nodes, OnInverted, Others,
    Polynomial, QualityOutput, RotationForm, Rotor, Schedule, SelectionCriterion, SelectionMethod,
    Step, Steps, SurfaceMotion, SurfaceOutput, Table, TableMotion, Translation,
};
#[doc(inline)]
pub use azimesh_io::{
    CellKind, Cells, Compression, DataArray, DiffOptions, Difference, Encoding, Group, Loaded,
    Mesh, MeshView, Notes, Precision, ReadOptions, SplitCounts, Values, WriteOptions, diff,
};
#[doc(inline)]
pub use azimesh_quality::{Quality, quality};
#[doc(inline)]
pub use azimesh_rbf::SurfaceMap;
