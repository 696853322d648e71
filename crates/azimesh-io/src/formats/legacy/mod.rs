//! VTK's legacy files (.vtk): versions 1.0 to 5.1, text and binary.
//!
//! Reads unstructured grids and polygonal data, and structured grids, rectilinear grids and images
//! as the cells that they imply. Writes unstructured grids of version 5.1 or 4.2.
//!
//! ```
//! use azimesh_io::formats::{Commit, legacy, save};
//! use azimesh_io::{CellKind, Mesh, WriteOptions};
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("block.vtk");
//!
//! let mesh = Mesh::read("testdata/vtk/structured_ascii.vtk")?;
//! assert_eq!(mesh.cells.get(0).kind, CellKind::Hexahedron);
//!
//! // `mesh.write(path)` writes version 5.1. Programs older than VTK 9 read version 4.2.
//! save(&mesh.view(), &path, &legacy::VTK42, &WriteOptions::default(), Commit::REPLACE)?;
//! assert_eq!(Mesh::read(&path)?.cells, mesh.cells);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
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
use crate::formats::Out;
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::Result;
use write::Version;

/// VTK legacy file: reads every version and writes one of them.
pub struct Legacy {
    name: &'static str,
    title: &'static str,
    version: Version,
}

/// VTK legacy file (.vtk), written in version 5.1.
pub static VTK51: Legacy = Legacy {
    name: "vtk",
    title: "VTK legacy file (.vtk)",
    version: Version::V51,
};

/// VTK legacy file, written in version 4.2 for older readers.
pub static VTK42: Legacy = Legacy {
    name: "vtk42",
    title: "VTK legacy file of version 4.2 (.vtk)",
    version: Version::V42,
};

impl Format for Legacy {
    fn name(&self) -> &'static str {
        self.name
    }
    fn title(&self) -> &'static str {
        self.title
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["vtk"]
    }
    fn flavours(&self) -> &'static [&'static dyn Format] {
        static FLAVOURS: [&dyn Format; 1] = [&VTK42];
        &FLAVOURS
    }
    fn recognizes_start(&self, head: &[u8]) -> bool {
        let start = head.trim_ascii_start().get(..14);
        start.is_some_and(|start| start.eq_ignore_ascii_case(b"# vtk DataFile"))
    }
    fn list_ending(&self) -> Option<&'static str> {
        Some("vtk.series")
    }
    fn holds_arrays(&self) -> bool {
        true
    }
    fn has_tag_names(&self) -> bool {
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
        out: &mut dyn Out,
        options: &WriteOptions,
    ) -> Result<Notes> {
        write::write(mesh, out, options, self.version)
    }
}

#[cfg(test)]
mod tests;
