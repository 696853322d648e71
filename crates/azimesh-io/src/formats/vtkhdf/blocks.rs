//! What is written of a mesh: the datasets, and notes on what they leave out.

use super::super::column::{BLOCK, Column, Data, Sink, stream_integers};
use super::super::vtk::arrays::{Sections, VtkArrays, ends_of};
use super::super::vtk::number::Element;
use super::faces::{self, FaceCounts};
use crate::formats::Notes;
use crate::formats::names::Rule;
use crate::mesh::{DataArray, Listing, MeshView, NodesOfCells};
use azimesh_core::diagnostic::formats::ArrayWritten;
use azimesh_core::error::Result;
use azimesh_core::parallel::collect;

/// One dataset.
pub(super) struct Block<'a> {
    /// The group in that of the grid; empty for the grid itself.
    pub group: &'static str,
    pub column: Column<'a>,
}

/// The arrays of a mesh, and the numbers that say how long they are.
pub(super) struct Blocks<'a> {
    /// Node coordinates.
    pub points: Block<'a>,
    /// Datasets of the cells: connectivity, offsets, types, faces.
    pub cells: Vec<Block<'a>>,
    /// `PointData`, `CellData` and `FieldData`.
    pub arrays: Vec<Block<'a>>,
    /// Names and values of the datasets of one number a part.
    pub counts: Vec<(&'static str, u64)>,
    pub notes: Notes,
}

impl Block<'_> {
    pub fn shape(&self) -> Vec<u64> {
        shape(self.column.n_tuples as u64, self.column.n_components as u64)
    }
}

/// A shape that has a second index only where there are components.
pub(super) fn shape(n_rows: u64, n_components: u64) -> Vec<u64> {
    match n_components {
        1 => vec![n_rows],
        n => vec![n_rows, n],
    }
}

impl<'a> Blocks<'a> {
    pub fn new(mesh: &'a MeshView<'a>, plan: &'a VtkArrays<'a>) -> Self {
        let Sections {
            fields,
            point_data,
            cell_data,
            mut points,
            cells,
        } = plan.sections();
        let mut notes = plan.notes.clone();
        notes.extend(unwritten_components(mesh));
        let mut arrays = Vec::new();
        for (group, columns) in [
            ("PointData", point_data),
            ("CellData", cell_data),
            ("FieldData", fields),
        ] {
            for column in columns {
                if column.element == Element::String && group != "FieldData" {
                    // VTK reads text in field data only; elsewhere it makes VTK refuse all arrays.
                    notes.push(ArrayWritten::TextLeftOut {
                        format: "VTKHDF",
                        name: column.name.to_owned(),
                    });
                } else {
                    arrays.push(Block { group, column });
                }
            }
        }
        let mut counts = vec![
            ("NumberOfPoints", mesh.points.len() as u64),
            ("NumberOfCells", plan.n_cells() as u64),
        ];
        let points = points
            .pop()
            .expect("a plan has coordinates, perhaps of no node");
        Self {
            points: of_grid(points),
            cells: cell_blocks(mesh, plan, cells, &mut counts),
            arrays,
            counts,
            notes,
        }
    }
}

/// Names of datasets: those of the arrays, but for what HDF5 does not allow.
pub(super) const NAMES: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name {
        "" | "." => "_".to_owned(),
        name => name.replace(['/', '\0'], "_"),
    },
    why: "names in HDF5 have no slash",
};

fn unwritten_components(mesh: &MeshView) -> impl Iterator<Item = ArrayWritten> {
    let named = |array: &&DataArray| !array.component_names.is_empty();
    let names = mesh.arrays().filter(named).map(|array| array.name.clone());
    names.map(|name| ArrayWritten::ComponentNames { name })
}

/// A dataset of the grid itself.
fn of_grid(column: Column) -> Block {
    Block { group: "", column }
}

