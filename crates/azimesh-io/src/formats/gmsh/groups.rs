//! Physical groups and entities: read from their sections, and made groups and arrays of the mesh from
//! the tags of its elements. Finds the groups of each cell when writing.

use super::super::Notes;
use super::super::names::text_of;
use super::stream::{Stream, Version};
use crate::mesh::{CellSet, DataArray, Group, Mesh, MeshView, Values};
use azimesh_core::error::Result;
use azimesh_core::note;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Dimension and tag of an entity or a physical group.
type Key = (u8, i32);

/// Physical groups and parents of the entities.
#[derive(Debug, Default)]
pub(super) struct Entities {
    /// Set where the file has them.
    pub are_known: bool,
    /// Physical groups of the entities that are in any.
    pub physicals: BTreeMap<Key, Vec<i32>>,
    /// For an entity of a partition the entity of its dimension that it is a part of, and the first
    /// of its partitions.
    parts: BTreeMap<Key, (i32, i32)>,
}

impl Entities {
    /// Reads `$Entities` or `$PartitionedEntities` of version 4.
    pub fn read(&mut self, stream: &mut Stream, partitioned: bool) -> Result<()> {
        self.are_known = true;
        if partitioned {
            stream.size("the number of partitions")?;
            for _ in 0..stream.size("the number of ghost entities")? {
                stream.int("the tag of a ghost entity")?;
                stream.int("the partition of a ghost entity")?;
            }
        }
        let mut counts = [0; 4];
        let items = ["points", "curves", "surfaces", "volumes"];
        for (count, item) in counts.iter_mut().zip(items) {
            *count = stream.size(&format!("the number of {item}"))?;
        }
        for (dimension, n) in (0..).zip(counts) {
            for _ in 0..n {
                self.read_entity(stream, dimension, partitioned)?;
            }
        }
        Ok(())
    }

    /// Reads tag, parent, position or box, physical groups and boundary of one entity.
    fn read_entity(&mut self, stream: &mut Stream, dimension: u8, partitioned: bool) -> Result<()> {
        let key = (dimension, stream.int("the tag of an entity")?);
        let mut part = None;
        if partitioned {
            let parent_dimension = stream.int("the dimension of a parent entity")?;
            let parent = stream.int("the tag of a parent entity")?;
            let partitions = ints(stream, "the number of partitions", "a partition")?;
            let first = partitions.first().copied().unwrap_or(0);
            part = (parent_dimension == i32::from(dimension)).then_some((parent, first));
        }
        let is_position = dimension == 0 && stream.version == Version::V41;
        for _ in 0..if is_position { 3 } else { 6 } {
            stream.real("a bound of an entity")?;
        }
        let groups = ints(stream, "the number of physical groups", "a physical group")?;
        if dimension > 0 {
            let what = "a bounding entity";
            ints(stream, "the number of bounding entities", what)?;
        }
        let (mut kept, mut seen) = (Vec::new(), BTreeSet::new());
        for group in groups {
            // A negative group holds the entity with its orientation reversed.
            let wrong = || stream.error(format!("physical group {group} is out of range"));
            let group = group.checked_abs().ok_or_else(wrong)?;
            if seen.insert(group) {
                kept.push(group);
            }
        }
        if !kept.is_empty() {
            self.physicals.insert(key, kept);
        }
        if let Some(part) = part {
            self.parts.insert(key, part);
            if let Some(groups) = self.physicals.get(&(dimension, part.0)).cloned() {
                self.physicals.entry(key).or_insert(groups);
            }
        }
        Ok(())
    }
}

/// Reads a list of integers after its length.
fn ints(stream: &mut Stream, count: &str, what: &str) -> Result<Vec<i32>> {
    let mut ints = Vec::new();
    for _ in 0..stream.size(count)? {
        ints.push(stream.int(what)?);
    }
    Ok(ints)
}

/// Cells by dimension and tag.
#[derive(Debug, Default)]
pub(super) struct Tagged(BTreeMap<Key, CellSet>);

impl Tagged {
    /// Adds cells above all that were added before.
    pub fn add(&mut self, dimension: u8, tag: i32, cells: Range<usize>) {
        let set = self.0.entry((dimension, tag)).or_default();
        set.push_range(cells);
    }

    /// Cells by physical group, from cells by entity.
    pub fn physical(&self, entities: &Entities) -> Self {
        self.renamed(|key| entities.physicals.get(&key).into_iter().flatten().copied())
    }

    /// Cells by whole entity and by partition, from cells by entity or part of one; `None` where no
    /// entity is a part.
    pub fn of_parts(&self, entities: &Entities) -> Option<(Self, Self)> {
        let part = |key: Key| entities.parts.get(&key);
        (!entities.parts.is_empty()).then(|| {
            (
                self.renamed(|key| [part(key).map_or(key.1, |part| part.0)]),
                self.renamed(|key| part(key).map(|part| part.1)),
            )
        })
    }

