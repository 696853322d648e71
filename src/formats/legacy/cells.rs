//! Lists of cells in a legacy file: `n, node...` for each, or since version 5 offsets and nodes.
//!
//! A polyhedron has its face stream in the place of its nodes, in both.

use super::super::vtk::cells::{CellTable, Nodes};
use super::super::vtk::number::{Chunk, Element, Number, with_type};
use super::cursor::Cursor;
use super::values::{self, Type, check_count};
use crate::error::{Error, Result};
use crate::mesh::CellKind;
use rayon::prelude::*;

/// The cells after one keyword, without their types.
#[derive(Default)]
pub(super) struct List {
    /// Where the list stands.
    pub at: usize,
    n_cells: usize,
    entries: Vec<u32>,
    /// Where each cell ends; without them `entries` has a count before each cell.
    ends: Option<Vec<u64>>,
}

impl List {
    /// Reads what follows the keyword: two counts, and the cells.
    pub fn read(cursor: &mut Cursor) -> Result<Self> {
        let at = cursor.at;
        let n = cursor.count("a number of cells")?;
        let size = cursor.count("the size of the list")?;
        check_count(cursor, n, "cells")?;
        if cursor.peek().as_deref() == Some("offsets") {
            return Self::with_offsets(cursor, at, n, size);
        }
        if cursor.version.0 >= 5 && n <= 1 && size == 0 {
            return Ok(Self::default());
        }
        let entries = match cursor.binary {
            false => values::numbers::<u32>(cursor, Element::UInt32, size)?,
            true => {
                let mut entries = Vec::new();
                values::binary(cursor, Element::Int32, size, &mut |chunk| {
                    entries = vec![0; size];
                    chunk.convert::<i32, u32>(&mut entries, |x| x as u32);
                    Ok(())
                })?;
                entries
            }
        };
        Ok(Self {
            at,
            n_cells: n,
            entries,
            ends: None,
        })
    }

    fn with_offsets(cursor: &mut Cursor, at: usize, n: usize, size: usize) -> Result<Self> {
        cursor.keyword();
        let offsets = integers(cursor, n, |offset| offset)?;
        let mut ends = offsets;
        if !ends.is_empty() {
            let first = ends.remove(0);
            if first != 0 {
                let message = format!("the first offset is {first}; it must be 0");
                return Err(cursor.error_at(at, message));
            }
        }
        match cursor.keyword().as_deref() {
            Some("connectivity") => {}
            _ => return Err(cursor.error("CONNECTIVITY must follow the offsets")),
        }
        // An index that is too large for 32 bits is too large for every mesh.
        let narrow = |node: u64| u32::try_from(node).unwrap_or(u32::MAX);
        let entries = integers(cursor, size, narrow)?;
        Ok(Self {
            at,
            n_cells: ends.len(),
            entries,
            ends: Some(ends),
        })
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.n_cells
    }

    /// Appends the cells to a table; `kind` gives VTK's type of a cell with this index and number
    /// of nodes, `nodes` those that there are.
    pub fn append(
        self,
        table: &mut CellTable,
        nodes: Nodes,
        kind: impl Fn(usize, usize) -> u8,
    ) -> Result<()> {
        let polyhedron = CellKind::Polyhedron.vtk();
        let mut entries = self.entries;
        let first = table.connectivity.len();
        let (mut from, mut to) = (0, 0);
        let mut unique: Vec<u32> = Vec::new();
        for cell in 0..self.n_cells {
            let length = match &self.ends {
                Some(ends) => ends[cell].checked_sub(from as u64).map(|n| n as usize),
                None => {
                    let length = entries.get(from).map(|n| *n as usize);
                    from += 1;
                    length
                }
            };
            let end = length.and_then(|n| from.checked_add(n));
            let end = end.filter(|end| *end <= entries.len()).ok_or_else(|| {
                let n = entries.len();
                Error::input(format!(
                    "cell {cell} reaches beyond the {n} entries of the list"
                ))
            })?;
            let vtk = kind(cell, end - from);
            if vtk == polyhedron {
                let stream = &entries[from..end];
                table.streams.push(stream, nodes, cell)?;
                distinct(stream, &mut unique);
                entries[to..to + unique.len()].copy_from_slice(&unique);
                table.append_run(vtk, unique.len(), 1)?;
                to += unique.len();
            } else {
                entries.copy_within(from..end, to);
                table.append_run(vtk, end - from, 1)?;
                to += end - from;
            }
            from = end;
        }
        if from != entries.len() {
            let (left, n) = (entries.len() - from, entries.len());
            return Err(Error::input(format!(
                "the list of cells has {n} entries, {left} more than its cells"
            )));
        }
        entries.truncate(to);
        check_nodes(&entries, nodes)?;
        match first {
            0 => table.connectivity = entries,
            _ => table.connectivity.append(&mut entries),
        }
        Ok(())
    }
}

/// Nodes of a face stream, each once, ascending as VTK has them.
fn distinct(stream: &[u32], unique: &mut Vec<u32>) {
    unique.clear();
    let mut at = 1;
    while let Some(&n) = stream.get(at) {
        let face = stream.get(at + 1..).unwrap_or(&[]);
        unique.extend(&face[..face.len().min(n as usize)]);
        at += 1 + n as usize;
    }
    unique.sort_unstable();
    unique.dedup();
}

fn check_nodes(entries: &[u32], nodes: Nodes) -> Result<()> {
    let outside = |node: &&u32| u64::from(**node) >= nodes.limit;
    if entries.par_iter().any(|node| outside(&node)) {
        let node = entries.iter().find(outside).expect("one is outside");
        let shown = match *node {
            u32::MAX => "out of range".into(),
            node => node.to_string(),
        };
        let n = nodes.limit;
        return Err(Error::input(format!(
            "a node index of a cell is {shown}; the file has {n} nodes, counted from 0"
        )));
    }
    Ok(())
}

/// Reads a type and `n` integers, which must not be negative.
fn integers<U: Copy + Default + Send + Sync>(
    cursor: &mut Cursor,
    n: usize,
    map: impl Fn(u64) -> U + Sync,
) -> Result<Vec<U>> {
    let at = cursor.at;
    let element = match Type::read(cursor)? {
        Type::Number(element) if element.is_integer() => element,
        Type::Id if cursor.binary => Element::Int32,
        Type::Id => Element::Int64,
        _ => return Err(cursor.error_at(at, "offsets and node indices must be integers")),
    };
    let mut integers = Vec::new();
    with_type!(element, T => {
        if cursor.binary {
            values::binary(cursor, element, n, &mut |chunk: Chunk| {
                integers = vec![U::default(); n];
                chunk.convert::<T, U>(&mut integers, |x| map(x.as_index()));
                Ok(())
            })?;
        } else {
            let numbers: Vec<T> = values::numbers(cursor, element, n)?;
            integers = numbers.into_par_iter().map(|x| map(x.as_index())).collect();
        }
    });
    Ok(integers)
}

/// Reads VTK's types of `n` cells.
pub(super) fn types(cursor: &mut Cursor) -> Result<Vec<u8>> {
    let n = cursor.count("a number of cells")?;
    let numbers = values::numbers::<i32>(cursor, Element::Int32, n)?;
    // No type is larger than 255, and 255 is none.
    let narrow = |vtk: i32| u8::try_from(vtk).unwrap_or(u8::MAX);
    Ok(numbers.into_iter().map(narrow).collect())
}
