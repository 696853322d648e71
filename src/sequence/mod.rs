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
mod course;
mod deformer;
mod differs;
mod extremes;
mod fields;
mod finish;
mod finished;
mod fit;
mod given;
mod glide;
mod joined;
mod layer;
mod lock;
mod memory;
mod meshes;
mod output;
mod parts;
mod pass;
mod periodic;
mod plan;
mod progress;
mod prove;
mod record;
mod repair;
mod resume;
mod rims;
mod run;
mod sections;
mod space;
mod step;
mod stop;
mod stretches;
mod substeps;
mod surface;
mod survey;
mod table;
mod velocity;
mod wall;
mod wall_angle;
mod writer;
mod zone;

pub use choose::{check_tolerance, choose, constant};
pub use deformer::Deformer;
pub use extremes::Extremes;
pub use finish::finish;
pub use finished::Finished;
pub use layer::{Centre, Kind, Layer};
pub use memory::{check_memory, estimate_memory};
pub use plan::Plan;
pub use progress::{Progress, Silent};
pub use run::{Request, estimate_bytes, run};
pub use stop::Stop;
pub use surface::SurfacePoints;
pub use survey::{BodyAtStep, bodies_at, conflicts};
pub use wall::FirstCells;
pub use wall_angle::WallAngles;

#[cfg(test)]
mod tests;
