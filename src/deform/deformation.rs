//! The [`Deformation`] of a mesh by a schedule: the public value with positions, velocities and quality.

use super::base_points::BasePoints;
use super::checks::check_length;
use super::choose::{choose, from_nodes};
use super::interval::Interval;
use super::layer::LayerKind;
use super::measures::Measures;
use super::plan::Plan;
use super::positions::{Positions, Stepper};
use super::repair::Repair;
use super::sharing::Sharing;
use super::step_memory::{Rounding, StepMemory};
use super::team::Team;
use super::tolerance::{BaseOrigin, check_tolerance};
use crate::error::{Error, Result, counted};
use crate::geometry::vector::Vector;
use crate::mesh::{Apart, Mesh};
use crate::motion::{OnInverted, QualityOutput, Schedule, Step};
use crate::progress::{Progress, Silent, Stop};
use crate::quality::{Assessment, Quality};
use crate::rbf::select::Selection;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A mesh that deforms by a schedule: node positions, velocities and quality at every step.
///
/// Base points are chosen once, and the fields of the motion are evaluated at every node once; a step
/// then costs a product of small matrices. With method `real` each selection interval does that when a
/// step of it is first needed, and the last interval is kept.
///
/// Where cells of a step are folded, it is repaired with the steps around it, unless the schedule says otherwise
/// ([`OnInverted`](crate::OnInverted)). For that, steps near the one that is asked for are judged too, each once. What comes out depends on the step
/// alone, not on the order in which steps are asked for.
///
/// It owns what it needs and may be shared between threads. It writes no file.
///
/// ```
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
    plan: Arc<Plan>,
    measures: OnceLock<Measures>,
    base: Option<BasePoints>,
    /// The interval that was entered last.
    current: Mutex<Option<Arc<Interval>>>,
    /// What is known of the steps, without rounding of coordinates and with it.
    known: [StepMemory; 2],
    /// The nodes whose positions are wanted here, once others stay with their ranks; none where all are.
    divided: OnceLock<Option<Vec<u32>>>,
    progress: Arc<dyn Progress>,
    stop: Arc<Stop>,
}

/// Options of a [`Deformation`], from [`Deformation::builder`].
///
/// ```
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
    team: Option<Arc<Team>>,
}

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
    #[must_use]
    pub fn stop(mut self, stop: Arc<Stop>) -> Self {
        self.stop = stop;
        self
    }

    /// Shares the work with other ranks, which serve this one, the first.
    #[doc(hidden)]
    #[must_use]
    pub fn team(mut self, team: Option<Arc<Team>>) -> Self {
        self.team = team;
        self
    }

    /// Checks mesh and schedule, chooses base points, and evaluates the motion at every node.
    ///
    /// # Errors
    /// As [`Deformation::new`].
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

    /// Resolves the schedule on a mesh that is valid, as readers give it; base points are chosen when they
    /// are needed.
    #[doc(hidden)]
    pub fn plan(self) -> Result<Deformation> {
        let sharing = self.team.map_or(Sharing::Alone, Sharing::Ranks);
        let plan = Plan::with(self.mesh, self.schedule, sharing)?;
        Ok(Deformation {
            plan: Arc::new(plan),
            measures: OnceLock::new(),
            base: self.base,
            current: Mutex::new(None),
            known: Default::default(),
            divided: OnceLock::new(),
            progress: self.progress,
            stop: self.stop,
        })
    }
}

impl Deformation {
    /// Checks mesh and schedule, chooses base points, and evaluates the motion at every node.
    ///
    /// # Errors
    /// Of kind `Input` where the mesh is none (an index out of range, a coordinate that is no number) or
    /// the schedule does not fit it; of kind `Check` where no base points meet the tolerance.
    pub fn new(mesh: impl Into<Arc<Mesh>>, schedule: Schedule) -> Result<Self> {
        Self::builder(mesh, schedule).build()
    }

    /// A deformation with options: given base points, a progress, a stop. [`build`](DeformationBuilder::build)
    /// makes it.
    pub fn builder(mesh: impl Into<Arc<Mesh>>, schedule: Schedule) -> DeformationBuilder {
        DeformationBuilder {
            mesh: mesh.into(),
            schedule,
            base: None,
            progress: Arc::new(Silent),
            stop: Arc::default(),
            team: None,
        }
    }

