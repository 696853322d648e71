//! Values as text, many at a time.

use super::content::Content;
use super::number::{Element, Number, with_type};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::io::{self, Write};

/// Values that one task turns into text; a multiple of every line length.
const PER_TASK: usize = 7560;

/// An error of the sink.
pub fn failed(error: io::Error) -> Error {
    Error::system(format!("cannot write: {error}"))
}

/// Writes the values as text, a tuple or ten scalars a line.
pub fn ascii(array: &Content, out: &mut dyn Write) -> Result<()> {
    let element = match array.element {
        // Characters are written as numbers.
        Element::String => Element::UInt8,
        element => element,
    };
    let per_line = match array.n_components {
        1 => 10,
        n => n.min(10),
    };
    with_type!(element, T => array.for_each(&mut |bytes| {
        let per_task = PER_TASK / per_line * per_line * size_of::<T>();
        for group in bytes.chunks(per_task * 64) {
            let texts: Vec<Vec<u8>> = group
                .par_chunks(per_task)
                .map(|bytes| lines::<T>(bytes, per_line))
                .collect();
            for text in texts {
                out.write_all(&text).map_err(failed)?;
            }
        }
        Ok(())
    }))
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
