//! Reads and writes meshes by their paths: the entry points of this module.

use super::save::stage_file;
use super::staged_folder::stage_folder;
use super::{
    Begin, Commit, Format, Loaded, Location, Notes, OutputSet, ReadOptions, SequenceFile, Staged,
    WriteOptions, by_extension, read,
};
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::{Error, Result};
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
    /// assert_eq!(loaded.format.name(), "su2");
    /// loaded.notes.iter().for_each(|note| eprintln!("{note}"));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Those of [`Mesh::read`].
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
    /// Those of [`Mesh::write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Notes> {
        self.write_with(path, &WriteOptions::default())
    }

    /// Writes as [`Mesh::write`] does, with options. Those that the format has no use for change nothing.
    ///
    /// # Errors
    /// Those of [`Mesh::write`].
    pub fn write_with(&self, path: impl AsRef<Path>, options: &WriteOptions) -> Result<Notes> {
        let path = path.as_ref();
        save(self, path, by_extension(path)?, options, Commit::REPLACE)
    }
}

/// Writes `mesh` to `path`; returns a note for each thing that the format cannot hold.
///
/// The files are staged in the same folder, renamed once all are complete, and removed when anything
/// fails. `-` is standard output. A device or a pipe, which cannot be replaced, is written to directly;
/// a symbolic link is followed.
pub fn save(
    mesh: &MeshView,
    path: &Path,
    format: &dyn Format,
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
    format: &dyn Format,
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
    format: &dyn Format,
    options: &WriteOptions,
    commit: Commit,
    write: impl FnOnce(&mut dyn SequenceFile) -> Result<T>,
) -> Result<(T, Staged)> {
    let create = format.sequence().ok_or_else(|| {
        Error::input(format!("{} cannot hold a sequence", format.title())).file(path)
    })?;
    let fill = |staged: &Path| write(&mut *create(staged, options, Begin::Fill, false)?);
    match format.is_folder() {
        true => stage_folder(path, format.shared_folder(path), commit, fill),
        false => stage_file(path, commit, fill),
    }
}
