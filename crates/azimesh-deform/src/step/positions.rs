//! Positions of the nodes at a step: as prescribed by the motion, with folded cells repaired.
//!
//! With `on_inverted = "repair"` steps are repaired by windows ([`super::window`]): all of them with the same substeps and
//! in the same area of nodes, each from its own positions. So a repair depends only on the mesh, the schedule and the number
//! of the step, not on the order of evaluation, and changes smoothly with the motion from step to step.

use super::evaluator::StepEvaluator;
use super::measures::Measures;
use super::repair::{self, CellsToRepair, Repair, n_not_valid};
use super::segment::Segment;
use super::step_memory::{RepairedStep, Rounding, StepMemory};
use super::substeps::Parts;
use super::untangle::{StepFreedom, copies};
use super::window::{FADE, Window, faded, folded_around, steps_around};
use crate::motion::{OnInverted, Step};
use crate::part::Part;
use crate::plan::Plan;
use crate::whole::{Whole, on_first};
use azimesh_core::error::{Result, counted};
use azimesh_core::geometry::vector::{Vector, add, scale};
use azimesh_core::parallel;
use azimesh_core::progress::{Progress, Stop};
use azimesh_quality::Summary;
use azimesh_quality::repair::{Area, FoldedCells, Limits, PatchLog, low_cells, refused};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// Least rings of neighbours around the folded cells of a window: its repair is spread over more nodes than one step needs.
const LEAST_RINGS: usize = 3;
/// Largest number of checks of a window's hardest step for cells that are folded between valid corners.
const LOOKS: usize = 3;
const MEASURED: &str = "repairs are made where quality is evaluated";
const ON_FIRST: &str = "the first rank has the whole mesh";

/// The directions in which nodes may move, on the first rank.
type OnFirst<'a> = Option<StepFreedom<'a>>;

/// Results of positioning the nodes at a step.
#[derive(Clone)]
pub(crate) struct Positions {
    pub selection_error: f64,
    pub cells: Option<Summary>,
    pub repair: Option<Repair>,
}

/// Data and functions to compute positions at the steps of an interval. All ranks call its functions, each for the nodes of its part.
#[derive(Clone, Copy)]
pub(crate) struct Stepper<'a> {
    pub plan: &'a Plan,
    pub part: &'a Part,
    pub whole: &'a Whole,
    pub interval: &'a StepEvaluator,
    /// The steps of one run, which begin windows of their own.
    pub segment: &'a Segment,
    /// Present if quality is evaluated and folded cells are repaired.
    pub measures: Option<&'a Measures>,
    pub memory: &'a StepMemory,
    pub rounding: Rounding,
    /// Cells below this scaled Jacobian are improved, after a repair without this.
    pub improve: Option<f64>,
    pub stop: &'a Stop,
    /// Receives messages about repairs, which may take long.
    pub progress: &'a dyn Progress,
}

impl<'a> Stepper<'a> {
    /// Computes positions of a step; evaluates and repairs them if the schedule asks for that.
    pub fn at(&self, step: &Step, points: &mut [Vector]) -> Result<Positions> {
        let repairs = self.plan.schedule.output.on_inverted == OnInverted::Repair;
        if self.measures.is_some() && repairs && self.is_repaired_by_windows()? {
            let found = self.in_windows(step, points)?;
            self.say_no_more(&found);
            return Ok(found);
        }
        let selection_error = self.plain(step, points)?;
        let cells = self.measures.map(|by| by.cells(&self.part.mesh, points));
        let mut found = Positions {
            selection_error,
            cells,
            repair: None,
        };
        self.alone(step, points, &mut found)?;
        self.say_no_more(&found);
        Ok(found)
    }

    /// Returns whether the mesh has only cells that can be repaired.
    fn is_repaired_by_windows(&self) -> Result<bool> {
        let own = refused(&self.part.mesh).is_none();
        Ok(self.part.ranks().allgather(own).into_iter().all(|own| own))
    }

    fn say_moves(&self, step: &Step) {
        self.progress
            .say(&format!("{step}: nodes near folded cells are moved"));
    }

    fn say_no_more(&self, found: &Positions) {
        if found.repair.is_some() {
            self.progress.say("");
        }
    }

