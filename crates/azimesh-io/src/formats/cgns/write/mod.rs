//! A mesh as a CGNS file: one base, one zone, a section for each run of cells of one type.
//!
//! ```text
//! plan      which cells make up which section; numbering: their numbers; names: what CGNS takes for a name
//! sections  connectivity; faces: those of polyhedra, each once
//! groups    boundary conditions, subregions, families; arrays: solutions; fields: of the mesh as a whole
//! sequence  steps in one file; series: arrays that change
//! draft     nodes with name, label and data -> HDF5
//! ```

mod arrays;
mod draft;
mod faces;
mod fields;
mod groups;
mod names;
mod numbering;
mod plan;
mod sections;
pub(super) mod sequence;
mod series;

use super::super::{Precision, WriteOptions};
use super::{CELL_ORDER, FromAdf};
use crate::formats::column::Data;
use crate::formats::{Notes, Out};
use crate::mesh::{Coordinates, MeshView};
use azimesh_core::diagnostic::formats::Written;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
pub(super) use plan::other_order;
pub(in crate::formats) use sections::{list_elements, list_mixed};

use draft::{DataType, Draft, NodeIndex};
use faces::FaceTable;
use names::Names;
use numbering::Numbering;
use plan::Planned;
use std::slice::from_ref;

/// Version of CGNS that is written: the first in which polygons have start offsets.
const VERSION: f32 = 3.4;
/// Name of the zone.
const ZONE: &str = "Zone";
/// Name of the node with the times of a sequence.
const TIMES: &str = "TimeIterValues";
/// Name of the node that declares a sequence to be one in time.
const SIMULATION: &str = "SimulationType";
/// What numbers are measured in: whatever the mesh is.
const UNITS: &str = "NormalizedByUnknownDimensional";
/// Nodes whose coordinates are gathered at a time.
const BLOCK: usize = 1 << 18;

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
    let mut static_part = Static::new(mesh, (&numbering, &faces), is_flat)?;
    let (draft, zone) = (&mut static_part.draft, static_part.zone);
    let grid = draft.group(zone, "GridCoordinates", "GridCoordinates_t");
    add_coordinates(draft, grid, mesh, options, static_part.n_axes);
    let mut notes = static_part.notes;
    notes.extend(flattened);
    notes.extend(from_adf.map(|_| Written::Hdf5ForAdf));
    notes.extend(sorted.iter().map(|_| Written::CellsByType));
    fields::add(draft, static_part.base, &mesh.field_arrays, &mut notes);
    let everywhere = 0..mesh.points.len();
    let at_nodes = arrays::scalars(mesh, &mesh.point_arrays, from_ref(&everywhere), &mut notes);
    add_solution(draft, zone, (arrays::AT_NODES, "Vertex"), &at_nodes);
    let cells = arrays::volume_cells(mesh);
    let at_cells = arrays::scalars(mesh, &mesh.cell_arrays, &cells, &mut notes);
    add_solution(draft, zone, (arrays::AT_CELLS, "CellCenter"), &at_cells);
    draft.tree().write(out)?;
    Ok(notes)
}

fn add_solution<'a>(
    draft: &mut Draft<'a>,
    zone: NodeIndex,
    (name, location): (&str, &str),
    scalars: &[arrays::Scalar<'a>],
) {
    if scalars.is_empty() {
        return;
    }
    let solution = draft.group(zone, name, "FlowSolution_t");
    draft.text(solution, "GridLocation", "GridLocation_t", location);
    for scalar in scalars {
        scalar.add(draft, solution);
    }
}

/// Writes all but coordinates, solutions and field arrays.
struct Static<'a> {
    draft: Draft<'a>,
    base: NodeIndex,
    zone: NodeIndex,
    /// Coordinates that nodes have.
    n_axes: usize,
    notes: Notes,
}

