//! The [`Deformation`] of a mesh by a schedule: the public value with positions, velocities and quality.

mod follow;

use super::base::base_points::BasePoints;
use super::base::choose::{choose, from_nodes};
use super::base::tolerance::{BaseOrigin, check_tolerance};
use super::part::Part;
use super::plan::Plan;
use super::plan::checks::check_length;
use super::plan::layer::LayerKind;
use super::plan::prepare::leave_out_boxes;
use super::step::evaluator::StepEvaluator;
use super::step::measures::Measures;
use super::step::positions::{Positions, Stepper};
use super::step::repair::Repair;
use super::step::segment::Segment;
use super::step::step_memory::Rounding;
use super::whole::{ReadWhole, Whole};
use super::write::Nowhere;
use crate::motion::{OnInverted, QualityOutput, Schedule, Step};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::progress::{Progress, Silent, Stop};
use azimesh_io::mesh::{ByRanks, DataArray, Mesh, MeshView};
use azimesh_quality::{Assessment, Quality};
use azimesh_rbf::select::Selection;
use follow::Call;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// A mesh that deforms by a schedule: node positions, velocities and quality at every step.
///
/// Base points are selected once, and the fields of the motion are evaluated at every node once. A step then costs a
/// product of small matrices. With method `real` each selection interval is prepared when one of its steps is first needed,
/// and the last interval is kept.
///
/// Folded cells of a step are repaired together with the neighbouring steps, unless the schedule says otherwise
/// ([`OnInverted`](crate::OnInverted)). For that, the quality of nearby steps is evaluated too, each once. The result depends
/// only on the step, not on the order of calls.
///
/// It owns its data and may be shared between threads. It creates no file; on several ranks it writes nodes into an open one.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Cyclic, Deformation, Mesh, Schedule, Steps};
///
/// # fn main() -> azimesh::Result<()> {
/// let mesh = Mesh::read("testdata/naca0012.vtu")?;
/// let schedule = Schedule::new(Steps::azimuth_deg(0.0, 360.0, 90.0))
///     .body(Body::new("airfoil", ["airfoil"]).cyclic(Cyclic::new().pitch_deg(1, 5.0, 0.0)))
///     .fixed(["farfield"]);
/// let deformation = Deformation::new(mesh, schedule)?;
/// for step in deformation.steps() {
///     let points = deformation.points_at(step)?;
///     assert_eq!(points.len(), deformation.mesh().points().len());
///     assert_eq!(deformation.quality_of(&points)?.inverted, 0);
/// }
/// # Ok(())
/// # }
/// ```
pub struct Deformation {
    pub(super) plan: Arc<Plan>,
    /// The part of the mesh of this rank; on one rank, all of it.
    pub(super) part: Arc<Part>,
    whole: Whole,
    /// On the first of several ranks that write one file together: the kinds of all cells, the groups and the arrays.
    layout: Option<Mesh>,
    /// True if other ranks follow this one.
    pub(super) is_leading: bool,
    measures: OnceLock<Measures>,
    base: Option<BasePoints>,
    /// The interval entered last.
    current: Mutex<Option<Arc<StepEvaluator>>>,
    /// Held while an interval is entered, so that it is done once.
    entering: Mutex<()>,
    /// The steps by the runs that computed them: one segment, unless steps were added to a finished run.
    segments: Mutex<Vec<Arc<Segment>>>,
    progress: Arc<dyn Progress>,
    stop: Arc<Stop>,
}

/// Options of a [`Deformation`], from [`Deformation::builder`].
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Deformation, Mesh, Schedule, Steps, Translation};
///
/// let mesh = Mesh::read("testdata/naca0012.vtu")?;
/// let heave = Translation::new([0.0, 0.1, 0.0]);
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0]))
///     .body(Body::new("airfoil", ["airfoil"]).translate(heave))
///     .fixed(["farfield"]);
/// let first = Deformation::new(mesh.clone(), schedule.clone())?;
/// let builder = Deformation::builder(mesh, schedule).base_points(first.base_points());
/// let again = builder.build()?;
/// assert_eq!(again.base_points(), first.base_points());
/// # Ok::<(), azimesh::Error>(())
/// ```
pub struct DeformationBuilder {
    mesh: Arc<Mesh>,
    schedule: Schedule,
    base: Option<BasePoints>,
    progress: Arc<dyn Progress>,
    stop: Arc<Stop>,
    whole: Option<ReadWhole>,
    layout: Option<Mesh>,
}

