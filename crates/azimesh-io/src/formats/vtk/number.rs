//! Numbers in the bytes or the text of a file.

use crate::formats::column::Column;
use crate::formats::tokens::Tokens;
use crate::mesh::Values;
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::point;
use azimesh_core::parallel::map_blocks;
use std::io::{self, Write};

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

/// Gives each type its Rust type and its kind of [`Values`].
macro_rules! elements {
    ($($name:ident $T:ty, $values:ident;)*) => {
        impl Element {
            const ALL: [Element; 11] = [$(Element::$name),*];

            /// VTK's name of the type.
            pub fn name(self) -> &'static str {
                match self { $(Element::$name => stringify!($name)),* }
            }

            /// The type of the values of an array.
            pub fn of(values: &Values) -> Self {
                match values { $(Values::$values(_) => Element::$name),* }
            }

            /// No values of this type.
            pub fn no_values(self) -> Values {
                match self { $(Element::$name => Values::$values(Vec::new())),* }
            }

            /// Bytes of one value.
            pub fn size(self) -> usize {
                match self { $(Element::$name => size_of::<$T>()),* }
            }
        }
    };
}
elements! {
    Int8 i8, I8;
    UInt8 u8, U8;
    Int16 i16, I16;
    UInt16 u16, U16;
    Int32 i32, I32;
    UInt32 u32, U32;
    Int64 i64, I64;
    UInt64 u64, U64;
    Float32 f32, F32;
    Float64 f64, F64;
    String u8, Text;
}

impl Element {
    /// The type with VTK's name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|element| element.name() == name)
    }

    /// Returns whether the values are integers.
    pub fn is_integer(self) -> bool {
        !matches!(self, Element::Float32 | Element::Float64 | Element::String)
    }
}

/// Runs `$body` with `$T` standing for the Rust type of `$element`; the bytes of strings are `u8`.
macro_rules! with_type {
    ($element:expr, $T:ident => $body:expr) => {
        with_type!($element, $T => $body; Int8 = i8, UInt8 | String = u8, Int16 = i16, UInt16 = u16, Int32 = i32,
            UInt32 = u32, Int64 = i64, UInt64 = u64, Float32 = f32, Float64 = f64)
    };
    ($element:expr, $T:ident => $body:expr; $($($name:ident)|+ = $type:ident),*) => {
        match $element {
            $($(Element::$name)|+ => {
                type $T = $type;
                $body
            })*
        }
    };
}
pub(in crate::formats) use with_type;

/// A number as a file holds it.
pub trait Number: bytemuck::Pod + Send + Sync {
    /// Its type.
    const ELEMENT: Element;
    /// From as many bytes as it has, in the byte order of this machine.
    #[inline]
    fn from_bytes(bytes: &[u8]) -> Self {
        bytemuck::pod_read_unaligned(bytes)
    }
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
    ($($T:ident $element:ident),*) => { $(impl Number for $T {
        const ELEMENT: Element = Element::$element;
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
            write!(text, "{self}").expect("writing to memory does not fail");
        }
    })* };
}
integer!(i8 Int8, u8 UInt8, i16 Int16, u16 UInt16, i32 Int32, u32 UInt32, i64 Int64, u64 UInt64);

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
    ($($T:ident $element:ident),*) => { $(impl Number for $T {
        const ELEMENT: Element = Element::$element;
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
            let written = if self.is_nan() { write!(text, "nan") } else { write!(text, "{self:?}") };
            written.expect("writing to memory does not fail");
        }
    })* };
}
float!(f32 Float32, f64 Float64);

/// The bytes of the numbers in `text`, separated by white space; or the place of a word that is no such number, and a
/// sentence about it.
pub fn parse_words(text: &[u8], element: Element) -> std::result::Result<Vec<u8>, (usize, String)> {
    with_type!(element, T => parse_each::<T>(text)).map_err(|(at, word)| {
        let (shown, name) = (word[..word.len().min(40)].escape_ascii(), element.name());
        (at, format!("\"{shown}\" is not a number of type {name}"))
    })
}

/// Position of a word, and the word.
type Word<'a> = (usize, &'a [u8]);

fn parse_each<T: Number>(text: &[u8]) -> std::result::Result<Vec<u8>, Word<'_>> {
    let (mut numbers, mut words) = (Vec::new(), Tokens::new(text));
    while let Some(word) = words.word() {
        let number = T::parse(word).ok_or((words.position() - word.len(), word))?;
        numbers.extend_from_slice(bytemuck::bytes_of(&number));
    }
    Ok(numbers)
}

/// Refuses points with a coordinate that is not finite and names the value. Nodes count from
/// `first`.
pub fn points_are_finite(
    first: usize,
    points: &[[f64; 3]],
) -> std::result::Result<(), (usize, Error)> {
    let mut values = points.as_flattened().iter();
    let Some(value) = values.position(|x| !x.is_finite()) else {
        return Ok(());
    };
    let (node, at) = (first + value / 3, point(&points[value / 3]));
    let message = format!("node {node} is at {at}; coordinates must be finite");
    Err((value, Error::input(message)))
}

/// Values that one task turns into text; a multiple of every line length.
const PER_TASK: usize = 7560;

/// Ends of stretches of text of about `length`, between words; the first is `start`.
pub fn cuts(text: &[u8], start: usize, end: usize, length: usize) -> Vec<usize> {
    let mut cuts = vec![start];
    while cuts[cuts.len() - 1] < end {
        cuts.push(word_end(&text[..end], cuts[cuts.len() - 1] + length));
    }
    cuts
}

/// The end of the word that `at` is in.
pub fn word_end(text: &[u8], at: usize) -> usize {
    let Some(rest) = text.get(at..) else {
        return text.len();
    };
    let length = rest.iter().position(u8::is_ascii_whitespace);
    at + length.unwrap_or(rest.len())
}

/// Start of the word with this index; the end of the text where there are fewer.
pub fn word_start(text: &[u8], index: usize) -> usize {
    let mut words = Tokens::new(text);
    for _ in 0..index {
        words.word();
    }
    let blanks = words
        .left()
        .iter()
        .take_while(|byte| byte.is_ascii_whitespace());
    words.position() + blanks.count()
}

/// An error of the sink.
pub fn failed(error: io::Error) -> Error {
    Error::system(format!("cannot write: {error}"))
}

/// Writes the values as text, a tuple or ten scalars a line.
pub fn ascii(array: &Column, out: &mut dyn Write) -> Result<()> {
    let element = match array.element {
        // Characters are written as numbers.
        Element::String => Element::UInt8,
        element => element,
    };
    let per_line = match array.n_components {
        1 => 10,
        n => n.min(10),
    };
    let per_task = PER_TASK / per_line * per_line * element.size();
    array.for_each(&mut |bytes| {
        for group in bytes.chunks(per_task * 64) {
            let texts = map_blocks(
                group.len(),
                per_task,
                &|range| with_type!(element, T => lines::<T>(&group[range], per_line)),
            );
            for text in texts {
                out.write_all(&text).map_err(failed)?;
            }
        }
        Ok(())
    })
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