impl<'a> Static<'a> {
    /// Of a mesh; `is_flat` tells whether all nodes of one of less than three dimensions lie in the plane z = 0.
    fn new(
        mesh: &'a MeshView<'a>,
        (numbering, faces): (&Numbering, &'a FaceTable),
        is_flat: impl FnOnce() -> bool,
    ) -> Result<Self> {
        let mut notes = Notes::default();
        let dimension = mesh.dimension().max(1);
        let n_axes = match dimension {
            3 => 3,
            _ if is_flat() => 2,
            _ => 3,
        };
        let mut names = Names::of_zone();
        let mut sections = plan::sections(mesh, &mut names)?;
        // VTK's reader wants those of cells first in the file as well.
        sections.sort_by_key(|section| numbering.element(section.cells.start));
        let kind = index_kind(mesh, faces);
        let mut draft = Draft::default();
        draft.version(VERSION);
        let sizes = [i64::from(dimension), n_axes as i64];
        let name = ("Base", "CGNSBase_t");
        let base = draft.integers(None, name, DataType::I4, &[2], &sizes);
        draft.text(base, "DataClass", "DataClass_t", UNITS);
        let n_cells: usize = mesh.volume_runs().map(|run| run.n_cells()).sum();
        let n_cells = if mesh.dimension() == 0 { 0 } else { n_cells };
        let sizes = [mesh.points.len() as i64, n_cells as i64, 0];
        let zone = draft.integers(base, (ZONE, "Zone_t"), kind, &[1, 3], &sizes);
        draft.text(zone, "ZoneType", "ZoneType_t", "Unstructured");
        for section in &sections {
            let first = numbering.element(section.cells.start);
            sections::add(&mut draft, zone, (section, first), mesh, faces, kind);
        }
        if !numbering.is_order_of_cells() {
            add_order(&mut draft, zone, &sections, kind);
        }
        if faces.len() > 0 {
            let name = names.give("NGON_n");
            sections::add_faces(&mut draft, zone, &name, faces, kind);
        }
        let numbers = (numbering, kind);
        groups::add(
            &mut draft,
            (base, zone),
            mesh,
            &mut names,
            numbers,
            &mut notes,
        );
        arrays::note_boundary_values(mesh, &mut notes);
        Ok(Self {
            draft,
            base,
            zone,
            n_axes,
            notes,
        })
    }
}

/// Adds the first cell of each section, so that cells come back in the order of the mesh.
fn add_order(draft: &mut Draft, zone: NodeIndex, sections: &[Planned], kind: DataType) {
    let first = sections.iter().map(|section| section.cells.start as i64);
    let first: Vec<i64> = first.collect();
    let order = draft.group(zone, CELL_ORDER, "UserDefinedData_t");
    let name = ("FirstCell", "DataArray_t");
    draft.integers(order, name, kind, &[first.len() as u64], &first);
}

/// The type of integers in which all numbers of nodes, elements and entries fit.
fn index_kind(mesh: &MeshView, faces: &FaceTable) -> DataType {
    let entries = mesh.cells.connectivity().len() + mesh.cells.len() + faces.n_entries();
    let largest = entries
        .max(mesh.points.len())
        .max(faces.first_element() + faces.len());
    match i32::try_from(largest) {
        Ok(_) => DataType::I4,
        Err(_) => DataType::I8,
    }
}

/// Says that an array holds lengths.
fn add_length_exponents(draft: &mut Draft, array: NodeIndex) {
    let exponents = [0.0, 1.0, 0.0, 0.0, 0.0];
    let name = ("DimensionalExponents", "DimensionalExponents_t");
    draft.reals(array, name, &exponents);
}

/// Adds the arrays of coordinates to a grid.
fn add_coordinates<'a>(
    draft: &mut Draft<'a>,
    grid: NodeIndex,
    mesh: &'a MeshView<'a>,
    options: &WriteOptions,
    n_axes: usize,
) {
    let names = ["CoordinateX", "CoordinateY", "CoordinateZ"];
    let is_single = options.precision == Precision::F32;
    let kind = match is_single {
        true => DataType::R4,
        false => DataType::R8,
    };
    let n = mesh.points.len();
    for (axis, name) in names.into_iter().enumerate().take(n_axes) {
        let name = (name, "DataArray_t");
        let numbers = Coordinates::new(Some(axis), is_single);
        let data = match mesh.coordinates_apart(numbers) {
            Some(numbers) => Data::Remote(numbers),
            None => listed(numbers, mesh.points),
        };
        let node = draft.data(grid, name, kind, &[n as u64], data);
        add_length_exponents(draft, node);
    }
}

/// The coordinates of nodes.
fn listed(numbers: Coordinates, points: &[Vector]) -> Data<'_> {
    Data::made(move |sink| {
        let mut bytes = Vec::new();
        for block in points.chunks(BLOCK) {
            bytes.clear();
            numbers.append(block, &mut bytes);
            sink(&bytes)?;
        }
        Ok(())
    })
}
