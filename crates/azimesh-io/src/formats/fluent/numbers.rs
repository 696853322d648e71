//! Numbers of a section, on all threads: coordinates and faces, as text or in the byte order of the file.

use super::content::{FaceList, NONE};
use super::sections::Scanner;
use crate::formats::number::DType;
use crate::formats::tokens::{Tokens, line_of, shown};
use crate::mesh::first_where;
use azimesh_core::error::{Error, Position, Result, counted};
use azimesh_core::parallel::map_items;
use std::ops::Range;

/// Bytes of text that one task parses.
const PIECE: usize = 1 << 20;
/// Faces of binary sections that one task decodes.
const BLOCK: usize = 1 << 15;

/// The numbers of a section.
pub(super) enum Body {
    /// Bytes of text.
    Text(Range<usize>),
    /// Bytes from the scanner's place on, with the type of coordinates; integers have 4 bytes.
    Binary(DType),
}

/// Reads `n` nodes of 2 or 3 coordinates.
pub(super) fn points(
    scanner: &mut Scanner,
    body: &Body,
    n: usize,
    dimension: usize,
) -> Result<Vec<[f64; 3]>> {
    let reals = match body {
        Body::Text(body) => return points_of_text(scanner.bytes, body, n, dimension),
        Body::Binary(reals) => reals,
    };
    let (start, size) = (scanner.at, dimension * reals.element.size());
    let points = reals.of(take(scanner, n, size, "node")?).points(dimension);
    if let Some(value) = first_where(points.as_flattened(), |x| !x.is_finite()) {
        let i = value / 3;
        let message = format!("a coordinate is {:?}, which is not finite", points[i]);
        return Err(Error::input(message).byte((start + i * size) as u64));
    }
    scanner.close_binary()?;
    Ok(points)
}

/// Reads `n` faces of `size` nodes each, or, if it is 0, of several sizes, each after its size.
pub(super) fn faces(scanner: &mut Scanner, body: &Body, n: usize, size: usize) -> Result<FaceList> {
    let swap = match body {
        Body::Text(body) => return faces_of_text(scanner.bytes, body, n, size),
        Body::Binary(reals) => reals.swap,
    };
    let list = binary_faces(scanner, n, size, swap)?;
    scanner.close_binary()?;
    Ok(list)
}

/// Takes the next `n` records of `size` bytes.
fn take<'a>(scanner: &mut Scanner<'a>, n: usize, size: usize, what: &str) -> Result<&'a [u8]> {
    let rest = scanner.rest();
    let wanted = n.checked_mul(size).filter(|wanted| *wanted <= rest.len());
    let Some(wanted) = wanted else {
        return Err(scanner.error(format!(
            "the section says that it has {n} {what}s, but the file ends after {} bytes",
            rest.len()
        )));
    };
    scanner.at += wanted;
    Ok(&rest[..wanted])
}

fn word(bytes: [u8; 4], swap: bool) -> u32 {
    let word = u32::from_ne_bytes(bytes);
    if swap { word.swap_bytes() } else { word }
}

fn binary_faces(scanner: &mut Scanner, n: usize, size: usize, swap: bool) -> Result<FaceList> {
    let (start, words) = (scanner.at, scanner.rest().as_chunks::<4>().0);
    // The words of a face that are no nodes: two cells, and its size before the nodes.
    let n_other = if size == 0 { 3 } else { 2 };
    take(scanner, n, 4 * (size + n_other), "face")?;
    let mut ends = Vec::new();
    if size == 0 {
        scanner.at = start;
        ends = ends_of(scanner, words, n, swap)?;
    }
    let start_of = |face: usize| match face {
        0 => 0,
        _ if size == 0 => ends[face - 1] as usize,
        _ => face * size,
    };
    let (mut nodes, mut cells) = (vec![0; start_of(n)], vec![[0; 2]; n]);
    let mut rest = &mut nodes[..];
    let mut tasks = Vec::with_capacity(n.div_ceil(BLOCK));
    for (i, cells) in cells.chunks_mut(BLOCK).enumerate() {
        let faces = i * BLOCK..i * BLOCK + cells.len();
        let (own, tail) = rest.split_at_mut(start_of(faces.end) - start_of(faces.start));
        tasks.push((faces, own, cells));
        rest = tail;
    }
    let index = |bytes: [u8; 4]| word(bytes, swap).wrapping_sub(1);
    map_items(tasks, &|_, (faces, mut rest, cells)| {
        for (face, cells) in faces.zip(cells) {
            let (nodes, tail) = rest.split_at_mut(start_of(face + 1) - start_of(face));
            rest = tail;
            let at = start_of(face) + n_other * (face + 1) - 2;
            let (of_nodes, of_cells) = words[at..at + nodes.len() + 2].split_at(nodes.len());
            for (node, bytes) in nodes.iter_mut().zip(of_nodes) {
                *node = index(*bytes);
            }
            *cells = [index(of_cells[0]), index(of_cells[1])];
        }
    });
    Ok(FaceList {
        size,
        ends,
        nodes,
        cells,
    })
}

