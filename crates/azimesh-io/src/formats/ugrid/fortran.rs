//! Fortran's unformatted records: each has a mark with its length before and after it.
//!
//! A record too long for a mark is a chain of parts. The mark in front of a part is
//! negative where another follows, the one behind it where another came before.

use super::layout::Binary;
use crate::formats::Out;
use azimesh_core::error::{Error, Result};
use std::io::{self, Write};

pub(super) const MARK: usize = 4;
/// Longest part of a record, as compilers cut them.
const LONGEST: u64 = 2_147_483_639;

/// Bytes of the marks around a record of `body` bytes.
pub(super) fn marks(body: u128) -> u128 {
    2 * MARK as u128 * body.div_ceil(LONGEST.into()).max(1)
}

/// The counts, where the file starts with their record.
pub(super) fn header<'a>(bytes: &'a [u8], binary: &Binary) -> Option<&'a [u8]> {
    let end = MARK + binary.header();
    let is_mark = |bytes: &[u8]| binary.integer(bytes) == binary.header() as i64;
    let whole = bytes.get(..end + MARK)?;
    (is_mark(&whole[..MARK]) && is_mark(&whole[end..])).then(|| &whole[MARK..end])
}

/// The data of all records from byte `start` on, in their parts, and where it starts in the file.
pub(super) fn data<'a>(
    bytes: &'a [u8],
    start: usize,
    binary: &Binary,
) -> Result<(Vec<&'a [u8]>, usize)> {
    let mut parts: Vec<&[u8]> = Vec::new();
    let mut at = start;
    while at < bytes.len() {
        let damaged = |found: i64| {
            Error::input(format!(
                "a record mark is {found}, which does not fit the file: its Fortran records are damaged"
            ))
            .byte(at as u64)
        };
        let mark = |at: usize| {
            let mark = bytes.get(at..at.checked_add(MARK)?)?;
            Some(binary.integer(mark).unsigned_abs() as usize)
        };
        let length = mark(at).ok_or_else(|| damaged(bytes.len() as i64 - at as i64))?;
        let end = at.saturating_add(MARK).saturating_add(length);
        if mark(end) != Some(length) {
            return Err(damaged(length as i64));
        }
        parts.push(&bytes[at + MARK..end]);
        at = end + MARK;
    }
    let mark = if parts.is_empty() { 0 } else { MARK };
    Ok((parts, start + mark))
}

/// A sink that puts marks around one record of known length.
pub(super) struct Record<'a> {
    out: &'a mut dyn Write,
    is_big_endian: bool,
    longest: u64,
    /// Bytes of the record, those before the part at hand, and those that are written.
    length: u64,
    start: u64,
    at: u64,
}

impl<'a> Record<'a> {
    /// Starts a record of `length` bytes.
    pub fn new(out: &'a mut dyn Write, binary: &Binary, length: u64) -> io::Result<Self> {
        Self::in_parts(out, binary.is_big_endian, length, LONGEST)
    }

    fn in_parts(
        out: &'a mut dyn Write,
        is_big_endian: bool,
        length: u64,
        longest: u64,
    ) -> io::Result<Self> {
        let mut record = Self {
            out,
            is_big_endian,
            longest,
            length,
            start: 0,
            at: 0,
        };
        record.mark(record.end() < length)?;
        if length == 0 {
            record.mark(false)?;
        }
        Ok(record)
    }

    /// The end of the part at hand.
    fn end(&self) -> u64 {
        self.length.min(self.start + self.longest)
    }

    fn mark(&mut self, is_negative: bool) -> io::Result<()> {
        let length = (self.end() - self.start) as i32;
        let mark = if is_negative { -length } else { length };
        let little = mark.to_le_bytes();
        let bytes = if self.is_big_endian {
            mark.to_be_bytes()
        } else {
            little
        };
        self.out.write_all(&bytes)
    }
}

impl Out for Record<'_> {}

impl Write for Record<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let fits = usize::try_from(self.end() - self.at).unwrap_or(usize::MAX);
        let n = bytes.len().min(fits);
        self.out.write_all(&bytes[..n])?;
        self.at += n as u64;
        if self.at == self.end() && n > 0 {
            self.mark(self.start > 0)?;
            self.start = self.at;
            if self.at < self.length {
                self.mark(self.end() < self.length)?;
            }
        }
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::binary;
    use super::*;

    #[test]
    fn a_record_in_parts_comes_back() {
        let binary = binary(true, 8, 4, true).expect("it is binary");
        let mut file = Vec::new();
        let mut record = Record::in_parts(&mut file, true, 10, 4).expect("a vector takes all");
        record.write_all(&[1, 2, 3]).expect("a vector takes all");
        record
            .write_all(&[4, 5, 6, 7, 8, 9, 10])
            .expect("a vector takes all");
        let minus = (-4i32).to_be_bytes();
        let plus = 4i32.to_be_bytes();
        assert_eq!(file[..4], minus);
        assert_eq!(file[8..12], plus);
        assert_eq!(file[20..24], minus);
        assert_eq!(file[24..28], 2i32.to_be_bytes());
        assert_eq!(file[30..], (-2i32).to_be_bytes());
        let (data, start) = data(&file, 0, &binary).expect("good records");
        assert_eq!(data.concat(), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
        assert_eq!(start, 4);
    }
}
