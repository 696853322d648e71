//! Lists of labels, points and faces, binary or as text.
//!
//! The width of binary numbers is the one with which a list ends at its closing bracket: the header may say nothing of
//! it, or something that is not so. Text is parsed in parts on all threads: a list is cut between its values.

use super::file::{FoamFile, Layout};
use super::text::Text;
use crate::formats::by_faces::{Faces, Labels, regular_size};
use crate::formats::number::DType;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::{any, collect, map_items};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes of text that one task parses.
const PART: usize = 1 << 18;
/// Tasks whose results are held before they are put together.
const BATCH: usize = 64;

/// The labels in a file; `of` gives `None` for a label that cannot be one. A list of one value for all may have at most
/// so many.
pub(super) fn labels<T: Copy + Default + Send + Sync>(
    file: &FoamFile,
    most: usize,
    of: impl Fn(i64) -> Option<T> + Sync,
) -> Result<Vec<T>> {
    file.checked(labels_at(&mut file.text(), file.header.layout, most, &of))
}

/// The indices in a file, as [`labels`], without a copy where the file has them as the machine does. Lets go of the memory of
/// a file that is copied.
pub(super) fn indices(
    file: &FoamFile,
    most: usize,
    of: impl Fn(i64) -> Option<u32> + Sync,
) -> Result<Labels> {
    let layout = file.header.layout;
    let labels = file.checked(indices_at(&mut file.text(), file, layout, most, &of))?;
    if !labels.is_stored() {
        file.release();
    }
    Ok(labels)
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
        && let Ok((n, Some(b'('))) = head(&mut after)
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
        None => Ok(Vec::new()),
        Some(b'{') => {
            let n = match n {
                Some(n) if n <= most => n,
                Some(n) => {
                    return Err(text.error(format!(
                        "a list of {n} equal values is too long; it can have {most}"
                    )));
                }
                None => return Err(text.error("a list of equal values has no number of them")),
            };
            let value = if text.is_binary {
                binary_value(text, layout)?
            } else {
                text.integer("the value of a list")?
            };
            text.expect(b'}', "after the value of a list")?;
            let value = of(value).ok_or_else(|| wrong_label(text, start, 0, value))?;
            Ok(vec![value; n])
        }
        _ if text.is_binary => {
            let (values, width) = binary(text, n, "label", layout.labels, ends)?;
            match width {
                1 => decode::<1, T>(text, values, layout, of),
                4 => decode::<4, T>(text, values, layout, of),
                _ => decode::<8, T>(text, values, layout, of),
            }
        }
        _ => values(text, n, b' ', |text| {
            let place = text.at;
            let label = text.digits().ok_or((place, "an integer"))?;
            of(label).ok_or((place, "an index"))
        }),
    }
}

/// The points in a file; as text or binary, in 64 or 32 bits.
pub(super) fn points(file: &FoamFile) -> Result<Vec<[f64; 3]>> {
    let (mut text, layout) = (file.text(), file.header.layout);
    let points = head(&mut text).and_then(|(n, open)| match open {
        None => Ok(Vec::new()),
        Some(b'{') => Err(text.error("all points are at one place; there must be a list of them")),
        _ if text.is_binary => {
            let sizes = layout.scalars.map(|width| 3 * width);
            let (values, size) = binary(&mut text, n, "point", sizes, ends_file)?;
            let reals = DType::real(size / 3, layout.is_big_endian);
            Ok(reals.of(&text.bytes[values]).points(3))
        }
        _ => values(&mut text, n, b')', point),
    });
    file.checked(points)
}

/// The faces in a file: a `faceList`, or a `faceCompactList` (where each starts, then the nodes of all).
pub(super) fn faces(file: &FoamFile) -> Result<Faces> {
    let mut text = file.text();
    let layout = file.header.layout;
    let faces = match file.header.class.as_str() {
        "faceCompactList" => compact_faces(&text, file, layout),
        _ => head(&mut text).and_then(|(n, open)| match open {
            None => Ok(Faces::default()),
            Some(b'{') => Err(text.error("all faces are the same; there must be a list of them")),
            _ if text.is_binary => {
                let n = needed(&text, n)?;
                of_either_width(&text, layout, |text, layout| binary_faces(text, n, layout))
            }
            _ => faces_as_text(&mut text, n),
        }),
    };
    let faces = file.checked(faces)?;
    if !faces.nodes.is_stored() {
        file.release();
    }
    Ok(faces)
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
        if open == Some(b'(') {
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
            return Err(text.error(TOO_MANY_NODES));
        }
        faces.push(nodes.iter().copied());
    }
    text.expect(b')', "after the last face")?;
    Ok(faces)
}

