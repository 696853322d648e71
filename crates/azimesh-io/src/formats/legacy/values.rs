//! Values of arrays in a legacy file: numbers as text or in big-endian bytes, bits, strings.

use super::super::Notes;
use super::super::names::text_of;
use super::super::number::{Chunk, DType};
use super::super::tokens::shown;
use super::super::vtk::list::List;
use super::super::vtk::number::{
    Element, cuts, parse_words, points_are_finite, word_end, word_start,
};
use super::cursor::{Cursor, decoded};
use crate::mesh::{Values, arrays::with_numbers, too_many};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::map;

/// Bytes of text that one task parses.
const PER_TASK: usize = 1 << 18;
/// Tasks whose numbers are held before they are appended.
const BATCH: usize = 32;

/// Type of the values of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Number(Element),
    /// VTK's ids: 64 bits in memory, 32 in binary files.
    Id,
    /// Eight to a byte, the first one highest.
    Bit,
    Text,
}

impl Type {
    pub fn from_name(name: &[u8]) -> Option<Self> {
        let element = match name.to_ascii_lowercase().as_slice() {
            b"bit" => return Some(Type::Bit),
            b"vtkidtype" => return Some(Type::Id),
            b"string" | b"utf8_string" => return Some(Type::Text),
            b"char" | b"signed_char" | b"vtktypeint8" => Element::Int8,
            b"unsigned_char" | b"vtktypeuint8" => Element::UInt8,
            b"short" | b"vtktypeint16" => Element::Int16,
            b"unsigned_short" | b"vtktypeuint16" => Element::UInt16,
            b"int" | b"vtktypeint32" => Element::Int32,
            b"unsigned_int" | b"vtktypeuint32" => Element::UInt32,
            b"long" | b"long_long" | b"vtktypeint64" => Element::Int64,
            b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => Element::UInt64,
            b"float" | b"vtktypefloat32" => Element::Float32,
            b"double" | b"vtktypefloat64" => Element::Float64,
            _ => return None,
        };
        Some(Type::Number(element))
    }

    /// Reads the next word as a type.
    pub fn read(cursor: &mut Cursor) -> Result<Self> {
        let word = cursor.need("a type of values")?;
        Self::from_name(word).ok_or_else(|| {
            let name = shown(word);
            cursor.error(format!(
                "{name} is not a type of values; known types: bit, char, unsigned_char, short, \
                 unsigned_short, int, unsigned_int, long, unsigned_long, vtktypeint64, \
                 vtktypeuint64, vtkIdType, float, double, string"
            ))
        })
    }
}

pub(super) fn read(cursor: &mut Cursor, kind: Type, n: usize, notes: &mut Notes) -> Result<Values> {
    let element = match kind {
        Type::Number(element) => element,
        Type::Id => {
            let ids = converted(cursor, id(cursor), n, &|chunk, out| chunk.integers(out))?;
            return Ok(Values::I64(ids));
        }
        Type::Bit => return bits(cursor, n).map(Values::U8),
        Type::Text => return strings(cursor, n, notes).map(Values::Text),
    };
    let mut values = element.no_values();
    with_numbers!(&mut values, out => *out = numbers(cursor, element, n)?, _text => {});
    Ok(values)
}

/// Encoding of ids.
fn id(cursor: &Cursor) -> Element {
    cursor.by_encoding(Element::Int32, Element::Int64)
}

/// Reads `n` coordinates of whatever type.
pub(super) fn coordinates(cursor: &mut Cursor, kind: Type, n: usize) -> Result<Vec<f64>> {
    let element = coordinate_type(cursor, kind)?;
    converted(cursor, element, n, &|chunk, out| chunk.reals(out))
}

