//! The stored values of one array, turned into chunks of bytes: text, base64, raw, compressed blocks.
//!
//! Sizes given by a file are checked against the bytes it has before any memory is allocated,
//! and values pass through in chunks, so that decompression needs little more than its result.

use super::super::Compression;
use super::super::decompress::reason;
use super::super::number::{Chunk, DType};
use super::super::tokens::n_words;
use super::super::vtk::number::{cuts, parse_words, word_end};
use super::xml::{Array, DataEncoding, Layout};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::numbers::with_verb;
use azimesh_core::parallel::{map, map_items};
use std::borrow::Cow;
use std::io::Read;

/// Bytes decoded before they are passed on.
const CHUNK: usize = 8 << 20;

/// The stored values of one array, their sizes checked.
pub(super) struct Stored<'d, 'a> {
    array: &'d Array<'a>,
    data: Data<'a>,
}

enum Data<'a> {
    Text,
    Plain(&'a [u8]),
    /// Base64 of `skip` bytes and then the values.
    Base64 {
        text: Cow<'a, [u8]>,
        skip: usize,
        n_bytes: usize,
    },
    Blocks(Blocks<'a>),
}

struct Blocks<'a> {
    compression: Compression,
    data: Cow<'a, [u8]>,
    /// Compressed size of each block.
    sizes: Vec<usize>,
    /// Decompressed size of each block but the last.
    block_size: usize,
    n_bytes: usize,
}

impl<'d, 'a> Stored<'d, 'a> {
    /// Finds the values of an array and checks their declared size.
    pub fn open(array: &'d Array<'a>) -> Result<Self> {
        let (encoding, layout) = (array.encoding, &array.layout);
        let stored = match encoding {
            DataEncoding::Base64 => array.stored.trim_ascii_start(),
            _ => array.stored,
        };
        let data = match (encoding, layout.compression) {
            (DataEncoding::Ascii, _) => Ok(Data::Text),
            (DataEncoding::Base64, _) if stored.is_empty() => Ok(Data::Plain(&[])),
            (_, Compression::None) => plain(encoding, stored, layout),
            _ => blocks(encoding, stored, layout),
        };
        let data = data.map_err(|error| error.dataset(&array.name))?;
        Ok(Self { array, data })
    }

    /// The values where the file has them as they are.
    pub fn plain(&self) -> Option<Chunk<'a>> {
        match self.data {
            Data::Plain(bytes) => Some(self.chunk(bytes)),
            _ => None,
        }
    }

    fn chunk<'b>(&self, bytes: &'b [u8]) -> Chunk<'b> {
        // Text is parsed to the order of this machine.
        let is_big_endian = match self.data {
            Data::Text => cfg!(target_endian = "big"),
            _ => self.array.layout.big_endian,
        };
        DType::new(self.array.element, is_big_endian).of(bytes)
    }

    /// Number of bytes of all values; unknown for text.
    pub fn n_bytes(&self) -> Option<usize> {
        match &self.data {
            Data::Text => None,
            Data::Plain(bytes) => Some(bytes.len()),
            Data::Base64 { n_bytes, .. } => Some(*n_bytes),
            Data::Blocks(blocks) => Some(blocks.n_bytes),
        }
    }

    /// Number of values; the words of text are counted.
    pub fn n_values(&self) -> usize {
        match self.n_bytes() {
            Some(n_bytes) => n_bytes / self.array.element.size(),
            None => n_words(self.array.stored),
        }
    }

    /// Passes the values to `sink` in chunks of a whole number of tuples of `tuple` bytes.
    pub fn for_each(&self, tuple: usize, sink: &mut dyn FnMut(Chunk) -> Result<()>) -> Result<()> {
        let mut pending = Vec::new();
        let mut push = |fill: &mut dyn FnMut(&mut Vec<u8>) -> Result<()>| {
            fill(&mut pending)?;
            let whole = pending.len() / tuple * tuple;
            if whole > 0 {
                sink(self.chunk(&pending[..whole]))?;
                pending.drain(..whole);
            }
            Ok(())
        };
        match &self.data {
            Data::Plain(bytes) if bytes.len() >= tuple => return sink(self.chunk(bytes)),
            Data::Plain(_) => {}
            Data::Text => text_chunks(self.array, &mut push)?,
            Data::Base64 { text, skip, .. } => base64_chunks(text, *skip, &mut push)?,
            Data::Blocks(blocks) => blocks.chunks(&mut push)?,
        }
        if pending.is_empty() {
            return Ok(());
        }
        Err(Error::input(format!(
            "it has {}, which is not a whole number of tuples of {}",
            counted(self.n_values(), "value"),
            tuple / self.array.element.size()
        )))
    }
}

/// Passes on the bytes that a function appends, except for an incomplete tuple at the end.
type Push<'p> = &'p mut dyn FnMut(&mut dyn FnMut(&mut Vec<u8>) -> Result<()>) -> Result<()>;