const TOO_MANY_NODES: &str =
    "the faces have more than 4294967295 nodes together, the most that are read";

/// The start of a list, `List<...>`, the number of values and a bracket, which it moves past: `(` before values, `{` before one
/// value for all, none of an empty binary list.
fn head(text: &mut Text) -> Result<(Option<usize>, Option<u8>)> {
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
    match text.peek() {
        Some(open @ (b'(' | b'{')) => {
            text.at += 1;
            Ok((n, Some(open)))
        }
        _ if n == Some(0) => Ok((n, None)),
        _ => Err(text.expected(text.at, "( before a list")),
    }
}

fn needed(text: &Text, n: Option<usize>) -> Result<usize> {
    n.ok_or_else(|| text.error("a binary list has no number of values"))
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
    let left = text.rest().len();
    Err(text.error(format!(
        "the list of {n} {what}s ends at a closing bracket neither with {low} nor with {high} bytes a {what}: \
         {left} bytes follow, so the file is cut off or damaged"
    )))
}

/// Checks if a list ends here at a closing bracket.
fn ends(text: &Text, end: usize) -> bool {
    let next = text.bytes.get(end + 1);
    text.bytes.get(end) == Some(&b')')
        && next.is_none_or(|byte| byte.is_ascii_whitespace() || b";/)".contains(byte))
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
        format!("value {i} of the list is {value}, which is not a valid index"),
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

/// A value of a list as text, or the position and description of what is expected there.
type Parsed<T> = std::result::Result<T, (usize, &'static str)>;

/// The values of a list as text, which end with the byte `cut`; moves past it.
fn values<T: Copy + Send>(
    text: &mut Text,
    n: Option<usize>,
    cut: u8,
    value: impl Fn(&mut Text) -> Parsed<T> + Sync,
) -> Result<Vec<T>> {
    let mut all = Vec::new();
    let new = |n_bytes| Vec::with_capacity(n_bytes / if cut == b' ' { 6 } else { 20 });
    let push = |text: &mut Text, part: &mut Vec<T>| value(text).map(|value| part.push(value));
    parse(text, n, cut, new, push, |_, part| {
        all.extend_from_slice(&part);
        Ok(all.len())
    })?;
    Ok(all)
}

fn faces_as_text(text: &mut Text, n: Option<usize>) -> Result<Faces> {
    let (mut starts, mut all) = (vec![0], Vec::new());
    let new = |n_bytes| {
        (
            Vec::with_capacity(n_bytes / 20),
            Vec::with_capacity(n_bytes / 6),
        )
    };
    let push = |text: &mut Text, (sizes, nodes): &mut (Vec<u32>, Vec<u32>)| {
        face(text, nodes).map(|size| sizes.push(size))
    };
    parse(text, n, b')', new, push, |text, (sizes, nodes)| {
        let mut end = all.len();
        if end + nodes.len() > u32::MAX as usize {
            return Err(text.error(TOO_MANY_NODES));
        }
        all.extend_from_slice(&nodes);
        starts.extend(sizes.iter().map(|size| {
            end += *size as usize;
            end as u32
        }));
        Ok(starts.len() - 1)
    })?;
    Ok(Faces::new(starts, all))
}

/// Parses the values of a list as text in parts, cut behind the byte `cut` (a blank for any white space), and moves past its
/// closing bracket: the last one of the file, or the next one if values have no brackets. `push` adds the next value to a
/// `new` part for so many bytes; `add` takes the parts in order and returns the number of values so far.
fn parse<T: Send>(
    text: &mut Text,
    n: Option<usize>,
    cut: u8,
    new: impl Fn(usize) -> T + Sync,
    push: impl Fn(&mut Text, &mut T) -> Parsed<()> + Sync,
    mut add: impl FnMut(&Text, T) -> Result<usize>,
) -> Result<()> {
    const UNCLOSED: &str =
        "the list that begins here has no closing bracket: the file is cut off or damaged";
    let (start, rest) = (text.clone(), text.rest());
    let ends_file = cut == b')';
    let length = if ends_file {
        memchr::memrchr(b')', rest)
    } else {
        memchr::memchr(b')', rest)
    };
    let length = length.ok_or_else(|| text.error(UNCLOSED))?;
    // A list with comments is not cut, since one may hold brackets.
    let is_plain = memchr::memchr(b'/', &rest[..length]).is_none();
    let mut after = Text {
        at: text.at + length + 1,
        ..text.clone()
    };
    if ends_file && is_plain && after.peek().is_some() {
        return Err(text.error(UNCLOSED));
    }
    let (end, size) = if is_plain {
        (text.at + length, PART)
    } else {
        (text.bytes.len(), rest.len())
    };
    let parse = |mut part: Text| -> Parsed<(T, usize)> {
        let mut values = new(part.bytes.len() - part.at);
        while part.peek().is_some_and(|byte| is_plain || byte != b')') {
            push(&mut part, &mut values)?;
        }
        Ok((values, part.at))
    };
    let (mut next, mut found) = (text.at, 0);
    while next < end {
        let mut parts = Vec::with_capacity(BATCH);
        while next < end && parts.len() < BATCH {
            let from = next;
            next = (next + size).min(end);
            let rest = &text.bytes[next..end];
            let length = match cut {
                b' ' => rest.iter().position(u8::is_ascii_whitespace),
                cut => memchr::memchr(cut, rest),
            };
            next += length.map_or(rest.len(), |length| length + 1);
            parts.push(Text {
                at: from,
                bytes: &text.bytes[..next],
                ..start.clone()
            });
        }
        for part in map_items(parts, &|_, part| parse(part)) {
            let (values, at) = part.map_err(|(at, what)| start.expected(at, what))?;
            text.at = at;
            found = add(&start, values)?;
        }
    }
    if !text.take(b')') || ends_file && text.peek().is_some() {
        return Err(start.error(UNCLOSED));
    }
    match n {
        Some(n) if n != found => Err(start.error(format!(
            "the list is said to have {n} values, but it has {found}"
        ))),
        _ => Ok(()),
    }
}

#[inline]
fn real(text: &mut Text) -> Parsed<f64> {
    text.skip();
    let rest = text.rest();
    match fast_float2::parse_partial::<f64, _>(rest) {
        Ok((value, length)) if value.is_finite() => {
            let ends = |byte: &u8| matches!(byte, b')' | b'/') || byte.is_ascii_whitespace();
            if !rest.get(length).is_none_or(ends) {
                return Err((text.at, "a number"));
            }
            text.at += length;
            Ok(value)
        }
        _ => Err((text.at, "a finite number")),
    }
}

/// `(x y z)`.
#[inline]
fn point(text: &mut Text) -> Parsed<[f64; 3]> {
    if !text.take(b'(') {
        return Err((text.at, "a point, (x y z)"));
    }
    let point = [real(text)?, real(text)?, real(text)?];
    if !text.take(b')') {
        return Err((text.at, ") after three numbers"));
    }
    Ok(point)
}

/// `n(a b c ...)`, or without the number: appends the nodes, gives how many there are.
#[inline]
fn face(text: &mut Text, nodes: &mut Vec<u32>) -> Parsed<u32> {
    let n = match text.peek() {
        Some(b'(') => None,
        _ => Some((text.at, text.digits().ok_or((text.at, "an integer"))?)),
    };
    if !text.take(b'(') {
        return Err((text.at, "( before the nodes of a face"));
    }
    let before = nodes.len();
    while !text.take(b')') {
        let place = text.at;
        let node = u32::try_from(text.digits().ok_or((text.at, "an integer"))?);
        nodes.push(node.map_err(|_| (place, "the index of a node"))?);
    }
    let found = nodes.len() - before;
    match n {
        Some((place, n)) if n != found as i64 => {
            Err((place, "a face with as many nodes as it says"))
        }
        _ => Ok(found as u32),
    }
}
