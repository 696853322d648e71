//! Reading UGRID from text: numbers between white space, wherever lines end.

use super::super::Notes;
use super::super::tokens::{Tokens, shown, without_comments};
use super::Ugrid;
use super::layout::{Counts, KINDS, N_FACE_KINDS};
use super::read::no_such_node;
use crate::mesh::Mesh;
use azimesh_core::diagnostic::formats::NotKept;
use azimesh_core::error::{Error, Result, option};

/// Checks if seven counts are at the start, with about as much text behind them as they need.
pub(super) fn fits(bytes: &[u8]) -> bool {
    let Ok((counts, rest)) = counts(bytes) else {
        return false;
    };
    let n_numbers = 3 * counts.n_nodes as u128 + counts.n_integers() as u128;
    let mut first = Tokens::new(&bytes[rest..]).next_word();
    let is_number = first
        .as_mut()
        .is_some_and(|word| word.real("a coordinate").is_ok());
    counts.is_mesh() && is_number && n_numbers * 2 <= (bytes.len() - rest) as u128 + 1
}

/// The counts, and the byte behind them.
fn counts(bytes: &[u8]) -> Result<(Counts, usize)> {
    let mut lexer = Tokens::new(bytes);
    let mut numbers = [0; 7];
    for number in &mut numbers {
        let word = lexer.next_word();
        let mut word =
            word.ok_or_else(|| lexer.error("the file ends within the seven counts at its start"))?;
        *number = word.integer("one of the seven counts")?;
    }
    let counts = Counts::of(numbers).map_err(|refusal| lexer.error(refusal))?;
    Ok((counts, lexer.position()))
}

/// The mesh in a text, which may have comments, and the number of each boundary face.
pub(super) fn read(bytes: &[u8], flavour: &Ugrid, notes: &mut Notes) -> Result<(Mesh, Vec<i32>)> {
    let plain = without_comments(bytes);
    let found = read_plain(plain.as_deref().unwrap_or(bytes), flavour, notes)?;
    if plain.is_some() {
        notes.dialect(bytes);
    }
    Ok(found)
}

fn read_plain(bytes: &[u8], flavour: &Ugrid, notes: &mut Notes) -> Result<(Mesh, Vec<i32>)> {
    let (counts, start) = counts(bytes).map_err(|error| binary_instead(error, bytes, flavour))?;
    let tokens = Tokens::between(bytes, start..bytes.len());
    let words = tokens.words();
    let n_found = words.len();
    let n_needed = 3 * counts.n_nodes + counts.n_integers();
    if n_found < n_needed {
        return Err(tokens.error_at_end(format!(
            "the counts at the start need {n_needed} numbers, the file ends after {n_found}"
        )));
    }
    let mut points = vec![[0.0; 3]; counts.n_nodes];
    let mut integers = vec![0u32; counts.n_integers()];
    let reals = points.as_flattened_mut();
    words.parse_into(reals, "a coordinate", &mut integers, |words, first, out| {
        parse_integers(words, &counts, first, out)
    })?;
    let first = counts.n_entries(N_FACE_KINDS);
    let face_numbers = integers.drain(first..first + counts.n_faces());
    let face_numbers = face_numbers.map(|bits| bits as i32).collect();
    notes.dialect(bytes);
    notes.count(n_found - n_needed, |n| NotKept::Rest { n, what: "numbers" });
    let mesh = Mesh {
        points,
        cells: counts.cells(integers),
        ..Mesh::default()
    };
    Ok((mesh, face_numbers))
}

/// Adds to an error what the file may be instead.
fn binary_instead(mut error: Error, bytes: &[u8], flavour: &Ugrid) -> Error {
    if let Some(name) = flavour.other(bytes) {
        error.message += &format!(" (read as text; it would fit {} {name})", option("format"));
    } else if bytes.iter().take(64).any(|byte| *byte == 0) {
        let start = shown(&bytes[..bytes.len().min(16)]);
        error.message = format!("expected text, found binary data: {start}");
    }
    error
}

/// Parses integers from number `first` on: nodes counted from 0, bits of the face numbers.
fn parse_integers(
    words: &mut Tokens,
    counts: &Counts,
    first: usize,
    out: &mut [u32],
) -> Result<()> {
    let (mut at, end) = (first, first + out.len());
    let mut out = out.iter_mut();
    for kind in 0..KINDS.len() {
        if kind == N_FACE_KINDS {
            let n = counts.n_before(kind).min(end).saturating_sub(at);
            for out in out.by_ref().take(n) {
                *out = words.narrow::<i32>("a face number")? as u32;
            }
            at += n;
        }
        let last = counts.n_before(kind) + counts.n_entries(kind + 1) - counts.n_entries(kind);
        let n = last.min(end).saturating_sub(at);
        for out in out.by_ref().take(n) {
            let node = words.integer("a node index")?;
            *out = match usize::try_from(node) {
                Ok(index) if index >= 1 && index <= counts.n_nodes => (index - 1) as u32,
                _ => return Err(words.error(no_such_node(kind, node, counts.n_nodes))),
            };
        }
        at += n;
    }
    Ok(())
}
