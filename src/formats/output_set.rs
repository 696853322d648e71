//! Where a mesh goes: one file, a file and others beside it, or a folder; all whole before any takes its name.

use super::hidden::{Commit, Hidden, folder_of, sync_folder};
use super::save::{Waiting, exists, stage_bytes, stage_whole};
use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The files that a mesh is written to. Each has a hidden name until [`OutputSet::finish`], whose result gives
/// them theirs: those of a folder first, then those beside, the main file last, since it may name the others.
pub struct OutputSet<'a> {
    path: &'a Path,
    /// `None` where the bytes go nowhere.
    commit: Option<Commit>,
    folder: Option<Folder>,
    files: Vec<Waiting>,
    main: Option<Waiting>,
    /// The main file of a folder's, which names those: written when they have their names, since a signal names
    /// what is whole and removes a folder that waits.
    list: Option<Vec<u8>>,
    tally: Tally,
}

/// Files of one mesh that are whole.
pub struct Output {
    /// What gives them their names.
    pub files: Waiting,
    /// Hash of the main file, or of all files of a folder, where it was asked for.
    pub hash: Option<blake3::Hash>,
    /// Bytes of the main file, or of all files of a folder.
    pub n_bytes: u64,
}

/// Bytes that were written, and their hash where that is wanted.
#[derive(Default)]
struct Tally {
    n_bytes: u64,
    is_hashed: bool,
    main: Option<blake3::Hash>,
    /// Of the files of a folder, by their names.
    of_folder: BTreeMap<String, blake3::Hash>,
}

impl<'a> OutputSet<'a> {
    /// What is to be at a path; `-` is standard output.
    pub fn new(path: &'a Path, commit: Commit) -> Self {
        Self {
            commit: Some(commit),
            ..Self::nowhere(path)
        }
    }

    /// The same, of which nothing is kept but how long it is, and its hash.
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

    /// With a hash of what is written.
    #[must_use]
    pub fn hashed(mut self) -> Self {
        self.tally.is_hashed = true;
        self
    }

    /// Where the mesh goes.
    pub fn path(&self) -> &Path {
        self.path
    }

    /// Whether that is standard output, a device or a pipe, beside which nothing can be.
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

    /// Writes a small file beside the main one, which is no part of the hash.
    pub fn beside(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        if let Some(commit) = self.commit {
            self.files.push(stage_bytes(bytes, path, commit)?);
        }
        Ok(())
    }

    /// Writes a file of a folder, at `path` or beside it; `name` may have folders of its own. All files of a set
    /// are in one folder.
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
            // The main file says whether what is beside it may be replaced.
            let replace = folder != self.path || commit.replace;
            self.folder = Some(Folder::beside(folder, Commit { replace, ..commit })?);
        }
        let staged = self.folder.as_mut().expect("it was just made");
        let path = staged.hidden.path().join(name);
        fs::create_dir_all(folder_of(&path)).map_err(|error| Error::io(folder, &error))?;
        let tally = &mut self.tally;
        let counted = |out: &mut dyn Write| tally.count(out, write);
        let replace = Commit {
            replace: true,
            ..commit
        };
        let ((written, hash), file) = stage_whole(&path, replace, counted)?;
        file.keep()?;
        staged.names.push(name.to_owned());
        self.tally
            .of_folder
            .extend(hash.map(|hash| (name.to_owned(), hash)));
        Ok(written)
    }

    /// The files, which are whole.
    pub fn finish(self) -> Output {
        let files = self.files.into_iter().chain(self.main);
        let files: Vec<Waiting> = files.collect();
        let files = match (self.folder, self.commit) {
            (Some(folder), Some(commit)) => {
                let path = self.path.to_path_buf();
                let list = self.list;
                folder.waiting(commit, move || {
                    Waiting::keep_all(files)?;
                    let list = list.map(|list| stage_bytes(&list, &path, commit));
                    list.transpose()?.map_or(Ok(()), Waiting::keep)
                })
            }
            _ => Waiting::all(files),
        };
        Output {
            files,
            hash: self.tally.hash(),
            n_bytes: self.tally.n_bytes,
        }
    }
}

