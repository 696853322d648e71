//! STL: triangles of a surface in space, binary or text.
//!
//! The surface of the mesh is written as triangles whose normals point out of the solid. Text has a `solid` for each
//! tag; binary files have no names, and coordinates of 32 bits. Nodes at one place are one node when a file is read.

mod read;
mod triangles;
mod write;

use super::surface::{OuterFaces, surface_of};
use super::{Format, Notes, ReadOptions, Source, WriteOptions};
use crate::error::Result;
use crate::formats::Out;
use crate::mesh::{Mesh, MeshView};

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
