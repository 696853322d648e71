//! A .vtu file as a mesh: nodes and arrays of all pieces, one after another.

use super::super::vtk::cells::repeat_tuples;
use super::super::vtk::number::{Chunk, Element, Number, points_are_finite, with_type};
use super::super::vtk::text::word_start;
use super::super::vtk::{order, tags};
use super::arrays::{data, field};
use super::document::{self, Document, Grid, Piece};
use super::stored::Stored;
use super::xml::{Array, Layout, Place, as_utf8, line_after};
use super::{cells, structured};
use crate::error::{Error, Result, counted};
use crate::formats::{Notes, ReadOptions};
use crate::mesh::Mesh;

/// XML of this version on has hexahedra of high order in VTK's present order of nodes.
const FIRST_WITH_PRESENT_ORDER: (u32, u32) = (2, 1);

/// Reads a mesh. Pieces keep nodes of their own; arrays that not all of them have are left out.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let mut mesh = raw(bytes, notes)?.mesh;
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    Ok(mesh)
}

/// A file's mesh with every array as it is, and the names of those that hold global numbers.
pub(in crate::formats) struct Raw {
    /// The mesh, without groups.
    pub mesh: Mesh,
    /// Point array with the number of each node in a mesh of several files.
    pub global_nodes: Option<String>,
    /// Cell array with the same of each cell.
    pub global_cells: Option<String>,
}

/// Reads a file, but for what its arrays mean.
pub(in crate::formats) fn raw(bytes: &[u8], notes: &mut Notes) -> Result<Raw> {
    let bytes = &*as_utf8(bytes, notes);
    let mut document = document::parse(bytes)?;
    document.tell_arrays_apart(notes);
    let (mut mesh, origin) = match document.grid {
        Grid::Unstructured | Grid::Poly => unstructured(&mut document, notes)?,
        _ => {
            let mesh = structured::read(&mut document, bytes.len());
            (mesh.map_err(|error| error.dataset("Extent"))?, None)
        }
    };
    let (pieces, layout) = (&document.pieces, &document.layout);
    mesh.point_arrays = data(pieces, layout, "point", point_data, notes)?;
    mesh.cell_arrays = data(pieces, layout, "cell", cell_data, notes)?;
    for array in &document.field_data {
        mesh.field_arrays.push(field(array, layout, notes)?);
    }
    if let Some(origin) = &origin {
        repeat_tuples(&mut mesh.cell_arrays, origin);
    }
    if document.version < FIRST_WITH_PRESENT_ORDER {
        order::swap(&mut mesh, notes);
    }
    let first = pieces.iter().find(|piece| piece.n_points > 0);
    Ok(Raw {
        mesh,
        global_nodes: first.and_then(|piece| piece.global_nodes.clone()),
        global_cells: first.and_then(|piece| piece.global_cells.clone()),
    })
}

/// Points and cells that are listed; where each cell comes from, unless all are as listed.
fn unstructured(document: &mut Document, notes: &mut Notes) -> Result<(Mesh, Option<Vec<usize>>)> {
    let points = points(&document.pieces, &document.layout)?;
    let built = match document.grid {
        Grid::Poly => cells::read_lists(&mut document.pieces, &document.layout, notes),
        _ => cells::read(&document.pieces, &document.layout, notes),
    };
    let built = built.map_err(|error| error.dataset("Cells"))?;
    let mesh = Mesh {
        points,
        cells: built.cells,
        ..Mesh::default()
    };
    Ok((mesh, built.origin))
}

fn point_data<'d, 'a>(piece: &'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>) {
    (piece.n_points, &piece.point_data)
}

fn cell_data<'d, 'a>(piece: &'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>) {
    (piece.n_cells, &piece.cell_data)
}

/// Coordinates of the nodes of all pieces.
pub(super) fn points(pieces: &[Piece], layout: &Layout) -> Result<Vec<[f64; 3]>> {
    let mut points = Vec::new();
    for piece in pieces {
        let array = match piece.points.as_slice() {
            [array] => array,
            [] if piece.n_points == 0 => continue,
            arrays => {
                let found = arrays.len();
                let message = format!("a piece needs one array of points, found {found}");
                return Err(Error::input(message).dataset("Points"));
            }
        };
        if array.n_components != 3 || array.element == Element::String {
            return Err(Error::input(format!(
                "points are {} of {} components; they must be numbers, 3 a point",
                array.element.name(),
                array.n_components
            ))
            .dataset("Points"));
        }
        let n = count(piece.n_points).map_err(|error| error.dataset("Points"))?;
        let first = points.len();
        with_type!(array.element, T => collect(
            array, layout, 3, Some(n), &mut points,
            |chunk, out| { chunk.convert::<T, f64>(out.as_flattened_mut(), T::as_f64); Ok(()) },
        )?);
        if array.place == Place::Ascii {
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
            "{n} is more than the 4294967294 that can be held"
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
    fill: impl Fn(Chunk, &mut [U]) -> Result<()>,
) -> Result<()> {
    let stored = Stored::open(array, layout)?;
    let result = collect_stored(&stored, array, tuple, expected, out, fill);
    result.map_err(|error| error.dataset(&array.name))
}

fn collect_stored<U: Copy + Default + Send>(
    stored: &Stored,
    array: &Array,
    tuple: usize,
    expected: Option<usize>,
    out: &mut Vec<U>,
    fill: impl Fn(Chunk, &mut [U]) -> Result<()>,
) -> Result<()> {
    let width = array.element.size().checked_mul(tuple);
    let width = width.ok_or_else(|| Error::input(format!("tuples of {tuple} components")))?;
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
    let before = out.len();
    let n_tuples = expected.or(stored.n_bytes().map(|n| n / width));
    stored.for_each(width, &mut |chunk| {
        let n = chunk.bytes.len() / width;
        let start = out.len();
        if n_tuples.is_some_and(|n_tuples| start - before + n > n_tuples) {
            return wrong(counted(stored.n_values(), "value"));
        }
        grow(out, n, n_tuples.unwrap_or(0));
        fill(chunk, &mut out[start..])
    })?;
    match n_tuples {
        Some(n) if out.len() - before != n => wrong(counted(out.len() - before, "tuple")),
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
