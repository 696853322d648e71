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

mod attributes;
mod cursor;
mod read;
mod values;
mod write;

use super::{Format, Holds, Precision};
use write::Version;

/// VTK legacy file (.vtk), written in version 5.1.
pub static VTK51: Format = Format {
    name: "vtk",
    title: "VTK legacy file (.vtk)",
    write: Some(|mesh, out, options| write::write(mesh, out, options, Version::V51)),
    ..VTK
};

/// VTK legacy file, written in version 4.2 for older readers.
pub static VTK42: Format = Format {
    name: "vtk42",
    title: "VTK legacy file of version 4.2 (.vtk)",
    write: Some(|mesh, out, options| write::write(mesh, out, options, Version::V42)),
    ..VTK
};

const VTK: Format = Format {
    extensions: &["vtk"],
    holds: Holds::NAMED_ARRAYS,
    precisions: &[Precision::F64, Precision::F32],
    list_ending: Some("vtk.series"),
    detect: |source| {
        let start = source.bytes().trim_ascii_start().get(..14);
        start.is_some_and(|start| start.eq_ignore_ascii_case(b"# vtk DataFile"))
    },
    version: |head| super::word_after(head, b"Version"),
    read: |source, options, notes| read::read(source.bytes(), options, notes),
    ..Format::NEW
};

#[cfg(test)]
mod tests;
