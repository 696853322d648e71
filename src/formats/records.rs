//! Writing many records: formatted on all threads, written in order; and the sentences about what
//! a format without arrays leaves out.

use super::{Precision, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use rayon::prelude::*;
use std::io::Write;
use std::ops::Range;

/// Records that one task formats at a time.
const CHUNK: usize = 8192;
/// Tasks whose output is held before it is written.
const BATCH: usize = 32;

/// Writes bytes; a refusal is the system's failure.
pub fn write_all(out: &mut dyn Write, bytes: &[u8]) -> Result<()> {
    out.write_all(bytes)
        .map_err(|error| Error::system(error.to_string()))
}

/// Writes records `0..n`, which `format` appends to a buffer for any range of them.
pub fn write_records(
    out: &mut dyn Write,
    n: usize,
    format: impl Fn(Range<usize>, &mut Vec<u8>) + Sync,
) -> Result<()> {
    let chunks: Vec<Range<usize>> = (0..n)
        .step_by(CHUNK)
        .map(|start| start..n.min(start + CHUNK))
        .collect();
    for batch in chunks.chunks(BATCH) {
        let buffers: Vec<Vec<u8>> = batch
            .par_iter()
            .map(|range| {
                let mut buffer = Vec::new();
                format(range.clone(), &mut buffer);
                buffer
            })
            .collect();
        for buffer in buffers {
            write_all(out, &buffer)?;
        }
    }
    Ok(())
}

/// Appends an integer as text.
pub fn push_integer(buffer: &mut Vec<u8>, value: u64) {
    let mut digits = [0u8; 20];
    let mut at = digits.len();
    let mut left = value;
    loop {
        at -= 1;
        digits[at] = b'0' + (left % 10) as u8;
        left /= 10;
        if left == 0 {
            break;
        }
    }
    buffer.extend_from_slice(&digits[at..]);
}

/// Appends a real as the shortest text that reads back to the same bits.
pub fn push_real(buffer: &mut Vec<u8>, value: f64) {
    write!(buffer, "{value:?}").expect("a vector takes every byte");
}

/// A sentence for each array and option that a format with f64 coordinates and without arrays
/// leaves out.
pub fn left_out(format: &str, mesh: &Mesh, options: &WriteOptions) -> Vec<String> {
    left_out_but(format, mesh, options, &[])
}

/// [`left_out`] without the field arrays in `kept`, which the format writes in a way of its own.
pub fn left_out_but(
    format: &str,
    mesh: &Mesh,
    options: &WriteOptions,
    kept: &[&str],
) -> Vec<String> {
    let kinds = [
        ("point", &mesh.point_arrays),
        ("cell", &mesh.cell_arrays),
        ("field", &mesh.field_arrays),
    ];
    let mut notes = Vec::new();
    for (kind, arrays) in kinds {
        let names = arrays.iter().map(|array| array.name.as_str());
        let names = names.filter(|name| kind != "field" || !kept.contains(name));
        let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
        if !names.is_empty() {
            let names = names.join(", ");
            notes.push(format!(
                "{format} holds no {kind} arrays; left out: {names}"
            ));
        }
    }
    if options.precision == Precision::F32 {
        notes.push(format!("{format} holds coordinates in f64 only"));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_written_in_order() {
        let mut out = Vec::new();
        write_records(&mut out, 600_000, |range, buffer| {
            for i in range {
                push_integer(buffer, i as u64);
                buffer.push(b'\n');
            }
        })
        .expect("a vector takes every byte");
        let text = String::from_utf8(out).expect("digits");
        assert!(
            text.lines()
                .enumerate()
                .all(|(i, line)| line == i.to_string())
        );
    }

    #[test]
    fn reals_come_back_to_the_same_bits() {
        for value in [0.1, -0.0, 1e-300, 1.0 / 3.0, 5e-324, f64::MAX, 123456.0] {
            let mut text = Vec::new();
            push_real(&mut text, value);
            let back: f64 = fast_float2::parse(&text).expect("a number");
            assert_eq!(back.to_bits(), value.to_bits());
        }
    }
}
