//! Numbers in the bytes or the text of a file.

use crate::error::{Error, Result};
use rayon::prelude::*;

/// Type of the values of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // VTK's names
pub enum Element {
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float32,
    Float64,
    /// Bytes of NUL-terminated strings.
    String,
}

impl Element {
    const ALL: [Element; 11] = [
        Element::Int8,
        Element::UInt8,
        Element::Int16,
        Element::UInt16,
        Element::Int32,
        Element::UInt32,
        Element::Int64,
        Element::UInt64,
        Element::Float32,
        Element::Float64,
        Element::String,
    ];

    /// VTK's name of the type.
    pub fn name(self) -> &'static str {
        match self {
            Element::Int8 => "Int8",
            Element::UInt8 => "UInt8",
            Element::Int16 => "Int16",
            Element::UInt16 => "UInt16",
            Element::Int32 => "Int32",
            Element::UInt32 => "UInt32",
            Element::Int64 => "Int64",
            Element::UInt64 => "UInt64",
            Element::Float32 => "Float32",
            Element::Float64 => "Float64",
            Element::String => "String",
        }
    }

    /// The type with VTK's name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|element| element.name() == name)
    }

    /// Bytes of one value.
    pub fn size(self) -> usize {
        match self {
            Element::Int8 | Element::UInt8 | Element::String => 1,
            Element::Int16 | Element::UInt16 => 2,
            Element::Int32 | Element::UInt32 | Element::Float32 => 4,
            Element::Int64 | Element::UInt64 | Element::Float64 => 8,
        }
    }

    /// Whether the values are integers.
    pub fn is_integer(self) -> bool {
        !matches!(self, Element::Float32 | Element::Float64 | Element::String)
    }
}

/// Runs `$body` with `$T` standing for the Rust type of `$element`; the bytes of strings are `u8`.
macro_rules! with_type {
    ($element:expr, $T:ident => $body:expr) => {
        match $element {
            Element::Int8 => {
                type $T = i8;
                $body
            }
            Element::UInt8 | Element::String => {
                type $T = u8;
                $body
            }
            Element::Int16 => {
                type $T = i16;
                $body
            }
            Element::UInt16 => {
                type $T = u16;
                $body
            }
            Element::Int32 => {
                type $T = i32;
                $body
            }
            Element::UInt32 => {
                type $T = u32;
                $body
            }
            Element::Int64 => {
                type $T = i64;
                $body
            }
            Element::UInt64 => {
                type $T = u64;
                $body
            }
            Element::Float32 => {
                type $T = f32;
                $body
            }
            Element::Float64 => {
                type $T = f64;
                $body
            }
        }
    };
}
pub(in crate::formats) use with_type;

/// A number as a file holds it.
pub trait Number: bytemuck::Pod + Send + Sync {
    /// From bytes in the byte order of this machine. `bytes` has its size.
    fn from_bytes(bytes: &[u8]) -> Self;
    /// With its bytes reversed.
    fn swapped(self) -> Self;
    /// As an index; whatever cannot be one becomes a number above all indices.
    fn as_index(self) -> u64;
    /// As a coordinate.
    fn as_f64(self) -> f64;
    /// From one word of text.
    fn parse(word: &[u8]) -> Option<Self>;
    /// As text that reads back the same.
    fn format(self, text: &mut Vec<u8>);
}

macro_rules! integer {
    ($($T:ident),*) => { $(impl Number for $T {
        fn from_bytes(bytes: &[u8]) -> Self {
            Self::from_ne_bytes(bytes.try_into().expect("the caller cuts to size"))
        }
        fn swapped(self) -> Self {
            self.swap_bytes()
        }
        fn as_index(self) -> u64 {
            self as i64 as u64
        }
        fn as_f64(self) -> f64 {
            self as f64
        }
        fn parse(word: &[u8]) -> Option<Self> {
            let (negative, digits) = match word {
                [b'-', digits @ ..] => (true, digits),
                [b'+', digits @ ..] => (false, digits),
                digits => (false, digits),
            };
            let magnitude = parse_digits(digits)?;
            let value = if negative { -i128::from(magnitude) } else { magnitude.into() };
            value.try_into().ok()
        }
        fn format(self, text: &mut Vec<u8>) {
            use std::io::Write;
            write!(text, "{self}").expect("writing to memory does not fail");
        }
    })* };
}
integer!(i8, u8, i16, u16, i32, u32, i64, u64);

fn parse_digits(digits: &[u8]) -> Option<u64> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0u64, |value, byte| {
        let digit = byte.wrapping_sub(b'0');
        (digit < 10).then_some(())?;
        value.checked_mul(10)?.checked_add(digit.into())
    })
}

