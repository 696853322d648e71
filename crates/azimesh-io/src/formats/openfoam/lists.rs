//! Lists of labels, points and faces, binary or as text (`ascii`).
//!
//! The width of binary numbers is the one with which a list ends at its closing bracket: the header may say nothing of
//! it, or something that is not so.

use super::ascii;
use super::file::FoamFile;
use super::text::Text;
use crate::formats::by_faces::Labels;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::collect;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// What of a list comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Open {
    /// `(`: the values follow.
    Values,
    /// `{`: one value for all.
    Uniform,
    /// Nothing: a binary list of no values.
    Nothing,
}

/// How binary numbers are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Bytes of a label, the likeliest first.
    pub labels: [usize; 2],
    /// Bytes of a scalar, the likeliest first.
    pub scalars: [usize; 2],
    /// Highest byte first.
    pub is_big_endian: bool,
}

impl Layout {
    /// As the header of a file has it, else the usual one first.
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

/// The indices of a list, as [`labels_at`], without a copy where the file has them as the machine does. `of` takes all
/// from 0 on as they are.
pub(super) fn indices_at(
    text: &mut Text,
    file: &FoamFile,
    layout: Layout,
    most: usize,
    of: &(impl Fn(i64) -> Option<u32> + Sync),
) -> Result<Labels> {
    let mut after = text.clone();
    if let Some(found) = stored(&mut after, file, layout) {
        *text = after;
        return Ok(found);
    }
    labels_at(text, layout, most, of).map(Labels::from)
}

/// The labels of a list where none is negative and the file has them as the machine does; moves past it.
fn stored(text: &mut Text, file: &FoamFile, layout: Layout) -> Option<Labels> {
    let is_as_here = text.is_binary && layout.is_big_endian == cfg!(target_endian = "big");
    let (Some(n), Open::Values) = head(text).ok()? else {
        return None;
    };
    let mut widths = layout.labels.into_iter();
    let width = widths.find(|width| ends(text, n, *width))?;
    if !is_as_here || width != 4 {
        return None;
    }
    let values = text.at..text.at + n * width;
    text.at = values.end + 1;
    let labels = file.labels(values);
    let is_index = |largest: u32| i32::try_from(largest).is_ok();
    labels.largest().is_none_or(is_index).then_some(labels)
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
            let value = match text.is_binary {
                true => binary_value(text, layout)?,
                false => text.integer("the value of a list")?,
            };
            text.expect(b'}', "after the value of a list")?;
            let value = of(value).ok_or_else(|| wrong_label(text, start, 0, value))?;
            Ok(vec![value; n])
        }
        Open::Values if text.is_binary => {
            let n = needed(text, n)?;
            let width = layout
                .labels
                .into_iter()
                .find(|width| ends(text, n, *width));
            let width = width.ok_or_else(|| cut_off(text, n, "label", layout.labels))?;
            let values = start..start + n * width;
            text.at = values.end + 1;
            decode(text, values, width, layout.is_big_endian, of)
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
            let n = needed(&text, n)?;
            let is_all = |width: &usize| ends_file(&text, n, 3 * width);
            let width = layout.scalars.into_iter().find(is_all);
            let widths = layout.scalars.map(|width| 3 * width);
            let width = width.ok_or_else(|| cut_off(&text, n, "point", widths))?;
            let values = &text.bytes[text.at..text.at + n * 3 * width];
            Ok(decode_points(values, width, layout.is_big_endian))
        }
        Open::Values => ascii::points(&mut text, n),
    }
}

