//! VTK XML unstructured grids (.vtu).
//!
//! Reads every way in which VTK stores numbers and writes the ones that [`WriteOptions`] names.
//! Boundary tags and zones are integer cell arrays; their names are in string arrays (see `vtk::tags`).
//!
//! ```
//! use azimesh_io::{Compression, DataArray, Mesh, Values, WriteOptions};
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("heights.vtu");
//!
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! let heights = mesh.points.iter().map(|point| point[1]).collect();
//! let heights = DataArray::scalar("height", Values::F64(heights));
//!
//! let options = WriteOptions { compression: Compression::Lz4, ..WriteOptions::default() };
//! mesh.view().with_point_array(&heights).write_with(&path, &options)?;
//!
//! let read = Mesh::read(&path)?;
//! assert!(read.point_arrays.contains(&heights));
//! assert_eq!(read.groups, mesh.groups);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! xml     elements, and where the values of an array lie; document: which arrays there are
//! stored  stored values of one array -> bytes: text, base64, raw; blocks: compressed ones
//! read    arrays -> nodes; arrays: values; cells: types, offsets, connectivity; structured: blocks
//! slabs   some nodes and cells of a file of raw values
//! write   mesh -> file; encode: one array as text, base64, blocks
//! file    list of arrays -> XML and values; polydata: surfaces (.vtp)
//! ```

mod aligner;
mod arrays;
mod blocks;
mod cells;
mod collect;
mod document;
mod encode;
mod file;
mod polydata;
pub(super) mod read;
mod slabs;
mod stored;
mod structured;
mod write;
pub(super) mod xml;

pub use polydata::Vtp;

pub use file::NAMES;
pub(super) use file::{escaped, is_xml};

use super::slabs::{Opened, opened};
use super::vtk::tags;
use super::{Compression, Encoding, Format, Notes, ReadOptions, Source, WriteOptions};
use crate::formats::Out;
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::Result;

/// VTK XML unstructured grid (.vtu).
pub struct Vtu;

impl Format for Vtu {
    fn name(&self) -> &'static str {
        "vtu"
    }

    fn title(&self) -> &'static str {
        "VTK XML unstructured grid (.vtu)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["vtu"]
    }

    /// Any VTK XML file; the reader refuses other grids with their names.
    fn recognizes_start(&self, head: &[u8]) -> bool {
        let head = &head[..head.len().min(4096)];
        memchr::memmem::find(head, b"<VTKFile").is_some()
    }

    fn encodings(&self) -> &'static [Encoding] {
        &[Encoding::Raw, Encoding::Base64, Encoding::Ascii]
    }

    fn compresses(&self) -> bool {
        true
    }

    fn has_tag_names(&self) -> bool {
        true
    }

    fn holds_arrays(&self) -> bool {
        true
    }

    fn version(&self, head: &[u8]) -> Option<String> {
        // An XML declaration before it also has a version.
        let start = memchr::memmem::find(&head[..head.len().min(4096)], b"<VTKFile")?;
        super::word_after(&head[start..], b" version=\"")
    }

    fn read_file(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source.bytes(), options, notes)
    }

    fn slabs<'a>(&self, source: &'a Source, options: &ReadOptions) -> Result<Opened<'a>> {
        opened(slabs::open(source.bytes(), options))
    }

    fn takes_numbers_apart(&self, options: &WriteOptions) -> bool {
        options.encoding == Encoding::Raw && options.compression == Compression::None
    }

    fn takes_cells_apart(&self, mesh: &MeshView) -> bool {
        !tags::has_repeated(mesh)
    }

    fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Out,
        options: &WriteOptions,
    ) -> Result<Notes> {
        write::write(mesh, out, options)
    }
}

#[cfg(test)]
mod tests;
