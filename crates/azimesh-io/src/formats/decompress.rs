//! Decompresses input files: gzip, xz and zstd, recognized by their first bytes, with any number of members.

use super::memory_limit::MemoryLimit;
use azimesh_core::error::{Error, Result};
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};
use std::io::{self, ErrorKind};

/// The largest dictionary or window, in bytes, that a file may require.
const WINDOW: u64 = 2 << 30;

/// Extensions of compressed files.
const ENDINGS: &[&str] = &[".gz", ".xz", ".zst"];

/// A file name without the extension of a compressed file.
pub fn without_compression(name: &str) -> &str {
    let is_end = |ending: &&&str| {
        let from = name.len().checked_sub(ending.len());
        let end = from.and_then(|from| name.get(from..));
        end.is_some_and(|end| end.eq_ignore_ascii_case(ending))
    };
    match ENDINGS.iter().find(is_end) {
        Some(ending) => &name[..name.len() - ending.len()],
        None => name,
    }
}

/// The format of a compressed file with these first bytes.
fn codec(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x1f, 0x8b, ..] => Some("gzip"),
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => Some("xz"),
        [0x28, 0xb5, 0x2f, 0xfd, ..] | [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..] => Some("zstd"),
        _ => None,
    }
}

/// Checks if a file with these first bytes is compressed.
pub(super) fn is_compressed(bytes: &[u8]) -> bool {
    codec(bytes).is_some()
}

/// The content of a compressed file, and the number of zeros that a gzip file is filled up with at its end; `None` for
/// any other file. More than `limit` allows is an error.
pub(super) fn decompress(bytes: &[u8], limit: MemoryLimit) -> Option<Result<(Vec<u8>, usize)>> {
    let codec = codec(bytes)?;
    let limit = limit.for_compressed(bytes.len());
    let mut content = Vec::new();
    let mut n_padding = 0;
    let result = match codec {
        "gzip" => gzip(bytes, limit, &mut content).map(|n| n_padding = n),
        "xz" => {
            let window_kib = (WINDOW >> 10) as u32;
            let file = lzma_rust2::XzReader::new_mem_limit(bytes, true, window_kib);
            limit.read_all(file, &mut content)
        }
        _ => zstd(bytes, limit, &mut content),
    };
    Some(match result {
        Ok(()) => Ok((content, n_padding)),
        Err(error) => Err(refusal(codec, content.len(), &error)),
    })
}

fn refusal(name: &str, n_bytes: usize, error: &io::Error) -> Error {
    match error.kind() {
        ErrorKind::FileTooLarge => {
            Error::system(format!("the {name} data decompresses to {error}"))
        }
        ErrorKind::OutOfMemory => Error::system(format!(
            "no memory is left after {n_bytes} decompressed bytes of {name} data"
        )),
        _ => Error::input(format!(
            "the {name} data is damaged after {n_bytes} decompressed bytes: {}",
            reason(error)
        )),
    }
}

/// The fault of compressed data, in the words of its decoder if these are plain.
pub fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    if error.kind() == ErrorKind::UnexpectedEof || text.contains("UnexpectedEof") {
        return "it ends too early".to_owned();
    }
    let is_plain = !text.contains(['{', '(']);
    if is_plain {
        text
    } else {
        "a block cannot be decoded".to_owned()
    }
}

/// Decompresses every member; the number of zeros behind the last, as tapes and some tools leave them.
fn gzip(bytes: &[u8], limit: MemoryLimit, out: &mut Vec<u8>) -> io::Result<usize> {
    let mut rest = bytes;
    loop {
        let mut member = flate2::bufread::GzDecoder::new(rest);
        limit.read_all(&mut member, out)?;
        rest = member.into_inner();
        if rest.iter().all(|byte| *byte == 0) {
            return Ok(rest.len());
        }
    }
}

