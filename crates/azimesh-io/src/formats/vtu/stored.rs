//! The stored values of one array, turned into chunks of bytes: text, base64, raw, blocks.
//!
//! Sizes given by a file are checked against the bytes it has before any memory is allocated,
//! and values pass through in chunks, so that decompression needs little more than its result.

use super::super::Compression;
use super::super::vtk::chunk::Chunk;
use super::super::vtk::number::{Element, parse_words};
use super::super::vtk::text::{cuts, word_end};
use super::aligner::{Aligner, CHUNK};
use super::blocks::{Blocks, check_ratio};
use super::xml::{Array, DataEncoding, Layout, line_after};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::parallel::map;
use std::borrow::Cow;

/// The stored values of one array, their sizes checked.
pub(super) struct Stored<'a> {
    element: Element,
    swap: bool,
    data: Data<'a>,
}

enum Data<'a> {
    /// Numbers as text, and the file before it.
    Text(&'a [u8], &'a [u8]),
    /// The values as they are.
    Plain(&'a [u8]),
    /// Base64 of `skip` bytes and then the values.
    Base64 {
        text: Cow<'a, [u8]>,
        skip: usize,
        n_bytes: usize,
    },
    Blocks(Blocks<'a>),
}

impl<'a> Stored<'a> {
    /// Finds the values of an array and checks their declared size.
    pub fn open(array: &Array<'a>, layout: &Layout) -> Result<Self> {
        let data = match (array.encoding, layout.compression) {
            (DataEncoding::Ascii, _) => Ok(Data::Text(array.stored, array.before)),
            (encoding, Compression::None) => plain(encoding, array.stored, layout),
            (encoding, compression) => blocks(encoding, compression, array.stored, layout),
        };
        Ok(Self {
            element: array.element,
            swap: layout.big_endian != cfg!(target_endian = "big"),
            data: data.map_err(|error| error.dataset(&array.name))?,
        })
    }

    /// The values where they lie in the file as they are.
    pub fn plain(&self) -> Option<Chunk<'a>> {
        match self.data {
            Data::Plain(bytes) => Some(Chunk {
                bytes,
                element: self.element,
                swap: self.swap,
            }),
            _ => None,
        }
    }

    /// Number of bytes of all values; unknown for text.
    pub fn n_bytes(&self) -> Option<usize> {
        match &self.data {
            Data::Text(..) => None,
            Data::Plain(bytes) => Some(bytes.len()),
            Data::Base64 { n_bytes, .. } => Some(*n_bytes),
            Data::Blocks(blocks) => Some(blocks.n_bytes),
        }
    }

    /// The most values that there can be.
    pub fn most_values(&self) -> usize {
        match &self.data {
            Data::Text(text, _) => text.len().div_ceil(2),
            _ => self.n_bytes().unwrap_or(0) / self.element.size(),
        }
    }

    /// How many values there are; the words of text are counted.
    pub fn n_values(&self) -> usize {
        match &self.data {
            Data::Text(text, _) => n_words(text),
            _ => self.most_values(),
        }
    }

    /// Hands the values to `sink` in chunks of a whole number of tuples of `tuple` bytes.
    pub fn for_each(&self, tuple: usize, sink: &mut dyn FnMut(Chunk) -> Result<()>) -> Result<()> {
        let mut aligner = Aligner {
            tuple,
            element: self.element,
            swap: self.swap,
            pending: Vec::new(),
            sink,
        };
        match &self.data {
            Data::Plain(bytes) => {
                let chunk = Chunk {
                    bytes,
                    element: self.element,
                    swap: self.swap,
                };
                if bytes.len() >= tuple {
                    sink(chunk)?;
                }
                return Ok(());
            }
            Data::Text(text, before) => {
                aligner.swap = false;
                text_chunks(text, before, &mut aligner)?;
            }
            Data::Base64 { text, skip, .. } => base64_chunks(text, *skip, &mut aligner)?,
            Data::Blocks(blocks) => blocks.chunks(&mut aligner)?,
        }
        match aligner.pending.is_empty() {
            true => Ok(()),
            false => Err(Error::input(format!(
                "it has {}, which is not a whole number of tuples of {}",
                counted(self.n_values(), "value"),
                tuple / self.element.size()
            ))),
        }
    }
}

