//! The key of a table (azimuth, time or step) at a step of the schedule, and its rate of change.

use super::{At, OnMesh};
use crate::motion::steps::Step;
use crate::motion::table::{History, Key};
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::in_digits;
use azimesh_core::{Note, note};

/// Error message for a table over time in a schedule without times.
pub(super) const NO_TIME: &str = "the table has the column `time_s`, but the steps have no time; give the \
                                  schedule [time], or `rpm` in [rotor]";

/// A range is a small part of another if their ratio is below this.
const SMALL_PART: f64 = 0.02;

/// The promise behind `expect` on values at a step.
const PROMISE: &str = "the history was checked at every step";

/// The steps of a schedule, with their neighbours in time.
#[derive(Debug, Clone, Copy)]
pub(in crate::motion) struct Clock<'a> {
    /// The steps.
    pub steps: &'a [Step],
    /// Neighbours in time of each step.
    pub neighbours: &'a [[u32; 2]],
}

impl Clock<'_> {
    /// Returns the position of a body with this azimuth offset (radians) at a step, in the unit of the key. The
    /// offset shifts azimuths only: times and steps are the same for every body.
    pub fn place(key: Key, step: &Step, offset: f64) -> Option<f64> {
        let at = key.of_step(step)?;
        Some(match key {
            Key::AzimuthDeg => at + offset.to_degrees(),
            Key::AzimuthRad => at + offset,
            Key::Time | Key::Step => at,
        })
    }

    /// Returns the rate per second of a history's key at a step; 0 if the schedule has no time. For a linear history
    /// over steps, whose rates follow a row, it is the rate from this step to the next.
    pub fn rate_in(&self, history: &History, step: &Step) -> f64 {
        match history.key() {
            Key::Step if history.is_linear() => {
                let [before, after] = self.beside(step);
                let from = if after == step.index {
                    before
                } else {
                    step.index
                };
                self.steps_between(from, after)
            }
            key => self.rate(key, step),
        }
    }

    /// Returns the rate per second of the key at a step; 0 if the schedule has no time.
    pub fn rate(&self, key: Key, step: &Step) -> f64 {
        match key {
            Key::AzimuthDeg => step.azimuth_rate.unwrap_or(0.0).to_degrees(),
            Key::AzimuthRad => step.azimuth_rate.unwrap_or(0.0),
            Key::Time => 1.0,
            Key::Step => self.steps_a_second(step),
        }
    }

    /// Returns the neighbours of a step in time, before and after; the step itself at an end.
    pub fn beside(&self, step: &Step) -> [usize; 2] {
        self.neighbours[step.index].map(|step| step as usize)
    }

    /// Returns steps per second, between the neighbours of a step in time; 0 if the schedule has no time.
    pub fn steps_a_second(&self, step: &Step) -> f64 {
        let [from, to] = self.beside(step);
        self.steps_between(from, to)
    }

    fn steps_between(&self, from: usize, to: usize) -> f64 {
        match [from, to].map(|step| self.steps[step].time_s) {
            [Some(before), Some(after)] if after != before => {
                (to as f64 - from as f64) / (after - before)
            }
            _ => 0.0,
        }
    }

    /// Returns the azimuth (radians) by which a body is ahead in a history. A periodic table over azimuth has a row for
    /// every azimuth of a blade. Any other table describes events at azimuths of the rotor, the same for every body.
    pub fn offset(history: &History, on: &OnMesh<'_>) -> f64 {
        if history.repeats() { on.offset } else { 0.0 }
    }

    /// Refuses a history without values at some step; `place` is the key of its motion in the schedule. Returns a note
    /// if the body has an azimuth offset that the history does not follow, or if a step is past its last row.
    pub fn check(&self, history: &History, on: &OnMesh<'_>, place: &str) -> Result<Option<Note>> {
        let key = history.key();
        self.check_azimuth(key, on, place)?;
        let offset = Self::offset(history, on);
        let places = self.steps.iter().map(|step| Self::place(key, step, offset));
        let Some(places) = places.collect::<Option<Vec<f64>>>() else {
            return Err(on.error(place, NO_TIME));
        };
        let ranges = Ranges::of(history, &places);
        let mut past_last_row = None;
        for (step, at) in self.steps.iter().zip(&places) {
            let found = history.locate(*at);
            let found = found.map_err(|error| ranges.explain(error, place))?;
            if history.is_past_last_row(found) {
                past_last_row.get_or_insert(step);
            }
        }
        if let Some(small) = ranges.small_part(&on.body.name, place) {
            on.warn(small.file(history.path()));
        }
        let file = |note: Note| note.file(history.path());
        if !history.repeats() {
            return Ok(transient(key, on, &history.why_once()).map(file));
        }
        let closed = past_last_row.map(|step| {
            let (first, last) = history.range();
            note!(
                "closed_by_step",
                "body \"{}\": the table goes from {} to {}, one step before {}, and so repeats itself; the values of step {} \
                 are between its last and its first row",
                on.body.name,
                key.place(first),
                key.place(last),
                key.place(history.end()),
                step.index
            )
        });
        Ok(closed.map(file))
    }

    /// Refuses azimuth as a key where steps have none.
    pub fn check_azimuth(&self, key: Key, on: &OnMesh<'_>, place: &str) -> Result<()> {
        if key.revolution().is_none() || self.steps.iter().all(|step| step.has_azimuth) {
            return Ok(());
        }
        let message = format!(
            "the table has the column `{}`, but [time] has no `frequency` that gives an azimuth; add for \
             example  frequency = 2.0, or `azimuth_table` in [rotor], or give the table the column `time_s`",
            key.name()
        );
        Err(on.error(place, message))
    }
}

