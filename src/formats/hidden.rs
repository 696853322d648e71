//! Files under hidden names until they are whole: a list of them, so that a signal leaves none behind, and
//! locks, so that what a killed program has left is known and removed.
//!
//! A file is locked until it is whole. Of those that are whole and wait for their names, of which there may be
//! more than files can be open, the last one of each folder is: a program that has one file of a folder locked
//! is at work on all that it has there.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;
use tempfile::TempPath;

/// Hidden names are `.azimesh_PROCESS-NUMBER.part`, however long the name is that a file waits for.
const START: &str = ".azimesh_";
const END: &str = ".part";

/// How a whole file takes its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Commit {
    /// Whether a file that has the name is replaced; it gives its permissions. Otherwise it stays, and taking
    /// the name is an error.
    pub replace: bool,
    /// Whether the file and its name are on the disk before work goes on, so that they outlive a power cut.
    pub sync: bool,
}

impl Commit {
    /// Synced, in place of a file that has the name.
    pub const REPLACE: Self = Self {
        replace: true,
        sync: true,
    };

    /// Synced; a file that has the name is replaced by `force` only.
    pub fn with_force(force: bool) -> Self {
        Self {
            replace: force,
            sync: true,
        }
    }
}

/// What this process has under hidden names.
struct All {
    /// Every hidden file or folder there is, and the name that it waits for if it is whole.
    waiting: BTreeMap<PathBuf, Option<(PathBuf, Commit)>>,
    /// By folder, the file that became whole there last: locked as long as it is open.
    locked: BTreeMap<PathBuf, File>,
    /// Folders in which nothing is left of killed programs.
    cleared: BTreeSet<PathBuf>,
}

static ALL: Mutex<All> = Mutex::new(All {
    waiting: BTreeMap::new(),
    locked: BTreeMap::new(),
    cleared: BTreeSet::new(),
});
/// Makes every hidden name of this process another one.
static NUMBER: AtomicU64 = AtomicU64::new(0);

fn all() -> MutexGuard<'static, All> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder under a hidden name. Dropped, it is removed, unless it has taken its name.
#[must_use]
pub(super) struct Hidden {
    path: PathBuf,
    /// Locked as long as it is open: until it is whole.
    file: Option<File>,
}

impl Hidden {
    /// A new file in the folder of `target`, under a name that nothing has.
    pub fn beside(target: &Path) -> io::Result<(File, Self)> {
        target.file_name().ok_or(ErrorKind::InvalidInput)?;
        let create = |path: &Path| {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create_new(true).open(path)
        };
        let hidden = Self::create(folder_of(target), create)?;
        let file = hidden.file.as_ref().expect("it is not whole yet");
        Ok((file.try_clone()?, hidden))
    }

    /// A new folder in that of `target`.
    pub fn folder_beside(target: &Path) -> io::Result<Self> {
        let create = |path: &Path| {
            fs::create_dir(path)?;
            File::open(path)
        };
        Self::create(folder_of(target), create)
    }

    fn create(folder: &Path, create: impl Fn(&Path) -> io::Result<File>) -> io::Result<Self> {
        clear_once(folder);
        loop {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!("{START}{}-{number}{END}", std::process::id()));
            let mut all = all();
            let file = match create(&path) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            // Another program may have taken it for one that was left, before it was locked.
            if lock(&file) == Some(false) || !is_same(&file, &path) {
                continue;
            }
            all.waiting.insert(path.clone(), None);
            let file = Some(file);
            return Ok(Self { path, file });
        }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// It is whole: a signal gives it its name.
    pub fn is_whole(&mut self, target: &Path, commit: Commit) {
        let mut all = all();
        let wanted = Some((target.to_path_buf(), commit));
        all.waiting.insert(self.path.clone(), wanted);
        if let Some(file) = self.file.take() {
            all.locked.insert(folder_of(&self.path).to_path_buf(), file);
        }
    }

    /// Gives it its name. Its folder has to be synced after that.
    pub fn take_name(self, target: &Path, commit: Commit) -> io::Result<()> {
        if commit.sync {
            sync_file(&self.path)?;
        }
        let mut all = all();
        give_name(&self.path, target, commit)?;
        all.waiting.remove(&self.path);
        Ok(())
    }
}

impl Drop for Hidden {
    fn drop(&mut self) {
        let mut all = all();
        if all.waiting.remove(&self.path).is_some() {
            remove(&self.path);
        }
    }
}

fn give_name(hidden: &Path, target: &Path, commit: Commit) -> io::Result<()> {
    if !commit.replace {
        let named = TempPath::try_from_path(hidden)?.persist_noclobber(target);
        return named.map_err(|failed| failed.error);
    }
    if let Ok(replaced) = fs::metadata(target) {
        // File systems without permissions refuse this, and nothing is lost.
        let _ = fs::set_permissions(hidden, replaced.permissions());
    }
    fs::rename(hidden, target)
}

/// The folder that a file of this name is in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn sync_file(path: &Path) -> io::Result<()> {
    let mut options = OpenOptions::new();
    // Windows syncs what may be written only.
    options
        .read(true)
        .write(cfg!(windows))
        .open(path)?
        .sync_all()
}

