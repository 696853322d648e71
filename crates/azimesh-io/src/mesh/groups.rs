//! Named groups of cells: boundary tags, zones, and groups of lower dimension.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A named set of cells of one dimension. One below the mesh's dimension it is a boundary tag, of
/// the mesh's dimension a zone; in a cloud of points a tag.
///
/// ```
/// # fn main() -> azimesh_io::Result<()> {
/// let mesh = azimesh_io::Mesh::read("testdata/naca0012.vtu")?;
/// let names: Vec<&str> = mesh.tags().map(|tag| tag.name.as_str()).collect();
/// assert_eq!(names, ["airfoil", "farfield"]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Topological dimension of its cells.
    pub dimension: u8,
    /// Name of the group; its number where the file gives no name.
    pub name: String,
    /// The number the file gives it, for formats that number their groups.
    pub number: Option<i32>,
    /// Type of the boundary condition where the file gives one: a word of CGNS (`BCWallViscous`) or the type of a
    /// patch of OpenFOAM (`wall`).
    pub condition: Option<String>,
    /// The cells of the group.
    pub cells: CellSet,
}

impl Group {
    /// A group without a condition.
    pub(crate) fn new(
        dimension: u8,
        name: impl Into<String>,
        number: Option<i32>,
        cells: CellSet,
    ) -> Self {
        Self {
            dimension,
            name: name.into(),
            number,
            condition: None,
            cells,
        }
    }
}

/// The boundary tags of a mesh of this dimension, in order: groups of one dimension less, of points in a
/// cloud.
pub(super) fn boundary_tags(
    groups: &[Group],
    dimension: u8,
) -> impl Iterator<Item = &Group> + Clone {
    let below = dimension.saturating_sub(1);
    groups.iter().filter(move |group| group.dimension == below)
}

/// The zones of a mesh of this dimension, in order; a cloud has none.
pub(super) fn zones(groups: &[Group], dimension: u8) -> impl Iterator<Item = &Group> + Clone {
    let is_zone = move |group: &&Group| dimension > 0 && group.dimension == dimension;
    groups.iter().filter(is_zone)
}

/// A set of cell indices, kept as ascending disjoint ranges: boundaries and zones are mostly
/// contiguous, so a set of millions takes a few bytes.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellSet {
    ranges: Vec<Range<u32>>,
    len: usize,
}

impl CellSet {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a cell above all that are in the set; the last one again is ignored.
    ///
    /// # Panics
    /// When `cell` is below the set's largest.
    pub fn push(&mut self, cell: usize) {
        self.push_range(cell..cell + 1);
    }

    /// Adds a range that starts at or above the end of the set.
    pub fn push_range(&mut self, cells: Range<usize>) {
        let cells = cells.start as u32..cells.end as u32;
        if cells.is_empty() {
            return;
        }
        match self.ranges.last_mut() {
            Some(last) if last.end == cells.start => last.end = cells.end,
            Some(last) if last.end == cells.end && cells.len() == 1 => return,
            Some(last) => {
                assert!(last.end < cells.start, "cells are added in order");
                self.ranges.push(cells.clone());
            }
            None => self.ranges.push(cells.clone()),
        }
        self.len += cells.len();
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns whether the cell is in the set.
    pub fn contains(&self, cell: usize) -> bool {
        let after = self
            .ranges
            .partition_point(|range| range.start as usize <= cell);
        after > 0 && (cell as u32) < self.ranges[after - 1].end
    }

    /// Returns whether all of these cells are in the set.
    pub fn contains_range(&self, cells: Range<usize>) -> bool {
        let after = self
            .ranges
            .partition_point(|range| range.start as usize <= cells.start);
        cells.is_empty() || (after > 0 && cells.end <= self.ranges[after - 1].end as usize)
    }

    /// The cells, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> + Clone {
        self.ranges
            .iter()
            .flat_map(|range| range.start as usize..range.end as usize)
    }

    /// Cells of the set in a range, as ascending disjoint ranges.
    pub fn ranges_in(&self, cells: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let first = self
            .ranges
            .partition_point(|range| range.end as usize <= cells.start);
        let from = self.ranges[first..].iter();
        let here = from.map(move |range| {
            (range.start as usize).max(cells.start)..(range.end as usize).min(cells.end)
        });
        here.take_while(|range| !range.is_empty())
    }

    /// The cells as ascending disjoint ranges.
    pub fn ranges(&self) -> impl ExactSizeIterator<Item = Range<usize>> + Clone {
        self.ranges
            .iter()
            .map(|range| range.start as usize..range.end as usize)
    }
}

impl From<Range<usize>> for CellSet {
    fn from(cells: Range<usize>) -> Self {
        let mut set = Self::new();
        set.push_range(cells);
        set
    }
}

impl FromIterator<usize> for CellSet {
    /// Collects cells in any order; repeated ones count once.
    fn from_iter<I: IntoIterator<Item = usize>>(cells: I) -> Self {
        let mut cells: Vec<usize> = cells.into_iter().collect();
        cells.sort_unstable();
        let mut set = Self::new();
        for cell in cells {
            set.push(cell);
        }
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_holds_what_was_added() {
        let set: CellSet = [7, 3, 4, 9, 4].into_iter().collect();
        assert_eq!(set.iter().collect::<Vec<_>>(), [3, 4, 7, 9]);
        assert_eq!(set.len(), 4);
        assert_eq!(set.ranges().len(), 3);
        assert!(set.contains(4) && !set.contains(5) && !set.contains(0));
        assert!(set.contains_range(3..5) && set.contains_range(4..5));
        assert!(!set.contains_range(3..6) && !set.contains_range(0..4));
    }
}
