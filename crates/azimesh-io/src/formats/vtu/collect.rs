//! Values of arrays of all pieces, converted and appended: coordinates, indices, data.

use super::super::vtk::chunk::Chunk;
use super::super::vtk::number::{Element, points_are_finite};
use super::super::vtk::text::word_start;
use super::document::Piece;
use super::stored::Stored;
use super::xml::{Array, DataEncoding, Layout, line_after};
use azimesh_core::error::{Error, Result, counted};

/// Coordinates of the nodes of all pieces.
pub(super) fn points(pieces: &[Piece], layout: &Layout) -> Result<Vec<[f64; 3]>> {
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
            return Err(Error::input(format!(
                "points are {} with {} components; they must be numbers with 3 components",
                array.element.name(),
                array.n_components
            ))
            .dataset("Points"));
        }
        let n = count(piece.n_points).map_err(|error| error.dataset("Points"))?;
        let first = points.len();
        collect(array, layout, 3, Some(n), &mut points, &|chunk, out| {
            chunk.reals(out.as_flattened_mut());
            Ok(())
        })?;
        if array.encoding == DataEncoding::Ascii {
            check_finite(array, first, &points[first..])?;
        }
    }
    Ok(points)
}

/// Refuses text with a coordinate that is no number, at its line; nodes count from `first`.
fn check_finite(array: &Array, first: usize, points: &[[f64; 3]]) -> Result<()> {
    points_are_finite(first, points).map_err(|(value, error)| {
        let at = word_start(array.stored, value);
        error.line(line_after(array.before) - 1 + line_after(&array.stored[..at]))
    })
}

/// A number of nodes or cells, which must fit in an index of 32 bits.
pub(super) fn count(n: u64) -> Result<usize> {
    if n >= u64::from(u32::MAX) {
        return Err(Error::input(format!(
            "{n} is more than 4294967294, the most nodes or cells that a mesh can have"
        )));
    }
    Ok(n as usize)
}

/// Appends the tuples of an array to `out`, `tuple` values each. Their number must be `expected`.
pub(super) fn collect<U: Copy + Default + Send>(
    array: &Array,
    layout: &Layout,
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
    Stored::open(array, layout).and_then(|stored| {
        let result = for_each_chunk(&stored, array, tuple, expected, &mut append);
        result.map_err(|error| error.dataset(&array.name))
    })
}

/// Hands the tuples of an array to `append`, chunk by chunk, with their number and that of all (0 where it is not known).
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
    if let Some(n_bytes) = stored.n_bytes() {
        let fits = match expected {
            Some(n) => n.checked_mul(width) == Some(n_bytes),
            None => n_bytes.is_multiple_of(width),
        };
        if !fits {
            return wrong(format!("{n_bytes} bytes"));
        }
    } else if expected.is_some_and(|n| n > stored.most_values() / tuple) {
        return wrong(counted(stored.n_values(), "value"));
    }
    let n_tuples = expected.or(stored.n_bytes().map(|n| n / width));
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
        // At least doubled: text tells no total, and pieces one each.
        out.reserve(total.max(n));
    }
    out.resize(out.len() + n, U::default());
}
