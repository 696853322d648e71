//! The output of one mesh: a file, a file with companion files, or a folder. All files are complete before any gets
//! its name.

use super::save::{Staged, exists, stage_bytes, stage_whole};
use super::staged::{Commit, Temporary, folder_of, sync_folder};
use crate::error::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The files that a mesh is written to, staged until the result of [`OutputSet::finish`] is committed: first the
/// files of a folder, then companion files, then the main file, since it may refer to the others.
pub struct OutputSet<'a> {
    path: &'a Path,
    /// `None` where nothing is kept.
    commit: Option<Commit>,
    folder: Option<Folder>,
    files: Vec<Staged>,
    main: Option<Staged>,
    /// Content of the main file of a set with a folder, which refers to the files in it: staged only when those
    /// have their names, since a signal commits staged files and removes a staged folder.
    list: Option<Vec<u8>>,
    tally: Tally,
}

/// A folder that a mesh shares with files that are not of the mesh.
pub struct SharedFolder {
    /// The folder.
    pub folder: PathBuf,
    /// The folder inside it that is the mesh's own.
    pub own: &'static str,
    /// An empty file that viewers open.
    pub mark: String,
}

/// The complete files of one mesh.
pub struct Output {
    /// The staged files.
    pub files: Staged,
    /// Hash of the main file, or of all files of a folder, with [`OutputSet::hashed`].
    pub hash: Option<blake3::Hash>,
    /// Bytes of the main file, or of all files of a folder.
    pub n_bytes: u64,
    /// Hash of each file of a folder by its name, with [`OutputSet::hashed`].
    pub of_folder: BTreeMap<String, blake3::Hash>,
}

/// Number of bytes written, and their hash with [`OutputSet::hashed`].
#[derive(Default)]
struct Tally {
    n_bytes: u64,
    is_hashed: bool,
    main: Option<blake3::Hash>,
    /// Hashes of the files of a folder, by their names.
    of_folder: BTreeMap<String, blake3::Hash>,
}

impl<'a> OutputSet<'a> {
    /// An output at a path; `-` is standard output.
    pub fn new(path: &'a Path, commit: Commit) -> Self {
        Self {
            commit: Some(commit),
            ..Self::nowhere(path)
        }
    }

    /// An output of which only the number of bytes and the hash are kept.
    pub fn nowhere(path: &'a Path) -> Self {
        Self {
            path,
            commit: None,
            folder: None,
            files: Vec::new(),
            main: None,
            list: None,
            tally: Tally::default(),
        }
    }

    /// Computes a hash of what is written.
    #[must_use]
    pub fn hashed(mut self) -> Self {
        self.tally.is_hashed = true;
        self
    }

    /// Where the mesh goes.
    pub fn path(&self) -> &Path {
        self.path
    }

    /// Whether it is standard output, a device or a pipe, which can have no companion files.
    pub fn is_stream(&self) -> bool {
        let is_special = |found: fs::Metadata| !found.is_file() && !found.is_dir();
        self.path.as_os_str() == "-" || fs::metadata(self.path).is_ok_and(is_special)
    }

    /// Writes the main file, front to back.
    pub fn main<T>(&mut self, write: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
        let Some(commit) = self.commit else {
            let (written, hash) = self.tally.count(&mut io::sink(), write)?;
            self.tally.main = hash;
            return Ok(written);
        };
        if self.folder.is_some() {
            let mut list = Vec::new();
            let (written, hash) = self.tally.count(&mut list, write)?;
            self.tally.main = hash;
            self.list = Some(list);
            return Ok(written);
        }
        let tally = &mut self.tally;
        let counted = |out: &mut dyn Write| tally.count(out, write);
        let ((written, hash), file) = stage_whole(self.path, commit, counted)?;
        self.tally.main = hash;
        self.main = Some(file);
        Ok(written)
    }

    /// Writes a small companion file, which is not part of the hash.
    pub fn companion(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        if let Some(commit) = self.commit {
            self.files.push(stage_bytes(bytes, path, commit)?);
        }
        Ok(())
    }

