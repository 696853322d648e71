//! Sets of node displacements, one for each step or one for all: the set of a step and its rate of change.

use super::clock::{NO_TIME, StepHistory, transient};
use super::link::{Link, NodeField, NodeLink};
use super::modes::ModeShapes;
use super::nodes::BodyNodes;
use super::{At, Clock, MapScope, OnMesh, ResolvedMotion};
use crate::motion::steps::Step;
use crate::motion::table::{History, Interpolation, Key, Period, why_once};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, scale, sub};
use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

/// Allowed offset of a set from its step, as a part of the distance to the next set; of a single set, as a part of
/// its position.
const SAME: f64 = 1e-4;
/// Round-off, as a part of a position.
const ROUND_OFF: f64 = 1e-14;
/// Allowed difference of the last set of whole revolutions from the first, as a part of the largest component.
const REPEATED: f64 = 1e-3;

/// A set of displacements of the nodes of a body for every step, or one for all.
#[derive(Debug)]
pub(super) struct NodeSets {
    /// Key of the sets; `None` for one set for all steps.
    key: Option<Key>,
    /// Positions of the sets, increasing.
    places: Vec<f64>,
    /// Displacements of the body's nodes.
    sets: Vec<Vec<Vector>>,
    /// The last line of each set, in a table.
    lines: Vec<u64>,
    /// Period of the sets, or the reason why they are not periodic.
    period: std::result::Result<Period, Option<String>>,
    /// Notes for the user.
    notes: Vec<Note>,
    nodes: Arc<BodyNodes>,
    /// The azimuth (radians) by which the body is ahead among them; 0 if they are not periodic.
    offset: f64,
}

impl ResolvedMotion for NodeSets {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let set = self.find(at.step).expect("there is a set for every step");
        let rates = || self.rates(at.step, &at.clock);
        let rates = at.rates.then(|| NodeField::Values(Cow::Owned(rates())));
        Some(Link::Nodes(NodeLink {
            nodes: Arc::clone(&self.nodes),
            fields: vec![(NodeField::Values(Cow::Borrowed(&self.sets[set])), rates)],
            part: at.part,
            growth: 0.0,
        }))
    }

    fn map_scope(&self) -> MapScope {
        MapScope::Nodes
    }

    fn memory_bytes(&self) -> usize {
        let sets = self.sets.iter();
        sets.map(|set| size_of_val(set.as_slice())).sum()
    }

    fn notes(&self) -> &[Note] {
        &self.notes
    }
}

impl NodeSets {
    /// One set for all steps.
    pub(super) fn one(sets: Vec<Vec<Vector>>, notes: Vec<Note>, on: &OnMesh<'_>) -> Self {
        Self {
            key: None,
            places: vec![0.0],
            sets,
            lines: Vec::new(),
            period: Err(None),
            notes,
            nodes: on.nodes(),
            offset: 0.0,
        }
    }

    /// Creates sets at increasing positions of a key; `lines` has the last line of each in a table.
    pub(super) fn at_places(
        (key, places): (Key, Vec<f64>),
        sets: Vec<Vec<Vector>>,
        lines: Vec<u64>,
        notes: Vec<Note>,
        on: &OnMesh<'_>,
    ) -> Self {
        let period = Period::of(key, &places, || last_differs(&sets));
        Self {
            key: Some(key),
            places,
            lines,
            offset: if period.is_ok() { on.offset } else { 0.0 },
            period,
            ..Self::one(sets, notes, on)
        }
    }

    /// The set that holds at every step with its notes, where it is one.
    pub(super) fn single(mut self) -> Option<(Vec<Vector>, Vec<Note>)> {
        (self.key.is_none()).then(|| (self.sets.remove(0), self.notes))
    }

    /// Interpolates between the sets: each is a shape whose coordinate is 1 at its own position and 0 at the others.
    pub(super) fn interpolated(
        self,
        interpolation: Interpolation,
        on: &OnMesh<'_>,
        path: &Path,
    ) -> Result<Arc<dyn ResolvedMotion>> {
        let Some(key) = self.key else {
            let message = "there is one set of displacements, which holds at every step: nothing is between sets; leave it out, or give \
                           the table a column `time_s`, `azimuth_deg` or `step`";
            return Err(on.error("surface.interpolation", message));
        };
        let (n, n_shapes) = (
            self.places.len(),
            self.period
                .as_ref()
                .map_or(self.places.len(), |period| period.n_rows),
        );
        let factors =
            (0..n * n_shapes).map(|at| f64::from((at / n_shapes) % n_shapes == at % n_shapes));
        let ends = [0, n - 1].map(|set| self.lines[set]);
        let history = History::new(path, key, self.places, factors.collect(), interpolation);
        let coordinates = StepHistory::new(history.with_lines(ends).held(), on, "surface")?;
        let mut notes = self.notes;
        notes.extend(coordinates.note.clone());
        Ok(Arc::new(ModeShapes {
            shapes: self.sets,
            coordinates,
            nodes: self.nodes,
            notes,
        }))
    }

    /// Returns the set of a step.
    fn find(&self, step: &Step) -> Option<usize> {
        let Some(key) = self.key else { return Some(0) };
        let at = Clock::place(key, step, self.offset)?;
        let turned = || self.nearest_turned(at, self.period.as_ref().ok()?.length);
        self.nearest(at).or_else(turned)
    }

