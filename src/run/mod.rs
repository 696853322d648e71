//! A deformation written to a folder: names, rows, resume, parts, locks, files.
//!
//! Owns the order of the work and what it leaves in its folder. Leaves to `deform` where nodes are, and
//! to `formats` what a file looks like.

pub mod base_file;
mod base_points;
mod case;
mod compatibility;
mod finished;
mod lock;
mod merge;
mod merged;
mod meshes;
mod names;
mod parts;
mod record;
mod request;
mod resume;
#[expect(clippy::module_inception)]
mod run;
mod step;
mod step_loop;
mod surface;
mod table;
mod verify;
mod writer;

pub use finished::Finished;
pub use merge::finish;
pub use request::Request;
pub use run::{run, run_after};

#[cfg(test)]
mod tests;
