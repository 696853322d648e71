//! The steps of a schedule: their azimuths and times.

use super::keys::{Keys, Kind, keys, number, positive};
use super::places::Places;
use super::reader::{AngleUnit, Entry, Section};
use super::rotor::{Rotor, RotorInTime};
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::{named_step, short};
use azimesh_core::{Note, note};
use serde_json::json;
use std::f64::consts::TAU;
use std::fmt;

/// Largest number of steps of a schedule.
pub const MAX_STEPS: usize = 1_000_000;

/// A step that ends within this part of a step of `stop` counts as landing on it.
const LANDING: f64 = 1e-6;

/// One step of the schedule.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Schedule, Steps};
///
/// let steps = Schedule::new(Steps::azimuths_deg([0.0, 30.0])).steps()?;
/// assert_eq!((steps[1].index(), steps[1].azimuth_deg(), steps[1].time_s()), (1, Some(30.0), None));
/// assert_eq!(steps[1].to_string(), "step 1 (azimuth 30 degrees)");
/// # Ok::<(), azimesh::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Zero-based index in the whole schedule.
    pub(crate) index: usize,
    /// Azimuth in degrees; 0 where the schedule has none.
    pub(crate) azimuth_deg: f64,
    /// Azimuth in radians.
    #[doc(hidden)]
    pub azimuth: f64,
    /// Time in seconds, where `rpm` or `[time]` gives it.
    pub(crate) time_s: Option<f64>,
    /// True if the schedule has an azimuth: false for times with neither a frequency nor a table of the azimuth.
    pub(crate) has_azimuth: bool,
    /// Rate of the azimuth, in radians per second, if the schedule gives it.
    pub(crate) azimuth_rate: Option<f64>,
}

impl Step {
    /// Zero-based index in the whole schedule.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Azimuth in degrees; `None` if the schedule has times without a frequency.
    pub fn azimuth_deg(&self) -> Option<f64> {
        self.has_azimuth.then_some(self.azimuth_deg)
    }

    /// Time in seconds; `None` if the schedule has azimuths and the rotor no revolutions per minute.
    pub fn time_s(&self) -> Option<f64> {
        self.time_s
    }

    /// Time for viewers: in seconds if that is known, else the azimuth in degrees, else the number of the step.
    pub fn time(&self) -> f64 {
        let azimuth = self.azimuth_deg().unwrap_or(self.index as f64);
        self.time_s.unwrap_or(azimuth)
    }
}

/// As in `step 3 (azimuth 30 degrees)`.
impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&named_step(self.index, self.azimuth_deg(), self.time_s))
    }
}

/// The steps of a schedule as declared: azimuths, or times.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::Steps;
///
/// let revolution = Steps::azimuth_deg(0.0, 360.0, 10.0); // 37 steps, 360 included
/// let listed = Steps::azimuths_deg([0.0, 30.0, 90.0]);
/// let second = Steps::time_s(0.0, 1.0, 0.05).frequency_hz(2.0); // azimuth = 360 * 2 * time
/// ```
#[derive(Debug, Clone)]
pub struct Steps {
    values: Values,
    of: Of,
    /// Revolutions per second, of times.
    frequency: Option<f64>,
}

#[derive(Debug, Clone)]
enum Values {
    Range { start: f64, stop: f64, step: f64 },
    Listed(Vec<f64>),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Of {
    Azimuth(AngleUnit),
    Time,
    /// Neither.
    Number,
}

impl Steps {
    /// Creates azimuths in degrees from `start` by `step`; `stop` is the last if a step lands on it.
    pub fn azimuth_deg(start: f64, stop: f64, step: f64) -> Self {
        Self::new(
            Values::Range { start, stop, step },
            Of::Azimuth(AngleUnit::Degrees),
        )
    }

    /// Creates steps at these azimuths in degrees, in any order.
    pub fn azimuths_deg(values: impl IntoIterator<Item = f64>) -> Self {
        let values = Values::Listed(values.into_iter().collect());
        Self::new(values, Of::Azimuth(AngleUnit::Degrees))
    }

