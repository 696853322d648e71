//! Staged files: files and folders under temporary names until they are complete. Owns the list of them, so that
//! a signal leaves none behind, and their locks, so that what a killed program has left is found and removed.
//!
//! A file is locked until it is complete. Complete files that wait for their names may be more than can be open,
//! so that only the last one of each folder stays locked: a program that holds a lock in a folder is still
//! using all its temporary files there.

use super::moves::{LIST, complete_left, rename_to};
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, SystemTime};

/// Temporary names are `.azimesh_HOST_PROCESS-NUMBER.part`, however long the final name is. Locks of a network file system may
/// be local to a host, so that another host does not see whether a file is in use; without a name of the host, `HOST_` is left out.
const START: &str = ".azimesh_";
const END: &str = ".part";

/// Options for giving a complete file its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Commit {
    /// True if an existing file of that name is replaced (its permissions are kept). Otherwise it stays, and
    /// committing is an error.
    pub replace: bool,
    /// True if the file and its name are synced to the disk, so that they survive a power cut.
    pub sync: bool,
}

impl Commit {
    /// Synced; an existing file is replaced.
    pub const REPLACE: Self = Self {
        replace: true,
        sync: true,
    };

    /// Synced; an existing file is replaced only with `force`.
    pub fn with_force(force: bool) -> Self {
        Self {
            replace: force,
            sync: true,
        }
    }
}

/// The temporary files of this process.
pub(super) struct Registry {
    /// Every temporary file or folder.
    entries: BTreeSet<PathBuf>,
    /// By folder, the file that was completed there last: locked while it is open.
    locked: BTreeMap<PathBuf, File>,
    /// Folders that were cleared of the files of killed programs.
    cleared: BTreeSet<PathBuf>,
    /// Folders whose lists of moves were looked for, and when they were changed last.
    completed: BTreeMap<PathBuf, Option<SystemTime>>,
}

static REGISTRY: Mutex<Registry> = Mutex::new(Registry {
    entries: BTreeSet::new(),
    locked: BTreeMap::new(),
    cleared: BTreeSet::new(),
    completed: BTreeMap::new(),
});
/// The number of the next temporary name.
static NUMBER: AtomicU64 = AtomicU64::new(0);

pub(super) fn registry() -> MutexGuard<'static, Registry> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder under a temporary name. It is removed when dropped, unless it was committed.
#[must_use]
pub(super) struct Temporary {
    path: PathBuf,
    /// The open file, which holds the lock; `None` once it is complete.
    file: Option<File>,
}

impl Temporary {
    /// A new file in the folder of `target`.
    pub fn file_for(target: &Path) -> io::Result<(File, Self)> {
        target.file_name().ok_or(ErrorKind::InvalidInput)?;
        let create = |path: &Path| {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create_new(true).open(path)
        };
        let temporary = Self::create(folder_of(target), create)?;
        let file = temporary.file.as_ref();
        let file = file.expect("it is not complete yet").try_clone()?;
        Ok((file, temporary))
    }

    /// A new folder in the folder of `target`.
    pub fn folder_for(target: &Path) -> io::Result<Self> {
        let create = |path: &Path| {
            fs::create_dir(path)?;
            let opened = File::open(path);
            if opened.is_err() {
                let _ = fs::remove_dir(path);
            }
            opened
        };
        Self::create(folder_of(target), create)
    }

    fn create(folder: &Path, create: impl Fn(&Path) -> io::Result<File>) -> io::Result<Self> {
        clear_once(folder);
        loop {
            let path = next_path(folder);
            let mut registry = registry();
            let file = match create(&path) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            // Before it was locked, another program may have removed it as left over.
            if lock(&file) == Some(false) || !is_same(&file, &path) {
                continue;
            }
            registry.entries.insert(path.clone());
            let file = Some(file);
            return Ok(Self { path, file });
        }
    }