/// Ends of `n` faces of several sizes among all nodes: each end gives the start of the next face. Passes the faces.
fn ends_of(scanner: &mut Scanner, words: &[[u8; 4]], n: usize, swap: bool) -> Result<Vec<u32>> {
    let start = scanner.at;
    let mut ends = Vec::with_capacity(n);
    let (mut at, mut end) = (0_usize, 0_u32);
    for face in 0..n {
        scanner.at = start + 4 * at;
        let Some(count) = words.get(at).map(|bytes| word(*bytes, swap)) else {
            return Err(scanner.error(format!("the file ends after {face} of {n} faces")));
        };
        let next = at.checked_add(count as usize + 3);
        let Some(next) = next.filter(|next| *next <= words.len()) else {
            return Err(scanner.error(format!(
                "face {} of {n} has {count} nodes, beyond the end of the file",
                face + 1
            )));
        };
        at = next;
        // There are fewer nodes than words, but of these there may be more than 32 bits count.
        end = end
            .checked_add(count)
            .ok_or_else(|| scanner.error(TOO_MANY_NODES))?;
        ends.push(end);
    }
    scanner.at = start + 4 * at;
    Ok(ends)
}

pub(super) const TOO_MANY_NODES: &str =
    "the faces have more than 4294967295 nodes together, the most that are read";

fn points_of_text(
    bytes: &[u8],
    body: &Range<usize>,
    n: usize,
    dimension: usize,
) -> Result<Vec<[f64; 3]>> {
    let found = || {
        check_length(bytes, body, n, dimension, || {
            format!("{n} nodes of {dimension} numbers")
        })?;
        let parts = in_pieces(bytes, body, &|range| {
            let mut words = Tokens::between(bytes, range.clone());
            let mut points = Vec::with_capacity(range.len() / (12 * dimension));
            while !words.is_done() {
                let mut point = [0.0; 3];
                for x in &mut point[..dimension] {
                    *x = words.real("a coordinate")?;
                }
                points.push(point);
            }
            Ok(points)
        })?;
        check_number(parts.iter().map(Vec::len).sum(), n, "node")?;
        Ok(joined(parts))
    };
    found().map_err(|error| of_line(bytes, body, &|_| dimension, "a node", error))
}

fn faces_of_text(bytes: &[u8], body: &Range<usize>, n: usize, size: usize) -> Result<FaceList> {
    let found = || {
        let (words, least) = if size == 0 {
            (3, " or more")
        } else {
            (size + 2, "")
        };
        check_length(bytes, body, n, words, || {
            format!("{n} faces of {words} numbers{least}")
        })?;
        let parts = in_pieces(bytes, body, &|range| faces_of(bytes, range, size))?;
        check_number(parts.iter().map(FaceList::len).sum(), n, "face")?;
        let mut ends = Vec::new();
        let mut before = 0_usize;
        for part in &parts {
            // Ends that do not fit are refused with the faces of all sections together.
            ends.extend(part.ends.iter().map(|end| (before + *end as usize) as u32));
            before += part.nodes.len();
        }
        let parts = parts.into_iter().map(|part| (part.nodes, part.cells));
        let (nodes, cells) = parts.unzip();
        Ok(FaceList {
            size,
            ends,
            nodes: joined(nodes),
            cells: joined(cells),
        })
    };
    let record = |first: &[u8]| match size {
        0 => {
            let text = std::str::from_utf8(first).unwrap_or("");
            usize::from_str_radix(text, 16).map_or(0, |n| n.saturating_add(3))
        }
        size => size + 2,
    };
    found().map_err(|error| of_line(bytes, body, &record, "a face", error))
}