    /// Creates times in seconds from `start` by `step`; `stop` is the last if a step lands on it.
    pub fn time_s(start: f64, stop: f64, step: f64) -> Self {
        Self::new(Values::Range { start, stop, step }, Of::Time)
    }

    /// Creates steps at these times in seconds, in any order.
    pub fn times_s(values: impl IntoIterator<Item = f64>) -> Self {
        Self::new(Values::Listed(values.into_iter().collect()), Of::Time)
    }

    /// Creates steps 0 to `last`, without azimuths and times.
    pub fn numbered(last: usize) -> Self {
        let (start, stop, step) = (0.0, last as f64, 1.0);
        Self::new(Values::Range { start, stop, step }, Of::Number)
    }

    /// Sets the revolutions per second, which give times an azimuth of `360 frequency time` degrees.
    #[must_use]
    pub fn frequency_hz(mut self, frequency: f64) -> Self {
        self.frequency = Some(frequency);
        self
    }

    fn new(values: Values, of: Of) -> Self {
        Self {
            values,
            of,
            frequency: None,
        }
    }

    /// Reads `[azimuth]` or `[time]`; exactly one of them must be present.
    pub(super) fn read(root: &Section<'_>) -> Result<Self> {
        let (azimuth, time) = (root.get("azimuth"), root.get("time"));
        if let Some(number) = root.get("steps") {
            return match azimuth.or(time) {
                None => number.count().map(Self::numbered),
                Some(other) => {
                    Err(other.error("and `steps` both define the steps; keep one of them"))
                }
            };
        }
        match (azimuth, time) {
            (Some(azimuth), None) => {
                let values = Values::read(&Azimuths::section(&azimuth)?)?;
                Ok(Self::new(values, Of::Azimuth(azimuth.unit())))
            }
            (None, Some(time)) => {
                let section = Times::section(&time)?;
                let frequency = section.optional("frequency", Entry::positive)?;
                Ok(Self {
                    frequency,
                    ..Self::new(Values::read(&section)?, Of::Time)
                })
            }
            (Some(_), Some(time)) => {
                Err(time.error("and [azimuth] both define the steps; keep one of them"))
            }
            (None, None) => Err(Error::input(
                "the schedule has no steps; give it [azimuth] or [time] with start, stop and step, or with values, or `steps`, the number of the last step",
            )),
        }
    }

    /// Returns the section of a schedule that defines them.
    pub(super) fn section(&self) -> &'static str {
        match self.of {
            Of::Azimuth(_) => "azimuth",
            Of::Time => "time",
            Of::Number => "steps",
        }
    }

    /// Returns whether they are times without an azimuth.
    pub(super) fn has_no_azimuth(&self, rotor: &Rotor) -> bool {
        let has_none = self.frequency.is_none() && !rotor.turns_in_time();
        self.of == Of::Number || self.of == Of::Time && has_none
    }

    /// Returns the steps, at least one. `rpm` of the first rotor gives azimuths their times; `rpm` or the table gives times
    /// their azimuths, which are 0 without either.
    pub(super) fn steps(&self, first: &RotorInTime<'_>, places: &Places) -> Result<Vec<Step>> {
        let section = self.section();
        let rotor = first.rotor;
        let values = self.values.all(section, places)?;
        if let (Of::Number, Some(_)) = (self.of, rotor.rpm) {
            let message =
                "`rpm` gives azimuths their times; give the steps as [azimuth], not as `steps`";
            return Err(first.places.error("rpm", message));
        }
        if let (Of::Azimuth(_) | Of::Number, Some(_)) = (self.of, self.frequency) {
            let message = "`frequency` is for steps in time; for azimuths give `rpm` in [rotor]";
            return Err(places.error(section, message));
        }
        if let Some(frequency) = self.frequency {
            places.positive("time.frequency", frequency)?;
        }
        self.check_azimuth(first)?;
        let step = |(index, value)| self.step(index, value, first);
        let steps: Result<Vec<Step>> = values.into_iter().enumerate().map(step).collect();
        let steps = steps?;
        let no_time = |step: &&Step| step.time_s.is_some_and(|time| !time.is_finite());
        if let Some(step) = steps.iter().find(no_time) {
            let message = format!(
                "`{section}` with this `rpm` gives step {} a time that is not finite",
                step.index
            );
            return Err(places.error(section, message));
        }
        if let Some(step) = steps.iter().find(|step| !step.azimuth.is_finite()) {
            let message = format!(
                "`frequency` is so large that the azimuth of step {} is not finite",
                step.index
            );
            return Err(places.error("time.frequency", message));
        }
        Ok(steps)
    }

