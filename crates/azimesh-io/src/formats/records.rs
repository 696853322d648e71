//! Writes many records: formats them on all threads and writes them in order.

use azimesh_core::error::{Error, Result};
use azimesh_core::parallel;
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

/// Writes records `0..n`, which `format` appends to a buffer for any range of them. While a batch is
/// written, the next one is formatted.
pub fn write_records(
    out: &mut dyn Write,
    n: usize,
    format: &(dyn Fn(Range<usize>, &mut Vec<u8>) + Sync),
) -> Result<()> {
    if n <= CHUNK {
        let mut buffer = Vec::new();
        format(0..n, &mut buffer);
        return write_all(out, &buffer);
    }
    let chunks: Vec<Range<usize>> = (0..n)
        .step_by(CHUNK)
        .map(|start| start..n.min(start + CHUNK))
        .collect();
    let fill = |batch: &[Range<usize>], buffers: &mut Vec<Vec<u8>>| {
        buffers.resize_with(batch.len(), Vec::new);
        parallel::for_items(buffers, &|i, buffer| {
            buffer.clear();
            format(batch[i].clone(), buffer);
        });
    };
    let (mut ready, mut next) = (Vec::new(), Vec::new());
    let mut batches = chunks.chunks(BATCH);
    fill(batches.next().unwrap_or_default(), &mut ready);
    while !ready.is_empty() {
        let batch = batches.next().unwrap_or_default();
        let mut written = Ok(());
        parallel::with(
            &mut || written = ready.iter().try_for_each(|buffer| write_all(out, buffer)),
            &mut || fill(batch, &mut next),
        );
        written?;
        std::mem::swap(&mut ready, &mut next);
    }
    Ok(())
}

/// Appends an integer as text.
pub fn push_integer(buffer: &mut Vec<u8>, value: u64) {
    let mut digits = [0u8; 20];
    let mut at = digits.len();
    let mut left = value;
    while left >= 100 {
        at -= 2;
        let pair = 2 * (left % 100) as usize;
        [digits[at], digits[at + 1]] = [PAIRS[pair], PAIRS[pair + 1]];
        left /= 100;
    }
    if left >= 10 {
        at -= 2;
        digits[at..at + 2].copy_from_slice(&PAIRS[2 * left as usize..][..2]);
    } else {
        at -= 1;
        digits[at] = b'0' + left as u8;
    }
    buffer.extend_from_slice(&digits[at..]);
}

/// The numbers from 00 to 99.
const PAIRS: &[u8; 200] = b"\
    0001020304050607080910111213141516171819\
    2021222324252627282930313233343536373839\
    4041424344454647484950515253545556575859\
    6061626364656667686970717273747576777879\
    8081828384858687888990919293949596979899";

/// Appends a real as the shortest text that reads back to the same bits.
pub fn push_real(buffer: &mut Vec<u8>, value: f64) {
    let mut text = zmij::Buffer::new();
    buffer.extend_from_slice(text.format(value).as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_written_in_order() {
        let mut out = Vec::new();
        write_records(&mut out, 600_000, &|range, buffer| {
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
