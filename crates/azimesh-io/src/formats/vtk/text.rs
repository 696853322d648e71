//! Values as text, many at a time; text cut between words.

use super::super::column::Column;
use super::number::{Element, Number, with_type};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::map_blocks;
use std::io::{self, Write};

/// Values that one task turns into text; a multiple of every line length.
const PER_TASK: usize = 7560;

/// Ends of stretches of text of about `length`, between words; the first is `start`.
pub fn cuts(text: &[u8], start: usize, end: usize, length: usize) -> Vec<usize> {
    let mut cuts = vec![start];
    while cuts[cuts.len() - 1] < end {
        cuts.push(word_end(&text[..end], cuts[cuts.len() - 1] + length));
    }
    cuts
}

/// The end of the word that `at` is in.
pub fn word_end(text: &[u8], at: usize) -> usize {
    let Some(rest) = text.get(at..) else {
        return text.len();
    };
    let length = rest.iter().position(u8::is_ascii_whitespace);
    at + length.unwrap_or(rest.len())
}

/// Where the word with this index starts; the end of the text where there are fewer.
pub fn word_start(text: &[u8], index: usize) -> usize {
    let mut at = 0;
    for i in 0.. {
        let blank = text[at..].iter().take_while(|b| b.is_ascii_whitespace());
        at += blank.count();
        if i == index || at == text.len() {
            break;
        }
        at = word_end(text, at);
    }
    at
}

/// An error of the sink.
pub fn failed(error: io::Error) -> Error {
    Error::system(format!("cannot write: {error}"))
}

/// Writes the values as text, a tuple or ten scalars a line.
pub fn ascii(array: &Column, out: &mut dyn Write) -> Result<()> {
    let element = match array.element {
        // Characters are written as numbers.
        Element::String => Element::UInt8,
        element => element,
    };
    let per_line = match array.n_components {
        1 => 10,
        n => n.min(10),
    };
    let per_task = PER_TASK / per_line * per_line * element.size();
    array.for_each(&mut |bytes| {
        for group in bytes.chunks(per_task * 64) {
            let texts = map_blocks(
                group.len(),
                per_task,
                &|range| with_type!(element, T => lines::<T>(&group[range], per_line)),
            );
            for text in texts {
                out.write_all(&text).map_err(failed)?;
            }
        }
        Ok(())
    })
}

fn lines<T: Number>(bytes: &[u8], per_line: usize) -> Vec<u8> {
    let mut text = Vec::with_capacity(bytes.len() * 2);
    for line in bytes.chunks(per_line * size_of::<T>()) {
        for value in line.chunks_exact(size_of::<T>()) {
            T::from_bytes(value).format(&mut text);
            text.push(b' ');
        }
        text.pop();
        text.push(b'\n');
    }
    text
}
