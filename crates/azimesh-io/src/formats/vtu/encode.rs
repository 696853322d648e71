//! Bytes of one array as a file stores them: text, base64, raw, compressed blocks.

use super::super::Compression;
use super::super::column::Column;
pub(super) use super::super::vtk::text::{ascii, failed};
use crate::formats::Out;
use azimesh_core::error::Result;
use azimesh_core::parallel::{block, try_map};
use std::io::Write;

/// Bytes of a block that is compressed on its own.
const BLOCK: usize = 256 << 10;

/// Writes the values as they are, after their number of bytes.
pub(super) fn raw(array: &Column, out: &mut dyn Out) -> Result<()> {
    out.write_all(&size(array.n_bytes())).map_err(failed)?;
    if let Some(numbers) = array.remote() {
        return out.apart(numbers, 0).map(drop);
    }
    array.for_each(&mut |bytes| out.write_all(bytes).map_err(failed))
}

/// Writes the number of bytes and the values as one base64 text.
pub(super) fn base64(array: &Column, out: &mut dyn Write) -> Result<()> {
    let mut text = Base64 {
        pending: size(array.n_bytes()).to_vec(),
        out,
    };
    array.for_each(&mut |bytes| text.push(bytes))?;
    text.finish()
}

/// A number in a header.
fn size(n: usize) -> [u8; 8] {
    (n as u64).to_ne_bytes()
}

/// Encodes bytes as they come.
struct Base64<'o> {
    pending: Vec<u8>,
    out: &'o mut dyn Write,
}

impl Base64<'_> {
    /// Bytes encoded at a time, a multiple of 3.
    const STEP: usize = 3 << 18;

    fn push(&mut self, bytes: &[u8]) -> Result<()> {
        let mut bytes = bytes;
        // Fill the group of three that was begun.
        let missing = (3 - self.pending.len() % 3) % 3;
        let (head, rest) = bytes.split_at(missing.min(bytes.len()));
        self.pending.extend_from_slice(head);
        bytes = rest;
        if !self.pending.len().is_multiple_of(3) {
            return Ok(());
        }
        let pending = std::mem::take(&mut self.pending);
        self.write(&pending)?;
        let whole = bytes.len() / 3 * 3;
        for step in bytes[..whole].chunks(Self::STEP) {
            self.write(step)?;
        }
        self.pending.extend_from_slice(&bytes[whole..]);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let text = base64_simd::STANDARD.encode_to_string(bytes);
        self.out.write_all(text.as_bytes()).map_err(failed)
    }

    fn finish(mut self) -> Result<()> {
        let pending = std::mem::take(&mut self.pending);
        self.write(&pending)
    }
}

/// An array in compressed blocks.
pub(super) struct CompressedBlocks {
    /// Number of blocks, their size, the last one's if it is smaller, and the size of each.
    header: Vec<u8>,
    blocks: Vec<Vec<u8>>,
}

impl CompressedBlocks {
    /// Compresses an array.
    pub fn new(array: &Column, compression: Compression) -> Result<Self> {
        let mut blocks = Vec::new();
        let mut pending: Vec<u8> = Vec::new();
        array.for_each(&mut |bytes| {
            let missing = (BLOCK - pending.len()) % BLOCK;
            let (head, rest) = bytes.split_at(missing.min(bytes.len()));
            pending.extend_from_slice(head);
            if pending.len() == BLOCK {
                blocks.push(pack(compression, &pending)?);
                pending.clear();
            }
            let whole = rest.len() / BLOCK * BLOCK;
            blocks.extend(try_map(whole / BLOCK, &|i| {
                pack(compression, &rest[block(whole, BLOCK, i)])
            })?);
            pending.extend_from_slice(&rest[whole..]);
            Ok(())
        })?;
        let last = pending.len();
        if last > 0 {
            blocks.push(pack(compression, &pending)?);
        }
        let mut header = Vec::with_capacity(8 * (3 + blocks.len()));
        for n in [blocks.len(), BLOCK, last] {
            header.extend(size(n));
        }
        for block in &blocks {
            header.extend(size(block.len()));
        }
        Ok(Self { header, blocks })
    }

    /// Bytes that [`CompressedBlocks::write_raw`] writes.
    pub fn n_bytes(&self) -> usize {
        self.header.len() + self.blocks.iter().map(Vec::len).sum::<usize>()
    }

    /// Writes header and blocks as they are.
    pub fn write_raw(&self, out: &mut dyn Write) -> Result<()> {
        out.write_all(&self.header).map_err(failed)?;
        self.blocks
            .iter()
            .try_for_each(|block| out.write_all(block).map_err(failed))
    }

    /// Writes the header as one base64 text and the blocks as another.
    pub fn write_base64(&self, out: &mut dyn Write) -> Result<()> {
        let mut header = Base64 {
            pending: Vec::new(),
            out,
        };
        header.push(&self.header)?;
        header.finish()?;
        let mut blocks = Base64 {
            pending: Vec::new(),
            out,
        };
        self.blocks
            .iter()
            .try_for_each(|block| blocks.push(block))?;
        blocks.finish()
    }
}

fn pack(compression: Compression, block: &[u8]) -> Result<Vec<u8>> {
    // Between fast and small; topology shrinks well at any level.
    const ZLIB_LEVEL: u32 = 4;
    const LZMA_PRESET: u32 = 4;
    match compression {
        Compression::None => Ok(block.to_vec()),
        Compression::Lz4 => Ok(lz4_flex::block::compress(block)),
        Compression::Zlib => {
            let level = flate2::Compression::new(ZLIB_LEVEL);
            let mut writer = flate2::write::ZlibEncoder::new(Vec::new(), level);
            writer
                .write_all(block)
                .and_then(|()| writer.finish())
                .map_err(failed)
        }
        Compression::Lzma => {
            let mut options = lzma_rust2::XzOptions::with_preset(LZMA_PRESET);
            options.lzma_options.dict_size = BLOCK as u32;
            options.set_check_sum_type(lzma_rust2::CheckType::Crc32);
            let mut writer = lzma_rust2::XzWriter::new(Vec::new(), options).map_err(failed)?;
            writer
                .write_all(block)
                .and_then(|()| writer.finish())
                .map_err(failed)
        }
    }
}
