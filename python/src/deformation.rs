//! The classes `Deformation` and `Step`.

use crate::arguments;
use crate::arrays::{frozen, indices, vectors};
use crate::background::{Ending, done};
use crate::error::{input, raised};
use crate::mesh::PyMesh;
use crate::progress::Told;
use crate::quality::summary_of;
use crate::schedule::PySchedule;
use azimesh::record::Criterion;
use azimesh::run::{Finished, Request, run};
use azimesh::{BasePoints, Error, Mesh, Result, Schedule, Stop};
use azimesh_deform::Deformation;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyIterator, PyList};
use std::cell::Cell;
use std::path::PathBuf;
use std::sync::Arc;

/// A mesh that deforms by a schedule: ``Deformation(mesh, schedule, *, base_points, rotation_base_points, progress)``.
///
/// Base points are chosen once, unless numbers of nodes are given. Iterating gives a `Step` each, with its points,
/// velocities and quality. `progress` is True for a bar, or a function ``(stage, done, total)``; Ctrl-C ends the work.
/// Raises `Error` where ``azimesh deform`` exits with 1 or 2.
#[pyclass(frozen, weakref, module = "azimesh", name = "Deformation")]
pub struct PyDeformation {
    work: Work,
    deformation: Arc<Deformation>,
    /// The mesh as it was given, with its file and the further files that were read for it.
    given: (Arc<Mesh>, Option<PathBuf>, Vec<PathBuf>),
    has_base: bool,
}

/// The function that is told of the work; a bar for True.
fn as_function(py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Option<Py<PyAny>>> {
    let made = py.import("azimesh._progress")?;
    let made = made.call_method1("as_function", (progress,))?;
    Ok((!made.is_none()).then(|| made.unbind()))
}

/// What every call of a deformation needs.
#[derive(Clone)]
struct Work {
    schedule: Arc<Py<PySchedule>>,
    stop: Arc<Stop>,
    told: Option<Arc<Told>>,
}

impl Work {
    /// Does `work` beside the interpreter. What a function of Python raised counts before its result.
    fn done<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce() -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        self.ended(py, true, work)
    }

    /// Does `work`; a signal makes it end, and if `wait` holds it is waited for.
    fn ended<T: Send + 'static>(
        &self,
        py: Python<'_>,
        wait: bool,
        work: impl FnOnce() -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        // Nobody has asked for this call to end.
        self.stop.ask(0);
        self.schedule.get().raised.take();
        let work = self.schedule.get().naming(work);
        let is_abandoned = Cell::new(false);
        let ending = Ending {
            stop: &self.stop,
            report: &|error| {
                is_abandoned.set(!wait);
                // Functions of Python are not called any more.
                self.schedule.get().raised.keep(error);
            },
            wait,
        };
        let result = done(py, Some(ending), work);
        if is_abandoned.get() {
            return result;
        }
        let by_progress = self.told.as_ref().and_then(|told| told.take_raised());
        let by_motion = self.schedule.get().raised.take();
        match by_progress.or(by_motion) {
            Some(error) => Err(error),
            None => result,
        }
    }

    fn schedule(&self) -> Schedule {
        self.schedule.get().schedule.clone()
    }

    fn builder(&self, mesh: Arc<Mesh>, schedule: Schedule) -> azimesh::DeformationBuilder {
        let builder = Deformation::builder(mesh, schedule).stop(Arc::clone(&self.stop));
        match &self.told {
            Some(told) => builder.progress(Arc::clone(told) as Arc<dyn azimesh::Progress>),
            None => builder,
        }
    }
}

