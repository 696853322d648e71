//! Hashes of files and folders on the disk.

use super::opened::hash_of_read;
use super::openfoam::hash_of_origin;
use super::output_set::{hash_of_folder, hash_of_names};
use super::pvtu;
use super::source::check_file;
use crate::mesh::Mesh;
use std::collections::BTreeMap;
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

/// The hash of a mesh that was read from `path`, of the bytes that were read: of the file, or of what a case holds of the mesh.
pub fn hash_of_input(path: &Path, mesh: &Mesh) -> std::io::Result<blake3::Hash> {
    hash_of_origin(mesh).map_or_else(|| hash_of_pieces(path, &hash_of_read), Ok)
}

/// The hash of a file or folder with a mesh; of a list of pieces (.pvtu, not compressed) that of these too.
pub fn hash_of_mesh_file(path: &Path) -> std::io::Result<blake3::Hash> {
    hash_of_pieces(path, &hash_of)
}

fn hash_of_pieces(
    path: &Path,
    hash_of: &dyn Fn(&Path) -> std::io::Result<blake3::Hash>,
) -> std::io::Result<blake3::Hash> {
    let pieces = match path.is_file() {
        true => pvtu::pieces_of(path)?,
        false => Vec::new(),
    };
    if pieces.is_empty() {
        return hash_of(path);
    }
    let of_piece = |name: String| {
        let hash = hash_of(&path.with_file_name(&name))?;
        Ok((name, hash))
    };
    let mut named = pieces
        .into_iter()
        .map(of_piece)
        .collect::<std::io::Result<BTreeMap<_, _>>>()?;
    named.insert(String::new(), hash_of(path)?);
    Ok(hash_of_names(&named))
}

/// The hash of some bytes of a file.
pub fn hash_of_range(path: &Path, bytes: Range<u64>) -> std::io::Result<blake3::Hash> {
    check_file(path)?;
    hash_of_file(&mut File::open(path)?, bytes)
}

/// The hash of some bytes of an open file.
pub(super) fn hash_of_file(file: &mut File, bytes: Range<u64>) -> std::io::Result<blake3::Hash> {
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