    /// Repairs a single step: in substeps, if the schedule asks for that and cells are folded.
    fn alone(&self, step: &Step, points: &mut [Vector], found: &mut Positions) -> Result<()> {
        let Some(cells) = &mut found.cells else {
            return Ok(());
        };
        if !repair::wants_repair(self.plan, cells) {
            return Ok(());
        }
        let mut done = self.try_substeps(step, points, cells, &mut found.selection_error)?;
        if self.plan.schedule.output.on_inverted == OnInverted::Repair && n_not_valid(cells) > 0 {
            let freedom = self.freedom(step)?;
            self.say_moves(step);
            let repaired = self.untangle(&freedom, points)?;
            done.untangled(repaired, n_not_valid(cells));
        }
        found.repair = Some(done);
        Ok(())
    }

    fn try_substeps(
        &self,
        step: &Step,
        points: &mut [Vector],
        cells: &mut Summary,
        error: &mut f64,
    ) -> Result<Repair> {
        repair::try_substeps(
            self.plan,
            points,
            cells,
            error,
            |parts, n_inverted, points| {
                let inverted = counted(n_inverted, "inverted cell");
                self.progress.say(&format!(
                    "{step} has {inverted}, and is computed in {} substeps",
                    parts.n
                ));
                let error = self.through(step, parts, points)?;
                Ok((error, self.cells(points)))
            },
        )
    }

    /// Computes a step as repaired without improving cells, then improves them: so no step becomes worse by it.
    fn in_windows(&self, step: &Step, points: &mut [Vector]) -> Result<Positions> {
        if let Some(kept) = self.memory.repaired(step.index) {
            points.copy_from_slice(&kept.points);
            return Ok(kept.found.clone());
        }
        let repairs = Self {
            improve: None,
            ..*self
        };
        let window = repairs.window(step.index, points)?;
        let selection_error = self.plain(step, points)?;
        let cells = match self.memory.verdict(step.index) {
            Some(cells) => cells,
            None => self.cells(points),
        };
        let mut found = Positions {
            selection_error,
            cells: Some(cells),
            repair: None,
        };
        // Nothing has moved, so there is no window to join.
        if !self.has_moved(points) {
            return Ok(found);
        }
        if let Some(window) = &window {
            repairs.repair(window, step, points, &mut found)?;
        }
        if self.improve.is_some()
            && let Some(window) = self.window(step.index, &mut points.to_vec())?
        {
            self.repair(&window, step, points, &mut found)?;
        }
        if self.plan.velocity.is_some() && found.repair.is_some() {
            self.memory.keep_repaired(RepairedStep {
                step: step.index,
                points: points.to_vec(),
                found: found.clone(),
            });
        }
        Ok(found)
    }

    /// Returns whether any node of the mesh has moved from its position at rest.
    fn has_moved(&self, points: &[Vector]) -> bool {
        let own = *points != self.part.mesh.points[..];
        self.part.ranks().allgather(own).contains(&true)
    }

    /// Finds the window of a step, if any; overwrites `points`.
    fn window(&self, step: usize, points: &mut [Vector]) -> Result<Option<Arc<Window>>> {
        if let Some(window) = self.memory.window(self.improve.is_some(), step) {
            return Ok(Some(window));
        }
        let within = self.window_range();
        let folded = folded_around(step, &within, &mut |step| {
            if self.memory.repair_count(step).is_some() {
                return Ok(self.repair_count(step) != CellsToRepair::default());
            }
            self.check_stop()?;
            let at = &self.plan.motion.steps[step];
            self.plain(at, points)?;
            let cells = self.cells(points);
            let repair_count = CellsToRepair {
                not_valid: n_not_valid(&cells),
                low: self.n_low(points),
            };
            self.memory.keep_verdict(step, &cells, repair_count);
            Ok(self.repair_count(step) != CellsToRepair::default())
        })?;
        let window = if folded.is_empty() {
            let Some(fading) = self.fading().filter(|steps| steps.contains(&step)) else {
                return Ok(None);
            };
            Window::after_seam(fading)
        } else {
            self.find(folded, points)?
        };
        let window = Arc::new(window);
        self.memory.keep_window(&window);
        Ok(Some(window))
    }

    /// Returns the steps that windows may have.
    fn window_range(&self) -> Range<usize> {
        let Range { start, end } = self.interval.steps().clone();
        start.max(self.segment.steps.start)..end
    }

    /// Returns the steps over which the repair of the last finished step fades; `None` if it was not repaired. Improved cells
    /// start from positions that follow it already.
    fn fading(&self) -> Option<Range<usize>> {
        let Range { start, end } = self.window_range();
        let seam = self.segment.seam().filter(|_| self.improve.is_none());
        seam.map(|_| start..(start + FADE).min(end))
    }

