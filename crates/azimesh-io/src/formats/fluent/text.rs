//! Numbers of a body of text, in pieces on all threads: coordinates, and faces in hexadecimal numbers.

use super::content::{FaceList, NONE};
use crate::formats::lexer::{Fields, line_of, shown};
use azimesh_core::error::{Error, Position, Result, counted};
use azimesh_core::parallel::map_items;
use std::ops::Range;

/// Bytes of a piece.
const PIECE: usize = 1 << 20;

/// The coordinates in these bytes: `n` nodes of 2 or 3 numbers.
pub(super) fn points(
    bytes: &[u8],
    body: Range<usize>,
    n: usize,
    dimension: usize,
) -> Result<Vec<[f64; 3]>> {
    // A number and the blank before it have two bytes.
    if n.saturating_mul(2 * dimension) > body.len() + 1 {
        let error = too_short(bytes, &body, format!("{n} nodes of {dimension} numbers"));
        return Err(of_line(bytes, &body, &|_| dimension, "a node", error));
    }
    let parse = |range: Range<usize>| -> Result<Vec<[f64; 3]>> {
        let mut words = Fields::between(bytes, range.clone());
        let mut points = Vec::with_capacity(range.len() / (12 * dimension));
        while !words.is_done() {
            let mut point = [0.0; 3];
            for x in &mut point[..dimension] {
                *x = words.real("a coordinate")?;
            }
            points.push(point);
        }
        Ok(points)
    };
    let parts = in_pieces(bytes, &body, &parse);
    let parts = parts.map_err(|error| of_line(bytes, &body, &|_| dimension, "a node", error))?;
    let found: usize = parts.iter().map(Vec::len).sum();
    if found != n {
        let error = wrong_number(found, n, "node");
        return Err(of_line(bytes, &body, &|_| dimension, "a node", error));
    }
    Ok(joined(parts))
}

/// All parts one after another.
fn joined<T: Copy + Default + Send + Sync>(mut parts: Vec<Vec<T>>) -> Vec<T> {
    if parts.len() == 1 {
        return parts.remove(0);
    }
    let mut all = vec![T::default(); parts.iter().map(Vec::len).sum()];
    let mut rest = &mut all[..];
    let mut tasks = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, tail) = rest.split_at_mut(part.len());
        tasks.push((own, part));
        rest = tail;
    }
    map_items(tasks, &|_, (own, part)| own.copy_from_slice(&part));
    all
}

/// What a piece gives; where its lines are no whole records, all of the body as one piece.
fn in_pieces<T: Send>(
    bytes: &[u8],
    body: &Range<usize>,
    parse: &(dyn Fn(Range<usize>) -> Result<T> + Sync),
) -> Result<Vec<T>> {
    let pieces = pieces(bytes, body);
    let parts: Result<Vec<T>> = map_items(pieces, &|_, piece| parse(piece))
        .into_iter()
        .collect();
    parts.or_else(|_| Ok(vec![parse(body.clone())?]))
}

/// The body in pieces that end at line ends.
fn pieces(bytes: &[u8], body: &Range<usize>) -> Vec<Range<usize>> {
    let mut pieces = Vec::new();
    let mut from = body.start;
    while from < body.end {
        let wanted = body.end.min(from + PIECE);
        let rest = &bytes[wanted..body.end];
        let end = memchr::memchr(b'\n', rest).map_or(body.end, |n| wanted + n + 1);
        pieces.push(from..end);
        from = end;
    }
    pieces
}

/// The faces in these bytes: `n` of `size` nodes each, or of several sizes, each with its size before it.
pub(super) fn faces(bytes: &[u8], body: Range<usize>, n: usize, size: usize) -> Result<FaceList> {
    let words = if size == 0 { 3 } else { size + 2 };
    let record = |first: &[u8]| match size {
        0 => {
            let text = std::str::from_utf8(first).unwrap_or("");
            usize::from_str_radix(text, 16).map_or(0, |n| n.saturating_add(3))
        }
        size => size + 2,
    };
    if n.saturating_mul(2 * words) > body.len() + 1 {
        let least = if size == 0 { " or more" } else { "" };
        let said = format!("{n} faces of {words} numbers{least}");
        let error = too_short(bytes, &body, said);
        return Err(of_line(bytes, &body, &record, "a face", error));
    }
    let parts = in_pieces(bytes, &body, &|range| faces_of(bytes, range, size));
    let parts = parts.map_err(|error| of_line(bytes, &body, &record, "a face", error))?;
    let found: usize = parts.iter().map(FaceList::len).sum();
    if found != n {
        let error = wrong_number(found, n, "face");
        return Err(of_line(bytes, &body, &record, "a face", error));
    }
    let mut ends = Vec::new();
    let mut before = 0_usize;
    for part in &parts {
        ends.extend(part.ends.iter().map(|end| (before + *end as usize) as u32));
        before += part.nodes.len();
    }
    // Ends that do not fit are refused with the faces of all sections together.
    let (nodes, cells) = parts
        .into_iter()
        .map(|part| (part.nodes, part.cells))
        .unzip();
    Ok(FaceList {
        size,
        ends,
        nodes: joined(nodes),
        cells: joined(cells),
    })
}

