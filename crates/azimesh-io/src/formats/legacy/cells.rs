//! Lists of cells in a legacy file: `n, node...` for each, or since version 5 offsets and nodes.
//!
//! A polyhedron has its face stream in the place of its nodes, in both.

use super::super::vtk::chunk::Chunk;
use super::super::vtk::list::List;
use super::super::vtk::number::Element;
use super::cursor::Cursor;
use super::values::{self, Type, check_count};
use azimesh_core::error::Result;

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
    let element = if cursor.binary {
        Element::Int32
    } else {
        Element::UInt32
    };
    let entries = values::numbers(cursor, element, size)?;
    Ok(List::counted(n, entries))
}

fn with_offsets(cursor: &mut Cursor, at: usize, n: usize, size: usize) -> Result<List> {
    cursor.keyword();
    let mut ends = integers(cursor, n, &|chunk, out| chunk.integers(out))?;
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
    let entries = integers(cursor, size, &|chunk, out| chunk.narrow(out))?;
    Ok(List::ending(ends, entries))
}

/// Reads a type and `n` integers, which `convert` puts into the type that is wanted.
fn integers<U: Copy + Default>(
    cursor: &mut Cursor,
    n: usize,
    convert: &dyn Fn(Chunk, &mut [U]),
) -> Result<Vec<U>> {
    let at = cursor.at;
    let element = match Type::read(cursor)? {
        Type::Number(element) if element.is_integer() => element,
        Type::Id => values::id(cursor),
        _ => return Err(cursor.error_at(at, "offsets and node indices must be integers")),
    };
    values::converted(cursor, element, n, convert)
}

/// Reads VTK's types of `n` cells.
pub(super) fn types(cursor: &mut Cursor) -> Result<Vec<u8>> {
    let n = cursor.count("a number of cells")?;
    values::converted(cursor, Element::Int32, n, &|chunk, out| chunk.types(out))
}
