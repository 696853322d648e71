//! Types of values, as HDF5 describes them.

use crate::formats::vtk::number::Element as VtkElement;

/// A number that has its own type in HDF5.
pub(in crate::formats) trait Number: bytemuck::NoUninit {
    /// That type.
    const ELEMENT: Element;
}

macro_rules! number {
    ($($T:ident $name:ident),*) => { $(impl Number for $T {
        const ELEMENT: Element = Element::$name;
    })* };
}
number!(i8 I8, u8 U8, i16 I16, u16 U16, i32 I32, u32 U32, i64 I64, u64 U64, f32 F32, f64 F64);

/// Type of the values of a dataset or an attribute. Numbers have the byte order of this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) enum Element {
    /// An integer of 1, 2, 4 or 8 bytes.
    Integer {
        /// Size in bytes.
        bytes: u8,
        /// Whether it can be below zero.
        signed: bool,
    },
    /// A floating-point number of 4 or 8 bytes.
    Float {
        /// Size in bytes.
        bytes: u8,
    },
    /// ASCII text of so many bytes, ended by a zero or filled up with them.
    Text {
        /// Size in bytes, at least 1.
        bytes: u32,
        /// Whether a zero must follow the text (C's strings), or only fills up what is left.
        terminated: bool,
    },
    /// Text of any length: a reference into a heap.
    String,
}

impl Element {
    pub const I8: Self = Self::integer(1, true);
    pub const U8: Self = Self::integer(1, false);
    pub const I16: Self = Self::integer(2, true);
    pub const U16: Self = Self::integer(2, false);
    pub const I32: Self = Self::integer(4, true);
    pub const U32: Self = Self::integer(4, false);
    pub const I64: Self = Self::integer(8, true);
    pub const U64: Self = Self::integer(8, false);
    pub const F32: Self = Element::Float { bytes: 4 };
    pub const F64: Self = Element::Float { bytes: 8 };

    const fn integer(bytes: u8, signed: bool) -> Self {
        Element::Integer { bytes, signed }
    }

    /// Bytes of one value in a dataset.
    pub fn size(self) -> u64 {
        match self {
            Element::Integer { bytes, .. } | Element::Float { bytes } => bytes.into(),
            Element::Text { bytes, .. } => bytes.into(),
            Element::String => 16,
        }
    }

    /// The datatype message.
    pub(super) fn encode(self) -> Vec<u8> {
        let order = u8::from(cfg!(target_endian = "big"));
        let mut message = Vec::with_capacity(20);
        match self {
            Element::Integer { bytes, signed } => {
                message.extend([0x10, order | u8::from(signed) << 3, 0, 0]);
                message.extend(u32::from(bytes).to_le_bytes());
                message.extend([0, 0]);
                message.extend((u16::from(bytes) * 8).to_le_bytes());
            }
            Element::Float { bytes } => {
                let (sign, exponent_at, exponent, bias) = match bytes {
                    4 => (31, 23, 8, 127_u32),
                    _ => (63, 52, 11, 1023),
                };
                message.extend([0x11, 0x20 | order, sign, 0]);
                message.extend(u32::from(bytes).to_le_bytes());
                message.extend([0, 0, bytes * 8, 0, exponent_at, exponent, 0, exponent_at]);
                message.extend(bias.to_le_bytes());
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

impl From<VtkElement> for Element {
    fn from(element: VtkElement) -> Self {
        match element {
            VtkElement::Int8 => Element::I8,
            VtkElement::UInt8 => Element::U8,
            VtkElement::Int16 => Element::I16,
            VtkElement::UInt16 => Element::U16,
            VtkElement::Int32 => Element::I32,
            VtkElement::UInt32 => Element::U32,
            VtkElement::Int64 => Element::I64,
            VtkElement::UInt64 => Element::U64,
            VtkElement::Float32 => Element::F32,
            VtkElement::Float64 => Element::F64,
            VtkElement::String => Element::String,
        }
    }
}
