//! Lists of labels, points and faces, binary or as text (`ascii`).
//!
//! The width of binary numbers is the one with which a list ends at its closing bracket: the header may say nothing of
//! it, or something that is not so.

use super::ascii;
use super::file::FoamFile;
use super::text::Text;
use crate::formats::by_faces::{Faces, Labels, regular_size};
use crate::formats::number::DType;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{any, collect};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// The first byte of a list after its number of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Open {
    /// `(`: the values follow.
    Values,
    /// `{`: one value for all.
    Uniform,
    /// Nothing: a binary list of no values.
    Nothing,
}

/// Storage of binary numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Bytes of a label, the likeliest first.
    pub labels: [usize; 2],
    /// Bytes of a scalar, the likeliest first.
    scalars: [usize; 2],
    /// Highest byte first.
    is_big_endian: bool,
}

impl Layout {
    /// The layout in the header of a file, else the usual one first.
    pub fn of(file: &FoamFile) -> Self {
        let either = |likeliest: Option<usize>, usual: usize| match likeliest.unwrap_or(usual) {
            4 => [4, 8],
            _ => [8, 4],
        };
        Self {
            labels: either(file.header.width("label"), 4),
            scalars: either(file.header.width("scalar"), 8),
            is_big_endian: file.header.is_big_endian(),
        }
    }
}

/// The labels in a file; `of` gives `None` for a label that cannot be one. A list of one value for all may have at most
/// so many.
pub(super) fn labels<T: Copy + Default + Send + Sync>(
    file: &FoamFile,
    most: usize,
    of: impl Fn(i64) -> Option<T> + Sync,
) -> Result<Vec<T>> {
    let mut text = file.text();
    file.checked(labels_at(&mut text, Layout::of(file), most, &of))
}

/// The indices in a file, as [`labels`], without a copy where the file has them as the machine does.
pub(super) fn indices(
    file: &FoamFile,
    most: usize,
    of: impl Fn(i64) -> Option<u32> + Sync,
) -> Result<Labels> {
    let mut text = file.text();
    file.checked(indices_at(&mut text, file, Layout::of(file), most, &of))
}

/// The indices of a list, as [`labels_at`], without a copy where the file has them as the machine does and none is
/// negative. `of` takes all from 0 on as they are.
fn indices_at(
    text: &mut Text,
    file: &FoamFile,
    layout: Layout,
    most: usize,
    of: &(impl Fn(i64) -> Option<u32> + Sync),
) -> Result<Labels> {
    let mut after = text.clone();
    if text.is_binary
        && layout.is_big_endian == cfg!(target_endian = "big")
        && let Ok((n, Open::Values)) = head(&mut after)
        && let Ok((values, 4)) = binary(&mut after, n, "label", layout.labels, ends)
    {
        let labels = file.labels(values);
        let is_index = |largest: u32| i32::try_from(largest).is_ok();
        if labels.largest().is_none_or(is_index) {
            *text = after;
            return Ok(labels);
        }
    }
    labels_at(text, layout, most, of).map(Labels::from)
}

/// The labels of a list; moves past it.
pub(super) fn labels_at<T: Copy + Default + Send + Sync>(
    text: &mut Text,
    layout: Layout,
    most: usize,
    of: &(impl Fn(i64) -> Option<T> + Sync),
) -> Result<Vec<T>> {
    let (n, open) = head(text)?;
    let start = text.at;
    match open {
        Open::Nothing => Ok(Vec::new()),
        Open::Uniform => {
            let n = checked_uniform(text, n, most)?;
            let value = if text.is_binary {
                binary_value(text, layout)?
            } else {
                text.integer("the value of a list")?
            };
            text.expect(b'}', "after the value of a list")?;
            let value = of(value).ok_or_else(|| wrong_label(text, start, 0, value))?;
            Ok(vec![value; n])
        }
        Open::Values if text.is_binary => {
            let (values, width) = binary(text, n, "label", layout.labels, ends)?;
            match width {
                1 => decode::<1, T>(text, values, layout, of),
                4 => decode::<4, T>(text, values, layout, of),
                _ => decode::<8, T>(text, values, layout, of),
            }
        }
        Open::Values => ascii::labels(text, n, of),
    }
}

/// The points in a file; as text or binary, in 64 or 32 bits.
pub(super) fn points(file: &FoamFile, most: usize) -> Result<Vec<[f64; 3]>> {
    file.checked(points_in(file, most))
}

fn points_in(file: &FoamFile, most: usize) -> Result<Vec<[f64; 3]>> {
    let mut text = file.text();
    let layout = Layout::of(file);
    let (n, open) = head(&mut text)?;
    match open {
        Open::Nothing => Ok(Vec::new()),
        Open::Uniform if text.is_binary => {
            Err(text.error("all points are at one place; there must be a list of them"))
        }
        Open::Uniform => {
            let n = checked_uniform(&text, n, most)?;
            let point = ascii::point(&mut text)?;
            text.expect(b'}', "after the value of a list")?;
            Ok(vec![point; n])
        }
        Open::Values if text.is_binary => {
            let sizes = layout.scalars.map(|width| 3 * width);
            let (values, size) = binary(&mut text, n, "point", sizes, ends_file)?;
            let reals = DType::real(size / 3, layout.is_big_endian);
            Ok(reals.of(&text.bytes[values]).points(3))
        }
        Open::Values => ascii::points(&mut text, n),
    }
}

