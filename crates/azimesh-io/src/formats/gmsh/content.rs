//! The content of an MSH file of either version: entities, physical numbers, and blocks of elements in the mesh's
//! order.

use super::groups::{ENTITIES, segments};
use super::index::Index;
use super::kinds::{self, Type};
use crate::formats::portable::remedy;
use crate::mesh::{CellRun, DataArray, Group, MeshView, Values};
use azimesh_core::error::{Error, Result};
use azimesh_core::{Note, note};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// One entity for each dimension, set of groups and, where the mesh came with them, entity.
pub(super) struct Entity {
    pub dimension: u8,
    /// The entity's own tag where that is free in its dimension; else counted from 1.
    pub tag: i32,
    pub physicals: Vec<i32>,
}

/// Consecutive cells of one kind in one entity.
pub(super) struct ElementBlock {
    /// Index of the element type.
    pub of: usize,
    pub cells: Range<usize>,
    pub entity: usize,
}

/// The content of an MSH file, for both versions.
pub(super) struct MshContent {
    pub entities: Vec<Entity>,
    pub blocks: Vec<ElementBlock>,
    /// Gmsh's number of each element type that occurs, and its node order.
    pub types: Vec<(i32, Type)>,
    /// Physical number of each group of the mesh.
    pub numbers: Vec<i32>,
    /// Tags of the nodes, where they do not count from 1.
    pub node_numbers: Option<Vec<i64>>,
    /// Tags of the elements, where they do not count from 1.
    pub cell_numbers: Option<Vec<i64>>,
    /// Set where entities have the tags they came with.
    has_own_tags: bool,
}

/// Name of the array of node tags.
pub(super) const NODE_NUMBERS: &str = "node_number";
/// Name of the array of element tags.
pub(super) const CELL_NUMBERS: &str = "cell_number";

impl MshContent {
    /// With tags up to `highest` and numbers of groups from `lowest_group` on. Refuses kinds of cells
    /// that Gmsh has not.
    pub fn new(mesh: &MeshView, highest: i64, lowest_group: i32) -> Result<Self> {
        let own_tags = own_tags(mesh);
        let mut content = Self {
            entities: Vec::new(),
            blocks: Vec::new(),
            types: Vec::new(),
            numbers: physical_numbers(mesh.groups, lowest_group),
            node_numbers: tags(&mesh.point_arrays, NODE_NUMBERS, highest),
            cell_numbers: tags(&mesh.cell_arrays, CELL_NUMBERS, highest),
            has_own_tags: own_tags.is_some(),
        };
        let mut known = BTreeMap::new();
        for (cells, groups) in segments(mesh) {
            for run in mesh.cells.runs_in(cells) {
                let of = content.element_type(run)?;
                let mut next = run.first_cell;
                let mut add = |own: i64, n: usize| {
                    let entity = content.entity(&mut known, (run.kind.dimension(), own), &groups);
                    content.add(of, entity, next..next + n);
                    next += n;
                };
                let range = run.range();
                match own_tags {
                    Some(tags) => tags.for_each_stretch(range, add),
                    None => add(0, range.len()),
                }
            }
        }
        let entities = content.entities.iter();
        let own = entities.map(|entity| (entity.dimension, Some(entity.tag).filter(|n| *n > 0)));
        let tags = free_numbers(own);
        for (entity, tag) in content.entities.iter_mut().zip(tags) {
            entity.tag = tag;
        }
        Ok(content)
    }

    fn element_type(&mut self, run: CellRun) -> Result<usize> {
        let is_same = |(_, of): &(i32, Type)| (of.kind, of.n_nodes) == (run.kind, run.n_nodes);
        if let Some(of) = self.types.iter().position(is_same) {
            return Ok(of);
        }
        let of = kinds::written_type(run.kind, run.n_nodes).ok_or_else(|| refused(run))?;
        self.types.push(of);
        Ok(self.types.len() - 1)
    }

    /// The index of the entity of these groups and this dimension and own tag, 0 for none.
    fn entity(
        &mut self,
        known: &mut BTreeMap<(u8, i64, Vec<usize>), usize>,
        (dimension, own): (u8, i64),
        groups: &[usize],
    ) -> usize {
        let key = (dimension, own, groups.to_vec());
        *known.entry(key).or_insert_with(|| {
            self.entities.push(Entity {
                dimension,
                tag: i32::try_from(own).unwrap_or(0),
                physicals: groups.iter().map(|group| self.numbers[*group]).collect(),
            });
            self.entities.len() - 1
        })
    }

    fn add(&mut self, of: usize, entity: usize, cells: Range<usize>) {
        let fits = |last: &ElementBlock| {
            (last.of, last.entity) == (of, entity) && last.cells.end == cells.start
        };
        match self.blocks.last_mut() {
            Some(last) if fits(last) => last.cells.end = cells.end,
            _ => self.blocks.push(ElementBlock { of, cells, entity }),
        }
    }

    /// Counts nodes and elements that have values from 1 on where their own tags are above the 32
    /// bits that data refer to them with. Returns a note for each.
    pub fn drop_large_numbers(&mut self, mesh: &MeshView) -> Vec<Note> {
        let [at_nodes, at_cells] = self.data(mesh).map(|arrays| !arrays.is_empty());
        let mut notes = Vec::new();
        for (what, has_data, numbers) in [
            ("nodes", at_nodes, &mut self.node_numbers),
            ("elements", at_cells, &mut self.cell_numbers),
        ] {
            let large = |numbers: &mut Vec<i64>| numbers.iter().any(|n| i32::try_from(*n).is_err());
            if has_data && numbers.take_if(large).is_some() {
                notes.push(note!(
                    "counted_from_one",
                    "{what} are counted from 1: their own numbers are above {}, the largest that data in MSH can refer to",
                    i32::MAX
                ));
            }
        }
        notes
    }

