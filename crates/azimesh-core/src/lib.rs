//! The parts that every crate of azimesh uses: errors, notes, parallel loops, geometry, linear systems, ranks.
//!
//! Owns: the error type, with its place in a file; notes, with code, sentence, place and data; numbers in sentences;
//! progress and stop requests; parallel loops with the same result on any number of threads; vectors, rigid
//! transforms, boxes, order in space and closest points; dense factors and sparse systems of 3x3 blocks;
//! messages between processes that share a mesh.
//!
//! Leaves to others: meshes and files (`azimesh-io`), interpolation (`azimesh-rbf`), quality
//! (`azimesh-quality`), motions (`azimesh-deform`), and MPI, which the program connects as a
//! [`Network`](ranks::Network). Prints nothing.
//!
//! ```text
//! error       Error = ErrorKind + file + Position + message         Result
//! note        Note = code + file + Position + text + data
//! progress    Progress (stages, as a trait)                         Stop (a request to end)
//! parallel    collect, map, map_blocks, for_blocks, sort            results in order
//! geometry    Vector ──> Bounds, Transform, Moving, Twist           curve, ClosestSurface ──> ClosestPoint
//! linear      Matrix ──> Cholesky, GrowingCholesky, svd             blocks::Blocks (sparse, symmetric)
//! ranks       Ranks ──> Network ──> the other ranks                 alone: rank 0 of 1
//! ```
//!
//! ```
//! use azimesh_core::geometry::{Bounds, Transform};
//! use azimesh_core::{Error, parallel};
//! use std::f64::consts::FRAC_PI_2;
//! use std::path::Path;
//!
//! // 10,000 points along x, turned about z on all threads.
//! let turn = Transform::rotation([0.0, 0.0, 1.0], [0.0; 3], FRAC_PI_2);
//! let turned = parallel::collect(10_000, |i| turn.apply([i as f64, 0.0, 0.0]));
//! let bounds = Bounds::around(&turned);
//! assert!(bounds.high[0] < 1e-9 && (bounds.high[1] - 9999.0).abs() < 1e-9);
//!
//! let error = Error::input("found 2 node indices, a triangle needs 3").line(412).file(Path::new("wing.su2"));
//! assert_eq!(error.to_string(), "wing.su2:412: found 2 node indices, a triangle needs 3");
//! ```

pub mod error;
pub mod geometry;
pub mod linear;
pub mod note;
pub mod numbers;
pub mod parallel;
pub mod progress;
pub mod ranks;
pub mod sparse;

pub use error::{Error, ErrorKind, Result};
pub use note::Note;
pub use progress::{Progress, Stop};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
