//! Reads and writes meshes by their paths: the entry points of this module.

use super::{
    Commit, Format, Location, Notes, OutputSet, ReadOptions, Source, Staged, WriteOptions,
    by_extension, choice, names, of,
};
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use azimesh_core::numbers::short;
use std::path::Path;

impl Mesh {
    /// The mesh in a file or folder, of any format that is read; the last step of a sequence. `-` is standard
    /// input.
    ///
    /// ```
    /// use azimesh_io::Mesh;
    /// # fn main() -> azimesh_io::Result<()> {
    /// let mesh = Mesh::read("testdata/naca0012.vtu")?;
    /// assert_eq!(mesh.dimension(), 2);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If there is no mesh or it is damaged, with the place in the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self::read_with(path, &ReadOptions::default())?.mesh)
    }

    /// Reads as [`Mesh::read`] does, with options. Gives the mesh, notes on what it does not hold of the file, and the
    /// file's format.
    ///
    /// ```
    /// use azimesh_io::{Mesh, ReadOptions};
    /// # fn main() -> azimesh_io::Result<()> {
    /// let loaded = Mesh::read_with("testdata/mixed_cells.su2", &ReadOptions::default())?;
    /// assert_eq!(loaded.format.name, "su2");
    /// loaded.notes.iter().for_each(|note| eprintln!("{note}"));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Mesh::read`].
    pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded> {
        read(&Location::open(path.as_ref())?, options)
    }

    /// Writes the mesh in the format of the path's extension, completely or not at all. An existing file is replaced.
    /// Returns notes on what the format does not hold.
    ///
    /// ```
    /// use azimesh_io::Mesh;
    /// # fn main() -> azimesh_io::Result<()> {
    /// # let folder = tempfile::tempdir().expect("a folder");
    /// # let path = folder.path().join("naca0012.su2");
    /// let mesh = Mesh::read("testdata/naca0012.vtu")?;
    /// let notes = mesh.write(&path)?;
    /// assert!(notes.is_empty());
    /// assert_eq!(Mesh::read(&path)?.points, mesh.points);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If no format has the extension, if the format cannot hold the mesh, and errors of the system.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Notes> {
        self.view().write(path)
    }
}

impl MeshView<'_> {
    /// Writes the mesh as [`Mesh::write`] does.
    ///
    /// # Errors
    /// As [`Mesh::write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Notes> {
        self.write_with(path, &WriteOptions::default())
    }

    /// Writes as [`Mesh::write`] does, with options. Those that the format has no use for change nothing.
    ///
    /// # Errors
    /// As [`Mesh::write`].
    pub fn write_with(&self, path: impl AsRef<Path>, options: &WriteOptions) -> Result<Notes> {
        let path = path.as_ref();
        save(self, path, by_extension(path)?, options, Commit::REPLACE)
    }
}

/// A mesh that was read, with its format and notes. See [`Mesh::read_with`].
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// Notes on what the mesh does not hold of the file.
    pub notes: Notes,
    /// The file's format.
    pub format: &'static Format,
}

/// Reads a mesh in the format of its content or, if that is ambiguous, of its name.
pub fn read(location: &Location, options: &ReadOptions) -> Result<Loaded> {
    read_as(of(location)?, location, options)
}

/// Reads a mesh of a known format.
pub fn read_as(
    format: &'static Format,
    location: &Location,
    options: &ReadOptions,
) -> Result<Loaded> {
    let is_empty = |file: &Source| file.bytes().is_empty();
    if location.file().is_ok_and(is_empty) && !format.recognizes(location) {
        return Err(Error::input("the file is empty; it should hold a mesh").file(location.path()));
    }
    let mut notes = Notes::default();
    if let Ok(file) = location.file() {
        if let Some(refusal) = choice::refusal(file).filter(|_| !format.recognizes(location)) {
            return Err(refusal);
        }
        notes.count(file.n_padding(), |n| {
            note!(
                "zero_padding",
                "{} behind the compressed data are passed over",
                counted(n, "zero")
            )
        });
    }
    note_steps(format, location, options, &mut notes);
    let read = format.read(location, options, &mut notes);
    if let Ok(file) = location.file() {
        file.check_whole()?;
    }
    let valid = read.and_then(|mesh| mesh.validate().map(|()| mesh));
    let mut mesh = valid.map_err(|error| error.file(location.path()))?;
    if format.lists_faces_again {
        mesh.merge_repeated_faces();
    }
    names::check(&mut mesh, &mut notes);
    notes.close();
    Ok(Loaded {
        mesh,
        notes,
        format,
    })
}

