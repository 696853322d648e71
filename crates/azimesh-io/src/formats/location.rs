//! The location of a mesh that is read: a file, standard input, or a folder.

use super::source::Source;
use azimesh_core::error::{Error, Result};
use std::path::{Path, PathBuf};

/// The location of a mesh that is read.
pub enum Location {
    /// A file, decompressed, or standard input.
    File(Source),
    /// A folder, in which a format finds its files.
    Folder(PathBuf),
}

impl Location {
    /// Opens a path; `-` is standard input. Decompressed content, and that of a pipe, may take
    /// half of the free memory.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_within(path, None)
    }

    /// [`Location::open`] with a limit in bytes for decompressed content and that of a pipe.
    pub fn open_within(path: &Path, max_memory: Option<u64>) -> Result<Self> {
        match path.is_dir() {
            true => Ok(Self::Folder(path.to_path_buf())),
            false => Source::open_within(path, max_memory).map(Self::File),
        }
    }

    /// The path, as messages give it.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(source) => source.path(),
            Self::Folder(path) => path,
        }
    }

    /// The file.
    ///
    /// # Errors
    /// Where it is a folder.
    pub fn file(&self) -> Result<&Source> {
        match self {
            Self::File(source) => Ok(source),
            Self::Folder(path) => Err(Error::input("this is a folder, not a mesh file").file(path)),
        }
    }

    /// The bytes of the file; none of a folder.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::File(source) => source.bytes(),
            Self::Folder(_) => &[],
        }
    }
}

impl From<Source> for Location {
    fn from(source: Source) -> Self {
        Self::File(source)
    }
}
