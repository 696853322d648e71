//! Where an option of a schedule was given: its line in a file, or in words where it was given in memory.

use azimesh_core::error::{Error, Position};
use std::collections::BTreeMap;

/// The places of the options of a schedule or of a body.
#[derive(Debug, Clone, Default)]
pub(super) struct Places {
    /// What has the options, in words; of a schedule nothing, its sections have names.
    item: String,
    /// Lines by key; empty where there is no file.
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

    /// The place of a key such as `rbf.substeps`, or of the table it would be in.
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

    /// The first line of some keys; the place of the first key where none is given.
    pub fn first_of(&self, keys: &[&str]) -> Option<Position> {
        let lines = keys.iter().filter_map(|key| self.lines.get(*key));
        let first = lines.min().map(|line| Position::Line(*line));
        first.or_else(|| self.of(keys[0]))
    }

    /// An error at the place of a key.
    pub fn error(&self, key: &str, message: impl Into<String>) -> Error {
        Error::input(message).at(self.of(key))
    }
}
