//! The location of a mesh that is read, and its bytes: a mapped file, a decompressed one, or standard input.

use super::decompress::{decompress, is_compressed};
use super::inputs::note_opened;
use super::memory_limit::MemoryLimit;
use super::staged::complete_above;
use azimesh_core::error::{Error, Result};
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError, Weak};

/// The bytes of one input file, and its name in messages. Copies share the bytes.
#[derive(Clone)]
pub struct Source {
    path: PathBuf,
    bytes: Arc<Bytes>,
    /// Zeros behind compressed data.
    n_padding: usize,
}

/// Message for a file that another program has truncated.
pub const SHORTER: &str =
    "the file became shorter while it was read; run the command again when no program writes to it";

static MAPPED: Mutex<Vec<MappedFile>> = Mutex::new(Vec::new());

/// A mapped file: its addresses in memory and its name.
struct MappedFile {
    addresses: Range<usize>,
    path: PathBuf,
    bytes: Weak<Bytes>,
}

fn mapped() -> MutexGuard<'static, Vec<MappedFile>> {
    MAPPED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lets go of the memory that holds mapped files, as `Source::release` does.
pub fn release_mapped() {
    // The last handle on a file removes it from the list.
    let handles = |file: &MappedFile| file.bytes.upgrade();
    let all: Vec<_> = mapped().iter().filter_map(handles).collect();
    all.iter().for_each(|bytes| bytes.release_all());
}

/// Calls `act` with the name of the mapped file at an address; returns whether there is one. A handler of signals may call
/// it: it allocates nothing, and no thread reads a mapped file while it holds the list.
pub fn with_mapped_at(address: usize, act: impl FnOnce(&Path)) -> bool {
    let files = loop {
        match MAPPED.try_lock() {
            Ok(files) => break files,
            Err(TryLockError::Poisoned(files)) => break files.into_inner(),
            Err(TryLockError::WouldBlock) => std::hint::spin_loop(),
        }
    };
    let file = files.iter().find(|file| file.addresses.contains(&address));
    file.map(|file| act(&file.path)).is_some()
}

enum Bytes {
    /// A map that is in the list of mapped files until it is dropped.
    Mapped(memmap2::Mmap),
    Owned(Vec<u8>),
}

impl Drop for Bytes {
    fn drop(&mut self) {
        if let Self::Mapped(map) = self {
            let start = map.as_ptr().addr();
            mapped().retain(|file| file.addresses.start != start);
        }
    }
}

impl Bytes {
    fn mapped(map: memmap2::Mmap, path: &Path) -> Arc<Self> {
        let start = map.as_ptr().addr();
        let addresses = start..start + map.len();
        let bytes = Arc::new(Self::Mapped(map));
        let file = MappedFile {
            addresses,
            path: path.to_path_buf(),
            bytes: Arc::downgrade(&bytes),
        };
        mapped().push(file);
        bytes
    }

    fn release_all(&self) {
        self.release(0..self.as_ref().len());
    }