    /// The mesh before it deforms, in its final order: where a zone turns, nodes of its interface are
    /// there twice.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.plan.mesh
    }

    /// The steps of the schedule, at least one.
    pub fn steps(&self) -> &[Step] {
        &self.plan.motion.steps
    }

    /// The positions (n, 3) of all nodes at a step, in mesh units, in the order of [`mesh`](Self::mesh).
    ///
    /// # Errors
    /// Where the step is none of this schedule, where an interval of method `real` misses the
    /// tolerance, and with `on_inverted = "stop"` where a cell is inverted.
    pub fn points_at(&self, step: &Step) -> Result<Vec<Vector>> {
        let mut points = vec![[0.0; 3]; self.plan.mesh.points.len()];
        self.points_into(step, &mut points)?;
        Ok(points)
    }

    /// Writes the positions (n, 3) of all nodes at a step to `points`, in mesh units, in the order of
    /// [`mesh`](Self::mesh).
    ///
    /// # Errors
    /// As [`points_at`](Self::points_at), and where `points` has another length than the mesh has nodes.
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

    /// The velocities (n, 3) of all nodes at a step, in mesh units a second.
    ///
    /// # Errors
    /// As [`points_at`](Self::points_at), and where the schedule does not ask for velocities.
    pub fn velocities_at(&self, step: &Step) -> Result<Vec<Vector>> {
        if self.plan.velocity.is_none() {
            return Err(Error::input(
                "the schedule has no velocities; set `velocity` before the deformation is made",
            ));
        }
        self.check_step(step)?;
        self.stop.check()?;
        let interval = self.interval(step)?;
        let mut points = vec![[0.0; 3]; self.plan.mesh.points.len()];
        let found = self.position(&interval, step, &mut points)?;
        let measures = || self.measures();
        let stepper = self.stepper(&interval, (Rounding::None, None), &measures);
        let velocities = stepper.velocities(step, &found, &points)?;
        Ok(velocities.expect("the schedule asks for them"))
    }

    /// The quality of the mesh with its nodes at `points`, relative to the mesh before it deforms.
    ///
    /// # Errors
    /// Where `points` has another length than the mesh has nodes.
    pub fn quality_of(&self, points: &[Vector]) -> Result<Quality> {
        self.check_length(points)?;
        Ok(self.measures().quality(&self.plan, points))
    }

    /// The base points of the interval that was entered last; none before the first.
    pub fn base_points(&self) -> BasePoints {
        let current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        let mut base = BasePoints::default();
        let Some(interval) = &*current else {
            return base;
        };
        for (layer, points) in self.plan.layers.iter().zip(&interval.bases) {
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
        check_length("point", points.len(), self.plan.mesh.points.len())
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

    fn interval(&self, step: &Step) -> Result<Arc<Interval>> {
        self.enter(step, &*self.progress, &mut |steps| {
            if let Some(base) = &self.base {
                return from_nodes(&self.plan, steps, base);
            }
            let selections = choose(&self.plan, steps, &*self.progress)?;
            check_tolerance(&self.plan, &selections, BaseOrigin::Chosen)?;
            Ok(selections)
        })
    }
}

/// What rooms above need beyond the public methods.
impl Deformation {
    /// Everything that was decided before base points are chosen.
    pub(crate) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Why the first rank has cut the mesh into parts for the others, where it has.
    #[doc(hidden)]
    pub fn why_cut(&self) -> Option<String> {
        self.plan.team()?.why_cut()
    }

    /// Why the first rank has read the whole mesh, where the outline was not enough.
    pub(crate) fn why_whole(&self) -> Option<&'static str> {
        self.plan.whole.get().map(|whole| whole.1)
    }

    /// Quality measures of the reference mesh, made on first use.
    pub(crate) fn measures(&self) -> &Measures {
        self.measures.get_or_init(|| Measures::new(&self.plan))
    }

    /// Its stop request.
    pub(crate) fn stop(&self) -> &Arc<Stop> {
        &self.stop
    }

    /// Its progress reports.
    pub(crate) fn progress(&self) -> &dyn Progress {
        &*self.progress
    }

    /// The interval of a step, with base points by `select` where it is entered.
    pub(crate) fn enter(
        &self,
        step: &Step,
        progress: &dyn Progress,
        select: &mut dyn FnMut(&Range<usize>) -> Result<Vec<Selection>>,
    ) -> Result<Arc<Interval>> {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(interval) = &*current
            && interval.steps().contains(&step.index)
        {
            return Ok(Arc::clone(interval));
        }
        // Its fields go before those of the next are made.
        *current = None;
        let mut intervals = self.plan.selection_intervals().into_iter();
        let steps = intervals.find(|steps| steps.contains(&step.index));
        let steps = steps.expect("every step is in an interval");
        let selections = select(&steps)?;
        let interval = Interval::new(&self.plan, selections, &steps, progress)?;
        Ok(Arc::clone(current.insert(Arc::new(interval))))
    }

    /// What gives positions at the steps of an interval, of the nodes that have to be `known` or of all.
    fn stepper<'a>(
        &'a self,
        interval: &'a Interval,
        (rounding, known): (Rounding, Option<&'a [u32]>),
        measures: &'a dyn Fn() -> &'a Measures,
    ) -> Stepper<'a> {
        Stepper {
            plan: &self.plan,
            interval,
            measures,
            memory: &self.known[usize::from(rounding == Rounding::Single)],
            rounding,
            known,
            stop: &self.stop,
            progress: &*self.progress,
        }
    }

    /// Positions of a step as they are, judged where something depends on it.
    fn position(
        &self,
        interval: &Interval,
        step: &Step,
        points: &mut [Vector],
    ) -> Result<Positions> {
        let output = &self.plan.schedule.output;
        let judges =
            output.quality != QualityOutput::None && output.on_inverted != OnInverted::Warn;
        let measures = || self.measures();
        let stepper = self.stepper(interval, (Rounding::None, None), &measures);
        stepper.at(step, judges, points)
    }

    /// Writes to `points` where the motion puts the nodes at a step, without a repair. Those of most nodes may stay `apart`, as
    /// for [`evaluate`](Self::evaluate). Gives whether they do, and the velocities.
    pub(crate) fn place(
        &self,
        interval: &Interval,
        step: &Step,
        rounding: Rounding,
        apart: bool,
        points: &mut [Vector],
    ) -> Result<Evaluated> {
        let measures = || self.measures();
        let known = apart.then(|| self.known_nodes()).flatten();
        let stepper = self.stepper(interval, (rounding, known), &measures);
        stepper.plain(step, points)?;
        Ok(Evaluated {
            is_apart: known.is_some(),
            velocities: interval.velocities_at(step, known.is_some(), points),
            ..Evaluated::default()
        })
    }

    /// The nodes whose positions have to be known here where the others may stay elsewhere; none where all are.
    fn known_nodes(&self) -> Option<&[u32]> {
        self.divided.get_or_init(|| self.plan.divide()).as_deref()
    }

    /// Everything about a step but its arrays at cells; positions go to `points`. Those of most nodes may stay `apart`, with
    /// the ranks that move them: [`keep`](Self::keep) gives them.
    pub(crate) fn evaluate(
        &self,
        interval: &Interval,
        step: &Step,
        rounding: Rounding,
        apart: bool,
        points: &mut [Vector],
    ) -> Result<Evaluated> {
        let plan = self.plan();
        let measures = || self.measures();
        let known = apart.then(|| self.known_nodes()).flatten();
        let stepper = self.stepper(interval, (rounding, known), &measures);
        if stepper.known.is_none() {
            plan.take_whole("steps are computed again")?;
        }
        let judges = plan.schedule.output.quality != QualityOutput::None;
        let found = stepper.at(step, judges, points)?;
        let velocities = stepper.velocities(step, &found, points)?;
        let measures = found.cells.is_some().then(|| self.measures());
        let by_fields = found.repair.is_none().then_some(step.index);
        let slots = plan.slots(found.is_apart);
        Ok(Evaluated {
            quality: measures
                .zip(found.cells)
                .map(|(by, cells)| by.complete(plan, cells, points, by_fields)),
            normal_change: measures.and_then(|by| by.normal_change(plan, points, by_fields)),
            first_cell_ratio: plan.first_cells.smallest_ratio((slots, points), &plan.mesh),
            selection_error: found.selection_error,
            surface_error: interval.surface_error(step, (slots, points)),
            largest_displacement: plan.largest_displacement(step.index),
            velocities,
            n_base: interval.n_base,
            repair: found.repair,
            is_apart: found.is_apart,
        })
    }
}

