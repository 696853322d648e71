//! A staged folder: files that are moved to their folder when all are complete. The folder may exist and hold other
//! files; what is new in it moves in one piece.

use super::inputs::refuse_guarded;
use super::output_set::files_in;
use super::save::{Staged, exists};
use super::staged::{Commit, Temporary, folder_of, sync_file, sync_folder};
use azimesh_core::error::{Error, Result};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A folder that a mesh shares with files that are not of the mesh.
pub struct SharedFolder {
    /// The folder.
    pub folder: PathBuf,
    /// The folders inside it that are the mesh's own.
    pub own: Vec<String>,
    /// An empty file that viewers open.
    pub mark: String,
}

/// Lets `write` fill a staged folder, whose path it is given; the result commits it to `path` or, where it is `shared`
/// with other files, to a folder in which it replaces some folders as a whole.
pub(super) fn stage_folder<T>(
    path: &Path,
    shared: Option<SharedFolder>,
    commit: Commit,
    write: impl FnOnce(&Path) -> Result<T>,
) -> Result<(T, Staged)> {
    let mut folder = match &shared {
        Some(shared) => Folder::into(&shared.folder, &shared.own, commit)?,
        None => Folder::new(path, commit)?,
    };
    let written = write(folder.temporary.path()).map_err(|mut error| {
        // The user knows `path`, not the temporary folder.
        error.path = error
            .path
            .filter(|path| !path.starts_with(folder.temporary.path()));
        error.file(path)
    })?;
    if let Some(shared) = shared.filter(|shared| !shared.folder.join(&shared.mark).exists()) {
        let mark = folder.temporary.path().join(shared.mark);
        fs::write(&mark, "").map_err(|error| Error::io(path, &error))?;
    }
    let names = files_in(folder.temporary.path());
    folder.names = names.map_err(|error| Error::io(path, &error))?;
    Ok((written, folder.staged(commit, || Ok(()))))
}

/// Files in a staged folder that are moved to their folder, which may exist.
pub(super) struct Folder {
    pub temporary: Temporary,
    target: PathBuf,
    /// Names of the files, which may contain folders.
    pub names: Vec<String>,
    /// Folders in `target` that are replaced as a whole.
    owned: Vec<String>,
    /// Whether they are; otherwise those that are there by then are kept.
    replace: bool,
}

impl Folder {
    /// An empty staged folder for `target`. Refuses an existing target unless it is to be replaced.
    pub fn new(target: &Path, commit: Commit) -> Result<Self> {
        if !commit.replace && target.exists() {
            return Err(exists(target));
        }
        refuse_inputs_in(target)?;
        let temporary = Temporary::folder_for(target).map_err(|error| Error::io(target, &error))?;
        Ok(Self {
            temporary,
            target: target.to_path_buf(),
            names: Vec::new(),
            owned: Vec::new(),
            replace: true,
        })
    }

    /// An empty staged folder for files in `target`, inside it where it exists. Refuses an existing folder of those
    /// that are to be replaced as a whole, unless they may be.
    pub fn into<N: AsRef<str>>(target: &Path, owned: &[N], commit: Commit) -> Result<Self> {
        let taken = owned
            .iter()
            .map(|name| target.join(name.as_ref()))
            .find(|path| path.exists());
        if let (Some(taken), false) = (taken, commit.replace) {
            return Err(exists(&taken));
        }
        if target.is_file() {
            return Err(Error::input("this is a file, not a folder").file(target));
        }
        let mut owned_there = owned.iter().map(|name| target.join(name.as_ref()));
        owned_there.try_for_each(|folder| refuse_inputs_in(&folder))?;
        let inside = target.is_dir().then(|| target.join("files"));
        let beside = inside.as_deref().unwrap_or(target);
        let temporary = Temporary::folder_for(beside).map_err(|error| Error::io(target, &error))?;
        Ok(Self {
            temporary,
            target: target.to_path_buf(),
            names: Vec::new(),
            owned: owned.iter().map(|name| name.as_ref().to_owned()).collect(),
            replace: commit.replace,
        })
    }

    /// The staged files; committing them moves them, then calls `last`. After an error the files that were there
    /// before are restored. A system that stops between two renames leaves a mixture of old and new files: no
    /// file system renames several files at once.
    pub fn staged(
        self,
        commit: Commit,
        last: impl FnOnce() -> Result<()> + Send + 'static,
    ) -> Staged {
        Staged::new(move || {
            if commit.sync {
                self.sync_files()?;
            }
            self.put_in_place(|| {
                if commit.sync {
                    self.sync_names()?;
                }
                last()
            })?;
            Ok(commit.sync.then(|| folder_of(&self.target).to_path_buf()))
        })
    }