#[pymethods]
impl PyDeformation {
    #[new]
    #[pyo3(signature = (mesh, schedule, *, base_points=None, rotation_base_points=None, progress=None))]
    fn new(
        py: Python<'_>,
        mesh: &PyMesh,
        schedule: Py<PySchedule>,
        base_points: Option<&Bound<'_, PyAny>>,
        rotation_base_points: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let stop = Arc::new(Stop::default());
        let progress = as_function(py, progress)?;
        let told = progress.map(|function| Arc::new(Told::new(function, Arc::clone(&stop))));
        let work = Work {
            schedule: Arc::new(schedule),
            stop,
            told,
        };
        let mut builder = work.builder(Arc::clone(&mesh.mesh), work.schedule());
        let has_base = base_points.is_some();
        if let Some(nodes) = base_points {
            let of_rotation =
                |nodes: &Bound<'_, PyAny>| arguments::indices(nodes, "rotation base points");
            builder = builder.base_points(BasePoints {
                nodes: arguments::indices(nodes, "base points")?,
                rotation_nodes: rotation_base_points.map(of_rotation).transpose()?,
            });
        }
        // Nothing is written, so a signal need not wait.
        let deformation = work.ended(py, false, move || builder.build())?;
        Ok(Self {
            work,
            deformation: Arc::new(deformation),
            given: (
                Arc::clone(&mesh.mesh),
                mesh.path.clone(),
                mesh.files.clone(),
            ),
            has_base,
        })
    }

    /// The mesh before it deforms, in its final order: where a zone turns, nodes of its interface are there twice.
    #[getter]
    fn mesh(&self) -> PyMesh {
        PyMesh::new(Arc::clone(self.deformation.mesh()))
    }

    /// The steps of the schedule. Each keeps its points as long as it lives; iterating over the deformation keeps none.
    #[getter]
    fn steps<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyList>> {
        let n = slf.get().deformation.steps().len();
        let steps = (0..n).map(|index| PyStep::new(slf, index));
        PyList::new(slf.py(), steps)
    }

    fn __len__(&self) -> usize {
        self.deformation.steps().len()
    }

    fn __getitem__(slf: &Bound<'_, Self>, index: isize) -> PyResult<PyStep> {
        let n = slf.get().deformation.steps().len();
        let from_start = if index < 0 { index + n as isize } else { index };
        match usize::try_from(from_start) {
            Ok(found) if found < n => Ok(PyStep::new(slf, found)),
            _ => Err(PyIndexError::new_err(format!("step {index} of {n}"))),
        }
    }

    /// Makes each step when it is asked for, so that the points of one that is dropped are freed.
    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let builtins = slf.py().import("builtins")?;
        let numbers = builtins.call_method1("range", (slf.get().__len__(),))?;
        let step = slf.getattr("__getitem__")?;
        builtins.call_method1("map", (step, numbers))?.try_iter()
    }

    /// Numbers of the nodes that are base points; with twist those of the translation.
    #[getter]
    fn base_points<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let base = self.deformation.base_points().nodes;
        indices(py, base.into_iter().map(|node| node as usize))
    }

    /// With twist, numbers of the nodes that are base points of the rotation; else None.
    #[getter]
    fn rotation_base_points<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        let base = self.deformation.base_points().rotation_nodes?;
        Some(indices(py, base.into_iter().map(|node| node as usize)))
    }

    /// Writes what ``azimesh deform`` leaves in `folder`, byte for byte; gives what it came to.
    ///
    /// `format` replaces that of the schedule; `steps` is (first, end), counted from 0, for a part; the other options are those of
    /// the command. Raises `Error` of kind ``check`` where the command exits with 1, after the files are written.
    #[pyo3(signature = (folder, *, format=None, steps=None, force=false, resume=false, keep_going=false, allow_outside=false, no_sync=false, fail_on=Vec::new()))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn write<'py>(
        &self,
        py: Python<'py>,
        folder: PathBuf,
        format: Option<String>,
        steps: Option<(usize, usize)>,
        force: bool,
        resume: bool,
        keep_going: bool,
        allow_outside: bool,
        no_sync: bool,
        fail_on: Vec<String>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (mesh, path, files) = self.given.clone();
        let in_memory = path.is_none() || self.work.schedule.get().file.is_none();
        if resume && in_memory {
            return Err(input(
                py,
                "a run of a mesh or a schedule that was made in memory cannot be resumed; write them to files",
            ));
        }
        if self.has_base {
            return Err(input(
                py,
                "base points that were given cannot be written with a run; save them with `azimesh select`",
            ));
        }
        let conditions = fail_on.iter().map(|text| text.parse::<Criterion>());
        let conditions = conditions.collect::<std::result::Result<Vec<_>, _>>();
        let request = Request {
            mesh: path.unwrap_or_else(|| PathBuf::from("-")),
            files,
            folder,
            steps: steps.map(|(start, end)| start..end),
            force,
            resume,
            keep_going,
            allow_outside,
            no_sync,
            fail_on: conditions.map_err(|error| input(py, error.to_string()))?,
            ..Request::default()
        };
        let mut schedule = self.work.schedule();
        if let Some(format) = format {
            schedule = schedule.format(format);
        }
        let builder = self.work.builder(mesh, schedule);
        let finished = self
            .work
            .done(py, move || run(&builder.plan()?, &request))?;
        told(py, finished)
    }

    fn __repr__(&self) -> String {
        format!(
            "<azimesh.Deformation: {} points, {} steps, {} base points>",
            self.deformation.mesh().points().len(),
            self.deformation.steps().len(),
            self.deformation.base_points().nodes.len()
        )
    }
}

