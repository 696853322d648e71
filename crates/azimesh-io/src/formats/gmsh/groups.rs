//! Converts tags of elements to named groups of the mesh, and to arrays where groups do not suffice; finds the
//! groups of each cell when writing.

use super::super::Notes;
use super::super::names::text_of;
use super::entities::Entities;
use super::nodes::count;
use super::stream::Stream;
use crate::mesh::{CellSet, DataArray, Group, Mesh, MeshView, Values};
use azimesh_core::diagnostic::formats::Read;
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Cells by dimension and tag.
#[derive(Debug, Default)]
pub(super) struct Tagged(BTreeMap<(u8, i32), CellSet>);

impl Tagged {
    /// Adds cells above all that were added before.
    pub fn add(&mut self, dimension: u8, tag: i32, cells: Range<usize>) {
        let set = self.0.entry((dimension, tag)).or_default();
        set.push_range(cells);
    }

    /// Whether no cell has a tag.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Cells by physical group, from cells by entity.
    pub fn physical(&self, entities: &Entities) -> Self {
        self.renamed(|key| match entities.physicals.get(&key) {
            Some(numbers) => numbers,
            None => &[],
        })
    }

    /// Cells by whole entity and by partition, from cells by entity or part of one.
    pub fn of_parts(self, entities: &Entities) -> (Self, Self) {
        if entities.parts.is_empty() {
            return (self, Self::default());
        }
        let parent = |key: (u8, i32)| entities.parts.get(&key).map_or(key.1, |part| part.0);
        let partition = |key: (u8, i32)| entities.parts.get(&key).map(|part| part.1);
        let tags: BTreeMap<(u8, i32), [i32; 1]> =
            self.0.keys().map(|&key| (key, [parent(key)])).collect();
        let partitions: BTreeMap<(u8, i32), Option<i32>> =
            self.0.keys().map(|&key| (key, partition(key))).collect();
        (
            self.renamed(|key| &tags[&key]),
            self.renamed(|key| partitions[&key].as_slice()),
        )
    }

    /// The cells by the tags that `names` gives for each key.
    fn renamed<'a>(&self, names: impl Fn((u8, i32)) -> &'a [i32]) -> Self {
        let mut ranges: BTreeMap<(u8, i32), Vec<Range<usize>>> = BTreeMap::new();
        for (&key, cells) in &self.0 {
            for &number in names(key) {
                let group = ranges.entry((key.0, number)).or_default();
                group.extend(cells.ranges());
            }
        }
        let sets = ranges.into_iter().map(|(key, mut ranges)| {
            ranges.sort_unstable_by_key(|range| range.start);
            let mut set = CellSet::new();
            for range in ranges {
                set.push_range(range);
            }
            (key, set)
        });
        Self(sets.collect())
    }

    /// The tags as an array over `n` cells; 0 where a cell has none.
    fn array(&self, name: &str, n: usize) -> DataArray {
        let mut values = vec![0; n];
        for (&(_, tag), cells) in &self.0 {
            for range in cells.ranges() {
                values[range].fill(tag);
            }
        }
        DataArray::scalar(name, Values::I32(values))
    }
}

/// Version 2 repeats an element of several physical groups: the dimensions where an entity is in
/// more than one.
#[derive(Debug, Default)]
pub(super) struct Shared {
    first: BTreeMap<(u8, i32), i32>,
    dimensions: BTreeSet<u8>,
}

impl Shared {
    /// Notes that an entity has elements of a physical group.
    pub fn add(&mut self, dimension: u8, entity: i32, physical: i32) {
        if *self.first.entry((dimension, entity)).or_insert(physical) != physical {
            self.dimensions.insert(dimension);
        }
    }

    /// Makes repeated cells one cell in several groups.
    pub fn merge(&self, mesh: &mut Mesh) {
        for &dimension in &self.dimensions {
            mesh.merge_repeated_cells(dimension);
        }
    }
}

