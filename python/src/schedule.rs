//! The class `Schedule`: from a file, or from a dict of the same keys.

use crate::arguments;
use crate::arrays::vectors;
use crate::error::{input, raised};
use azimesh::{Body, Error, Result, Schedule, Step};
use azimesh_core::error::Position;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use toml::{Table, Value};

/// Lists and dicts within one another, at most.
const DEEPEST: usize = 32;
/// Key of a body whose displacements come from a function.
const FUNCTION: &str = "displacements";

/// A motion schedule: which bodies move how at which steps, and how the mesh follows.
///
/// ``Schedule("pitch.toml")`` reads a file; ``Schedule({"azimuth": {...}, "body": [...]})`` takes the same keys as a dict. There a
/// body may also have ``"displacements": f``, a function ``f(moment, points)`` that gives the displacements (n, 3) of all its
/// nodes from their positions (n, 3) in the undeformed mesh, in mesh units, at a `Moment`.
#[pyclass(frozen, module = "azimesh", name = "Schedule")]
pub struct PySchedule {
    pub schedule: Schedule,
    /// The file it came from.
    pub file: Option<PathBuf>,
    /// The key at each line of a schedule that was a dict, as Python writes it: `schedule["body"][0]["name"]`.
    keys: Arc<[String]>,
    pub raised: Raised,
}

/// What a function of Python raised while the library called it, until somebody takes it.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    pub fn keep(&self, error: PyErr) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get_or_insert(error);
    }

    fn is_set(&self) -> bool {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.is_some()
    }
}

/// A step's place in the motion, for functions that give displacements: ``index``, ``azimuth_deg``, ``time_s``.
#[pyclass(frozen, get_all, module = "azimesh", name = "Moment")]
pub struct PyMoment {
    index: usize,
    azimuth_deg: Option<f64>,
    time_s: Option<f64>,
}

#[pymethods]
impl PySchedule {
    #[new]
    fn new(py: Python<'_>, source: &Bound<'_, PyAny>) -> PyResult<Self> {
        let found = match source.cast::<PyDict>() {
            Ok(keys) => Self::of_keys(keys),
            Err(_) => Self::of_file(py, source.extract()?),
        }?;
        let steps = found.schedule.steps();
        steps.map_err(|error| raised(py, &named(&found.keys, error)))?;
        Ok(found)
    }

    /// The file it came from; None for one made of a dict.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.file.clone()
    }

    /// Number of steps.
    #[getter]
    fn n_steps(&self) -> usize {
        self.schedule.steps().map_or(0, |steps| steps.len())
    }

    fn __repr__(&self) -> String {
        let from = match &self.file {
            Some(path) => format!(" of {}", path.display()),
            None => String::new(),
        };
        format!("<azimesh.Schedule{from}: {} steps>", self.n_steps())
    }
}

impl PySchedule {
    fn of_file(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let schedule = Schedule::read(&path).map_err(|error| raised(py, &error))?;
        Ok(Self {
            schedule,
            file: Some(path),
            keys: Arc::default(),
            raised: Raised::default(),
        })
    }

    fn of_keys(keys: &Bound<'_, PyDict>) -> PyResult<Self> {
        let py = keys.py();
        let mut functions = Vec::new();
        let mut table = as_table(keys, "", 0, &mut functions)?;
        table.entry("version").or_insert(Value::Integer(1));
        let text = toml::to_string(&table);
        let text = text.map_err(|error| input(py, format!("the schedule is no TOML: {error}")))?;
        let keys: Arc<[String]> = keys_of_lines(&text).into();
        let raised = Raised::default();
        let told = raised.clone();
        let complete = |name: &str, body: Body| match functions.iter().find(|(of, _)| of == name) {
            Some((_, function)) => moved_by(body, Arc::clone(function), told.clone()),
            None => body,
        };
        // The path of standard input, which has no folder: files are looked for in the working folder.
        let schedule = Schedule::parse_with(&text, Path::new("-"), &complete);
        Ok(Self {
            schedule: schedule.map_err(|error| crate::error::raised(py, &named(&keys, error)))?,
            file: None,
            keys,
            raised,
        })
    }

    /// Makes work name keys in its errors, not lines that no file has.
    pub fn naming<T>(
        &self,
        work: impl FnOnce() -> Result<T> + Send + 'static,
    ) -> impl FnOnce() -> Result<T> + Send + 'static {
        let keys = Arc::clone(&self.keys);
        move || work().map_err(|error| named(&keys, error))
    }
}