/// The datasets of the cells: both of a pair have indices of the same size, as VTK wants them.
fn cell_blocks<'a>(
    mesh: &'a MeshView<'a>,
    plan: &'a VtkArrays<'a>,
    columns: Vec<Column<'a>>,
    counts: &mut Vec<(&'static str, u64)>,
) -> Vec<Block<'a>> {
    let mut blocks = Vec::new();
    let mut n_entries = 0;
    for column in columns {
        match column.name {
            "connectivity" => {
                n_entries = column.n_tuples as u64;
                let wide = is_wide(n_entries.max(mesh.points.len() as u64));
                let remote =
                    || mesh.nodes_apart(NodesOfCells::new(0..mesh.cells.len(), Listing::Vtk, true));
                let data = match wide.then(remote).flatten() {
                    Some(numbers) => Data::Remote(numbers),
                    None if wide => Data::made(move |sink| {
                        column.for_each(&mut |bytes| widened(bytemuck::cast_slice(bytes), sink))
                    }),
                    None => column.data,
                };
                blocks.push(indices("Connectivity", n_entries, wide, data));
                blocks.push(offsets(mesh, plan, wide));
            }
            "types" => blocks.push(of_grid(Column {
                name: "Types",
                ..column
            })),
            _ => {}
        }
    }
    counts.push(("NumberOfConnectivityIds", n_entries));
    if mesh.cells.has_polyhedra() {
        blocks.extend(face_blocks(mesh, plan, counts));
    }
    blocks
}

/// The datasets of the faces of polyhedra.
fn face_blocks<'a>(
    mesh: &'a MeshView<'a>,
    plan: &VtkArrays,
    counts: &mut Vec<(&'static str, u64)>,
) -> [Block<'a>; 4] {
    let FaceCounts { faces, entries } = FaceCounts::of(mesh.cells);
    counts.push(("NumberOfFaces", faces));
    counts.push(("NumberOfFaceConnectivityIds", entries));
    counts.push(("NumberOfPolyhedronToFaceIds", faces));
    let cells = mesh.cells;
    let (n_cells, n_more) = (plan.n_cells() as u64, plan.repeated.len());
    let wide = is_wide(entries.max(mesh.points.len() as u64));
    let wide_faces = is_wide(faces);
    let starts = move |sink: Sink| stream_integers(faces::starts(cells), wide, sink);
    let numbers = move |sink: Sink| stream_integers(0..faces as i64, wide_faces, sink);
    let cell_starts =
        move |sink: Sink| stream_integers(faces::cell_starts(cells, n_more), wide_faces, sink);
    let nodes = move |sink: Sink| stream_integers(faces::nodes(cells), wide, sink);
    [
        indices("FaceConnectivity", entries, wide, Data::made(nodes)),
        indices("FaceOffsets", faces + 1, wide, Data::made(starts)),
        indices("PolyhedronToFaces", faces, wide_faces, Data::made(numbers)),
        indices(
            "PolyhedronOffsets",
            n_cells + 1,
            wide_faces,
            Data::made(cell_starts),
        ),
    ]
}

fn is_wide(largest: u64) -> bool {
    i32::try_from(largest).is_err()
}

/// A dataset of indices.
fn indices<'a>(name: &'a str, n_rows: u64, wide: bool, data: Data<'a>) -> Block<'a> {
    let element = if wide { Element::Int64 } else { Element::Int32 };
    of_grid(Column::scalar(name, element, n_rows as usize, data))
}

fn widened(nodes: &[u32], sink: Sink) -> Result<()> {
    for some in nodes.chunks(BLOCK) {
        let wide = collect(some.len(), |i| i64::from(some[i]));
        sink(bytemuck::cast_slice(&wide))?;
    }
    Ok(())
}

/// Start of the nodes of each cell, and the end of the last.
fn offsets<'a>(mesh: &'a MeshView<'a>, plan: &VtkArrays, wide: bool) -> Block<'a> {
    let cells = mesh.cells;
    let mut end = cells.connectivity().len();
    let ends = plan.repeated.iter().map(|cell| {
        end += cells.get(*cell).nodes.len();
        end as i64
    });
    let ends: Vec<i64> = ends.collect();
    let data = Data::Parts(vec![
        Data::integers(&[0], wide),
        Data::made(move |sink| stream_integers(ends_of(cells), wide, sink)),
        Data::integers(&ends, wide),
    ]);
    indices("Offsets", plan.n_cells() as u64 + 1, wide, data)
}
