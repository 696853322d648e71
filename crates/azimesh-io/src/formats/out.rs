//! Where a file is written front to back; some of its bytes may be written by other ranks.

use super::save::Pieces;
use crate::mesh::NumbersApart;
use azimesh_core::error::{Error, Result};
use azimesh_core::ranks::hash::HashedBytes;
use std::io::{self, BufWriter, Write};

/// What takes the bytes of a file.
pub trait Out: Write {
    /// Has other ranks write the next bytes. Gives what they tell of them, hashed from byte `hash_from` on.
    ///
    /// # Errors
    /// Where this is no file, which alone all ranks can open.
    fn apart(&mut self, _numbers: &NumbersApart, _hash_from: u64) -> Result<Vec<HashedBytes>> {
        Err(Error::system(
            "what other ranks have is written to files only",
        ))
    }
}

impl Out for Vec<u8> {}

/// What is written nowhere is written by no rank.
impl Out for io::Sink {
    fn apart(&mut self, _: &NumbersApart, _: u64) -> Result<Vec<HashedBytes>> {
        Ok(Vec::new())
    }
}

impl Out for BufWriter<Pieces<Box<dyn Write>>> {}

impl Out for BufWriter<&mut dyn Out> {
    fn apart(&mut self, numbers: &NumbersApart, hash_from: u64) -> Result<Vec<HashedBytes>> {
        self.flush()
            .map_err(|error| Error::system(error.to_string()))?;
        self.get_mut().apart(numbers, hash_from)
    }
}