    /// Makes `folder`, which may be there and hold other files, the folder of all files. The folders in `owned` inside it
    /// are replaced as a whole.
    pub fn into_folder(&mut self, folder: &Path, owned: &[&str]) -> Result<()> {
        let Some(commit) = self.commit else {
            return Ok(());
        };
        self.folder = Some(Folder::into(folder, owned, commit)?);
        Ok(())
    }

    /// Writes the file `name` of a folder, which is `path` or lies next to it; `name` may contain folders. All files
    /// of a set are in one folder.
    pub fn in_folder<T>(
        &mut self,
        folder: &Path,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> Result<T>,
    ) -> Result<T> {
        let Some(commit) = self.commit else {
            let (written, hash) = self.tally.count(&mut io::sink(), write)?;
            self.tally
                .of_folder
                .extend(hash.map(|hash| (name.to_owned(), hash)));
            return Ok(written);
        };
        if self.folder.is_none() {
            // Whether the main file may be replaced decides for its folder too.
            let replace = folder != self.path || commit.replace;
            self.folder = Some(Folder::new(folder, Commit { replace, ..commit })?);
        }
        let staged = self.folder.as_mut().expect("it was just made");
        let path = staged.temporary.path().join(name);
        fs::create_dir_all(folder_of(&path)).map_err(|error| Error::io(folder, &error))?;
        let tally = &mut self.tally;
        let counted = |out: &mut dyn Write| tally.count(out, write);
        let replace = Commit {
            replace: true,
            ..commit
        };
        let known = |mut error: Error| {
            // The user knows the folder, not the staged one.
            if error
                .path
                .as_ref()
                .is_some_and(|path| path.starts_with(staged.temporary.path()))
            {
                error.path = Some(folder.join(name));
            }
            error
        };
        let ((written, hash), file) = stage_whole(&path, replace, counted).map_err(known)?;
        file.keep().map_err(known)?;
        staged.names.push(name.to_owned());
        self.tally
            .of_folder
            .extend(hash.map(|hash| (name.to_owned(), hash)));
        Ok(written)
    }

    /// The files, all of them complete.
    pub fn finish(self) -> Output {
        let files = self.files.into_iter().chain(self.main);
        let files: Vec<Staged> = files.collect();
        let files = match (self.folder, self.commit) {
            (Some(folder), Some(commit)) => {
                let path = self.path.to_path_buf();
                let list = self.list;
                folder.staged(commit, move || {
                    Staged::keep_all(files)?;
                    let list = list.map(|list| stage_bytes(&list, &path, commit));
                    list.transpose()?.map_or(Ok(()), Staged::keep)
                })
            }
            _ => Staged::all(files),
        };
        Output {
            files,
            hash: self.tally.hash(),
            n_bytes: self.tally.n_bytes,
            of_folder: self.tally.of_folder,
        }
    }
}

impl Tally {
    /// Lets `write` write to `out`; counts and hashes the bytes.
    fn count<T>(
        &mut self,
        out: &mut dyn Write,
        write: impl FnOnce(&mut dyn Write) -> Result<T>,
    ) -> Result<(T, Option<blake3::Hash>)> {
        let mut counting = Counting {
            out,
            n_bytes: 0,
            hasher: self.is_hashed.then(blake3::Hasher::new),
        };
        let written = write(&mut counting)?;
        self.n_bytes += counting.n_bytes;
        Ok((written, counting.hasher.map(|hasher| hasher.finalize())))
    }

    fn hash(&self) -> Option<blake3::Hash> {
        let of_folder = || hash_of_names(&self.of_folder);
        self.main.or_else(|| self.is_hashed.then(of_folder))
    }
}

/// Counts and hashes the bytes that pass through.
struct Counting<'a> {
    out: &'a mut dyn Write,
    n_bytes: u64,
    hasher: Option<blake3::Hasher>,
}

