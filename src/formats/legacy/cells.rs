//! Lists of cells in a legacy file: `n, node...` for each, or since version 5 offsets and nodes.
//!
//! A polyhedron has its face stream in the place of its nodes, in both.

use super::super::vtk::list::List;
use super::super::vtk::number::{Chunk, Element, Number, with_type};
use super::cursor::Cursor;
use super::values::{self, Type, check_count};
use crate::error::Result;
use rayon::prelude::*;

/// Reads what follows the keyword of a list: two counts, and the cells.
pub(super) fn read(cursor: &mut Cursor) -> Result<List> {
    let at = cursor.at;
    let n = cursor.count("a number of cells")?;
    let size = cursor.count("the size of the list")?;
    check_count(cursor, n, "cells")?;
    if cursor.peek().as_deref() == Some("offsets") {
        return with_offsets(cursor, at, n, size);
    }
    if cursor.version.0 >= 5 && n <= 1 && size == 0 {
        return Ok(List::default());
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
    Ok(List::counted(n, entries))
}

fn with_offsets(cursor: &mut Cursor, at: usize, n: usize, size: usize) -> Result<List> {
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
    Ok(List::ending(ends, entries))
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
