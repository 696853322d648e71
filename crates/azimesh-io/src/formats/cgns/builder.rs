//! The mesh as far as it has been read: nodes, cells, groups, arrays, and a record of what is left out.

use super::super::Notes;
use super::super::names::Places;
use super::solution::Arrays;
use crate::mesh::{CellRun, CellSet, Cells, DataArray, Group};
use azimesh_core::error::counted;
use azimesh_core::{Note, note};
use std::collections::BTreeMap;
use std::ops::Range;

/// The mesh as far as it has been read.
#[derive(Default)]
pub(super) struct MeshBuilder {
    pub points: Vec<[f64; 3]>,
    pub cells: Cells,
    pub tags: Tags,
    pub point_arrays: Arrays,
    pub cell_arrays: Arrays,
    pub field_arrays: Vec<DataArray>,
    /// Elements that keep only their corners, by type.
    pub incomplete: BTreeMap<&'static str, usize>,
    /// Notes on damage in the file.
    pub remarks: Vec<Note>,
    /// Kinds of data that are left out, with their numbers.
    left: BTreeMap<String, usize>,
    /// Kinds of data that are left out, with their names.
    left_by_name: BTreeMap<String, Vec<String>>,
}

impl MeshBuilder {
    /// The runs of some cells.
    pub fn cells_in(&self, ranges: &[Range<usize>]) -> impl Iterator<Item = CellRun<'_>> {
        ranges
            .iter()
            .flat_map(|range| self.cells.runs_in(range.clone()))
    }

    /// Counts data that a mesh cannot hold.
    pub fn leave(&mut self, what: &str, n: usize) {
        *self.left.entry(what.to_owned()).or_default() += n;
    }

    /// Notes the name of data that a mesh cannot hold.
    pub fn leave_named(&mut self, what: &str, name: &str) {
        let names = self.left_by_name.entry(what.to_owned()).or_default();
        names.push(name.to_owned());
    }

    /// Adds the notes on what is left out.
    pub fn say(&self, notes: &mut Notes) {
        notes.extend(self.remarks.iter().cloned());
        for (what, n) in &self.left {
            match n {
                n if what.contains(' ') => notes.not_kept(what, *n),
                1 => notes.push(note!("type_not_kept", "a node of type {what} is not kept")),
                n => notes.push(note!(
                    "type_not_kept",
                    "{n} nodes of type {what} are not kept"
                )),
            }
        }
        for (what, names) in &self.left_by_name {
            notes.names_not_kept(what, names.clone());
        }
        for (&element, &n) in &self.incomplete {
            notes.push(note!(
                "only_corners",
                "only the corner nodes of {} of type {element} are kept: no kind of cell has the other nodes",
                counted(n, "element")
            ));
        }
    }
}

/// Groups found so far: the same name in several places is one group.
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
        let is_taken = |name: &str| self.places.get(&(dimension, name.to_owned())).is_some();
        let unique = free_name(name, place, is_taken);
        self.add(&unique, place, dimension, None, cells.iter().cloned());
    }

    /// The groups that hold cells, in the order in which they were found.
    pub fn into_groups(self) -> Vec<Group> {
        let groups = self.found.into_iter().map(|found| Group {
            dimension: found.dimension,
            name: found.name,
            number: None,
            condition: found.condition,
            cells: set_of(found.cells),
        });
        groups.filter(|group| !group.cells.is_empty()).collect()
    }
}

/// The name or, where it is taken, the first free one of "place/name", "place/name 2", and so on.
pub(super) fn free_name(name: &str, place: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut free = name.to_owned();
    let mut count = 0;
    while is_taken(&free) {
        count += 1;
        free = match count {
            1 => format!("{place}/{name}"),
            _ => format!("{place}/{name} {count}"),
        };
    }
    free
}

/// The cells of ranges in any order, which may overlap.
pub(super) fn set_of(mut ranges: Vec<Range<usize>>) -> CellSet {
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