/// A function that returns the base points of each layer of a plan for some steps, and their origin.
type Select<'a> = dyn FnMut(&Plan, &Range<usize>) -> Result<(BaseOrigin, Vec<Selection>)> + 'a;

impl DeformationBuilder {
    /// Uses these base points instead of choosing them.
    #[must_use]
    pub fn base_points(mut self, base: impl Into<BasePoints>) -> Self {
        self.base = Some(base.into());
        self
    }

    /// Reports progress to `progress`.
    #[must_use]
    pub fn progress(mut self, progress: Arc<dyn Progress>) -> Self {
        self.progress = progress;
        self
    }

    /// Ends work with an error of kind `Interrupted` once `stop` is requested.
    ///
    /// ```
    /// # use azimesh_deform as azimesh;
    /// use azimesh::{Deformation, ErrorKind, Mesh, Schedule, Stop};
    /// use std::path::Path;
    /// use std::sync::Arc;
    ///
    /// # fn main() -> azimesh::Result<()> {
    /// let stop = Arc::new(Stop::default());
    /// let mesh = Mesh::read("testdata/naca0012.vtu")?;
    /// let schedule = Schedule::read(Path::new("testdata/naca0012.toml"))?;
    /// let deformation = Deformation::builder(mesh, schedule).stop(stop.clone()).build()?;
    /// stop.ask(2); // usually from another thread, or from the handler of the signal with this number
    /// let error = deformation.points_at(&deformation.steps()[1]).err();
    /// assert_eq!(error.map(|error| error.kind), Some(ErrorKind::Interrupted { signal: 2 }));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn stop(mut self, stop: Arc<Stop>) -> Self {
        self.stop = stop;
        self
    }

    /// Makes the first of several ranks read the whole mesh by `read` when it is needed; each rank has a part. If all
    /// ranks write one file together, `layout` has the kinds of all cells, the groups and the arrays of the mesh.
    #[doc(hidden)]
    #[must_use]
    pub fn on_ranks(mut self, read: Option<ReadWhole>, layout: Option<Mesh>) -> Self {
        (self.whole, self.layout) = (read, layout);
        self
    }

    /// Checks mesh and schedule, chooses base points, and evaluates the motion at every node.
    ///
    /// # Errors
    /// Like [`Deformation::new`].
    pub fn build(self) -> Result<Deformation> {
        self.mesh.validate()?;
        let deformation = self.plan()?;
        if deformation.plan.selection_intervals().len() == 1 {
            deformation.interval(&deformation.plan.motion.steps[0])?;
        } else if deformation.base.is_some() {
            return Err(Error::input(
                "method = \"real\" chooses new base points along the schedule, so none can be given",
            ));
        }
        Ok(deformation)
    }

    /// Resolves the schedule on a valid mesh, as readers return it; base points are selected when they are needed.
    #[doc(hidden)]
    pub fn plan(self) -> Result<Deformation> {
        let (mut plan, part) = Plan::new(self.mesh, self.schedule)?;
        let mut layout = self.layout;
        if let Some(layout) = &mut layout {
            plan.without_boxes = leave_out_boxes(layout);
            for doubled in &part.doubled {
                doubled.apply_to_layout(layout);
            }
        }
        let segments = Mutex::new(Segment::all(plan.motion.steps.len(), &[], |_| false));
        Ok(Deformation {
            plan: Arc::new(plan),
            part: Arc::new(part),
            whole: Whole::new(self.whole),
            layout,
            is_leading: false,
            measures: OnceLock::new(),
            base: self.base,
            current: Mutex::new(None),
            entering: Mutex::new(()),
            segments,
            progress: self.progress,
            stop: self.stop,
        })
    }
}

impl Deformation {
    /// Checks mesh and schedule, chooses base points, and evaluates the motion at every node.
    ///
    /// # Errors
    /// Of kind `Input` if the mesh is invalid (an index out of range, a coordinate that is not finite) or the schedule does
    /// not fit it; of kind `Check` if no base points meet the tolerance.
    pub fn new(mesh: impl Into<Arc<Mesh>>, schedule: Schedule) -> Result<Self> {
        Self::builder(mesh, schedule).build()
    }

