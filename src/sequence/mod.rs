//! A run from plan to files: base points once, mode fields once, one mesh a step.
//!
//! ```text
//! Plan ──> Selection ──> Deformer ──> points, quality, one file and one row of steps.csv a step
//! ```
//!
//! Owns what a run decides, the order of its work and what it leaves in its folder. Leaves to
//! others how a motion is written down, how it is interpolated and what a file looks like.

pub mod base;
mod checks;
mod choose;
mod deformer;
mod fields;
mod fit;
mod given;
mod glide;
mod layer;
mod meshes;
mod output;
mod periodic;
mod plan;
mod progress;
mod record;
mod run;
mod sections;
mod step;
mod stretches;
mod surface;
mod survey;
mod velocity;
mod wall;
mod zone;

pub use choose::{check_tolerance, choose, constant};
pub use deformer::Deformer;
pub use layer::{Centre, Kind, Layer};
pub use plan::Plan;
pub use progress::{Progress, Silent};
pub use run::{Finished, Request, estimate_bytes, run};
pub use surface::SurfacePoints;
pub use survey::{BodyAtStep, bodies_at, conflicts};
pub use wall::FirstCells;

#[cfg(test)]
mod tests;
