//! The output of one mesh: a file, a file with companion files, or a folder. All files are complete before any gets
//! its name.

use super::out::Out;
use super::save::{PIECE, Staged, stage_bytes, stage_whole};
use super::sink::refuse_special;
use super::staged::{Commit, folder_of};
use super::staged_folder::Folder;
use crate::mesh::NumbersApart;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::with_own_thread;
use azimesh_core::ranks::hash::{HashedBytes, TreeHasher};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// Bytes whose hash is worth a thread.
const LARGE: usize = 4 << 20;

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
    pub fn main<T>(&mut self, write: impl FnOnce(&mut dyn Out) -> Result<T>) -> Result<T> {
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
        let counted = |out: &mut dyn Out| tally.count(out, write);
        let ((written, hash), file) = stage_whole(self.path, commit, counted)?;
        self.tally.main = hash;
        self.main = Some(file);
        Ok(written)
    }

    /// Writes a small companion file, which is not part of the hash. One that may be replaced and has these bytes stays: it may be that of
    /// the input too.
    pub fn companion(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        let is_there = || path.is_file() && fs::read(path).is_ok_and(|there| there == bytes);
        if let Some(commit) = self.commit.filter(|own| !(own.replace && is_there())) {
            refuse_special(path)?;
            self.files.push(stage_bytes(bytes, path, commit)?);
        }
        Ok(())
    }

    /// Makes `folder`, which may be there and hold other files, the folder of all files. The folders in `owned` inside it
    /// are replaced as a whole.
    pub fn place_in<N: AsRef<str>>(&mut self, folder: &Path, owned: &[N]) -> Result<()> {
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
        write: impl FnOnce(&mut dyn Out) -> Result<T>,
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
        let counted = |out: &mut dyn Out| tally.count(out, write);
        // It is synced when the folder is put in place.
        let replace = Commit {
            replace: true,
            sync: false,
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

    /// Makes a link to a folder, `to` from the folder of the link, in the folder of [`OutputSet::place_in`].
    pub fn link_in_folder(&mut self, name: &str, to: &Path) -> Result<()> {
        let Some(staged) = &mut self.folder else {
            return Ok(());
        };
        let path = staged.temporary.path().join(name);
        let made = fs::create_dir_all(folder_of(&path)).and_then(|()| link_folder(to, &path));
        made.map_err(|error| Error::io(&self.path.join(name), &error))?;
        staged.names.push(name.to_owned());
        Ok(())
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
        out: &mut dyn Out,
        write: impl FnOnce(&mut dyn Out) -> Result<T>,
    ) -> Result<(T, Option<blake3::Hash>)> {
        let mut counting = Counting {
            out,
            n_bytes: 0,
            hasher: self.is_hashed.then(TreeHasher::default),
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
    out: &'a mut dyn Out,
    n_bytes: u64,
    hasher: Option<TreeHasher>,
}

impl Out for Counting<'_> {
    fn apart(&mut self, numbers: &NumbersApart, hash_from: u64) -> Result<Vec<HashedBytes>> {
        let hash_from = self.hasher.as_ref().map_or(hash_from, TreeHasher::n_bytes);
        let mut told = self.out.apart(numbers, hash_from)?;
        if let Some(hasher) = &mut self.hasher {
            if told.is_empty() {
                // It was written nowhere.
                told = numbers.by.write(None, &numbers.numbers, hash_from)?;
            }
            told.iter().for_each(|part| hasher.take(part));
        }
        self.n_bytes += numbers.n_bytes;
        Ok(told)
    }
}

impl Write for Counting<'_> {
    /// Large pieces are hashed beside the writing.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let (out, mut hasher) = (&mut *self.out, self.hasher.as_mut());
        match hasher.as_mut().filter(|_| bytes.len() >= LARGE) {
            Some(hasher) => {
                let mut written = Ok(());
                with_own_thread(&mut || written = out.write_all(bytes), &mut || {
                    hasher.update(bytes);
                });
                written?;
            }
            None => {
                // A piece is hashed while it is in the cache.
                for piece in bytes.chunks(PIECE) {
                    out.write_all(piece)?;
                    if let Some(hasher) = &mut hasher {
                        hasher.update(piece);
                    }
                }
            }
        }
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }

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

#[cfg(unix)]
use std::os::unix::fs::symlink as link_folder;
#[cfg(windows)]
use std::os::windows::fs::symlink_dir as link_folder;

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
pub(super) fn files_in(folder: &Path) -> io::Result<Vec<String>> {
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