    /// A name in the folder of `target`, without a file. What gets it is removed when this is dropped.
    pub fn name_for(target: &Path) -> Self {
        let path = next_path(folder_of(target));
        registry().entries.insert(path.clone());
        Self { path, file: None }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Closes a complete file.
    pub fn close(&mut self) {
        if let Some(file) = self.file.take() {
            let folder = folder_of(&self.path).to_path_buf();
            registry().locked.insert(folder, file);
        }
    }

    /// Renames it to `target`. The folder has to be synced after that.
    pub fn commit(self, target: &Path, commit: Commit) -> io::Result<()> {
        if commit.sync {
            sync_file(&self.path)?;
        }
        let mut registry = registry();
        rename_to(&self.path, target, commit.replace)?;
        registry.entries.remove(&self.path);
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // A folder is opened to be removed, and a program may have as many files open as it can.
        self.file = None;
        let mut registry = registry();
        // Files in a staged folder are no longer looked for there: open ones would keep their space on the disk.
        registry
            .locked
            .retain(|folder, _| !folder.starts_with(&self.path));
        if registry.entries.remove(&self.path) {
            remove(&self.path);
        }
    }
}

/// The next temporary name in a folder.
fn next_path(folder: &Path) -> PathBuf {
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let host = host().map_or(String::new(), |host| format!("{host}_"));
    folder.join(format!("{START}{host}{}-{number}{END}", std::process::id()))
}

/// The folder that contains a path.
pub fn folder_of(path: &Path) -> &Path {
    let folder = path.parent();
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// Syncs the bytes of a file to the disk.
pub(super) fn sync_file(path: &Path) -> io::Result<()> {
    // Windows syncs only files that are open for writing.
    let mut options = OpenOptions::new();
    let opened = options.read(true).write(cfg!(windows)).open(path);
    opened?.sync_all()
}

/// Syncs the names in a folder to the disk.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // Folders can be opened on Unix only, and one without read permission cannot be synced.
    match File::open(folder) {
        Ok(open) if cfg!(unix) => match open.sync_all() {
            Err(error) if error.kind() == ErrorKind::InvalidInput => Ok(()),
            synced => synced,
        },
        _ => Ok(()),
    }
}

pub(super) fn remove(path: &Path) {
    // The error that led here is the one to report.
    let _ = if path.is_dir() {
        fs::remove_dir_all(path).or_else(|_| remove_one_by_one(path))
    } else {
        fs::remove_file(path)
    };
}

/// Removes a folder; one folder is open at a time, where the standard library has all on the way open.
fn remove_one_by_one(folder: &Path) -> io::Result<()> {
    let entries = fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    for entry in entries {
        if entry.file_type()?.is_dir() {
            remove_one_by_one(&entry.path())?;
        } else {
            fs::remove_file(entry.path())?;
        }
    }
    fs::remove_dir(folder)
}

/// Removes the temporary files that killed programs of this host have left in a folder: the files of processes that hold no
/// lock there. What a killed program was renaming is completed before that, and stays where it cannot be.
pub fn clear_left(folder: &Path) {
    if complete_left(folder).is_err() {
        return;
    }
    let mut of_processes: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if let Some(process) = entry
            .file_name()
            .to_str()
            .and_then(|name| process_of(name, END))
        {
            let files = of_processes.entry(process.to_owned()).or_default();
            files.push(entry.path());
        }
    }
    of_processes.retain(|_, files| files.iter().all(|path| is_unlocked(path)));
    let files = of_processes.values().flatten();
    files.for_each(|path| remove(path));
}

/// Checks if a temporary file could be locked, so that no program is using it.
fn is_unlocked(path: &Path) -> bool {
    let file = if path.is_dir() {
        File::open(path)
    } else {
        OpenOptions::new().read(true).write(true).open(path)
    };
    file.is_ok_and(|file| lock(&file) == Some(true) && is_same(&file, path))
}

fn clear_once(folder: &Path) {
    let is_new = registry().cleared.insert(folder.to_path_buf());
    if is_new {
        clear_left(folder);
    }
}

/// The name of this host; `None` where the system does not show it as a file.
fn host() -> Option<String> {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").ok()?;
    Some(name.trim().to_owned()).filter(|name| !name.is_empty())
}

