//! Compressed blocks, unpacked in parallel.

use super::super::Compression;
use super::stored::{Aligner, CHUNK};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Read;

/// Blocks of one array, their sizes checked.
pub(super) struct Blocks<'a> {
    pub compression: Compression,
    pub data: Cow<'a, [u8]>,
    /// Compressed size of each block.
    pub sizes: Vec<usize>,
    /// Size of each block but the last when unpacked.
    pub block_size: usize,
    pub n_bytes: usize,
}

/// Refuses sizes that no compressed data could unpack to.
pub(super) fn check_ratio(
    compression: Compression,
    n_bytes: usize,
    n_compressed: usize,
    block_size: usize,
    last: usize,
) -> Result<()> {
    let ratio = match compression {
        Compression::None => 1,
        Compression::Zlib => 1100,
        Compression::Lz4 => 256,
        Compression::Lzma => 10_000,
    };
    if block_size == 0 || last > block_size || n_bytes / ratio > n_compressed {
        return Err(Error::input(format!(
            "blocks of {block_size} bytes, {n_bytes} in all, cannot come from {n_compressed} \
             compressed bytes"
        )));
    }
    Ok(())
}

impl Blocks<'_> {
    pub fn chunks(&self, aligner: &mut Aligner) -> Result<()> {
        let per_chunk = (CHUNK / self.block_size).max(1);
        let mut data = &self.data[..];
        let mut left = self.n_bytes;
        for (chunk, sizes) in self.sizes.chunks(per_chunk).enumerate() {
            let mut packed = Vec::with_capacity(sizes.len());
            for size in sizes {
                let (block, rest) = data.split_at(*size);
                packed.push(block);
                data = rest;
            }
            let n_bytes = left.min(sizes.len() * self.block_size);
            left -= n_bytes;
            aligner.push(|bytes| {
                let start = bytes.len();
                bytes.resize(start + n_bytes, 0);
                bytes[start..]
                    .par_chunks_mut(self.block_size)
                    .zip(packed)
                    .enumerate()
                    .try_for_each(|(block, (out, packed))| {
                        unpack(self.compression, packed, out).map_err(|what| {
                            let block = chunk * per_chunk + block;
                            Error::input(format!("compressed block {block} is damaged: {what}"))
                        })
                    })
            })?;
        }
        Ok(())
    }
}

/// Unpacks one block, which must fill `out` exactly.
fn unpack(
    compression: Compression,
    packed: &[u8],
    out: &mut [u8],
) -> std::result::Result<(), String> {
    // A dictionary larger than this is never of use for a block of an array.
    const LZMA_MEMORY_KIB: u32 = 128 << 10;
    let expected = out.len();
    let wrong = |n| format!("it unpacks to {n} bytes, not {expected}");
    match compression {
        Compression::Lz4 => match lz4_flex::block::decompress_into(packed, out) {
            Ok(n) if n == expected => Ok(()),
            Ok(n) => Err(wrong(n)),
            Err(error) => Err(error.to_string()),
        },
        Compression::Zlib => fill(flate2::read::ZlibDecoder::new(packed), out),
        Compression::Lzma => fill(
            lzma_rust2::XzReader::new_mem_limit(packed, false, LZMA_MEMORY_KIB),
            out,
        ),
        Compression::None => Err(wrong(packed.len())),
    }
}

fn fill(mut reader: impl Read, out: &mut [u8]) -> std::result::Result<(), String> {
    reader.read_exact(out).map_err(|error| error.to_string())?;
    // Reading on makes the decoder compare its checksum.
    match reader.read(&mut [0]) {
        Ok(0) => Ok(()),
        Ok(_) => Err(format!("it unpacks to more than {} bytes", out.len())),
        Err(error) => Err(error.to_string()),
    }
}