/// Decompresses every frame; skippable frames are skipped.
fn zstd(bytes: &[u8], limit: MemoryLimit, out: &mut Vec<u8>) -> io::Result<()> {
    let mut rest = bytes;
    while !rest.is_empty() {
        if let [0x50..=0x5f, 0x2a, 0x4d, 0x18, a, b, c, d, tail @ ..] = rest {
            let length = u32::from_le_bytes([*a, *b, *c, *d]) as usize;
            rest = tail.get(length..).ok_or(ErrorKind::UnexpectedEof)?;
            continue;
        }
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(WINDOW);
        let mut frame =
            StreamingDecoder::new_with_decoder(rest, decoder).map_err(io::Error::other)?;
        limit.read_all(&mut frame, out)?;
        let (tail, decoder) = frame.into_parts();
        let promised = decoder.get_checksum_from_data();
        if promised.is_some() && promised != decoder.get_calculated_checksum() {
            return Err(io::Error::other("the checksum is wrong"));
        }
        rest = tail;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;
    use azimesh_core::error::ErrorKind;
    use flate2::{Compression, write::GzEncoder};
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    use std::io::Write;

    fn gzip(text: &[u8]) -> Vec<u8> {
        let mut file = GzEncoder::new(Vec::new(), Compression::fast());
        file.write_all(text).expect("a vector takes all");
        file.finish().expect("a vector takes all")
    }

    fn xz(text: &[u8]) -> Vec<u8> {
        let options = lzma_rust2::XzOptions::with_preset(1);
        let mut file = lzma_rust2::XzWriter::new(Vec::new(), options).expect("good options");
        file.write_all(text).expect("a vector takes all");
        file.finish().expect("a vector takes all")
    }

    fn zst(text: &[u8]) -> Vec<u8> {
        compress_to_vec(text, CompressionLevel::Fastest)
    }

    fn decompress(bytes: &[u8]) -> Option<Result<Vec<u8>>> {
        let found = super::decompress(bytes, MemoryLimit::new(None));
        found.map(|found| found.map(|(content, _)| content))
    }

    #[test]
    fn zeros_behind_gzip_data_are_counted_and_other_bytes_are_refused() {
        let mut file = [gzip(b"NDIME= "), gzip(b"2\n")].concat();
        file.extend([0; 100]);
        let found = super::decompress(&file, MemoryLimit::new(None)).expect("it is compressed");
        assert_eq!(found.expect("it is whole"), (b"NDIME= 2\n".to_vec(), 100));
        file.push(1);
        let found = super::decompress(&file, MemoryLimit::new(None)).expect("it is compressed");
        assert!(found.is_err());
    }

    type Compressor = fn(&[u8]) -> Vec<u8>;
    const COMPRESSORS: [Compressor; 3] = [gzip, xz, zst];

    #[test]
    fn members_in_a_row_are_one_file() {
        for compress in COMPRESSORS {
            let file = [
                compress(b"NDIME= 2\n"),
                compress(b""),
                compress(b"NELEM= 0\n"),
            ]
            .concat();
            let text = decompress(&file)
                .expect("it is compressed")
                .expect("it is whole");
            assert_eq!(text, b"NDIME= 2\nNELEM= 0\n");
        }
        assert!(decompress(b"NDIME= 2\n").is_none());
        let skipped = [&[0x51, 0x2a, 0x4d, 0x18, 2, 0, 0, 0, 7, 7][..], &zst(b"x")].concat();
        let text = decompress(&skipped)
            .expect("it is compressed")
            .expect("whole");
        assert_eq!(text, b"x");
    }

    #[test]
    fn damaged_data_is_refused_in_a_sentence() {
        let text: Vec<u8> = (0..20_000u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        for compress in COMPRESSORS {
            let whole = compress(&text);
            for length in [8, whole.len() / 2, whole.len() - 2] {
                let result = decompress(&whole[..length]).expect("it is compressed");
                let message = result.expect_err("it is cut off").to_string();
                assert_says(&message, "data is damaged");
            }
            for at in (12..whole.len()).step_by(whole.len() / 50) {
                let mut file = whole.clone();
                file[at] ^= 0x55;
                let result = decompress(&file).expect("it is compressed");
                assert!(result.is_err() || result.is_ok_and(|back| back == text));
            }
        }
    }

    #[test]
    fn content_beyond_the_memory_limit_is_refused() {
        let text = vec![b' '; 3_000_000];
        for compress in COMPRESSORS {
            let file = [compress(&text), compress(&text)].concat();
            let with_limit = |n: u64| {
                super::decompress(&file, MemoryLimit::new(Some(n))).expect("it is compressed")
            };
            assert_eq!(with_limit(6_000_000).expect("it fits").0.len(), 6_000_000);
            for n in [5_999_999, 3_000_000, 1000, 0] {
                let error = with_limit(n).expect_err("it is too much");
                assert_eq!(error.kind, ErrorKind::System);
                let limit = format!("more than {n} bytes, the limit set by `max_memory`");
                assert_says(&error.message, &limit);
            }
        }
    }

    #[test]
    fn the_extension_of_a_compressed_file_is_removed() {
        assert_eq!(without_compression("wing.b8.ugrid.GZ"), "wing.b8.ugrid");
        assert_eq!(without_compression("wing.su2"), "wing.su2");
        assert_eq!(without_compression(".zst"), "");
    }
}
