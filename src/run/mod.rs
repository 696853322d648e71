//! A deformation written to a folder: names, rows, resume, parts, locks, files.
//!
//! Owns the order of the work and what it leaves in its folder. Leaves to `deform` where nodes are, and
//! to `formats` what a file looks like.

pub mod base;
mod compatibility;
mod finished;
mod intervals;
mod lock;
mod merge;
mod merged;
mod meshes;
mod names;
mod parts;
mod prove;
mod record;
mod resume;
#[expect(clippy::module_inception)]
mod run;
mod step;
mod step_loop;
mod table;
mod writer;

pub use finished::Finished;
pub use merge::finish;
pub use run::{Request, run};

#[cfg(test)]
mod tests;
