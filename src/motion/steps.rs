//! The steps of a schedule: which azimuths, and when.

use super::reader::{AngleUnit, Entry, Keys, Section};
use crate::error::Result;
use std::f64::consts::TAU;

/// Steps a schedule may have at most.
pub const MAX_STEPS: usize = 1_000_000;

/// A step whose end is this part of a step past `stop` or before it counts as landing on it.
const LANDING: f64 = 1e-6;
/// Numbers from here on are shown with an exponent.
const LONG: f64 = 1e16;

const AZIMUTH: Keys = Keys {
    known: &["start", "stop", "step", "values"],
    later: &[],
};
const TIME: Keys = Keys {
    known: &["start", "stop", "step", "values", "frequency"],
    later: &[],
};

/// One step of the schedule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Zero-based place in the whole schedule.
    pub index: usize,
    /// Azimuth in degrees.
    pub azimuth_deg: f64,
    /// Azimuth in radians.
    pub azimuth: f64,
    /// Time in seconds, where `rpm` or `[time]` gives it.
    pub time_s: Option<f64>,
}

impl Step {
    /// The time that viewers are told: in seconds where that is known, else the azimuth in degrees.
    pub fn time(&self) -> f64 {
        self.time_s.unwrap_or(self.azimuth_deg)
    }
}

/// The steps of `[azimuth]`; `rpm` in revolutions a minute gives each its time.
pub(super) fn from_azimuth(
    entry: &Entry<'_>,
    unit: AngleUnit,
    rpm: Option<f64>,
) -> Result<Vec<Step>> {
    let section = entry.section("[azimuth]", &AZIMUTH)?;
    let azimuths = match section.get("values") {
        Some(values) => listed(&section, &values)?,
        None => range(&section)?,
    };
    let step = |(index, azimuth): (usize, f64)| {
        let azimuth_deg = unit.to_degrees(azimuth);
        Step {
            index,
            azimuth_deg,
            azimuth: unit.to_radians(azimuth),
            time_s: rpm.map(|rpm| azimuth_deg / (6.0 * rpm)),
        }
    };
    let steps: Vec<Step> = azimuths.into_iter().enumerate().map(step).collect();
    let no_time = |step: &&Step| step.time_s.is_some_and(|time| !time.is_finite());
    if let Some(step) = steps.iter().find(no_time) {
        let message = format!("with this `rpm` gives step {} no time", step.index);
        return Err(entry.error(&message));
    }
    Ok(steps)
}

/// The steps of `[time]` and the rate of the azimuth in radians a second: azimuth = 360 frequency
/// time, in degrees; 0 throughout without a frequency.
pub(super) fn from_time(entry: &Entry<'_>) -> Result<(Vec<Step>, Option<f64>)> {
    let section = entry.section("[time]", &TIME)?;
    let frequency = section
        .get("frequency")
        .map(|frequency| frequency.positive());
    let frequency = frequency.transpose()?;
    let times = match section.get("values") {
        Some(values) => listed(&section, &values)?,
        None => range(&section)?,
    };
    let step = |(index, time): (usize, f64)| {
        let azimuth_deg = frequency.map_or(0.0, |frequency| 360.0 * frequency * time);
        Step {
            index,
            azimuth_deg,
            azimuth: azimuth_deg.to_radians(),
            time_s: Some(time),
        }
    };
    let steps: Vec<Step> = times.into_iter().enumerate().map(step).collect();
    if let Some(step) = steps.iter().find(|step| !step.azimuth.is_finite()) {
        let entry = section.get("frequency").expect("without one it is 0");
        let message = format!("is so large that step {} has no azimuth", step.index);
        return Err(entry.error(&message));
    }
    Ok((steps, frequency.map(|frequency| TAU * frequency)))
}

/// For each step those with the next smaller and the next larger time, itself where there is none;
/// without times those next to it in the schedule.
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

fn listed(section: &Section<'_>, values: &Entry<'_>) -> Result<Vec<f64>> {
    for key in ["start", "stop", "step"] {
        if let Some(entry) = section.get(key) {
            return Err(
                entry.error("and `values` both say which steps there are; keep one of them")
            );
        }
    }
    let elements = values.elements("numbers")?;
    if elements.is_empty() {
        return Err(values.error("is empty: the schedule has no steps; give at least one"));
    }
    if elements.len() > MAX_STEPS {
        return Err(too_many(values, elements.len() as f64));
    }
    elements.iter().map(Entry::number).collect()
}

/// `start`, `start + step`, ... up to `stop`, which is the last when a step lands on it.
fn range(section: &Section<'_>) -> Result<Vec<f64>> {
    let start = section
        .get("start")
        .map_or(Ok(0.0), |entry| entry.number())?;
    let stop_entry = section.require("stop", "stop = 360.0")?;
    let stop = stop_entry.number()?;
    let step_entry = section.require("step", "step = 10.0")?;
    let step = step_entry.number()?;
    if step == 0.0 {
        return Err(step_entry
            .error("is 0: the schedule would never reach `stop`; give a step other than 0"));
    }
    let intervals = (stop - start) / step;
    if !intervals.is_finite() || intervals + 1.0 > MAX_STEPS as f64 {
        return Err(too_many(&step_entry, intervals + 1.0));
    }
    if intervals < -LANDING {
        return Err(step_entry.error(&format!(
            "leads away from `stop` ({} from {} by {}): the schedule has no steps; reverse its sign",
            shown(stop),
            shown(start),
            shown(step)
        )));
    }
    let last = (intervals + LANDING).floor();
    let lands = (intervals - last).abs() <= LANDING;
    let mut values: Vec<f64> = (0..=last as usize)
        .map(|i| start + i as f64 * step)
        .collect();
    if lands && let Some(value) = values.last_mut() {
        *value = stop;
    }
    Ok(values)
}

fn too_many(entry: &Entry<'_>, n: f64) -> crate::error::Error {
    entry.error(&format!(
        "gives {} steps; at most {MAX_STEPS} are possible",
        shown(n.round())
    ))
}

/// A number without hundreds of digits.
fn shown(x: f64) -> String {
    match x.abs() < LONG {
        true => x.to_string(),
        false => format!("{x:.1e}"),
    }
}

/// A sentence where the last step is not at `stop`.
pub(super) fn short_of_stop(entry: &Entry<'_>) -> Option<String> {
    let section = entry.section("steps", &TIME).ok()?;
    let [stop, step] = ["stop", "step"].map(|key| section.get(key)?.number().ok());
    let (stop, step) = (stop?, step?);
    let last = *range(&section).ok()?.last()?;
    (last != stop).then(|| {
        format!(
            "the last step is at {}: `stop` = {} is not a whole number of steps of {} from the first",
            shown(last),
            shown(stop),
            shown(step)
        )
    })
}