/// The key at each line of a TOML text without values of several lines.
fn keys_of_lines(text: &str) -> Vec<String> {
    let (mut table, mut n_of) = ("schedule".to_owned(), BTreeMap::<String, usize>::new());
    let of_line = |line: &str| {
        let Some(header) = line.strip_prefix('[') else {
            let key = line.split(" = ").next().unwrap_or_default();
            return format!("{table}[\"{}\"]", key.trim_matches('"'));
        };
        let name = header.trim_matches(['[', ']']);
        if header.starts_with('[') {
            n_of.retain(|of, _| !of.starts_with(&format!("{name}.")));
            *n_of.entry(name.to_owned()).or_default() += 1;
        }
        let (mut path, mut found) = (String::new(), "schedule".to_owned());
        for key in name.split('.') {
            path = format!("{path}.{key}").trim_start_matches('.').to_owned();
            found += &format!("[\"{key}\"]");
            found += &n_of
                .get(&path)
                .map_or_else(String::new, |n| format!("[{}]", n - 1));
        }
        table.clone_from(&found);
        found
    };
    text.lines().map(of_line).collect()
}

/// An error on a schedule of these keys, with its key in place of its line.
fn named(keys: &[String], error: Error) -> Error {
    if keys.is_empty() || error.path.as_deref() != Some(Path::new("-")) {
        return error;
    }
    let key = match error.position {
        Some(Position::Line(line)) => keys.get(line as usize - 1).cloned(),
        _ => None,
    };
    Error {
        path: None,
        position: Some(Position::Item(key.unwrap_or_else(|| "the schedule".into()))),
        ..error
    }
}

/// The body with displacements by `function(moment, points)`.
fn moved_by(body: Body, function: Arc<Py<PyAny>>, told: Raised) -> Body {
    body.displacements(move |step, points, displacements| {
        if told.is_set() {
            return;
        }
        let found = Python::try_attach(|py| called(py, &function, step, points));
        match found {
            Some(Ok(found)) => displacements.copy_from_slice(&found),
            Some(Err(error)) => told.keep(error),
            None => (),
        }
    })
}

fn called(
    py: Python<'_>,
    function: &Py<PyAny>,
    step: &Step,
    points: &[[f64; 3]],
) -> PyResult<Vec<[f64; 3]>> {
    let moment = PyMoment {
        index: step.index(),
        azimuth_deg: step.azimuth_deg(),
        time_s: step.time_s(),
    };
    let given = vectors(py, points.to_vec())?;
    let found = function.bind(py).call1((moment, given))?;
    let found = arguments::vectors(&found, "displacements")?;
    if found.len() != points.len() {
        let (n, wanted) = (found.len(), points.len());
        return Err(input(
            py,
            format!("the function gave {n} displacements for {wanted} nodes"),
        ));
    }
    Ok(found)
}

type Functions = Vec<(String, Arc<Py<PyAny>>)>;

/// The keys of a dict; functions of bodies are taken out.
fn as_table(
    keys: &Bound<'_, PyDict>,
    place: &str,
    depth: usize,
    functions: &mut Functions,
) -> PyResult<Table> {
    let mut table = Table::new();
    let mut function = None;
    for (key, value) in keys {
        let key = key.cast::<PyString>()?.to_string();
        if key == FUNCTION && value.is_callable() && place == "body" {
            function = Some(value.unbind());
            continue;
        }
        let value = as_value(&value, &key, depth + 1, functions)?;
        table.insert(key, value);
    }
    if let Some(function) = function {
        let name = table
            .get("name")
            .and_then(Value::as_str)
            .unwrap_or_default();
        functions.push((name.to_owned(), Arc::new(function)));
    }
    Ok(table)
}

fn as_value(
    value: &Bound<'_, PyAny>,
    key: &str,
    depth: usize,
    functions: &mut Functions,
) -> PyResult<Value> {
    if depth > DEEPEST {
        let message = format!(
            "the schedule's `{key}` has more than {DEEPEST} lists and dicts within one another; does one contain itself?"
        );
        return Err(input(value.py(), message));
    }
    if let Ok(keys) = value.cast::<PyDict>() {
        return Ok(Value::Table(as_table(keys, key, depth, functions)?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let elements = value.try_iter()?;
        let elements = elements.map(|element| as_value(&element?, key, depth + 1, functions));
        return Ok(Value::Array(elements.collect::<PyResult<_>>()?));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    // Arrays and numbers of numpy.
    if value.hasattr("tolist")? {
        return as_value(&value.call_method0("tolist")?, key, depth + 1, functions);
    }
    // Paths.
    if let Ok(path) = value.extract::<PathBuf>() {
        return Ok(Value::String(path.display().to_string()));
    }
    let found = value.get_type().name()?;
    Err(PyTypeError::new_err(format!(
        "the schedule's `{key}` is a {found}; it must be a number, text, a list or a dict"
    )))
}
