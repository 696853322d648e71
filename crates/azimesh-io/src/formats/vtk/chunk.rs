//! Bytes of an array that are numbers, and their conversion on all threads.

use super::number::{Element, Number, with_type};
use crate::mesh::{Values, arrays::with_numbers};
use azimesh_core::parallel::for_blocks;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Values of a chunk that one task converts.
const PER_TASK: usize = 1 << 16;

/// Bytes of an array, a whole number of values. Their type is looked at once for each task, so that what reads files
/// is compiled once for all types.
#[derive(Clone, Copy)]
pub struct Chunk<'a> {
    /// The bytes.
    pub bytes: &'a [u8],
    /// Type of the values.
    pub element: Element,
    /// Whether the bytes of each value are in the other order than on this machine.
    pub swap: bool,
}

impl<'a> Chunk<'a> {
    /// The numbers of an array; `None` for text.
    pub fn of(values: &'a Values) -> Option<Self> {
        let bytes = with_numbers!(values, v => bytemuck::cast_slice(v), _text => return None);
        let (element, swap) = (Element::of(values), false);
        Some(Self {
            bytes,
            element,
            swap,
        })
    }

    /// Number of values.
    pub fn n_values(&self) -> usize {
        self.bytes.len() / self.element.size()
    }

    /// Some of the values.
    pub fn part(&self, values: Range<usize>) -> Self {
        let size = self.element.size();
        Self {
            bytes: &self.bytes[values.start * size..values.end * size],
            ..*self
        }
    }

    /// The value at `at` as an integer.
    pub fn integer(&self, at: usize) -> i64 {
        let mut value = [0];
        self.part(at..at + 1).integers(&mut value);
        value[0]
    }

    /// The values themselves, of a type of the same size.
    pub fn copy_to<T: bytemuck::Pod>(&self, out: &mut [T]) {
        let out: &mut [u8] = bytemuck::cast_slice_mut(out);
        for_blocks(out, PER_TASK, &|first, out| {
            out.copy_from_slice(&self.bytes[first..first + out.len()]);
            if self.swap {
                reverse_each(out, self.element.size());
            }
        });
    }

    /// The values as coordinates.
    pub fn reals(&self, out: &mut [f64]) {
        self.convert(
            out,
            &|part, out| with_type!(part.element, T => part.map(out, T::as_f64)),
        );
    }

    /// The values as integers.
    pub fn integers(&self, out: &mut [i64]) {
        self.convert(
            out,
            &|part, out| with_type!(part.element, T => part.map(out, |x: T| x.as_index() as i64)),
        );
    }

    /// The values as indices of 32 bits; one that is too large for them is too large for every mesh and becomes the
    /// largest.
    pub fn narrow(&self, out: &mut [u32]) {
        let narrow = |index| u32::try_from(index).unwrap_or(u32::MAX);
        self.convert(
            out,
            &|part, out| with_type!(part.element, T => part.map(out, |x: T| narrow(x.as_index()))),
        );
    }

    /// The values as VTK's types of cells: none is larger than 255, and 255 is none.
    pub fn types(&self, out: &mut [u8]) {
        let narrow = |index| u8::try_from(index).unwrap_or(u8::MAX);
        self.convert(
            out,
            &|part, out| with_type!(part.element, T => part.map(out, |x: T| narrow(x.as_index()))),
        );
    }

    /// The values as coordinates, on this thread.
    pub fn few_reals(&self, out: &mut [f64]) {
        with_type!(self.element, T => self.map(out, T::as_f64));
    }

    /// Converts numbers of which there are `n`, from `first` on, into indices from `base` on; fails with place and value
    /// of one that is no such number.
    pub fn indices(
        &self,
        out: &mut [u32],
        (first, n): (u64, u64),
        base: u32,
    ) -> std::result::Result<(), (usize, String)> {
        let is_wrong = AtomicBool::new(false);
        self.convert(out, &|part, out| {
            let mut any = false;
            with_type!(part.element, T => part.map(out, |x: T| {
                let index = x.as_index().wrapping_sub(first);
                any |= index >= n;
                (index as u32).wrapping_add(base)
            }));
            if any {
                is_wrong.store(true, Ordering::Relaxed);
            }
        });
        if !is_wrong.into_inner() {
            return Ok(());
        }
        let (at, value) = (0..self.n_values())
            .map(|at| (at, self.integer(at)))
            .find(|(_, value)| (*value as u64).wrapping_sub(first) >= n)
            .expect("one was out of range");
        Err(match self.element {
            Element::UInt64 => (at, (value as u64).to_string()),
            _ => (at, value.to_string()),
        })
    }

    /// Calls `fill` on all threads with parts of the values and their places in `out`, which has the same length.
    fn convert<U: Send>(&self, out: &mut [U], fill: &(dyn Fn(Chunk, &mut [U]) + Sync)) {
        for_blocks(out, PER_TASK, &|first, out| {
            fill(self.part(first..first + out.len()), out);
        });
    }

    fn map<T: Number, U>(&self, out: &mut [U], mut of: impl FnMut(T) -> U) {
        let values = self.bytes.chunks_exact(size_of::<T>()).map(T::from_bytes);
        let places = out.iter_mut().zip(values);
        if self.swap {
            places.for_each(|(place, x)| *place = of(x.swapped()));
        } else {
            places.for_each(|(place, x)| *place = of(x));
        }
    }
}

/// Reverses the bytes of each value of `size` bytes.
pub fn reverse_each(bytes: &mut [u8], size: usize) {
    fn reverse<const N: usize>(bytes: &mut [u8]) {
        bytes
            .as_chunks_mut::<N>()
            .0
            .iter_mut()
            .for_each(|value| value.reverse());
    }
    match size {
        2 => reverse::<2>(bytes),
        4 => reverse::<4>(bytes),
        8 => reverse::<8>(bytes),
        _ => {}
    }
}
