//! Reading UGRID from text: numbers between white space, wherever lines end.
//!
//! The text is cut into pieces whose words are counted first, so that all of them can be parsed
//! at once.

use super::super::dialect::without_comments;
use super::super::lexer::{Fields, Lexer, shown};
use super::Ugrid;
use super::layout::{Content, Counts, KINDS, N_FACE_KINDS, n_nodes};
use crate::formats::Notes;
use azimesh_core::diagnostic::formats::NotKept;
use azimesh_core::error::{Error, Result, option};
use azimesh_core::parallel::{map, map_items};
use std::ops::Range;

/// Bytes of one piece.
const PIECE: usize = 1 << 20;

/// Whether seven counts stand at the start, with about as much text behind them as they need.
pub(super) fn fits(bytes: &[u8]) -> bool {
    let Ok((counts, rest)) = counts(bytes) else {
        return false;
    };
    let n_numbers = 3 * counts.n_nodes as u128 + counts.n_integers() as u128;
    let length = (bytes.len() - rest) as u128;
    let first = Lexer::new(&bytes[rest..], None)
        .word()
        .map(|mut word| word.real("a coordinate").is_ok());
    counts.n_nodes > 0
        && counts.n_cells.iter().any(|n| *n > 0)
        && first == Some(true)
        && n_numbers * 2 <= length + 1
}

/// The counts, and the byte behind them.
fn counts(bytes: &[u8]) -> Result<(Counts, usize)> {
    let mut lexer = Lexer::new(bytes, None);
    let mut numbers = [0; 7];
    for number in &mut numbers {
        let word = lexer.word();
        let mut word =
            word.ok_or_else(|| lexer.error("the file ends within the seven counts at its start"))?;
        *number = word.integer("one of the seven counts")?;
    }
    let counts = Counts::of(numbers).map_err(|refusal| lexer.error(refusal))?;
    Ok((counts, lexer.position()))
}

/// Reads the numbers of a text, which may have comments.
pub(super) fn read(bytes: &[u8], flavour: &Ugrid) -> Result<Content> {
    let Some(plain) = without_comments(bytes) else {
        return read_plain(bytes, flavour);
    };
    let mut content = read_plain(&plain, flavour)?;
    content.notes.dialect(bytes);
    Ok(content)
}

fn read_plain(bytes: &[u8], flavour: &Ugrid) -> Result<Content> {
    let (counts, start) = counts(bytes).map_err(|error| binary_instead(error, bytes, flavour))?;
    let pieces = pieces(bytes, start);
    let sizes = map(pieces.len(), &|i| n_words(&bytes[pieces[i].clone()]));
    let n_found: usize = sizes.iter().sum();
    let n_needed = 3 * counts.n_nodes + counts.n_integers();
    if n_found < n_needed {
        let mut end = Lexer::new(bytes, None);
        end.set_position(bytes.len());
        return Err(end.error(format!(
            "the counts at the start need {n_needed} numbers, the file ends after {n_found}"
        )));
    }
    let (points, mut integers) = parse(bytes, &counts, pieces, &sizes)?;
    let [n_face_entries, _] = counts.n_entries();
    let faces = n_face_entries..n_face_entries + counts.n_faces();
    let face_numbers = integers.drain(faces).map(|bits| bits as i32).collect();
    let mut notes = Notes::default();
    notes.dialect(bytes);
    if n_found > n_needed {
        notes.push(NotKept::Rest {
            n: n_found - n_needed,
            what: "numbers",
        });
    }
    Ok(Content {
        counts,
        points,
        connectivity: integers,
        face_numbers,
        notes,
    })
}