fn faces_of(bytes: &[u8], range: Range<usize>, size: usize) -> Result<FaceList> {
    let mut words = Hexadecimal {
        bytes: &bytes[..range.end],
        at: range.start,
    };
    let n_expected = range.len() / 32;
    let mut list = FaceList {
        size,
        ends: Vec::new(),
        nodes: Vec::with_capacity(n_expected * size.max(3)),
        cells: Vec::with_capacity(n_expected),
    };
    while words.is_more() {
        let n = match size {
            0 => words.next("the number of nodes of a face")? as usize,
            size => size,
        };
        for _ in 0..n {
            list.nodes.push(words.next("a node")?.wrapping_sub(1));
        }
        let cells = [words.next("a cell")?, words.next("a cell")?];
        list.cells.push(cells.map(|cell| cell.wrapping_sub(1)));
        if size == 0 {
            list.ends.push(list.nodes.len() as u32);
        }
    }
    debug_assert_eq!(0_u32.wrapping_sub(1), NONE);
    Ok(list)
}

/// Hexadecimal numbers between blanks.
pub(super) struct Hexadecimal<'a> {
    /// Up to the end of the numbers.
    pub bytes: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
}

impl Hexadecimal<'_> {
    /// Passes over blanks; whether a number follows.
    #[inline]
    pub fn is_more(&mut self) -> bool {
        while let Some(byte) = self.bytes.get(self.at) {
            if !byte.is_ascii_whitespace() {
                return true;
            }
            self.at += 1;
        }
        false
    }

    /// The next number.
    #[inline]
    pub fn next(&mut self, what: &str) -> Result<u32> {
        if !self.is_more() {
            return Err(self.wrong(what));
        }
        let start = self.at;
        let mut value = 0_u64;
        while let Some(digit) = self
            .bytes
            .get(self.at)
            .and_then(|byte| DIGITS[usize::from(*byte)])
        {
            value = value << 4 | u64::from(digit);
            self.at += 1;
            if value > u64::from(u32::MAX) {
                self.at = start;
                return Err(self.wrong(what));
            }
        }
        let is_end = |byte: &u8| byte.is_ascii_whitespace();
        if self.at == start || !self.bytes.get(self.at).is_none_or(is_end) {
            self.at = start;
            return Err(self.wrong(what));
        }
        Ok(value as u32)
    }

    #[cold]
    fn wrong(&self, what: &str) -> Error {
        let rest = &self.bytes[self.at..];
        let n = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let found = match n {
            0 => "the end of the section".to_owned(),
            n => shown(&rest[..n]),
        };
        Error::input(format!(
            "expected {what} as a hexadecimal number of 32 bits, found {found}"
        ))
        .line(line_of(self.bytes, self.at))
    }
}

/// What each byte is worth as a digit.
static DIGITS: [Option<u8>; 256] = {
    let mut digits = [None; 256];
    let mut byte = 0;
    while byte < 256 {
        digits[byte] = match byte as u8 {
            digit @ b'0'..=b'9' => Some(digit - b'0'),
            digit @ b'a'..=b'f' => Some(digit - b'a' + 10),
            digit @ b'A'..=b'F' => Some(digit - b'A' + 10),
            _ => None,
        };
        byte += 1;
    }
    digits
};

fn too_short(bytes: &[u8], body: &Range<usize>, said: String) -> Error {
    Error::input(format!(
        "the section says that it has {said}, but it has only {}",
        counted(n_words(&bytes[body.clone()]), "number")
    ))
}

/// Words between blanks.
fn words(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = bytes.split(u8::is_ascii_whitespace);
    words.filter(|word| !word.is_empty())
}

/// Number of words between blanks.
pub(super) fn n_words(bytes: &[u8]) -> usize {
    words(bytes).count()
}

/// The line of a word of a body, counted from 0.
pub(super) fn line_of_word(bytes: &[u8], body: &Range<usize>, word: usize) -> u64 {
    let found = words(&bytes[body.clone()]).nth(word);
    let at = found.map(|word| word.as_ptr() as usize - bytes.as_ptr() as usize);
    line_of(bytes, at.unwrap_or(body.start))
}