fn text_chunks(array: &Array, push: Push) -> Result<()> {
    let text = array.stored;
    let mut start = 0;
    while start < text.len() {
        let end = word_end(text, start.saturating_add(CHUNK));
        let cuts = cuts(text, start, end, CHUNK / 32);
        let parts = map(cuts.len() - 1, &|i| {
            parse_words(&text[cuts[i]..cuts[i + 1]], array.element)
        });
        for (first, part) in cuts.into_iter().zip(parts) {
            let numbers =
                part.map_err(|(at, message)| Error::input(message).line(array.line(first + at)))?;
            push(&mut |bytes| {
                bytes.extend_from_slice(&numbers);
                Ok(())
            })?;
        }
        start = end;
    }
    Ok(())
}

fn base64_chunks(text: &[u8], mut skip: usize, push: Push) -> Result<()> {
    for part in text.chunks(CHUNK) {
        push(&mut |bytes| {
            let start = bytes.len();
            let decoded = base64_simd::STANDARD.decode_append(part, bytes);
            decoded.map_err(|_| Error::input("the base64 text is damaged"))?;
            bytes.drain(start..start + skip.min(bytes.len() - start));
            Ok(())
        })?;
        skip = 0;
    }
    Ok(())
}

/// The first `n_bytes` bytes of base64 as characters without white space, and the text after them.
fn base64_run(text: &[u8], n_bytes: usize) -> Result<(Cow<'_, [u8]>, &[u8])> {
    let text = text.trim_ascii_start();
    let short = || {
        let found = text.len();
        Error::input(format!(
            "{} in base64 are needed, but only {} left",
            counted(n_bytes, "byte"),
            with_verb(found, "character", "is")
        ))
    };
    let n = n_bytes.div_ceil(3).checked_mul(4);
    let n = n.filter(|n| *n <= text.len()).ok_or_else(short)?;
    if !text[..n].iter().any(u8::is_ascii_whitespace) {
        return Ok((Cow::Borrowed(&text[..n]), &text[n..]));
    }
    let mut run = Vec::with_capacity(n);
    for (at, byte) in text.iter().enumerate() {
        if !byte.is_ascii_whitespace() {
            run.push(*byte);
            if run.len() == n {
                return Ok((Cow::Owned(run), &text[at + 1..]));
            }
        }
    }
    Err(short())
}

/// The first `n_bytes` bytes of stored values, and the text or the bytes after them.
fn take(encoding: DataEncoding, stored: &[u8], n_bytes: usize) -> Result<(Cow<'_, [u8]>, &[u8])> {
    if encoding == DataEncoding::Raw {
        let (bytes, rest) = stored.split_at_checked(n_bytes).ok_or_else(|| {
            let left = stored.len();
            Error::input(format!(
                "its header is missing: {left} bytes are left in the file"
            ))
        })?;
        return Ok((Cow::Borrowed(bytes), rest));
    }
    let (run, rest) = base64_run(stored, n_bytes)?;
    // Padding may cut it short.
    let decoded = base64_simd::STANDARD.decode_to_vec(run).ok();
    let damaged = || Error::input("the base64 text is damaged");
    let whole = decoded.filter(|bytes| bytes.len() >= n_bytes);
    let mut bytes = whole.ok_or_else(damaged)?;
    bytes.truncate(n_bytes);
    Ok((Cow::Owned(bytes), rest))
}

/// Uncompressed values: their number of bytes, then they.
fn plain<'a>(encoding: DataEncoding, stored: &'a [u8], layout: &Layout) -> Result<Data<'a>> {
    let width = layout.header_bytes;
    let (header, rest) = take(encoding, stored, width)?;
    let n_bytes = header_number(&header, layout)?;
    if encoding == DataEncoding::Raw {
        let bytes = rest.get(..n_bytes).ok_or_else(|| {
            let left = rest.len();
            Error::input(format!(
                "its size is {n_bytes} bytes, but only {left} are left in the file"
            ))
        })?;
        return Ok(Data::Plain(bytes));
    }
    // The padding of a header alone means that the values are a separate base64 text. Else the header's last characters
    // belong to the values too, which may end there: with other padding.
    let padding = if width == 4 { "==" } else { "=" };
    let is_separate = stored[..stored.len() - rest.len()].ends_with(padding.as_bytes());
    let (text, skip) = if is_separate {
        (rest, 0)
    } else {
        (stored, width)
    };
    let total = n_bytes.checked_add(skip);
    let total = total.ok_or_else(|| Error::input("its size is out of range"))?;
    let text = base64_run(text, total)?.0;
    Ok(Data::Base64 {
        text,
        skip,
        n_bytes,
    })
}