/// The lists of moves in a folder that programs of this host have left, each locked while it is open.
pub(super) fn lists_of_killed(folder: &Path) -> Vec<(PathBuf, File)> {
    let ending = format!(".{LIST}");
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let lists = entries.filter_map(|entry| {
        process_of(entry.file_name().to_str()?, &ending)?;
        let file = File::open(entry.path()).ok()?;
        let is_left = lock(&file) == Some(true) && is_same(&file, &entry.path());
        is_left.then_some((entry.path(), file))
    });
    lists.collect()
}

/// Completes what killed programs were renaming in the folders of a file that is about to be read, or of a folder with a case.
///
/// # Errors
/// Of [`complete_left`].
pub(super) fn complete_above(path: &Path) -> Result<()> {
    let is_folder = path.is_dir();
    let path = std::path::absolute(path).unwrap_or_default();
    // CASE/TIME/REGION/polyMesh; the folder of the pieces is next to their list.
    let (first, n) = if is_folder { (0, 4) } else { (1, 2) };
    for folder in path.ancestors().skip(first).take(n) {
        let changed = fs::metadata(folder).and_then(|found| found.modified()).ok();
        let before = registry().completed.insert(folder.to_path_buf(), changed);
        if before != Some(changed) {
            complete_left(folder)?;
        }
    }
    Ok(())
}

/// The process id in a temporary name of this host.
fn process_of<'a>(name: &'a str, ending: &str) -> Option<&'a str> {
    let numbers = name.strip_prefix(START)?.strip_suffix(ending)?;
    let numbers = match numbers.rsplit_once('_') {
        Some((own, _)) if host().as_deref() != Some(own) => return None,
        Some((_, numbers)) => numbers,
        None => numbers,
    };
    let (process, number) = numbers.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (is_number(process) && is_number(number)).then_some(process)
}

/// Locks a file while it is open. `Some(false)`: another process holds the lock; `None`: the file system
/// has no locks. Nothing is locked on Windows, where others could not read a locked file.
pub(super) fn lock(file: &File) -> Option<bool> {
    match file.try_lock() {
        _ if !cfg!(unix) => None,
        Ok(()) => Some(true),
        Err(fs::TryLockError::WouldBlock) => Some(false),
        Err(fs::TryLockError::Error(_)) => None,
    }
}

/// Checks if an open file is the one at this path.
#[cfg(unix)]
pub fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |found: fs::Metadata| (found.dev(), found.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(file), Ok(path)) => place(file) == place(path),
        _ => false,
    }
}

/// Checks if an open file is the one at this path: always, where an open file cannot be renamed.
#[cfg(not(unix))]
pub fn is_same(_file: &File, _path: &Path) -> bool {
    true
}

/// Registers a file that was not made by this module, to be removed when a signal ends the program.
pub fn register_temporary(path: &Path) {
    registry().entries.insert(path.to_path_buf());
}

/// Removes a file of [`register_temporary`] from the list.
pub fn unregister_temporary(path: &Path) {
    registry().entries.remove(path);
}

/// For a program that a signal ends: removes the temporary files, once those that are being renamed have their names. After
/// that, a thread that creates or renames a file blocks until the process ends.
pub fn end_staged() {
    end_all(registry());
}

/// [`end_staged`] for a program that has run out of memory: waits at most a second for the list of files, since
/// the thread that holds its lock may be waiting for memory.
pub fn end_staged_soon() {
    for _ in 0..100 {
        match REGISTRY.try_lock() {
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(10)),
            Ok(registry) => return end_all(registry),
            Err(TryLockError::Poisoned(registry)) => return end_all(registry.into_inner()),
        }
    }
}

fn end_all(mut registry: MutexGuard<'static, Registry>) {
    for temporary in mem::take(&mut registry.entries) {
        remove(&temporary);
    }
    mem::forget(registry);
}

