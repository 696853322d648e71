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
mod write;

use super::format::{OuterFaces, surface_of};
use super::{Format, Notes};
use crate::mesh::{Mesh, MeshView};

/// STL (.stl).
pub static STL: Format = Format {
    name: "stl",
    title: "STL surface (.stl)",
    extensions: &["stl"],
    is_surface: true,
    lists_faces_again: false,
    detect: |source| read::recognizes(source.bytes()),
    read: |source, _, notes| read::read(source.bytes(), notes),
    surface: Some(surface),
    write: Some(|mesh, out, options| {
        let (surface, mut notes) = surface(mesh, OuterFaces::All);
        notes.extend(write::write(&surface.view(), out, options)?);
        Ok(notes)
    }),
    ..Format::NEW
};

fn surface(mesh: &MeshView, outer: OuterFaces) -> (Mesh, Notes) {
    let (surface, mut notes) = surface_of(mesh, "STL", outer);
    let triangles = write::triangles(surface, &mut notes);
    (triangles, notes)
}

#[cfg(test)]
mod tests;