    fn release(&self, bytes: Range<usize>) {
        #[cfg(unix)]
        if let Bytes::Mapped(map) = self {
            let advice = memmap2::UncheckedAdvice::DontNeed;
            // SAFETY: the map is of a file, read only and private, so that its bytes are again read from the file.
            let _ = unsafe { map.unchecked_advise_range(advice, bytes.start, bytes.len()) };
        }
    }
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
    /// Opens a file; `-` is standard input; a compressed file is decompressed. Decompressed content, and the content of a
    /// pipe, may take half of the free memory.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_within(path, None)
    }

    /// [`Source::open`] with a limit in bytes for decompressed content and the content of a pipe.
    pub fn open_within(path: &Path, max_memory: Option<u64>) -> Result<Self> {
        let limit = MemoryLimit::new(max_memory);
        if path.as_os_str() == "-" {
            return Self::standard_input(limit)?.decompressed(limit);
        }
        Self::stored_within(path, limit)?.decompressed(limit)
    }

    /// Opens a file as stored, compressed or not.
    pub(super) fn stored(path: &Path) -> Result<Self> {
        Self::stored_within(path, MemoryLimit::new(None))
    }

    /// The same source with its content decompressed, where it is compressed; it may take half of the free memory.
    pub(super) fn content(&self) -> Result<Self> {
        self.clone().decompressed(MemoryLimit::new(None))
    }

    fn stored_within(path: &Path, limit: MemoryLimit) -> Result<Self> {
        let io = |error| Error::io(path, &error);
        check_no_device(path).map_err(io)?;
        let file = File::open(path).map_err(io)?;
        if file.metadata().map_err(io)?.is_dir() {
            return Err(folder(path));
        }
        note_opened(path, &file);
        match map(&file, 0) {
            Some(map) => Ok(Self::of(path, Bytes::mapped(map, path))),
            None => Ok(Self::from_bytes(path, read_all(&file, limit).map_err(io)?)),
        }
    }

    fn of(path: &Path, bytes: Arc<Bytes>) -> Self {
        Self {
            path: path.to_path_buf(),
            bytes,
            n_padding: 0,
        }
    }

    /// Standard input: mapped where it is a file, read where it is a pipe.
    fn standard_input(limit: MemoryLimit) -> Result<Self> {
        let name = Path::new("<stdin>");
        if let Some(map) = map_standard_input() {
            return Ok(Self::of(name, Bytes::mapped(map, name)));
        }
        let bytes = read_all(std::io::stdin().lock(), limit);
        let bytes = bytes.map_err(|error| Error::io(name, &error))?;
        Ok(Self::from_bytes(name, bytes))
    }

    /// A source of bytes in memory, with a name for messages.
    pub fn from_bytes(name: &Path, bytes: Vec<u8>) -> Self {
        Self::of(name, Arc::new(Bytes::Owned(bytes)))
    }

    /// The same source with its content decompressed, where it is compressed.
    fn decompressed(self, limit: MemoryLimit) -> Result<Self> {
        match decompress(self.bytes(), limit) {
            None => Ok(self),
            Some(Ok((bytes, n_padding))) => Ok(Self {
                bytes: Arc::new(Bytes::Owned(bytes)),
                path: self.path,
                n_padding,
            }),
            Some(Err(error)) => Err(error.file(&self.path)),
        }
    }

    /// Checks if the [stored](Self::stored) bytes are compressed.
    pub(super) fn is_compressed(&self) -> bool {
        is_compressed((*self.bytes).as_ref())
    }

    /// Checks if the file is mapped, so that only what is read of it is in memory.
    pub(super) fn is_mapped(&self) -> bool {
        matches!(*self.bytes, Bytes::Mapped(_))
    }

    /// Refuses a mapped file that has become shorter: what is read beyond its end is zero up to the end of a page of memory.
    pub(super) fn check_whole(&self) -> Result<()> {
        let n_bytes = (*self.bytes).as_ref().len() as u64;
        let is_shorter = |found: std::fs::Metadata| found.is_file() && found.len() < n_bytes;
        if self.is_mapped() && std::fs::metadata(&self.path).is_ok_and(is_shorter) {
            return Err(Error::system(SHORTER).file(&self.path));
        }
        Ok(())
    }

    /// Zeros behind compressed data, which were passed over.
    pub fn n_padding(&self) -> usize {
        self.n_padding
    }

    /// The path, as messages give it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes; of text without the byte order mark that some editors put before UTF-8.
    pub fn bytes(&self) -> &[u8] {
        without_mark((*self.bytes).as_ref())
    }

    /// Lets go of the memory that holds a mapped file: its bytes are read again from the file where they are needed again.
    pub(super) fn release(&self) {
        self.bytes.release_all();
    }

    /// [`Source::release`] of some of its bytes.
    pub(super) fn release_part(&self, bytes: Range<usize>) {
        self.bytes.release(bytes);
    }

    /// A shared handle on the bytes, for a reader that has to own them; nothing is copied.
    pub(super) fn shared(&self) -> Shared {
        Shared(Arc::clone(&self.bytes))
    }
}

fn folder(path: &Path) -> Error {
    Error::input("this is a folder, not a mesh file").file(path)
}

/// The location of a mesh that is read.
pub enum Location {
    /// A file, decompressed, or standard input.
    File(Source),
    /// A folder, in which a format finds its files.
    Folder(PathBuf),
}

impl Location {
    /// Opens a path; `-` is standard input. Decompressed content, and the content of a pipe, may use
    /// half of the free memory.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_within(path, None)
    }

    /// [`Location::open`] with a limit in bytes for decompressed content and the content of a pipe.
    pub fn open_within(path: &Path, max_memory: Option<u64>) -> Result<Self> {
        if path.as_os_str() != "-" {
            complete_above(path)?;
        }
        if path.is_dir() {
            return Ok(Self::Folder(path.to_path_buf()));
        }
        Source::open_within(path, max_memory).map(Self::File)
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
    /// If it is a folder.
    pub fn file(&self) -> Result<&Source> {
        match self {
            Self::File(source) => Ok(source),
            Self::Folder(path) => Err(folder(path)),
        }
    }

    /// The bytes of the file; none of a folder.
    pub fn bytes(&self) -> &[u8] {
        self.file().map_or(&[], Source::bytes)
    }
}

impl From<Source> for Location {
    fn from(source: Source) -> Self {
        Self::File(source)
    }
}

/// Text without the byte order mark of UTF-8. A file that continues with control characters is binary, and may
/// start with these bytes.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    let is_text = |byte: &u8| byte.is_ascii_whitespace() || !byte.is_ascii_control();
    match bytes.strip_prefix(b"\xef\xbb\xbf") {
        Some(rest) if rest.first().is_none_or(is_text) => rest,
        _ => bytes,
    }
}