/// A hidden file that takes space on the disk until this is dropped. One that a killed program has left is removed like other staged
/// files.
pub struct Reserve(#[expect(dead_code)] Option<Temporary>);

impl Reserve {
    /// A number of bytes in the folder of a file; none where they are not available.
    pub fn beside(path: &Path, n_bytes: usize) -> Self {
        let filled = Temporary::file_for(path).and_then(|(mut file, temporary)| {
            file.write_all(&vec![0; n_bytes])?;
            Ok(temporary)
        });
        Self(filled.ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("the folder is there").flatten();
        entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn what_a_killed_program_left_goes_and_what_another_is_writing_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let (_, written) =
            Temporary::file_for(&folder.path().join("mesh.vtu")).expect("it is made");
        let left = [".azimesh_1-0.part", ".azimesh_77-12.part"];
        let others = [
            ".azimesh_0-10.lock",
            ".mesh.part",
            ".azimesh_1-x.part",
            ".azimesh_another-host_1-0.part",
        ];
        for name in left.iter().chain(&others) {
            fs::write(folder.path().join(name), "x").expect("it is written");
        }
        fs::create_dir(folder.path().join(".azimesh_5-5.part")).expect("it is made");
        clear_left(folder.path());
        assert!(written.path().exists());
        let mut expected = others.map(str::to_owned).to_vec();
        expected.extend(
            written
                .path()
                .file_name()
                .map(|name| name.to_string_lossy().into()),
        );
        let mut found = names(folder.path());
        expected.sort();
        found.sort();
        assert_eq!(found, expected);
        drop(written);
        assert_eq!(names(folder.path()).len(), others.len());
    }

    #[test]
    fn a_staged_folder_leaves_no_file_open() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("case");
        let staged = Temporary::folder_for(&target).expect("it is made");
        let inside = staged.path().join("mesh.vtu");
        let mut file = Temporary::file_for(&inside).expect("it is made").1;
        file.close();
        file.commit(&inside, Commit::REPLACE).expect("it is named");
        let is_locked = |path: &Path| registry().locked.contains_key(path);
        let path = staged.path().to_path_buf();
        assert!(is_locked(&path));
        drop(staged);
        assert!(!is_locked(&path) && !path.exists());
    }

    #[test]
    fn files_that_wait_for_their_names_stay_however_many() {
        let folder = tempfile::tempdir().expect("a folder");
        let whole: Vec<Temporary> = (0..5)
            .map(|i| {
                let target = folder.path().join(format!("mesh_{i}.vtu"));
                let (_, mut temporary) = Temporary::file_for(&target).expect("it is made");
                temporary.close();
                temporary
            })
            .collect();
        assert!(whole.iter().all(|temporary| temporary.file.is_none()));
        clear_left(folder.path());
        assert_eq!(names(folder.path()).len(), 5);
        for (i, temporary) in whole.into_iter().enumerate() {
            let target = folder.path().join(format!("mesh_{i}.vtu"));
            temporary
                .commit(&target, Commit::REPLACE)
                .expect("it is named");
            clear_left(folder.path());
        }
        assert!(
            names(folder.path())
                .iter()
                .all(|name| name.starts_with("mesh_"))
        );
        assert_eq!(names(folder.path()).len(), 5);
    }

    #[test]
    fn a_name_that_is_taken_stays_unless_it_is_to_be_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("mesh.vtu");
        fs::write(&target, "old").expect("it is written");
        let staged = || Temporary::file_for(&target).expect("it is made").1;
        let refused = staged().commit(&target, Commit::with_force(false));
        assert_eq!(
            refused.expect_err("it is taken").kind(),
            ErrorKind::AlreadyExists
        );
        assert_eq!(fs::read(&target).expect("it is there"), b"old");
        staged()
            .commit(&target, Commit::REPLACE)
            .expect("it is replaced");
        assert_eq!(fs::read(&target).expect("it is there"), b"");
        assert_eq!(names(folder.path()), ["mesh.vtu"]);
    }

    #[test]
    fn it_takes_room_until_it_is_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        let sizes = || -> Vec<u64> {
            let entries = fs::read_dir(folder.path()).expect("a folder").flatten();
            let sizes = entries.map(|entry| entry.metadata().expect("it is there").len());
            sizes.collect()
        };
        let reserve = Reserve::beside(&folder.path().join("run.json"), 10_000);
        assert_eq!(sizes(), [10_000]);
        drop(reserve);
        assert!(sizes().is_empty());
    }
}
