//! Packed files: gzip, xz and zstd, known by their first bytes, any number of members in a row.

use super::room::Room;
use crate::error::{Error, Result};
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};
use std::io::{self, ErrorKind};

/// Most memory that a dictionary or window may take, as a file asks for it.
const WINDOW: u64 = 2 << 30;

/// How a file is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Packing {
    Gzip,
    Xz,
    Zstd,
}

/// Endings of packed files.
const ENDINGS: &[&str] = &[".gz", ".xz", ".zst"];

/// A file name without the ending of a packed file.
pub fn without_packing(name: &str) -> &str {
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

/// What a packed file holds; `None` for any other. A small file may hold much: more than there is room for is
/// an error.
pub(super) fn unpack(bytes: &[u8], room: Room) -> Option<Result<Vec<u8>>> {
    let packing = match bytes {
        [0x1f, 0x8b, ..] => Packing::Gzip,
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => Packing::Xz,
        [0x28, 0xb5, 0x2f, 0xfd, ..] => Packing::Zstd,
        [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..] => Packing::Zstd,
        _ => return None,
    };
    let room = room.of_packed(bytes.len());
    let mut unpacked = Vec::new();
    let result = match packing {
        Packing::Gzip => {
            let file = flate2::read::MultiGzDecoder::new(bytes);
            room.read_all(file, &mut unpacked)
        }
        Packing::Xz => {
            let limit = (WINDOW >> 10) as u32;
            let file = lzma_rust2::XzReader::new_mem_limit(bytes, true, limit);
            room.read_all(file, &mut unpacked)
        }
        Packing::Zstd => zstd(bytes, room, &mut unpacked),
    };
    Some(match result {
        Ok(()) => Ok(unpacked),
        Err(error) => Err(refusal(packing, unpacked.len(), &error)),
    })
}

fn refusal(packing: Packing, n_unpacked: usize, error: &io::Error) -> Error {
    let name = match packing {
        Packing::Gzip => "gzip",
        Packing::Xz => "xz",
        Packing::Zstd => "zstd",
    };
    match error.kind() {
        ErrorKind::FileTooLarge => Error::system(format!("the {name} data is unpacked to {error}")),
        ErrorKind::OutOfMemory => Error::system(format!(
            "no memory is left after {n_unpacked} bytes of {name} data are unpacked"
        )),
        _ => Error::input(format!(
            "the {name} data is damaged after {n_unpacked} bytes that are unpacked: {error}"
        )),
    }
}

/// Unpacks every frame; frames that hold no data are passed over.
fn zstd(bytes: &[u8], room: Room, out: &mut Vec<u8>) -> io::Result<()> {
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
        room.read_all(&mut frame, out)?;
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
    use crate::error::ErrorKind;
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

    fn unpack(bytes: &[u8]) -> Option<Result<Vec<u8>>> {
        super::unpack(bytes, Room::new(None))
    }

    type Packer = fn(&[u8]) -> Vec<u8>;
    const PACKERS: [Packer; 3] = [gzip, xz, zst];

    #[test]
    fn members_in_a_row_are_one_file() {
        for pack in PACKERS {
            let file = [pack(b"NDIME= 2\n"), pack(b""), pack(b"NELEM= 0\n")].concat();
            let text = unpack(&file).expect("it is packed").expect("it is whole");
            assert_eq!(text, b"NDIME= 2\nNELEM= 0\n");
        }
        assert!(unpack(b"NDIME= 2\n").is_none());
        let skipped = [&[0x51, 0x2a, 0x4d, 0x18, 2, 0, 0, 0, 7, 7][..], &zst(b"x")].concat();
        let text = unpack(&skipped).expect("it is packed").expect("whole");
        assert_eq!(text, b"x");
    }

    #[test]
    fn damaged_data_is_refused_in_a_sentence() {
        let text: Vec<u8> = (0..20_000u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        for pack in PACKERS {
            let whole = pack(&text);
            for length in [8, whole.len() / 2, whole.len() - 2] {
                let result = unpack(&whole[..length]).expect("it is packed");
                let message = result.expect_err("it is cut off").to_string();
                assert!(message.contains("data is damaged"), "{message}");
            }
            for at in (12..whole.len()).step_by(whole.len() / 50) {
                let mut file = whole.clone();
                file[at] ^= 0x55;
                let result = unpack(&file).expect("it is packed");
                assert!(result.is_err() || result.is_ok_and(|back| back == text));
            }
        }
    }

    #[test]
    fn what_unpacks_to_more_than_there_is_room_for_is_refused() {
        let text = vec![b' '; 3_000_000];
        for pack in PACKERS {
            let file = [pack(&text), pack(&text)].concat();
            let room = |n: u64| super::unpack(&file, Room::new(Some(n))).expect("it is packed");
            assert_eq!(room(6_000_000).expect("it fits").len(), 6_000_000);
            for n in [5_999_999, 3_000_000, 1000, 0] {
                let error = room(n).expect_err("it is too much");
                assert_eq!(error.kind, ErrorKind::System);
                let limit = format!("more than {n} bytes, what --max-memory allows");
                assert!(error.message.contains(&limit), "{error}");
            }
        }
    }

    #[test]
    fn an_ending_of_a_packed_file_is_cut() {
        assert_eq!(without_packing("wing.b8.ugrid.GZ"), "wing.b8.ugrid");
        assert_eq!(without_packing("wing.su2"), "wing.su2");
        assert_eq!(without_packing(".zst"), "");
    }
}
