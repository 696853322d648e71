//! The output of one mesh: a file, a file with companion files, or a folder. All files are complete before any gets
//! its name.

use super::inputs::{files_in, hash_of_names, refuse_guarded};
use super::moves::Move;
use super::save::{
    Out, PIECE, Staged, exists, fill_file, is_special, refuse_special, stage_bytes, stage_file,
    stage_path,
};
use super::staged::{Commit, Temporary, folder_of, sync_file};
use crate::mesh::NumbersApart;
use azimesh_core::error::{Error, Result};
use azimesh_core::parallel::with_own_thread;
use azimesh_core::ranks::hash::{HashedBytes, TreeHasher};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Bytes whose hash is worth a thread.
const LARGE: usize = 4 << 20;

/// The files that a mesh is written to, staged until the result of [`OutputSet::finish`] is committed: first the
/// files of a folder, then companion files, then the main file, since it may refer to the others.
pub struct OutputSet<'a> {
    path: &'a Path,
    /// `None` where nothing is kept.
    commit: Option<Commit>,
    folder: Option<StagedFolder>,
    files: Vec<Staged>,
    is_hashed: bool,
    hash: Option<blake3::Hash>,
    n_bytes: u64,
    /// Hashes of the files of a folder, by their names.
    of_folder: BTreeMap<String, blake3::Hash>,
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

/// A folder that a mesh shares with files that are not of the mesh.
pub struct SharedFolder {
    /// The folder.
    pub folder: PathBuf,
    /// The folders inside it that are the mesh's own.
    pub own: Vec<String>,
    /// An empty file that viewers open.
    pub mark: String,
}

impl<'a> OutputSet<'a> {
    /// An output at a path; `-` is standard output.
    pub fn new(path: &'a Path, commit: Commit) -> Self {
        Self {
            commit: Some(commit),
            ..Self::nowhere(path)
        }
    }

    /// An output that keeps only the number of bytes and the hash.
    pub fn nowhere(path: &'a Path) -> Self {
        Self {
            path,
            commit: None,
            folder: None,
            files: Vec::new(),
            is_hashed: false,
            hash: None,
            n_bytes: 0,
            of_folder: BTreeMap::new(),
        }
    }

    /// Computes a hash of what is written.
    #[must_use]
    pub fn hashed(mut self) -> Self {
        self.is_hashed = true;
        self
    }

    /// The path of the output.
    pub fn path(&self) -> &Path {
        self.path
    }

    /// Checks if it is standard output, a device or a pipe, which can have no companion files.
    pub fn is_stream(&self) -> bool {
        self.path.as_os_str() == "-" || is_special(self.path)
    }

    /// Writes the main file, front to back.
    pub fn main<T>(&mut self, write: impl FnOnce(&mut dyn Out) -> Result<T>) -> Result<T> {
        let (written, hash) = match self.commit {
            None => self.count(&mut io::sink(), write)?,
            Some(commit) => {
                let path = self.path;
                let (counted, file) = stage_file(path, commit, |out| self.count(out, write))?;
                self.files.push(file);
                counted
            }
        };
        self.hash = hash;
        Ok(written)
    }

    /// Lets `write` fill the main file, or the folder where all files are in one, whose staged path it is given.
    pub(super) fn at_path<T>(
        &mut self,
        folder: Option<SharedFolder>,
        commit: Commit,
        write: impl FnOnce(&Path) -> Result<T>,
    ) -> Result<T> {
        let Some(shared) = folder else {
            let (written, file) = stage_path(self.path, commit, write)?;
            self.files.push(file);
            return Ok(written);
        };
        let mut folder = StagedFolder::new(&shared.folder, Some(&shared.own), commit)?;
        let staged = folder.temporary.path();
        let written = write(staged).map_err(|mut error| {
            // The user knows `path`, not the temporary folder.
            error.path = error.path.filter(|path| !path.starts_with(staged));
            error.file(self.path)
        })?;
        let failed = |error: io::Error| Error::io(self.path, &error);
        if !shared.folder.join(&shared.mark).exists() {
            fs::write(staged.join(shared.mark), "").map_err(failed)?;
        }
        folder.names = files_in(staged).map_err(failed)?;
        self.folder = Some(folder);
        Ok(written)
    }

