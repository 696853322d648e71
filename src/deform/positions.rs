//! Positions of the nodes at a step: where the motion puts them, and repaired where cells are folded there.
//!
//! With `on_inverted = "repair"` steps are repaired by windows ([`super::window`]): all of them in as many substeps, in the
//! same area of nodes, each from its own positions. So a repair follows from the mesh, the schedule and the number of
//! the step, whichever steps were looked at before, and goes along with the motion from step to step.

use super::interval::Interval;
use super::measures::Measures;
use super::plan::Plan;
use super::repair::{self, Repair, n_not_valid};
use super::step_memory::{RepairedStep, Rounding, StepMemory};
use super::substeps::Parts;
use super::untangle::StepFreedom;
use super::window::{Window, folded_around, steps_around};
use crate::error::{Result, counted};
use crate::geometry::vector::Vector;
use crate::motion::{OnInverted, Step};
use crate::parallel;
use crate::progress::{Progress, Stop};
use crate::quality::Summary;
use crate::repair::{Area, FoldedCells, Limits, Repaired, refused};
use std::sync::Arc;

/// Rings of neighbours around the folded cells of a window: its repair is spread over more nodes than one step needs.
const LEAST_RINGS: usize = 3;
/// How often the hardest step of a window is looked at for cells that are folded between valid corners.
const LOOKS: usize = 3;

/// Results of positioning the nodes at a step.
#[derive(Clone)]
pub(super) struct Positions {
    pub selection_error: f64,
    pub cells: Option<Summary>,
    pub repair: Option<Repair>,
    /// Whether the positions are with the ranks, but for those that are known here.
    pub is_apart: bool,
}

/// Gives positions at the steps of an interval.
#[derive(Clone, Copy)]
pub(super) struct Stepper<'a> {
    pub plan: &'a Plan,
    pub interval: &'a Interval,
    /// Made where cells are judged.
    pub measures: &'a dyn Fn() -> &'a Measures,
    pub memory: &'a StepMemory,
    pub rounding: Rounding,
    /// The nodes whose positions are wanted here, where the others may stay with the ranks that move them.
    pub known: Option<&'a [u32]>,
    pub stop: &'a Stop,
    /// Hears what is done about folded cells, which may take long.
    pub progress: &'a dyn Progress,
}

