//! What a run leaves behind besides meshes, as types of plain numbers.
//!
//! Owns the layout of steps.csv. Leaves to `run` when it is written, and to `report` what is shown of it.

mod steps;

pub use steps::{COLUMNS, Row, Rows, number, parse, text};
