//! Addresses of what is stored in a file, and how the values of a dataset are stored.

/// The undefined address.
pub(super) const NOWHERE: u64 = u64::MAX;

/// Values or an object in a growing file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) struct Stored {
    pub(super) address: u64,
}

impl Stored {
    /// The values past so many bytes.
    pub fn past(self, n_bytes: u64) -> Self {
        Self {
            address: self.address + n_bytes,
        }
    }
}

/// Where the values of a dataset lie.
#[derive(Debug, Clone)]
pub(super) enum Storage {
    /// In one piece.
    Contiguous(u64),
    /// In chunks of so many rows, by way of the index at this address.
    Chunked { rows: u64, index: Stored },
}