impl Stepper<'_> {
    /// Positions of a step, with `judges` judged and repaired where the schedule wants that.
    pub fn at(&self, step: &Step, judges: bool, points: &mut [Vector]) -> Result<Positions> {
        let repairs = self.plan.schedule.output.on_inverted == OnInverted::Repair;
        if judges && repairs && refused(&self.plan.mesh).is_none() {
            let found = self.in_windows(step, points)?;
            self.say_no_more(&found);
            return Ok(found);
        }
        let selection_error = self.plain(step, points)?;
        let cells = judges.then(|| self.judge_plain(step, points));
        let mut found = Positions {
            selection_error,
            cells,
            repair: None,
            is_apart: self.known.is_some(),
        };
        self.alone(step, points, &mut found)?;
        self.say_no_more(&found);
        Ok(found)
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

    /// A step by itself: in substeps, where the schedule wants that and cells are folded.
    fn alone(&self, step: &Step, points: &mut [Vector], found: &mut Positions) -> Result<()> {
        let Some(cells) = &mut found.cells else {
            return Ok(());
        };
        if !repair::wants_repair(self.plan, cells) {
            return Ok(());
        }
        self.make_whole(points)?;
        found.is_apart = false;
        let mut done = self.try_substeps(step, points, cells, &mut found.selection_error)?;
        if self.plan.schedule.output.on_inverted == OnInverted::Repair && n_not_valid(cells) > 0 {
            let freedom = StepFreedom::of(self.plan, (self.measures)(), step);
            self.say_moves(step);
            let repaired = freedom.untangle(points, Limits::default(), self.stop)?;
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
                Ok((error, self.judge_plain(step, points)))
            },
        )
    }

    fn in_windows(&self, step: &Step, points: &mut [Vector]) -> Result<Positions> {
        if let Some(kept) = self.memory.repaired(step.index) {
            points.copy_from_slice(&kept.points);
            return Ok(kept.found.clone());
        }
        let window = self.window(step.index, points)?;
        let selection_error = self.plain(step, points)?;
        let cells = match self.memory.verdict(step.index) {
            Some(cells) => cells,
            None => self.judge_plain(step, points),
        };
        let mut found = Positions {
            selection_error,
            cells: Some(cells),
            repair: None,
            is_apart: self.known.is_some() && window.is_none(),
        };
        // Where nothing has moved there is nothing to take part in.
        let window = match window {
            Some(window) => {
                self.make_whole(points)?;
                (*points != self.plan.whole().points[..]).then_some(window)
            }
            None => None,
        };
        if let Some(window) = window {
            self.repair(&window, step, points, &mut found)?;
            if self.plan.velocity.is_some() {
                self.memory.keep_repaired(RepairedStep {
                    step: step.index,
                    points: points.to_vec(),
                    found: found.clone(),
                });
            }
        }
        Ok(found)
    }

    /// The window of a step, where it lies in one; leaves `points` in disorder.
    fn window(&self, step: usize, points: &mut [Vector]) -> Result<Option<Arc<Window>>> {
        if let Some(window) = self.memory.window(step) {
            return Ok(Some(window));
        }
        let folded = folded_around(step, self.interval.steps(), &mut |step| {
            if let Some(n) = self.memory.folded(step) {
                return Ok(n > 0);
            }
            self.stop.check()?;
            let at = &self.plan.motion.steps[step];
            self.plain(at, points)?;
            let cells = self.judge_plain(at, points);
            self.memory.keep_verdict(step, &cells);
            Ok(n_not_valid(&cells) > 0)
        })?;
        if folded.is_empty() {
            return Ok(None);
        }
        let window = Arc::new(self.find(folded, points)?);
        self.memory.keep_window(&window);
        Ok(Some(window))
    }

    /// The window of folded steps: as many substeps as the step needs that has most folded cells, and an area around
    /// all cells that are still folded at any step then, as wide as the hardest of them needs.
    fn find(&self, folded: Vec<usize>, points: &mut [Vector]) -> Result<Window> {
        let steps = &self.plan.motion.steps;
        let n_folded = |step: usize| self.memory.folded(step).unwrap_or(0);
        let worst = folded
            .iter()
            .copied()
            .rev()
            .max_by_key(|&step| n_folded(step));
        let worst = &steps[worst.unwrap_or(folded[0])];
        let mut error = self.plain(worst, points)?;
        let mut cells = self.judge_plain(worst, points);
        self.make_whole(points)?;
        let substeps = self
            .try_substeps(worst, points, &mut cells, &mut error)?
            .substeps;
        let freedom = StepFreedom::of(self.plan, (self.measures)(), worst);
        let mut all = FoldedCells::default();
        let mut hardest = (0, worst);
        for &step in &folded {
            self.stop.check()?;
            let error = self.start(&steps[step], substeps, points)?;
            if substeps.is_some() {
                self.memory.keep_start(step, points, error);
            }
            let n = all.add(freedom.task(), points).all();
            if n > hardest.0 {
                hardest = (n, &steps[step]);
            }
        }
        let mut rings = LEAST_RINGS;
        if hardest.0 > 0 {
            self.kept_start(hardest.1, substeps, points)?;
            let freedom = StepFreedom::of(self.plan, (self.measures)(), hardest.1);
            self.say_moves(hardest.1);
            let repaired = freedom.untangle(points, Limits::default(), self.stop)?;
            rings = rings_of(&repaired).max(rings);
        }
        let mut area = Area::around(freedom.task(), &all, rings);
        if hardest.0 > 0 {
            self.look_between(&mut area, hardest.1, substeps, points)?;
        }
        Ok(Window {
            steps: steps_around(&folded, self.interval.steps()),
            substeps,
            area,
            folded,
        })
    }

    /// Has an area look between the corners of the cells that it leaves folded there at the hardest step, so that it moves
    /// its nodes at all steps alike.
    fn look_between(
        &self,
        area: &mut Area,
        hardest: &Step,
        substeps: Option<Parts>,
        points: &mut [Vector],
    ) -> Result<()> {
        let freedom = StepFreedom::of(self.plan, (self.measures)(), hardest);
        for _ in 0..LOOKS {
            self.kept_start(hardest, substeps, points)?;
            freedom.relax(area, points, self.stop)?;
            self.rounding.apply(points);
            if !area.look_between(freedom.task(), points) {
                break;
            }
        }
        Ok(())
    }

    /// Repairs a step of a window, whose positions before that are in `points`.
    fn repair(
        &self,
        window: &Window,
        step: &Step,
        points: &mut [Vector],
        found: &mut Positions,
    ) -> Result<()> {
        let before = found.cells.take().unwrap_or_default();
        let weight = window.weight(step.index);
        let plain = (weight < 1.0).then(|| points.to_vec());
        let plain_error = found.selection_error;
        if window.substeps.is_some() {
            found.selection_error = match self.memory.take_start(step.index) {
                Some(start) => {
                    points.copy_from_slice(&start.points);
                    start.selection_error
                }
                None => self.start(step, window.substeps, points)?,
            };
        }
        let freedom = StepFreedom::of(self.plan, (self.measures)(), step);
        let after = FoldedCells::default().add(freedom.task(), points);
        self.say_moves(step);
        let (repaired, mut cells) = self.make_valid(&freedom, &window.area, points)?;
        let mut taken = 1.0;
        if let Some(plain) = plain {
            let blended = self.blend(&freedom, &plain, weight, points, cells);
            (taken, cells) = blended;
            found.selection_error = found.selection_error.max(plain_error);
            if n_not_valid(&cells) > 0 {
                // A step that is valid by itself stays so.
                points.copy_from_slice(&plain);
                found.selection_error = plain_error;
                (taken, cells) = (0.0, before.clone());
            }
        }
        found.repair = Some(Repair::of_window(
            window,
            taken,
            (&before, after),
            repaired,
            &cells,
        ));
        found.cells = Some(cells);
        Ok(())
    }

    /// Moves the nodes of an area to where its functional is least. Where cells are left, they get patches of their own; then
    /// the area has another try, from valid cells, so that it ends where it ends at the steps beside this one.
    fn make_valid(
        &self,
        freedom: &StepFreedom<'_>,
        area: &Area,
        points: &mut [Vector],
    ) -> Result<(Repaired, Summary)> {
        let mut repaired = freedom.relax(area, points, self.stop)?;
        self.rounding.apply(points);
        let mut cells = self.judge(points);
        if n_not_valid(&cells) == 0 {
            return Ok((repaired, cells));
        }
        let further = freedom.untangle(points, Limits::default(), self.stop)?;
        repaired.patches.extend(further.patches);
        self.rounding.apply(points);
        cells = self.judge(points);
        if n_not_valid(&cells) == 0 {
            let mut again = points.to_vec();
            let last = freedom.relax(area, &mut again, self.stop)?;
            self.rounding.apply(&mut again);
            let after = self.judge(&again);
            if n_not_valid(&after) == 0 {
                points.copy_from_slice(&again);
                repaired.patches.extend(last.patches);
                cells = after;
            }
        }
        Ok((repaired, cells))
    }

    /// Makes `points`, which are a repaired step, a part of that and of its `plain` positions: `weight` of it, or more where
    /// cells are folded then. Gives the part and its cells.
    fn blend(
        &self,
        freedom: &StepFreedom<'_>,
        plain: &[Vector],
        weight: f64,
        points: &mut [Vector],
        cells: Summary,
    ) -> (f64, Summary) {
        let repaired = points.to_vec();
        for weight in [weight, 0.5 + 0.5 * weight, 0.75 + 0.25 * weight] {
            parallel::update(points, |node, x| {
                let (from, to) = (plain[node], repaired[node]);
                for k in 0..3 {
                    x[k] = from[k] + weight * (to[k] - from[k]);
                }
            });
            freedom.keep_to_surface(points);
            self.rounding.apply(points);
            let cells = self.judge(points);
            if n_not_valid(&cells) == 0 {
                return (weight, cells);
            }
        }
        points.copy_from_slice(&repaired);
        (1.0, cells)
    }

    /// Where the motion puts the nodes; gives the largest error before the correction.
    pub fn plain(&self, step: &Step, points: &mut [Vector]) -> Result<f64> {
        let n_substeps = self.plan.schedule.rbf.substeps;
        if n_substeps > 1 {
            self.progress
                .say(&format!("{step} is computed in {n_substeps} substeps"));
        }
        let error = (self.interval).known_points_at(step, self.known, points)?;
        self.end_move(step, (self.known, false), points);
        Ok(error)
    }

    fn through(&self, step: &Step, parts: Parts, points: &mut [Vector]) -> Result<f64> {
        let error = self.interval.points_through(step, parts, points)?;
        self.end_move(step, (None, true), points);
        Ok(error)
    }

    /// Rounds positions that fields gave, and has all ranks end the move.
    fn end_move(
        &self,
        step: &Step,
        (known, in_substeps): (Option<&[u32]>, bool),
        points: &mut [Vector],
    ) {
        match known {
            Some(known) => {
                let slots = self.plan.slots(true);
                self.rounding.apply_to(known, (slots, points));
            }
            None => self.rounding.apply(points),
        }
        let team = self.plan.team();
        if let Some(team) = team.filter(|_| self.interval.ranks_follow(known, in_substeps)) {
            team.end_move(step.index, self.plan.maps_at(step), self.rounding);
        }
    }

    /// Takes the positions of a plain step that are elsewhere, and the whole mesh.
    fn make_whole(&self, points: &mut [Vector]) -> Result<()> {
        if self.known.is_none() {
            return Ok(());
        }
        self.plan.take_whole("folded cells are repaired")?;
        if let Some(team) = self.plan.team() {
            team.collect(points);
        }
        Ok(())
    }

    /// Where the repair of a step begins.
    fn start(&self, step: &Step, substeps: Option<Parts>, points: &mut [Vector]) -> Result<f64> {
        match substeps {
            None => {
                let error = self.plain(step, points)?;
                self.make_whole(points)?;
                Ok(error)
            }
            Some(parts) => self.through(step, parts, points),
        }
    }

    /// The same, from memory where it was kept there.
    fn kept_start(
        &self,
        step: &Step,
        substeps: Option<Parts>,
        points: &mut [Vector],
    ) -> Result<()> {
        if self.memory.copy_start(step.index, points).is_none() {
            self.start(step, substeps, points)?;
        }
        Ok(())
    }

    fn judge(&self, points: &[Vector]) -> Summary {
        (self.measures)().cells(self.plan, points, None)
    }

    /// The same of positions that [`plain`](Self::plain) or [`through`](Self::through) has just given.
    fn judge_plain(&self, step: &Step, points: &[Vector]) -> Summary {
        (self.measures)().cells(self.plan, points, Some(step.index))
    }
}

/// The rings of the widest patch that has become valid.
fn rings_of(repaired: &Repaired) -> usize {
    let valid = repaired.patches.iter().filter(|log| log.invalid == 0);
    valid.map(|log| log.rings).max().unwrap_or(0)
}
