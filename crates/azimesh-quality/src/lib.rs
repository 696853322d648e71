//! Quality of meshes: metrics of cells and faces, validity, and the repair of folded cells.
//!
//! Owns: the volume, scaled Jacobian, edge ratio and skew of a cell, by the definitions of the Verdict library;
//! face metrics of finite-volume solvers; size and skew against a reference mesh; the rule by which a cell counts
//! as inverted, between its corners too; summaries and statistics; patches of cells in which nodes are moved until
//! all are valid. Only volume cells (cells of the mesh's own dimension) count. Second-order cells are evaluated by
//! their corners; polygons and polyhedra have an area or a volume and face metrics only. All sums are the same on
//! any number of threads.
//!
//! Leaves to others: meshes and files (`azimesh-io`), node positions at a step and the nodes that a repair may
//! move (`azimesh-deform`), limits and reports (the program).
//!
//! ```text
//! reference mesh ──> QualityEvaluator (Reference: orientation of cells; sizes; adjacency)
//!                      │ assess(mesh, points)
//!                      v
//!                    Assessment = Summary (cells) + FaceSummary (faces) ──> Quality (plain numbers)
//!
//! Reference, points ──> per_cell, statistics, worst ──> CellMetrics, Statistic, Candidate
//!                  └──> validity::assess ──> Validity (between the corners)
//! repair::Task (mesh, Reference, Freedom), points ──> untangle, improve ──> Repaired
//! ```
//!
//! ```
//! use azimesh_io::Mesh;
//! use azimesh_quality::{QualityEvaluator, worst};
//!
//! # fn main() -> azimesh_io::Result<()> {
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! let judge = QualityEvaluator::new(&mesh); // later positions are compared with these
//! let before = judge.assess(&mesh, &mesh.points).cells;
//! assert_eq!(before.inverted, 0);
//!
//! // A node of the worst cell is moved far away.
//! let cell = worst(&mesh, &mesh.points, &judge.reference, 1)[0].cell;
//! let mut points = mesh.points.clone();
//! points[mesh.cells.get(cell).nodes[0] as usize][0] += 100.0;
//! let after = judge.assess(&mesh, &points).cells;
//! assert!(after.inverted > 0 && !after.inverted_cells.is_empty());
//! # Ok(())
//! # }
//! ```
//!
//! Source: C. J. Stimpson, C. D. Ernst, P. Knupp, P. P. Pebay, D. Thompson, The Verdict Geometric
//! Quality Library, Sandia report SAND2007-1751, with the later changes that VTK 9 has.

mod angles;
mod block;
mod cells;
mod column;
mod detail;
mod evaluator;
pub mod faces;
mod facing;
mod figures;
mod flaws;
mod fold;
mod metrics;
mod percentile;
mod plane;
mod reference;
mod remarks;
pub mod repair;
pub mod size_skew;
mod solid;
mod span;
mod statistics;
mod summary;
mod tagged;
#[cfg(test)]
mod tests;
pub mod validity;
mod visit;
mod worst;

pub use cells::{CellMetrics, per_cell, scaled_jacobians};
pub use evaluator::{Assessment, CURVED_COLUMNS, QualityEvaluator};
pub use figures::{Quality, quality};
pub use flaws::{Flawed, Flaws, flaws};
pub use reference::Reference;
pub use remarks::remarks;
pub use statistics::{Statistic, statistics};
pub use summary::assess;
pub use summary::{Extreme, Summary};
pub use tagged::TaggedSurface;
pub use validity::curved::FaceTerms;
pub use worst::{Candidate, worst};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
