//! Prevents two runs from writing the same steps of a folder: each run has a hidden file that is locked by the system, which
//! releases it when the process ends in any way.

use super::names::Names;
use crate::record::{file_name, parts_in};
use azimesh_core::error::{Error, Result};
use azimesh_core::{Note, note};
use azimesh_io::formats::{
    folder_of, is_same, register_temporary, sync_folder, unregister_temporary,
};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

const STEM: &str = ".azimesh";
const EXTENSION: &str = "lock";

/// The steps of a folder, held by this process until it is dropped.
pub(super) struct Lock {
    /// Locked while it is open.
    file: File,
    path: PathBuf,
    /// The folders that were made for this run, innermost first.
    made: Vec<PathBuf>,
    /// Notes for the user.
    pub warning: Option<Note>,
}

impl Lock {
    /// Locks the steps of a run; creates its folder if there is none.
    pub fn take(names: &Names) -> Result<Self> {
        let folder = &names.folder;
        if folder.is_file() {
            return Err(Error::input("this is a file, not a folder").file(folder));
        }
        let is_new = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made = folder.ancestors().take_while(is_new);
        let made: Vec<PathBuf> = made.map(Path::to_path_buf).collect();
        let make = || {
            fs::create_dir_all(folder)?;
            let mut made = made.iter();
            made.try_for_each(|path| sync_folder(folder_of(path)))
        };
        make().map_err(|error| Error::io(folder, &error))?;
        // In a folder that cannot be listed, files of an earlier run and other runs would not be found.
        fs::read_dir(folder).map_err(|error| {
            let mut error = Error::io(folder, &error);
            error.message += "; the output folder must be readable, for a run looks there for files of earlier ones";
            error
        })?;
        let steps = names.steps();
        let path = folder.join(file_name(STEM, Some(&steps), EXTENSION));
        let (file, warning) = own(&path, folder, &steps)?;
        register_temporary(&path);
        let lock = Self {
            file,
            path,
            made,
            warning,
        };
        for (other, path) in others(folder) {
            let overlaps = other.start < steps.end && steps.start < other.end;
            if path != lock.path && overlaps && is_locked(&path)? {
                return Err(busy(folder, &other));
            }
        }
        Ok(lock)
    }

    /// Checks if the folder is still the one that was locked.
    pub fn holds(&self) -> bool {
        is_same(&self.file, &self.path)
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // An unlocked file left behind blocks nobody, and a folder with files in it is kept.
        if self.holds() {
            let _ = fs::remove_file(&self.path);
        }
        unregister_temporary(&self.path);
        for folder in &self.made {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Removes the lock files of killed runs.
pub(super) fn remove_left(folder: &Path) -> Result<()> {
    for (_, path) in others(folder) {
        if !is_locked(&path)? {
            fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
        }
    }
    Ok(())
}

fn busy(folder: &Path, steps: &Range<usize>) -> Error {
    Error::input(format!(
        "another run is writing steps {}..{} here; wait until it ends",
        steps.start, steps.end
    ))
    .file(folder)
}

/// Opens and locks the file of this run; returns a note if the file system has no locks.
fn own(path: &Path, folder: &Path, steps: &Range<usize>) -> Result<(File, Option<Note>)> {
    loop {
        let file = open(path, true)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(busy(folder, steps)),
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                let note = note!(
                    "no_locks",
                    "this file system has no locks: nothing prevents another run from writing the same steps"
                )
                .file(folder);
                return Ok((file, Some(note)));
            }
            Err(TryLockError::Error(error)) => return Err(refused(path, &error)),
        }
        // A run that ended between the two has removed the file that is now locked.
        if is_same(&file, path) {
            return Ok((file, None));
        }
    }
}

/// Opens a lock file, which must be a regular file: another program may have put a link or a pipe in its place.
fn open(path: &Path, create: bool) -> Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(create);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    let is_file = |found: fs::Metadata| found.is_file();
    match options.open(path) {
        Ok(file) if file.metadata().is_ok_and(is_file) => Ok(file),
        Err(error) if fs::symlink_metadata(path).map_or(true, is_file) => {
            Err(Error::io(path, &error))
        }
        _ => Err(Error::input(
            "this is a link, a folder, a pipe or a device, not the lock file of a run; remove it",
        )
        .file(path)),
    }
}

/// Returns the lock files of a folder and their steps, in order.
fn others(folder: &Path) -> Vec<(Range<usize>, PathBuf)> {
    parts_in(folder, STEM, EXTENSION).unwrap_or_default()
}

/// Checks if a run holds this file; false if the file is missing.
fn is_locked(path: &Path) -> Result<bool> {
    let Ok(file) = open(path, false) else {
        return Ok(false);
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(false),
        Err(TryLockError::WouldBlock) => Ok(true),
        Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => Ok(false),
        Err(TryLockError::Error(error)) => Err(refused(path, &error)),
    }
}

fn refused(path: &Path, error: &std::io::Error) -> Error {
    Error::system(format!("cannot be locked: {error}")).file(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path, steps: Option<Range<usize>>) -> Names {
        let format = azimesh_io::formats::by_name("vtu").expect("it is known");
        let names = Names::new(folder, Path::new("wing.su2"), format, 10);
        match steps {
            Some(steps) => names.part(steps).expect("there are ten steps"),
            None => names,
        }
    }

    #[test]
    fn steps_are_held_by_one_run_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let take = |steps| Lock::take(&names(folder.path(), steps));
        let first = take(Some(0..4)).expect("nobody holds them");
        let second = take(Some(4..6)).expect("nobody holds them");
        for (steps, by) in [
            (Some(0..4), "0..4"),
            (Some(3..5), "0..4"),
            (Some(5..6), "4..6"),
            (None, "0..4"),
        ] {
            let message = take(steps.clone())
                .err()
                .expect("they are held")
                .to_string();
            assert!(
                message.contains(&format!("steps {by} here")),
                "{steps:?}: {message}"
            );
        }
        drop(first);
        take(Some(0..4)).expect("they are free again");
        drop(second);
        take(None).expect("all are free again");
        let left = fs::read_dir(folder.path()).expect("it is there").count();
        assert_eq!(left, 0);
    }

    #[test]
    fn a_file_that_a_killed_run_left_stops_nobody() {
        let folder = tempfile::tempdir().expect("a folder");
        let left = folder.path().join(".azimesh_0-10.lock");
        fs::write(&left, "").expect("it can be written");
        let lock = Lock::take(&names(folder.path(), Some(2..3))).expect("nobody holds them");
        drop(lock);
        assert!(left.exists());
        remove_left(folder.path()).expect("it can be removed");
        assert!(!left.exists());
    }

    #[test]
    fn a_folder_made_for_nothing_goes_away() {
        let folder = tempfile::tempdir().expect("a folder");
        let inner = folder.path().join("out");
        drop(Lock::take(&names(&inner, None)).expect("it can be made"));
        assert!(!inner.exists());
    }
}