    /// Moves the `plain` positions of a step towards the positions of the last finished step, if the repair displaced them.
    fn follow_seam<'b>(&self, step: &Step, plain: &'b [Vector]) -> Cow<'b, [Vector]> {
        let by = faded(self.segment.after_seam(step));
        let Some(seam) = self
            .segment
            .seam()
            .filter(|_| by > 0.0 && self.improve.is_none())
        else {
            return Cow::Borrowed(plain);
        };
        let to_inertial = self.plan.motion.to_inertial(step);
        Cow::Owned(parallel::collect(plain.len(), |node| {
            let number = self.part.mesh.number_of_node(node as u32);
            let turn = to_inertial.as_ref().and_then(|to| to.of_node(number));
            let added = turn.map_or(seam[node], |turn| turn.turn(seam[node]));
            add(plain[node], scale(added, by))
        }))
    }

    /// Returns the number of cells of a step that need a repair; cells of low quality only if they are improved.
    fn repair_count(&self, step: usize) -> CellsToRepair {
        let CellsToRepair { not_valid, low } = self.memory.repair_count(step).unwrap_or_default();
        let low = if self.improve.is_some() { low } else { 0 };
        CellsToRepair { not_valid, low }
    }

    /// The key of a step of the windows of this kind.
    fn key(&self, step: &Step) -> (bool, usize) {
        (self.improve.is_some(), step.index)
    }

    /// Finds the window of folded steps. The step with most folded cells determines the substeps. The area surrounds all
    /// cells that are still folded at any step, with as many rings as the hardest step needs.
    fn find(&self, folded: Vec<usize>, points: &mut [Vector]) -> Result<Window> {
        let steps = &self.plan.motion.steps;
        let worst = folded
            .iter()
            .copied()
            .rev()
            .max_by_key(|&step| self.repair_count(step));
        let worst = &steps[worst.unwrap_or(folded[0])];
        let mut error = self.plain(worst, points)?;
        let mut cells = self.cells(points);
        let substeps = self
            .try_substeps(worst, points, &mut cells, &mut error)?
            .substeps;
        let freedom = self.freedom(worst)?;
        let mut all = FoldedCells::default();
        let mut hardest = (0, worst);
        for &step in &folded {
            self.check_stop()?;
            let error = self.start(&steps[step], substeps, points)?;
            if substeps.is_some() {
                let n_nodes = self.plan.boundary.n_nodes;
                let key = self.key(&steps[step]);
                self.memory.keep_start(key, n_nodes, points, error);
            }
            let n = self.on_first(&freedom, points, |freedom, points| {
                Ok(freedom.add(&mut all, points, self.improve))
            })?;
            if n > hardest.0 {
                hardest = (n, &steps[step]);
            }
        }
        let mut rings = LEAST_RINGS;
        if hardest.0 > 0 {
            self.kept_start(hardest.1, substeps, points)?;
            let freedom = self.freedom(hardest.1)?;
            self.say_moves(hardest.1);
            rings = rings_of(&self.untangle(&freedom, points)?).max(rings);
        }
        let mut area = None;
        self.on_first(&freedom, points, |freedom, points| {
            area = Some(freedom.area(&all, rings, points, self.improve, self.stop)?);
            Ok(())
        })?;
        if hardest.0 > 0 && self.repair_count(hardest.1.index).not_valid > 0 {
            self.look_between(&mut area, hardest.1, substeps, points)?;
        }
        Ok(Window {
            steps: steps_around(&folded, &self.window_range()),
            improves: self.improve.is_some(),
            substeps,
            area,
            folded,
        })
    }

    /// Checks the cells of an area between their corners at the hardest step, and extends the area by cells that are
    /// folded there, so that it moves its nodes in the same way at all steps.
    fn look_between(
        &self,
        area: &mut Option<Area>,
        hardest: &Step,
        substeps: Option<Parts>,
        points: &mut [Vector],
    ) -> Result<()> {
        let freedom = self.freedom(hardest)?;
        for _ in 0..LOOKS {
            self.kept_start(hardest, substeps, points)?;
            self.relax(&freedom, area.as_ref(), points)?;
            let found_more = self.on_first(&freedom, points, |freedom, points| {
                let area = area.as_mut().expect(ON_FIRST);
                Ok(area.look_between(freedom.task(), points))
            })?;
            if !found_more {
                break;
            }
        }
        Ok(())
    }

    /// Repairs a step of a window; `points` has its positions by the motion or, if cells are improved, as repaired without that.
    fn repair(
        &self,
        window: &Window,
        step: &Step,
        points: &mut [Vector],
        found: &mut Positions,
    ) -> Result<()> {
        let before = found.cells.take().unwrap_or_default();
        let plain_cells = self
            .memory
            .verdict(step.index)
            .unwrap_or_else(|| before.clone());
        let growth = 1.0 - faded(self.segment.after_seam(step));
        let weight = window.weight(step.index) * growth;
        let improves = window.improves;
        let plain = (weight < 1.0 || improves).then(|| points.to_vec());
        let plain_error = found.selection_error;
        if window.substeps.is_some() || improves && found.repair.is_some() {
            found.selection_error = match self.memory.take_start(self.key(step)) {
                Some(start) => {
                    points.copy_from_slice(&start.points);
                    start.selection_error
                }
                None => self.start(step, window.substeps, points)?,
            };
        }
        let freedom = self.freedom(step)?;
        let after = self.on_first(&freedom, points, |freedom, points| {
            Ok(FoldedCells::default().add(freedom.task(), points))
        })?;
        self.say_moves(step);
        let area = window.area.as_ref();
        let (repaired, mut cells) = if window.folded.is_empty() {
            (Vec::new(), before.clone())
        } else {
            self.make_valid(&freedom, area, points)?
        };
        let repair_count = self.memory.repair_count(step.index).unwrap_or_default();
        let mut taken = 1.0;
        if let Some(plain) = plain {
            let is_good = |cells: &Summary| {
                let is_valid = n_not_valid(cells) == 0;
                if improves {
                    !cells.is_worse_than(&before)
                } else {
                    is_valid
                }
            };
            if weight < 1.0 || !is_good(&cells) {
                let from = self.follow_seam(step, &plain);
                (taken, cells) =
                    self.blend(&freedom, &from, weight, points, cells, (improves, &is_good))?;
                found.selection_error = found.selection_error.max(plain_error);
            }
            if !is_good(&cells) {
                // A step that is valid without the repair stays valid, and one that is better without `improve` as good.
                points.copy_from_slice(&plain);
                found.selection_error = plain_error;
                (taken, cells) = (0.0, before.clone());
                if let Some(repair) = &mut found.repair {
                    repair.low = repair_count.low;
                    repair.still_low = self.n_low(points);
                    found.cells = Some(cells);
                    return Ok(());
                }
            }
        }
        if window.folded.is_empty() {
            taken = (1.0 - growth) * (1.0 - taken);
        }
        found.repair = Some(Repair::of_window(
            window,
            taken,
            (&plain_cells, repair_count),
            after,
            repaired,
            (&cells, self.n_low(points)),
        ));
        found.cells = Some(cells);
        Ok(())
    }

    /// Moves the nodes of an area to the minimum of its functional. Remaining folded cells get their own patches. The area
    /// is then minimised again from valid cells, so that it converges to the same result as in neighbouring steps.
    fn make_valid(
        &self,
        freedom: &OnFirst<'_>,
        area: Option<&Area>,
        points: &mut [Vector],
    ) -> Result<(Vec<PatchLog>, Summary)> {
        let mut repaired = self.relax(freedom, area, points)?;
        let mut cells = self.cells(points);
        if n_not_valid(&cells) == 0 {
            return Ok((repaired, cells));
        }
        repaired.extend(self.untangle(freedom, points)?);
        self.rounding.apply(points);
        cells = self.cells(points);
        if n_not_valid(&cells) == 0 {
            let mut again = points.to_vec();
            let last = self.relax(freedom, area, &mut again)?;
            let after = self.cells(&again);
            if n_not_valid(&after) == 0 {
                points.copy_from_slice(&again);
                repaired.extend(last);
                cells = after;
            }
        }
        Ok((repaired, cells))
    }

    /// Blends a repaired step `points` with its `plain` positions: by `weight`, or more if the cells would not be good, or less
    /// if cells are improved. Returns the weight and the quality of the cells.
    fn blend(
        &self,
        freedom: &OnFirst<'_>,
        plain: &[Vector],
        weight: f64,
        points: &mut [Vector],
        cells: Summary,
        (improves, is_good): (bool, &dyn Fn(&Summary) -> bool),
    ) -> Result<(f64, Summary)> {
        let repaired = points.to_vec();
        let weights = if improves {
            [1.0, 0.6, 0.3].map(|part| part * weight)
        } else {
            [0.0, 0.5, 0.75].map(|part| part + (1.0 - part) * weight)
        };
        for weight in weights {
            parallel::update(points, |node, x| {
                let (from, to) = (plain[node], repaired[node]);
                for k in 0..3 {
                    x[k] = from[k] + weight * (to[k] - from[k]);
                }
            });
            self.on_first(freedom, points, |freedom, points| {
                freedom.keep_to_surface(points);
                Ok(())
            })?;
            self.rounding.apply(points);
            let cells = self.cells(points);
            if is_good(&cells) {
                return Ok((weight, cells));
            }
        }
        points.copy_from_slice(&repaired);
        Ok((1.0, cells))
    }

    /// Computes positions by the motion; returns the largest error before the correction.
    pub fn plain(&self, step: &Step, points: &mut [Vector]) -> Result<f64> {
        let n_substeps = self.plan.schedule.rbf.substeps;
        if n_substeps > 1 {
            self.progress
                .say(&format!("{step} is computed in {n_substeps} substeps"));
        }
        let error = self.interval.points_at(step, points)?;
        self.rounding.apply(points);
        Ok(error)
    }

    fn through(&self, step: &Step, parts: Parts, points: &mut [Vector]) -> Result<f64> {
        let error = self.interval.points_through(step, parts, points)?;
        self.rounding.apply(points);
        Ok(error)
    }

    /// Evaluates the quality of the cells.
    fn cells(&self, points: &[Vector]) -> Summary {
        self.measures
            .expect(MEASURED)
            .cells(&self.part.mesh, points)
    }

    /// Cells below the scaled Jacobian that the schedule wants, on all ranks.
    fn n_low(&self, points: &[Vector]) -> usize {
        let Some(wanted) = self.plan.schedule.output.improve else {
            return 0;
        };
        let reference = &self.measures.expect(MEASURED).evaluator.reference;
        let own = low_cells(&self.part.mesh, reference, points, wanted).len();
        self.part.ranks().allgather(own).into_iter().sum()
    }

    /// Returns an error if the user of any rank has requested a stop.
    fn check_stop(&self) -> Result<()> {
        self.part.ranks().all_ok(self.stop.check())
    }

    /// Returns the directions in which nodes may move at a step; `None` on all ranks but the first.
    fn freedom(&self, step: &Step) -> Result<OnFirst<'a>> {
        let own = &self.measures.expect(MEASURED).evaluator;
        let made = || {
            let mesh = self.whole.mesh(self.part)?;
            let evaluator = self.whole.evaluator(self.part, own)?;
            let copies = self.whole.copies(|| copies(self.plan, mesh));
            Ok(StepFreedom::of(self.plan, mesh, evaluator, copies, step))
        };
        let ranks = self.part.ranks();
        ranks.all_ok(ranks.is_first().then(made).transpose())
    }

    /// Makes the first rank work on the positions of all nodes.
    fn on_first<T: Serialize + DeserializeOwned>(
        &self,
        freedom: &OnFirst<'_>,
        points: &mut [Vector],
        act: impl FnOnce(&StepFreedom<'_>, &mut [Vector]) -> Result<T>,
    ) -> Result<T> {
        on_first(self.part, points, |points| {
            act(freedom.as_ref().expect(ON_FIRST), points)
        })
    }

    /// Makes invalid cells valid, moving as few nodes as possible.
    fn untangle(&self, freedom: &OnFirst<'_>, points: &mut [Vector]) -> Result<Vec<PatchLog>> {
        self.on_first(freedom, points, |freedom, points| {
            freedom.untangle(points, Limits::default(), self.stop)
        })
    }

    /// Moves the nodes of an area to the minimum of its functional, and rounds them.
    fn relax(
        &self,
        freedom: &OnFirst<'_>,
        area: Option<&Area>,
        points: &mut [Vector],
    ) -> Result<Vec<PatchLog>> {
        let repaired = self.on_first(freedom, points, |freedom, points| {
            freedom.relax(area.expect(ON_FIRST), points, self.stop)
        })?;
        self.rounding.apply(points);
        Ok(repaired)
    }

    /// Computes the positions before the repair of a step.
    fn start(&self, step: &Step, substeps: Option<Parts>, points: &mut [Vector]) -> Result<f64> {
        match substeps {
            None => self.plain(step, points),
            Some(parts) => self.through(step, parts, points),
        }
    }

    /// Returns the positions before the repair of a step, from memory if they are stored.
    fn kept_start(
        &self,
        step: &Step,
        substeps: Option<Parts>,
        points: &mut [Vector],
    ) -> Result<()> {
        if self.memory.copy_start(self.key(step), points).is_none() {
            self.start(step, substeps, points)?;
        }
        Ok(())
    }
}

/// Returns the rings of the widest patch that has become valid.
fn rings_of(patches: &[PatchLog]) -> usize {
    let valid = patches.iter().filter(|log| log.invalid == 0);
    valid.map(|log| log.rings).max().unwrap_or(0)
}