/// Reads the coordinates of `n` points.
pub(super) fn points(cursor: &mut Cursor, kind: Type, n: usize) -> Result<Vec<[f64; 3]>> {
    let n_values = n.checked_mul(3);
    let n_values = n_values.ok_or_else(|| cursor.error("there are too many points"))?;
    let element = coordinate_type(cursor, kind)?;
    check_room(cursor, element, n_values)?;
    let mut out = vec![[0.0; 3]; n];
    let start = cursor.at;
    fill(cursor, element, out.as_flattened_mut(), &|chunk, out| {
        chunk.reals(out)
    })?;
    if !cursor.binary {
        points_are_finite(0, &out).map_err(|(value, error)| {
            let at = start + word_start(&cursor.bytes[start..], value);
            cursor.error_at(at, error.message)
        })?;
    }
    Ok(out)
}

/// The type of coordinates. As text, a float is rounded to one, as VTK does.
fn coordinate_type(cursor: &Cursor, kind: Type) -> Result<Element> {
    match kind {
        Type::Number(element) => Ok(element),
        Type::Id => Ok(id(cursor)),
        Type::Bit | Type::Text => Err(cursor.error("coordinates must be numbers")),
    }
}

/// Reads `n` numbers of the type `element`, which has the size of `T`.
pub(super) fn numbers<T: bytemuck::Pod + Default>(
    cursor: &mut Cursor,
    element: Element,
    n: usize,
) -> Result<Vec<T>> {
    converted(cursor, element, n, &|chunk, out| chunk.copy_to(out))
}

/// Reads `n` numbers of the type `element`, which `convert` puts into the type that is wanted.
pub(super) fn converted<U: Copy + Default>(
    cursor: &mut Cursor,
    element: Element,
    n: usize,
    convert: &dyn Fn(Chunk, &mut [U]),
) -> Result<Vec<U>> {
    check_room(cursor, element, n)?;
    let mut out = vec![U::default(); n];
    fill(cursor, element, &mut out, convert)?;
    Ok(out)
}

/// Reads as many numbers as `out` has: the bytes after this line, or the next words. Some text after the words may be parsed
/// in vain.
fn fill<U>(
    cursor: &mut Cursor,
    element: Element,
    out: &mut [U],
    convert: &dyn Fn(Chunk, &mut [U]),
) -> Result<()> {
    let (n, mut done) = (out.len(), 0);
    if cursor.binary {
        cursor.line();
        let bytes = take(cursor, n.checked_mul(element.size()), n)?;
        convert(DType::new(element, true).of(bytes), out);
        return Ok(());
    }
    while done < n {
        let guess = (n - done).saturating_mul(24).max(256);
        let end = cursor.at.saturating_add(guess.min(PER_TASK * BATCH));
        let end = word_end(cursor.bytes, end);
        let cuts = cuts(cursor.bytes, cursor.at, end, PER_TASK);
        let parts = map(cuts.len() - 1, &|i| {
            parse(&cursor.bytes[cuts[i]..cuts[i + 1]], element)
        });
        for ((bytes, wrong), part) in parts.into_iter().zip(cuts.windows(2)) {
            let numbers = DType::new(element, cfg!(target_endian = "big")).of(&bytes);
            let (missing, found) = (n - done, numbers.n_values());
            if found >= missing {
                convert(numbers.part(0..missing), &mut out[done..]);
                let last = part[0] + word_start(&cursor.bytes[part[0]..], missing - 1);
                cursor.at = word_end(cursor.bytes, last);
                return Ok(());
            }
            convert(numbers, &mut out[done..done + found]);
            done += found;
            cursor.at = part[1];
            if let Some((at, message)) = wrong {
                let message = format!("{message} (after {done} of {n} values)");
                return Err(cursor.error_at(part[0] + at, message));
            }
        }
        if done < n && cursor.at == cursor.bytes.len() {
            let message = format!("the file ends after {done} of {n} values");
            return Err(cursor.error_at(cursor.at, message));
        }
    }
    Ok(())
}

/// The numbers before the first wrong word, and its place.
fn parse(text: &[u8], element: Element) -> (Vec<u8>, Option<(usize, String)>) {
    match parse_words(text, element) {
        Ok(bytes) => (bytes, None),
        Err((at, message)) => {
            let before = parse_words(&text[..at], element);
            (before.unwrap_or_default(), Some((at, message)))
        }
    }
}