/// Coordinates and integers in the pieces of a text; `sizes` are their numbers of words.
fn parse(
    bytes: &[u8],
    counts: &Counts,
    pieces: Vec<Range<usize>>,
    sizes: &[usize],
) -> Result<(Vec<[f64; 3]>, Vec<u32>)> {
    let mut points = vec![[0.0; 3]; counts.n_nodes];
    let mut integers = vec![0u32; counts.n_integers()];
    let sections = Sections::of(counts);
    let mut tasks = Vec::with_capacity(pieces.len());
    let (mut reals_left, mut integers_left) = (points.as_flattened_mut(), &mut integers[..]);
    let mut first_integer = 0;
    for (piece, &n) in pieces.into_iter().zip(sizes) {
        let (reals, tail) = reals_left.split_at_mut(n.min(reals_left.len()));
        reals_left = tail;
        let n_integers = (n - reals.len()).min(integers_left.len());
        let (own, tail) = integers_left.split_at_mut(n_integers);
        integers_left = tail;
        tasks.push((piece, reals, first_integer, own));
        first_integer += n_integers;
    }
    let results = map_items(tasks, &|_, (piece, reals, first, integers)| {
        let mut words = Fields::between(bytes, piece);
        for x in reals {
            *x = words.real("a coordinate")?;
        }
        sections.parse(&mut words, first, integers)
    });
    results.into_iter().collect::<Result<()>>()?;
    Ok((points, integers))
}

/// Adds to an error what the file may be instead.
fn binary_instead(mut error: Error, bytes: &[u8], flavour: &Ugrid) -> Error {
    match Ugrid::that_fits(bytes) {
        Some(name) if name != flavour.name => {
            error.message += &format!(" (read as text; it would fit {} {name})", option("format"));
        }
        _ if bytes.iter().take(64).any(|byte| *byte == 0) => {
            let start = shown(&bytes[..bytes.len().min(16)]);
            error.message = format!("expected text, found binary data: {start}");
        }
        _ => {}
    }
    error
}

/// The text from `start` on in pieces that end at white space.
fn pieces(bytes: &[u8], start: usize) -> Vec<Range<usize>> {
    let mut pieces = Vec::new();
    let mut from = start;
    while from < bytes.len() {
        let wanted = bytes.len().min(from + PIECE);
        let rest = bytes[wanted..].iter();
        let end = wanted + rest.take_while(|byte| !byte.is_ascii_whitespace()).count();
        pieces.push(from..end);
        from = end;
    }
    pieces
}

fn n_words(bytes: &[u8]) -> usize {
    let is_blank = bytes.iter().map(u8::is_ascii_whitespace);
    let before = std::iter::once(true).chain(is_blank.clone());
    before.zip(is_blank).filter(|&(a, b)| a && !b).count()
}

/// Where the integers of each kind of cell end, and what they may be.
struct Sections {
    n_nodes: usize,
    /// Ends of the sections; face numbers have no kind.
    ends: Vec<(usize, Option<usize>)>,
}

impl Sections {
    fn of(counts: &Counts) -> Self {
        let mut ends = Vec::new();
        let mut end = 0;
        for (i, (kind, n)) in KINDS.iter().zip(counts.n_cells).enumerate() {
            if i == N_FACE_KINDS {
                end += counts.n_faces();
                ends.push((end, None));
            }
            end += n_nodes(*kind) * n;
            ends.push((end, Some(i)));
        }
        Self {
            n_nodes: counts.n_nodes,
            ends,
        }
    }

    /// Parses integers from number `first` on: nodes counted from 0, bits of the face numbers.
    fn parse(&self, words: &mut Fields, first: usize, out: &mut [u32]) -> Result<()> {
        let mut at = first;
        let end = first + out.len();
        let mut out = out.iter_mut();
        for &(section_end, kind) in &self.ends {
            let n = section_end.min(end).saturating_sub(at);
            for out in out.by_ref().take(n) {
                *out = match kind {
                    None => words.narrow::<i32>("a face number")? as u32,
                    Some(kind) => self.node(words, kind)?,
                };
            }
            at += n;
        }
        Ok(())
    }

    fn node(&self, words: &mut Fields, kind: usize) -> Result<u32> {
        let node = words.integer("a node index")?;
        match usize::try_from(node) {
            Ok(index) if index >= 1 && index <= self.n_nodes => Ok((index - 1) as u32),
            _ => Err(words.error(format!(
                "a {} has node {node}, but the mesh has {} nodes, counted from 1",
                KINDS[kind].name(),
                self.n_nodes
            ))),
        }
    }
}
