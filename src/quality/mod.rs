//! How good a mesh is: cell metrics by the definitions of the Verdict library, face metrics by those of
//! finite-volume solvers, size and skew against a reference mesh, and their summary.
//!
//! Owns what a cell's volume, scaled Jacobian, edge ratio and skew are, and which cells count as
//! inverted. Leaves to others where the nodes are and what is done about a bad cell. Second-order
//! cells are judged by their corners; polygons and polyhedra have an area or a volume and face metrics
//! only. Only volume cells (those of the mesh's own dimension) count.
//!
//! Source: C. J. Stimpson, C. D. Ernst, P. Knupp, P. P. Pebay, D. Thompson, The Verdict Geometric
//! Quality Library, Sandia report SAND2007-1751, with the later changes that VTK 9 has.

mod angles;
mod block;
mod cells;
mod column;
pub mod criterion;
mod detail;
pub mod faces;
mod facing;
mod figures;
mod flaws;
mod fold;
mod judge;
mod metrics;
mod percentile;
mod plane;
mod reference;
mod remarks;
pub mod size_skew;
mod solid;
mod span;
mod statistics;
mod summary;
#[cfg(test)]
mod tests;
pub mod validity;
mod visit;
mod worst;

pub use cells::{per_cell, scaled_jacobians};
pub use criterion::Criterion;
pub use figures::{Quality, quality};
pub use flaws::{Flawed, Flaws, flaws};
pub use judge::{Assessment, Judge};
pub use reference::Reference;
pub use remarks::remarks;
pub use statistics::{Statistic, statistics};
pub use summary::assess;
pub use summary::{Extreme, Summary};
pub use worst::{Candidate, worst};
