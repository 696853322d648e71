//! Values of arrays of all pieces, converted and joined: coordinates, indices, data.

use super::super::number::Chunk;
use super::super::vtk::number::{Element, points_are_finite, word_start};
use super::document::Piece;
use super::stored::Stored;
use super::xml::{Array, DataEncoding};
use crate::formats::Notes;
use crate::formats::names::{alike, text_of};
use crate::formats::notes::too_long;
use crate::formats::tokens::n_words;
use crate::mesh::{DataArray, Values, arrays::with_numbers};
use azimesh_core::error::{Error, Result, counted};

/// Coordinates of the nodes of all pieces.
pub(super) fn points(pieces: &[Piece]) -> Result<Vec<[f64; 3]>> {
    let mut points = Vec::new();
    for piece in pieces {
        let array = match piece.points.as_slice() {
            [array] => array,
            [] if piece.n_points == 0 => continue,
            arrays => {
                let found = arrays.len();
                let message = format!("a piece must have one array of points, found {found}");
                return Err(Error::input(message).dataset("Points"));
            }
        };
        if array.n_components != 3 || array.element == Element::String {
            let (element, n) = (array.element.name(), array.n_components);
            let message = format!(
                "points are {element} with {n} components; they must be numbers with 3 components"
            );
            return Err(Error::input(message).dataset("Points"));
        }
        let n = count(piece.n_points).map_err(|error| error.dataset("Points"))?;
        let first = points.len();
        collect(array, 3, Some(n), &mut points, &|chunk, out| {
            chunk.reals(out.as_flattened_mut());
            Ok(())
        })?;
        if array.encoding == DataEncoding::Ascii {
            let finite = points_are_finite(first, &points[first..]);
            finite.map_err(|(value, error)| {
                error.line(array.line(word_start(array.stored, value)))
            })?;
        }
    }
    Ok(points)
}

/// A number of nodes or cells, which must fit in an index of 32 bits.
pub(super) fn count(n: u64) -> Result<usize> {
    if n < u64::from(u32::MAX) {
        return Ok(n as usize);
    }
    Err(Error::input(format!(
        "{n} is more than 4294967294, the most nodes or cells that a mesh can have"
    )))
}

/// All values of an array; their number must be `expected`.
pub(super) fn all<U: Copy + Default + Send>(
    array: &Array,
    expected: Option<usize>,
    convert: impl Fn(Chunk, &mut [U]),
) -> Result<Vec<U>> {
    let mut out = Vec::new();
    collect(array, 1, expected, &mut out, &|chunk, out| {
        convert(chunk, out);
        Ok(())
    })?;
    Ok(out)
}

/// Appends the tuples of an array to `out`, `tuple` values each. Their number must be `expected`.
pub(super) fn collect<U: Copy + Default + Send>(
    array: &Array,
    tuple: usize,
    expected: Option<usize>,
    out: &mut Vec<U>,
    fill: &dyn Fn(Chunk, &mut [U]) -> Result<()>,
) -> Result<()> {
    let mut append = |chunk: Chunk, n: usize, total: usize| {
        let start = out.len();
        grow(out, n, total);
        fill(chunk, &mut out[start..])
    };
    let stored = Stored::open(array)?;
    let result = for_each_chunk(&stored, array, tuple, expected, &mut append);
    result.map_err(|error| error.dataset(&array.name))
}

