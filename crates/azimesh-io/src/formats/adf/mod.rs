//! ADF files, in which CGNS was stored before HDF5: nodes with a name, a label, data and children, and links to nodes of
//! the same or of other files. Reads; the meaning of nodes is left to CGNS.
//!
//! ```text
//! file     header, tags, pointers, and who owns which part: a file is read in place
//! node     name, label, children
//! links    nodes of the same and of other files that a node stands for
//! data     types, dimensions, and values in the byte order of this machine
//! ```
//!
//! All that a file holds is behind a tag of four letters, most of it with another one at its end. Counts are
//! hexadecimal text. A pointer is a block of 4096 bytes and an offset in it: as text in files of version A, in binary in
//! version B, which has the dimensions of data in binary too.

mod data;
mod file;
mod links;
mod node;

#[cfg(test)]
pub(super) mod fixture;

pub(super) use self::{data::Data, node::Node};

/// The text behind the first four bytes of an ADF file.
pub(super) const NAME: &[u8] = b"ADF Database";

/// Tests if a file starts as these do: four bytes of any kind, then the name of the format.
pub(super) fn is_adf(head: &[u8]) -> bool {
    head.get(4..16) == Some(NAME)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
