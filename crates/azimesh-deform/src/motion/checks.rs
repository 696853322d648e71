//! Checks of numbers, the same for those of a file and those given in memory.

use super::places::Places;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;

/// Largest angle in radians; of one as large a ten-millionth of a turn is left.
pub(super) const MOST_TURNED: f64 = 1e9;

/// Whether a number, in radians, is accepted as an angle.
pub(super) fn is_angle(angle: f64) -> bool {
    angle.abs() <= MOST_TURNED
}

impl Places {
    /// Refuses what is not so: `key` is found to be `found`, and must be `expected`.
    pub fn check(&self, holds: bool, key: &str, found: &str, expected: &str) -> Result<()> {
        if holds {
            return Ok(());
        }
        let name = key.rsplit('.').next().unwrap_or(key);
        Err(self.error(key, format!("`{name}` is {found}; it must be {expected}")))
    }

    /// Refuses a number that is not greater than 0.
    pub fn positive(&self, key: &str, number: f64) -> Result<()> {
        let holds = number > 0.0 && number.is_finite();
        self.check(holds, key, &number.to_string(), "a number greater than 0")
    }

    /// Refuses numbers that are not finite.
    pub fn finite(&self, key: &str, numbers: &[f64]) -> Result<()> {
        let holds = numbers.iter().all(|x| x.is_finite());
        self.check(holds, key, &format!("{numbers:?}"), "finite")
    }

    /// Refuses an angle, in radians, that is no number or has too many turns.
    pub fn angle(&self, key: &str, angle: f64) -> Result<()> {
        let expected = format!("an angle, a finite number of at most {MOST_TURNED:e} radians");
        self.check(
            is_angle(angle),
            key,
            &format!("{angle:e} radians"),
            &expected,
        )
    }

    /// Refuses a direction that has no length.
    pub fn direction(&self, key: &str, direction: Vector) -> Result<()> {
        if direction != [0.0; 3] {
            return Ok(());
        }
        let name = key.rsplit('.').next().unwrap_or(key);
        let message =
            format!("`{name}` has length zero; it must be a direction such as [0.0, 0.0, 1.0]");
        Err(self.error(key, message))
    }
}
