//! STL: triangles of a surface in space, binary or text.
//!
//! The surface of the mesh is written as triangles whose normals point out of the solid. Text has a `solid` for each
//! tag; binary files have no names, and coordinates of 32 bits. Nodes at one place are one node when a file is read.
//!
//! ```
//! use azimesh_io::{Encoding, Mesh, WriteOptions};
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("sphere.stl");
//!
//! let mesh = Mesh::read("testdata/sphere_in_box_raw_zlib.vtu")?;
//! let options = WriteOptions { encoding: Encoding::Ascii, ..WriteOptions::default() };
//! let notes = mesh.view().write_with(&path, &options)?;
//! notes.iter().for_each(|note| eprintln!("{note}")); // Solid cells are not in the file.
//!
//! let surface = Mesh::read(&path)?;
//! let tags: Vec<_> = surface.tags().map(|tag| (tag.name.as_str(), tag.cells.len())).collect();
//! assert_eq!(tags, [("sphere", 50), ("inlet", 90), ("outlet", 90), ("walls", 360)]);
//! # Ok(())
//! # }
//! ```

mod read;
mod triangles;
mod write;

use super::surface::{OuterFaces, surface_of};
use super::{Format, Notes, ReadOptions, Source, WriteOptions};
use crate::formats::Out;
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::Result;

/// STL (.stl).
pub struct Stl;

impl Format for Stl {
    fn name(&self) -> &'static str {
        "stl"
    }

    fn title(&self) -> &'static str {
        "STL surface (.stl)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["stl"]
    }

    fn is_surface(&self) -> bool {
        true
    }

    fn recognizes_file(&self, source: &Source) -> bool {
        read::recognizes(source.bytes())
    }

    fn lists_faces_again(&self) -> bool {
        false
    }

    fn read_file(&self, source: &Source, _: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes(), notes)
    }

    fn surface(&self, mesh: &MeshView, outer: OuterFaces) -> Option<(Mesh, Notes)> {
        let (surface, mut notes) = surface_of(mesh, "STL", outer);
        let triangles = triangles::of(surface, &mut notes);
        Some((triangles, notes))
    }

    fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Out,
        options: &WriteOptions,
    ) -> Result<Notes> {
        let (surface, mut notes) = self.surface(mesh, OuterFaces::All).expect("it has one");
        notes.extend(write::write(&surface.view(), out, options)?);
        Ok(notes)
    }
}

#[cfg(test)]
mod tests;