/// Puts the names in a folder on the disk.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // Folders are files on Unix only, and one that may not be read cannot be synced.
    match File::open(folder) {
        Ok(open) if cfg!(unix) => match open.sync_all() {
            Err(error) if error.kind() == ErrorKind::InvalidInput => Ok(()),
            synced => synced,
        },
        _ => Ok(()),
    }
}

fn remove(path: &Path) {
    // Whatever went wrong before is what is told.
    let _ = match path.is_dir() {
        true => fs::remove_dir_all(path),
        false => fs::remove_file(path),
    };
}

/// Removes what killed programs have left in a folder: the hidden files of those that have none of them locked.
pub fn clear_left(folder: &Path) {
    let mut of_processes: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if let Some(process) = entry.file_name().to_str().and_then(process_of) {
            let files = of_processes.entry(process.to_owned()).or_default();
            files.push(entry.path());
        }
    }
    for files in of_processes.values() {
        if files.iter().all(|path| is_unlocked(path)) {
            files.iter().for_each(|path| remove(path));
        }
    }
}

/// Whether a hidden file could be locked, so that no program is at work on it.
fn is_unlocked(path: &Path) -> bool {
    let file = match path.is_dir() {
        true => File::open(path),
        false => OpenOptions::new().read(true).write(true).open(path),
    };
    file.is_ok_and(|file| lock(&file) == Some(true) && is_same(&file, path))
}

fn clear_once(folder: &Path) {
    let is_new = all().cleared.insert(folder.to_path_buf());
    if is_new {
        clear_left(folder);
    }
}

/// The process that a hidden name tells.
fn process_of(name: &str) -> Option<&str> {
    let numbers = name.strip_prefix(START)?.strip_suffix(END)?;
    let (process, number) = numbers.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (is_number(process) && is_number(number)).then_some(process)
}

/// Locks a file as long as it is open; tells whether nobody else has it locked, as far as the file system
/// knows. On Windows, where others could not read a locked file, none is.
fn lock(file: &File) -> Option<bool> {
    match file.try_lock() {
        _ if !cfg!(unix) => None,
        Ok(()) => Some(true),
        Err(fs::TryLockError::WouldBlock) => Some(false),
        Err(fs::TryLockError::Error(_)) => None,
    }
}

/// Whether an open file is the one that has this name.
#[cfg(unix)]
pub fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |found: fs::Metadata| (found.dev(), found.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(file), Ok(path)) => place(file) == place(path),
        _ => false,
    }
}

/// An open file keeps its name there.
#[cfg(not(unix))]
pub fn is_same(_file: &File, _path: &Path) -> bool {
    true
}

/// Lists a hidden file that is none of this module's, to be removed where a signal ends the program.
pub fn list_hidden(path: &Path) {
    all().waiting.insert(path.to_path_buf(), None);
}

/// Takes it off the list.
pub fn unlist_hidden(path: &Path) {
    all().waiting.remove(path);
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
        match ALL.try_lock() {
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(10)),
            Ok(all) => return end_all(all),
            Err(TryLockError::Poisoned(all)) => return end_all(all.into_inner()),
        }
    }
}

fn end_all(mut all: MutexGuard<'static, All>) {
    for (hidden, wanted) in mem::take(&mut all.waiting) {
        let named = wanted.is_some_and(|(target, commit)| {
            let synced = match commit.sync {
                true => sync_file(&hidden),
                false => Ok(()),
            };
            synced
                .and_then(|()| give_name(&hidden, &target, commit))
                .and_then(|()| sync_folder(folder_of(&target)))
                .is_ok()
        });
        if !named {
            remove(&hidden);
        }
    }
    mem::forget(all);
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
        let (_, written) = Hidden::beside(&folder.path().join("mesh.vtu")).expect("it is made");
        let left = [".azimesh_1-0.part", ".azimesh_77-12.part"];
        let others = [".azimesh_0-10.lock", ".mesh.part", ".azimesh_1-x.part"];
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
    fn files_that_wait_for_their_names_stay_however_many() {
        let folder = tempfile::tempdir().expect("a folder");
        let whole: Vec<Hidden> = (0..5)
            .map(|i| {
                let target = folder.path().join(format!("mesh_{i}.vtu"));
                let (_, mut hidden) = Hidden::beside(&target).expect("it is made");
                hidden.is_whole(&target, Commit::REPLACE);
                hidden
            })
            .collect();
        assert!(whole.iter().all(|hidden| hidden.file.is_none()));
        clear_left(folder.path());
        assert_eq!(names(folder.path()).len(), 5);
        for (i, hidden) in whole.into_iter().enumerate() {
            let target = folder.path().join(format!("mesh_{i}.vtu"));
            hidden
                .take_name(&target, Commit::REPLACE)
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
        let staged = || Hidden::beside(&target).expect("it is made").1;
        let refused = staged().take_name(&target, Commit::with_force(false));
        assert_eq!(
            refused.expect_err("it is taken").kind(),
            ErrorKind::AlreadyExists
        );
        assert_eq!(fs::read(&target).expect("it is there"), b"old");
        staged()
            .take_name(&target, Commit::REPLACE)
            .expect("it is replaced");
        assert_eq!(fs::read(&target).expect("it is there"), b"");
        assert_eq!(names(folder.path()), ["mesh.vtu"]);
    }
}
