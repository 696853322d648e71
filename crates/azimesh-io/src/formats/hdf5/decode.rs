//! Additions to the crate that reads HDF5: numbers by their size alone, and chunks that are cut short.

use crate::formats::vtk::number::Number;
use bytemuck::allocation::pod_collect_to_vec;
use hdf5_reader::error::{Error, Result};
use hdf5_reader::filters::deflate::decompress_with_limit;
use hdf5_reader::filters::{FILTER_DEFLATE, FilterRegistry};
use hdf5_reader::messages::filter_pipeline::FilterDescription;
use hdf5_reader::{ByteOrder, Dataset, Datatype, H5Type};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A number of the size of `T`, in the byte order of this machine. Signed, unsigned and floating-point numbers of one size
/// have the same bytes: so the crate is compiled for four types instead of ten.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct Bits<T>(T);

const NATIVE: ByteOrder = if cfg!(target_endian = "little") {
    ByteOrder::LittleEndian
} else {
    ByteOrder::BigEndian
};

impl<T: Number> H5Type for Bits<T> {
    fn hdf5_type() -> Datatype {
        Datatype::FixedPoint {
            size: size_of::<T>() as u8,
            signed: false,
            byte_order: NATIVE,
        }
    }

    fn from_bytes(bytes: &[u8], datatype: &Datatype) -> Result<Self> {
        let bytes = bytes.get(..size_of::<T>());
        let bytes = bytes.ok_or_else(|| Error::InvalidData("a number is cut off".to_owned()))?;
        let bits = T::from_bytes(bytes);
        let is_native = is_native(datatype);
        Ok(Self(if is_native { bits } else { bits.swapped() }))
    }

    fn element_size(_: &Datatype) -> usize {
        size_of::<T>()
    }

    fn decode_vec(bytes: &[u8], datatype: &Datatype, n: usize) -> Option<Result<Vec<Self>>> {
        let bytes = bytes.get(..n.checked_mul(size_of::<T>())?)?;
        let mut values: Vec<Self> = pod_collect_to_vec(bytes);
        if !is_native(datatype) {
            let swap = |bits: &mut Self| bits.0 = bits.0.swapped();
            values.iter_mut().for_each(swap);
        }
        Some(Ok(values))
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

/// Bytes of the whole chunks of the dataset that is read, and of a last one that holds only the rows that there are, as Fluent
/// writes it; 0 where none is.
#[derive(Clone, Default)]
pub(super) struct ShortChunks(Arc<[AtomicUsize; 2]>);

impl ShortChunks {
    /// Filters that lengthen a last chunk to the length of the others.
    pub fn filters(&self) -> FilterRegistry {
        let sizes = Arc::clone(&self.0);
        let mut filters = FilterRegistry::new();
        let inflate = move |_: &FilterDescription, data: &[u8], _: usize| {
            let [whole, last] = [0, 1].map(|i| sizes[i].load(Ordering::Relaxed));
            let most = match whole {
                0 => hdf5_reader::HDF5_MAX_CHUNK_BYTES,
                whole => whole + 1,
            };
            let mut bytes = decompress_with_limit(data, most)?;
            if last > 0 && bytes.len() == last {
                bytes.resize(whole, 0);
            }
            Ok(bytes)
        };
        filters.register(FILTER_DEFLATE, Box::new(inflate));
        filters
    }

    /// Lets `read` read a dataset with a last chunk that is cut short.
    pub fn while_reading<T>(&self, dataset: &Dataset, read: impl FnOnce() -> T) -> T {
        self.set(sizes(dataset).unwrap_or_default());
        let result = read();
        self.set([0, 0]);
        result
    }

    fn set(&self, sizes: [usize; 2]) {
        for (own, size) in self.0.iter().zip(sizes) {
            own.store(size, Ordering::Relaxed);
        }
    }
}

/// Bytes of the chunks of a dataset, and of its last one if that holds only the rows that there are.
fn sizes(dataset: &Dataset) -> Option<[usize; 2]> {
    let chunk = dataset.chunks()?;
    let (&rows, row) = chunk.split_first()?;
    let (&n_rows, others) = dataset.shape().split_first()?;
    let is_by_rows = row.iter().map(|n| u64::from(*n)).eq(others.iter().copied());
    let value = dataset.raw_element_size().ok()?;
    let size = |size: usize, n: &u32| size.checked_mul(*n as usize);
    let row = row.iter().try_fold(value, size)?;
    let last = usize::try_from(n_rows.checked_rem(u64::from(rows))?).ok()?;
    let whole = row.checked_mul(rows as usize)?;
    let is_sound = is_by_rows && whole < hdf5_reader::HDF5_MAX_CHUNK_BYTES;
    is_sound.then_some([whole, last * row])
}
