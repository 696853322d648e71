//! From the tags of elements to the named groups of the mesh.

use super::entities::Physicals;
use super::nodes::count;
use super::stream::Stream;
use crate::error::Result;
use crate::mesh::{CellSet, Group, Mesh};
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

    /// Cells by physical group, from cells by entity.
    pub fn physical(&self, physicals: &Physicals) -> Self {
        let mut ranges: BTreeMap<(u8, i32), Vec<Range<usize>>> = BTreeMap::new();
        for (&(dimension, entity), cells) in &self.0 {
            for &number in physicals.get(&(dimension, entity)).into_iter().flatten() {
                let group = ranges.entry((dimension, number)).or_default();
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

    /// Makes repeated cells one cell in several groups. Those of the boundary are left to whoever
    /// reads a mesh of any format.
    pub fn merge(&self, mesh: &mut Mesh) {
        let boundary = mesh.dimension().checked_sub(1);
        for &dimension in self.dimensions.iter().filter(|d| Some(**d) != boundary) {
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
pub(super) fn read_names(stream: &mut Stream) -> Result<Vec<PhysicalName>> {
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
        let dimension = dimension.map(|d| u8::try_from(d).ok().filter(|d| *d <= 3));
        let (Ok(number), None | Some(Some(_))) = (i32::try_from(number), dimension) else {
            return Err(line.error("a physical group has a dimension of 0 to 3 and a number"));
        };
        names.push(PhysicalName {
            dimension: dimension.flatten(),
            number,
            name: unquoted(line.rest()),
        });
    }
    Ok(names)
}

/// The text between the quotes: to the last one where that ends the line, to the next one where
/// some program put more behind it. All of it where there are none.
fn unquoted(text: &[u8]) -> String {
    let Some(inside) = text.strip_prefix(b"\"") else {
        return String::from_utf8_lossy(text).into_owned();
    };
    let next = memchr::memchr(b'"', inside).unwrap_or(inside.len());
    let name = inside.strip_suffix(b"\"").unwrap_or(&inside[..next]);
    String::from_utf8_lossy(name).into_owned()
}

/// The groups of a mesh of this dimension: named ones in the order of the file, then nameless ones,
/// called by their number, then entities where the boundary has no physical group.
pub(super) fn groups(
    names: Vec<PhysicalName>,
    physical: Tagged,
    elementary: Tagged,
    dimension: u8,
) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut left = physical.0;
    for name in names {
        let dimensions = match name.dimension {
            Some(dimension) => dimension..=dimension,
            None => 0..=3,
        };
        for of in dimensions {
            let cells = left.remove(&(of, name.number));
            let known = |group: &Group| (group.dimension, group.number) == (of, Some(name.number));
            if (cells.is_none() && name.dimension.is_none()) || groups.iter().any(known) {
                continue;
            }
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
    let is_boundary = |of: u8| of + 1 == dimension;
    if !groups.iter().any(|group| is_boundary(group.dimension)) {
        let entities = elementary.0.into_iter();
        groups.extend(entities.filter(|(key, _)| is_boundary(key.0)).map(nameless));
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_spaces_and_quotes() {
        assert_eq!(unquoted(b"\"upper wall\""), "upper wall");
        assert_eq!(unquoted(b"\"the \"hub\" side\""), "the \"hub\" side");
        assert_eq!(unquoted(b"\"beam\" lower_dimensional_block"), "beam");
        assert_eq!(unquoted(b"bare"), "bare");
        assert_eq!(unquoted(b"\""), "");
    }
}
