//! A mesh as Gmsh wants it: entities, physical numbers, and blocks of elements in the mesh's order.

use super::super::records::{push_integer, push_real, write_all, write_records};
use super::super::{Encoding, WriteOptions};
use super::kinds;
use crate::error::{Error, Result};
use crate::mesh::{CellKind, Group, Mesh};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::ops::Range;

/// One entity for each dimension and set of groups.
pub(super) struct Entity {
    pub dimension: u8,
    /// From 1 in each dimension.
    pub tag: i32,
    /// Physical numbers.
    pub physicals: Vec<i32>,
}

/// Consecutive cells of one kind in one entity.
pub(super) struct Block {
    pub kind: CellKind,
    /// Gmsh's element type.
    pub number: i32,
    pub cells: Range<usize>,
    /// Index of the entity.
    pub entity: usize,
}

/// What both versions write.
pub(super) struct Plan {
    pub entities: Vec<Entity>,
    pub blocks: Vec<Block>,
    /// Physical number of each group of the mesh.
    pub numbers: Vec<i32>,
}

impl Plan {
    /// Refuses polygons and polyhedra.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let numbers = physical_numbers(&mesh.groups);
        let mut plan = Self {
            entities: Vec::new(),
            blocks: Vec::new(),
            numbers,
        };
        let mut known: BTreeMap<(u8, Vec<usize>), usize> = BTreeMap::new();
        let mut next_tag = [1; 4];
        for (cells, groups) in segments(mesh) {
            for run in mesh.cells.runs_in(cells) {
                let number = kinds::number(run.kind).ok_or_else(|| {
                    Error::input(format!(
                        "cell {} is a {}, which MSH cannot hold",
                        run.first_cell,
                        run.kind.name()
                    ))
                })?;
                let dimension = run.kind.dimension();
                let entity = *known.entry((dimension, groups.clone())).or_insert_with(|| {
                    let tag = &mut next_tag[usize::from(dimension)];
                    plan.entities.push(Entity {
                        dimension,
                        tag: *tag,
                        physicals: groups.iter().map(|group| plan.numbers[*group]).collect(),
                    });
                    *tag += 1;
                    plan.entities.len() - 1
                });
                let cells = run.first_cell..run.first_cell + run.n_cells();
                match plan.blocks.last_mut() {
                    Some(last) if (last.kind, last.entity) == (run.kind, entity) => {
                        last.cells.end = cells.end;
                    }
                    _ => plan.blocks.push(Block {
                        kind: run.kind,
                        number,
                        cells,
                        entity,
                    }),
                }
            }
        }
        Ok(plan)
    }
}

/// The cells in order, cut wherever the set of groups changes.
fn segments(mesh: &Mesh) -> Vec<(Range<usize>, Vec<usize>)> {
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

/// A positive number for each group, its own where that is free in its dimension.
fn physical_numbers(groups: &[Group]) -> Vec<i32> {
    let mut taken = BTreeSet::new();
    let mut numbers = vec![0; groups.len()];
    for (number, group) in numbers.iter_mut().zip(groups) {
        let own = group.number.or_else(|| group.name.parse().ok());
        if let Some(own) = own.filter(|n| *n > 0 && taken.insert((group.dimension, *n))) {
            *number = own;
        }
    }
    for (number, group) in numbers.iter_mut().zip(groups).filter(|(n, _)| **n == 0) {
        *number = (1..)
            .find(|n| taken.insert((group.dimension, *n)))
            .expect("there are fewer groups than numbers");
    }
    numbers
}

/// Writes scalars as text or little-endian binary.
pub(super) struct Sink<'a> {
    pub out: &'a mut dyn Write,
    pub text: bool,
}

impl<'a> Sink<'a> {
    pub fn new(out: &'a mut dyn Write, options: &WriteOptions) -> Self {
        Self {
            out,
            text: options.encoding == Encoding::Ascii,
        }
    }

    /// Writes a line or several, in text and binary files alike.
    pub fn line(&mut self, line: &str) -> Result<()> {
        write_all(self.out, line.as_bytes())?;
        write_all(self.out, b"\n")
    }

    /// Ends binary data; text ends its lines itself.
    pub fn end_binary(&mut self) -> Result<()> {
        if self.text {
            return Ok(());
        }
        write_all(self.out, b"\n")
    }

    /// Writes `$MeshFormat`.
    pub fn header(&mut self, version: &str) -> Result<()> {
        let is_binary = u8::from(!self.text);
        self.line(&format!("$MeshFormat\n{version} {is_binary} 8"))?;
        if !self.text {
            write_all(self.out, &1i32.to_le_bytes())?;
            self.end_binary()?;
        }
        self.line("$EndMeshFormat")
    }

    /// Writes `$PhysicalNames`. A nameless group goes without, unless it is empty: then the line is
    /// all that remains of it. Returns sentences about names that had to change.
    pub fn physical_names(&mut self, mesh: &Mesh, plan: &Plan) -> Result<Vec<String>> {
        let mut notes = Vec::new();
        let mut lines = Vec::new();
        for (group, number) in mesh.groups.iter().zip(&plan.numbers) {
            if group.name == number.to_string() && !group.cells.is_empty() {
                continue;
            }
            let name = group.name.replace(char::is_control, " ").replace('"', "'");
            if name != group.name {
                notes.push(format!(
                    "group {:?} is written as \"{name}\": MSH cannot hold quotes or line ends",
                    group.name
                ));
            }
            lines.push(format!("{} {number} \"{name}\"", group.dimension));
        }
        if !lines.is_empty() {
            let n = lines.len();
            let lines = lines.join("\n");
            self.line(&format!("$PhysicalNames\n{n}\n{lines}\n$EndPhysicalNames"))?;
        }
        Ok(notes)
    }

    /// Writes many records of integers as lines or in binary of `width` bytes each: `record` puts
    /// record `i` into the slice of `n_values`.
    pub fn integers(
        &mut self,
        n: usize,
        n_values: usize,
        width: usize,
        record: impl Fn(usize, &mut [u64]) + Sync,
    ) -> Result<()> {
        let text = self.text;
        write_records(self.out, n, |range, buffer| {
            let mut values = [0; 40];
            let values = &mut values[..n_values];
            for i in range {
                record(i, values);
                for (at, value) in values.iter().enumerate() {
                    if text {
                        push_integer(buffer, *value);
                        buffer.push(if at + 1 < n_values { b' ' } else { b'\n' });
                    } else {
                        buffer.extend_from_slice(&value.to_le_bytes()[..width]);
                    }
                }
            }
        })
    }
}

/// Appends three coordinates as the end of a line.
pub(super) fn push_point(buffer: &mut Vec<u8>, point: &[f64; 3]) {
    for (i, x) in point.iter().enumerate() {
        push_real(buffer, *x);
        buffer.push(if i < 2 { b' ' } else { b'\n' });
    }
}

/// Appends three coordinates in binary.
pub(super) fn push_point_binary(buffer: &mut Vec<u8>, point: &[f64; 3]) {
    for x in point {
        buffer.extend_from_slice(&x.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(physical_numbers(&groups), [2, 1, 3, 7, 4]);
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
        assert_eq!(segments(&mesh), expected);
    }
}
