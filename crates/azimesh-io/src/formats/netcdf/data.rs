//! Values of a variable.

use super::super::vtk::chunk::Chunk;
use super::super::vtk::number::Element;
use super::Values;
use std::borrow::Cow;

/// Values as they lie in the file, or as they were read of HDF5.
pub(in super::super) enum Data<'a> {
    /// Bytes, the most significant first.
    Bytes(Cow<'a, [u8]>, Element),
    /// Of HDF5.
    Values(Values),
}

impl Data<'_> {
    /// The numbers; `None` for text.
    pub fn chunk(&self) -> Option<Chunk<'_>> {
        match self {
            Self::Bytes(_, Element::String) => None,
            Self::Bytes(bytes, element) => Some(Chunk {
                bytes,
                element: *element,
                swap: cfg!(target_endian = "little"),
            }),
            Self::Values(values) => Chunk::of(values),
        }
    }

    /// The numbers in their own type; `None` for text.
    pub fn into_values(self) -> Option<Values> {
        let chunk = match self {
            Self::Values(Values::Text(_)) => return None,
            Self::Values(values) => return Some(values),
            Self::Bytes(..) => self.chunk()?,
        };
        macro_rules! copied {
            ($($element:ident $variant:ident),*) => {
                match chunk.element {
                    $(Element::$element => {
                        let mut values = vec![Default::default(); chunk.n_values()];
                        chunk.copy_to(&mut values);
                        Values::$variant(values)
                    })*
                    Element::String => return None,
                }
            };
        }
        Some(copied!(
            Int8 I8, UInt8 U8, Int16 I16, UInt16 U16, Int32 I32, UInt32 U32, Int64 I64, UInt64 U64, Float32 F32,
            Float64 F64
        ))
    }
}