    /// Refuses a second definition of the azimuth.
    fn check_azimuth(&self, first: &RotorInTime<'_>) -> Result<()> {
        let has_table = first.rotor.azimuth_table.is_some();
        let (key, message) = match (self.of, self.frequency, first.rotor.rpm) {
            (Of::Azimuth(_) | Of::Number, _, _) if has_table => (
                "azimuth_table",
                "`azimuth_table` gives times their azimuths; give the steps as [time], not as [azimuth]",
            ),
            (Of::Time, Some(_), _) if has_table => (
                "azimuth_table",
                "`azimuth_table` and `frequency` in [time] both define the azimuth; keep one of them",
            ),
            (Of::Time, _, Some(_)) if has_table => (
                "rpm",
                "`rpm` and `azimuth_table` both define the azimuth; keep one of them",
            ),
            (Of::Time, Some(_), Some(_)) => (
                "rpm",
                "`rpm` and `frequency` in [time] both define the azimuth; keep one of them",
            ),
            _ => return Ok(()),
        };
        Err(first.places.error(key, message))
    }

    fn step(&self, index: usize, value: f64, first: &RotorInTime<'_>) -> Result<Step> {
        let rpm = first.rotor.rpm;
        let (azimuth_deg, azimuth, azimuth_rate, time_s) = match self.of {
            Of::Azimuth(unit) => {
                let degrees = unit.to_degrees(value);
                let time = rpm.map(|rpm| degrees / (6.0 * rpm));
                let rate = rpm.map(|rpm| (6.0 * rpm).to_radians());
                (degrees, unit.to_radians(value), rate, time)
            }
            Of::Number => (0.0, 0.0, None, None),
            Of::Time => match (first.azimuth_at(value)?, self.frequency) {
                (Some([degrees, radians, rate]), _) => (degrees, radians, Some(rate), Some(value)),
                (None, Some(frequency)) => {
                    let degrees = 360.0 * frequency * value;
                    let rate = TAU * frequency;
                    (degrees, degrees.to_radians(), Some(rate), Some(value))
                }
                (None, None) => (0.0, 0.0, None, Some(value)),
            },
        };
        Ok(Step {
            index,
            azimuth_deg,
            azimuth,
            time_s,
            has_azimuth: !self.has_no_azimuth(first.rotor),
            azimuth_rate,
        })
    }

    /// Returns a note if the last step is not at `stop`.
    pub(super) fn short_of_stop(&self) -> Option<Note> {
        let Values::Range { stop, step, .. } = self.values else {
            return None;
        };
        let last = *self.values.all("", &Places::default()).ok()?.last()?;
        (last != stop).then(|| {
            note!(
                "short_of_stop",
                "the last step is at {}; `stop` = {} is not reached, since it is not a whole number of steps of {} from \
                 the first",
                short(last),
                short(stop),
                short(step)
            )
        })
    }
}

/// Keys of `[azimuth]`.
pub(super) struct Azimuths;

/// Keys of `[time]`.
pub(super) struct Times;

