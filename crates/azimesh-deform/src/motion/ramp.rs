//! `ramp` of a body: a smooth start of its motions.

use super::keys::{count, keys, positive};
use super::motions::Clock;
use super::places::Places;
use super::steps::Step;
use azimesh_core::error::Result;

keys! {
    /// A smooth start: the motions of a body times `s^2 (3 - 2 s)`; `s` grows from 0 at the first step to 1 after some
    /// steps or seconds.
    #[derive(Debug, Clone)]
    pub(super) struct Ramp "ramp = { seconds }" {
        /// seconds after the first step at which the whole motion is reached; steps need times
        seconds: Option<f64>, positive("s"), or "none";
        /// or the number of steps until then
        steps: Option<usize>, count("integer, at least 1"), or "none";
    }
}

impl Ramp {
    pub fn of_seconds(seconds: f64) -> Self {
        Self {
            seconds: Some(seconds),
            steps: None,
        }
    }

    pub fn of_steps(steps: usize) -> Self {
        Self {
            seconds: None,
            steps: Some(steps),
        }
    }

    /// Refuses a ramp without a length or with two.
    pub fn check(&self, places: &Places) -> Result<()> {
        if self.seconds.is_some() == self.steps.is_some() {
            let message =
                "`ramp` needs either `seconds` or `steps`, for example  ramp = { seconds = 0.1 }";
            return Err(places.error("ramp", message));
        }
        places.check(self.steps != Some(0), "ramp.steps", "0", "at least 1")?;
        self.seconds
            .map_or(Ok(()), |seconds| places.positive("ramp.seconds", seconds))
    }

    /// Refuses seconds where steps have no times.
    pub fn check_times(&self, steps: &[Step], places: &Places) -> Result<()> {
        if self.seconds.is_none() || steps.iter().all(|step| step.time_s.is_some()) {
            return Ok(());
        }
        let message = "`ramp` has seconds, but the steps have no times; give the schedule [time], or `rpm` in [rotor], or the ramp `steps`";
        Err(places.error("ramp", message))
    }

    /// Returns the part of the motion at a step, and its rate per second.
    pub fn at(&self, step: &Step, clock: &Clock<'_>) -> [f64; 2] {
        let (s, rate) = match self.steps {
            Some(n) => {
                let n = n as f64;
                (step.index as f64 / n, clock.steps_a_second(step) / n)
            }
            None => {
                let times = clock.steps.iter().filter_map(|step| step.time_s);
                let first = times.fold(f64::INFINITY, f64::min);
                let length = self.seconds.unwrap_or(1.0);
                (
                    (step.time_s.unwrap_or(first) - first) / length,
                    1.0 / length,
                )
            }
        };
        let s = s.min(1.0);
        [s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) * rate]
    }
}
