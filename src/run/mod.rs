//! A deformation written to a folder: names, rows, resume, parts, locks, files.
//!
//! Owns the order of the work and the files in its folder. `deform` computes node positions, and `formats` the content of
//! mesh files.

pub mod base_file;
mod base_points;
mod compatibility;
mod finish;
mod finished;
mod lock;
mod names;
mod outputs;
mod parts;
mod record;
mod resume;
#[expect(clippy::module_inception)]
mod run;
mod step;
mod step_loop;
mod surface;
mod table;
mod writer;

pub use finish::finish;
pub use finished::Finished;
pub use run::{Request, run, run_after};

#[cfg(test)]
mod tests;
