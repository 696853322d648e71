//! Decompresses blocks in parallel.

use super::super::Compression;
use super::super::decompress::reason;
use super::aligner::{Aligner, CHUNK};
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::map_items;
use std::borrow::Cow;
use std::io::Read;

/// Blocks of one array, their sizes checked.
pub(super) struct Blocks<'a> {
    pub compression: Compression,
    pub data: Cow<'a, [u8]>,
    /// Compressed size of each block.
    pub sizes: Vec<usize>,
    /// Decompressed size of each block but the last.
    pub block_size: usize,
    pub n_bytes: usize,
}

/// Refuses decompressed sizes that the compressed data cannot have.
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
            "{n_compressed} compressed bytes cannot hold {n_bytes} bytes in blocks of {block_size}"
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
            let mut compressed = Vec::with_capacity(sizes.len());
            for size in sizes {
                let (block, rest) = data.split_at(*size);
                compressed.push(block);
                data = rest;
            }
            let n_bytes = left.min(sizes.len() * self.block_size);
            left -= n_bytes;
            let damaged = |block: usize, what: String| {
                let block = chunk * per_chunk + block;
                Error::input(format!("compressed block {block} is damaged: {what}"))
            };
            aligner.push(|bytes| {
                if n_bytes > CHUNK && compressed.len() == 1 {
                    return decompress_large(self.compression, compressed[0], n_bytes, bytes)
                        .map_err(|what| damaged(0, what));
                }
                let start = bytes.len();
                bytes.resize(start + n_bytes, 0);
                let blocks = bytes[start..].chunks_mut(self.block_size);
                let results = map_items(blocks.zip(compressed), &|i, (out, compressed)| {
                    decompress(self.compression, compressed, out).map_err(|what| damaged(i, what))
                });
                results.into_iter().collect()
            })?;
        }
        Ok(())
    }
}

/// Decompresses one block, which must fill `out` exactly.
fn decompress(
    compression: Compression,
    compressed: &[u8],
    out: &mut [u8],
) -> std::result::Result<(), String> {
    let expected = out.len();
    let wrong = |n| format!("it decompresses to {n} bytes instead of {expected}");
    match compression {
        Compression::Lz4 => match lz4_flex::block::decompress_into(compressed, out) {
            Ok(n) if n == expected => Ok(()),
            Ok(n) => Err(wrong(n)),
            Err(error) => Err(error.to_string()),
        },
        Compression::Zlib => {
            let mut reader = zlib(compressed);
            fill(&mut reader, out)?;
            finish(&mut reader, expected)
        }
        Compression::Lzma => {
            let mut reader = lzma(compressed);
            fill(&mut reader, out)?;
            finish(&mut reader, expected)
        }
        Compression::None => Err(wrong(compressed.len())),
    }
}

/// Appends a block that is declared to have `n_bytes`; memory is allocated as the bytes arrive.
fn decompress_large(
    compression: Compression,
    compressed: &[u8],
    n_bytes: usize,
    out: &mut Vec<u8>,
) -> std::result::Result<(), String> {
    let mut reader: Box<dyn Read + '_> = match compression {
        Compression::Zlib => Box::new(zlib(compressed)),
        Compression::Lzma => Box::new(lzma(compressed)),
        Compression::Lz4 | Compression::None => {
            let start = out.len();
            out.resize(start + n_bytes, 0);
            return decompress(compression, compressed, &mut out[start..]);
        }
    };
    let end = out.len() + n_bytes;
    while out.len() < end {
        let start = out.len();
        out.resize(end.min(start + CHUNK), 0);
        fill(&mut reader, &mut out[start..])?;
    }
    finish(&mut reader, n_bytes)
}

fn zlib(compressed: &[u8]) -> flate2::read::ZlibDecoder<&[u8]> {
    flate2::read::ZlibDecoder::new(compressed)
}

fn lzma(compressed: &[u8]) -> lzma_rust2::XzReader<&[u8]> {
    // A dictionary larger than this is never of use for a block of an array.
    const MEMORY_KIB: u32 = 128 << 10;
    lzma_rust2::XzReader::new_mem_limit(compressed, false, MEMORY_KIB)
}

fn fill(reader: &mut impl Read, out: &mut [u8]) -> std::result::Result<(), String> {
    reader.read_exact(out).map_err(|error| reason(&error))
}

/// Reading on makes the decoder compare its checksum.
fn finish(reader: &mut impl Read, n_bytes: usize) -> std::result::Result<(), String> {
    match reader.read(&mut [0]) {
        Ok(0) => Ok(()),
        Ok(_) => Err(format!("it decompresses to more than {n_bytes} bytes")),
        Err(error) => Err(reason(&error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_that_claims_more_than_it_has_takes_no_memory_for_it() {
        let mut writer = lzma_rust2::XzWriter::new(Vec::new(), lzma_rust2::XzOptions::default())
            .expect("good options");
        std::io::Write::write_all(&mut writer, &[7; 100]).expect("it is compressed");
        let compressed = writer.finish().expect("it is compressed");
        let mut out = Vec::new();
        let claimed = 1 << 40;
        let error = decompress_large(Compression::Lzma, &compressed, claimed, &mut out);
        assert!(error.is_err());
        assert!(out.capacity() <= CHUNK);
        out.clear();
        decompress_large(Compression::Lzma, &compressed, 100, &mut out).expect("it has them");
        assert_eq!(out, [7; 100]);
        let short = decompress_large(Compression::Lzma, &compressed, 99, &mut out);
        assert!(short.is_err());
    }
}
