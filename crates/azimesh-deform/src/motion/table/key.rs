//! Keys of the rows of a table: azimuths, times or steps.

use crate::motion::Step;
use azimesh_core::numbers::in_digits;
use std::f64::consts::TAU;

/// Quantity in the first column of a table over the steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// Azimuth in degrees.
    AzimuthDeg,
    /// Azimuth in radians.
    AzimuthRad,
    /// Time in seconds.
    Time,
    /// Zero-based number of the step in the schedule.
    Step,
}

impl Key {
    /// All keys.
    pub const ALL: [Self; 4] = [Self::AzimuthDeg, Self::AzimuthRad, Self::Time, Self::Step];

    /// The column's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::AzimuthDeg => "azimuth_deg",
            Self::AzimuthRad => "azimuth_rad",
            Self::Time => "time_s",
            Self::Step => "step",
        }
    }

    /// Returns one revolution in the column's unit; times and steps have none.
    pub fn revolution(self) -> Option<f64> {
        match self {
            Self::AzimuthDeg => Some(360.0),
            Self::AzimuthRad => Some(TAU),
            Self::Time | Self::Step => None,
        }
    }

    /// Returns the position of a step in the column's unit; `None` for the time of a step that has none.
    pub fn of_step(self, step: &Step) -> Option<f64> {
        match self {
            Self::AzimuthDeg => Some(step.azimuth_deg),
            Self::AzimuthRad => Some(step.azimuth),
            Self::Time => step.time_s,
            Self::Step => Some(step.index as f64),
        }
    }

    /// Formats a position, as in "azimuth 30 deg".
    pub fn place(self, at: f64) -> String {
        match self {
            Self::AzimuthDeg => format!("azimuth {} deg", in_digits(at, 12)),
            Self::AzimuthRad => format!("azimuth {} rad", in_digits(at, 12)),
            Self::Time => format!("time {} s", in_digits(at, 12)),
            Self::Step => format!("step {at}"),
        }
    }
}