/// What a run came to, as `deform --json` has it; raises where a check failed.
fn told(py: Python<'_>, finished: Finished) -> PyResult<Bound<'_, PyDict>> {
    if let Some(error) = &finished.ended_by {
        return Err(raised(py, error));
    }
    if finished.is_failed() {
        let all = [&finished.inverted, &finished.failures, &finished.skipped];
        let all: Vec<String> = all.into_iter().flatten().map(ToString::to_string).collect();
        return Err(raised(py, &Error::check(all.join("; "))));
    }
    let found = PyDict::new(py);
    found.set_item("outcome", finished.outcome)?;
    found.set_item("steps_written", finished.n_steps)?;
    found.set_item("steps_kept", finished.n_kept)?;
    found.set_item("base_points", finished.n_base)?;
    found.set_item("selection_error", finished.selection_error)?;
    found.set_item("max_surface_error", finished.surface_error)?;
    found.set_item("inverted_steps", finished.inverted_steps)?;
    found.set_item("min_scaled_jacobian", finished.min_scaled_jacobian)?;
    let warnings: Vec<String> = finished.warnings.iter().map(ToString::to_string).collect();
    found.set_item("warnings", warnings)?;
    Ok(found)
}

/// A step of a deformation. Positions are computed when they are first asked for, and kept.
#[pyclass(frozen, module = "azimesh", name = "Step")]
pub struct PyStep {
    of: Py<PyDeformation>,
    #[pyo3(get)]
    index: usize,
    points: PyOnceLock<Py<PyAny>>,
}

impl PyStep {
    fn new(of: &Bound<'_, PyDeformation>, index: usize) -> Self {
        Self {
            of: of.clone().unbind(),
            index,
            points: PyOnceLock::new(),
        }
    }

    /// Asks the deformation about this step.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        question: impl FnOnce(&Deformation, &azimesh::Step) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let of = self.of.get();
        let (deformation, index) = (Arc::clone(&of.deformation), self.index);
        of.work.done(py, move || {
            question(&deformation, &deformation.steps()[index])
        })
    }
}

#[pymethods]
impl PyStep {
    /// Azimuth in degrees, where the schedule has one.
    #[getter]
    fn azimuth_deg(&self) -> Option<f64> {
        self.of.get().deformation.steps()[self.index].azimuth_deg()
    }

    /// Time in seconds, where the schedule has one.
    #[getter]
    fn time_s(&self) -> Option<f64> {
        self.of.get().deformation.steps()[self.index].time_s()
    }

    /// Positions (n, 3) of all nodes, read-only, in mesh units; computed when first asked for, and kept.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if let Some(known) = self.points.get(py) {
            return Ok(known.bind(py).clone());
        }
        let points = self.ask(py, Deformation::points_at)?;
        let points = frozen(vectors(py, points)?)?;
        Ok(self
            .points
            .get_or_init(py, || points.unbind())
            .bind(py)
            .clone())
    }

    /// Velocities (n, 3) of all nodes, in mesh units a second; the schedule must ask for them (``output.velocity``).
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, self.ask(py, Deformation::velocities_at)?)
    }

    /// Quality of the mesh at this step, relative to the mesh before it deforms: the numbers of a row of steps.csv.
    #[getter]
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let points = arguments::vectors(&self.points(py)?, "points")?;
        let found = self.ask(py, move |deformation, _| deformation.quality_of(&points))?;
        summary_of(py, &found)
    }

    fn __repr__(&self) -> String {
        format!(
            "<azimesh.Step: {}>",
            self.of.get().deformation.steps()[self.index]
        )
    }
}
