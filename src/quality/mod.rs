//! Cell metrics by the definitions of the Verdict library, and what they come to over a mesh.
//!
//! Owns what a cell's volume, scaled Jacobian, edge ratio and skew are, and which cells count as
//! inverted. Leaves to others where the nodes are and what is done about a bad cell. Second-order
//! cells are judged by their corners; polygons and polyhedra have an area or a volume only. Only
//! volume cells (those of the mesh's own dimension) count.
//!
//! Source: C. J. Stimpson, C. D. Ernst, P. Knupp, P. P. Pebay, D. Thompson, The Verdict Geometric
//! Quality Library, Sandia report SAND2007-1751, with the later changes that VTK 9 has.

mod angles;
mod block;
mod cells;
pub mod criterion;
mod detail;
mod fold;
mod metrics;
mod percentile;
mod plane;
mod reference;
mod solid;
mod statistics;
mod summary;
#[cfg(test)]
mod tests;
mod visit;
mod worst;

pub use cells::{CellMetrics, per_cell};
pub use criterion::Criterion;
pub use detail::detail_arrays;
pub use reference::Reference;
pub use statistics::{Statistic, statistics};
pub use summary::{Extreme, Summary, assess};
pub use worst::{Candidate, worst};