    /// Refuses steps without a set; adds a note if the body has an azimuth offset that the sets do not follow.
    pub(super) fn check(&mut self, on: &OnMesh<'_>, path: &Path) -> Result<()> {
        let Some(key) = self.key else { return Ok(()) };
        on.clock.check_azimuth(key, on, "surface")?;
        let mut steps = on.clock.steps.iter();
        steps.try_for_each(|step| self.check_step(step, on, path))?;
        if let Err(open) = &self.period {
            let note = transient(key, on, &why_once(open.as_deref()));
            self.notes.extend(note.map(|note| note.file(path)));
        }
        Ok(())
    }

    /// Refuses a step without a set. Where rows are missing, the error is at the last row before them.
    fn check_step(&self, step: &Step, on: &OnMesh<'_>, path: &Path) -> Result<()> {
        let (Some(key), None) = (self.key, self.find(step)) else {
            return Ok(());
        };
        let Some(at) = Clock::place(key, step, self.offset) else {
            return Err(on.error("surface", NO_TIME));
        };
        let before = self.places.partition_point(|place| *place < at);
        let message = format!(
            "there are no rows for {} (step {}); every step needs rows of its own, and the file has them from \
             {} to {}",
            key.place(at),
            step.index,
            key.place(self.places[0]),
            key.place(self.places[self.places.len() - 1])
        );
        let line = self.lines[before.saturating_sub(1)];
        Err(Error::input(message).line(line).file(path))
    }

    /// Returns the set nearest to a position, if it is close enough.
    fn nearest(&self, at: f64) -> Option<usize> {
        let after = self.places.partition_point(|place| *place < at);
        let beside = after.saturating_sub(1)..(after + 1).min(self.places.len());
        let off = |set: &usize| (self.places[*set] - at).abs();
        let nearest = beside.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= self.slack(nearest, at)).then_some(nearest)
    }

    /// Returns the set nearest to a position, up to whole turns, if it is close enough.
    fn nearest_turned(&self, at: f64, turn: f64) -> Option<usize> {
        let off = |set: &usize| {
            let off = (self.places[*set] - at).rem_euclid(turn);
            off.min(turn - off)
        };
        let nearest = (0..self.places.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(&nearest) <= self.slack(nearest, at)).then_some(nearest)
    }

    /// Returns the allowed offset of a set from a position.
    fn slack(&self, set: usize, at: f64) -> f64 {
        let place = self.places[set];
        let before = set.checked_sub(1).map(|before| place - self.places[before]);
        let after = self.places.get(set + 1).map(|after| after - place);
        let spacing = before.into_iter().chain(after).reduce(f64::min);
        SAME * spacing.unwrap_or(place.abs()) + ROUND_OFF * at.abs()
    }

    /// Velocities at a step: the slope between the neighbouring sets or, where sets belong to steps, between the sets
    /// of the neighbouring steps in time; one-sided at an end.
    fn rates(&self, step: &Step, clock: &Clock<'_>) -> Vec<Vector> {
        let (from, to, rate) = self.slope(step, clock).unwrap_or((0, 0, 0.0));
        let pairs = self.sets[from].iter().zip(&self.sets[to]);
        pairs
            .map(|(from, to)| scale(sub(*to, *from), rate))
            .collect()
    }

    /// Returns two sets, and the factor of their difference; `None` if there is no other set.
    fn slope(&self, step: &Step, clock: &Clock<'_>) -> Option<(usize, usize, f64)> {
        let key = self.key?;
        if key == Key::Step {
            let [before, after] = clock.beside(step).map(|step| &clock.steps[step]);
            let seconds = after.time_s? - before.time_s?;
            let sets = (self.find(before)?, self.find(after)?);
            return (seconds > 0.0).then_some((sets.0, sets.1, 1.0 / seconds));
        }
        let [before, after] = self.beside(self.find(step)?);
        let way = after.1 - before.1;
        (way > 0.0).then(|| (before.0, after.0, clock.rate(key, step) / way))
    }

    /// Returns the sets before and after one, with their positions; across the end of the period if the sets are
    /// periodic. At an end it is the set itself.
    fn beside(&self, set: usize) -> [(usize, f64); 2] {
        let places = &self.places;
        let last = places.len() - 1;
        let period = self.period.as_ref();
        let (n, period) = period.map_or((0, 0.0), |period| (period.n_rows, period.length));
        let before = match set {
            0 if n > 0 => (n - 1, places[n - 1] - period),
            _ => (set.saturating_sub(1), places[set.saturating_sub(1)]),
        };
        let after = match set {
            _ if set < last => (set + 1, places[set + 1]),
            _ if n > 0 => ((last + 1) % n, places[(last + 1) % n] + period),
            _ => (last, places[last]),
        };
        [before, after]
    }
}

/// Returns whether the last set differs from the first.
fn last_differs(sets: &[Vec<Vector>]) -> bool {
    let numbers = |set: usize| sets[set].as_flattened().iter();
    let largest = sets
        .iter()
        .flat_map(|set| set.as_flattened())
        .fold(0.0, |most, x| f64::max(most, x.abs()));
    let mut pairs = numbers(0).zip(numbers(sets.len() - 1));
    pairs.any(|(first, last)| (last - first).abs() > REPEATED * largest)
}
