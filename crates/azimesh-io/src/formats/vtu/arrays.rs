//! Arrays at nodes and cells, of all pieces, and of the whole mesh.

use super::super::vtk::number::Element;
use super::collect::{collect, count};
use super::document::Piece;
use super::stored::{Stored, n_words};
use super::xml::{Array, DataEncoding, Layout};
use crate::formats::Notes;
use crate::formats::names::text_of;
use crate::mesh::{DataArray, Values};
use azimesh_core::diagnostic::formats::ArrayRead;
use azimesh_core::error::counted;
use azimesh_core::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};

/// The arrays that all pieces with nodes (or cells) have, of one type; a note on others.
pub(super) fn data<'d, 'a: 'd>(
    pieces: &'d [Piece<'a>],
    layout: &Layout,
    what: &'static str,
    of: impl Fn(&'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>),
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let parts: Vec<_> = pieces.iter().map(of).filter(|(n, _)| *n > 0).collect();
    let Some(((_, first), rest)) = parts.split_first() else {
        return Ok(Vec::new());
    };
    let mut arrays: Vec<DataArray> = Vec::new();
    let mut known: BTreeSet<&str> = BTreeSet::new();
    let rest: Vec<_> = rest.iter().map(|(_, part)| by_name(part)).collect();
    for array in first.iter() {
        let others = rest.iter().map(|part| {
            let mut named = part.get(&*array.name)?.iter();
            named.find(|other| is_alike(array, other)).copied()
        });
        let Some(others) = others.collect::<Option<Vec<_>>>() else {
            continue;
        };
        let everywhere = std::iter::once(array).chain(others);
        let parts = parts.iter().map(|(n, _)| *n).zip(everywhere);
        known.insert(&array.name);
        match joined(parts, layout, notes)? {
            Some(all) => arrays.push(all),
            None => {
                let name = array.name.clone();
                notes.push(ArrayRead::TooLong { what, name });
            }
        }
    }
    for array in parts.iter().flat_map(|(_, part)| part.iter()) {
        if !known.contains(&*array.name) {
            let name = array.name.clone();
            notes.push(ArrayRead::NotAlike { what, name });
        }
    }
    Ok(arrays)
}

/// The arrays of a piece by name.
fn by_name<'d, 'a>(part: &'d [Array<'a>]) -> BTreeMap<&'d str, Vec<&'d Array<'a>>> {
    let mut named: BTreeMap<&str, Vec<&Array>> = BTreeMap::new();
    for array in part {
        named.entry(&array.name).or_default().push(array);
    }
    named
}

/// Whether arrays of two pieces have the same type and number of components.
fn is_alike(one: &Array, other: &Array) -> bool {
    let (a, b) = (one, other);
    (a.element, a.is_bits, a.n_components) == (b.element, b.is_bits, b.n_components)
}

/// The values of one array of all pieces, of which each has so many tuples; `None` where one has more.
fn joined<'d, 'a: 'd>(
    parts: impl Iterator<Item = (u64, &'d Array<'a>)>,
    layout: &Layout,
    notes: &mut Notes,
) -> Result<Option<DataArray>> {
    let mut all: Option<DataArray> = None;
    for (n, array) in parts {
        let all = all.get_or_insert_with(|| empty(array));
        let n = count(n).map_err(|error| error.dataset(&array.name))?;
        if !append_fitting(&mut all.values, array, layout, n, notes)? {
            return Ok(None);
        }
    }
    Ok(all)
}

/// Appends the values of an array of `n` tuples; `false` where it has whole tuples beyond them.
fn append_fitting(
    values: &mut Values,
    array: &Array,
    layout: &Layout,
    n: usize,
    notes: &mut Notes,
) -> Result<bool> {
    if has_more(array, layout, n)? {
        return Ok(false);
    }
    match append(values, array, layout, Some(n), notes) {
        // How long text is turns out as it is read.
        Err(_) if text_has_more(array, n) => Ok(false),
        appended => appended.map(|()| true),
    }
}

/// Whether an array stored as text has whole tuples beyond the first `n`; counts its words.
fn text_has_more(array: &Array, n: usize) -> bool {
    if array.encoding != DataEncoding::Ascii || array.element == Element::String {
        return false;
    }
    let found = n_words(array.stored);
    let needed = n.checked_mul(array.n_components);
    needed.is_some_and(|needed| found > needed && found.is_multiple_of(array.n_components))
}

/// Whether an array has whole tuples beyond the first `n`.
fn has_more(array: &Array, layout: &Layout, n: usize) -> Result<bool> {
    if array.element == Element::String || array.is_bits {
        return Ok(false);
    }
    let stored = Stored::open(array, layout)?;
    let tuple = array.element.size().checked_mul(array.n_components);
    let fits = |n_bytes: usize| tuple.is_some_and(|tuple| n_bytes.is_multiple_of(tuple));
    let needed = tuple.and_then(|tuple| tuple.checked_mul(n));
    let n_bytes = stored.n_bytes().filter(|n_bytes| fits(*n_bytes));
    Ok(n_bytes.is_some_and(|n_bytes| needed.is_some_and(|needed| n_bytes > needed)))
}

