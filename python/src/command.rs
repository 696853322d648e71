//! The program `azimesh`, and the page of a run.

use crate::background::done;
use crate::error::{input, raised};
use azimesh::{ReadOptions, cli, report::page};
use azimesh_io::formats::{Commit, save_text};
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Writes the page of a run in `folder` to `output`; gives its path.
#[pyfunction]
#[pyo3(signature = (folder, output=None))]
pub fn report(py: Python<'_>, folder: PathBuf, output: Option<PathBuf>) -> PyResult<PathBuf> {
    if !folder.is_dir() {
        return Err(input(py, format!("{} is no folder", folder.display())));
    }
    let output = output.unwrap_or_else(|| folder.join("report.html"));
    let to = output.clone();
    done(py, None, move || {
        let found = page(&folder, &ReadOptions::default())?;
        save_text(&found.html, &to, Commit::REPLACE)
    })?;
    Ok(output)
}

/// Runs the program with these arguments, the first its name; gives the exit code.
#[pyfunction]
pub fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    let thread = std::thread::Builder::new();
    let run = thread.spawn(move || cli::run_with(arguments));
    let run = run.map_err(|error| raised(py, &azimesh::Error::system(error.to_string())))?;
    // The program listens to signals itself from here on.
    Ok(py.detach(|| run.join().unwrap_or(101)))
}