/// Refuses `n` records of this many words in a body that is too short for them: a word and a blank have two bytes.
fn check_length(
    bytes: &[u8],
    body: &Range<usize>,
    n: usize,
    words: usize,
    said: impl Fn() -> String,
) -> Result<()> {
    if n.saturating_mul(2 * words) <= body.len() + 1 {
        return Ok(());
    }
    Err(Error::input(format!(
        "the section says that it has {}, but it has only {}",
        said(),
        counted(n_words(&bytes[body.clone()]), "number")
    )))
}

fn check_number(found: usize, n: usize, what: &str) -> Result<()> {
    if found == n {
        return Ok(());
    }
    let message = format!("the section says that it has {n} {what}s, but it has {found}");
    Err(Error::input(message))
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

/// Parses the body in pieces that end at line ends; if these are no whole records, as one piece.
fn in_pieces<T: Send>(
    bytes: &[u8],
    body: &Range<usize>,
    parse: &(dyn Fn(Range<usize>) -> Result<T> + Sync),
) -> Result<Vec<T>> {
    let mut pieces = Vec::new();
    let mut from = body.start;
    while from < body.end {
        let wanted = body.end.min(from + PIECE);
        let rest = &bytes[wanted..body.end];
        let end = memchr::memchr(b'\n', rest).map_or(body.end, |n| wanted + n + 1);
        pieces.push(from..end);
        from = end;
    }
    let parts = map_items(pieces, &|_, piece| parse(piece));
    let parts: Result<Vec<T>> = parts.into_iter().collect();
    parts.or_else(|_| Ok(vec![parse(body.clone())?]))
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
    // A cell 0 becomes NONE.
    const { assert!(0_u32.wrapping_sub(1) == NONE) };
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
    Ok(list)
}

/// Hexadecimal numbers between blanks.
struct Hexadecimal<'a> {
    /// Up to the end of the numbers.
    bytes: &'a [u8],
    at: usize,
}