    /// Starts a deformation with options: given base points, progress, a stop request.
    /// [`build`](DeformationBuilder::build) completes it.
    pub fn builder(mesh: impl Into<Arc<Mesh>>, schedule: Schedule) -> DeformationBuilder {
        DeformationBuilder {
            mesh: mesh.into(),
            schedule,
            base: None,
            progress: Arc::new(Silent),
            stop: Arc::default(),
            whole: None,
            layout: None,
        }
    }

    /// The mesh before it deforms, in its final order: interface nodes of a turning zone are duplicated. On one of
    /// several ranks, its part of the mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.part.mesh
    }

    /// The steps of the schedule, at least one.
    pub fn steps(&self) -> &[Step] {
        &self.plan.motion.steps
    }

    /// Returns the positions (n, 3) of all nodes at a step, in mesh units, in the order of [`mesh`](Self::mesh).
    ///
    /// # Errors
    /// If the step is not one of this schedule, if an interval of method `real` misses the tolerance, and with
    /// `on_inverted = "stop"` if a cell is inverted.
    pub fn points_at(&self, step: &Step) -> Result<Vec<Vector>> {
        let mut points = vec![[0.0; 3]; self.part.mesh.points.len()];
        self.points_into(step, &mut points)?;
        Ok(points)
    }

    /// Writes the positions (n, 3) of all nodes at a step to `points`, in mesh units, in the order of
    /// [`mesh`](Self::mesh).
    ///
    /// # Errors
    /// Like [`points_at`](Self::points_at), and if `points` does not have the length of the mesh's nodes.
    pub fn points_into(&self, step: &Step, points: &mut [Vector]) -> Result<()> {
        self.check_length(points)?;
        self.check_step(step)?;
        self.stop.check()?;
        let interval = self.interval(step)?;
        let found = self.position(&interval, step, points)?;
        let stops = self.plan.schedule.output.on_inverted == OnInverted::Stop;
        match found.cells.filter(|cells| stops && cells.inverted > 0) {
            None => Ok(()),
            Some(cells) => Err(Error::check(format!(
                "{step} has {}, the first is cell {}",
                counted(cells.inverted, "inverted cell"),
                cells.inverted_cells.first().copied().unwrap_or_default()
            ))),
        }
    }

    /// Returns the velocities (n, 3) of all nodes at a step, in mesh units per second.
    ///
    /// # Errors
    /// Like [`points_at`](Self::points_at), and if the schedule does not ask for velocities.
    pub fn velocities_at(&self, step: &Step) -> Result<Vec<Vector>> {
        if self.plan.velocity.is_none() {
            return Err(Error::input(
                "the schedule has no velocities; set `velocity` before the deformation is made",
            ));
        }
        self.check_step(step)?;
        self.stop.check()?;
        let interval = self.interval(step)?;
        let mut points = vec![[0.0; 3]; self.part.mesh.points.len()];
        let found = self.position(&interval, step, &mut points)?;
        let segment = self.segment_of(step);
        let stepper = self.stepper(&interval, &segment, Rounding::None, self.repairs());
        let velocities = stepper.velocities(step, &found, &points)?;
        Ok(velocities.expect("the schedule asks for them"))
    }

    /// Evaluates the quality of the mesh with its nodes at `points`, relative to the mesh before it deforms.
    ///
    /// # Errors
    /// If `points` does not have the length of the mesh's nodes.
    pub fn quality_of(&self, points: &[Vector]) -> Result<Quality> {
        self.check_length(points)?;
        Ok(self.measures().quality(&self.part, points))
    }

    /// Returns the base points of the interval entered last; `None` before the first.
    pub fn base_points(&self) -> BasePoints {
        let current = self.current();
        let bases = current.as_ref().map(|interval| &interval.bases[..]);
        self.base_nodes(bases.unwrap_or_default())
    }

    /// Returns the base points of each layer, by mesh node.
    fn base_nodes(&self, bases: &[Vec<usize>]) -> BasePoints {
        let mut base = BasePoints::default();
        for (layer, points) in self.plan.layers.iter().zip(bases) {
            let nodes = points
                .iter()
                .map(|&at| self.plan.surface.nodes[at])
                .collect();
            match layer.kind {
                LayerKind::Displacement => base.nodes = nodes,
                LayerKind::Rotation(_) => base.rotation_nodes = Some(nodes),
            }
        }
        base
    }

    fn check_length(&self, points: &[Vector]) -> Result<()> {
        check_length("point", points.len(), self.part.mesh.points.len())
    }

    fn check_step(&self, step: &Step) -> Result<()> {
        match self.steps().get(step.index) {
            Some(own) if own == step => Ok(()),
            _ => Err(Error::input(format!(
                "{step} is not a step of this schedule, which has {}",
                counted(self.steps().len(), "step")
            ))),
        }
    }

    fn interval(&self, step: &Step) -> Result<Arc<StepEvaluator>> {
        self.enter(step, &*self.progress, &mut |plan, steps| {
            if let Some(base) = &self.base {
                let selections = from_nodes(plan, steps, base)?;
                return Ok((BaseOrigin::Given, selections));
            }
            let selections = self.choose(steps, &*self.progress)?;
            check_tolerance(plan, &selections, BaseOrigin::Chosen)?;
            Ok((BaseOrigin::Chosen, selections))
        })
    }
}