/// Passes the tuples of an array to `append` by chunks, with their number and the total (0 where it is not known).
fn for_each_chunk(
    stored: &Stored,
    array: &Array,
    tuple: usize,
    expected: Option<usize>,
    append: &mut dyn FnMut(Chunk, usize, usize) -> Result<()>,
) -> Result<()> {
    let width = array.element.size().checked_mul(tuple);
    let width = width.ok_or_else(|| {
        Error::input(format!(
            "its tuples have {tuple} components, which is out of range"
        ))
    })?;
    let wrong = |found: String| {
        let element = array.element.name();
        let needed = match expected {
            Some(n) => format!("{} of {tuple} {element}", counted(n, "tuple")),
            None => format!("a whole number of tuples of {tuple} {element}"),
        };
        Err(Error::input(format!(
            "it has {found}; it must have {needed}"
        )))
    };
    let n_bytes = stored.n_bytes();
    if let Some(n_bytes) = n_bytes {
        let fits = match expected {
            Some(n) => n.checked_mul(width) == Some(n_bytes),
            None => n_bytes.is_multiple_of(width),
        };
        if !fits {
            return wrong(format!("{n_bytes} bytes"));
        }
    } else if expected.is_some_and(|n| n > array.stored.len().div_ceil(2) / tuple) {
        return wrong(counted(stored.n_values(), "value"));
    }
    let n_tuples = expected.or(n_bytes.map(|n| n / width));
    let mut done = 0;
    stored.for_each(width, &mut |chunk| {
        let n = chunk.bytes.len() / width;
        done += n;
        if n_tuples.is_some_and(|n_tuples| done > n_tuples) {
            return wrong(counted(stored.n_values(), "value"));
        }
        append(chunk, n, n_tuples.unwrap_or(0))
    })?;
    match n_tuples {
        Some(n) if done != n => wrong(counted(done, "tuple")),
        _ => Ok(()),
    }
}

/// Makes `n` more elements, the first of `total`.
fn grow<U: Copy + Default>(out: &mut Vec<U>, n: usize, total: usize) {
    if out.is_empty() && n >= total {
        // Memory that the system zeroes when it is first touched, by the threads that fill it.
        *out = vec![U::default(); n];
        return;
    }
    if out.capacity() < out.len() + n {
        // At least doubled: the total of text is not known, and each piece has its own.
        out.reserve(total.max(n));
    }
    out.resize(out.len() + n, U::default());
}

/// The arrays that all pieces with nodes (or cells) have, of one type; a note on others.
pub(super) fn data<'d, 'a: 'd>(
    pieces: &'d [Piece<'a>],
    what: &'static str,
    of: impl Fn(&'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>),
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let parts: Vec<_> = pieces.iter().map(of).filter(|(n, _)| *n > 0).collect();
    let all: Vec<&Vec<Array>> = parts.iter().map(|(_, part)| *part).collect();
    let kind = |a: &Array| (a.name.clone(), a.element.name(), a.is_bits, a.n_components);
    let mut misfits = Notes::default();
    let mut arrays: Vec<DataArray> = Vec::new();
    for of_pieces in alike(&all, what, (|array| &*array.name, kind), &mut misfits) {
        let mut all = empty(of_pieces[0]);
        let mut fits = true;
        for (array, (n, _)) in of_pieces.into_iter().zip(&parts) {
            let n = count(*n).map_err(|error| error.dataset(&array.name))?;
            fits = fits && append_fitting(&mut all.values, array, n, notes)?;
        }
        if fits {
            arrays.push(all);
        } else {
            notes.push(too_long(what, &all.name));
        }
    }
    notes.extend(misfits);
    Ok(arrays)
}

/// Appends the values of an array of `n` tuples; `false` where it has whole tuples beyond them.
fn append_fitting(values: &mut Values, array: &Array, n: usize, notes: &mut Notes) -> Result<bool> {
    let is_text = array.encoding == DataEncoding::Ascii;
    let is_string = array.element == Element::String;
    let has_more = |found: usize| {
        let needed = n.checked_mul(array.n_components);
        needed.is_some_and(|needed| found > needed && found.is_multiple_of(array.n_components))
    };
    if !is_text && !is_string && !array.is_bits {
        let n_bytes = Stored::open(array)?.n_bytes().unwrap_or(0);
        let size = array.element.size();
        if n_bytes.is_multiple_of(size) && has_more(n_bytes / size) {
            return Ok(false);
        }
    }
    match append(values, array, Some(n), notes) {
        // The length of text is known after it is read.
        Err(_) if is_text && !is_string && has_more(n_words(array.stored)) => Ok(false),
        appended => appended.map(|()| true),
    }
}