    /// Syncs what is in the files.
    fn sync_files(&self) -> Result<()> {
        let staged = |name: &&String| self.temporary.path().join(name);
        let mut files = self.names.iter().filter(|name| !staged(name).is_symlink());
        files.try_for_each(|name| {
            let synced = sync_file(&staged(&name));
            synced.map_err(|error| Error::io(&self.target.join(name), &error))
        })
    }

    /// Syncs the names of all files and folders.
    fn sync_names(&self) -> Result<()> {
        let of_name = |name: &String| {
            Path::new(name)
                .ancestors()
                .skip(1)
                .map(Path::to_path_buf)
                .collect::<Vec<_>>()
        };
        let folders: BTreeSet<PathBuf> = self.names.iter().flat_map(of_name).collect();
        for folder in folders {
            let folder = self.target.join(folder);
            sync_folder(&folder).map_err(|error| Error::io(&folder, &error))?;
        }
        Ok(())
    }

    /// Moves the files to their folder, then calls `last`. What lies in a folder that is new moves in one piece.
    fn put_in_place(&self, last: impl FnOnce() -> Result<()>) -> Result<()> {
        let mut moved = Moves::default();
        let done = self.move_all(&mut moved).and_then(|()| last());
        if done.is_err() {
            // A file that cannot be restored matters less than the error that is reported.
            moved.undo();
        }
        done
    }

    fn move_all(&self, moved: &mut Moves) -> Result<()> {
        let old = self.temporary.path().join("old");
        let there: Vec<&String> = self
            .owned
            .iter()
            .filter(|name| self.target.join(name).exists())
            .collect();
        for name in there.iter().filter(|_| self.replace) {
            moved.rename(&self.target.join(name), &old.join(name))?;
        }
        let is_kept = |name: &&String| {
            !self.replace && there.iter().any(|own| Path::new(name).starts_with(own))
        };
        for name in self.names.iter().filter(|name| !is_kept(name)) {
            let Some(piece) = self.new_piece(name) else {
                continue;
            };
            let (from, target) = (self.temporary.path().join(&piece), self.target.join(&piece));
            if target.exists() {
                moved.rename(&target, &old.join(&piece))?;
            }
            moved.rename(&from, &target)?;
        }
        Ok(())
    }

    /// The largest part of a name that is to be moved in one piece: the first folder on the way that is not there yet,
    /// or else the file. `None` where it has been moved with another one.
    fn new_piece(&self, name: &str) -> Option<PathBuf> {
        let path = Path::new(name);
        // A link may lead to what has been moved.
        if fs::symlink_metadata(self.temporary.path().join(path)).is_err() {
            return None;
        }
        let folders: Vec<&Path> = path.ancestors().skip(1).collect();
        let is_new =
            |piece: &&&Path| !self.target.join(piece).exists() && !piece.as_os_str().is_empty();
        let first = folders.iter().rev().find(is_new);
        Some(first.map_or(path, |piece| piece).to_path_buf())
    }
}

/// Refuses to replace a folder that is a guarded input or has one in it.
fn refuse_inputs_in(folder: &Path) -> Result<()> {
    refuse_guarded(folder)?;
    let mut files = fs::read_dir(folder).into_iter().flatten().flatten();
    files.try_for_each(|file| refuse_guarded(&file.path()))
}

/// Renamed files and folders, to be renamed back after an error.
#[derive(Default)]
struct Moves {
    done: Vec<(PathBuf, PathBuf)>,
    /// Folders that were made.
    made: Vec<PathBuf>,
}

impl Moves {
    /// Renames `from` to `to`, whose folder is made where it is not there.
    fn rename(&mut self, from: &Path, to: &Path) -> Result<()> {
        let io = |error: io::Error| Error::io(to, &error);
        let folder = folder_of(to);
        let new: Vec<&Path> = folder
            .ancestors()
            .take_while(|path| !path.exists())
            .collect();
        self.made
            .extend(new.into_iter().rev().map(Path::to_path_buf));
        fs::create_dir_all(folder).map_err(io)?;
        fs::rename(from, to).map_err(io)?;
        self.done.push((from.to_path_buf(), to.to_path_buf()));
        Ok(())
    }

    fn undo(self) {
        for (from, to) in self.done.into_iter().rev() {
            let _ = fs::rename(to, from);
        }
        for folder in self.made.into_iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}
