//! An oscillating angle or factor of a translation: harmonics of the azimuth or at a frequency, and a table.

use super::clock::StepHistory;
use super::series::Series;
use super::{At, OnMesh, TableSource};
use crate::motion::places::Places;
use crate::motion::table::{History, Interpolation};
use azimesh_core::Note;
use azimesh_core::error::Result;
use std::f64::consts::TAU;

/// The declaration of a mean, its harmonics and a table.
#[derive(Debug, Clone, Default)]
pub(in crate::motion) struct Oscillation {
    /// Harmonics of `psi`.
    pub series: Series,
    /// In Hz; `psi = 2 pi frequency time` then replaces the azimuth of the body.
    pub frequency: Option<f64>,
    /// Values to add: a column `angle_deg` or `angle_rad`.
    pub table: Option<TableSource>,
    /// Between the rows of the table.
    pub interpolation: Interpolation,
}

impl Oscillation {
    /// Returns whether it needs the azimuth of a step.
    pub fn has_harmonics(&self) -> bool {
        !self.series.harmonics.is_empty() && self.frequency.is_none()
    }

    /// Returns whether it is zero at every step.
    pub fn is_zero(&self) -> bool {
        self.series.is_zero() && self.table.is_none()
    }

    /// Refuses invalid numbers; `key` is its key.
    pub fn check(&self, places: &Places, key: &str) -> Result<()> {
        let Some(frequency) = self.frequency else {
            return Ok(());
        };
        let key = format!("{key}.frequency");
        places.positive(&key, frequency)?;
        if self.series.harmonics.is_empty() {
            let message = "`frequency` belongs to `harmonics`, which are not given; add for example  harmonics = \
                           [ { sin = 10.0 } ]";
            return Err(places.error(&key, message));
        }
        Ok(())
    }

    /// Evaluates it at every step; `key` is its key in the schedule.
    pub(super) fn resolve(&self, on: &OnMesh<'_>, key: &str) -> Result<Swing> {
        let timed = on.clock.steps.iter().all(|step| step.time_s.is_some());
        if self.frequency.is_some() && !timed {
            let message = "`frequency` needs the time of every step; give the schedule [time], or `rpm` in [rotor], or \
                           leave `frequency` out to swing with the azimuth";
            return Err(on.error(&format!("{key}.frequency"), message));
        }
        let table = self.table.as_ref().map(|table| {
            let key = format!("{key}.table");
            let table = table.read(on, &key)?;
            let mut columns = table.columns();
            let place = columns.require_key()?;
            let angle = columns.require_angle("angle")?;
            columns.done()?;
            let history = History::from_table(&table, place, &[angle], self.interpolation)?;
            StepHistory::new(history, on, &key)
        });
        Ok(Swing {
            series: self.series.clone(),
            frequency: self.frequency,
            offset: on.offset,
            table: table.transpose()?,
        })
    }
}

/// An oscillation on the steps of a schedule.
#[derive(Debug)]
pub(super) struct Swing {
    series: Series,
    frequency: Option<f64>,
    offset: f64,
    table: Option<StepHistory>,
}

impl Swing {
    /// Returns the value at a step, and its rate per second:
    ///
    /// ```text
    /// mean + sum_m [ A_m sin(m psi) + B_m cos(m psi) ] + table
    /// ```
    pub fn at(&self, at: &At<'_>) -> [f64; 2] {
        let [psi, psi_rate] = match (self.frequency, at.step.time_s) {
            (Some(frequency), Some(time)) => [TAU * frequency * time, TAU * frequency],
            _ => [
                at.step.azimuth + self.offset,
                at.step.azimuth_rate.unwrap_or(0.0),
            ],
        };
        let [mut value, mut rate] = [
            self.series.at(psi, 0.0),
            self.series.slope(psi, 0.0) * psi_rate,
        ];
        if let Some(table) = &self.table {
            value += table.values(at.step)[0];
            rate += table.rates(at)[0];
        }
        [value, rate]
    }

    /// Note on its table.
    pub fn note(&self) -> Option<Note> {
        self.table.as_ref().and_then(|table| table.note.clone())
    }
}
