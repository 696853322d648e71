//! Numbers stored as bytes: their type, and their conversion on all threads.

use super::vtk::number::Element::{self, Float32, Float64, Int32, Int64};
use super::vtk::number::{Number, with_type};
use crate::mesh::{Values, arrays::with_numbers, reverse_each};
use azimesh_core::parallel::for_blocks;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Values of a chunk that one task converts.
const PER_TASK: usize = 1 << 16;

/// Type of numbers stored as bytes: kind and width, and byte order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DType {
    pub element: Element,
    /// True if the bytes of each value are in the other order than on this machine.
    pub swap: bool,
}

impl DType {
    /// A type in a byte order.
    pub fn new(element: Element, is_big_endian: bool) -> Self {
        let swap = is_big_endian != cfg!(target_endian = "big");
        Self { element, swap }
    }

    /// Floating-point numbers of 4 or 8 bytes.
    pub fn real(width: usize, is_big_endian: bool) -> Self {
        let element = if width == 4 { Float32 } else { Float64 };
        Self::new(element, is_big_endian)
    }

    /// Signed integers of 4 or 8 bytes.
    pub fn integer(width: usize, is_big_endian: bool) -> Self {
        let element = if width == 4 { Int32 } else { Int64 };
        Self::new(element, is_big_endian)
    }

    /// The numbers in these bytes.
    pub fn of(self, bytes: &[u8]) -> Chunk<'_> {
        let Self { element, swap } = self;
        Chunk {
            bytes,
            element,
            swap,
        }
    }
}

/// Bytes of an array, a whole number of values. Their type is looked at once for each task, so that what reads files
/// is compiled once for all types.
#[derive(Clone, Copy)]
pub struct Chunk<'a> {
    pub bytes: &'a [u8],
    pub element: Element,
    /// True if the bytes of each value are in the other order than on this machine.
    pub swap: bool,
}

impl<'a> Chunk<'a> {
    /// The numbers of an array; `None` for text.
    pub fn of(values: &'a Values) -> Option<Self> {
        let bytes = with_numbers!(values, v => bytemuck::cast_slice(v), _text => return None);
        Some(Self {
            bytes,
            element: Element::of(values),
            swap: false,
        })
    }

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
        let (mut value, part) = ([0], self.part(at..at + 1));
        with_type!(part.element, T => part.map(&mut value, |x: T| x.as_index() as i64));
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
        self.convert(out, &|part, out| part.few_reals(out));
    }

    /// The values as integers.
    pub fn integers(&self, out: &mut [i64]) {
        self.convert(
            out,
            &|part, out| with_type!(part.element, T => part.map(out, |x: T| x.as_index() as i64)),
        );
    }

    /// The values as indices of 32 bits, or as VTK's types of cells; one that is too large becomes the `highest`, which is
    /// too large for every mesh and is no type.
    pub fn narrow<U: TryFrom<u64> + Copy + Send + Sync>(&self, out: &mut [U], highest: U) {
        let narrow = |index| U::try_from(index).unwrap_or(highest);
        self.convert(
            out,
            &|part, out| with_type!(part.element, T => part.map(out, |x: T| narrow(x.as_index()))),
        );
    }

    /// The values as coordinates, on this thread.
    pub fn few_reals(&self, out: &mut [f64]) {
        with_type!(self.element, T => self.map(out, T::as_f64));
    }

    /// Points of 2 or 3 coordinates each.
    pub fn points(&self, dimension: usize) -> Vec<[f64; 3]> {
        let mut points = vec![[0.0; 3]; self.n_values() / dimension];
        if dimension == 3 {
            self.reals(points.as_flattened_mut());
            return points;
        }
        for_blocks(&mut points, PER_TASK, &|first, points| {
            let mut rows = vec![0.0; dimension * points.len()];
            let start = dimension * first;
            self.part(start..start + rows.len()).few_reals(&mut rows);
            for (point, row) in points.iter_mut().zip(rows.chunks_exact(dimension)) {
                point[..dimension].copy_from_slice(row);
            }
        });
        points
    }

    /// Sets one coordinate of every point; returns whether all are finite.
    pub fn axis(&self, axis: usize, points: &mut [[f64; 3]]) -> bool {
        let all_finite = AtomicBool::new(true);
        for_blocks(points, PER_TASK, &|first, points| {
            let part = self.part(first..first + points.len());
            let mut finite = true;
            let places = points.iter_mut().map(|point| &mut point[axis]);
            with_type!(part.element, T => part.map(places, |x: T| {
                let x = x.as_f64();
                finite &= x.is_finite();
                x
            }));
            if !finite {
                all_finite.store(false, Ordering::Relaxed);
            }
        });
        all_finite.into_inner()
    }

    /// Converts `n` numbers, from `first` on, into indices from `base` on; fails with place and value
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

    fn map<'o, T: Number, U: 'o>(
        &self,
        out: impl IntoIterator<Item = &'o mut U>,
        mut of: impl FnMut(T) -> U,
    ) {
        let values = self.bytes.chunks_exact(size_of::<T>()).map(T::from_bytes);
        let places = out.into_iter().zip(values);
        if self.swap {
            places.for_each(|(place, x)| *place = of(x.swapped()));
        } else {
            places.for_each(|(place, x)| *place = of(x));
        }
    }
}
