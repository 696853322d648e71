//! Recognizes HDF5 files, and files that are cut off, by their superblock.
//!
//! Format: HDF5 File Format Specification version 3.0, section II.A.

use crate::formats::Source;
use azimesh_core::error::{Error, Result};

/// First bytes of an HDF5 file.
pub(in crate::formats) const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Offset of the superblock: the first byte, or behind a block of another program's.
fn start(bytes: &[u8]) -> Option<usize> {
    let doubling = std::iter::successors(Some(512_usize), |at| at.checked_mul(2));
    std::iter::once(0)
        .chain(doubling)
        .take_while(|at| *at < bytes.len())
        .find(|at| bytes[*at..].starts_with(SIGNATURE))
}

/// Checks if these are the bytes of an HDF5 file, also behind a block of another program's.
pub(in crate::formats) fn is_hdf5(bytes: &[u8]) -> bool {
    start(bytes).is_some()
}

/// The length of the file by its superblock, from its first bytes `start`. `None` where it has another version.
fn said(bytes: &[u8]) -> Option<Option<u64>> {
    let version = *bytes.get(8)?;
    let (size_at, first) = match version {
        0 => (13, 24),
        1 => (13, 28),
        2 | 3 => (9, 12),
        _ => return Some(None),
    };
    let size = usize::from(*bytes.get(size_at)?);
    if ![2, 4, 8].contains(&size) {
        return Some(None);
    }
    // Base address, then another address, then the end of the file.
    let end = bytes.get(first + 2 * size..first + 3 * size)?;
    let value = end.iter().rev();
    Some(Some(
        value.fold(0, |value, byte| value << 8 | u64::from(*byte)),
    ))
}

/// An error for a file that begins as HDF5 does and ends before its end.
pub(in crate::formats) fn cut_off(bytes: &[u8]) -> Option<Error> {
    let n = bytes.len();
    let message = match said(&bytes[start(bytes)?..]) {
        None => format!("the HDF5 file is cut off: it ends within its header, after {n} bytes"),
        Some(Some(end)) if end > n as u64 => {
            format!(
                "the HDF5 file is cut off: it has {n} bytes of the {end} that its header states"
            )
        }
        Some(_) => return None,
    };
    Some(Error::input(message).byte(n as u64))
}

/// Refuses what is no HDF5 file, or a part of one.
pub(super) fn check(source: &Source) -> Result<()> {
    let bytes = source.bytes();
    if !is_hdf5(bytes) {
        return Err(Error::input(format!(
            "this is no HDF5 file: it begins with {}, and HDF5 with \"{}\"",
            first_bytes(bytes),
            SIGNATURE.escape_ascii()
        ))
        .byte(0));
    }
    cut_off(bytes).map_or(Ok(()), Err)
}

/// First bytes of a file, for errors.
pub(in crate::formats) fn first_bytes(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(16)];
    format!("\"{}\"", head.escape_ascii())
}

#[cfg(test)]
mod tests {
    use super::super::Tree;
    use super::*;
    use crate::testing::assert_says;

    #[test]
    fn a_file_that_is_cut_off_says_so_wherever_its_superblock_is() {
        let mut file = Vec::new();
        let mut tree = Tree::new();
        tree.group(Tree::ROOT, "a");
        tree.write(&mut file).expect("memory takes it");
        assert!(is_hdf5(&file) && cut_off(&file).is_none());
        let n = file.len();
        let told = |bytes: &[u8]| cut_off(bytes).map(|error| error.to_string());
        for len in 8..n {
            let told = told(&file[..len]).expect("it is cut off");
            let expected = if len < 36 {
                format!("it ends within its header, after {len} bytes")
            } else {
                format!("it has {len} bytes of the {n} that")
            };
            assert_says(&told, &expected);
        }
        // Superblocks of the first versions, with addresses of 4 bytes, behind 512 bytes of another program.
        for version in [0, 1] {
            let mut old = vec![0; 512];
            old.extend_from_slice(SIGNATURE);
            old.extend([version, 0, 0, 0, 0, 4, 4, 0]);
            old.resize(512 + if version == 0 { 24 } else { 28 } + 8, 0);
            old.extend(2000_u32.to_le_bytes());
            old.resize(2000, 0);
            assert!(is_hdf5(&old) && told(&old).is_none());
            assert!(told(&old[..1999]).is_some_and(|told| told.contains("1999 bytes of the 2000")));
        }
        assert!(told(b"\x88HDF\r\n\x1a\n").is_none());
    }
}
