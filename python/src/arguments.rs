//! What callers hand over: anything numpy takes for an array, checked and copied into Rust's vectors.

use crate::error::input;
use azimesh::Values;
use numpy::{
    PyArray1, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Finite or not, numbers of shape (n, 3).
pub fn vectors(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[f64; 3]>> {
    let py = given.py();
    let array = as_array(given, Some("float64"), what)?;
    let shape = array.shape().to_vec();
    let [_, 3] = shape[..] else {
        let message = format!(
            "{what} have the shape {}; it must be (n, 3)",
            shape_text(&shape)
        );
        return Err(input(py, message));
    };
    let array = array.into_any().cast_into::<PyArray2<f64>>()?.readonly();
    Ok(array.as_slice()?.as_chunks::<3>().0.to_vec())
}

/// Numbers of nodes or cells: integers of shape (n,), from 0.
pub fn indices(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<u32>> {
    integers(given, what)?
        .into_iter()
        .map(|value| narrow(given.py(), value, what))
        .collect()
}

/// Numbers of nodes as rows of a table, (n, columns); the columns too.
pub fn table(given: &Bound<'_, PyAny>, what: &str) -> PyResult<(Vec<u32>, usize)> {
    let py = given.py();
    let array = as_array(given, None, what)?;
    let shape = array.shape().to_vec();
    let [_, n_columns] = shape[..] else {
        let message = format!(
            "{what} have the shape {}; it must be (cells, nodes)",
            shape_text(&shape)
        );
        return Err(input(py, message));
    };
    let flat = array.call_method1("reshape", (-1,))?;
    Ok((indices(&flat, what)?, n_columns))
}

/// An array of any number type, or of text, with its number of components.
pub fn values(given: &Bound<'_, PyAny>, what: &str) -> PyResult<(Values, usize)> {
    let py = given.py();
    let array = as_array(given, None, what)?;
    let n_components = match array.shape() {
        [_] => 1,
        [_, n] => *n,
        shape => {
            let shape = shape_text(shape);
            return Err(input(
                py,
                format!("{what} has the shape {shape}; it must be (n,) or (n, k)"),
            ));
        }
    };
    let flat = array.call_method1("reshape", (-1,))?;
    let name: String = array.dtype().getattr("name")?.extract()?;
    let values = match (array.dtype().kind(), name.as_str()) {
        (b'b', _) => Values::U8(of_type(&flat, "uint8")?),
        (_, "int8") => Values::I8(of_type(&flat, "int8")?),
        (_, "uint8") => Values::U8(of_type(&flat, "uint8")?),
        (_, "int16") => Values::I16(of_type(&flat, "int16")?),
        (_, "uint16") => Values::U16(of_type(&flat, "uint16")?),
        (_, "int32") => Values::I32(of_type(&flat, "int32")?),
        (_, "uint32") => Values::U32(of_type(&flat, "uint32")?),
        (_, "int64") => Values::I64(of_type(&flat, "int64")?),
        (_, "uint64") => Values::U64(of_type(&flat, "uint64")?),
        (_, "float16" | "float32") => Values::F32(of_type(&flat, "float32")?),
        (_, "float64") => Values::F64(of_type(&flat, "float64")?),
        (b'U', _) => Values::Text(flat.call_method0("tolist")?.extract()?),
        _ => {
            let message =
                format!("{what} is an array of {name}; it must hold real numbers or text");
            return Err(PyTypeError::new_err(message));
        }
    };
    Ok((values, n_components))
}

fn of_type<T: numpy::Element>(flat: &Bound<'_, PyAny>, dtype: &str) -> PyResult<Vec<T>> {
    let array = flat.call_method1("astype", (dtype,))?;
    let array = array.cast_into::<PyArray1<T>>()?.readonly();
    Ok(array.to_vec()?)
}

fn integers(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<i64>> {
    let py = given.py();
    let array = as_array(given, None, what)?;
    let [n] = array.shape()[..] else {
        let shape = shape_text(array.shape());
        return Err(input(
            py,
            format!("{what} have the shape {shape}; it must be (n,)"),
        ));
    };
    // An empty list is one of floats to numpy.
    if n > 0 && !matches!(array.dtype().kind(), b'i' | b'u') {
        let name: String = array.dtype().getattr("name")?.extract()?;
        return Err(PyTypeError::new_err(format!(
            "{what} are {name}; they must be integers"
        )));
    }
    of_type(array.as_any(), "int64")
}

fn narrow(py: Python<'_>, value: i64, what: &str) -> PyResult<u32> {
    u32::try_from(value).map_err(|_| {
        input(
            py,
            format!(
                "{what} have {value}; numbers are from 0 to {}",
                u32::MAX - 1
            ),
        )
    })
}

/// The argument as a contiguous array of numpy.
fn as_array<'py>(
    given: &Bound<'py, PyAny>,
    dtype: Option<&str>,
    what: &str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = given.py();
    let numpy = py.import("numpy")?;
    let options = PyDict::new(py);
    if let Some(dtype) = dtype {
        let found = numpy.call_method1("asarray", (given,))?;
        let kind: String = found.getattr("dtype")?.getattr("kind")?.extract()?;
        if !matches!(kind.as_str(), "i" | "u" | "f" | "b") {
            return Err(PyTypeError::new_err(format!("{what} must be real numbers")));
        }
        options.set_item("dtype", dtype)?;
    }
    let array = numpy.call_method("ascontiguousarray", (given,), Some(&options))?;
    Ok(array.cast_into::<PyUntypedArray>()?)
}

fn shape_text(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
    match &sizes[..] {
        [one] => format!("({one},)"),
        _ => format!("({})", sizes.join(", ")),
    }
}
