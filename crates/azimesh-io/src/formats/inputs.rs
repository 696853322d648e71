//! Input files: those that an output must not replace, and hashes of the bytes that were read.
//!
//! Inputs are known by their identity on the disk, device and inode, so that links count. The inputs of a run are kept
//! open until they are hashed: the hash is then the hash of the bytes that were read, also if another file has taken the
//! name meanwhile.

use super::openfoam;
use super::source::check_file;
use crate::mesh::Mesh;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::fs::{self, File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// The inputs that no output may replace, once [`guard_inputs`] has been called.
static GUARDED: Mutex<Option<Inputs>> = Mutex::new(None);

/// Files and folders that are read.
#[derive(Debug, Clone, Default)]
pub struct Inputs(BTreeMap<Identity, PathBuf>);

/// Device and inode; the path without links where the system has no such numbers.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

#[cfg(unix)]
use std::os::fd::AsFd as Stream;
#[cfg(windows)]
use std::os::windows::io::AsHandle as Stream;

#[cfg(unix)]
fn identity_of(_: &Path, found: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino()))
}
#[cfg(not(unix))]
fn identity_of(path: &Path, _: &Metadata) -> Option<Identity> {
    fs::canonicalize(path).ok()
}

/// The identity of a file or folder; `None` of a device or a pipe, and of what is not there.
fn identity(path: &Path) -> Option<Identity> {
    identity_in(path, fs::metadata(path).ok()?)
}

/// The identity of a file from which standard input comes, or to which standard output goes.
fn identity_of_stream(stream: &impl Stream) -> Option<Identity> {
    let file = File::from(stream.as_fd().try_clone_to_owned().ok()?);
    identity_in(Path::new("-"), file.metadata().ok()?)
}

fn identity_in(path: &Path, found: Metadata) -> Option<Identity> {
    let is_stored = found.is_file() || found.is_dir();
    is_stored.then(|| identity_of(path, &found)).flatten()
}

impl Inputs {
    /// The inputs at these paths.
    pub fn of<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Self {
        let mut inputs = Self::default();
        paths.into_iter().for_each(|path| inputs.add(path.as_ref()));
        inputs
    }

    /// Adds an input; of a case all files, also those that are not read.
    fn add(&mut self, path: &Path) {
        let identity = match path.to_str() {
            Some("-") => identity_of_stream(&io::stdin()),
            _ => identity(path),
        };
        let mut add = |identity, path: &Path| {
            self.0.entry(identity).or_insert_with(|| path.to_path_buf());
        };
        let shown = if path.as_os_str() == "-" {
            Path::new("<stdin>")
        } else {
            path
        };
        identity.into_iter().for_each(|own| add(own, shown));
        for file in openfoam::files_of_case(path) {
            self::identity(&file)
                .into_iter()
                .for_each(|own| add(own, &file));
        }
    }

    /// The input that the path of an output leads to.
    pub fn find(&self, path: &Path) -> Option<&Path> {
        let identity = match path.to_str() {
            Some("-") => identity_of_stream(&io::stdout()),
            _ => identity(path),
        };
        self.0.get(&identity?).map(PathBuf::as_path)
    }

    /// Refuses an output at a path that leads to an input.
    pub fn refuse(&self, output: &Path) -> Result<()> {
        (self.find(output)).map_or(Ok(()), |input| Err(replaced(output, input)))
    }
}

/// The refusal of an output that would replace an input.
pub fn replaced(output: &Path, input: &Path) -> Error {
    let output = if output.as_os_str() == "-" {
        Path::new("<stdout>")
    } else {
        output
    };
    let which = if output == input {
        "this is an input".to_owned()
    } else {
        format!("this is the input {}", input.display())
    };
    Error::input(format!(
        "{which}, which the output would replace; give the output another name or folder"
    ))
    .file(output)
}

/// From now on no file that this process writes may replace one of these inputs, or a file that it reads as one.
pub fn guard_inputs<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) {
    let mut guarded = guarded();
    let inputs = guarded.get_or_insert_default();
    paths.into_iter().for_each(|path| inputs.add(path.as_ref()));
}