impl Tally {
    /// Lets `write` write to `out`, and counts.
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

/// Counts and hashes what goes through it.
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

/// One hash of several files: of their names and hashes, in the order of the names.
fn hash_of_names(files: &BTreeMap<String, blake3::Hash>) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for (name, hash) in files {
        hasher.update(name.as_bytes());
        hasher.update(&[0]);
        hasher.update(hash.as_bytes());
    }
    hasher.finalize()
}

/// The hash that [`Output::hash`] gives of the files of a folder; `of_file` is that of a file.
pub fn hash_of_folder(
    folder: &Path,
    of_file: impl Fn(&Path) -> io::Result<blake3::Hash>,
) -> io::Result<blake3::Hash> {
    let names = files_in(folder)?.into_iter();
    let hashes = names.map(|name| Ok((name.clone(), of_file(&folder.join(name))?)));
    Ok(hash_of_names(&hashes.collect::<io::Result<_>>()?))
}

/// Names of all files below a folder, with the folders in it that they are in.
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

/// Lets `write` fill a folder, of a name that it is given, which then waits for the name `path`.
pub(super) fn stage_folder<T>(
    path: &Path,
    commit: Commit,
    write: impl FnOnce(&Path) -> Result<T>,
) -> Result<(T, Waiting)> {
    let mut folder = Folder::beside(path, commit)?;
    let written = write(folder.hidden.path()).map_err(|mut error| {
        // Who asked for `path` knows nothing of the hidden folder.
        error.path = error
            .path
            .filter(|path| !path.starts_with(folder.hidden.path()));
        error.file(path)
    })?;
    let names = files_in(folder.hidden.path());
    folder.names = names.map_err(|error| Error::io(path, &error))?;
    Ok((written, folder.waiting(commit, || Ok(()))))
}

/// Files in a hidden folder that go to a folder, which may be there.
struct Folder {
    hidden: Hidden,
    target: PathBuf,
    names: Vec<String>,
}

impl Folder {
    /// An empty one. Refuses a name that is taken, unless that is to be replaced.
    fn beside(target: &Path, commit: Commit) -> Result<Self> {
        if !commit.replace && target.exists() {
            return Err(exists(target));
        }
        let hidden = Hidden::folder_beside(target).map_err(|error| Error::io(target, &error))?;
        Ok(Self {
            hidden,
            target: target.to_path_buf(),
            names: Vec::new(),
        })
    }

    /// What moves them, then does the `last` thing. An error on the way brings back the files that had the
    /// names before. A system that stops between the renames, which no file system does at once for several
    /// files, leaves old and new ones.
    fn waiting(
        self,
        commit: Commit,
        last: impl FnOnce() -> Result<()> + Send + 'static,
    ) -> Waiting {
        Waiting::new(move || {
            self.put_in_place(|| {
                if commit.sync {
                    sync_folder(&self.target).map_err(|error| Error::io(&self.target, &error))?;
                }
                last()
            })?;
            Ok(commit.sync.then(|| folder_of(&self.target).to_path_buf()))
        })
    }

    /// Moves the files to their folder, then does the `last` thing.
    fn put_in_place(&self, last: impl FnOnce() -> Result<()>) -> Result<()> {
        let (hidden, folder) = (self.hidden.path(), &self.target);
        let old = hidden.join("old");
        let is_new = !folder.exists();
        for made in [&old, folder] {
            fs::create_dir_all(made).map_err(|error| Error::io(made, &error))?;
        }
        let mut moved = 0;
        let move_all = || {
            for name in &self.names {
                let target = folder.join(name);
                let io = |error: io::Error| Error::io(&target, &error);
                fs::create_dir_all(folder_of(&target)).map_err(io)?;
                if target.exists() {
                    let kept = old.join(name);
                    fs::create_dir_all(folder_of(&kept)).map_err(io)?;
                    fs::rename(&target, kept).map_err(io)?;
                }
                moved += 1;
                fs::rename(hidden.join(name), &target).map_err(io)?;
            }
            last()
        };
        let done = move_all();
        if done.is_err() {
            // What cannot be brought back is worth less than the error that is told.
            for name in &self.names[..moved] {
                let target = folder.join(name);
                let _ = fs::remove_file(&target);
                let _ = fs::rename(old.join(name), &target);
            }
            if is_new {
                let _ = fs::remove_dir(folder);
            }
        }
        done
    }
}
