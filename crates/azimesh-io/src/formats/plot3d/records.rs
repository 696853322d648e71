//! Binary files: the layouts whose counts fit a file, and the coordinates of its blocks.

use super::super::number::{Chunk, DType};
use super::layout::{Binary, Fit, HEADERS, Layout, header, n_nodes};
use azimesh_core::error::{Error, Result};

/// Bytes of a mark of a record, and of a count.
const MARK: usize = 4;

impl Binary {
    fn integer(&self, bytes: &[u8], at: usize) -> Option<i64> {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        Some(DType::integer(4, self.is_big_endian).of(bytes).integer(0))
    }

    fn reals<'a>(&self, bytes: &'a [u8]) -> Chunk<'a> {
        DType::real(self.real, self.is_big_endian).of(bytes)
    }

    /// The integers of the record of `n` at a place, and what follows it.
    fn record(&self, bytes: &[u8], at: usize, n: usize) -> Option<(Vec<i64>, usize)> {
        let length = n.checked_mul(4)?;
        let mark = if self.has_records { MARK } else { 0 };
        let end = at.checked_add(mark)?.checked_add(length)?;
        if end.checked_add(mark)? > bytes.len() {
            return None;
        }
        let is_mark = |at: usize| self.integer(bytes, at) == i64::try_from(length).ok();
        if self.has_records && !(is_mark(at) && is_mark(end)) {
            return None;
        }
        let mut integers = vec![0; n];
        let stored = DType::integer(4, self.is_big_endian).of(&bytes[at + mark..end]);
        stored.integers(&mut integers);
        Some((integers, end + mark))
    }
}

/// Every layout whose counts fit the length of a file and whose records have right marks.
pub(super) fn fits(bytes: &[u8]) -> Vec<Fit> {
    let mut found = Vec::new();
    for is_big_endian in [false, true] {
        for has_records in [true, false] {
            let binary = Binary {
                is_big_endian,
                has_records,
                real: 0,
            };
            for (is_multi, n_axes) in HEADERS {
                let counts = |at, n| binary.record(bytes, at, n);
                let header = header((is_multi, n_axes), counts);
                let known = header.filter(|(blocks, _)| n_nodes(blocks, bytes.len() / 4).is_some());
                let Some((blocks, start)) = known else {
                    continue;
                };
                for (real, has_blanking) in [(4, false), (4, true), (8, false), (8, true)] {
                    let layout = Layout {
                        binary: Some(Binary { real, ..binary }),
                        is_multi,
                        n_axes,
                        has_blanking,
                    };
                    let blocks = blocks.clone();
                    let fit = Fit {
                        layout,
                        blocks,
                        start,
                    };
                    found.extend(fit.ends_with(bytes).then_some(fit));
                }
            }
        }
    }
    // One that fits is right even where a grid has odd numbers; of several, those with numbers of grids.
    if found.len() > 1 && found.iter().any(|fit| fit.is_plausible(bytes)) {
        found.retain(|fit| fit.is_plausible(bytes));
    }
    found
}

/// Returns whether any layout fits, with numbers such as grids have.
pub(super) fn recognizes(bytes: &[u8]) -> bool {
    // Text never does: its first four characters would be a count of millions.
    bytes.len() >= 24 && fits(bytes).iter().any(|fit| fit.is_plausible(bytes))
}

impl Fit {
    fn binary(&self) -> Binary {
        self.layout.binary.expect("the layout of a binary file")
    }

    /// Bytes of a block with its marks.
    fn block_bytes(&self, n: usize) -> usize {
        let blanking = if self.layout.has_blanking { 4 } else { 0 };
        let binary = self.binary();
        let marks = if binary.has_records { 2 * MARK } else { 0 };
        n * (self.layout.n_axes * binary.real + blanking) + marks
    }

    /// The place of each block's first coordinate, and its nodes.
    fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        let mark = if self.binary().has_records { MARK } else { 0 };
        let mut at = self.start;
        self.blocks.iter().map(move |block| {
            let n = block.iter().product();
            let place = at + mark;
            at += self.block_bytes(n);
            (place, n)
        })
    }

    /// Returns whether the last block ends where the file does, and the records have right marks.
    fn ends_with(&self, bytes: &[u8]) -> bool {
        let size = |block: &[usize; 3]| self.block_bytes(block.iter().product());
        let sizes = self.blocks.iter().map(size);
        if sizes.sum::<usize>().checked_add(self.start) != Some(bytes.len()) {
            return false;
        }
        let binary = self.binary();
        !binary.has_records
            || self.places().all(|(place, n)| {
                let length = self.block_bytes(n) - 2 * MARK;
                let is_mark = |at| binary.integer(bytes, at) == i64::try_from(length).ok();
                is_mark(place - MARK) && is_mark(place + length)
            })
    }

    /// Returns whether some of the coordinates are such as meshes have, and the blanking is small integers.
    fn is_plausible(&self, bytes: &[u8]) -> bool {
        const LOOKED_AT: usize = 4096;
        let binary = self.binary();
        let n_blocks = self.blocks.len() as i64;
        self.places().all(|(place, n)| {
            let n_reals = n * self.layout.n_axes;
            let is_real = |i: usize| {
                let at = place + i * binary.real;
                let mut x = [0.0];
                binary.reals(&bytes[at..at + binary.real]).few_reals(&mut x);
                let x = x[0].abs();
                x == 0.0 || (1e-35..1e20).contains(&x)
            };
            let is_flag = |i: usize| {
                let flag = binary.integer(bytes, place + n_reals * binary.real + 4 * i);
                flag.is_some_and(|flag| (-n_blocks..=n_blocks.max(8)).contains(&flag))
            };
            let step = n_reals / LOOKED_AT + 1;
            (0..n_reals).step_by(step).all(is_real)
                && (!self.layout.has_blanking || (0..n).step_by(n / LOOKED_AT + 1).all(is_flag))
        })
    }

    /// The coordinates of all blocks, and whether nodes are blanked.
    pub fn points(&self, bytes: &[u8]) -> Result<(Vec<[f64; 3]>, bool)> {
        let total = n_nodes(&self.blocks, u32::MAX as usize - 1);
        let total = total
            .ok_or_else(|| Error::input(crate::mesh::too_many("nodes")).byte(self.start as u64))?;
        let mut points = vec![[0.0; 3]; total];
        let (binary, n_axes) = (self.binary(), self.layout.n_axes);
        let real = binary.real;
        let mut rest = &mut points[..];
        let mut is_blanked = false;
        for (place, n) in self.places() {
            let (own, tail) = rest.split_at_mut(n);
            rest = tail;
            let mut all_finite = true;
            for axis in 0..n_axes {
                let start = place + axis * n * real;
                let values = binary.reals(&bytes[start..start + n * real]);
                all_finite &= values.axis(axis, own);
            }
            let wrong = || own.as_flattened().iter().position(|x| !x.is_finite());
            if !all_finite && let Some(value) = wrong() {
                let (i, axis) = (value / 3, value % 3);
                let at = place + (axis * n + i) * real;
                let message = format!(
                    "node {} of a block has a coordinate that is not finite",
                    i + 1
                );
                return Err(Error::input(message).byte(at as u64));
            }
            if self.layout.has_blanking {
                let flags = place + n * n_axes * real;
                let mut flags = bytes[flags..flags + 4 * n].chunks_exact(4);
                is_blanked |= flags.any(|flag| flag == [0; 4]);
            }
        }
        Ok((points, is_blanked))
    }
}