    /// Writes a small companion file, which is not part of the hash. One that has these bytes stays: the input, or a mesh of
    /// another format, may have it too.
    pub fn companion(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        let is_there = || path.is_file() && fs::read(path).is_ok_and(|there| there == bytes);
        if let Some(commit) = self.commit.filter(|_| !is_there()) {
            refuse_special(path)?;
            self.files.push(stage_bytes(bytes, path, commit)?);
        }
        Ok(())
    }

    /// Makes `folder`, which may be there and hold other files, the folder of all files. The folders in `owned` inside it
    /// are replaced as a whole.
    pub fn place_in(&mut self, folder: &Path, owned: &[String]) -> Result<()> {
        if let Some(commit) = self.commit {
            self.folder = Some(StagedFolder::new(folder, Some(owned), commit)?);
        }
        Ok(())
    }

    /// Writes the file `name` of a folder, which is `path` or is next to it; `name` may contain folders. All files
    /// of a set are in one folder.
    pub fn in_folder<T>(
        &mut self,
        folder: &Path,
        name: &str,
        write: impl FnOnce(&mut dyn Out) -> Result<T>,
    ) -> Result<T> {
        let (written, hash) = match self.commit {
            None => self.count(&mut io::sink(), write)?,
            Some(commit) => {
                if self.folder.is_none() {
                    // Whether the main file may be replaced decides for its folder too.
                    let replace = folder != self.path || commit.replace;
                    let commit = Commit { replace, ..commit };
                    self.folder = Some(StagedFolder::new(folder, None, commit)?);
                }
                let staged = self.folder.as_mut().expect("it was just made");
                let path = staged
                    .place(name)
                    .map_err(|error| Error::io(folder, &error))?;
                fill_file(&path, |out| self.count(out, write)).map_err(|mut error| {
                    // The user knows the folder, not the staged one.
                    if error.path.as_ref() == Some(&path) {
                        error.path = Some(folder.join(name));
                    }
                    error
                })?
            }
        };
        self.of_folder
            .extend(hash.map(|hash| (name.to_owned(), hash)));
        Ok(written)
    }

    /// Makes a link to a folder, `to` from the folder of the link, in the folder of [`OutputSet::place_in`].
    pub fn link_in_folder(&mut self, name: &str, to: &Path) -> Result<()> {
        let Some(staged) = &mut self.folder else {
            return Ok(());
        };
        let made = staged.place(name).and_then(|path| link_folder(to, &path));
        made.map_err(|error| Error::io(&self.path.join(name), &error))
    }

    /// The files, all of them complete.
    pub fn finish(self) -> Output {
        // The main file comes last, its companions directly before it.
        let folder = self.folder.map(Staged::folder).into_iter();
        let files = Staged::all(folder.chain(self.files).collect());
        let of_folder = || self.is_hashed.then(|| hash_of_names(&self.of_folder));
        Output {
            files,
            hash: self.hash.or_else(of_folder),
            n_bytes: self.n_bytes,
            of_folder: self.of_folder,
        }
    }

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
        let mut hashed = self.out.apart(numbers, hash_from)?;
        if let Some(hasher) = &mut self.hasher {
            if hashed.is_empty() {
                // It was written nowhere.
                hashed = numbers.by.write(None, &numbers.numbers, hash_from)?;
            }
            hashed.iter().for_each(|part| hasher.take(part));
        }
        self.n_bytes += numbers.n_bytes;
        Ok(hashed)
    }
}

impl Write for Counting<'_> {
    /// Large pieces are hashed while they are written.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let (out, mut hasher) = (&mut *self.out, self.hasher.as_mut());
        if let Some(hasher) = hasher.as_mut().filter(|_| bytes.len() >= LARGE) {
            let mut written = Ok(());
            with_own_thread(&mut || written = out.write_all(bytes), &mut || {
                hasher.update(bytes);
            });
            written?;
        } else {
            // A piece is hashed while it is in the cache.
            for piece in bytes.chunks(PIECE) {
                out.write_all(piece)?;
                if let Some(hasher) = &mut hasher {
                    hasher.update(piece);
                }
            }
        }
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.write_all(bytes).map(|()| bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(unix)]
use std::os::unix::fs::symlink as link_folder;
#[cfg(windows)]
use std::os::windows::fs::symlink_dir as link_folder;