/// Number of words of a text.
pub(super) fn n_words(text: &[u8]) -> usize {
    let words = text.split(u8::is_ascii_whitespace);
    words.filter(|word| !word.is_empty()).count()
}

fn text_chunks(text: &[u8], before: &[u8], aligner: &mut Aligner) -> Result<()> {
    let mut start = 0;
    while start < text.len() {
        let end = word_end(text, start.saturating_add(CHUNK));
        let cuts = cuts(text, start, end, CHUNK / 32);
        let element = aligner.element;
        let parts = map(cuts.len() - 1, &|i| {
            parse_words(&text[cuts[i]..cuts[i + 1]], element)
        });
        for (first, part) in cuts.into_iter().zip(parts) {
            let numbers = part.map_err(|(at, message)| {
                let line = line_after(before) - 1 + line_after(&text[..first + at]);
                Error::input(message).line(line)
            })?;
            aligner.push(|bytes| {
                bytes.extend_from_slice(&numbers);
                Ok(())
            })?;
        }
        start = end;
    }
    Ok(())
}

fn base64_chunks(text: &[u8], skip: usize, aligner: &mut Aligner) -> Result<()> {
    let mut skip = skip;
    for part in text.chunks(CHUNK) {
        aligner.push(|bytes| {
            let start = bytes.len();
            base64_simd::STANDARD
                .decode_append(part, bytes)
                .map_err(|_| Error::input("the base64 text is damaged"))?;
            bytes.drain(start..start + skip.min(bytes.len() - start));
            Ok(())
        })?;
        skip = 0;
    }
    Ok(())
}

/// The first `n_bytes` bytes of base64 as characters without white space, and how many characters
/// of `text` they take.
fn base64_run(text: &[u8], n_bytes: usize) -> Result<(Cow<'_, [u8]>, usize)> {
    let short = || {
        let found = text.len();
        Error::input(format!(
            "{n_bytes} bytes in base64 are needed, but only {found} characters are left"
        ))
    };
    let n = n_bytes
        .div_ceil(3)
        .checked_mul(4)
        .filter(|n| *n <= text.len())
        .ok_or_else(short)?;
    if !text[..n].iter().any(u8::is_ascii_whitespace) {
        return Ok((Cow::Borrowed(&text[..n]), n));
    }
    let mut run = Vec::with_capacity(n);
    for (at, byte) in text.iter().enumerate() {
        if !byte.is_ascii_whitespace() {
            run.push(*byte);
            if run.len() == n {
                return Ok((Cow::Owned(run), at + 1));
            }
        }
    }
    Err(short())
}

/// Decodes a run of base64 that should give at least `n_bytes`: padding may cut it short.
fn decode(run: &[u8], n_bytes: usize) -> Result<Vec<u8>> {
    base64_simd::STANDARD
        .decode_to_vec(run)
        .ok()
        .filter(|decoded| decoded.len() >= n_bytes)
        .ok_or_else(|| Error::input("the base64 text is damaged"))
}

/// Uncompressed values: their number of bytes, then they.
fn plain<'a>(encoding: DataEncoding, stored: &'a [u8], layout: &Layout) -> Result<Data<'a>> {
    let width = layout.header_bytes;
    if encoding == DataEncoding::Raw {
        let header = stored.get(..width).ok_or_else(|| no_header(stored))?;
        let n_bytes = header_number(header, layout)?;
        let bytes = stored[width..].get(..n_bytes).ok_or_else(|| {
            let left = stored.len() - width;
            Error::input(format!(
                "its size is {n_bytes} bytes, but only {left} are left in the file"
            ))
        })?;
        return Ok(Data::Plain(bytes));
    }
    let text = stored.trim_ascii_start();
    if text.is_empty() {
        return Ok(Data::Plain(&[]));
    }
    let (run, taken) = base64_run(text, width)?;
    // Padding after the header means that the values are a separate base64 text.
    let apart = run.ends_with(b"=");
    // Without it, the run's last characters belong to the values too.
    let n_bytes = header_number(&decode(&run, width)?[..width], layout)?;
    let (text, skip) = if apart {
        (&text[taken..], 0)
    } else {
        (text, width)
    };
    let total = n_bytes
        .checked_add(skip)
        .ok_or_else(|| Error::input("its size is out of range"))?;
    let (text, _) = base64_run(text.trim_ascii_start(), total)?;
    Ok(Data::Base64 {
        text,
        skip,
        n_bytes,
    })
}