keys! { impl Azimuths "[azimuth]" = Self, {
    /// first azimuth
    start, number("angle"), default 0;
    /// last azimuth; included if the steps land on it, to a millionth of a step; a note says if they do not
    stop, number("angle"), or "required";
    /// not 0; negative when `stop` is less than `start`
    step, number("angle"), or "required";
    /// in place of these three: the azimuths themselves, in any order
    values, listed("array of angles");
} }

keys! { impl Times "[time]" = Self, {
    /// first time
    start, number("s"), default 0;
    /// last time, as for azimuths
    stop, number("s"), or "required";
    /// not 0
    step, number("s"), or "required";
    /// in place of these three
    values, listed("array of s");
    /// greater than 0; the azimuth is 360 degrees x frequency x time. This, or `rpm` or `azimuth_table` in `[rotor]`, is needed if anything depends on the azimuth: harmonics without their own frequency, tables over azimuth, the inertial frame
    frequency, positive("Hz"), or "none";
} }

/// Any number of numbers.
const fn listed(words: &'static str) -> Kind<Vec<f64>> {
    Kind {
        words,
        read: |entry| {
            let elements = entry.elements("numbers")?;
            elements.iter().map(Entry::number).collect()
        },
        schema: || json!({ "type": "array", "items": { "type": "number" }, "minItems": 1 }),
    }
}

impl Values {
    fn read(section: &Section<'_>) -> Result<Self> {
        let Some(values) = section.get("values") else {
            return Ok(Self::Range {
                start: section.optional("start", Entry::number)?.unwrap_or(0.0),
                stop: section.require("stop", "stop = 360.0")?.number()?,
                step: section.require("step", "step = 10.0")?.number()?,
            });
        };
        for key in ["start", "stop", "step"] {
            if let Some(entry) = section.get(key) {
                return Err(entry.error("and `values` both define the steps; keep one of them"));
            }
        }
        (listed("").read)(&values).map(Self::Listed)
    }

    /// Returns the values one by one: `start`, `start + step`, ... up to `stop`, which is the last if a step lands on it.
    fn all(&self, section: &str, places: &Places) -> Result<Vec<f64>> {
        let at = |key: &str| format!("{section}.{key}");
        let too_many = |key: &str, n: f64| {
            let n = if n.is_finite() {
                short(n.round())
            } else {
                "too many".to_owned()
            };
            let message = format!("`{key}` gives {n} steps; at most {MAX_STEPS} are possible");
            places.error(&at(key), message)
        };
        let (start, stop, step) = match self {
            Self::Range { start, stop, step } => (*start, *stop, *step),
            Self::Listed(values) if values.is_empty() => {
                let message = "`values` is empty: the schedule has no steps; give at least one";
                return Err(places.error(&at("values"), message));
            }
            Self::Listed(values) if values.len() > MAX_STEPS => {
                return Err(too_many("values", values.len() as f64));
            }
            Self::Listed(values) => {
                let wrong = values.iter().find(|x| !x.is_finite());
                let number = wrong.copied().unwrap_or(0.0);
                places.finite(&at("values"), &[number])?;
                return Ok(values.clone());
            }
        };
        places.finite(&at("start"), &[start])?;
        places.finite(&at("stop"), &[stop])?;
        places.finite(&at("step"), &[step])?;
        if step == 0.0 {
            let message =
                "`step` is 0: the schedule would never reach `stop`; give a step other than 0";
            return Err(places.error(&at("step"), message));
        }
        let intervals = (stop - start) / step;
        if !intervals.is_finite() || intervals + 1.0 > MAX_STEPS as f64 {
            return Err(too_many("step", intervals + 1.0));
        }
        if intervals < -LANDING {
            let message = format!(
                "`step` leads away from `stop` ({} from {} by {}): the schedule has no steps; reverse its sign",
                short(stop),
                short(start),
                short(step)
            );
            return Err(places.error(&at("step"), message));
        }
        let last = (intervals + LANDING).floor();
        let lands = last > 0.0 && (intervals - last).abs() <= LANDING;
        let steps = 0..=last as usize;
        let mut values: Vec<f64> = steps.map(|i| at_step(start, step, i)).collect();
        if lands && let Some(value) = values.last_mut() {
            *value = stop;
        }
        Ok(values)
    }
}