/// A line of `$PhysicalNames`.
#[derive(Debug)]
pub(super) struct PhysicalName {
    /// Dimension of the group; version 2.0 gives none.
    dimension: Option<u8>,
    number: i32,
    name: String,
}

/// Reads `$PhysicalNames`, which is text in binary files too.
pub(super) fn read_names(stream: &mut Stream, notes: &mut Notes) -> Result<Vec<PhysicalName>> {
    let n = count(stream, "the number of physical names")?;
    let mut names = Vec::new();
    for i in 0..n {
        let Some(mut line) = stream.text.line() else {
            return Err(stream.error(format!("the file ends after {i} of {n} physical names")));
        };
        let first = line.integer("the dimension of a physical group")?;
        let (dimension, number) = if line.rest().first() == Some(&b'"') {
            (None, first)
        } else {
            (Some(first), line.integer("the number of a physical group")?)
        };
        // Old files have a dimension of -1 where it is not known.
        let dimension = match dimension {
            None | Some(-1) => None,
            Some(d @ 0..=3) => Some(d as u8),
            Some(d) => {
                return Err(line.error(format!(
                    "a physical group has dimension {d}; it must be 0 to 3"
                )));
            }
        };
        let number = i32::try_from(number)
            .map_err(|_| line.error(format!("physical group {number} is out of range")))?;
        names.push(PhysicalName {
            dimension,
            number,
            name: text_of(unquoted(line.rest()), notes),
        });
    }
    Ok(names)
}

/// The text between the quotes: to the last one where that ends the line, to the next one where
/// some program put more behind it. All of it where there are none.
fn unquoted(text: &[u8]) -> &[u8] {
    let Some(inside) = text.strip_prefix(b"\"") else {
        return text;
    };
    let next = memchr::memchr(b'"', inside).unwrap_or(inside.len());
    inside.strip_suffix(b"\"").unwrap_or(&inside[..next])
}

/// The groups of a mesh of this dimension: named ones in the order of the file, then nameless ones,
/// called by their number, then entities where the boundary has no physical group, or the mesh itself
/// has none and several entities.
pub(super) fn groups(
    names: Vec<PhysicalName>,
    physical: Tagged,
    elementary: &Tagged,
    dimension: u8,
    notes: &mut Notes,
) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut places: BTreeMap<(u8, i32), usize> = BTreeMap::new();
    let mut left = physical.0;
    for name in names {
        let dimensions = match name.dimension {
            Some(dimension) => dimension..=dimension,
            None => 0..=3,
        };
        for of in dimensions {
            let cells = left.remove(&(of, name.number));
            if let Some(&place) = places.get(&(of, name.number)) {
                let known = &groups[place];
                if known.name != name.name {
                    notes.push(Read::SecondName {
                        number: name.number,
                        dimension: of,
                        used: known.name.clone(),
                        other: name.name.clone(),
                    });
                }
                continue;
            }
            if cells.is_none() && name.dimension.is_none() {
                continue;
            }
            places.insert((of, name.number), groups.len());
            groups.push(Group {
                dimension: of,
                name: name.name.clone(),
                number: Some(name.number),
                condition: None,
                cells: cells.unwrap_or_default(),
            });
        }
    }
    let nameless = |((dimension, number), cells): ((u8, i32), CellSet)| Group {
        dimension,
        name: number.to_string(),
        number: Some(number),
        condition: None,
        cells,
    };
    groups.extend(left.into_iter().map(nameless));
    for (of, at_least) in [(dimension.checked_sub(1), 1), (Some(dimension), 2)] {
        let Some(of) = of.filter(|of| groups.iter().all(|group| group.dimension != *of)) else {
            continue;
        };
        let entities = elementary.0.iter().filter(|(key, _)| key.0 == of);
        if entities.clone().count() >= at_least {
            let entities = entities.map(|(key, cells)| (*key, cells.clone()));
            groups.extend(entities.map(nameless));
        }
    }
    groups
}

