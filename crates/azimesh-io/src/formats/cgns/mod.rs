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
//! node          names, labels, data, children, in HDF5 and in ADF
//! read          all zones -> mesh; zone: one zone's sizes and nodes; time: steps of a sequence
//! slabs         some nodes and cells of unstructured zones
//! unstructured  sections, polyhedra -> cells; regions -> groups
//! structured    index ranges -> cells, faces
//! solution      arrays of all zones
//! builder       nodes, cells, groups and arrays so far
//! element       element types and their node order; lattice: of third and fourth order
//! ```

mod builder;
mod element;
mod lattice;
mod node;
mod polyhedra;
mod read;
mod regions;
mod sections;
mod slabs;
mod solution;
mod structured;
mod time;
mod unstructured;
mod write;
mod zone;

use super::adf::is_adf;
use super::hdf5::is_hdf5;
use super::slabs::opened;
use super::{Encoding, Format, Holds, Precision};
pub(super) use element::permute;
pub(super) use write::{list_elements, list_mixed};

/// Name of the node that holds a name in full which is too long for CGNS.
const FULL_NAME: &str = "FullName";

/// Name of the node that holds arrays of the mesh as a whole.
const FIELD_ARRAYS: &str = "FieldArrays";

/// Name of the node of a zone with the first cell of each section, in the order of the elements.
const CELL_ORDER: &str = "CellOrder";

/// Name of the list of these nodes, one for each step of a sequence.
const FIELD_POINTERS: &str = "FieldArraysPointers";

/// Mark of a mesh that was read from an ADF file, for the writer.
struct FromAdf;

/// CGNS (.cgns); written in HDF5.
pub static CGNS: Format = Format {
    name: "cgns",
    title: "CGNS (.cgns)",
    extensions: &["cgns"],
    holds: Holds::ARRAYS,
    encodings: &[Encoding::Raw],
    precisions: &[Precision::F64, Precision::F32],
    detect: |source| {
        let bytes = source.bytes();
        is_adf(bytes) || (is_hdf5(bytes) && node::has_bases(source))
    },
    title_of: Some(|head| {
        let title = match (is_adf(head), is_hdf5(head)) {
            (true, _) => "CGNS in ADF (.cgns)",
            (_, true) => "CGNS in HDF5 (.cgns)",
            _ => "CGNS (.cgns)",
        };
        title.to_owned()
    }),
    read: read::read,
    steps: |source| {
        time::times(&node::Node::root(source)?.0).map_err(|error| error.file(source.path()))
    },
    slabs: Some(|source, options| opened(slabs::open(source, options))),
    write: Some(write::write),
    sequence: Some(|path, options, begin, sync| {
        let file = write::sequence::Sequence::create(path, options, begin, sync)?;
        Ok(Box::new(file))
    }),
    takes_numbers_apart: |_| true,
    // Arrays at cells need a check for values on boundary faces, which needs the values of all ranks.
    takes_cells_apart: |mesh| {
        matches!(write::other_order(mesh), Ok(None)) && mesh.cell_arrays.is_empty()
    },
    ..Format::NEW
};

#[cfg(test)]
mod tests;
