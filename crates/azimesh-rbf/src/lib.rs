//! Interpolation of scattered values in space by compactly supported radial basis functions.
//!
//! Points and values in, values at any other points out. No mesh is needed.
//!
//! Owns: kernels; dense systems for the weights, with a polynomial, constrained directions or periodic images;
//! greedy selection of base points; evaluation at millions of points on all threads; the correction that makes
//! a surface exact; a motion as a few modes; maps between surfaces that do not match. Results are the same on any number of threads.
//!
//! Leaves to others: meshes and files (`azimesh-io`), schedules of motions and the order of a run
//! (`azimesh-deform`), vectors, dense factors and parallel loops (`azimesh-core`).
//!
//! ```text
//! s(x) (1, r) = sum_j phi(|x - b_j| / R) w_j,     j = 1 .. n
//!
//! x, b_j  (3)      a point, and a base point: coordinates in any unit of length
//! R                support radius, in that unit: phi is zero at and beyond it
//! phi              kernel of the scaled distance, without a unit, phi(0) = 1
//! w_j     (1, r)   weights, in the unit of the values: s(b_i) = values_i, r columns at once
//! ```
//!
//! All tables are slices by rows: `values (n, r)` has the `r` numbers of the first point first.
//!
//! ```text
//! Basis (Kernel, radius), points, values
//!   ├─> Interpolant::through ─────> Interpolant (base points, weights) ──> at(points)
//!   └─> Selection::to_tolerance ──> Selection (base points, Interpolant, residuals)
//!
//! Modes of a motion
//!   └─> Targets, Space, Limits ──> select ──> Selection ──┬─> Field (modes at nodes) ──> displace(step)
//!                                                         └─> Correction ──^
//! ```
//!
//! Weights that reproduce values at given points, evaluated elsewhere:
//!
//! ```
//! use azimesh_rbf::{Basis, Interpolant, Kernel};
//!
//! let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
//! let values = [20.0, 22.0, 21.0, 25.0]; // one column: a temperature at each point
//! let basis = Basis { kernel: Kernel::WendlandC2, radius: 10.0 }; // several distances between points
//! let field = Interpolant::through(basis, &points, &values, 1)?;
//!
//! let found = field.at(&[[1.0, 1.0, 0.0], [0.5, 0.5, 0.0]]);
//! assert!((found[0] - 25.0).abs() < 1e-9); // a given point
//! assert!((found[1] - 22.8).abs() < 0.1); // the middle
//! # Ok::<(), azimesh_rbf::Error>(())
//! ```
//!
//! Base points chosen from many points, so that the interpolant is within a tolerance at all of them:
//!
//! ```
//! use azimesh_rbf::{Basis, Kernel, Selection};
//!
//! // 5000 points along a helix, and their displacements: three columns.
//! let points: Vec<[f64; 3]> = (0..5000).map(|i| f64::from(i) / 500.0).map(|t| [t.cos(), t.sin(), t]).collect();
//! let values: Vec<f64> = points.iter().flat_map(|[x, _, z]| [0.01 * z * z, 0.1 * x, 0.0]).collect();
//! let basis = Basis { kernel: Kernel::WendlandC2, radius: 10.0 };
//! let selection = Selection::to_tolerance(basis, &points, &values, 3, 1e-3)?;
//!
//! assert!(selection.error <= 1e-3);
//! assert!(selection.base.len() < 200); // their indices; the first was the worst of all points
//! let found = selection.interpolant.at(&[points[1234]]);
//! assert!((found[1] - 0.1 * points[1234][0]).abs() <= 1e-3);
//! # Ok::<(), azimesh_rbf::Error>(())
//! ```
//!
//! Sources: C. Sheng, C. B. Allen, AIAA Journal 51(3), 2013; H. Wendland, Adv. Comput. Math. 4, 1995. Modules
//! name further ones.

use serde::{Deserialize, Serialize};

pub mod constrained;
pub mod constraint;
pub mod correct;
pub mod criterion;
pub mod distinct;
pub mod evaluate;
pub mod field;
pub mod images;
pub mod interpolant;
pub mod kernel;
pub mod modes;
mod newton;
pub mod power;
pub mod select;
pub mod slide;
pub mod space;
pub mod surface_map;
pub mod sweeps;
pub mod system;
pub mod targets;
pub mod transposed;

pub use azimesh_core::error::{Error, ErrorKind, Result};
pub use azimesh_core::geometry::vector::Vector;
pub use interpolant::Interpolant;
pub use kernel::Kernel;
pub use select::Selection;
pub use surface_map::SurfaceMap;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// A kernel with its support radius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Basis {
    /// The function of the scaled distance.
    pub kernel: Kernel,
    /// Distance at and beyond which it is zero, in the unit of the points.
    pub radius: f64,
}

impl Basis {
    /// Evaluates `phi(|a - b| / R)`.
    pub fn between(&self, a: &[f64; 3], b: &[f64; 3]) -> f64 {
        let squared: f64 = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum();
        self.kernel.value(squared.sqrt() / self.radius)
    }
}