/// The faces in a file: a `faceList`, or a `faceCompactList` (where each starts, then the nodes of all).
pub(super) fn faces(file: &FoamFile) -> Result<Faces> {
    let mut text = file.text();
    let layout = Layout::of(file);
    let faces = match file.header.class.as_str() {
        "faceCompactList" => compact_faces(&text, file, layout),
        _ => head(&mut text).and_then(|(n, open)| match open {
            Open::Nothing => Ok(Faces::default()),
            Open::Uniform => {
                Err(text.error("all faces are the same; there must be a list of them"))
            }
            Open::Values if text.is_binary => {
                let n = needed(&text, n)?;
                of_either_width(&text, layout, |text, layout| binary_faces(text, n, layout))
            }
            Open::Values => ascii::faces(&mut text, n),
        }),
    };
    file.checked(faces)
}

/// Reads with the one width of labels, and then with the other; the error comes from the likeliest width.
fn of_either_width<'a, T>(
    text: &Text<'a>,
    layout: Layout,
    read: impl Fn(&mut Text<'a>, Layout) -> Result<T>,
) -> Result<T> {
    let of_width = |width: usize| {
        let labels = [width; 2];
        read(&mut text.clone(), Layout { labels, ..layout })
    };
    let [likeliest, other] = layout.labels;
    let read = of_width(likeliest);
    if !text.is_binary {
        return read;
    }
    read.or_else(|error| of_width(other).map_err(|_| error))
}

fn compact_faces(text: &Text, file: &FoamFile, layout: Layout) -> Result<Faces> {
    let index = |label: i64| u32::try_from(label).ok();
    // The second list settles the width of both.
    let (starts, nodes) = of_either_width(text, layout, |text, layout| {
        let starts = indices_at(text, file, layout, 0, &index)?;
        if starts.is_empty() && text.peek().is_none() {
            return Ok((starts, Labels::default()));
        }
        let nodes = indices_at(text, file, layout, 0, &index)?;
        Ok((starts, nodes))
    })?;
    let list = starts.view();
    let fits = list.first().is_none_or(|first| first.get() == 0)
        && list.last().map_or(0, |last| last.get() as usize) == nodes.len();
    let size = regular_size(list);
    let falls = |i: usize| list[i].get() > list[i + 1].get();
    let is_ascending = size.is_some() || !any(list.len().saturating_sub(1), falls);
    if !is_ascending || !fits {
        return Err(text.error(format!(
            "the faces start at {} places, which do not ascend from 0 to {}, the number of nodes in the list",
            starts.len(),
            nodes.len()
        )));
    }
    Ok(Faces::of_size(size, starts, nodes))
}

/// A binary `faceList`, after its bracket: each face is its number of nodes and a binary list.
fn binary_faces(text: &mut Text, n: usize, layout: Layout) -> Result<Faces> {
    let mut faces = Faces::default();
    let mut nodes = Vec::new();
    for _ in 0..n {
        let (n, open) = head(text)?;
        nodes.clear();
        if open == Open::Values {
            let (values, width) = binary(text, n, "label", layout.labels, ends)?;
            for (i, bytes) in text.bytes[values.clone()].chunks_exact(width).enumerate() {
                let node = number(bytes, layout);
                let index = u32::try_from(node);
                nodes.push(index.map_err(|_| wrong_label(text, values.start, i, node))?);
            }
        } else {
            needed(text, n)?;
        }
        if faces.nodes.len() + nodes.len() > u32::MAX as usize {
            return Err(text.error(too_many_nodes()));
        }
        faces.push(nodes.iter().copied());
    }
    text.expect(b')', "after the last face")?;
    Ok(faces)
}

/// Refuses more nodes of faces than 32 bits count.
pub(super) fn too_many_nodes() -> String {
    "the faces have more than 4294967295 nodes together, the most that are read".to_owned()
}

/// The start of a list, `List<...>`, the number of values and a bracket, which it moves past.
fn head(text: &mut Text) -> Result<(Option<usize>, Open)> {
    if text.peek().is_some_and(|byte| byte.is_ascii_alphabetic()) {
        let place = text.at;
        let word = text.word("a list")?;
        if !word.starts_with(b"List<") {
            return Err(text.error_at(place, "expected a list of values"));
        }
    }
    let n = match text.peek() {
        Some(b'(' | b'{') => None,
        _ => {
            let place = text.at;
            let n = text.integer("the number of values of a list")?;
            let n = usize::try_from(n).ok().filter(|n| *n < u32::MAX as usize);
            let refused = "the number of values of a list must be from 0 to 4294967294";
            Some(n.ok_or_else(|| text.error_at(place, refused))?)
        }
    };
    let open = match text.peek() {
        Some(b'(') => Open::Values,
        Some(b'{') => Open::Uniform,
        _ if n == Some(0) => return Ok((n, Open::Nothing)),
        _ => return Err(text.error(format!("expected ( before a list, found {}", text.found()))),
    };
    text.at += 1;
    Ok((n, open))
}