/// Refuses more values than the rest of the file can hold.
fn check_room(cursor: &Cursor, element: Element, n: usize) -> Result<()> {
    if cursor.binary {
        let mut ahead = cursor.clone();
        ahead.line();
        return take(&mut ahead, n.checked_mul(element.size()), n).map(drop);
    }
    let left = cursor.rest().len();
    if n > left.div_ceil(2) {
        let message =
            format!("{n} values are needed, but only {left} characters are left in the file");
        return Err(cursor.error_at(cursor.at, message));
    }
    Ok(())
}

/// The next `n_bytes` bytes, of `n` values.
fn take<'a>(cursor: &mut Cursor<'a>, n_bytes: Option<usize>, n: usize) -> Result<&'a [u8]> {
    let rest = cursor.rest();
    let bytes = n_bytes.and_then(|n_bytes| rest.get(..n_bytes));
    let bytes = bytes.ok_or_else(|| {
        let left = rest.len();
        let message = format!("{n} values are needed, but only {left} bytes are left in the file");
        cursor.error_at(cursor.at, message)
    })?;
    cursor.at += bytes.len();
    Ok(bytes)
}

fn bits(cursor: &mut Cursor, n: usize) -> Result<Vec<u8>> {
    if !cursor.binary {
        return numbers(cursor, Element::UInt8, n);
    }
    cursor.line();
    let bytes = take(cursor, Some(n.div_ceil(8)), n)?;
    let bit = |i: usize| bytes[i / 8] >> (7 - i % 8) & 1;
    Ok((0..n).map(bit).collect())
}

/// Strings: in text one a line; in binary files their length comes first, in one, two, four or
/// eight bytes, as its first two bits encode.
fn strings(cursor: &mut Cursor, n: usize, notes: &mut Notes) -> Result<Vec<String>> {
    cursor.line();
    let mut strings = Vec::new();
    for i in 0..n {
        if cursor.rest().is_empty() {
            let message = format!("the file ends after {i} of {n} strings");
            return Err(cursor.error_at(cursor.at, message));
        }
        if !cursor.binary {
            let line = cursor.line();
            strings.push(decoded(line.strip_suffix(b"\r").unwrap_or(line), notes));
            continue;
        }
        let width = 8 >> (cursor.rest()[0] >> 6);
        let header = take(cursor, Some(width), 1)?;
        let length = header
            .iter()
            .fold(0u64, |n, byte| n << 8 | u64::from(*byte));
        let length = length & (u64::MAX >> (64 - 8 * width + 2));
        let bytes = take(cursor, usize::try_from(length).ok(), 1)?;
        strings.push(text_of(bytes, notes));
    }
    Ok(strings)
}

/// Refuses a count that the rest of the file cannot hold.
pub(super) fn check_count(cursor: &Cursor, n: usize, what: &str) -> Result<()> {
    if n >= u32::MAX as usize {
        return Err(Error::input(too_many(what)).byte(cursor.at as u64));
    }
    Ok(())
}

/// Reads the list of cells after its keyword: two counts, and `n, node...` for each cell or, since version 5, offsets and
/// nodes. A polyhedron has its face stream in the place of its nodes.
pub(super) fn list(cursor: &mut Cursor) -> Result<List> {
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
    let element = cursor.by_encoding(Element::Int32, Element::UInt32);
    Ok(List::counted(n, numbers(cursor, element, size)?))
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
    if cursor.keyword().as_deref() != Some("connectivity") {
        return Err(cursor.error("CONNECTIVITY must follow the offsets"));
    }
    let entries = integers(cursor, size, &|chunk, out| chunk.narrow(out, u32::MAX))?;
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
        Type::Id => id(cursor),
        _ => return Err(cursor.error_at(at, "offsets and node indices must be integers")),
    };
    converted(cursor, element, n, convert)
}

/// Reads VTK's types of `n` cells.
pub(super) fn types(cursor: &mut Cursor) -> Result<Vec<u8>> {
    let n = cursor.count("a number of cells")?;
    converted(cursor, Element::Int32, n, &|chunk, out| {
        chunk.narrow(out, u8::MAX)
    })
}