/// Notes which step of a sequence is read if none is asked for. The reader reports what is wrong with the file.
pub(super) fn note_steps(
    format: &Format,
    location: &Location,
    options: &ReadOptions,
    notes: &mut Notes,
) {
    let steps = || format.steps(location).unwrap_or_default();
    let steps = options.step.map_or_else(steps, |_| Vec::new());
    if let [.., _, last] = steps[..] {
        let n = counted(steps.len(), "step");
        notes.push(note!(
            "last_of_steps",
            "of {n} that it holds the last is read, at {}",
            short(last)
        ));
    }
}

/// The mesh in bytes of a known format, as the format gives it, without the checks of [`read`].
pub fn parse(format: &Format, bytes: &[u8], options: &ReadOptions) -> Result<Mesh> {
    let source = Source::from_bytes(Path::new("<memory>"), bytes.to_vec());
    (format.read)(&source, options, &mut Notes::default())
}

/// Writes `mesh` to `path`; returns a note for each thing that the format cannot hold.
///
/// The files are staged in the same folder, renamed once all are complete, and removed when anything
/// fails. `-` is standard output. A device or a pipe, which cannot be replaced, is written to directly;
/// a symbolic link is followed.
pub fn save(
    mesh: &MeshView,
    path: &Path,
    format: &Format,
    options: &WriteOptions,
    commit: Commit,
) -> Result<Notes> {
    let (notes, files) = stage(mesh, path, format, options, commit)?;
    files.keep()?;
    Ok(notes)
}

/// Writes `mesh` as [`save`] does, but leaves the files staged.
pub fn stage(
    mesh: &MeshView,
    path: &Path,
    format: &Format,
    options: &WriteOptions,
    commit: Commit,
) -> Result<(Notes, Staged)> {
    let mut out = OutputSet::new(path, commit);
    let notes = format.write(mesh, &mut out, options)?;
    Ok((notes, out.finish().files))
}

/// Lets `write` fill the staged file or folder of a whole sequence. Where `path` is standard output, a device or a
/// pipe, the file is copied to it and removed.
pub fn stage_sequence<T>(
    path: &Path,
    format: &Format,
    options: &WriteOptions,
    commit: Commit,
    write: impl FnOnce(&mut dyn SequenceFile) -> Result<T>,
) -> Result<(T, Staged)> {
    let create = format.sequence.ok_or_else(|| {
        Error::input(format!("{} cannot hold a sequence", format.title)).file(path)
    })?;
    let mut out = OutputSet::new(path, commit);
    let folder = format.folder.as_ref().map(|folder| (folder.shared)(path));
    let written = out.at_path(folder, commit, |staged| {
        write(&mut *create(staged, options, Begin::Fill, false)?)
    })?;
    Ok((written, out.finish().files))
}

/// A file to which meshes are appended one after another.
///
/// It has its name once the first mesh is committed. If the program ends after that, for whatever reason, the file
/// is valid and holds the meshes that were committed.
pub trait SequenceFile: Send {
    /// Appends a mesh with the same cells and arrays as the first; positions and values may differ. Returns the hash
    /// of the bytes added to the file. The mesh is part of the file from the next [`SequenceFile::commit`] on.
    fn append(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash>;

    /// Makes the mesh that was appended last a part of the file. Must be called before another is appended.
    fn commit(&mut self) -> Result<()> {
        Ok(())
    }

    /// Appends and commits.
    fn push(&mut self, time: f64, mesh: &MeshView) -> Result<blake3::Hash> {
        let hash = self.append(time, mesh)?;
        self.commit()?;
        Ok(hash)
    }

    /// Notes on what the format cannot hold of the first mesh.
    fn notes(&self) -> &Notes;

    /// Bytes of the file up to the end of the mesh appended last.
    fn n_bytes(&self) -> u64;

    /// Ends a resumed file ([`Begin::Resume`]) with the mesh appended last: removes what comes after it. Returns
    /// whether there was anything.
    fn end(&mut self) -> Result<bool> {
        Ok(false)
    }

    /// Checks if all meshes appended so far were in the file before ([`Begin::Resume`]).
    fn is_resuming(&self) -> bool {
        false
    }
}

/// Treatment of an existing file of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// It is replaced when the first mesh is complete.
    Create,
    /// It is resumed: appended meshes that it holds already are compared, not written. From the first byte that
    /// differs on it is overwritten; the meshes before that byte stay readable at every moment.
    Resume,
    /// It is an empty staged file, which is filled in place; the caller commits it.
    Fill,
}

/// Opens a file of a sequence. With `sync` each mesh is synced to the disk when it is committed.
pub type CreateSequence =
    fn(&Path, &WriteOptions, Begin, sync: bool) -> Result<Box<dyn SequenceFile>>;