fn needed(text: &Text, n: Option<usize>) -> Result<usize> {
    n.ok_or_else(|| text.error("a binary list has no number of values"))
}

fn checked_uniform(text: &Text, n: Option<usize>, most: usize) -> Result<usize> {
    match n {
        Some(n) if n <= most => Ok(n),
        Some(n) => Err(text.error(format!(
            "a list of {n} equal values is too long; it can have {most}"
        ))),
        None => Err(text.error("a list of equal values has no number of them")),
    }
}

/// The bytes of a binary list and the size of its values, the first of `sizes` with which it `ends` here; moves past it.
fn binary(
    text: &mut Text,
    n: Option<usize>,
    what: &str,
    sizes: [usize; 2],
    ends: impl Fn(&Text, usize) -> bool,
) -> Result<(Range<usize>, usize)> {
    let n = needed(text, n)?;
    for size in sizes {
        let n_bytes = n.checked_mul(size);
        if let Some(end) = n_bytes.and_then(|n_bytes| text.at.checked_add(n_bytes))
            && ends(text, end)
        {
            let values = text.at..end;
            text.at = end + 1;
            return Ok((values, size));
        }
    }
    let [low, high] = [sizes[0].min(sizes[1]), sizes[0].max(sizes[1])];
    let left = text.end.saturating_sub(text.at);
    Err(text.error(format!(
        "the list of {n} {what}s ends at a closing bracket neither with {low} nor with {high} bytes a {what}: \
         {left} bytes follow, so the file is cut off or damaged"
    )))
}

/// Checks if a list ends here at a closing bracket.
fn ends(text: &Text, end: usize) -> bool {
    if end >= text.end || text.bytes[end] != b')' {
        return false;
    }
    let next = text.bytes[end + 1..text.end].first();
    next.is_none_or(|byte| byte.is_ascii_whitespace() || matches!(byte, b';' | b'/' | b')'))
}

/// [`ends`] where nothing but comments follows.
fn ends_file(text: &Text, end: usize) -> bool {
    ends(text, end) && {
        let mut after = text.clone();
        after.at = end + 1;
        after.peek().is_none()
    }
}

#[cold]
fn wrong_label(text: &Text, start: usize, i: usize, value: i64) -> Error {
    text.error_at(
        start,
        format!("value {i} of the list is {value}, which is no index"),
    )
}

/// The one binary label of a list of equal values, before its `}`.
fn binary_value(text: &mut Text, layout: Layout) -> Result<i64> {
    let rest = text.rest();
    let mut widths = layout.labels.into_iter();
    let width = widths.find(|width| rest.get(*width) == Some(&b'}'));
    let width = width.ok_or_else(|| text.error("the value of a list does not end at its }"))?;
    text.at += width;
    Ok(number(&rest[..width], layout))
}

/// A label of 4 or 8 bytes, or a `bool`.
#[inline]
fn number(bytes: &[u8], layout: Layout) -> i64 {
    let is_big = layout.is_big_endian;
    match (<[u8; 4]>::try_from(bytes), <[u8; 8]>::try_from(bytes)) {
        (Ok(bytes), _) if is_big => i32::from_be_bytes(bytes).into(),
        (Ok(bytes), _) => i32::from_le_bytes(bytes).into(),
        (_, Ok(bytes)) if is_big => i64::from_be_bytes(bytes),
        (_, Ok(bytes)) => i64::from_le_bytes(bytes),
        _ => bytes.first().map_or(0, |byte| i64::from(*byte)),
    }
}

fn decode<const W: usize, T: Copy + Default + Send + Sync>(
    text: &Text,
    values: Range<usize>,
    layout: Layout,
    of: &(impl Fn(i64) -> Option<T> + Sync),
) -> Result<Vec<T>> {
    let bytes = text.bytes[values.clone()].as_chunks::<W>().0;
    let is_wrong = AtomicBool::new(false);
    let all = collect(bytes.len(), |i| {
        of(number(&bytes[i], layout)).unwrap_or_else(|| {
            is_wrong.store(true, Ordering::Relaxed);
            T::default()
        })
    });
    if is_wrong.into_inner() {
        let mut labels = bytes.iter().map(|bytes| number(bytes, layout)).enumerate();
        if let Some((i, label)) = labels.find(|(_, label)| of(*label).is_none()) {
            return Err(wrong_label(text, values.start + i * W, i, label));
        }
    }
    Ok(all)
}
