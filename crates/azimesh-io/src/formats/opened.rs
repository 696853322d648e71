//! Input files of a run, kept open from when they are read until they are hashed: a hash is then that of the bytes that were read,
//! also where another file has taken the name meanwhile.

use super::hash::{hash_of, hash_of_file};
use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// Open files, at the most; of further ones the stamps are kept alone.
const MOST_OPEN: usize = 64;

/// The files, by the paths they were opened at; `None` where they are not kept.
static OPENED: Mutex<Option<BTreeMap<PathBuf, Opened>>> = Mutex::new(None);

struct Opened {
    file: Option<File>,
    stamp: Stamp,
}

/// Size and time of change, and which file it is.
#[derive(Clone, Copy, PartialEq)]
struct Stamp {
    n_bytes: u64,
    modified: Option<SystemTime>,
    inode: u64,
}

impl Stamp {
    fn of(found: &Metadata) -> Self {
        Self {
            n_bytes: found.len(),
            modified: found.modified().ok(),
            #[cfg(unix)]
            inode: std::os::unix::fs::MetadataExt::ino(found),
            #[cfg(not(unix))]
            inode: 0,
        }
    }
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
        let files = opened.iter().flatten();
        let stamp = |(path, file): (&PathBuf, &Opened)| {
            (path.clone(), file.stamp.n_bytes, file.stamp.modified)
        };
        files.map(stamp).collect()
    }
}

impl Drop for KeptInputs {
    fn drop(&mut self) {
        *opened() = None;
    }
}

/// Keeps a file that is about to be read. One that is opened again as another file has no hash.
pub(super) fn note_opened(path: &Path, file: &File) {
    let mut opened = opened();
    let Some(files) = opened.as_mut() else {
        return;
    };
    let (Ok(found), n_open) = (file.metadata(), files.len()) else {
        return;
    };
    if !found.is_file() {
        return;
    }
    let stamp = Stamp::of(&found);
    match files.get_mut(path) {
        Some(before) if before.stamp == stamp => {}
        Some(before) => before.stamp.modified = None,
        None => {
            let file = (n_open < MOST_OPEN)
                .then(|| file.try_clone().ok())
                .flatten();
            files.insert(path.to_path_buf(), Opened { file, stamp });
        }
    }
}

/// The hash of the file that was read from a path: of the file that is there where none was kept.
///
/// # Errors
/// Where its bytes have changed since.
pub fn hash_of_read(path: &Path) -> io::Result<blake3::Hash> {
    let kept = |opened: &Opened| (opened.file.as_ref().map(File::try_clone), opened.stamp);
    let kept = opened()
        .as_ref()
        .and_then(|files| files.get(path).map(kept));
    let Some((file, stamp)) = kept else {
        return hash_of(path);
    };
    let mut file = file.unwrap_or_else(|| File::open(path))?;
    let hash = hash_of_file(&mut file, 0..u64::MAX)?;
    match Stamp::of(&file.metadata()?) == stamp {
        true => Ok(hash),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "this input was changed while it was read; start again",
        )),
    }
}

fn opened() -> MutexGuard<'static, Option<BTreeMap<PathBuf, Opened>>> {
    OPENED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
