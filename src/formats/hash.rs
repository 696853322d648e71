//! Hashes of files and folders on the disk.

use super::openfoam::hash_of_origin;
use super::output_set::hash_of_folder;
use super::source::check_no_device;
use crate::mesh::Mesh;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// Bytes that are read at once.
const PIECE: usize = 4 << 20;

/// The hash of a file, read piece by piece: a mapped file would count as memory of the run; of a folder, that of
/// its files.
pub fn hash_of(path: &Path) -> std::io::Result<blake3::Hash> {
    match path.is_dir() {
        true => hash_of_folder(path, hash_of),
        false => hash_of_range(path, 0..u64::MAX),
    }
}

/// The hash of a mesh that was read from `path`: of the file, or of what a case holds of the mesh.
pub fn hash_of_input(path: &Path, mesh: &Mesh) -> std::io::Result<blake3::Hash> {
    hash_of_origin(mesh).map_or_else(|| hash_of(path), Ok)
}

/// The hash of some bytes of a file.
pub fn hash_of_range(path: &Path, bytes: Range<u64>) -> std::io::Result<blake3::Hash> {
    check_no_device(path)?;
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(bytes.start))?;
    let mut file = file.take(bytes.end.saturating_sub(bytes.start));
    let mut hasher = blake3::Hasher::new();
    let mut piece = Vec::with_capacity(PIECE);
    loop {
        piece.clear();
        if file.by_ref().take(PIECE as u64).read_to_end(&mut piece)? == 0 {
            return Ok(hasher.finalize());
        }
        hasher.update_rayon(&piece);
    }
}
