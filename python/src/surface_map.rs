//! The class `SurfaceMap`.

use crate::arguments;
use crate::arrays::owned;
use crate::background::{done, mapped};
use crate::error::input;
use azimesh::SurfaceMap;
use pyo3::prelude::*;
use std::sync::Arc;

/// A map of displacements from given points to the points of another surface, and of forces back.
///
/// ``SurfaceMap(given, wall, method="rbf", *, facets=None)``: points (n, 3) with displacements and points (N, 3) that need
/// them. `method` is ``"rbf"``, ``"nearest"``, or ``"plane"`` with `facets`, triangles (m, 3) of given points or edges [a, b, b] in
/// the plane. Calling it with displacements (n, 3) gives those (N, 3) of the wall points.
#[pyclass(frozen, weakref, module = "azimesh", name = "SurfaceMap")]
pub struct PySurfaceMap {
    map: Arc<SurfaceMap>,
}

#[pymethods]
impl PySurfaceMap {
    #[new]
    #[pyo3(signature = (given, wall, method="rbf", *, facets=None))]
    fn new(
        py: Python<'_>,
        given: &Bound<'_, PyAny>,
        wall: &Bound<'_, PyAny>,
        method: &str,
        facets: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let given = arguments::vectors(given, "given points")?;
        let wall = arguments::vectors(wall, "wall points")?;
        let facets = facets.map(|facets| arguments::table(facets, "facets"));
        let map = match (method, facets.transpose()?) {
            ("rbf", None) => done(py, None, move || SurfaceMap::rbf(&given, &wall)),
            ("nearest", None) => done(py, None, move || SurfaceMap::nearest(&given, &wall)),
            ("plane", Some((facets, 3))) => done(py, None, move || {
                SurfaceMap::plane(&given, facets.as_chunks::<3>().0, &wall)
            }),
            ("plane", _) => Err(input(
                py,
                "method \"plane\" needs `facets`, an array (m, 3) of point numbers",
            )),
            ("rbf" | "nearest", _) => Err(input(py, "`facets` are for method \"plane\"")),
            _ => Err(input(
                py,
                format!("unknown method \"{method}\"; known: \"rbf\", \"nearest\", \"plane\""),
            )),
        };
        Ok(Self {
            map: Arc::new(map?),
        })
    }

    /// Distances (N) of the wall points from the given surface.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        owned(py, self.map.distances().to_vec())
    }

    /// Displacements (N, 3) of the wall points for displacements (n, 3) of the given points; rotations may be large.
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        displacements: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let map = SurfaceMap::displacements;
        mapped(py, &self.map, displacements, "displacements", map)
    }

    /// Forces (n, 3) at the given points for forces (N, 3) at the wall points: their sum and, but for "nearest", the sum of
    /// their moments stay.
    fn pull_back<'py>(
        &self,
        py: Python<'py>,
        forces: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        mapped(py, &self.map, forces, "forces", SurfaceMap::pull_back)
    }
}
