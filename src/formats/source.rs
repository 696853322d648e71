//! The bytes of an input: a mapped file, an unpacked one, or standard input.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The bytes of one input file and the name it goes by in messages.
pub struct Source {
    path: PathBuf,
    bytes: Arc<Bytes>,
}

enum Bytes {
    Mapped(memmap2::Mmap),
    Owned(Vec<u8>),
}

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        match self {
            Bytes::Mapped(map) => map,
            Bytes::Owned(bytes) => bytes,
        }
    }
}

/// A handle on the bytes of a [`Source`] that may outlive it.
pub(super) struct Shared(Arc<Bytes>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        (*self.0).as_ref()
    }
}

impl Source {
    /// Opens a file; `-` is standard input; a gzip file is unpacked.
    pub fn open(path: &Path) -> Result<Self> {
        if path.as_os_str() == "-" {
            let mut bytes = Vec::new();
            let name = Path::new("<stdin>");
            std::io::stdin()
                .read_to_end(&mut bytes)
                .map_err(|error| Error::io(name, &error))?;
            return Self::from_bytes(name, bytes).unpacked();
        }
        let io = |error| Error::io(path, &error);
        let file = File::open(path).map_err(io)?;
        if file.metadata().map_err(io)?.is_dir() {
            return Err(Error::input("this is a folder, not a mesh file").file(path));
        }
        // SAFETY: the map is read only. A file that another process shortens meanwhile would fault,
        // as it would for every program that maps its input.
        let mapped = unsafe { memmap2::Mmap::map(&file) };
        let bytes = match mapped {
            Ok(map) => Bytes::Mapped(map),
            Err(_) => Bytes::Owned(std::fs::read(path).map_err(io)?),
        };
        let bytes = Arc::new(bytes);
        let path = path.to_path_buf();
        Self { path, bytes }.unpacked()
    }

    /// Bytes that are in memory already, under a name for messages.
    pub fn from_bytes(name: &Path, bytes: Vec<u8>) -> Self {
        Self {
            path: name.to_path_buf(),
            bytes: Arc::new(Bytes::Owned(bytes)),
        }
    }

    fn unpacked(self) -> Result<Self> {
        if !self.bytes().starts_with(&[0x1f, 0x8b]) {
            return Ok(self);
        }
        let mut unpacked = Vec::new();
        flate2::read::MultiGzDecoder::new(self.bytes())
            .read_to_end(&mut unpacked)
            .map_err(|error| {
                Error::input(format!("the gzip data is damaged: {error}")).file(&self.path)
            })?;
        Ok(Self {
            bytes: Arc::new(Bytes::Owned(unpacked)),
            path: self.path,
        })
    }

    /// The name it goes by in messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        (*self.bytes).as_ref()
    }

    /// Its bytes, for a reader that wants to own them; nothing is copied.
    pub(super) fn shared(&self) -> Shared {
        Shared(Arc::clone(&self.bytes))
    }
}