impl Hexadecimal<'_> {
    /// Passes over blanks; returns whether a number follows.
    #[inline]
    fn is_more(&mut self) -> bool {
        while let Some(byte) = self.bytes.get(self.at) {
            if !byte.is_ascii_whitespace() {
                return true;
            }
            self.at += 1;
        }
        false
    }

    #[inline]
    fn next(&mut self, what: &str) -> Result<u32> {
        self.is_more();
        let start = self.at;
        let digit = |at: usize| DIGITS[usize::from(*self.bytes.get(at)?)];
        let mut value = 0_u64;
        let mut at = start;
        while let Some(digit) = digit(at).filter(|_| value <= u64::from(u32::MAX)) {
            value = value << 4 | u64::from(digit);
            at += 1;
        }
        let is_end = self.bytes.get(at).is_none_or(u8::is_ascii_whitespace);
        if at == start || !is_end || value > u64::from(u32::MAX) {
            return Err(self.wrong(what));
        }
        self.at = at;
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

/// The value of each byte as a digit.
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

/// The error of a body, or, if it is before that, one about the first line with more or fewer numbers than a record: such
/// a line shifts what follows. If the first line is no record, records are not lines.
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
        if let Some(first) = words(line).next() {
            let (wanted, found) = (record(first), n_words(line));
            if wanted != found {
                let number = line_of(bytes, at);
                if is_first || matches!(error.position, Some(Position::Line(own)) if own <= number)
                {
                    break;
                }
                let n = counted(wanted, "number");
                let message = format!("expected {n} for {what} in this line, found {found}");
                return Error::input(message).line(number);
            }
            is_first = false;
        }
        at += line.len();
    }
    error.line(line_of(bytes, body.start))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    #[test]
    fn faces_of_one_size_and_of_several_are_read_wherever_lines_end() {
        let list = faces_of_text(b"1 2 3 a 0\n3 2 4 B 1f\n", &(0..21), 2, 3).expect("two faces");
        assert_eq!(list.nodes, [0, 1, 2, 2, 1, 3]);
        assert_eq!(list.cells, [[9, NONE], [10, 30]]);
        assert_eq!((list.size, list.ends.len()), (3, 0));
        let text = b"3 1 2 3 a 0 4 3 2\n4 1 B 1f";
        let list = faces_of_text(text, &(0..text.len()), 2, 0).expect("two faces");
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
        let read =
            |text: &str| faces_of_text(text.as_bytes(), &(0..text.len()), n, 3).expect("all faces");
        assert_eq!(read(&by_line), read(&cut));
        let error =
            faces_of_text(by_line.as_bytes(), &(0..by_line.len()), n - 1, 3).expect_err("one more");
        assert_says(&error, "it has 150000");
        let damaged = by_line.replacen("\n1 2 ", "\n1 x ", 1);
        let error =
            faces_of_text(damaged.as_bytes(), &(0..damaged.len()), n, 3).expect_err("no number");
        assert_says(&error, "found \"x\"");
    }

    #[test]
    fn a_line_of_too_few_or_too_many_numbers_is_named() {
        let told = |text: &str, size: usize| {
            let error = faces_of_text(text.as_bytes(), &(0..text.len()), 3, size)
                .expect_err("a wrong line");
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
        let error =
            points_of_text(text.as_bytes(), &(0..text.len()), 3, 3).expect_err("a wrong line");
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
        let error = points_of_text(b" 1 2 3 ", &(0..7), usize::MAX / 8, 3).expect_err("too few");
        assert_says(&error, "only 3 numbers");
        let error = faces_of_text(b" 1 2 3 ", &(0..7), 1 << 40, 0).expect_err("too few");
        assert_says(&error, "only 3 numbers");
    }

    fn binary(width: usize, is_big_endian: bool) -> Body {
        Body::Binary(DType::real(width, is_big_endian))
    }

    fn bytes(numbers: &[u32]) -> Vec<u8> {
        numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
    }

    #[test]
    fn faces_of_several_sizes_are_those_of_one_size_each() {
        let n = BLOCK + 7;
        let (mut mixed, mut expected) = (Vec::new(), FaceList::default());
        for face in 0..n as u32 {
            let nodes: Vec<u32> = (0..3 + face % 3).map(|i| 1 + face + i).collect();
            mixed.push(nodes.len() as u32);
            mixed.extend(&nodes);
            mixed.extend([face, face + 1]);
            expected.nodes.extend(nodes.iter().map(|node| node - 1));
            expected.ends.push(expected.nodes.len() as u32);
            expected.cells.push([face.wrapping_sub(1), face]);
        }
        let mixed = bytes(&mixed);
        let mut scanner = Scanner::new(&mixed);
        let list = binary_faces(&mut scanner, n, 0, false).expect("they are whole");
        assert_eq!((list, scanner.at), (expected, mixed.len()));
        let error =
            binary_faces(&mut Scanner::new(&mixed[..400]), n, 0, false).expect_err("cut off");
        assert_says(&error, "says that it has");
        let short = bytes(&[3, 1, 2, 3, 1, 0, 9, 1, 1, 1, 1]);
        let error = binary_faces(&mut Scanner::new(&short), 2, 0, false);
        let error = error.expect_err("cut off").to_string();
        assert_says(&error, "face 2 of 2 has 9 nodes");
    }

    #[test]
    fn a_binary_coordinate_that_is_not_finite_is_refused() {
        let wrong: Vec<u8> = [1.0, f64::NAN]
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let error =
            points(&mut Scanner::new(&wrong), &binary(8, false), 1, 2).expect_err("no number");
        assert_says(&error, "which is not finite");
    }
}
