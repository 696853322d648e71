//! Arrays of Rust as numpy's: views of memory that a mesh owns, and vectors handed over.

use azimesh::{Mesh, Values};
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyUntypedArray};
use pyo3::prelude::*;
use pyo3::types::PyList;
use std::sync::Arc;

/// What numpy keeps alive as long as an array looks at a mesh.
#[pyclass(frozen, module = "azimesh._azimesh")]
pub struct Memory(#[expect(dead_code, reason = "it is held, not read")] Arc<Mesh>);

/// Makes views of one mesh.
pub struct Views<'py> {
    py: Python<'py>,
    owner: Bound<'py, PyAny>,
}

impl<'py> Views<'py> {
    /// Views of this mesh.
    pub fn of(py: Python<'py>, mesh: &Arc<Mesh>) -> PyResult<Self> {
        let owner = Bound::new(py, Memory(Arc::clone(mesh)))?.into_any();
        Ok(Self { py, owner })
    }

    /// A read-only view (n,).
    ///
    /// # Safety
    /// `values` are in the memory of the mesh, which nobody changes.
    pub unsafe fn flat<T: Element>(&self, values: &[T]) -> PyResult<Bound<'py, PyAny>> {
        let view = ArrayView1::from(values);
        // SAFETY: the owner keeps the memory, by the caller's promise.
        let array = unsafe { PyArray1::borrow_from_array(&view, self.owner.clone()) };
        frozen(array.into_any())
    }

    /// A read-only view (n, `n_columns`).
    ///
    /// # Safety
    /// As [`flat`](Self::flat).
    pub unsafe fn rows<T: Element>(
        &self,
        values: &[T],
        n_columns: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape = (values.len() / n_columns.max(1), n_columns);
        let view = ArrayView2::from_shape(shape, values).expect("whole rows");
        // SAFETY: the owner keeps the memory, by the caller's promise.
        let array = unsafe { PyArray2::borrow_from_array(&view, self.owner.clone()) };
        frozen(array.into_any())
    }

    /// A read-only view of an array of the mesh: (n,) or (n, components); a list of text.
    ///
    /// # Safety
    /// As [`flat`](Self::flat).
    pub unsafe fn values(&self, values: &Values, n: usize) -> PyResult<Bound<'py, PyAny>> {
        // SAFETY: by the caller's promise.
        unsafe {
            match values {
                Values::I8(values) => self.shaped(values, n),
                Values::U8(values) => self.shaped(values, n),
                Values::I16(values) => self.shaped(values, n),
                Values::U16(values) => self.shaped(values, n),
                Values::I32(values) => self.shaped(values, n),
                Values::U32(values) => self.shaped(values, n),
                Values::I64(values) => self.shaped(values, n),
                Values::U64(values) => self.shaped(values, n),
                Values::F32(values) => self.shaped(values, n),
                Values::F64(values) => self.shaped(values, n),
                Values::Text(values) => Ok(PyList::new(self.py, values)?.into_any()),
            }
        }
    }

    unsafe fn shaped<T: Element>(&self, values: &[T], n: usize) -> PyResult<Bound<'py, PyAny>> {
        // SAFETY: by the caller's promise.
        unsafe {
            match n {
                0 | 1 => self.flat(values),
                n => self.rows(values, n),
            }
        }
    }
}

/// The array, read-only.
pub fn frozen<'py>(array: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    array.cast::<PyUntypedArray>()?;
    array.getattr("flags")?.setattr("writeable", false)?;
    Ok(array)
}

/// Numbers handed over, (n,).
pub fn owned<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyAny> {
    PyArray1::from_vec(py, values).into_any()
}

/// Numbers handed over, (n, `n_columns`), without a copy.
pub fn owned_rows<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    n_columns: usize,
) -> PyResult<Bound<'_, PyAny>> {
    let n = values.len() / n_columns.max(1);
    Ok(PyArray1::from_vec(py, values)
        .reshape([n, n_columns])?
        .into_any())
}

/// Points or displacements handed over, (n, 3), without a copy.
pub fn vectors(py: Python<'_>, values: Vec<[f64; 3]>) -> PyResult<Bound<'_, PyAny>> {
    owned_rows(py, values.into_flattened(), 3)
}

/// Numbers of nodes and cells as numpy indexes with them.
pub fn indices(py: Python<'_>, values: impl IntoIterator<Item = usize>) -> Bound<'_, PyAny> {
    let values: Vec<i64> = values.into_iter().map(|index| index as i64).collect();
    owned(py, values)
}