/// The start of a list, `List<...>`, the number of values and a bracket, which it moves past.
pub(super) fn head(text: &mut Text) -> Result<(Option<usize>, Open)> {
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

pub(super) fn needed(text: &Text, n: Option<usize>) -> Result<usize> {
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

/// Whether `n` values of so many bytes, from here on, end at a closing bracket.
pub(super) fn ends(text: &Text, n: usize, size: usize) -> bool {
    let end = n.checked_mul(size).and_then(|n| n.checked_add(text.at));
    let Some(end) = end.filter(|end| *end < text.end && text.bytes[*end] == b')') else {
        return false;
    };
    let next = text.bytes[end + 1..text.end].first();
    next.is_none_or(|byte| byte.is_ascii_whitespace() || matches!(byte, b';' | b'/' | b')'))
}

/// [`ends`] where nothing but comments follows.
fn ends_file(text: &Text, n: usize, size: usize) -> bool {
    ends(text, n, size) && {
        let mut after = text.clone();
        after.at += n * size + 1;
        after.peek().is_none()
    }
}

#[cold]
pub(super) fn cut_off(text: &Text, n: usize, what: &str, sizes: [usize; 2]) -> Error {
    let [low, high] = [sizes[0].min(sizes[1]), sizes[0].max(sizes[1])];
    let left = text.end.saturating_sub(text.at);
    text.error(format!(
        "the list of {n} {what}s ends at a closing bracket neither with {low} nor with {high} bytes a {what}: \
         {left} bytes follow, so the file is cut off or damaged"
    ))
}

#[cold]
pub(super) fn wrong_label(text: &Text, start: usize, i: usize, value: i64) -> Error {
    text.error_at(
        start,
        format!("value {i} of the list is {value}, which is no index"),
    )
}

/// The one binary label of a list of equal values, before its `}`.
fn binary_value(text: &mut Text, layout: Layout) -> Result<i64> {
    let rest = text.rest();
    let width = layout
        .labels
        .into_iter()
        .find(|width| rest.get(*width) == Some(&b'}'));
    let Some(width) = width else {
        return Err(text.error("the value of a list does not end at its }"));
    };
    text.at += width;
    Ok(number(&rest[..width], layout.is_big_endian))
}

/// A label of 4 or 8 bytes.
pub(super) fn number(bytes: &[u8], is_big_endian: bool) -> i64 {
    let mut wide = [0; 8];
    let n = bytes.len().min(8);
    wide[..n].copy_from_slice(&bytes[..n]);
    if is_big_endian {
        wide[..n].reverse();
    }
    match n {
        4 => i64::from(u64::from_le_bytes(wide) as u32 as i32),
        _ => i64::from_le_bytes(wide),
    }
}

fn decode<T: Copy + Default + Send + Sync>(
    text: &Text,
    values: Range<usize>,
    width: usize,
    is_big_endian: bool,
    of: &(impl Fn(i64) -> Option<T> + Sync),
) -> Result<Vec<T>> {
    let bytes = &text.bytes[values.clone()];
    let is_wrong = AtomicBool::new(false);
    let checked = |label: i64| {
        of(label).unwrap_or_else(|| {
            is_wrong.store(true, Ordering::Relaxed);
            T::default()
        })
    };
    let n = bytes.len() / width;
    let all = match (width, is_big_endian) {
        (4, false) => {
            let bytes = bytes.as_chunks::<4>().0;
            collect(n, |i| checked(i32::from_le_bytes(bytes[i]).into()))
        }
        (8, false) => {
            let bytes = bytes.as_chunks::<8>().0;
            collect(n, |i| checked(i64::from_le_bytes(bytes[i])))
        }
        _ => collect(n, |i| {
            checked(number(&bytes[i * width..(i + 1) * width], is_big_endian))
        }),
    };
    if is_wrong.into_inner() {
        let label = |i: usize| number(&bytes[i * width..(i + 1) * width], is_big_endian);
        let i = (0..n).find(|i| of(label(*i)).is_none()).unwrap_or(0);
        return Err(wrong_label(text, values.start + i * width, i, label(i)));
    }
    Ok(all)
}

fn decode_points(bytes: &[u8], width: usize, is_big_endian: bool) -> Vec<[f64; 3]> {
    let n = bytes.len() / (3 * width);
    if width == 8 {
        let bytes = bytes.as_chunks::<8>().0.as_chunks::<3>().0;
        return match is_big_endian {
            false => collect(n, |i| bytes[i].map(f64::from_le_bytes)),
            true => collect(n, |i| bytes[i].map(f64::from_be_bytes)),
        };
    }
    let bytes = bytes.as_chunks::<4>().0.as_chunks::<3>().0;
    match is_big_endian {
        false => collect(n, |i| bytes[i].map(|x| f32::from_le_bytes(x).into())),
        true => collect(n, |i| bytes[i].map(|x| f32::from_be_bytes(x).into())),
    }
}
