//! CGNS files (.cgns), in HDF5 and in the older ADF.
//!
//! Reads all zones of all bases, structured ones too, as one mesh, and any step of a sequence. Boundary conditions are
//! tags with a condition; zones and their families are zones. Writes HDF5, one mesh or a sequence, in one zone.
//!
//! ```
//! use azimesh_io::Mesh;
//! # fn main() -> azimesh_io::Result<()> {
//! let mesh = Mesh::read("testdata/cgns/two_bases.cgns")?;
//! // Two zones of the same name: the second has the name of its base in front.
//! let zones: Vec<_> = mesh.zones().map(|zone| zone.name.as_str()).collect();
//! assert_eq!(zones, ["Zone", "Right/Zone"]);
//!
//! let wall = mesh.tags().next().expect("a boundary condition");
//! assert_eq!(wall.name, "wall");
//! assert_eq!(wall.condition.as_deref(), Some("BCWall"));
//! # Ok(())
//! # }
//! ```
//!
//! Parts of the module:
//!
//! ```text
//! node          names, labels, data, children; stored: the same in HDF5 and in ADF, links followed
//! read          all zones -> mesh; zone: one zone's sizes and nodes; time: steps of a sequence
//! slabs         some nodes and cells of unstructured zones
//! unstructured  sections, polyhedra -> cells; regions, node_set -> groups; exterior: faces the file lacks
//! structured    index ranges -> cells, faces
//! families, tags, arrays, solution: names of groups; groups; arrays of all zones
//! element       element types and their node order; lattice: of third and fourth order
//! ```

mod arrays;
mod builder;
mod element;
mod families;
mod lattice;
mod node;
mod node_set;
mod polyhedra;
mod read;
mod regions;
mod sections;
mod slabs;
mod solution;
mod stored;
mod structured;
mod tags;
mod time;
mod unstructured;
mod write;
mod zone;

use super::adf::is_adf;
use super::hdf5::is_hdf5;
use super::slabs::{Opened, opened};
use super::{
    CreateSequence, Encoding, Format, Notes, ReadOptions, Source, StepBytes, StepSize, WriteOptions,
};
use crate::formats::Out;
use crate::mesh::{Mesh, MeshView};
use azimesh_core::error::Result;
pub(super) use write::{list_elements, list_mixed};

/// Name of the node that holds a name in full which is too long for CGNS.
const FULL_NAME: &str = "FullName";

/// Name of the node that holds arrays of the mesh as a whole.
const FIELD_ARRAYS: &str = "FieldArrays";

/// Name of the node of a zone with the first cell of each section, in the order of the elements.
const CELL_ORDER: &str = "CellOrder";

/// Name of the list of these nodes, one for each step of a sequence.
const FIELD_POINTERS: &str = "FieldArraysPointers";

/// What the reader leaves for the writer: that the file was in ADF.
struct FromAdf;

/// CGNS (.cgns); written in HDF5.
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

    fn title_of(&self, head: &[u8]) -> String {
        match (is_adf(head), is_hdf5(head)) {
            (true, _) => "CGNS in ADF (.cgns)".to_owned(),
            (_, true) => "CGNS in HDF5 (.cgns)".to_owned(),
            _ => self.title().to_owned(),
        }
    }

    /// The start of an ADF file; that of an HDF5 file does not tell its format.
    fn recognizes_start(&self, head: &[u8]) -> bool {
        is_adf(head)
    }

    fn recognizes_file(&self, source: &Source) -> bool {
        self.recognizes_start(source.bytes())
            || (is_hdf5(source.bytes()) && node::has_bases(source))
    }

    fn read_file(&self, source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
        read::read(source, options, notes)
    }

    fn slabs<'a>(&self, source: &'a Source, options: &ReadOptions) -> Result<Opened<'a>> {
        opened(slabs::open(source, options))
    }

    fn steps_of_file(&self, source: &Source) -> Result<Vec<f64>> {
        time::times(&node::Node::root(source)?.0).map_err(|error| error.file(source.path()))
    }

    fn takes_numbers_apart(&self, _: &WriteOptions) -> bool {
        true
    }

    fn takes_cells_apart(&self, mesh: &MeshView) -> bool {
        // Of arrays at cells it is told which have values on faces that their cells do not have.
        matches!(write::other_order(mesh), Ok(None)) && mesh.cell_arrays.is_empty()
    }

    fn write_file(
        &self,
        mesh: &MeshView,
        out: &mut dyn Out,
        options: &WriteOptions,
    ) -> Result<Notes> {
        write::write(mesh, out, options)
    }

    fn encodings(&self) -> &'static [Encoding] {
        &[Encoding::Raw]
    }

    fn holds_arrays(&self) -> bool {
        true
    }

    fn sequence(&self) -> Option<CreateSequence> {
        use write::sequence::Sequence;
        Some(|path, options, begin, sync| {
            Ok(Box::new(Sequence::create(path, options, begin, sync)?))
        })
    }

    fn sequence_bytes(&self, step: &StepSize) -> StepBytes {
        write::sequence::step_bytes(step)
    }
}

#[cfg(test)]
mod tests;