impl Write for Counting<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.out.write(bytes)?;
        self.n_bytes += n as u64;
        if let Some(hasher) = &mut self.hasher {
            hasher.update(&bytes[..n]);
        }
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// One hash of several files: that of their names and hashes, ordered by name.
pub fn hash_of_names(files: &BTreeMap<String, blake3::Hash>) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for (name, hash) in files {
        hasher.update(name.as_bytes());
        hasher.update(&[0]);
        hasher.update(hash.as_bytes());
    }
    hasher.finalize()
}

/// The [`Output::hash`] of the files in a folder; `of_file` hashes a file.
pub fn hash_of_folder(
    folder: &Path,
    of_file: impl Fn(&Path) -> io::Result<blake3::Hash>,
) -> io::Result<blake3::Hash> {
    let names = files_in(folder)?.into_iter();
    let hashes = names.map(|name| Ok((name.clone(), of_file(&folder.join(name))?)));
    Ok(hash_of_names(&hashes.collect::<io::Result<_>>()?))
}

/// Paths of all files in a folder and its subfolders, relative to it, ascending.
fn files_in(folder: &Path) -> io::Result<Vec<String>> {
    let mut files = Vec::new();
    let mut folders = vec![String::new()];
    while let Some(before) = folders.pop() {
        for entry in fs::read_dir(folder.join(&before))? {
            let entry = entry?;
            let name = format!("{before}{}", entry.file_name().to_string_lossy());
            match entry.path().is_dir() {
                true => folders.push(name + "/"),
                false => files.push(name),
            }
        }
    }
    files.sort();
    Ok(files)
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
        Some(shared) => Folder::into(&shared.folder, &[shared.own], commit)?,
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
struct Folder {
    temporary: Temporary,
    target: PathBuf,
    names: Vec<String>,
    /// Folders in `target` that are replaced as a whole.
    owned: Vec<String>,
    /// Whether they are; otherwise those that are there by then are kept.
    replace: bool,
}

impl Folder {
    /// An empty staged folder for `target`. Refuses an existing target unless it is to be replaced.
    fn new(target: &Path, commit: Commit) -> Result<Self> {
        if !commit.replace && target.exists() {
            return Err(exists(target));
        }
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
    fn into(target: &Path, owned: &[&str], commit: Commit) -> Result<Self> {
        let taken = owned
            .iter()
            .map(|name| target.join(name))
            .find(|path| path.exists());
        if let (Some(taken), false) = (taken, commit.replace) {
            return Err(exists(&taken));
        }
        if target.is_file() {
            return Err(Error::input("this is a file, not a folder").file(target));
        }
        let inside = target.is_dir().then(|| target.join("files"));
        let beside = inside.as_deref().unwrap_or(target);
        let temporary = Temporary::folder_for(beside).map_err(|error| Error::io(target, &error))?;
        Ok(Self {
            temporary,
            target: target.to_path_buf(),
            names: Vec::new(),
            owned: owned.iter().map(|&name| name.to_owned()).collect(),
            replace: commit.replace,
        })
    }

    /// The staged files; committing them moves them, then calls `last`. After an error the files that were there
    /// before are restored. A system that stops between two renames leaves a mixture of old and new files: no
    /// file system renames several files at once.
    fn staged(self, commit: Commit, last: impl FnOnce() -> Result<()> + Send + 'static) -> Staged {
        Staged::new(move || {
            self.put_in_place(|| {
                if commit.sync {
                    self.sync()?;
                }
                last()
            })?;
            Ok(commit.sync.then(|| folder_of(&self.target).to_path_buf()))
        })
    }

    /// Syncs the names of all files and folders.
    fn sync(&self) -> Result<()> {
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
        let staged = |piece: &Path| self.temporary.path().join(piece).exists();
        if !staged(path) {
            return None;
        }
        let folders: Vec<&Path> = path.ancestors().skip(1).collect();
        let is_new =
            |piece: &&&Path| !self.target.join(piece).exists() && !piece.as_os_str().is_empty();
        let first = folders.iter().rev().find(is_new);
        Some(first.map_or(path, |piece| piece).to_path_buf())
    }
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