/// Ranges of the rows of a history and of the steps.
struct Ranges {
    key: Key,
    repeats: bool,
    rows: [f64; 2],
    steps: [f64; 2],
}

impl Ranges {
    fn of(history: &History, places: &[f64]) -> Self {
        let places = places.iter().copied();
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        Self {
            key: history.key(),
            repeats: history.repeats(),
            rows: history.range().into(),
            steps: places.fold(ends, |[low, high], at| [low.min(at), high.max(at)]),
        }
    }

    /// Returns the ratio of the first range to the second, if it is small.
    fn part([low, high]: [f64; 2], of: [f64; 2]) -> Option<f64> {
        let part = (high - low) / (of[1] - of[0]);
        (0.0 < part && part < SMALL_PART).then_some(part)
    }

    /// Returns a warning if the steps need a small part of the rows.
    fn small_part(&self, body: &str, place: &str) -> Option<Note> {
        let part = Self::part(self.steps, self.rows).filter(|_| !self.repeats)?;
        let [first, last] = self.rows.map(|at| self.key.place(at));
        let [from, to] = self.steps.map(|at| self.key.place(at));
        Some(note!(
            "small_part",
            "body \"{body}\": the steps go from {from} to {to}, which is {}% of the table, which goes from {first} to {last}{}",
            in_digits(100.0 * part, 2),
            self.remedy(place, true)
        ))
    }

    /// Adds a sentence to the error of a step without rows, if the table covers a small part of the steps.
    fn explain(&self, mut error: Error, place: &str) -> Error {
        if let Some(part) = Self::part(self.rows, self.steps) {
            let [from, to] = self.steps.map(|at| self.key.place(at));
            error.message += &format!(
                "; it covers {}% of the steps, which go from {from} to {to}{}",
                in_digits(100.0 * part, 2),
                self.remedy(place, false)
            );
        }
        error
    }

    /// Returns the likely remedy where the range of the rows is larger, or the range of the steps.
    fn remedy(&self, place: &str, of_rows: bool) -> String {
        let unit = if of_rows { "ms" } else { "min" };
        let motion = place.split('.').next().unwrap_or(place);
        match self.key {
            Key::Time if ["table", "beam"].contains(&motion) || place == "cyclic.table" => {
                format!(
                    "; if its times are not in s, write for example  units = {{ time_s = \"{unit}\" }}"
                )
            }
            Key::Time => "; times are in s".to_owned(),
            Key::AzimuthDeg if !of_rows => {
                "; azimuths in radians need the name `azimuth_rad`".to_owned()
            }
            _ => String::new(),
        }
    }
}

/// Returns a note if a body has an azimuth offset that its rows over azimuth, not being periodic, do not follow.
pub(super) fn transient(key: Key, on: &OnMesh<'_>, why: &str) -> Option<Note> {
    let differs = key.revolution().is_some() && on.offset != 0.0;
    differs.then(|| {
        note!(
            "transient",
            "body \"{}\": the table does not repeat itself ({why}), so it is taken at the azimuth of the rotor; \
             azimuth_offset = {} turns the axes of the blade, and shifts harmonics and tables that repeat themselves",
            on.body.name,
            in_digits(on.offset.to_degrees(), 6)
        )
    })
}

/// The history of a body, with values at every step.
#[derive(Debug)]
pub(super) struct StepHistory {
    history: History,
    offset: f64,
    /// Note for the user.
    pub note: Option<Note>,
}

impl StepHistory {
    /// Refuses a history without values at some step; `place` is the key of its motion in the schedule.
    pub fn new(history: History, on: &OnMesh<'_>, place: &str) -> Result<Self> {
        Ok(Self {
            note: on.clock.check(&history, on, place)?,
            offset: Clock::offset(&history, on),
            history,
        })
    }

    fn place(&self, step: &Step) -> f64 {
        Clock::place(self.history.key(), step, self.offset).expect(PROMISE)
    }

    /// Returns the values at a step.
    pub fn values(&self, step: &Step) -> Vec<f64> {
        self.history.at(self.place(step)).expect(PROMISE)
    }

    /// Returns the rates of the values per second; 0 if the schedule has no time.
    pub fn rates(&self, at: &At<'_>) -> Vec<f64> {
        let each = at.clock.rate_in(&self.history, at.step);
        let rates = self.history.rates_at(self.place(at.step)).expect(PROMISE);
        rates.into_iter().map(|rate| each * rate).collect()
    }
}
