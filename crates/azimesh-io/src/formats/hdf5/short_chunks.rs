//! Chunks that hold only the rows that a dataset has: Fluent writes the last chunk of a dataset so, which the library of HDF5
//! reads.

use hdf5_reader::Dataset;
use hdf5_reader::filters::deflate::decompress_with_limit;
use hdf5_reader::filters::{FILTER_DEFLATE, FilterRegistry};
use hdf5_reader::messages::filter_pipeline::FilterDescription;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes of the whole chunks of the dataset that is read, and of a last one that is cut short; 0 where none is.
#[derive(Clone, Default)]
pub(super) struct ShortChunks(Arc<[AtomicUsize; 2]>);

impl ShortChunks {
    /// Filters that lengthen a last chunk to that of the others.
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
