//! Lists as text, parsed in parts on all threads. Line ends mean nothing: a list is cut between its values.

use super::lists::too_many_nodes;
use super::text::{Text, integer};
use crate::formats::by_faces::Faces;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::map_items;
use std::borrow::Cow;
use std::ops::Range;

/// Bytes that one task parses.
const PART: usize = 1 << 18;
/// Tasks whose results are held before they are put together.
const BATCH: usize = 64;

/// The labels of a list; moves past its closing bracket.
pub(super) fn labels<T: Copy + Send + Sync>(
    text: &mut Text,
    n: Option<usize>,
    of: &(impl Fn(i64) -> Option<T> + Sync),
) -> Result<Vec<T>> {
    let body = Body::up_to_next_bracket(text)?;
    let labels = body.values(text, n, (b' ', 6), |cursor| {
        let place = cursor.at;
        let label = cursor.integer()?;
        of(label).ok_or_else(|| cursor.refuse(place, "an index"))
    })?;
    text.at = body.end + 1;
    Ok(labels)
}

/// The points of a list that ends the file.
pub(super) fn points(text: &mut Text, n: Option<usize>) -> Result<Vec<[f64; 3]>> {
    Body::up_to_last_bracket(text)?.values(text, n, (b')', 20), |cursor| cursor.point())
}

/// One point; moves past it.
pub(super) fn point(text: &mut Text) -> Result<[f64; 3]> {
    text.skip();
    let mut cursor = Cursor::new(text.bytes, text.at..text.end);
    let point = cursor.point().map_err(|found| found.error(text))?;
    text.at = cursor.at;
    Ok(point)
}

/// The faces of a list that ends the file.
pub(super) fn faces(text: &mut Text, n: Option<usize>) -> Result<Faces> {
    let body = Body::up_to_last_bracket(text)?;
    let parse = |part: Range<usize>| {
        let mut faces = (
            Vec::with_capacity(part.len() / 20),
            Vec::with_capacity(part.len() / 6),
        );
        let mut cursor = Cursor::new(&body.bytes, part);
        while !cursor.is_done() {
            let n = cursor.face(&mut faces.1)?;
            faces.0.push(n);
        }
        Ok(faces)
    };
    let (mut starts, mut all) = (vec![0], Vec::new());
    body.parse(text, b')', parse, |(sizes, nodes): (Vec<u32>, Vec<u32>)| {
        let mut end = all.len();
        if end + nodes.len() > u32::MAX as usize {
            return Err(text.error(too_many_nodes()));
        }
        all.extend_from_slice(&nodes);
        starts.extend(sizes.iter().map(|size| {
            end += *size as usize;
            end as u32
        }));
        Ok(())
    })?;
    checked(text, &body, n, starts.len() - 1)?;
    Ok(Faces::new(starts, all))
}

fn checked(text: &Text, body: &Body, n: Option<usize>, found: usize) -> Result<()> {
    match n {
        Some(n) if n != found => Err(text.error_at(
            body.start,
            format!("the list is said to have {n} values, but it has {found}"),
        )),
        _ => Ok(()),
    }
}

/// The values of a list.
struct Body<'a> {
    /// The file, with comments in the list made blanks.
    bytes: Cow<'a, [u8]>,
    start: usize,
    /// Where its closing bracket is.
    end: usize,
}

impl<'a> Body<'a> {
    /// A list whose values have no brackets.
    fn up_to_next_bracket(text: &Text<'a>) -> Result<Self> {
        let length = memchr::memchr2(b')', b'/', text.rest());
        let is_plain = length.is_none_or(|length| text.rest()[length] == b')');
        let mut body = Self::new(text, text.end, is_plain);
        let length = memchr::memchr(b')', &body.bytes[body.start..body.end]);
        body.end = body.start + length.ok_or_else(|| unclosed(text))?;
        Ok(body)
    }

    /// A list after which nothing but comments comes.
    fn up_to_last_bracket(text: &Text<'a>) -> Result<Self> {
        let end = text.at + without_comments(text.rest()).len();
        let is_plain = memchr::memchr(b'/', &text.bytes[text.at..end]).is_none();
        let mut body = Self::new(text, end, is_plain);
        let inside = body.bytes[body.start..body.end].trim_ascii_end();
        let inside = inside.strip_suffix(b")").ok_or_else(|| unclosed(text))?;
        body.end = body.start + inside.len();
        Ok(body)
    }

    fn new(text: &Text<'a>, end: usize, is_plain: bool) -> Self {
        let bytes = if is_plain {
            Cow::Borrowed(text.bytes)
        } else {
            Cow::Owned(blanked(text, end))
        };
        Self {
            bytes,
            start: text.at,
            end,
        }
    }

    /// Parses values, which end with the byte `cut` and take about `length` bytes each.
    fn values<T: Copy + Send>(
        &self,
        text: &Text,
        n: Option<usize>,
        (cut, length): (u8, usize),
        value: impl Fn(&mut Cursor) -> std::result::Result<T, Wrong> + Sync,
    ) -> Result<Vec<T>> {
        let parse = |part: Range<usize>| {
            let mut values = Vec::with_capacity(part.len() / length);
            let mut cursor = Cursor::new(&self.bytes, part);
            while !cursor.is_done() {
                values.push(value(&mut cursor)?);
            }
            Ok(values)
        };
        let mut all = Vec::new();
        self.parse(text, cut, parse, |part| {
            all.extend_from_slice(&part);
            Ok(())
        })?;
        checked(text, self, n, all.len())?;
        Ok(all)
    }

