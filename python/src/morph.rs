//! The class `Morph`.

use crate::arguments;
use crate::arrays::indices;
use crate::background::{ask, done, mapped};
use crate::error::{input, warn};
use crate::mesh::{PyMesh, choice};
use azimesh::{Kernel, Morph, MorphOptions, Nodes};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::sync::Arc;

/// A mesh that follows displacements of its moving nodes, linearly and exactly at the surface.
///
/// ``Morph(mesh, moving, fixed, *, slide, periodic, samples, max_points, tolerance, kernel, support_radius)``: nodes are
/// given by a tag, a list of tags or node numbers. Base points are chosen from `samples`, displacement fields (n_moving, 3)
/// such as mode shapes, else by the power function. Calling it with displacements gives positions.
#[pyclass(frozen, weakref, module = "azimesh", name = "Morph")]
pub struct PyMorph {
    morph: Arc<Morph>,
}

#[pymethods]
impl PyMorph {
    #[new]
    #[pyo3(signature = (mesh, moving, fixed=None, *, slide=None, periodic=None, samples=None, max_points=1000, tolerance=1e-4, kernel="wendland-c2", support_radius=None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        py: Python<'_>,
        mesh: &PyMesh,
        moving: &Bound<'_, PyAny>,
        fixed: Option<&Bound<'_, PyAny>>,
        slide: Option<&Bound<'_, PyAny>>,
        periodic: Option<Vec<[Bound<'_, PyAny>; 2]>>,
        samples: Option<Vec<Bound<'_, PyAny>>>,
        max_points: usize,
        tolerance: f64,
        kernel: &str,
        support_radius: Option<f64>,
    ) -> PyResult<Self> {
        let mut pairs = Vec::new();
        for [a, b] in periodic.iter().flatten() {
            pairs.push([nodes(a, "periodic")?, nodes(b, "periodic")?]);
        }
        let samples = samples.unwrap_or_default();
        let samples = samples
            .iter()
            .map(|sample| arguments::vectors(sample, "samples"));
        let options = MorphOptions {
            moving: nodes(moving, "moving")?,
            fixed: optional_nodes(fixed, "fixed")?,
            slide: optional_nodes(slide, "slide")?,
            periodic: pairs,
            samples: samples.collect::<PyResult<_>>()?,
            max_points,
            tolerance,
            kernel: choice(py, "kernel", kernel, &kernels())?,
            support_radius,
        };
        let mesh = Arc::clone(&mesh.mesh);
        let morph = done(py, None, move || Morph::new(mesh, options))?;
        warn(py, &morph.warning())?;
        Ok(Self {
            morph: Arc::new(morph),
        })
    }

    /// The mesh at rest.
    #[getter]
    fn mesh(&self) -> PyMesh {
        PyMesh::new(Arc::clone(self.morph.mesh()))
    }

    /// Numbers of the moving nodes (n_moving,), in the order of the displacements.
    #[getter]
    fn moving<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        indices(py, self.morph.moving().iter().map(|&node| node as usize))
    }

    /// Numbers of the nodes that are base points.
    #[getter]
    fn base_points<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let base = self.morph.base_points().into_iter();
        indices(py, base.map(|node| node as usize))
    }

    /// The error that the base points leave, in the sense of `tolerance`; above it there is a warning of class `Note`.
    #[getter]
    fn selection_error(&self) -> f64 {
        self.morph.selection_error()
    }

    /// Positions (n, 3) of all nodes for displacements (n_moving, 3) of the moving ones, in mesh units; exact at the surface.
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        displacements: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        mapped(
            py,
            &self.morph,
            displacements,
            "displacements",
            Morph::points,
        )
    }

    /// Displacements (n, 3) of all nodes: the linear part of the morph.
    fn displacements_of<'py>(
        &self,
        py: Python<'py>,
        displacements: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = Morph::displacements_of;
        mapped(py, &self.morph, displacements, "displacements", map)
    }

    /// The exact transpose of `displacements_of`: of derivatives (n, 3) by the positions of all nodes those (n_moving, 3) by
    /// the displacements of the moving ones.
    fn pull_back<'py>(
        &self,
        py: Python<'py>,
        d_points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        mapped(py, &self.morph, d_points, "derivatives", Morph::pull_back)
    }

    /// How far the base points are off at the surface before the correction, and where cells may fold for it.
    fn report<'py>(
        &self,
        py: Python<'py>,
        displacements: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let given = arguments::vectors(displacements, "displacements")?;
        let report = ask(py, &self.morph, move |morph| morph.report(&given))?;
        let found = PyDict::new(py);
        found.set_item("largest_residual", report.largest_residual)?;
        found.set_item("largest_slope", report.largest_slope)?;
        found.set_item("steepest_node", report.steepest_node)?;
        let steep = report.steep_nodes.into_iter().map(|node| node as usize);
        found.set_item("steep_nodes", indices(py, steep))?;
        Ok(found)
    }

    fn __repr__(&self) -> String {
        format!(
            "<azimesh.Morph: {} points, {} of them moving, {} base points>",
            self.morph.mesh().points().len(),
            self.morph.moving().len(),
            self.morph.base_points().len()
        )
    }
}

fn kernels() -> [(&'static str, Kernel); 4] {
    let all = [
        Kernel::WendlandC0,
        Kernel::WendlandC2,
        Kernel::WendlandC4,
        Kernel::WendlandC6,
    ];
    all.map(|kernel| (kernel.name(), kernel))
}

fn optional_nodes(given: Option<&Bound<'_, PyAny>>, what: &str) -> PyResult<Nodes> {
    given.map_or_else(|| Ok(Nodes::default()), |given| nodes(given, what))
}

/// A tag, several tags, or numbers of nodes.
fn nodes(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Nodes> {
    if given.is_instance_of::<PyString>() {
        return Ok(Nodes::Tags(vec![given.extract()?]));
    }
    match given.extract::<Vec<String>>() {
        Ok(tags) if tags.is_empty() => Err(input(given.py(), format!("`{what}` is empty"))),
        Ok(tags) => Ok(Nodes::Tags(tags)),
        Err(_) => Ok(Nodes::Numbers(arguments::indices(
            given,
            &format!("`{what}`"),
        )?)),
    }
}
