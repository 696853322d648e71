//! Types of values, as HDF5 describes them.

use crate::formats::vtk::number::Element as VtkElement;

/// A number that has its own type in HDF5.
pub(in crate::formats) trait Number: bytemuck::NoUninit {
    /// That type.
    const ELEMENT: Element;
}

/// Type of the values of a dataset or an attribute. Numbers have the byte order of this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) enum Element {
    /// A number.
    Number(VtkElement),
    /// ASCII text of so many bytes, ended by a zero or filled up with zeros.
    Text {
        /// Size in bytes, at least 1.
        bytes: u32,
        /// True if a zero must follow the text (C's strings); otherwise zeros only fill up what is left.
        terminated: bool,
    },
    /// Text of any length: a reference into a heap.
    String,
}

macro_rules! numbers {
    ($($T:ident $name:ident $element:ident),*) => {
        impl Element {
            $(pub const $name: Self = Element::Number(VtkElement::$element);)*
        }
        $(impl Number for $T {
            const ELEMENT: Element = Element::$name;
        })*
    };
}
numbers!(
    i8 I8 Int8, u8 U8 UInt8, i16 I16 Int16, u16 U16 UInt16, i32 I32 Int32, u32 U32 UInt32,
    i64 I64 Int64, u64 U64 UInt64, f32 F32 Float32, f64 F64 Float64
);

impl From<VtkElement> for Element {
    fn from(element: VtkElement) -> Self {
        match element {
            VtkElement::String => Element::String,
            number => Element::Number(number),
        }
    }
}

impl Element {
    /// Bytes of one value in a dataset.
    pub fn size(self) -> u64 {
        match self {
            Element::Number(number) => number.size() as u64,
            Element::Text { bytes, .. } => bytes.into(),
            Element::String => 16,
        }
    }

    /// The datatype message.
    pub(super) fn encode(self) -> Vec<u8> {
        let order = u8::from(cfg!(target_endian = "big"));
        let mut message = Vec::with_capacity(20);
        match self {
            Element::Number(number @ (VtkElement::Float32 | VtkElement::Float64)) => {
                let (sign, exponent_at, exponent, bias) = match number {
                    VtkElement::Float32 => (31, 23, 8, 127_u32),
                    _ => (63, 52, 11, 1023),
                };
                let bits = sign + 1;
                message.extend([0x11, 0x20 | order, sign, 0]);
                message.extend((number.size() as u32).to_le_bytes());
                message.extend([0, 0, bits, 0, exponent_at, exponent, 0, exponent_at]);
                message.extend(bias.to_le_bytes());
            }
            Element::Number(number) => {
                use VtkElement::{Int8, Int16, Int32, Int64};
                let is_signed = matches!(number, Int8 | Int16 | Int32 | Int64);
                message.extend([0x10, order | u8::from(is_signed) << 3, 0, 0]);
                message.extend((number.size() as u32).to_le_bytes());
                message.extend([0, 0]);
                message.extend((number.size() as u16 * 8).to_le_bytes());
            }
            Element::Text { bytes, terminated } => {
                message.extend([0x13, u8::from(!terminated), 0, 0]);
                message.extend(bytes.to_le_bytes());
            }
            Element::String => {
                // Called ASCII, as VTK wants it, whatever the bytes.
                message.extend([0x19, 1, 0, 0]);
                message.extend(16_u32.to_le_bytes());
                message.extend(Element::U8.encode());
            }
        }
        message
    }
}
