//! The key of a table (azimuth, time or step) at a step of the schedule, and its rate of change.

use super::OnMesh;
use crate::error::Result;
use crate::motion::steps::Step;
use crate::motion::table::{History, Key};

/// The error of a table over time in a schedule without times.
pub(super) const NO_TIME: &str = "the table has the column `time_s`, but the steps have no time; give the \
                                  schedule [time], or `rpm` in [rotor]";

/// The steps of a schedule with what is known of their times.
#[derive(Debug, Clone, Copy)]
pub(in crate::motion) struct Clock<'a> {
    /// The steps.
    pub steps: &'a [Step],
    /// By how much the azimuth grows, in radians a second.
    pub azimuth_rate: Option<f64>,
    /// For each step those next to it in time.
    pub neighbours: &'a [[u32; 2]],
}

impl Clock<'_> {
    /// Where a body with this azimuth offset (radians) is at a step, in the unit of the key. The offset
    /// is one of azimuth: times and steps are the same for every body.
    pub fn place(key: Key, step: &Step, offset: f64) -> Option<f64> {
        let at = key.of_step(step)?;
        Some(match key {
            Key::AzimuthDeg => at + offset.to_degrees(),
            Key::AzimuthRad => at + offset,
            Key::Time | Key::Step => at,
        })
    }

    /// By how much the key grows in a second at a step; 0 where the schedule has no time.
    pub fn rate(&self, key: Key, step: &Step) -> f64 {
        match key {
            Key::AzimuthDeg => self.azimuth_rate.unwrap_or(0.0).to_degrees(),
            Key::AzimuthRad => self.azimuth_rate.unwrap_or(0.0),
            Key::Time => 1.0,
            Key::Step => self.steps_a_second(step),
        }
    }

    /// The steps next to one in time, before and after; the step itself at an end.
    pub fn beside(&self, step: &Step) -> [usize; 2] {
        self.neighbours[step.index].map(|step| step as usize)
    }

    /// Steps a second, between the neighbours of a step in time; 0 where the schedule has no time.
    pub fn steps_a_second(&self, step: &Step) -> f64 {
        let [from, to] = self.beside(step);
        match [from, to].map(|step| self.steps[step].time_s) {
            [Some(before), Some(after)] if after != before => {
                (to as f64 - from as f64) / (after - before)
            }
            _ => 0.0,
        }
    }

    /// Refuses a history that has no values at some step; its motion is under `place` in the schedule.
    pub fn check(&self, history: &History, on: &OnMesh<'_>, place: &str) -> Result<()> {
        let key = history.key();
        let turns = key.revolution().is_some();
        let timed = self.steps.iter().any(|step| step.time_s.is_some());
        if turns && timed && self.azimuth_rate.is_none() {
            let message = format!(
                "the table has the column `{}`, but [time] has no `frequency` that gives an azimuth; add for \
                 example  frequency = 2.0, or give the table the column `time_s`",
                key.name()
            );
            return Err(on.error(place, message));
        }
        for step in self.steps {
            let Some(at) = Self::place(key, step, on.offset) else {
                return Err(on.error(place, NO_TIME));
            };
            history.locate(at)?;
        }
        Ok(())
    }
}
