//! Records of a run besides meshes, as types of plain numbers.
//!
//! Owns the layout of run.json, steps.csv and base.toml and the names of their files; one definition for writing and
//! reading. `run` writes them, and `report` shows them.

mod base;
mod criterion;
mod diagnostic;
mod names;
mod run;
mod steps;
#[cfg(test)]
mod tests;

pub use base::BaseFile;
pub use criterion::Criterion;
pub use diagnostic::{Diagnostic, Failed, Failure, Level, sentences};
pub use names::{file_name, numbered, part_of, parts_in, step_of};
pub use run::{
    BodyRecord, EndRecord, FunctionRecord, InputRecord, LayerRecord, MotionRecord, OptionsRecord,
    PatchRecord, RepairRecord, RunRecord, SelectionRecord, Timings, WorstStep, in_shell,
    in_shell_all,
};
pub use steps::{CHECKSUM, COLUMNS, Row, Rows, lines, parse, text};