/// An array of the whole mesh.
pub(super) fn field(array: &Array, layout: &Layout, notes: &mut Notes) -> Result<DataArray> {
    let mut all = empty(array);
    let n = array.n_tuples.map(count).transpose();
    let n = n.map_err(|error| error.dataset(&array.name))?;
    append(&mut all.values, array, layout, n, notes)?;
    Ok(all)
}

fn empty(array: &Array) -> DataArray {
    let values = match array.element {
        Element::Int8 => Values::I8(Vec::new()),
        Element::UInt8 => Values::U8(Vec::new()),
        Element::Int16 => Values::I16(Vec::new()),
        Element::UInt16 => Values::U16(Vec::new()),
        Element::Int32 => Values::I32(Vec::new()),
        Element::UInt32 => Values::U32(Vec::new()),
        Element::Int64 => Values::I64(Vec::new()),
        Element::UInt64 => Values::U64(Vec::new()),
        Element::Float32 => Values::F32(Vec::new()),
        Element::Float64 => Values::F64(Vec::new()),
        Element::String => Values::Text(Vec::new()),
    };
    DataArray {
        name: array.name.clone(),
        n_components: array.n_components,
        component_names: array.component_names.clone(),
        values,
    }
}

/// Appends the values of an array of `n` tuples.
fn append(
    values: &mut Values,
    array: &Array,
    layout: &Layout,
    n: Option<usize>,
    notes: &mut Notes,
) -> Result<()> {
    macro_rules! numbers {
        ($($variant:ident),*) => {
            match values {
                Values::U8(out) if array.is_bits => bits(array, layout, n, out),
                $(Values::$variant(out) => {
                    let values = n.map(|n| n.checked_mul(array.n_components).unwrap_or(usize::MAX));
                    copied(array, layout, values, out)
                })*
                Values::Text(out) => strings(array, layout, n, out, notes),
            }
        };
    }
    numbers!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64)?;
    if !values.len().is_multiple_of(array.n_components) {
        let (found, n) = (values.len(), array.n_components);
        let message =
            format!("it has {found} values, which is not a whole number of tuples of {n}");
        return Err(Error::input(message).dataset(&array.name));
    }
    Ok(())
}

/// Appends the values of an array as they are; their number must be `expected`.
fn copied<T: bytemuck::Pod + Default + Send>(
    array: &Array,
    layout: &Layout,
    expected: Option<usize>,
    out: &mut Vec<T>,
) -> Result<()> {
    collect(array, layout, 1, expected, out, &|chunk, out| {
        chunk.copy_to(out);
        Ok(())
    })
}

/// Bits, the first of a byte its highest; as text, a word each.
fn bits(array: &Array, layout: &Layout, n: Option<usize>, out: &mut Vec<u8>) -> Result<()> {
    let n = n.and_then(|n| n.checked_mul(array.n_components));
    let is_text = array.encoding == DataEncoding::Ascii;
    let expected = n.map(|n| if is_text { n } else { n.div_ceil(8) });
    let mut bytes: Vec<u8> = Vec::new();
    copied(array, layout, expected, &mut bytes)?;
    if is_text {
        out.append(&mut bytes);
        return Ok(());
    }
    let n = n.unwrap_or(8 * bytes.len());
    out.extend((0..n).map(|i| bytes[i / 8] >> (7 - i % 8) & 1));
    Ok(())
}

/// Strings are bytes, each string ended by a zero; as text, the numbers of the bytes, which some
/// writers give as signed.
fn strings(
    array: &Array,
    layout: &Layout,
    n: Option<usize>,
    out: &mut Vec<String>,
    notes: &mut Notes,
) -> Result<()> {
    let mut bytes: Vec<u8> = Vec::new();
    if array.encoding == DataEncoding::Ascii {
        let codes = Array {
            element: Element::Int16,
            ..array.clone()
        };
        let mut wide: Vec<i16> = Vec::new();
        copied(&codes, layout, None, &mut wide)?;
        for code in wide {
            bytes.push(
                u8::try_from(code)
                    .or_else(|_| i8::try_from(code).map(|c| c as u8))
                    .map_err(|_| {
                        Error::input(format!("{code} is not a character")).dataset(&array.name)
                    })?,
            );
        }
    } else {
        copied(array, layout, None, &mut bytes)?;
    }
    let before = out.len();
    let mut words = bytes.split(|byte| *byte == 0).collect::<Vec<_>>();
    if words.last().is_some_and(|word| word.is_empty()) {
        words.pop();
    }
    out.extend(words.iter().map(|word| text_of(word, notes)));
    let found = out.len() - before;
    match n.map(|n| n.checked_mul(array.n_components)) {
        Some(expected) if expected != Some(found) => {
            let needed = expected.map_or("more".to_owned(), |n| n.to_string());
            let message = format!("it has {}; it must have {needed}", counted(found, "string"));
            Err(Error::input(message).dataset(&array.name))
        }
        _ => Ok(()),
    }
}