    /// Parses the list in parts, cut behind this byte (a blank for any white space); `add` takes the results in order.
    fn parse<T: Send>(
        &self,
        text: &Text,
        cut: u8,
        parse: impl Fn(Range<usize>) -> std::result::Result<T, Wrong> + Sync,
        mut add: impl FnMut(T) -> Result<()>,
    ) -> Result<()> {
        let mut start = self.start;
        while start < self.end {
            let mut parts = Vec::with_capacity(BATCH);
            while start < self.end && parts.len() < BATCH {
                let end = self.cut_after((start + PART).min(self.end), cut);
                parts.push(start..end);
                start = end;
            }
            let results = map_items(parts, &|_, part| parse(part));
            for result in results {
                add(result.map_err(|wrong| wrong.error(text))?)?;
            }
        }
        Ok(())
    }

    fn cut_after(&self, at: usize, cut: u8) -> usize {
        let rest = &self.bytes[at..self.end];
        let length = match cut {
            b' ' => rest.iter().position(u8::is_ascii_whitespace),
            cut => memchr::memchr(cut, rest),
        };
        at + length.map_or(rest.len(), |length| length + 1)
    }
}

#[cold]
fn unclosed(text: &Text) -> Error {
    text.error("the list that begins here has no closing bracket: the file is cut off or damaged")
}

/// Text without the comments and blanks at its end.
fn without_comments(bytes: &[u8]) -> &[u8] {
    let mut rest = bytes.trim_ascii_end();
    loop {
        let line = memchr::memrchr(b'\n', rest).map_or(0, |at| at + 1);
        let comment = memchr::memmem::find(&rest[line..], b"//").map(|at| line + at);
        let block = rest
            .ends_with(b"*/")
            .then(|| memchr::memmem::rfind(rest, b"/*"))
            .flatten();
        match block.or(comment) {
            Some(at) => rest = rest[..at].trim_ascii_end(),
            None => return rest,
        }
    }
}

/// The file up to `end`, with the comments from the place of `text` on made blanks.
fn blanked(text: &Text, end: usize) -> Vec<u8> {
    let mut bytes = text.bytes[..end].to_vec();
    let mut walk = Text::new(text.bytes, text.at..end);
    while let Some(length) = memchr::memchr(b'/', walk.rest()) {
        walk.at += length;
        let start = walk.at;
        walk.skip();
        let end = walk.at.min(bytes.len());
        for byte in &mut bytes[start..end] {
            *byte = if *byte == b'\n' { b'\n' } else { b' ' };
        }
        walk.at = end.max(start + 1);
    }
    bytes
}

/// What is wrong with a value: where, and what it should be.
struct Wrong {
    at: usize,
    what: &'static str,
}

impl Wrong {
    #[cold]
    fn error(&self, text: &Text) -> Error {
        let here = Text {
            at: self.at.min(text.end),
            ..text.clone()
        };
        here.error(format!("expected {}, found {}", self.what, here.found()))
    }
}

/// A place in a list.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn new(bytes: &'a [u8], part: Range<usize>) -> Self {
        Self {
            bytes: &bytes[..part.end],
            at: part.start,
        }
    }

    #[inline]
    fn skip(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    fn is_done(&mut self) -> bool {
        self.skip();
        self.at == self.bytes.len()
    }

    #[cold]
    fn refuse(&self, at: usize, what: &'static str) -> Wrong {
        Wrong { at, what }
    }

    #[inline]
    fn take(&mut self, byte: u8) -> bool {
        self.skip();
        let is_next = self.bytes.get(self.at) == Some(&byte);
        self.at += usize::from(is_next);
        is_next
    }

    #[inline]
    fn integer(&mut self) -> std::result::Result<i64, Wrong> {
        self.skip();
        match integer(&self.bytes[self.at..]) {
            Some((value, length)) => {
                self.at += length;
                Ok(value)
            }
            None => Err(self.refuse(self.at, "an integer")),
        }
    }

    #[inline]
    fn real(&mut self) -> std::result::Result<f64, Wrong> {
        self.skip();
        match fast_float2::parse_partial::<f64, _>(&self.bytes[self.at..]) {
            Ok((value, length)) if value.is_finite() => {
                let next = self.bytes.get(self.at + length);
                if next.is_some_and(|byte| *byte != b')' && !byte.is_ascii_whitespace()) {
                    return Err(self.refuse(self.at, "a number"));
                }
                self.at += length;
                Ok(value)
            }
            _ => Err(self.refuse(self.at, "a finite number")),
        }
    }

    /// `(x y z)`.
    #[inline]
    fn point(&mut self) -> std::result::Result<[f64; 3], Wrong> {
        if !self.take(b'(') {
            return Err(self.refuse(self.at, "a point, (x y z)"));
        }
        let point = [self.real()?, self.real()?, self.real()?];
        if !self.take(b')') {
            return Err(self.refuse(self.at, ") after three numbers"));
        }
        Ok(point)
    }

    /// `n(a b c ...)`, or without the number: appends the nodes, gives how many there are.
    #[inline]
    fn face(&mut self, nodes: &mut Vec<u32>) -> std::result::Result<u32, Wrong> {
        self.skip();
        let start = self.at;
        let n = match self.bytes.get(self.at) {
            Some(b'(') => None,
            _ => Some(self.integer()?),
        };
        if !self.take(b'(') {
            return Err(self.refuse(self.at, "( before the nodes of a face"));
        }
        let before = nodes.len();
        while !self.take(b')') {
            let place = self.at;
            let node = u32::try_from(self.integer()?);
            nodes.push(node.map_err(|_| self.refuse(place, "the index of a node"))?);
        }
        let found = nodes.len() - before;
        match n {
            Some(n) if n != found as i64 => {
                Err(self.refuse(start, "a face with as many nodes as it says"))
            }
            _ => Ok(found as u32),
        }
    }
}