    /// Tag of a node.
    pub fn node_tag(&self, node: u32) -> u64 {
        match &self.node_numbers {
            Some(numbers) => numbers[node as usize] as u64,
            None => u64::from(node) + 1,
        }
    }

    /// Physical numbers of a block's cells, 0 for none.
    pub fn physicals(&self, block: &ElementBlock) -> &[i32] {
        match &self.entities[block.entity].physicals[..] {
            [] => &[0],
            numbers => numbers,
        }
    }

    /// Arrays that are written as values at nodes and at elements: all but those that became tags.
    pub fn data<'a>(&self, mesh: &MeshView<'a>) -> [Vec<&'a DataArray>; 2] {
        let mut data = [mesh.point_arrays.to_vec(), mesh.cell_arrays.to_vec()];
        data[0].retain(|a| self.node_numbers.is_none() || a.name != NODE_NUMBERS);
        data[1].retain(|a| self.cell_numbers.is_none() || a.name != CELL_NUMBERS);
        data[1].retain(|a| !self.has_own_tags || a.name != ENTITIES);
        data
    }
}

fn refused(run: CellRun) -> Error {
    let (name, remedy, n) = (run.kind.name(), remedy(run.kind), run.n_nodes);
    Error::input(format!(
        "cell {} is a {name} with {n} nodes, which MSH cannot hold{remedy}",
        run.first_cell
    ))
}

/// The values of the array of this name, where they are distinct tags from 1 to `highest`.
fn tags(arrays: &[&DataArray], name: &str, highest: i64) -> Option<Vec<i64>> {
    let is_found = |array: &&&DataArray| array.name == name && array.n_components == 1;
    let tags = arrays.iter().find(is_found)?.values.to_integers()?;
    let are_in_range = tags.iter().all(|tag| (1..=highest).contains(tag));
    (are_in_range && Index::new(&tags, "tag").is_ok()).then_some(tags)
}

/// The entities of the cells, where the mesh came with them; 0 for none.
fn own_tags<'a>(mesh: &MeshView<'a>) -> Option<&'a Values> {
    let mut arrays = mesh.cell_arrays.iter().copied();
    let array = arrays.find(|array| array.name == ENTITIES)?;
    let values = &array.values;
    let mut good = array.n_components == 1 && values.is_integer();
    let range = 0..=i64::from(i32::MAX);
    values.for_each_stretch(0..values.len(), |tag, _| good &= range.contains(&tag));
    good.then_some(values)
}

/// Lowest and highest of `n` tags, which count from 1 where there are none.
pub(super) fn tag_range(tags: Option<&[i64]>, n: usize) -> [usize; 2] {
    match tags {
        None => [n.min(1), n],
        Some(tags) => {
            [tags.iter().min(), tags.iter().max()].map(|tag| tag.map_or(0, |t| *t as usize))
        }
    }
}

/// The numbers of the groups: their own from `lowest` on.
fn physical_numbers(groups: &[Group], lowest: i32) -> Vec<i32> {
    free_numbers(groups.iter().map(|group| {
        let own = group.number.or_else(|| group.name.parse().ok());
        (group.dimension, own.filter(|n| *n >= lowest))
    }))
}

/// A number for each item: its own where no earlier item of its dimension has that, else the lowest that
/// is free, from 1 on.
fn free_numbers(items: impl Iterator<Item = (u8, Option<i32>)>) -> Vec<i32> {
    let mut taken = BTreeSet::new();
    let own = items.map(|(dimension, own)| {
        let own = own.filter(|n| taken.insert((dimension, *n)));
        (dimension, own)
    });
    let own: Vec<_> = own.collect();
    // The lowest that may be free in each dimension.
    let mut next = [1; 4];
    let number = |(dimension, own): (u8, Option<i32>)| {
        own.unwrap_or_else(|| {
            let next = &mut next[usize::from(dimension)];
            while !taken.insert((dimension, *next)) {
                *next += 1;
            }
            *next
        })
    };
    own.into_iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(name: &str, number: Option<i32>) -> Group {
        Group::new(2, name, number, Default::default())
    }

    #[test]
    fn groups_keep_their_numbers_and_others_get_free_ones() {
        let groups = [
            group("a", None),
            group("b", Some(1)),
            group("c", Some(1)),
            group("7", None),
            group("d", Some(-2)),
        ];
        assert_eq!(physical_numbers(&groups, 1), [2, 1, 3, 7, 4]);
        let zero = [group("0", Some(0))];
        assert_eq!(physical_numbers(&zero, 0), [0]);
        assert_eq!(physical_numbers(&zero, 1), [1]);
    }

    #[test]
    fn a_hundred_thousand_groups_are_numbered_at_once() {
        let groups: Vec<Group> = (0..100_000)
            .map(|i| group(&format!("g{i}"), None))
            .collect();
        let expected: Vec<i32> = (1..=100_000).collect();
        assert_eq!(physical_numbers(&groups, 1), expected);
    }
}