/// Files in a staged folder that are moved to their folder, which may exist.
pub(super) struct StagedFolder {
    temporary: Temporary,
    target: PathBuf,
    /// Names of the files, which may contain folders.
    names: Vec<String>,
    /// Folders in `target` that are replaced as a whole.
    owned: Vec<String>,
    /// True if they are; otherwise those that are there by then are kept.
    replace: bool,
    /// True if files and names are synced to the disk.
    sync: bool,
}

impl StagedFolder {
    /// An empty staged folder for files in `target`. Where the target may have other files, it is inside an existing
    /// target, and the folders `owned` are replaced as a whole. Refuses to replace what may not be.
    fn new(target: &Path, owned: Option<&[String]>, commit: Commit) -> Result<Self> {
        let places: Vec<PathBuf> = match owned {
            Some(owned) => owned.iter().map(|name| target.join(name)).collect(),
            None => vec![target.to_path_buf()],
        };
        let taken = places.iter().find(|path| path.exists());
        if let Some(taken) = taken.filter(|_| !commit.replace) {
            return Err(exists(taken));
        }
        if owned.is_some() && target.is_file() {
            return Err(Error::input("this is a file, not a folder").file(target));
        }
        for folder in &places {
            refuse_guarded(folder)?;
            let mut files = files_in(folder).unwrap_or_default().into_iter();
            files.try_for_each(|file| refuse_guarded(&folder.join(file)))?;
        }
        let is_inside = owned.is_some() && target.is_dir();
        let inside = is_inside.then(|| target.join("files"));
        let temporary = Temporary::folder_for(inside.as_deref().unwrap_or(target));
        Ok(Self {
            temporary: temporary.map_err(|error| Error::io(target, &error))?,
            target: target.to_path_buf(),
            names: Vec::new(),
            owned: owned.unwrap_or_default().to_vec(),
            replace: commit.replace || owned.is_none(),
            sync: commit.sync,
        })
    }

    /// Adds a file or a link; gives its staged path, whose folder is made.
    fn place(&mut self, name: &str) -> io::Result<PathBuf> {
        let path = self.temporary.path().join(name);
        fs::create_dir_all(folder_of(&path))?;
        self.names.push(name.to_owned());
        Ok(path)
    }

    /// The moves that put the files in place, once they are synced.
    pub fn moves(&self) -> Result<Vec<Move>> {
        if self.sync {
            self.sync_files()?;
        }
        let (target, staged) = (&self.target, self.temporary.path());
        let to_move = |from: PathBuf, to: PathBuf| Move {
            from,
            to,
            replace: true,
            sync: self.sync,
        };
        let owned = self.owned.iter();
        let there: Vec<&String> = owned.filter(|name| target.join(name).exists()).collect();
        let mut moves = Vec::new();
        for name in there.iter().filter(|_| self.replace) {
            let (from, to) = (staged.join(name), target.join(name));
            moves.push(match from.exists() {
                true => to_move(from, to),
                // It is removed with the staged folder.
                false => to_move(to, staged.join("old").join(name)),
            });
        }
        let is_with_owned = |name: &&String| {
            let mut there = there.iter();
            there.any(|own| Path::new(name).starts_with(own))
        };
        let names = self.names.iter().filter(|name| !is_with_owned(name));
        let pieces: BTreeSet<&Path> = names.map(|name| self.new_piece(name)).collect();
        for piece in pieces {
            let to = target.join(piece);
            refuse_guarded(&to)?;
            moves.push(to_move(staged.join(piece), to));
        }
        Ok(moves)
    }

    /// The folders that are to be synced to the disk once the files are in place.
    pub fn synced(&self) -> BTreeSet<PathBuf> {
        let of_name = |name| Path::new(name).ancestors().skip(1);
        let names = self.names.iter().filter(|_| self.sync);
        let folders = names
            .flat_map(of_name)
            .map(|folder| self.target.join(folder));
        let above = self.sync.then(|| folder_of(&self.target).to_path_buf());
        folders.chain(above).collect()
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

    /// The part of a name that is moved in one piece: the first folder on the way that is not there yet, or else the file.
    fn new_piece<'n>(&self, name: &'n str) -> &'n Path {
        let path = Path::new(name);
        let folders = path.ancestors().skip(1);
        let new = folders.take_while(|folder| !self.target.join(folder).exists());
        let first = new.filter(|folder| !folder.as_os_str().is_empty()).last();
        first.unwrap_or(path)
    }
}
