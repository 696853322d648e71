//! Fluent's mesh and case files, read: `.msh` and `.cas` (text and binary sections), and `.msh.h5` and `.cas.h5`.
//!
//! Cells are made from their faces. Zones of cells are zones, zones of faces on the boundary are tags.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! let mesh = Mesh::read("testdata/fluent/house.msh")?;
//! let zones: Vec<_> = mesh.zones().map(|zone| zone.name.as_str()).collect();
//! assert_eq!(zones, ["room", "roof"]);
//! let tags: Vec<_> = mesh.tags().map(|tag| (tag.name.as_str(), tag.cells.len())).collect();
//! assert_eq!(tags, [("sides", 4), ("floor", 1), ("tiles", 4)]);
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! sections   files of sections -> content; numbers: nodes and faces of a section, text or binary
//! cff        HDF5 -> content
//! content    contents of all these files: nodes, zones of faces with their two cells, zones of cells, their types
//! join       faces of all zones as one list, without those that were refined
//! assemble   content -> a mesh, its cells by `by_faces` in 3D and by their edges in 2D
//! ```

mod assemble;
mod cff;
mod content;
mod join;
mod numbers;
mod sections;

use super::Format;

/// Fluent's files, which are read and not written.
pub static FLUENT: Format = Format {
    name: "fluent",
    title: "Fluent mesh or case (.msh, .cas, .msh.h5, .cas.h5)",
    extensions: &["cas", "cas.h5", "msh.h5"],
    lists_faces_again: false,
    detect: |source| is_text(source.bytes()) || cff::is_of_fluent(source),
    title_of: Some(|head| {
        let storage = if is_text(head) { "" } else { " in HDF5" };
        format!("Fluent mesh or case{storage}")
    }),
    read: |source, _, notes| {
        let content = if super::hdf5::is_hdf5(source.bytes()) {
            cff::read(source, notes)?
        } else {
            sections::read(source.bytes(), notes)?
        };
        assemble::mesh(content, source.bytes(), notes).map_err(|error| error.dataset("faces"))
    },
    ..Format::NEW
};

/// Returns whether a file starts with a section: a parenthesis and the index of one that comes first, then a blank, a
/// parenthesis or a string.
fn is_text(head: &[u8]) -> bool {
    let Some(rest) = head.trim_ascii_start().strip_prefix(b"(") else {
        return false;
    };
    let rest = rest.trim_ascii_start();
    let n = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let is_index = (1..=4).contains(&n);
    let is_behind = |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, b'(' | b'"');
    is_index && rest.get(n).is_some_and(is_behind)
}

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod tests;