    /// The cells by the tags that replace each key's.
    fn renamed<T: IntoIterator<Item = i32>>(&self, tags: impl Fn(Key) -> T) -> Self {
        let mut ranges: BTreeMap<Key, Vec<Range<usize>>> = BTreeMap::new();
        for (&key, cells) in &self.0 {
            for tag in tags(key) {
                let of_tag = ranges.entry((key.0, tag)).or_default();
                of_tag.extend(cells.ranges());
            }
        }
        let sets = ranges.into_iter().map(|(key, mut ranges)| {
            ranges.sort_unstable_by_key(|range| range.start);
            let mut set = CellSet::new();
            ranges.into_iter().for_each(|range| set.push_range(range));
            (key, set)
        });
        Self(sets.collect())
    }

    /// The tags as an array over `n` cells; 0 for cells without a tag.
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
    first: BTreeMap<Key, i32>,
    dimensions: BTreeSet<u8>,
}

impl Shared {
    /// Notes that an entity has elements of a physical group.
    pub fn add(&mut self, dimension: u8, entity: i32, physical: i32) {
        if *self.first.entry((dimension, entity)).or_insert(physical) != physical {
            self.dimensions.insert(dimension);
        }
    }

    /// Makes repeated cells one cell in several groups, but for boundary faces: the caller of the reader merges those.
    pub fn merge(&self, mesh: &mut Mesh) {
        let boundary = mesh.dimension().checked_sub(1);
        let dimensions = self.dimensions.iter();
        for &dimension in dimensions.filter(|dimension| Some(**dimension) != boundary) {
            mesh.merge_repeated_cells(dimension);
        }
    }
}

/// A line of `$PhysicalNames`: dimension, which version 2.0 does not give, number and name.
pub(super) type PhysicalName = (Option<u8>, i32, String);

/// Reads `$PhysicalNames`, which is text in binary files too.
pub(super) fn read_names(stream: &mut Stream, notes: &mut Notes) -> Result<Vec<PhysicalName>> {
    let n = stream.count("the number of physical names")?;
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
        let name = text_of(unquoted(line.rest()), notes);
        names.push((dimension, number, name));
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
    let group = |(dimension, number): Key, name: String, cells: CellSet| {
        Group::new(dimension, name, Some(number), cells)
    };
    let nameless = |(key, cells): (Key, CellSet)| group(key, key.1.to_string(), cells);
    let mut groups: Vec<Group> = Vec::new();
    let mut places: BTreeMap<Key, usize> = BTreeMap::new();
    let mut left = physical.0;
    for (own_dimension, number, name) in names {
        for dimension in own_dimension.map_or(0..=3, |own| own..=own) {
            let key = (dimension, number);
            let cells = left.remove(&key);
            match places.get(&key).map(|place| &groups[*place].name) {
                Some(used) if *used != name => notes.push(note!(
                    "second_name",
                    "physical group {number} of dimension {dimension} has two names; \"{used}\" is used, not \"{name}\""
                )),
                None if cells.is_some() || own_dimension.is_some() => {
                    places.insert(key, groups.len());
                    groups.push(group(key, name.clone(), cells.unwrap_or_default()));
                }
                _ => {}
            }
        }
    }
    groups.extend(left.into_iter().map(nameless));
    for (of, at_least) in [(dimension.checked_sub(1), 1), (Some(dimension), 2)] {
        let Some(of) = of.filter(|of| groups.iter().all(|group| group.dimension != *of)) else {
            continue;
        };
        let entities = elementary.0.range((of, i32::MIN)..=(of, i32::MAX));
        if entities.clone().count() >= at_least {
            groups.extend(entities.map(|(key, cells)| nameless((*key, cells.clone()))));
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
    let adds_more = |(key, cells): (&Key, &CellSet)| {
        key.0 + 1 >= mesh.dimension() && !known.insert((key.0, groups_in(&segments, cells)))
    };
    if elementary.0.iter().any(adds_more) {
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
    // Cells at which a group begins or ends.
    let mut events: Vec<(usize, usize)> = Vec::new();
    for (i, group) in mesh.groups.iter().enumerate() {
        let ranges = group.cells.ranges();
        events.extend(ranges.flat_map(|range| [(range.start, i), (range.end, i)]));
    }
    events.sort_unstable();
    let mut active = BTreeSet::new();
    let mut segments = Vec::new();
    let mut start = 0;
    for (cell, group) in events {
        if cell > start {
            segments.push((start..cell, active.iter().copied().collect()));
            start = cell;
        }
        if !active.remove(&group) {
            active.insert(group);
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
