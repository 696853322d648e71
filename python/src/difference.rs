//! How two meshes differ.

use crate::background::done;
use crate::mesh::PyMesh;
use azimesh::{DiffOptions, Difference};
use pyo3::prelude::*;
use std::sync::Arc;

/// What a comparison found.
#[pyclass(frozen, module = "azimesh", name = "Difference")]
pub struct PyDifference {
    found: Difference,
}

#[pymethods]
impl PyDifference {
    /// Returns whether the meshes are the same within the tolerance.
    #[getter]
    fn is_same(&self) -> bool {
        self.found.is_same()
    }

    /// Largest distance of two nodes that belong together, in mesh units.
    #[getter]
    fn max_distance(&self) -> f64 {
        self.found.max_distance()
    }

    /// Nodes that are further apart than the tolerance.
    #[getter]
    fn moved_nodes(&self) -> usize {
        self.found.moved_nodes
    }

    /// Cells that differ in their kind or nodes.
    #[getter]
    fn changed_cells(&self) -> usize {
        self.found.changed_cells
    }

    /// What differs, in words.
    #[getter]
    fn sentences(&self) -> Vec<String> {
        let found = &self.found;
        let parts = [&found.nodes, &found.cells, &found.groups, &found.arrays];
        parts.into_iter().flatten().cloned().collect()
    }

    /// What could not be compared, in words.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.found.notes.iter().map(ToString::to_string).collect()
    }

    fn __bool__(&self) -> bool {
        !self.found.is_same()
    }

    fn __repr__(&self) -> String {
        if self.found.is_same() {
            "<azimesh.Difference: same>".to_owned()
        } else {
            format!("<azimesh.Difference: {}>", self.sentences().join("; "))
        }
    }
}

/// Compares two meshes node by node, cell by cell, tag by tag, array by array; the result is true where they differ.
///
/// `tolerance` is in mesh units, with `relative` a fraction of the diagonal. With `by_position` nodes are paired by their
/// places, at most `match_tolerance` apart.
#[pyfunction]
#[pyo3(signature = (a, b, *, tolerance=0.0, relative=false, by_position=false, match_tolerance=None))]
pub fn diff(
    py: Python<'_>,
    a: &PyMesh,
    b: &PyMesh,
    tolerance: f64,
    relative: bool,
    by_position: bool,
    match_tolerance: Option<f64>,
) -> PyResult<PyDifference> {
    let options = DiffOptions {
        tolerance,
        relative,
        by_position,
        match_tolerance,
    };
    let (a, b) = (Arc::clone(&a.mesh), Arc::clone(&b.mesh));
    let found = done(py, None, move || azimesh::diff(&a, &b, &options))?;
    Ok(PyDifference { found })
}
