//! CGNS files (.cgns) in HDF5.
//!
//! ```text
//! node          names, labels, data, children; links
//! read          all zones -> mesh; zone: one zone's sizes and nodes; time: steps of a sequence
//! unstructured  sections, polyhedra -> cells; regions -> groups; exterior: faces the file lacks
//! structured    index ranges -> cells, faces
//! families, tags, arrays, solution: names of groups; groups; arrays of all zones
//! element       element types and their node order; lattice: of third and fourth order
//! ```

mod arrays;
mod element;
mod exterior;
mod families;
mod lattice;
mod node;
mod polyhedra;
mod read;
mod regions;
mod sections;
mod solution;
mod structured;
mod tags;
mod time;
mod unstructured;
mod zone;

use super::{Format, Notes, ReadOptions, Source, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::Write;

/// Name of the node that holds a name in full which is too long for CGNS.
const FULL_NAME: &str = "FullName";

/// CGNS in HDF5 (.cgns).
pub struct Cgns;

impl Format for Cgns {
    fn name(&self) -> &'static str {
        "cgns"
    }

    fn title(&self) -> &'static str {
        "CGNS (.cgns)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["cgns"]
    }

    /// An HDF5 file that speaks of CGNS near its start or end, or a file in the old ADF format, of
    /// which the reader says how to convert it.
    fn recognizes(&self, head: &[u8]) -> bool {
        const NEAR: usize = 1 << 20;
        let start = &head[..head.len().min(NEAR)];
        let end = &head[head.len().saturating_sub(NEAR)..];
        let speaks = |bytes| memchr::memmem::find(bytes, b"CGNSLibraryVersion").is_some();
        head.starts_with(b"@(#)ADF Database")
            || (head.starts_with(b"\x89HDF\r\n\x1a\n") && (speaks(start) || speaks(end)))
    }

    fn read(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source, options, notes)
    }

    fn steps(&self, source: &Source) -> Result<Vec<f64>> {
        time::times(&node::Node::root(source)?).map_err(|error| error.file(source.path()))
    }

    fn write(
        &self,
        _mesh: &Mesh,
        _out: &mut dyn Write,
        _options: &WriteOptions,
    ) -> Result<Vec<String>> {
        Err(Error::input("CGNS is not written"))
    }
}
