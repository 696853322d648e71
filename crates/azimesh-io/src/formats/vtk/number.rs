//! Numbers in the bytes or the text of a file.

use super::text::word_end;
use crate::mesh::Values;
use azimesh_core::diagnostic::point;
use azimesh_core::error::{Error, Result};

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

    /// The type of the values of an array.
    pub fn of(values: &Values) -> Self {
        match values {
            Values::I8(_) => Element::Int8,
            Values::U8(_) => Element::UInt8,
            Values::I16(_) => Element::Int16,
            Values::U16(_) => Element::UInt16,
            Values::I32(_) => Element::Int32,
            Values::U32(_) => Element::UInt32,
            Values::I64(_) => Element::Int64,
            Values::U64(_) => Element::UInt64,
            Values::F32(_) => Element::Float32,
            Values::F64(_) => Element::Float64,
            Values::Text(_) => Element::String,
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
        #[inline]
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
        #[inline]
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

/// The bytes of the numbers in `text`, which stand between white space; or where a word is no such number, and a
/// sentence about it.
pub fn parse_words(text: &[u8], element: Element) -> std::result::Result<Vec<u8>, (usize, String)> {
    with_type!(element, T => parse_each::<T>(text)).map_err(|(at, word)| {
        let shown = word[..word.len().min(40)].escape_ascii();
        (
            at,
            format!("\"{shown}\" is not a number of type {}", element.name()),
        )
    })
}

/// Where a word is, and the word.
type Word<'a> = (usize, &'a [u8]);

fn parse_each<T: Number>(text: &[u8]) -> std::result::Result<Vec<u8>, Word<'_>> {
    let mut numbers = Vec::new();
    let mut at = 0;
    while at < text.len() {
        if text[at].is_ascii_whitespace() {
            at += 1;
            continue;
        }
        let end = word_end(text, at);
        let word = &text[at..end];
        let number = T::parse(word).ok_or((at, word))?;
        numbers.extend_from_slice(bytemuck::bytes_of(&number));
        at = end;
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
    let message = format!(
        "node {} is at {}; coordinates must be finite",
        first + value / 3,
        point(&points[value / 3])
    );
    Err((value, Error::input(message)))
}

/// An error about an array that must hold integers.
pub fn need_integers(name: &str, element: Element) -> Result<()> {
    if element.is_integer() {
        return Ok(());
    }
    Err(Error::input(format!(
        "its values have type {}; they must be integers",
        element.name()
    ))
    .dataset(name))
}