/// Refuses devices, which may give bytes without end.
pub fn check_no_device(path: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = std::fs::metadata(path)?.file_type();
        if kind.is_char_device() || kind.is_block_device() {
            let message = "this is a device, not a file";
            return Err(io::Error::new(ErrorKind::InvalidInput, message));
        }
    }
    Ok(())
}

/// Refuses what is no regular file: a folder, a device, or a pipe, whose reader may wait for ever. For files that
/// another file refers to, and for companion files.
pub fn check_file(path: &Path) -> io::Result<()> {
    let message = "this is a folder, a pipe or a device, not a file";
    let is_file = std::fs::metadata(path)?.is_file();
    let refusal = || io::Error::new(ErrorKind::InvalidInput, message);
    is_file.then_some(()).ok_or_else(refusal)
}

/// The content of a small companion file, which must be a file: a pipe may wait for ever.
pub fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    check_file(path)?;
    read_input(path)
}

/// The content of a small input, which may be a pipe.
pub fn read_input(path: &Path) -> io::Result<Vec<u8>> {
    check_no_device(path)?;
    let mut file = File::open(path)?;
    note_opened(path, &file);
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn read_all(from: impl Read, limit: MemoryLimit) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    limit.read_all(from, &mut bytes)?;
    Ok(bytes)
}

/// The bytes of a file from `start` on, where the system can map them.
fn map(file: &File, start: u64) -> Option<memmap2::Mmap> {
    let mut options = memmap2::MmapOptions::new();
    // SAFETY: the map is read only. Where another process shortens the file, a read beyond its end raises SIGBUS,
    // for which the program has a handler.
    unsafe { options.offset(start).map(file) }.ok()
}

/// Maps the rest of standard input, where it is a file.
#[cfg(unix)]
fn map_standard_input() -> Option<memmap2::Mmap> {
    use std::io::Seek;
    use std::os::fd::AsFd;
    let stdin = std::io::stdin().as_fd().try_clone_to_owned().ok()?;
    let mut file = File::from(stdin);
    if !file.metadata().ok()?.is_file() {
        return None;
    }
    let start = file.stream_position().ok()?;
    map(&file, start)
}

#[cfg(not(unix))]
fn map_standard_input() -> Option<memmap2::Mmap> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{Encoding, FORMATS, ReadOptions, WriteOptions, read};
    use crate::mesh::{CellKind, Mesh};

    const MARK: &[u8] = b"\xef\xbb\xbf";

    #[test]
    fn the_mark_of_utf_8_changes_no_text() {
        let mut mesh = Mesh::of_points(vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]);
        mesh.cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
        let options = WriteOptions {
            encoding: Encoding::Ascii,
            ..WriteOptions::default()
        };
        let mut n_texts = 0;
        for format in FORMATS {
            let mut file = MARK.to_vec();
            // A list of pieces is nothing without them, and surfaces have an order of their own.
            if format.name == "pvtu"
                || format.is_surface
                || format
                    .write_file(&mesh.view(), &mut file, &options)
                    .is_err()
            {
                continue;
            }
            if !file[MARK.len()..].is_ascii() || file.contains(&0) {
                continue;
            }
            let source = Source::from_bytes(Path::new("marked"), file);
            let found = read(&source.into(), &ReadOptions::default()).map(|loaded| loaded.mesh);
            let found = found.unwrap_or_else(|error| panic!("{}: {error}", format.name));
            assert_eq!(found.points, mesh.points, "{}", format.name);
            n_texts += 1;
        }
        assert_eq!(n_texts, 7, "vtu, vtk, vtk42, msh, msh22, su2 and ugrid");
    }

    #[test]
    fn a_mapped_file_that_has_become_shorter_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.su2");
        std::fs::write(&path, [1; 100]).expect("it is written");
        let source = Source::open(&path).expect("it is there");
        source.check_whole().expect("it is whole");
        let at = source.bytes().as_ptr().addr() + 99;
        let mut found = PathBuf::new();
        assert!(with_mapped_at(at, |path| found = path.to_path_buf()));
        assert_eq!(found, path);
        let file = File::options().write(true).open(&path);
        file.and_then(|file| file.set_len(99)).expect("it is ours");
        let error = source.check_whole().expect_err("a byte is lost");
        assert_eq!(error.kind, azimesh_core::error::ErrorKind::System);
        drop(source);
        assert!(!with_mapped_at(at, |_| {}));
    }

    #[test]
    fn binary_files_may_start_like_the_mark() {
        let bytes = [MARK, &[0, 1, 2]].concat();
        assert_eq!(without_mark(&bytes), bytes);
        assert_eq!(without_mark(MARK), b"");
    }
}