/// Compressed values: a header, then the blocks.
fn blocks<'a>(
    encoding: DataEncoding,
    compression: Compression,
    stored: &'a [u8],
    layout: &Layout,
) -> Result<Data<'a>> {
    let stored = if encoding == DataEncoding::Raw {
        stored
    } else {
        stored.trim_ascii_start()
    };
    if stored.is_empty() && encoding == DataEncoding::Base64 {
        return Ok(Data::Plain(&[]));
    }
    let Some((header, rest)) = block_header(encoding, stored, layout)? else {
        return Ok(Data::Plain(&[]));
    };
    let sizes = BlockSizes::read(&header, layout)?;
    let n_compressed = sizes
        .compressed
        .iter()
        .try_fold(0usize, |sum, size| sum.checked_add(*size));
    let n_compressed = n_compressed.filter(|n| *n <= rest.len()).ok_or_else(|| {
        let left = rest.len();
        Error::input(format!(
            "the compressed blocks are longer than the {left} bytes that are left"
        ))
    })?;
    let BlockSizes { block, last, .. } = sizes;
    check_ratio(compression, sizes.n_bytes, n_compressed, block, last)?;
    let data = match encoding {
        DataEncoding::Raw => Cow::Borrowed(&rest[..n_compressed]),
        _ => {
            let (run, _) = base64_run(rest.trim_ascii_start(), n_compressed)?;
            Cow::Owned(decode(&run, n_compressed)?)
        }
    };
    Ok(Data::Blocks(Blocks {
        compression,
        data,
        sizes: sizes.compressed,
        block_size: block,
        n_bytes: sizes.n_bytes,
    }))
}

/// The header of compressed values as bytes, and what follows it; nothing where there are no blocks.
#[expect(clippy::type_complexity)]
fn block_header<'a>(
    encoding: DataEncoding,
    stored: &'a [u8],
    layout: &Layout,
) -> Result<Option<(Cow<'a, [u8]>, &'a [u8])>> {
    let width = layout.header_bytes;
    let first = |n_bytes: usize| -> Result<(Cow<'a, [u8]>, &'a [u8])> {
        if encoding == DataEncoding::Raw {
            let (header, rest) = stored
                .split_at_checked(n_bytes)
                .ok_or_else(|| no_header(stored))?;
            return Ok((Cow::Borrowed(header), rest));
        }
        let (run, taken) = base64_run(stored, n_bytes)?;
        let mut header = decode(&run, n_bytes)?;
        header.truncate(n_bytes);
        Ok((Cow::Owned(header), &stored[taken..]))
    };
    let n_blocks = header_number(&first(width)?.0, layout)?;
    if n_blocks == 0 {
        return Ok(None);
    }
    let n_header = n_blocks.checked_add(3).and_then(|n| n.checked_mul(width));
    let n_header = n_header.filter(|n| *n <= stored.len()).ok_or_else(|| {
        Error::input(format!(
            "its header says {n_blocks} compressed blocks, more than the file can hold"
        ))
    })?;
    first(n_header).map(Some)
}

/// The header of compressed values: sizes in bytes.
struct BlockSizes {
    /// Of each block but the last, decompressed.
    block: usize,
    last: usize,
    /// Of all blocks, decompressed.
    n_bytes: usize,
    /// Of each block, compressed.
    compressed: Vec<usize>,
}

impl BlockSizes {
    /// Number of blocks (at least one), size of each, size of the last if it is smaller (else zero), compressed size
    /// of each.
    fn read(header: &[u8], layout: &Layout) -> Result<Self> {
        let numbers = header
            .chunks_exact(layout.header_bytes)
            .map(|number| header_number(number, layout))
            .collect::<Result<Vec<_>>>()?;
        let (block, last) = (numbers[1], numbers[2]);
        let compressed = numbers[3..].to_vec();
        let last = if last == 0 { block } else { last };
        let n_bytes = (compressed.len() - 1)
            .checked_mul(block)
            .and_then(|n| n.checked_add(last))
            .ok_or_else(|| Error::input("the size of its blocks is out of range"))?;
        Ok(Self {
            block,
            last,
            n_bytes,
            compressed,
        })
    }
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

fn no_header(stored: &[u8]) -> Error {
    let left = stored.len();
    Error::input(format!(
        "its header is missing: {left} bytes are left in the file"
    ))
}
