//! Numbers read by their size alone. Signed, unsigned and floating-point numbers of one size have the same bytes: so the
//! library that reads HDF5 is compiled for four types instead of ten.

use hdf5_reader::error::{Error, Result};
use hdf5_reader::{ByteOrder, Datatype, H5Type};

/// A number of the size of `T`, in the byte order of this machine.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct Bits<T>(T);

const NATIVE: ByteOrder = match cfg!(target_endian = "little") {
    true => ByteOrder::LittleEndian,
    false => ByteOrder::BigEndian,
};

impl<T: bytemuck::Pod + Send> Bits<T> {
    /// From as many bytes as it has.
    fn read(bytes: &[u8]) -> Self {
        Self(bytemuck::pod_read_unaligned(bytes))
    }

    fn reversed(mut self) -> Self {
        bytemuck::bytes_of_mut(&mut self.0).reverse();
        self
    }
}

impl<T: bytemuck::Pod + Send> H5Type for Bits<T> {
    fn hdf5_type() -> Datatype {
        Datatype::FixedPoint {
            size: size_of::<T>() as u8,
            signed: false,
            byte_order: NATIVE,
        }
    }

    fn from_bytes(bytes: &[u8], datatype: &Datatype) -> Result<Self> {
        let bytes = bytes.get(..size_of::<T>()).map(Self::read);
        let bits = bytes.ok_or_else(|| Error::InvalidData("a number is cut off".to_owned()))?;
        match is_native(datatype) {
            true => Ok(bits),
            false => Ok(bits.reversed()),
        }
    }

    fn element_size(_: &Datatype) -> usize {
        size_of::<T>()
    }

    fn decode_vec(bytes: &[u8], datatype: &Datatype, n: usize) -> Option<Result<Vec<Self>>> {
        let bytes = bytes.get(..n.checked_mul(size_of::<T>())?)?;
        let values = bytes.chunks_exact(size_of::<T>()).map(Self::read);
        Some(Ok(match is_native(datatype) {
            true => values.collect(),
            false => values.map(Self::reversed).collect(),
        }))
    }

    fn native_copy_compatible(datatype: &Datatype) -> bool {
        is_native(datatype)
    }
}

fn is_native(datatype: &Datatype) -> bool {
    match datatype {
        Datatype::FixedPoint { byte_order, .. } | Datatype::FloatingPoint { byte_order, .. } => {
            *byte_order == NATIVE
        }
        _ => false,
    }
}
