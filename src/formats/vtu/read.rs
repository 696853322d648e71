//! A .vtu file as a mesh: nodes and arrays of all pieces, one after another.

use super::super::vtk::cells::repeat_tuples;
use super::super::vtk::number::{Chunk, Element, Number, with_type};
use super::super::vtk::{order, tags};
use super::document::{self, Document, Grid, Piece};
use super::stored::Stored;
use super::xml::{self, Array, Layout};
use super::{cells, structured};

use crate::error::{Error, Result};
use crate::formats::{Notes, ReadOptions};
use crate::mesh::{DataArray, Mesh, Values};

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
    let mut document = document::parse(bytes)?;
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
        mesh.field_arrays.push(field(array, layout)?);
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
        with_type!(array.element, T => collect(
            array, layout, 3, Some(n), &mut points,
            |chunk, out| { chunk.convert::<T, f64>(out.as_flattened_mut(), T::as_f64); Ok(()) },
        )?);
    }
    Ok(points)
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
            Some(n) => format!("{n} tuples of {tuple} {element}"),
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
        return wrong(format!("at most {} values", stored.most_values()));
    }
    let before = out.len();
    let n_tuples = expected.or(stored.n_bytes().map(|n| n / width));
    stored.for_each(width, &mut |chunk| {
        let n = chunk.bytes.len() / width;
        let start = out.len();
        if n_tuples.is_some_and(|n_tuples| start - before + n > n_tuples) {
            return wrong("more values".into());
        }
        grow(out, n, n_tuples.unwrap_or(0));
        fill(chunk, &mut out[start..])
    })?;
    match n_tuples {
        Some(n) if out.len() - before != n => wrong(format!("{} tuples", out.len() - before)),
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

/// The arrays that all pieces with nodes (or cells) have, of one type; a note on others.
fn data<'d, 'a: 'd>(
    pieces: &'d [Piece<'a>],
    layout: &Layout,
    what: &str,
    of: impl Fn(&'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>),
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let parts: Vec<_> = pieces.iter().map(of).filter(|(n, _)| *n > 0).collect();
    let Some(((_, first), rest)) = parts.split_first() else {
        return Ok(Vec::new());
    };
    let mut arrays: Vec<DataArray> = Vec::new();
    let mut left_out: Vec<&String> = Vec::new();
    for array in first.iter() {
        let same = |other: &&Array| {
            (
                &other.name,
                other.element,
                other.is_bits,
                other.n_components,
            ) == (
                &array.name,
                array.element,
                array.is_bits,
                array.n_components,
            )
        };
        let others: Option<Vec<_>> = rest
            .iter()
            .map(|(_, part)| part.iter().find(same))
            .collect();
        let Some(others) = others else {
            continue;
        };
        let everywhere: Vec<&Array> = std::iter::once(array).chain(others).collect();
        let mut all = empty(array);
        let mut is_longer = false;
        for ((n, _), array) in parts.iter().zip(everywhere) {
            let n = count(*n).map_err(|error| error.dataset(&array.name))?;
            is_longer = has_more(array, layout, n)?;
            if is_longer {
                break;
            }
            append(&mut all.values, array, layout, Some(n))?;
        }
        if is_longer {
            let name = &array.name;
            notes.push(format!(
                "the {what} array \"{name}\" is left out: it has more tuples than there are {what}s"
            ));
            left_out.push(name);
        } else {
            arrays.push(all);
        }
    }
    for array in parts.iter().flat_map(|(_, part)| part.iter()) {
        let name = &array.name;
        if !left_out.contains(&name) && !arrays.iter().any(|kept| kept.name == *name) {
            notes.push(format!(
                "the {what} array \"{name}\" is left out: the pieces do not all have it alike"
            ));
        }
    }
    Ok(arrays)
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

fn field(array: &Array, layout: &Layout) -> Result<DataArray> {
    let mut all = empty(array);
    let n = array.n_tuples.map(count).transpose();
    let n = n.map_err(|error| error.dataset(&array.name))?;
    append(&mut all.values, array, layout, n)?;
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
fn append(values: &mut Values, array: &Array, layout: &Layout, n: Option<usize>) -> Result<()> {
    macro_rules! numbers {
        ($($variant:ident),*) => {
            match values {
                Values::U8(out) if array.is_bits => bits(array, layout, n, out),
                $(Values::$variant(out) => {
                    let values = n.map(|n| n.checked_mul(array.n_components).unwrap_or(usize::MAX));
                    collect(array, layout, 1, values, out, |chunk, out| {
                        chunk.convert(out, |x| x);
                        Ok(())
                    })
                })*
                Values::Text(out) => strings(array, layout, n, out),
            }
        };
    }
    numbers!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64)?;
    if !values.len().is_multiple_of(array.n_components) {
        let (found, n) = (values.len(), array.n_components);
        let message = format!("{found} values are no whole number of tuples of {n}");
        return Err(Error::input(message).dataset(&array.name));
    }
    Ok(())
}

/// Bits, the first of a byte its highest; as text, a word each.
fn bits(array: &Array, layout: &Layout, n: Option<usize>, out: &mut Vec<u8>) -> Result<()> {
    let n = n.and_then(|n| n.checked_mul(array.n_components));
    let is_text = array.place == xml::Place::Ascii;
    let expected = n.map(|n| if is_text { n } else { n.div_ceil(8) });
    let mut bytes: Vec<u8> = Vec::new();
    collect(array, layout, 1, expected, &mut bytes, |chunk, out| {
        chunk.convert::<u8, u8>(out, |x| x);
        Ok(())
    })?;
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
fn strings(array: &Array, layout: &Layout, n: Option<usize>, out: &mut Vec<String>) -> Result<()> {
    let mut bytes: Vec<u8> = Vec::new();
    if array.place == xml::Place::Ascii {
        let codes = Array {
            element: Element::Int16,
            ..array.clone()
        };
        let mut wide: Vec<i16> = Vec::new();
        collect(&codes, layout, 1, None, &mut wide, |chunk, out| {
            chunk.convert(out, |x| x);
            Ok(())
        })?;
        for code in wide {
            bytes.push(
                u8::try_from(code)
                    .or_else(|_| i8::try_from(code).map(|c| c as u8))
                    .map_err(|_| {
                        Error::input(format!("{code} is no character")).dataset(&array.name)
                    })?,
            );
        }
    } else {
        collect(array, layout, 1, None, &mut bytes, |chunk, out| {
            chunk.convert::<u8, u8>(out, |x| x);
            Ok(())
        })?;
    }
    let before = out.len();
    let mut words = bytes.split(|byte| *byte == 0).collect::<Vec<_>>();
    if words.last().is_some_and(|word| word.is_empty()) {
        words.pop();
    }
    out.extend(
        words
            .iter()
            .map(|word| String::from_utf8_lossy(word).into_owned()),
    );
    let found = out.len() - before;
    match n.map(|n| n.checked_mul(array.n_components)) {
        Some(expected) if expected != Some(found) => {
            let message = format!("{found} strings found, not as many as announced");
            Err(Error::input(message).dataset(&array.name))
        }
        _ => Ok(()),
    }
}