impl Deformation {
    /// The positions of the step that was evaluated last, which are apart.
    pub(crate) fn keep(&self, points: &[Vector]) -> Option<Box<dyn Apart>> {
        let team = self.plan.team()?;
        Some(Box::new(team.keep(points)))
    }
}

/// Everything about a step but its positions.
#[derive(Default)]
pub(crate) struct Evaluated {
    /// Where the schedule asks for quality.
    pub quality: Option<Assessment>,
    /// Largest change of the angle between a moving wall and its first cell, in degrees.
    pub normal_change: Option<f64>,
    /// Smallest ratio of a first-cell height to that of the reference mesh.
    pub first_cell_ratio: Option<f64>,
    /// Largest displacement error before the correction.
    pub selection_error: f64,
    /// Largest and root-mean-square distance of surface nodes from their place.
    pub surface_error: (f64, f64),
    /// Largest prescribed displacement.
    pub largest_displacement: f64,
    /// Where the schedule asks for them.
    pub velocities: Option<Vec<Vector>>,
    /// Distinct base points.
    pub n_base: usize,
    /// What was done about folded cells, where something was.
    pub repair: Option<Repair>,
    /// Whether most positions are with the ranks that moved them.
    pub is_apart: bool,
}

impl Evaluated {
    /// The first inverted cell, where there is one.
    pub fn first_inverted(&self) -> Option<usize> {
        let cells = self.quality.as_ref().map(|quality| &quality.cells);
        let inverted = cells.filter(|cells| cells.inverted > 0);
        inverted.map(|cells| cells.inverted_cells.first().copied().unwrap_or_default())
    }
}