/// Adds inputs that are about to be read, where inputs are guarded.
pub fn note_inputs<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) {
    if let Some(inputs) = guarded().as_mut() {
        paths.into_iter().for_each(|path| inputs.add(path.as_ref()));
    }
}

/// Refuses an output that would replace a guarded input.
pub(super) fn refuse_guarded(output: &Path) -> Result<()> {
    (guarded().as_ref()).map_or(Ok(()), |inputs| inputs.refuse(output))
}

fn guarded() -> MutexGuard<'static, Option<Inputs>> {
    GUARDED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Maximum number of open files; of further inputs only the stamps are kept.
const MOST_OPEN: usize = 64;

/// The opened inputs, by their paths; `None` where they are not kept.
static OPENED: Mutex<Option<BTreeMap<PathBuf, Opened>>> = Mutex::new(None);

struct Opened {
    file: Option<File>,
    /// `None` where two files were read.
    stamp: Option<Stamp>,
}

/// Size, time of change and identity of a file.
type Stamp = (u64, Option<SystemTime>, Option<Identity>);

fn stamp(path: &Path, found: &Metadata) -> Stamp {
    let identity = identity_of(path, found);
    (found.len(), found.modified().ok(), identity)
}

fn opened() -> MutexGuard<'static, Option<BTreeMap<PathBuf, Opened>>> {
    OPENED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The inputs that are opened while this is there are kept open.
#[must_use]
pub struct KeptInputs(());

impl KeptInputs {
    /// Begins.
    pub fn begin() -> Self {
        *opened() = Some(BTreeMap::new());
        Self(())
    }

    /// The files that are kept, their sizes and the times of their last change.
    pub fn stamps(&self) -> Vec<(PathBuf, u64, Option<SystemTime>)> {
        let opened = opened();
        let stamped = |(path, file): (&PathBuf, &Opened)| {
            let (n_bytes, modified, _) = file.stamp?;
            Some((path.clone(), n_bytes, modified))
        };
        opened.iter().flatten().filter_map(stamped).collect()
    }
}

impl Drop for KeptInputs {
    fn drop(&mut self) {
        *opened() = None;
    }
}

/// The files that were opened since [`KeptInputs::begin`], ascending.
pub fn opened_inputs() -> Vec<PathBuf> {
    let opened = opened();
    opened.iter().flat_map(BTreeMap::keys).cloned().collect()
}

/// Notes an input that is about to be read, and keeps it. One that is opened again as another file has no hash.
pub(super) fn note_opened(path: &Path, file: &File) {
    note_inputs([path]);
    let mut opened = opened();
    let (Some(files), Ok(found)) = (opened.as_mut(), file.metadata()) else {
        return;
    };
    if !found.is_file() {
        return;
    }
    let is_kept = files.len() < MOST_OPEN;
    let stamp = Some(stamp(path, &found));
    match files.get_mut(path) {
        Some(before) if before.stamp == stamp => {}
        Some(before) => before.stamp = None,
        None => {
            let file = is_kept.then(|| file.try_clone().ok()).flatten();
            files.insert(path.to_path_buf(), Opened { file, stamp });
        }
    }
}

