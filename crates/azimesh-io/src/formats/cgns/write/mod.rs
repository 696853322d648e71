//! A mesh as a CGNS file: one base, one zone, a section for each run of cells of one type.
//!
//! ```text
//! plan      which cells make up which section, and the numbers of their elements
//! sections  connectivity; faces of polyhedra, each once
//! groups    boundary conditions, subregions, families; arrays: of solutions and of the mesh as a whole
//! sequence  steps in one file; series: arrays that change
//! draft     nodes with name, label and data -> HDF5
//! ```

mod arrays;
mod draft;
mod faces;
mod groups;
mod plan;
mod sections;
pub(super) mod sequence;
mod series;

use super::super::{Precision, WriteOptions};
use super::{CELL_ORDER, FromAdf};
use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Id, Tree};
use crate::formats::names::{Rule, UniqueNames, cut};
use crate::formats::{Notes, Out};
use crate::mesh::{Coordinates, MeshView};
use arrays::{AT_CELLS, AT_NODES, OF_MESH};
use azimesh_core::error::Result;
use azimesh_core::{Note, note};
use draft::Draft;
use faces::FaceTable;
use plan::Numbering;
pub(super) use plan::other_order;
pub(in crate::formats) use sections::{list_elements, list_mixed};

/// Version of CGNS that is written: the first in which polygons have start offsets.
const VERSION: f32 = 3.4;
/// The base, and the type of its data.
const BASE: draft::Name = ("Base", "CGNSBase_t");
const BASE_DATA: Element = Element::Int32;
/// The zone.
const ZONE: draft::Name = ("Zone", "Zone_t");
/// Name of the node with the times of a sequence.
const TIMES: &str = "TimeIterValues";
/// Name of the node that declares a sequence to be one in time.
const SIMULATION: &str = "SimulationType";
/// Units of numbers: mesh units.
const UNITS: &str = "NormalizedByUnknownDimensional";
/// Nodes whose coordinates are gathered at a time.
const BLOCK: usize = 1 << 18;
/// Bytes of the longest name.
const LONGEST: usize = 32;

/// The rule for names in CGNS.
const RULE: Rule = Rule {
    longest: LONGEST,
    fit: fitting,
    why: "names in CGNS have at most 32 characters of ASCII and no slash",
};

/// The start of a name, without what CGNS does not take.
fn fitting(name: &str, longest: usize) -> String {
    let is_allowed = |c: char| c != '/' && (c == ' ' || c.is_ascii_graphic());
    let fitting = name.trim().replace(|c| !is_allowed(c), "_");
    match cut(&fitting, longest).trim_end() {
        "" => "unnamed".to_owned(),
        "." | ".." => "_".to_owned(),
        fitting => fitting.to_owned(),
    }
}

/// Writes the mesh; returns a note for each thing that is not in the file.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Out, options: &WriteOptions) -> Result<Notes> {
    let from_adf = mesh.origin.get::<FromAdf>();
    let flattened = options.check_coordinates(mesh)?;
    let sorted = plan::sorted(mesh)?;
    let sorted_view = sorted.as_ref().map(|sorted| sorted.view());
    let mesh = sorted_view.as_ref().unwrap_or(mesh);
    let numbering = Numbering::of(mesh);
    let faces = FaceTable::of(mesh, &numbering);
    let is_flat = || mesh.points.iter().all(|point| point[2] == 0.0);
    let mut fixed = Static::new(mesh, (&numbering, &faces), is_flat)?;
    let (draft, zone) = (&mut fixed.draft, fixed.zone);
    let grid = draft.group(zone, ("GridCoordinates", "GridCoordinates_t"));
    add_coordinates(draft, grid, mesh, options, fixed.n_axes);
    let mut notes = fixed.notes;
    notes.extend(flattened);
    notes.extend(from_adf.map(|_| hdf5_for_adf()));
    notes.extend(sorted.iter().map(|_| cells_by_type()));
    let [of_mesh, at_nodes, at_cells] = arrays::all(mesh, &mut notes);
    for (parent, kind, arrays) in [
        (fixed.base, OF_MESH, of_mesh),
        (zone, AT_NODES, at_nodes),
        (zone, AT_CELLS, at_cells),
    ] {
        arrays::add(draft, parent, (kind.name, &kind), arrays);
    }
    draft.tree.write(out)?;
    Ok(notes)
}

/// Writes all but coordinates, solutions and field arrays.
struct Static<'a> {
    draft: Draft<'a>,
    base: Id,
    zone: Id,
    /// Type of indices and counts.
    integer: Element,
    /// Coordinates that nodes have.
    n_axes: usize,
    notes: Notes,
}

