//! Groups as they are found: the same name in several places is one group.

use super::super::names::Places;
use crate::mesh::{CellSet, Group};
use std::ops::Range;

/// Groups found so far.
#[derive(Default)]
pub(super) struct Tags {
    found: Vec<FoundTag>,
    places: Places<(u8, String)>,
}

struct FoundTag {
    dimension: u8,
    name: String,
    condition: Option<String>,
    cells: Vec<Range<usize>>,
}

impl Tags {
    /// Adds cells of one dimension to the group of this name. Where there is one that has another
    /// boundary condition, `place` is put before the name.
    pub fn add(
        &mut self,
        name: &str,
        place: &str,
        dimension: u8,
        condition: Option<&str>,
        cells: impl IntoIterator<Item = Range<usize>>,
    ) {
        let fits = |found: &FoundTag| {
            let other = found.condition.as_deref();
            other.is_none() || condition.is_none() || other == condition
        };
        let mut key = (dimension, name.to_owned());
        let same = self.places.get(&key);
        if same.is_some_and(|same| !fits(&self.found[same])) {
            key.1 = format!("{place}/{name}");
        }
        let name = key.1.clone();
        let found = self.places.entry(key, &mut self.found, || FoundTag {
            dimension,
            name,
            condition: None,
            cells: Vec::new(),
        });
        found.cells.extend(cells);
        if found.condition.is_none() {
            found.condition = condition.map(str::to_owned);
        }
    }

    /// Adds a new group; where the name is taken, `place` is put before it.
    pub fn add_new(&mut self, name: &str, place: &str, dimension: u8, cells: &[Range<usize>]) {
        let mut unique = (dimension, name.to_owned());
        let mut count = 1;
        while self.places.get(&unique).is_some() {
            unique.1 = match count {
                1 => format!("{place}/{name}"),
                _ => format!("{place}/{name} {count}"),
            };
            count += 1;
        }
        self.add(&unique.1, place, dimension, None, cells.iter().cloned());
    }

    /// The groups that hold cells, in the order in which they were found.
    pub fn into_groups(self) -> Vec<Group> {
        let groups = self.found.into_iter().map(|found| Group {
            dimension: found.dimension,
            name: found.name,
            number: None,
            condition: found.condition,
            cells: set(found.cells),
        });
        groups.filter(|group| !group.cells.is_empty()).collect()
    }
}

/// The cells of ranges in any order, which may overlap.
fn set(mut ranges: Vec<Range<usize>>) -> CellSet {
    ranges.sort_unstable_by_key(|range| range.start);
    let mut set = CellSet::new();
    let mut end = 0;
    for range in ranges {
        let start = range.start.max(end);
        if start < range.end {
            set.push_range(start..range.end);
            end = range.end;
        }
    }
    set
}