/// Name of the array with the elementary entity of each cell.
pub(super) const ENTITIES: &str = "gmsh:geometrical";
/// Name of the array with the partition of each cell.
const PARTITIONS: &str = "gmsh:partition";

/// Arrays of the entities, where they hold more than the groups do of the mesh's own cells and its
/// boundary, and of the partitions, where there are any.
pub(super) fn arrays(elementary: &Tagged, partition: &Tagged, mesh: &Mesh) -> Vec<DataArray> {
    let mut arrays = Vec::new();
    let mut known = BTreeSet::new();
    let segments = segments(&mesh.view());
    let tells_more = |(key, cells): (&(u8, i32), &CellSet)| {
        key.0 + 1 >= mesh.dimension() && !known.insert((key.0, groups_in(&segments, cells)))
    };
    if elementary.0.iter().any(tells_more) {
        arrays.push(elementary.array(ENTITIES, mesh.cells.len()));
    }
    if !partition.0.is_empty() {
        arrays.push(partition.array(PARTITIONS, mesh.cells.len()));
    }
    arrays
}

/// The groups that have a cell of a set, ascending. Segments are the cells in order, with the groups
/// of each.
fn groups_in(segments: &[(Range<usize>, Vec<usize>)], cells: &CellSet) -> Vec<usize> {
    let mut groups = BTreeSet::new();
    for range in cells.ranges() {
        let first = segments.partition_point(|(segment, _)| segment.end <= range.start);
        let segments = segments[first..].iter();
        for (_, of_segment) in segments.take_while(|(segment, _)| segment.start < range.end) {
            groups.extend(of_segment);
        }
    }
    groups.into_iter().collect()
}

/// The cells in order, cut wherever the set of groups changes.
pub(super) fn segments(mesh: &MeshView) -> Vec<(Range<usize>, Vec<usize>)> {
    let mut events: Vec<(usize, bool, usize)> = Vec::new();
    for (i, group) in mesh.groups.iter().enumerate() {
        for range in group.cells.ranges() {
            events.push((range.start, true, i));
            events.push((range.end, false, i));
        }
    }
    events.sort_unstable();
    let mut active = BTreeSet::new();
    let mut segments = Vec::new();
    let mut start = 0;
    for (cell, enters, group) in events {
        if cell > start {
            segments.push((start..cell, active.iter().copied().collect()));
            start = cell;
        }
        if enters {
            active.insert(group);
        } else {
            active.remove(&group);
        }
    }
    if start < mesh.cells.len() {
        segments.push((start..mesh.cells.len(), Vec::new()));
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::slice;

    #[test]
    fn names_keep_their_spaces_and_quotes() {
        assert_eq!(unquoted(b"\"upper wall\""), b"upper wall");
        assert_eq!(unquoted(b"\"the \"hub\" side\""), b"the \"hub\" side");
        assert_eq!(unquoted(b"\"beam\" lower_dimensional_block"), b"beam");
        assert_eq!(unquoted(b"bare"), b"bare");
        assert_eq!(unquoted(b"\""), b"");
    }

    #[test]
    fn groups_of_an_entity_are_those_with_a_cell_in_it() {
        let segments = [
            (0..2, vec![]),
            (2..4, vec![5]),
            (4..5, vec![1, 5]),
            (5..9, vec![0]),
        ];
        let groups = |cells: &[Range<usize>]| {
            let cells = cells.iter().cloned().flatten().collect();
            groups_in(&segments, &cells)
        };
        assert_eq!(groups(slice::from_ref(&(0..2))), [0; 0]);
        assert_eq!(groups(slice::from_ref(&(1..3))), [5]);
        assert_eq!(groups(slice::from_ref(&(3..5))), [1, 5]);
        assert_eq!(groups(&[0..1, 4..5, 8..9]), [0, 1, 5]);
    }
}
