//! VTK XML unstructured grids (.vtu).
//!
//! Reads every way in which VTK stores numbers and writes the ones that [`WriteOptions`](crate::WriteOptions) names.
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
//! xml     elements and arrays; document: which arrays there are
//! stored  stored values of one array -> bytes: text, base64, raw, compressed blocks
//! read    arrays -> mesh; values: coordinates and data; cells: types, offsets, connectivity
//! slabs   some nodes and cells of a file of raw values
//! write   mesh -> file; polydata: surfaces (.vtp)
//! ```

mod cells;
mod document;
mod polydata;
pub(super) mod read;
mod slabs;
mod stored;
mod values;
mod write;
pub(super) mod xml;

pub use polydata::VTP;

pub use write::NAMES;
pub(super) use write::{escaped, is_xml};

use super::slabs::opened;
use super::vtk::tags;
use super::{Compression, Encoding, Format, Holds, Precision};

/// VTK XML unstructured grid (.vtu).
pub static VTU: Format = Format {
    name: "vtu",
    title: "VTK XML unstructured grid (.vtu)",
    extensions: &["vtu"],
    // Any VTK XML file; the reader refuses other grids with their names.
    detect: |source| start_of_xml(source.bytes()).is_some(),
    slabs: Some(|source, options| opened(slabs::open(source.bytes(), options))),
    write: Some(write::write),
    takes_numbers_apart: |options| {
        options.encoding == Encoding::Raw && options.compression == Compression::None
    },
    takes_cells_apart: |mesh| !tags::has_repeated(mesh),
    ..XML
};

/// Shared parts of the XML files of VTK.
const XML: Format = Format {
    holds: Holds::NAMED_ARRAYS,
    encodings: &[Encoding::Raw, Encoding::Base64, Encoding::Ascii],
    precisions: &[Precision::F64, Precision::F32],
    compresses: true,
    version,
    read: |source, options, notes| read::read(source.bytes(), options, notes),
    steps: |source| document::times(source.bytes()),
    ..Format::NEW
};

/// The first bytes of a file of VTK in XML, from its root element on.
fn start_of_xml(head: &[u8]) -> Option<&[u8]> {
    let head = &head[..head.len().min(4096)];
    memchr::memmem::find(head, b"<VTKFile").map(|at| &head[at..])
}

fn version(head: &[u8]) -> Option<String> {
    // An XML declaration before it also has a version.
    super::word_after(start_of_xml(head)?, b" version=\"")
}

#[cfg(test)]
mod tests;