/// The error of a body, or that of the first line which has more or fewer numbers than a record, where that stands before:
/// what follows such a line is shifted. Bodies whose first line is no record have lines as they like.
fn of_line(
    bytes: &[u8],
    body: &Range<usize>,
    record: &dyn Fn(&[u8]) -> usize,
    what: &str,
    error: Error,
) -> Error {
    let mut at = body.start;
    let mut is_first = true;
    for line in bytes[body.clone()].split_inclusive(|byte| *byte == b'\n') {
        let Some(first) = words(line).next() else {
            at += line.len();
            continue;
        };
        let (wanted, found) = (record(first), n_words(line));
        if wanted != found {
            let number = line_of(bytes, at);
            if is_first || matches!(error.position, Some(Position::Line(own)) if own <= number) {
                break;
            }
            let n = counted(wanted, "number");
            let message = format!("expected {n} for {what} in this line, found {found}");
            return Error::input(message).line(number);
        }
        is_first = false;
        at += line.len();
    }
    error.line(line_of(bytes, body.start))
}

fn wrong_number(found: usize, n: usize, what: &str) -> Error {
    Error::input(format!(
        "the section says that it has {n} {what}s, but it has {found}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_one_size_and_of_several_are_read_wherever_lines_end() {
        let list = faces(b"1 2 3 a 0\n3 2 4 B 1f\n", 0..21, 2, 3).expect("two faces");
        assert_eq!(list.nodes, [0, 1, 2, 2, 1, 3]);
        assert_eq!(list.cells, [[9, NONE], [10, 30]]);
        assert_eq!((list.size, list.ends.len()), (3, 0));
        let text = b"3 1 2 3 a 0 4 3 2\n4 1 B 1f";
        let list = faces(text, 0..text.len(), 2, 0).expect("two faces");
        assert_eq!(list.ends, [3, 7]);
        assert_eq!(list.nodes(1), [2, 1, 3, 0]);
    }

    #[test]
    fn large_bodies_are_the_same_in_pieces_even_where_lines_cut_faces() {
        let n = 150_000;
        let word = |face: usize, i: usize| format!("{:x}", 1 + (face * 7 + i) % 99_999);
        let record = |face: usize| (0..5).map(|i| word(face, i)).collect::<Vec<_>>().join(" ");
        let by_line: String = (0..n).map(|face| record(face) + "\n").collect();
        assert!(by_line.len() > 3 * PIECE);
        let all: Vec<String> = (0..n).map(record).collect();
        let words = all.join(" ");
        let words: Vec<&str> = words.split(' ').collect();
        let cut: String = words.chunks(7).map(|line| line.join(" ") + "\n").collect();
        let read = |text: &str| faces(text.as_bytes(), 0..text.len(), n, 3).expect("all faces");
        assert_eq!(read(&by_line), read(&cut));
        let error = faces(by_line.as_bytes(), 0..by_line.len(), n - 1, 3).expect_err("one more");
        assert!(error.to_string().contains("it has 150000"), "{error}");
        let damaged = by_line.replacen("\n1 2 ", "\n1 x ", 1);
        let error = faces(damaged.as_bytes(), 0..damaged.len(), n, 3).expect_err("no number");
        assert!(error.to_string().contains("found \"x\""), "{error}");
    }

    #[test]
    fn a_line_of_too_few_or_too_many_numbers_is_named() {
        let told = |text: &str, size: usize| {
            let error = faces(text.as_bytes(), 0..text.len(), 3, size).expect_err("a wrong line");
            error.to_string()
        };
        assert_eq!(
            told("\n1 2 3 a 0\n2 3 a 0\n3 4 5 a 0\n", 3),
            "line 3: expected 5 numbers for a face in this line, found 4"
        );
        assert_eq!(
            told("\n3 1 2 3 a 0\n3 1 2 3 a 0 1\n3 3 4 5 a 0\n", 0),
            "line 3: expected 6 numbers for a face in this line, found 7"
        );
        // The wrong word comes first, or lines are cut anywhere.
        assert!(
            told("\n1 2 3 a 0\n1 2 x a 0\n3 4 5 a\n", 3).starts_with("line 3: expected a node")
        );
        assert!(told("\n1 2 3\na 0 2 3 a 0\n3 4 5 aaaaa\n", 3).contains("the end of the section"));
        let text = "0.0 0 1\n0.0 1\n1.5 1 1\n";
        let error = points(text.as_bytes(), 0..text.len(), 3, 3).expect_err("a wrong line");
        assert_eq!(
            error.to_string(),
            "line 2: expected 3 numbers for a node in this line, found 2"
        );
        let text = b" a b\n c\n";
        assert_eq!(
            (0..4)
                .map(|i| line_of_word(text, &(0..8), i))
                .collect::<Vec<_>>(),
            [1, 1, 2, 1]
        );
    }

    #[test]
    fn sections_that_cannot_hold_their_numbers_take_no_memory() {
        let error = points(b" 1 2 3 ", 0..7, usize::MAX / 8, 3).expect_err("too few");
        assert!(error.to_string().contains("only 3 numbers"), "{error}");
        let error = faces(b" 1 2 3 ", 0..7, 1 << 40, 0).expect_err("too few");
        assert!(error.to_string().contains("only 3 numbers"), "{error}");
    }
}
