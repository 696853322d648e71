//! Errors and notes of the library as Python's.

use azimesh::{Error, ErrorKind, Note};
use azimesh_core::error::Position;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyTuple, PyType};

static ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static NOTE: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// The error as `azimesh.Error` with `kind`, `path` and `line`.
pub fn raised(py: Python<'_>, error: &Error) -> PyErr {
    let kind = match error.kind {
        ErrorKind::Input => "input",
        ErrorKind::Check => "check",
        ErrorKind::System => "system",
        ErrorKind::Interrupted { .. } => "interrupted",
    };
    let line = match error.position {
        Some(Position::Line(line)) => Some(line),
        _ => None,
    };
    let path = error.path.clone();
    let class = match ERROR.import(py, "azimesh._errors", "Error") {
        Ok(class) => class,
        Err(failed) => return failed,
    };
    match class.call1((error.to_string(), kind, path, line)) {
        Ok(value) => PyErr::from_value(value),
        Err(failed) => failed,
    }
}

/// Wrong input, found before the library is called.
pub fn input(py: Python<'_>, message: impl Into<String>) -> PyErr {
    raised(py, &Error::input(message))
}

/// Gives notes as warnings of class `azimesh.Note`, at the line that called the package.
pub fn warn<'n>(py: Python<'_>, notes: impl IntoIterator<Item = &'n Note>) -> PyResult<()> {
    let mut notes = notes.into_iter().peekable();
    if notes.peek().is_none() {
        return Ok(());
    }
    let class = NOTE.import(py, "azimesh._errors", "Note")?;
    let warnings = py.import("warnings")?;
    for note in notes {
        let arguments = PyTuple::new(py, [note.to_string()])?;
        let warning = class.call1(arguments)?;
        warnings.call_method1("warn", (warning, class, 1))?;
    }
    Ok(())
}