/// Functions for runs. On several ranks, all ranks call each of them.
impl Deformation {
    /// Returns the decisions made before base points are selected.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Returns the mesh to write: on the first of several ranks, or only its layout if all ranks write it together.
    ///
    /// # Errors
    /// If the first rank cannot read it.
    pub fn mesh_to_write(&self) -> Result<&Mesh> {
        match &self.layout {
            Some(layout) => Ok(layout),
            None => Ok(self.whole.mesh(&self.part)?),
        }
    }

    /// Returns a view of the mesh to write.
    ///
    /// # Errors
    /// Like [`mesh_to_write`](Self::mesh_to_write).
    pub fn view_to_write(&self) -> Result<MeshView<'_>> {
        let view = self.mesh_to_write()?.view();
        if self.layout.is_none() {
            return Ok(view);
        }
        Ok(view.by_ranks(ByRanks {
            by: &Nowhere,
            displacement: None,
            velocity: None,
        }))
    }

    /// Returns the reason why the first rank has read the whole mesh, if all ranks write it together.
    pub fn why_whole(&self) -> Option<String> {
        let is_read = self.layout.is_some() && self.whole.is_read();
        is_read.then(|| "folded cells are repaired".to_owned())
    }

    /// Returns whether all ranks write the mesh together.
    pub fn is_written_together(&self) -> bool {
        self.layout.is_some()
    }

    /// Returns quality measures of the reference mesh, computed on first use.
    pub(crate) fn measures(&self) -> &Measures {
        debug_assert!(
            !self.is_leading || self.measures.get().is_some(),
            "all ranks make them together"
        );
        let made = || Measures::new(&self.plan, &self.part.mesh);
        self.measures.get_or_init(made)
    }

    /// Computes the quality measures, if there are none yet.
    pub fn prepare_measures(&self) {
        if self.measures.get().is_none() {
            self.announce(Call::Measures);
            let made = Measures::new(&self.plan, &self.part.mesh);
            self.measures.get_or_init(|| made);
        }
    }

    /// Evaluates the mesh before it deforms.
    pub fn quality_at_rest(&self) -> Assessment {
        self.prepare_measures();
        self.announce(Call::AtRest);
        let (mesh, measures) = (&self.part.mesh, self.measures());
        let cells = measures.cells(mesh, &mesh.points);
        measures.complete(cells, mesh, &mesh.points)
    }

    /// Returns the quality measures if positions depend on them.
    fn repairs(&self) -> Option<&Measures> {
        let output = &self.plan.schedule.output;
        let repairs =
            output.quality != QualityOutput::None && output.on_inverted != OnInverted::Warn;
        repairs.then(|| self.measures())
    }

    /// Returns every metric as a cell array of the mesh that is written.
    pub fn cell_arrays(&self, points: &[Vector]) -> Result<Vec<DataArray>> {
        self.prepare_measures();
        let evaluator = self
            .whole
            .evaluator(&self.part, &self.measures().evaluator)?;
        Ok(evaluator.arrays(self.whole.mesh(&self.part)?, points))
    }

    /// Returns its stop request.
    pub fn stop(&self) -> &Arc<Stop> {
        &self.stop
    }

    /// Returns its progress reports.
    pub fn progress(&self) -> &dyn Progress {
        &*self.progress
    }

    /// Selects the base points of every layer for the steps of an interval.
    pub fn choose(&self, steps: &Range<usize>, progress: &dyn Progress) -> Result<Vec<Selection>> {
        self.announce(Call::Choose(steps.clone()));
        choose(&self.plan, steps, &self.part.ranks(), progress)
    }

    /// Returns the interval of a step; when the interval is entered, `select` gives its base points.
    pub fn enter(
        &self,
        step: &Step,
        progress: &dyn Progress,
        select: &mut Select<'_>,
    ) -> Result<Arc<StepEvaluator>> {
        let segment = self.segment_of(step);
        let plan = segment.plan(&self.plan)?;
        if segment.lacks_seam() {
            self.find_seam(&segment, progress, select)?;
        }
        let _entering = self.entering.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(interval) = &*self.current()
            && Arc::ptr_eq(&interval.plan, &plan)
            && interval.steps().contains(&step.index)
        {
            return Ok(Arc::clone(interval));
        }
        // Drops its fields before the next interval builds its own.
        self.leave();
        let mut intervals = plan.selection_intervals().into_iter();
        let steps = intervals.find(|steps| steps.contains(&step.index));
        let steps = steps.expect("every step is in an interval");
        let (origin, selections) = select(&plan, &steps)?;
        let bases: Vec<Vec<usize>> = selections.iter().map(|own| own.base.clone()).collect();
        let given = (origin != BaseOrigin::Chosen).then(|| self.base_nodes(&bases));
        self.announce(Call::Enter(step.index, given));
        let interval = StepEvaluator::new(&plan, &self.part, selections, &steps, progress)?;
        Ok(Arc::clone(self.current().insert(Arc::new(interval))))
    }

    /// Makes steps of earlier runs be computed as these runs did: they had these numbers of steps. `is_repaired` returns whether
    /// the repair of a step, the last of such a run, may have moved nodes.
    pub fn set_added(&self, added_after: &[usize], is_repaired: impl Fn(usize) -> bool) {
        let lock = || self.segments.lock().unwrap_or_else(PoisonError::into_inner);
        if added_after.is_empty() && lock().len() == 1 {
            return;
        }
        let repaired = added_after.iter().map(|n| n - 1);
        let repaired: Vec<usize> = repaired.filter(|step| is_repaired(*step)).collect();
        self.announce(Call::Added(added_after.to_vec(), repaired.clone()));
        let of_all = Segment::all(self.steps().len(), added_after, |step| {
            repaired.contains(&step)
        });
        *lock() = of_all;
        self.leave();
    }

    /// Returns the segment of a step.
    fn segment_of(&self, step: &Step) -> Arc<Segment> {
        let segments = self.segments.lock().unwrap_or_else(PoisonError::into_inner);
        let own = segments.iter().find(|own| own.steps.contains(&step.index));
        Arc::clone(own.expect("every step is in a segment"))
    }

    /// Finds the displacement by the repair of the last step before a segment.
    fn find_seam(
        &self,
        segment: &Segment,
        progress: &dyn Progress,
        select: &mut Select<'_>,
    ) -> Result<()> {
        if !self.plan.has_quality() || self.plan.schedule.output.on_inverted != OnInverted::Repair {
            segment.set_seam(None);
            return Ok(());
        }
        let before = &self.steps()[segment.steps.start - 1];
        let interval = self.enter(before, progress, select)?;
        self.prepare_measures();
        self.announce(Call::Seam(before.index));
        self.join(&interval, before)
    }

    /// Lets the segment after a step, its last, begin at the positions of that.
    fn join(&self, interval: &StepEvaluator, last: &Step) -> Result<()> {
        let rounding = match self.plan.schedule.output.rounds()? {
            true => Rounding::Single,
            false => Rounding::None,
        };
        let segment = self.segment_of(last);
        let stepper = self.stepper(interval, &segment, rounding, self.repairs());
        let added = stepper.added(last)?;
        self.segment_of(&self.steps()[last.index + 1])
            .set_seam(added);
        Ok(())
    }

    /// Drops the interval entered last.
    pub(super) fn leave(&self) {
        *self.current() = None;
    }

    fn current(&self) -> MutexGuard<'_, Option<Arc<StepEvaluator>>> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stepper<'a>(
        &'a self,
        interval: &'a StepEvaluator,
        segment: &'a Segment,
        rounding: Rounding,
        measures: Option<&'a Measures>,
    ) -> Stepper<'a> {
        Stepper {
            plan: &interval.plan,
            part: &self.part,
            whole: &self.whole,
            interval,
            segment,
            measures,
            memory: segment.memory(rounding),
            rounding,
            improve: self.plan.schedule.output.improve,
            stop: &self.stop,
            progress: &*self.progress,
        }
    }

    /// Computes positions of a step, with folded cells repaired.
    fn position(
        &self,
        interval: &StepEvaluator,
        step: &Step,
        points: &mut [Vector],
    ) -> Result<Positions> {
        let segment = self.segment_of(step);
        let stepper = self.stepper(interval, &segment, Rounding::None, self.repairs());
        stepper.at(step, points)
    }

    /// Writes the positions of the nodes at a step to `points`, without a repair; returns the velocities.
    pub fn place(
        &self,
        interval: &StepEvaluator,
        step: &Step,
        rounding: Rounding,
        points: &mut [Vector],
    ) -> Result<Evaluated> {
        self.announce(Call::Place(step.index, rounding));
        let segment = self.segment_of(step);
        let stepper = self.stepper(interval, &segment, rounding, None);
        stepper.plain(step, points)?;
        Ok(Evaluated {
            velocities: interval.velocities_at(step, points),
            ..Evaluated::default()
        })
    }

    /// Evaluates a step, without its cell arrays; writes positions to `points`.
    pub fn evaluate(
        &self,
        interval: &StepEvaluator,
        step: &Step,
        rounding: Rounding,
        points: &mut [Vector],
    ) -> Result<Evaluated> {
        self.announce(Call::Evaluate(step.index, rounding));
        let (plan, mesh) = (&self.plan, &self.part.mesh);
        let measures = plan.has_quality().then(|| self.measures());
        let segment = self.segment_of(step);
        let stepper = self.stepper(interval, &segment, rounding, measures);
        let found = stepper.at(step, points)?;
        let velocities = stepper.velocities(step, &found, points)?;
        Ok(Evaluated {
            quality: measures
                .zip(found.cells)
                .map(|(by, cells)| by.complete(cells, mesh, points)),
            normal_change: measures.and_then(|by| by.normal_change(mesh, points)),
            first_cell_ratio: self.part.first_cells.smallest_ratio(mesh, points),
            selection_error: found.selection_error,
            surface_error: interval.surface_error(step, points),
            largest_displacement: plan.largest_displacement(step.index),
            velocities,
            n_base: interval.n_base,
            repair: found.repair,
        })
    }
}

/// The results of a step except its positions.
#[derive(Default)]
pub struct Evaluated {
    /// If the schedule asks for quality.
    pub quality: Option<Assessment>,
    /// Largest change of the angle between a moving wall and its first cell, in degrees.
    pub normal_change: Option<f64>,
    /// Smallest ratio of a first-cell height to its height in the reference mesh.
    pub first_cell_ratio: Option<f64>,
    /// Largest displacement error before the correction.
    pub selection_error: f64,
    /// Largest and root-mean-square distance of surface nodes from their prescribed positions.
    pub surface_error: (f64, f64),
    /// Largest prescribed displacement.
    pub largest_displacement: f64,
    /// If the schedule asks for velocities.
    pub velocities: Option<Vec<Vector>>,
    /// Number of distinct base points.
    pub n_base: usize,
    /// The repair of folded cells, if there was one.
    pub repair: Option<Repair>,
}

impl Evaluated {
    /// Returns the first inverted cell, if there is one.
    pub fn first_inverted(&self) -> Option<usize> {
        let cells = self.quality.as_ref().map(|quality| &quality.cells);
        let inverted = cells.filter(|cells| cells.inverted > 0);
        inverted.map(|cells| cells.inverted_cells.first().copied().unwrap_or_default())
    }
}
