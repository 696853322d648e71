//! Meshes read and written by their paths alone: the front door of this room.

use super::{Commit, Loaded, Location, Notes, ReadOptions, WriteOptions, by_extension, read, save};
use crate::error::Result;
use crate::mesh::{Mesh, MeshView};
use std::path::Path;

impl Mesh {
    /// The mesh in a file or folder, of any format that is read; the last step of a sequence. `-` is standard
    /// input.
    ///
    /// ```
    /// use azimesh::Mesh;
    /// # fn main() -> azimesh::Result<()> {
    /// let mesh = Mesh::read("testdata/naca0012.vtu")?;
    /// assert_eq!(mesh.dimension(), 2);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Where there is no mesh, or none that is whole; they say where in the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self::read_with(path, &ReadOptions::default())?.mesh)
    }

    /// Reads as [`Mesh::read`] does, with options. Gives the mesh, notes on what it does not hold of the file, and the
    /// file's format.
    ///
    /// ```
    /// use azimesh::{Mesh, ReadOptions};
    /// # fn main() -> azimesh::Result<()> {
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

    /// Writes the mesh, whole or not at all, in the format that the path's ending names, in place of what has the
    /// name; gives notes on what the format does not hold.
    ///
    /// ```
    /// use azimesh::Mesh;
    /// # fn main() -> azimesh::Result<()> {
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
    /// Where no format has the ending, where the format cannot hold the mesh, and of the system.
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
