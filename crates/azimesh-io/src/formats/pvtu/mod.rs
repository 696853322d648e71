//! VTK XML grids in several files (.pvtu): pieces that are read into one mesh, and a mesh cut into
//! pieces.
//!
//! Reading leaves out ghost cells and joins the nodes that pieces share.
//!
//! ```
//! use azimesh_io::{Mesh, WriteOptions};
//! use std::num::NonZeroUsize;
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("airfoil.pvtu");
//!
//! let mesh = Mesh::read("testdata/naca0012.vtu")?;
//! let options = WriteOptions { pieces: NonZeroUsize::new(4), ..WriteOptions::default() };
//! mesh.view().write_with(&path, &options)?;
//! assert!(path.with_file_name("airfoil").join("airfoil_3.vtu").exists());
//!
//! // The pieces have global numbers of nodes and cells: the mesh has its order again.
//! let read = Mesh::read(&path)?;
//! assert_eq!(read.points, mesh.points);
//! assert_eq!(read.cells, mesh.cells);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! read     the list of pieces -> their meshes
//! ghosts   cells that a piece only shows for its neighbour, left out
//! merge    nodes that pieces share -> one mesh
//! subset   some cells of a mesh and their nodes
//! cut      which piece each cell goes to
//! write    pieces and the list of them
//! ```

mod cut;
mod ghosts;
pub mod merge;
mod read;
mod subset;
mod write;

use super::vtu::xml::as_utf8;
use super::{Encoding, Format, Holds, Notes};
use azimesh_core::error::{Error, option};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes in which a file says what it is.
const HEAD: usize = 4096;
/// Point array with the number of each node in the whole mesh.
const NODE_IDS: &str = "GlobalNodeIds";
/// Cell array with the number of each cell in the whole mesh.
const CELL_IDS: &str = "GlobalCellIds";

/// The names of the pieces that a file lists, from its folder; none where it is no list of pieces.
pub(super) fn pieces_of(path: &Path) -> std::io::Result<Vec<String>> {
    let mut head = Vec::new();
    File::open(path)?.take(HEAD as u64).read_to_end(&mut head)?;
    if !is_list(&head) {
        return Ok(Vec::new());
    }
    let bytes = std::fs::read(path)?;
    let text = as_utf8(&bytes, &mut Notes::default());
    Ok(read::piece_names(&text).unwrap_or_default())
}

/// VTK XML grid in several files (.pvtu).
pub static PVTU: Format = Format {
    name: "pvtu",
    title: "VTK XML grid in pieces (.pvtu)",
    extensions: &["pvtu"],
    holds: Holds {
        tag_names: true,
        ..Holds::NOTHING
    },
    is_in_pieces: true,
    encodings: &[Encoding::Raw, Encoding::Base64, Encoding::Ascii],
    compresses: true,
    detect: |source| is_list(source.bytes()),
    read: read::read,
    write_files: Some(|mesh, out, options| {
        let n = options.pieces.ok_or_else(|| {
            let pieces = option("pieces");
            Error::input(format!(
                "a .pvtu lists several files; write it with convert {pieces} N"
            ))
            .file(out.path())
        })?;
        write::write(mesh, n.get(), out, options)
    }),
    ..Format::NEW
};

fn is_list(head: &[u8]) -> bool {
    let head = &head[..head.len().min(HEAD)];
    let finds = |what: &str| memchr::memmem::find(head, what.as_bytes()).is_some();
    finds("<VTKFile") && (finds("\"PUnstructuredGrid\"") || finds("'PUnstructuredGrid'"))
}

#[cfg(test)]
mod tests;