/// Compressed values: the number of blocks, their decompressed size, the size of the last if it is smaller (else zero),
/// the compressed size of each, then the blocks.
fn blocks<'a>(encoding: DataEncoding, stored: &'a [u8], layout: &Layout) -> Result<Data<'a>> {
    let (width, compression) = (layout.header_bytes, layout.compression);
    let n_blocks = header_number(&take(encoding, stored, width)?.0, layout)?;
    if n_blocks == 0 {
        return Ok(Data::Plain(&[]));
    }
    let n_header = n_blocks.checked_add(3).and_then(|n| n.checked_mul(width));
    let n_header = n_header.filter(|n| *n <= stored.len()).ok_or_else(|| {
        Error::input(format!(
            "its header says {n_blocks} compressed blocks, more than the file can hold"
        ))
    })?;
    let (header, rest) = take(encoding, stored, n_header)?;
    let numbers = header.chunks_exact(width);
    let numbers = numbers.map(|number| header_number(number, layout));
    let mut sizes = numbers.collect::<Result<Vec<_>>>()?;
    let (block_size, last) = (sizes[1], sizes[2]);
    sizes.drain(..3);
    let last = if last == 0 { block_size } else { last };
    let n_bytes = (sizes.len() - 1).checked_mul(block_size);
    let n_bytes = n_bytes.and_then(|n| n.checked_add(last));
    let n_bytes = n_bytes.ok_or_else(|| Error::input("the size of its blocks is out of range"))?;
    let mut each = sizes.iter();
    let n_compressed = each.try_fold(0usize, |sum, size| sum.checked_add(*size));
    let n_compressed = n_compressed.filter(|n| *n <= rest.len()).ok_or_else(|| {
        let left = rest.len();
        Error::input(format!(
            "the compressed blocks are longer than the {left} bytes that are left"
        ))
    })?;
    let highest_ratio = match compression {
        Compression::None => 1,
        Compression::Zlib => 1100,
        Compression::Lz4 => 256,
        Compression::Lzma => 10_000,
    };
    if block_size == 0 || last > block_size || n_bytes / highest_ratio > n_compressed {
        return Err(Error::input(format!(
            "{n_compressed} compressed bytes cannot hold {n_bytes} bytes in blocks of {block_size}"
        )));
    }
    Ok(Data::Blocks(Blocks {
        compression,
        data: take(encoding, rest, n_compressed)?.0,
        sizes,
        block_size,
        n_bytes,
    }))
}

fn header_number(bytes: &[u8], layout: &Layout) -> Result<usize> {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    if layout.big_endian {
        wide[..bytes.len()].reverse();
    }
    let number = u64::from_le_bytes(wide);
    usize::try_from(number).map_err(|_| Error::input(format!("size {number} is too large")))
}

impl Blocks<'_> {
    fn chunks(&self, push: Push) -> Result<()> {
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
            push(&mut |bytes| {
                if n_bytes > CHUNK && compressed.len() == 1 {
                    return decompress_large(self.compression, compressed[0], n_bytes, bytes)
                        .map_err(|what| damaged(0, what));
                }
                let start = bytes.len();
                bytes.resize(start + n_bytes, 0);
                let blocks = bytes[start..].chunks_mut(self.block_size);
                let results = map_items(blocks.zip(&compressed), &|i, (out, compressed)| {
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
    if let Some(mut reader) = reader(compression, compressed) {
        reader.read_exact(out).map_err(|error| reason(&error))?;
        return finish(&mut reader, expected);
    }
    match lz4_flex::block::decompress_into(compressed, out) {
        Ok(n) if n == expected => Ok(()),
        Ok(n) => Err(format!(
            "it decompresses to {n} bytes instead of {expected}"
        )),
        Err(error) => Err(error.to_string()),
    }
}

/// Appends a block that is declared to have `n_bytes`; memory is allocated as the bytes arrive.
fn decompress_large(
    compression: Compression,
    compressed: &[u8],
    n_bytes: usize,
    out: &mut Vec<u8>,
) -> std::result::Result<(), String> {
    let end = out.len() + n_bytes;
    let Some(mut reader) = reader(compression, compressed) else {
        let start = out.len();
        out.resize(end, 0);
        return decompress(compression, compressed, &mut out[start..]);
    };
    while out.len() < end {
        let start = out.len();
        out.resize(end.min(start + CHUNK), 0);
        let read = reader.read_exact(&mut out[start..]);
        read.map_err(|error| reason(&error))?;
    }
    finish(&mut reader, n_bytes)
}

/// A decoder of zlib or xz; none of LZ4.
fn reader(compression: Compression, compressed: &[u8]) -> Option<Box<dyn Read + '_>> {
    // A block of an array never needs a larger dictionary.
    const MEMORY_KIB: u32 = 128 << 10;
    let lzma = lzma_rust2::XzReader::new_mem_limit;
    match compression {
        Compression::Zlib => Some(Box::new(flate2::read::ZlibDecoder::new(compressed))),
        Compression::Lzma => Some(Box::new(lzma(compressed, false, MEMORY_KIB))),
        Compression::Lz4 | Compression::None => None,
    }
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
