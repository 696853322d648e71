//! The content of an MSH file of either version: entities, physical numbers, and blocks of elements in the mesh's
//! order.

use super::groups::{ENTITIES, segments};
use super::index::Index;
use super::kinds::{self, Type};
use crate::formats::portable::remedy;
use crate::mesh::{CellKind, CellRun, DataArray, Group, MeshView, Values};
use azimesh_core::diagnostic::formats::Written;
use azimesh_core::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// One entity for each dimension, set of groups and, where the mesh came with them, entity.
pub(super) struct Entity {
    pub dimension: u8,
    /// The entity's own tag where that is free in its dimension; else counted from 1.
    pub tag: i32,
    /// Physical numbers.
    pub physicals: Vec<i32>,
}

/// Consecutive cells of one kind in one entity.
pub(super) struct ElementBlock {
    /// Index of the element type.
    pub of: usize,
    pub cells: Range<usize>,
    /// Index of the entity.
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
    /// Whether entities have the tags they came with.
    has_own_tags: bool,
}

/// Name of the array of node tags.
const NODE_NUMBERS: &str = "node_number";
/// Name of the array of element tags.
const CELL_NUMBERS: &str = "cell_number";

impl MshContent {
    /// With tags up to `highest` and numbers of groups from `lowest_group` on. Refuses kinds of cells
    /// that Gmsh has not.
    pub fn new(mesh: &MeshView, highest: i64, lowest_group: i32) -> Result<Self> {
        let own_tags = own_tags(mesh);
        let mut plan = Self {
            entities: Vec::new(),
            blocks: Vec::new(),
            types: Vec::new(),
            numbers: physical_numbers(mesh.groups, lowest_group),
            node_numbers: tags(&mesh.point_arrays, NODE_NUMBERS, highest),
            cell_numbers: tags(&mesh.cell_arrays, CELL_NUMBERS, highest),
            has_own_tags: own_tags.is_some(),
        };
        let mut known = Known::default();
        for (cells, groups) in segments(mesh) {
            for run in mesh.cells.runs_in(cells) {
                let of = plan.element_type(&mut known, run)?;
                let first = run.first_cell;
                let mut add = |own: i64, n: usize, from: &mut usize| {
                    plan.add(
                        &mut known,
                        run.kind.dimension(),
                        &groups,
                        own,
                        of,
                        *from..*from + n,
                    );
                    *from += n;
                };
                let mut from = first;
                match own_tags {
                    Some(tags) => {
                        let range = first..first + run.n_cells();
                        tags.for_each_stretch(range, |own, n| add(own, n, &mut from));
                    }
                    None => add(0, run.n_cells(), &mut from),
                }
            }
        }
        plan.number_entities();
        Ok(plan)
    }

    fn element_type(&mut self, known: &mut Known, run: CellRun) -> Result<usize> {
        let key = (run.kind, run.n_nodes);
        if let Some(&of) = known.types.get(&key) {
            return Ok(of);
        }
        let of = kinds::written_type(run.kind, run.n_nodes).ok_or_else(|| refused(run))?;
        self.types.push(of);
        known.types.insert(key, self.types.len() - 1);
        Ok(self.types.len() - 1)
    }

    /// Adds cells of one type to the entity of these groups and this own tag, 0 for none.
    fn add(
        &mut self,
        known: &mut Known,
        dimension: u8,
        groups: &[usize],
        own: i64,
        of: usize,
        cells: Range<usize>,
    ) {
        let of_groups = known.entities.entry((dimension, own)).or_default();
        let entity = *of_groups.entry(groups.to_vec()).or_insert_with(|| {
            self.entities.push(Entity {
                dimension,
                tag: i32::try_from(own).unwrap_or(0),
                physicals: groups.iter().map(|group| self.numbers[*group]).collect(),
            });
            self.entities.len() - 1
        });
        match self.blocks.last_mut() {
            Some(last)
                if (last.of, last.entity) == (of, entity) && last.cells.end == cells.start =>
            {
                last.cells.end = cells.end;
            }
            _ => self.blocks.push(ElementBlock { of, cells, entity }),
        }
    }

    /// Gives a free tag to entities that have none, or one that an earlier entity has.
    fn number_entities(&mut self) {
        let mut taken = BTreeSet::new();
        for entity in &mut self.entities {
            if entity.tag <= 0 || !taken.insert((entity.dimension, entity.tag)) {
                entity.tag = 0;
            }
        }
        let mut next = [1; 4];
        for entity in self.entities.iter_mut().filter(|entity| entity.tag == 0) {
            let next = &mut next[usize::from(entity.dimension)];
            while taken.contains(&(entity.dimension, *next)) {
                *next += 1;
            }
            entity.tag = *next;
            *next += 1;
        }
    }