pub(super) fn field(array: &Array, notes: &mut Notes) -> Result<DataArray> {
    let mut all = empty(array);
    let n = array.n_tuples.map(count).transpose();
    let n = n.map_err(|error| error.dataset(&array.name))?;
    append(&mut all.values, array, n, notes)?;
    Ok(all)
}

fn empty(array: &Array) -> DataArray {
    DataArray {
        name: array.name.clone(),
        n_components: array.n_components,
        component_names: array.component_names.clone(),
        values: array.element.no_values(),
    }
}

fn append(values: &mut Values, array: &Array, n: Option<usize>, notes: &mut Notes) -> Result<()> {
    let n_values = n.map(|n| n.checked_mul(array.n_components));
    let expected = n_values.map(|n| n.unwrap_or(usize::MAX));
    match values {
        Values::U8(out) if array.is_bits => bits(array, n_values.flatten(), out)?,
        _ => with_numbers!(
            values,
            out => copied(array, expected, out)?,
            out => strings(array, n_values, out, notes)?
        ),
    }
    if values.len().is_multiple_of(array.n_components) {
        return Ok(());
    }
    let (found, n) = (values.len(), array.n_components);
    let message = format!("it has {found} values, which is not a whole number of tuples of {n}");
    Err(Error::input(message).dataset(&array.name))
}

/// Appends the values of an array as they are; their number must be `expected`.
fn copied<T: bytemuck::Pod + Default + Send>(
    array: &Array,
    expected: Option<usize>,
    out: &mut Vec<T>,
) -> Result<()> {
    collect(array, 1, expected, out, &|chunk, out| {
        chunk.copy_to(out);
        Ok(())
    })
}

/// Bits, the first of a byte its highest; as text, a word each.
fn bits(array: &Array, n: Option<usize>, out: &mut Vec<u8>) -> Result<()> {
    if array.encoding == DataEncoding::Ascii {
        return copied(array, n, out);
    }
    let bytes: Vec<u8> = all(array, n.map(|n| n.div_ceil(8)), |chunk, out| {
        chunk.copy_to(out)
    })?;
    let n = n.unwrap_or(8 * bytes.len());
    out.extend((0..n).map(|i| bytes[i / 8] >> (7 - i % 8) & 1));
    Ok(())
}

/// Strings are bytes, each string ended by a zero; as text, the numbers of the bytes, which some
/// writers give as signed.
fn strings(
    array: &Array,
    n: Option<Option<usize>>,
    out: &mut Vec<String>,
    notes: &mut Notes,
) -> Result<()> {
    let bytes: Vec<u8> = if array.encoding == DataEncoding::Ascii {
        let mut codes = array.clone();
        codes.element = Element::Int16;
        let byte = |code: i16| {
            let byte = u8::try_from(code).or_else(|_| i8::try_from(code).map(|c| c as u8));
            let message = || format!("{code} is not a character");
            byte.map_err(|_| Error::input(message()).dataset(&array.name))
        };
        let wide: Vec<i16> = all(&codes, None, |chunk, out| chunk.copy_to(out))?;
        wide.into_iter().map(byte).collect::<Result<_>>()?
    } else {
        all(array, None, |chunk, out| chunk.copy_to(out))?
    };
    let mut words: Vec<_> = bytes.split(|byte| *byte == 0).collect();
    words.pop_if(|word| word.is_empty());
    let found = words.len();
    out.extend(words.iter().map(|word| text_of(word, notes)));
    match n {
        Some(expected) if expected != Some(found) => {
            let needed = expected.map_or("more".to_owned(), |n| n.to_string());
            let message = format!("it has {}; it must have {needed}", counted(found, "string"));
            Err(Error::input(message).dataset(&array.name))
        }
        _ => Ok(()),
    }
}
