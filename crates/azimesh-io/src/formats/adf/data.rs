//! The data of a node: its type, its dimensions, and its values in the byte order of this machine.

use super::file::File;
use crate::formats::vtk::number::Element::{
    self, Float32, Int8, Int32, Int64, UInt8, UInt32, UInt64,
};
use crate::mesh::Values;
use crate::mesh::reverse_each;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::for_blocks;
use bytemuck::allocation::zeroed_vec;
use std::ops::Range;
use std::rc::Rc;

/// Bytes that one task copies.
const PER_TASK: usize = 1 << 18;

/// The places of the bytes of data in the file, in order.
#[derive(Default)]
pub struct Pieces {
    /// For each piece the number of bytes before it, and its place.
    pieces: Vec<(usize, usize)>,
    n_bytes: usize,
}

impl Pieces {
    /// Adds a piece of the file, or of it what is left of `n_bytes` in all.
    pub fn add(&mut self, piece: Range<u64>, n_bytes: u64) {
        let left = n_bytes - self.n_bytes();
        self.pieces.push((self.n_bytes, piece.start as usize));
        self.n_bytes += (piece.end - piece.start).min(left) as usize;
    }

    /// Bytes in all.
    pub fn n_bytes(&self) -> u64 {
        self.n_bytes as u64
    }

    /// Copies the bytes from `first` on.
    fn copy(&self, file: &[u8], first: usize, out: &mut [u8]) {
        let mut at = self.pieces.partition_point(|(before, _)| *before <= first) - 1;
        let mut done = 0;
        while done < out.len() {
            let (before, start) = self.pieces[at];
            let end = self.pieces.get(at + 1).map_or(self.n_bytes, |next| next.0);
            let skip = first + done - before;
            let n = (end - before - skip).min(out.len() - done);
            let from = start + skip;
            out[done..done + n].copy_from_slice(&file[from..from + n]);
            done += n;
            at += 1;
        }
    }
}

/// The data of a node.
pub struct Data {
    file: Rc<File>,
    /// Type of the values in the file.
    element: Element,
    /// True if they are integers of 64 bits by their type, and of 32 in a file of a machine whose long integers have no more.
    is_short: bool,
    shape: Vec<u64>,
    n_values: usize,
    pieces: Pieces,
}

impl Data {
    /// Data of a type, which is at `at`; `pieces` gives the places of so many bytes.
    pub fn new(
        file: &Rc<File>,
        data_type: &[u8],
        shape: Vec<u64>,
        at: u64,
        pieces: impl FnOnce(u64) -> Result<Pieces>,
    ) -> Result<Self> {
        let Some((element, is_short)) = type_of(data_type, file.long()) else {
            let name = data_type.escape_ascii();
            let message = format!(
                "data of the type \"{name}\" is not read; C1, B1, I4, I8, U4, U8, R4 and R8 are"
            );
            return Err(file.refuse(message, at));
        };
        let length = file.source.bytes().len() as u64;
        let n_bytes = if shape.contains(&0) {
            Some(0)
        } else {
            shape
                .iter()
                .try_fold(element.size() as u64, |product, n| product.checked_mul(*n))
        };
        let Some(n_bytes) = n_bytes.filter(|n| *n <= length) else {
            let message = format!(
                "data of the dimensions {shape:?} is more than the file, which has {length} bytes"
            );
            return Err(file.refuse(message, at));
        };
        Ok(Self {
            file: file.clone(),
            element,
            is_short,
            shape,
            n_values: n_bytes as usize / element.size(),
            pieces: pieces(n_bytes)?,
        })
    }

    /// Number of values along each index, the last index running fastest.
    pub fn shape(&self) -> &[u64] {
        &self.shape
    }

    /// Number of rows: values of the first index.
    pub fn n_rows(&self) -> u64 {
        self.shape.first().copied().unwrap_or(1)
    }

    /// Values in one row.
    pub fn row(&self) -> Result<usize> {
        let n_rows = usize::try_from(self.n_rows()).unwrap_or(usize::MAX);
        Ok(self.n_values.checked_div(n_rows).unwrap_or(0))
    }

    /// `n`: rows can be read in any number.
    pub fn whole_chunks(&self, n: u64) -> u64 {
        n
    }

    /// Refuses rows that are not there.
    pub fn check_rows(&self, rows: &Range<u64>) -> Result<()> {
        let n = self.n_rows();
        if rows.start <= rows.end && rows.end <= n {
            return Ok(());
        }
        let (start, end) = (rows.start, rows.end);
        let message = format!("rows {start} to {end} are needed; it has {n}");
        Err(Error::input(message))
    }

    /// The values of some rows.
    pub fn rows(&self, rows: Range<u64>) -> Result<Values> {
        self.check_rows(&rows)?;
        let row = self.row()?;
        Ok(self.part(rows.start as usize * row..rows.end as usize * row))
    }

    /// All values.
    pub fn values(&self) -> Result<Values> {
        Ok(self.part(0..self.n_values))
    }

    /// The bytes of text.
    pub fn bytes(&self) -> Vec<u8> {
        self.numbers(0..self.n_values)
    }

    fn part(&self, values: Range<usize>) -> Values {
        match self.element {
            Int8 => Values::I8(self.numbers(values)),
            UInt8 => Values::U8(self.numbers(values)),
            Int32 if self.is_short => Values::I64(self.widened::<i32, _>(values)),
            UInt32 if self.is_short => Values::U64(self.widened::<u32, _>(values)),
            Int32 => Values::I32(self.numbers(values)),
            UInt32 => Values::U32(self.numbers(values)),
            Int64 => Values::I64(self.numbers(values)),
            UInt64 => Values::U64(self.numbers(values)),
            Float32 => Values::F32(self.numbers(values)),
            _ => Values::F64(self.numbers(values)),
        }
    }

    fn widened<T: bytemuck::Pod, W: From<T>>(&self, values: Range<usize>) -> Vec<W> {
        let short = self.numbers::<T>(values).into_iter();
        short.map(W::from).collect()
    }

    /// Values of the size of `T`.
    fn numbers<T: bytemuck::Pod>(&self, values: Range<usize>) -> Vec<T> {
        let mut numbers = zeroed_vec::<T>(values.len());
        self.fill(values.start, bytemuck::cast_slice_mut(&mut numbers));
        numbers
    }

    /// The bytes of values from `first` on.
    fn fill(&self, first: usize, out: &mut [u8]) {
        let (pieces, file) = (&self.pieces, self.file.source.bytes());
        let (size, swaps) = (self.element.size(), self.file.swaps());
        let start = first * size;
        for_blocks(out, PER_TASK, &|first, out| {
            pieces.copy(file, start + first, out);
            if swaps {
                reverse_each(out, size);
            }
        });
    }
}

/// The type in the file that a text means, and whether it stands for integers of 64 bits; links are text.
fn type_of(data_type: &[u8], long: usize) -> Option<(Element, bool)> {
    Some(match (data_type, long) {
        (b"C1" | b"LK", _) => (Int8, false),
        (b"B1", _) => (UInt8, false),
        (b"I8", 4) => (Int32, true),
        (b"U8", 4) => (UInt32, true),
        (b"I4", _) => (Int32, false),
        (b"U4", _) => (UInt32, false),
        (b"I8", _) => (Int64, false),
        (b"U8", _) => (UInt64, false),
        (b"R4", _) => (Float32, false),
        (b"R8", _) => (Element::Float64, false),
        _ => return None,
    })
}