    /// Counts nodes and elements that have values from 1 on where their own tags are above the 32
    /// bits that data refer to them with. Returns a note for each.
    pub fn drop_large_numbers(&mut self, mesh: &MeshView) -> Vec<Written> {
        let [has_point_data, has_cell_data] = self.data(mesh).map(|arrays| !arrays.is_empty());
        let is_large = |tag: &i64| i32::try_from(*tag).is_err();
        let mut notes = Vec::new();
        for (what, has_data, numbers) in [
            ("nodes", has_point_data, &mut self.node_numbers),
            ("elements", has_cell_data, &mut self.cell_numbers),
        ] {
            if has_data && numbers.iter().flatten().any(is_large) {
                *numbers = None;
                notes.push(Written::CountedFromOne { what });
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

    /// Lowest and highest node tag, of `n` nodes.
    pub fn node_tags(&self, n: usize) -> [usize; 2] {
        lowest_and_highest(self.node_numbers.as_deref(), n)
    }

    /// Lowest and highest element tag, of `n` elements.
    pub fn cell_tags(&self, n: usize) -> [usize; 2] {
        lowest_and_highest(self.cell_numbers.as_deref(), n)
    }

    /// Arrays that are written as values at nodes and at elements: all but those that became tags.
    pub fn data<'a>(&self, mesh: &MeshView<'a>) -> [Vec<&'a DataArray>; 2] {
        let point = mesh.point_arrays.iter().copied();
        let point = point.filter(|a| self.node_numbers.is_none() || a.name != NODE_NUMBERS);
        let cell = mesh.cell_arrays.iter().copied();
        let cell = cell.filter(|a| self.cell_numbers.is_none() || a.name != CELL_NUMBERS);
        let cell = cell.filter(|a| !self.has_own_tags || a.name != ENTITIES);
        [point.collect(), cell.collect()]
    }
}

/// Indices of types and entities by their keys.
#[derive(Default)]
struct Known {
    types: BTreeMap<(CellKind, usize), usize>,
    entities: BTreeMap<(u8, i64), BTreeMap<Vec<usize>, usize>>,
}

fn refused(run: CellRun) -> Error {
    let name = run.kind.name();
    let remedy = remedy(run.kind);
    Error::input(format!(
        "cell {} is a {name} with {} nodes, which MSH cannot hold{remedy}",
        run.first_cell, run.n_nodes
    ))
}

/// The values of the array of this name, where they are distinct tags from 1 to `highest`.
fn tags(arrays: &[&DataArray], name: &str, highest: i64) -> Option<Vec<i64>> {
    let array = arrays
        .iter()
        .find(|array| array.name == name && array.n_components == 1)?;
    let tags = array.values.to_integers()?;
    let good =
        tags.iter().all(|tag| (1..=highest).contains(tag)) && Index::new(&tags, "tag").is_ok();
    good.then_some(tags)
}

/// The entity of each cell, where the mesh came with them; 0 where a cell has none.
fn own_tags<'a>(mesh: &MeshView<'a>) -> Option<&'a Values> {
    let mut arrays = mesh.cell_arrays.iter().copied();
    let array = arrays.find(|array| array.name == ENTITIES)?;
    let mut good = array.n_components == 1 && array.values.is_integer();
    array
        .values
        .for_each_stretch(0..array.values.len(), |tag, _| {
            good &= (0..=i32::MAX.into()).contains(&tag);
        });
    good.then_some(&array.values)
}

fn lowest_and_highest(tags: Option<&[i64]>, n: usize) -> [usize; 2] {
    match tags {
        None => [n.min(1), n],
        Some(tags) => {
            [tags.iter().min(), tags.iter().max()].map(|tag| tag.map_or(0, |t| *t as usize))
        }
    }
}

/// A number for each group: its own where that is free in its dimension and not below `lowest`, else
/// the lowest that is free, from 1 on.
fn physical_numbers(groups: &[Group], lowest: i32) -> Vec<i32> {
    let mut taken = BTreeSet::new();
    let mut numbers = vec![None; groups.len()];
    for (number, group) in numbers.iter_mut().zip(groups) {
        let own = group.number.or_else(|| group.name.parse().ok());
        *number = own.filter(|n| *n >= lowest && taken.insert((group.dimension, *n)));
    }
    // The lowest that may be free in each dimension.
    let mut next = [1; 4];
    let free = |(number, group): (Option<i32>, &Group)| {
        number.unwrap_or_else(|| {
            let next = &mut next[usize::from(group.dimension)];
            let mut numbers = *next..;
            let free = numbers.find(|n| taken.insert((group.dimension, *n)));
            let free = free.expect("there are fewer groups than numbers");
            *next = free + 1;
            free
        })
    };
    numbers.into_iter().zip(groups).map(free).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    fn group(name: &str, number: Option<i32>, cells: Range<usize>) -> Group {
        Group {
            dimension: 2,
            name: name.into(),
            number,
            condition: None,
            cells: cells.collect(),
        }
    }

    #[test]
    fn groups_keep_their_numbers_and_others_get_free_ones() {
        let groups = [
            group("a", None, 0..0),
            group("b", Some(1), 0..0),
            group("c", Some(1), 0..0),
            group("7", None, 0..0),
            group("d", Some(-2), 0..0),
        ];
        assert_eq!(physical_numbers(&groups, 1), [2, 1, 3, 7, 4]);
        let zero = [group("0", Some(0), 0..0)];
        assert_eq!(physical_numbers(&zero, 0), [0]);
        assert_eq!(physical_numbers(&zero, 1), [1]);
    }

    #[test]
    fn a_hundred_thousand_groups_are_numbered_at_once() {
        let groups: Vec<Group> = (0..100_000)
            .map(|i| group(&format!("g{i}"), None, 0..0))
            .collect();
        let expected: Vec<i32> = (1..=100_000).collect();
        assert_eq!(physical_numbers(&groups, 1), expected);
    }

    #[test]
    fn cells_are_cut_where_their_groups_change() {
        let mut mesh = Mesh::default();
        for _ in 0..6 {
            mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        }
        mesh.groups = vec![group("a", None, 1..4), group("b", None, 3..5)];
        let expected = [
            (0..1, vec![]),
            (1..3, vec![0]),
            (3..4, vec![0, 1]),
            (4..5, vec![1]),
            (5..6, vec![]),
        ];
        assert_eq!(segments(&mesh.view()), expected);
    }
}
