//! The position of an option of a schedule: its line in a file, or words if it was given in memory. Checks of
//! numbers, the same for both.

use azimesh_core::error::{Error, Position, Result};
use azimesh_core::geometry::vector::Vector;
use std::collections::BTreeMap;

/// Largest angle in radians; at this size an angle is resolved to a ten-millionth of a turn.
pub(super) const MOST_TURNED: f64 = 1e9;

/// Returns whether a number, in radians, is accepted as an angle.
pub(super) fn is_angle(angle: f64) -> bool {
    angle.abs() <= MOST_TURNED
}

/// The positions of the options of a schedule or of a body.
#[derive(Debug, Clone, Default)]
pub(super) struct Places {
    /// Owner of the options, in words; empty for a schedule, whose sections have names.
    item: String,
    /// Lines by key; empty for a schedule in memory.
    lines: BTreeMap<String, u64>,
}

impl Places {
    pub fn of_item(item: String) -> Self {
        Self {
            item,
            lines: BTreeMap::new(),
        }
    }

    pub fn add(&mut self, key: String, line: u64) {
        self.lines.insert(key, line);
    }

    /// Returns the places of the options under a key, without that prefix; `item` names their owner.
    pub fn within(&self, key: &str, item: String) -> Self {
        let lines = self.lines.iter().filter_map(|(name, line)| {
            let name = name.strip_prefix(key)?;
            let name = name.strip_prefix('.').or(name.is_empty().then_some(""))?;
            Some((name.to_owned(), *line))
        });
        Self {
            lines: lines.collect(),
            item,
        }
    }

    /// Returns whether a file has this key.
    pub fn of_given(&self, key: &str) -> bool {
        self.lines.contains_key(key)
    }

    /// Returns the position of a key such as `rbf.substeps`, or of the table that would contain it.
    pub fn of(&self, key: &str) -> Option<Position> {
        let above = key.rfind('.').map_or("", |dot| &key[..dot]);
        let section = key.split('.').next().unwrap_or(key);
        match self.item.as_str() {
            _ if !self.lines.is_empty() => {
                let line = [key, above, ""].iter().find_map(|key| self.lines.get(*key));
                line.map(|line| Position::Line(*line))
            }
            "" => Some(Position::Item(section.to_owned())),
            item => Some(Position::Item(item.to_owned())),
        }
    }

    /// Returns the first line of some keys; if none is given, the position of the first key.
    pub fn first_of(&self, keys: &[&str]) -> Option<Position> {
        let lines = keys.iter().filter_map(|key| self.lines.get(*key));
        let first = lines.min().map(|line| Position::Line(*line));
        first.or_else(|| self.of(keys[0]))
    }

    /// Returns an error at the position of a key.
    pub fn error(&self, key: &str, message: impl Into<String>) -> Error {
        Error::input(message).at(self.of(key))
    }

    /// Refuses an invalid value: `key` is `found`, but must be `expected`.
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

    /// Refuses an angle, in radians, that is not finite or has too many turns.
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