/// The hash of the file that was read from a path: of the file that is there where none was kept.
///
/// # Errors
/// If its bytes have changed since.
pub fn hash_of_read(path: &Path) -> io::Result<blake3::Hash> {
    let kept = opened().as_ref().and_then(|files| {
        let kept = files.get(path)?;
        Some((kept.file.as_ref().map(File::try_clone), kept.stamp))
    });
    let Some((file, before)) = kept else {
        return hash_of(path);
    };
    let mut file = file.unwrap_or_else(|| File::open(path))?;
    let hash = hash_of_file(&mut file, 0..u64::MAX)?;
    if before == Some(stamp(path, &file.metadata()?)) {
        return Ok(hash);
    }
    let message = "this input was changed while it was read; start again";
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

/// Bytes that are read at once for a hash.
const PIECE: usize = 4 << 20;

/// The hash of a file, read piece by piece: a mapped file would count as memory of the run; of a folder, the hash of
/// its files.
pub fn hash_of(path: &Path) -> io::Result<blake3::Hash> {
    if !path.is_dir() {
        return hash_of_range(path, 0..u64::MAX);
    }
    let names = files_in(path)?.into_iter();
    let hashes = names.map(|name| Ok((name.clone(), hash_of(&path.join(name))?)));
    Ok(hash_of_names(&hashes.collect::<io::Result<_>>()?))
}

/// The hash of a mesh that was read from `path`, of the bytes that were read: of the file, or of what a case holds of the mesh.
pub fn hash_of_input(path: &Path, mesh: &Mesh) -> io::Result<blake3::Hash> {
    openfoam::hash_of_origin(mesh).map_or_else(|| hash_of_read(path), Ok)
}

/// The hash of some bytes of a file.
pub fn hash_of_range(path: &Path, bytes: Range<u64>) -> io::Result<blake3::Hash> {
    check_file(path)?;
    hash_of_file(&mut File::open(path)?, bytes)
}

/// The hash of some bytes of an open file.
fn hash_of_file(file: &mut File, bytes: Range<u64>) -> io::Result<blake3::Hash> {
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

/// One hash of several files, from their names and hashes, ordered by name.
pub fn hash_of_names(files: &BTreeMap<String, blake3::Hash>) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for (name, hash) in files {
        hasher.update(name.as_bytes());
        hasher.update(&[0]);
        hasher.update(hash.as_bytes());
    }
    hasher.finalize()
}

/// Paths of all files in a folder and its subfolders, relative to it, ascending.
pub fn files_in(folder: &Path) -> io::Result<Vec<String>> {
    let mut files = Vec::new();
    let mut folders = vec![String::new()];
    while let Some(before) = folders.pop() {
        for entry in fs::read_dir(folder.join(&before))? {
            let entry = entry?;
            let name = format!("{before}{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                folders.push(name + "/");
            } else {
                files.push(name);
            }
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_input_is_known_by_every_name_that_it_has() {
        let folder = tempfile::tempdir().expect("a folder");
        let [mesh, other, link, second] = ["mesh.vtu", "other.vtu", "link.vtu", "second.vtu"]
            .map(|name| folder.path().join(name));
        fs::write(&mesh, "x").expect("it can be written");
        fs::write(&other, "x").expect("it can be written");
        std::os::unix::fs::symlink(&mesh, &link).expect("links are known");
        fs::hard_link(&mesh, &second).expect("links are known");
        let inputs = Inputs::of([&mesh, Path::new("/dev/null"), &folder.path().join("none")]);
        for path in [&mesh, &link, &second] {
            assert_eq!(inputs.find(path), Some(&*mesh));
            inputs.refuse(path).expect_err("it is the input");
        }
        for path in [&*other, Path::new("/dev/null"), &folder.path().join("none")] {
            inputs.refuse(path).expect("it is no input");
        }
    }

    #[test]
    fn a_hash_is_that_of_the_bytes_that_were_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("motion.csv");
        let new = folder.path().join("new.csv");
        let read = |content: &str| {
            fs::write(&path, content).expect("it can be written");
            note_opened(&path, &File::open(&path).expect("it is there"));
        };
        let kept = KeptInputs::begin();
        read("old");
        fs::write(&new, "new").expect("it can be written");
        fs::rename(&new, &path).expect("it can be renamed");
        let hash = hash_of_read(&path).expect("the old file is open");
        assert_eq!(hash, blake3::hash(b"old"));
        // Changed in place, or read twice with a change in between.
        read("short");
        fs::write(&path, "longer").expect("it can be written");
        hash_of_read(&path).expect_err("it was changed");
        read("one");
        fs::remove_file(&path).expect("it is there");
        read("another");
        hash_of_read(&path).expect_err("two files were read");
        drop(kept);
        assert_eq!(
            hash_of_read(&path).expect("it is there"),
            blake3::hash(b"another")
        );
    }
}
