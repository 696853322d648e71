//! azimesh in Python: the native half of the package `azimesh`.
//!
//! Owns what Python sees of the library: classes that look at Rust's memory, errors with their place, and work that
//! lets the interpreter go on. Shapes, units and errors of each name are in the package's docstrings.

// PyO3's extraction of arguments hands them over by value.
#![allow(clippy::needless_pass_by_value)]

mod arguments;
mod arrays;
mod background;
mod command;
mod deformation;
mod difference;
mod error;
mod kinds;
mod make;
mod mesh;
mod morph;
mod progress;
mod quality;
mod schedule;
mod surface_map;

use pyo3::prelude::*;

/// What the package imports.
#[pymodule]
fn _azimesh(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<arrays::Memory>()?;
    module.add_class::<mesh::PyMesh>()?;
    module.add_class::<schedule::PySchedule>()?;
    module.add_class::<schedule::PyMoment>()?;
    module.add_class::<deformation::PyDeformation>()?;
    module.add_class::<deformation::PyStep>()?;
    module.add_class::<morph::PyMorph>()?;
    module.add_class::<surface_map::PySurfaceMap>()?;
    module.add_class::<difference::PyDifference>()?;
    module.add_function(wrap_pyfunction!(mesh::read, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::write, module)?)?;
    module.add_function(wrap_pyfunction!(quality::quality, module)?)?;
    module.add_function(wrap_pyfunction!(difference::diff, module)?)?;
    module.add_function(wrap_pyfunction!(command::report, module)?)?;
    module.add_function(wrap_pyfunction!(command::run_command, module)?)?;
    Ok(())
}