/// Returns `start + i step` in decimal arithmetic: 0.1 three times is 0.3. With more digits than a double has, the
/// sum is in double precision.
fn at_step(start: f64, step: f64, i: usize) -> f64 {
    let decimals = |x: f64| {
        x.to_string()
            .split_once('.')
            .map_or(0, |(_, rest)| rest.len())
    };
    let n = decimals(start).max(decimals(step));
    // Whole numbers up to these are exact, and so is their rounded ratio.
    let (scale, most) = (10_f64.powi(n.min(22) as i32), 2_f64.powi(53));
    let [first, by] = [start, step].map(|x| (x * scale).round());
    let whole = first + i as f64 * by;
    let is_exact = [first, i as f64 * by, whole].iter().all(|x| x.abs() < most);
    if n <= 22 && is_exact {
        whole / scale
    } else {
        start + i as f64 * step
    }
}

/// Returns for each step the steps with the next smaller and the next larger time, or itself if there is none;
/// without times, its neighbours in the schedule.
pub(super) fn neighbours(steps: &[Step]) -> Vec<[u32; 2]> {
    let time = |step: usize| steps[step].time_s.unwrap_or(step as f64);
    let mut order: Vec<u32> = (0..steps.len() as u32).collect();
    order.sort_by(|a, b| time(*a as usize).total_cmp(&time(*b as usize)));
    let beside = |step: usize| {
        let own = time(step);
        let from = order.partition_point(|other| time(*other as usize) < own);
        let to = order.partition_point(|other| time(*other as usize) <= own);
        let before = from.checked_sub(1).map(|at| order[at]);
        [before, order.get(to).copied()].map(|other| other.unwrap_or(step as u32))
    };
    (0..steps.len()).map(beside).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Schedule;

    #[test]
    fn numbered_steps_have_no_azimuth_and_no_time() {
        let steps = Schedule::new(Steps::numbered(4)).steps().expect("five");
        assert_eq!((steps.len(), steps[4].time()), (5, 4.0));
        assert_eq!((steps[4].azimuth_deg(), steps[4].time_s()), (None, None));
        assert_eq!(steps[4].to_string(), "step 4");
    }

    #[test]
    fn steps_of_a_range_are_decimals() {
        let range = |start, step| move |i| at_step(start, step, i);
        let found: Vec<f64> = (0..4).map(range(0.0, 0.1)).collect();
        assert_eq!(found, [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(range(-0.7, 0.1)(10), 0.3);
        assert_eq!(range(1.0, 1e-9)(3), 1.000_000_003);
        assert_eq!(range(10.0, 1e8)(3), 300_000_010.0);
        // Not decimals of a few digits.
        let (start, step) = (0.1, std::f64::consts::PI);
        assert_eq!(range(start, step)(7), start + 7.0 * step);
        assert_eq!(range(0.0, 1e300)(2), 2e300);
        assert_eq!(range(0.0, 1e-300)(2), 2e-300);
    }

    #[test]
    fn a_step_beyond_the_stop_leaves_the_start_alone() {
        for (stop, step) in [(10.0, 1e300), (10.0, 1e8), (-10.0, -1e300)] {
            let steps = Steps::azimuth_deg(3.0, 3.0 + stop, step);
            let found = Schedule::new(steps.clone()).steps().expect("there is one");
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].azimuth_deg(), Some(3.0));
            let note = steps.short_of_stop().expect("it is not reached");
            assert!(
                note.to_string()
                    .contains("the last step is at 3; `stop` = "),
                "{note}"
            );
        }
        let one = Steps::azimuth_deg(3.0, 3.0, 1.0);
        assert_eq!(one.short_of_stop(), None);
    }
}
