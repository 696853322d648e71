//! Files under hidden names, until they are whole: a list of them, so that a signal leaves none behind.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;

/// Every hidden file or folder there is, and the name that it waits for if it is whole.
static HIDDEN: Mutex<BTreeMap<PathBuf, Option<PathBuf>>> = Mutex::new(BTreeMap::new());

fn all() -> MutexGuard<'static, BTreeMap<PathBuf, Option<PathBuf>>> {
    HIDDEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder under a hidden name. Dropped, it is removed.
#[must_use]
pub(super) struct Hidden(PathBuf);

impl Hidden {
    /// A new file in the folder of `target`, under a name that nothing has.
    pub fn beside(target: &Path) -> io::Result<(File, Self)> {
        let name = target.file_name().ok_or(ErrorKind::InvalidInput)?;
        let mut attempt = 0_u32;
        loop {
            let mut hidden = OsString::from(".");
            hidden.push(name);
            hidden.push(format!(".{}-{attempt}.part", std::process::id()));
            let path = target.with_file_name(hidden);
            let mut all = all();
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    all.insert(path.clone(), None);
                    return Ok((file, Self(path)));
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists && attempt < 1000 => {
                    attempt += 1;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// A new folder of this name.
    pub fn folder(path: PathBuf) -> io::Result<Self> {
        let mut all = all();
        fs::create_dir(&path)?;
        all.insert(path.clone(), None);
        Ok(Self(path))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// It is whole: a signal gives it its name.
    pub fn is_whole(&self, target: &Path) {
        all().insert(self.0.clone(), Some(target.to_path_buf()));
    }

    /// Gives it its name.
    pub fn take_name(self, target: &Path) -> io::Result<()> {
        let mut all = all();
        fs::rename(&self.0, target)?;
        all.remove(&self.0);
        drop(all);
        mem::forget(self);
        Ok(())
    }
}

impl Drop for Hidden {
    fn drop(&mut self) {
        let mut all = all();
        remove(&self.0);
        all.remove(&self.0);
    }
}

fn remove(path: &Path) {
    // Whatever went wrong before is what is told.
    let _ = match path.is_dir() {
        true => fs::remove_dir_all(path),
        false => fs::remove_file(path),
    };
}

/// Lists a hidden file that is none of this module's, to be removed where a signal ends the program.
pub fn list_hidden(path: &Path) {
    all().insert(path.to_path_buf(), None);
}

/// Takes it off the list.
pub fn unlist_hidden(path: &Path) {
    all().remove(path);
}

/// For a program that a signal ends: hidden files that are whole get their names, the others are removed.
/// No file is made or gets its name after that; who tries waits for the end.
pub fn end_hidden() {
    end_all(all());
}

/// The same for a program that has no memory left: the list is waited for a second at the most, since the
/// thread that has it may be waiting for memory.
pub fn end_hidden_soon() {
    for _ in 0..100 {
        match HIDDEN.try_lock() {
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(10)),
            Ok(all) => return end_all(all),
            Err(TryLockError::Poisoned(all)) => return end_all(all.into_inner()),
        }
    }
}

fn end_all(mut all: MutexGuard<'static, BTreeMap<PathBuf, Option<PathBuf>>>) {
    for (hidden, target) in mem::take(&mut *all) {
        let named = target.is_some_and(|target| fs::rename(&hidden, target).is_ok());
        if !named {
            remove(&hidden);
        }
    }
    mem::forget(all);
}
