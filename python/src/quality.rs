//! Quality of cells and of a mesh as arrays and numbers.

use crate::arrays::{frozen, owned};
use crate::background::done;
use crate::error::input;
use crate::mesh::PyMesh;
use azimesh::{Error, Quality, Values};
use azimesh_quality::QualityEvaluator;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Metrics of each cell, and their summary; against the cells of `reference`, which has the same cells, where it is given.
#[pyfunction]
#[pyo3(signature = (mesh, reference=None))]
pub fn quality<'py>(
    py: Python<'py>,
    mesh: &PyMesh,
    reference: Option<&PyMesh>,
) -> PyResult<Bound<'py, PyAny>> {
    let mesh = Arc::clone(&mesh.mesh);
    let is_own = reference.is_none();
    let reference = reference.map_or(&mesh, |reference| &reference.mesh);
    if reference.cells != mesh.cells || reference.points.len() != mesh.points.len() {
        return Err(input(py, "the reference has other cells than the mesh"));
    }
    let reference = Arc::clone(reference);
    let (cells, summary) = done(py, None, move || {
        let mut evaluator = QualityEvaluator::new(&reference);
        if is_own {
            evaluator = evaluator.upright(&mesh, false);
        }
        let all = evaluator.assess(&mesh, &mesh.points);
        let cells = evaluator.arrays(&mesh, &mesh.points);
        Ok::<_, Error>((cells, Quality::from(&all)))
    })?;
    let arrays = PyDict::new(py);
    for array in cells {
        let values = match array.values {
            Values::F64(values) => owned(py, values),
            Values::U8(flags) => owned(py, flags.iter().map(|flag| *flag != 0).collect()),
            _ => continue,
        };
        arrays.set_item(array.name, frozen(values)?)?;
    }
    let class = py.import("azimesh._quality")?.getattr("Quality")?;
    class.call1((arrays, summary_of(py, &summary)?))
}

/// The numbers of a summary by their names.
pub fn summary_of<'py>(py: Python<'py>, found: &Quality) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, count) in [
        ("n_cells", found.n_cells),
        ("inverted", found.inverted),
        ("inverted_reference", found.inverted_reference),
        ("unproven", found.unproven),
    ] {
        all.set_item(name, count)?;
    }
    for (name, value) in [
        ("min_volume", found.min_volume),
        ("min_scaled_jacobian", found.min_scaled_jacobian),
        ("mean_scaled_jacobian", found.mean_scaled_jacobian),
        ("p01_scaled_jacobian", found.p01_scaled_jacobian),
        ("max_edge_ratio", found.max_edge_ratio),
        ("max_skew", found.max_skew),
        ("min_curved_jacobian", found.min_curved_jacobian),
        (
            "min_curved_scaled_jacobian",
            found.min_curved_scaled_jacobian,
        ),
        ("max_non_orthogonality", found.max_non_orthogonality),
        ("mean_non_orthogonality", found.mean_non_orthogonality),
        ("max_face_skewness", found.max_face_skewness),
        ("min_volume_ratio", found.min_volume_ratio),
        ("min_face_weight", found.min_face_weight),
        ("min_size_skew", found.min_size_skew),
        ("mean_size_skew", found.mean_size_skew),
        ("min_first_cell_ratio", found.min_first_cell_ratio),
        ("max_normal_change_deg", found.max_normal_change_deg),
    ] {
        all.set_item(name, value)?;
    }
    Ok(all)
}
