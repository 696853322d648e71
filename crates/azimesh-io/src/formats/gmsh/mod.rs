//! Gmsh MSH: reads versions 1, 2, 4.0 and 4.1, writes 2.2 and 4.1, as text and binary.
//!
//! Physical groups are the groups of the mesh. If boundary elements exist but no physical group of their
//! dimension, their elementary entities become the tags, named by number.
//! Values at nodes and elements are arrays of the mesh.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let path = folder.path().join("cylinder.msh22");
//!
//! let mesh = Mesh::read("testdata/gmsh/cylinder_v41.msh")?;
//! let zones: Vec<_> = mesh.zones().map(|zone| zone.name.as_str()).collect();
//! assert_eq!(zones, ["air in it"]);
//! // A physical group has a number, and mostly a name.
//! let tags: Vec<_> = mesh.tags().map(|tag| (tag.name.as_str(), tag.number)).collect();
//! assert_eq!(tags, [("outer wall", Some(7)), ("both", Some(9)), ("8", Some(8))]);
//!
//! mesh.write(&path)?; // `.msh22` is version 2.2, `.msh` is version 4.1.
//! assert_eq!(Mesh::read(&path)?.tags().count(), 3);
//! # Ok(())
//! # }
//! ```

mod content;
mod data;
mod elements;
mod groups;
mod index;
mod kinds;
mod nodes;
mod read;
mod slabs;
mod stream;
mod write;

pub(super) use index::Index;

use super::slabs::opened;
use super::{Format, Holds};

/// Gmsh MSH, written in version 4.1 (.msh).
pub static MSH41: Format = Format {
    name: "msh",
    title: "Gmsh MSH 4.1 (.msh)",
    extensions: &["msh", "msh4"],
    write: Some(|mesh, out, options| write::write(mesh, out, options, true)),
    ..MSH
};

/// Gmsh MSH, written in version 2.2 (.msh2).
pub static MSH22: Format = Format {
    name: "msh22",
    title: "Gmsh MSH 2.2 (.msh2)",
    extensions: &["msh2", "msh22"],
    write: Some(|mesh, out, options| write::write(mesh, out, options, false)),
    ..MSH
};

/// Every version is read.
const MSH: Format = Format {
    holds: Holds::ARRAYS,
    detect: |source| is_msh(source.bytes()),
    title_of: Some(title_of),
    version,
    read: |source, options, notes| read::read(source.bytes(), options, notes),
    steps: |source| read::steps(source.bytes()),
    slabs: Some(|source, options| opened(slabs::open(source.bytes(), options))),
    ..Format::NEW
};

/// The title of a file, by whether it is text or binary: `$MeshFormat` is followed by the version and a 1 for binary.
fn title_of(head: &[u8]) -> String {
    let start = memchr::memmem::find(&head[..head.len().min(HEADER_BYTES)], b"$MeshFormat");
    let is_binary = start.is_some_and(|start| {
        let mut words = head[start..].split(u8::is_ascii_whitespace);
        words.by_ref().filter(|word| !word.is_empty()).nth(2) == Some(b"1")
    });
    let form = if is_binary { "binary" } else { "text" };
    format!("Gmsh MSH, {form} (.msh)")
}

/// The version in the header of a file; version 1 has no header.
fn version(head: &[u8]) -> Option<String> {
    let is_first = || head.trim_ascii_start().starts_with(b"$NOD");
    super::word_after(head, b"$MeshFormat").or_else(|| is_first().then(|| "1".to_owned()))
}

/// Bytes in which the header of a file is looked for.
const HEADER_BYTES: usize = 4096;

/// Checks if a file starts as one of Gmsh does; `$NOD` starts version 1.
fn is_msh(head: &[u8]) -> bool {
    let starts: [&[u8]; 3] = [b"$MeshFormat", b"$Comments", b"$NOD"];
    let head = head.trim_ascii_start();
    starts.iter().any(|start| head.starts_with(start))
}

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod tests;