impl<'a> Static<'a> {
    /// Of a mesh; `is_flat` finds whether all nodes are in the plane z = 0, for cells of less than three dimensions.
    fn new(
        mesh: &'a MeshView<'a>,
        (numbering, faces): (&Numbering, &'a FaceTable),
        is_flat: impl FnOnce() -> bool,
    ) -> Result<Self> {
        let mut notes = Notes::default();
        let dimension = mesh.dimension().max(1);
        let n_axes = if dimension < 3 && is_flat() { 2 } else { 3 };
        let own = "ZoneType GridCoordinates ZoneBC ZoneGridConnectivity ZoneIterativeData \
            ArbitraryGridMotion";
        let of_arrays = [AT_NODES.name, AT_CELLS.name, CELL_ORDER];
        let mut names = UniqueNames::with(own.split(' ').chain(of_arrays));
        let mut sections = plan::sections(mesh, &mut names)?;
        // VTK's reader expects the sections of cells first in the file as well.
        sections.sort_by_key(|section| numbering.element(section.cells.start));
        let entries = mesh.cells.connectivity().len() + mesh.cells.len() + faces.nodes.len();
        let last_face = faces.first_element + faces.len();
        let integer = draft::integers_for(entries.max(mesh.points.len()).max(last_face));
        let mut draft = Draft::marked_root();
        let name = ("CGNSLibraryVersion", "CGNSLibraryVersion_t");
        draft.data(
            Tree::ROOT,
            name,
            (Element::Float32, &[1]),
            Data::owned(&[VERSION]),
        );
        let sizes = [i64::from(dimension), n_axes as i64];
        let base = draft.integers(Tree::ROOT, BASE, (BASE_DATA, &[2]), &sizes);
        draft.text(base, ("DataClass", "DataClass_t"), UNITS);
        let n_cells: usize = mesh.volume_runs().map(|run| run.n_cells()).sum();
        let n_cells = if mesh.dimension() == 0 { 0 } else { n_cells };
        let sizes = [mesh.points.len() as i64, n_cells as i64, 0];
        let zone = draft.integers(base, ZONE, (integer, &[1, 3]), &sizes);
        draft.text(zone, ("ZoneType", "ZoneType_t"), "Unstructured");
        for section in &sections {
            let first = numbering.element(section.cells.start);
            sections::add(&mut draft, zone, (section, first), mesh, faces, integer);
        }
        if !numbering.is_order_of_cells() {
            // The first cell of each section, so that cells come back in the order of the mesh.
            let first = sections.iter().map(|section| section.cells.start as i64);
            let first: Vec<i64> = first.collect();
            let order = draft.group(zone, (CELL_ORDER, "UserDefinedData_t"));
            let list = (integer, &[first.len() as u64][..]);
            draft.integers(order, ("FirstCell", "DataArray_t"), list, &first);
        }
        if faces.len() > 0 {
            let name = names.give("NGON_n", &RULE);
            sections::add_faces(&mut draft, zone, &name, faces, integer);
        }
        let to = (&mut draft, base, zone);
        groups::add(to, mesh, &mut names, (numbering, integer), &mut notes);
        arrays::note_boundary_values(mesh, &mut notes);
        Ok(Self {
            draft,
            base,
            zone,
            integer,
            n_axes,
            notes,
        })
    }
}

/// Adds the arrays of coordinates, which are lengths, to a grid.
fn add_coordinates<'a>(
    draft: &mut Draft<'a>,
    grid: Id,
    mesh: &'a MeshView<'a>,
    options: &WriteOptions,
    n_axes: usize,
) {
    let names = ["CoordinateX", "CoordinateY", "CoordinateZ"];
    let is_single = options.precision == Precision::F32;
    let element = if is_single {
        Element::Float32
    } else {
        Element::Float64
    };
    let points = mesh.points;
    for (axis, name) in names.into_iter().enumerate().take(n_axes) {
        let numbers = Coordinates::new(Some(axis), is_single);
        let data = match mesh.coordinates_apart(numbers) {
            Some(numbers) => Data::Remote(numbers),
            None => Data::made(move |sink| {
                let mut bytes = Vec::new();
                for block in points.chunks(BLOCK) {
                    bytes.clear();
                    numbers.append(block, &mut bytes);
                    sink(&bytes)?;
                }
                Ok(())
            }),
        };
        let kind = (element, &[points.len() as u64][..]);
        let node = draft.data(grid, (name, "DataArray_t"), kind, data);
        let exponents = Data::owned(&[0.0, 1.0, 0.0, 0.0, 0.0]);
        let name = ("DimensionalExponents", "DimensionalExponents_t");
        draft.data(node, name, (Element::Float64, &[5]), exponents);
    }
}

/// Notes a mesh of an ADF file, written as CGNS.
fn hdf5_for_adf() -> Note {
    note!(
        "hdf5_for_adf",
        "the mesh was read from a CGNS file in ADF and is written in HDF5; hdf2adf, a tool of CGNS, makes ADF of it"
    )
}

/// Notes cells in the order of their types.
fn cells_by_type() -> Note {
    note!(
        "cells_by_type",
        "cells are written in the order of their types and tags, which takes fewer sections than their own order"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_stay_unique() {
        let mut names = UniqueNames::default();
        let long = "a boundary with a name of more than 32 bytes";
        let mut give = |name: &str| names.give(name, &RULE);
        assert_eq!(give("hub"), "hub");
        assert_eq!(give(long), "a boundary with a name of more t");
        assert_eq!(give(long), "a boundary with a name of more_2");
        assert_eq!(give("a/b"), "a_b");
        assert_eq!(give("a_b"), "a_b_2");
        assert_eq!(give("a_b_3"), "a_b_3");
        assert_eq!(give("a_b"), "a_b_4");
        assert_eq!(give("  "), "unnamed");
        assert_eq!(give("Fläche é"), "Fl_che _");
        assert_eq!(give("Flüche è"), "Fl_che __2");
    }
}