macro_rules! float {
    ($($T:ident),*) => { $(impl Number for $T {
        fn from_bytes(bytes: &[u8]) -> Self {
            Self::from_ne_bytes(bytes.try_into().expect("the caller cuts to size"))
        }
        fn swapped(self) -> Self {
            Self::from_bits(self.to_bits().swap_bytes())
        }
        fn as_index(self) -> u64 {
            u64::MAX
        }
        fn as_f64(self) -> f64 {
            self.into()
        }
        fn parse(word: &[u8]) -> Option<Self> {
            fast_float2::parse(word).ok()
        }
        fn format(self, text: &mut Vec<u8>) {
            use std::io::Write;
            let written = if self.is_nan() { write!(text, "nan") } else { write!(text, "{self:?}") };
            written.expect("writing to memory does not fail");
        }
    })* };
}
float!(f32, f64);

/// Values of a chunk that one task converts.
const PER_TASK: usize = 1 << 16;

/// Bytes of an array, a whole number of values.
#[derive(Clone, Copy)]
pub struct Chunk<'a> {
    pub bytes: &'a [u8],
    /// Whether their order is the other one.
    pub swap: bool,
}

impl Chunk<'_> {
    /// Number of values of type `T`.
    pub fn len<T>(&self) -> usize {
        self.bytes.len() / size_of::<T>()
    }

    /// The value at `index`.
    pub fn get<T: Number>(&self, index: usize) -> T {
        let value = T::from_bytes(&self.bytes[index * size_of::<T>()..][..size_of::<T>()]);
        if self.swap { value.swapped() } else { value }
    }

    /// Converts every value into `out`, which has the same length.
    pub fn convert<T: Number, U: Send>(&self, out: &mut [U], map: impl Fn(T) -> U + Sync) {
        let tasks = self.bytes.par_chunks(PER_TASK * size_of::<T>());
        out.par_chunks_mut(PER_TASK)
            .zip(tasks)
            .for_each(|(out, bytes)| {
                let values = bytes.chunks_exact(size_of::<T>()).map(T::from_bytes);
                if self.swap {
                    out.iter_mut()
                        .zip(values)
                        .for_each(|(out, x)| *out = map(x.swapped()));
                } else {
                    out.iter_mut()
                        .zip(values)
                        .for_each(|(out, x)| *out = map(x));
                }
            });
    }

    /// Converts indices below `limit`, adding `base`; fails with place and value of one that is not.
    pub fn indices<T: Number>(
        &self,
        out: &mut [u32],
        limit: u64,
        base: u32,
    ) -> std::result::Result<(), (usize, String)> {
        let tasks = self.bytes.par_chunks(PER_TASK * size_of::<T>());
        let swap = self.swap;
        let bad = out
            .par_chunks_mut(PER_TASK)
            .zip(tasks)
            .map(|(out, bytes)| {
                let mut bad = false;
                for (out, bytes) in out.iter_mut().zip(bytes.chunks_exact(size_of::<T>())) {
                    let value = T::from_bytes(bytes);
                    let index = if swap { value.swapped() } else { value }.as_index();
                    bad |= index >= limit;
                    *out = (index as u32).wrapping_add(base);
                }
                bad
            })
            .reduce(|| false, |a, b| a | b);
        if bad {
            let found = (0..self.len::<T>())
                .map(|i| (i, self.get::<T>(i)))
                .find(|(_, value)| value.as_index() >= limit);
            let (at, value) = found.expect("one was out of range");
            let mut text = Vec::new();
            value.format(&mut text);
            return Err((at, String::from_utf8_lossy(&text).into_owned()));
        }
        Ok(())
    }
}

/// The numbers in `text`, separated by white space.
pub fn parse_words<T: Number>(
    text: &[u8],
    element: Element,
) -> std::result::Result<Vec<T>, (usize, String)> {
    let mut numbers = Vec::new();
    let mut at = 0;
    while at < text.len() {
        if text[at].is_ascii_whitespace() {
            at += 1;
            continue;
        }
        let rest = &text[at..];
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        let word = &rest[..length];
        let number = T::parse(word).ok_or_else(|| {
            let shown = word[..length.min(40)].escape_ascii();
            (at, format!("\"{shown}\" is no {}", element.name()))
        })?;
        numbers.push(number);
        at += length;
    }
    Ok(numbers)
}

/// Refuses points with a coordinate that is no number; tells which value it is. Nodes count from
/// `first`.
pub fn points_are_finite(
    first: usize,
    points: &[[f64; 3]],
) -> std::result::Result<(), (usize, Error)> {
    let value = points.as_flattened().iter().position(|x| !x.is_finite());
    let Some(value) = value else {
        return Ok(());
    };
    let (node, point) = (first + value / 3, points[value / 3]);
    let message = format!("node {node} has coordinates {point:?}; they must be finite numbers");
    Err((value, Error::input(message)))
}

/// An error about an array that must hold integers.
pub fn need_integers(name: &str, element: Element) -> Result<()> {
    if element.is_integer() {
        return Ok(());
    }
    Err(Error::input(format!(
        "it holds {}; it must hold integers",
        element.name()
    ))
    .dataset(name))
}
