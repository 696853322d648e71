//! VTK's legacy files (.vtk): versions 1.0 to 5.1, text and binary.
//!
//! Reads unstructured grids and polygonal data, and structured grids, rectilinear grids and images
//! as the cells that they imply. Writes unstructured grids of version 5.1 or 4.2.
//!
//! ```text
//! cursor      words and lines, and where an error is
//! values      numbers, bits, strings
//! cells       lists of cells; attributes: arrays in each of the ways there are
//! read        the parts of a file -> mesh
//! write       mesh -> file
//! ```

mod attributes;
mod cells;
mod cursor;
mod read;
mod values;
mod write;

use super::{Format, Notes, ReadOptions, Source, WriteOptions};
use crate::error::Result;
use crate::mesh::{Mesh, MeshView};
use std::io::Write;

/// VTK legacy file (.vtk), written in version 5.1.
pub struct Legacy;

/// VTK legacy file, written in version 4.2 for older readers.
pub struct Legacy42;

impl Format for Legacy {
    fn name(&self) -> &'static str {
        "vtk"
    }

    fn title(&self) -> &'static str {
        "VTK legacy file (.vtk)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["vtk"]
    }

    fn flavours(&self) -> &'static [&'static dyn Format] {
        &[&Legacy42]
    }

    fn recognizes_start(&self, head: &[u8]) -> bool {
        let start = head.trim_ascii_start();
        start
            .get(..14)
            .is_some_and(|start| start.eq_ignore_ascii_case(b"# vtk DataFile"))
    }

    fn list_ending(&self) -> Option<&'static str> {
        Some("vtk.series")
    }

    fn holds_arrays(&self) -> bool {
        true
    }

    fn version(&self, head: &[u8]) -> Option<String> {
        super::word_after(head, b"Version")
    }

    fn read_file(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes(), options, notes)
    }

    fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Notes> {
        write::write(mesh, out, options, write::Version::V51)
    }
}

impl Format for Legacy42 {
    fn name(&self) -> &'static str {
        "vtk42"
    }

    fn title(&self) -> &'static str {
        "VTK legacy file of version 4.2 (.vtk)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["vtk"]
    }

    fn recognizes_start(&self, head: &[u8]) -> bool {
        Legacy.recognizes_start(head)
    }

    fn list_ending(&self) -> Option<&'static str> {
        Some("vtk.series")
    }

    fn holds_arrays(&self) -> bool {
        true
    }

    fn read_file(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        Legacy.read_file(source, options, notes)
    }

    fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Write,
        options: &WriteOptions,
    ) -> Result<Notes> {
        write::write(mesh, out, options, write::Version::V42)
    }
}

#[cfg(test)]
mod tests;
