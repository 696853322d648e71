//! The datasets of a mesh, and notes on what they leave out.

use super::super::column::{BLOCK, Column, Data, Sink, starts, stream_integers};
use super::super::vtk::arrays::{VtkArrays, ends_of};
use super::super::vtk::number::Element;
use crate::formats::Notes;
use crate::formats::names::Rule;
use crate::mesh::{CellKind, Cells, Listing, MeshView, NodesOfCells};
use azimesh_core::error::Result;
use azimesh_core::note;
use azimesh_core::parallel::collect;

/// Names of datasets: the names of the arrays, without characters that HDF5 does not allow.
pub(super) const NAMES: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name {
        "" | "." => "_".to_owned(),
        name => name.replace(['/', '\0'], "_"),
    },
    why: "names in HDF5 have no slash",
};

/// One dataset.
pub(super) struct Block<'a> {
    /// The group inside the group of the grid; empty for the grid itself.
    pub group: &'static str,
    pub column: Column<'a>,
}

/// The arrays of a mesh, and their lengths.
pub(super) struct Blocks<'a> {
    /// Datasets of the cells: connectivity, offsets, types, faces.
    pub cells: Vec<Block<'a>>,
    /// Node coordinates, then `PointData`, `CellData` and `FieldData`.
    pub arrays: Vec<Block<'a>>,
    /// Names and values of the datasets of one number per part.
    pub counts: Vec<(&'static str, u64)>,
    pub notes: Notes,
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
        let sections = plan.sections();
        let mut notes = plan.notes.clone();
        let unnamed = mesh
            .arrays()
            .filter(|array| !array.component_names.is_empty());
        notes.extend(unnamed.map(|array| {
            let name = &array.name;
            note!(
                "component_names",
                "names of the components of \"{name}\" are not written"
            )
        }));
        let mut arrays = Vec::new();
        for (group, columns) in [
            ("", sections.points),
            ("PointData", sections.point_data),
            ("CellData", sections.cell_data),
            ("FieldData", sections.fields),
        ] {
            for column in columns {
                if column.element == Element::String && group != "FieldData" {
                    // VTK reads text in field data only; elsewhere it makes VTK refuse all arrays.
                    let name = &column.name;
                    notes.push(note!(
                        "text_left_out",
                        "the array \"{name}\" is left out: VTK reads no text at nodes or cells"
                    ));
                } else {
                    arrays.push(Block { group, column });
                }
            }
        }
        let mut blocks = Self {
            cells: Vec::new(),
            arrays,
            counts: vec![
                ("NumberOfPoints", mesh.points.len() as u64),
                ("NumberOfCells", plan.n_cells() as u64),
            ],
            notes,
        };
        blocks.add_cells(mesh, plan, sections.cells);
        if mesh.cells.has_polyhedra() {
            blocks.add_faces(mesh, plan);
        }
        blocks
    }

    /// Adds the datasets of the cells: both of a pair have indices of the same size, as VTK wants them.
    fn add_cells(
        &mut self,
        mesh: &'a MeshView<'a>,
        plan: &'a VtkArrays<'a>,
        columns: Vec<Column<'a>>,
    ) {
        for column in columns {
            match column.name {
                "connectivity" => {
                    let n_entries = column.n_tuples as u64;
                    let wide = is_wide(n_entries.max(mesh.points.len() as u64));
                    let all = NodesOfCells::new(0..mesh.cells.len(), Listing::Vtk, true);
                    let data = match wide.then(|| mesh.nodes_apart(all)).flatten() {
                        Some(numbers) => Data::Remote(numbers),
                        None if wide => Data::made(move |sink| {
                            column.for_each(&mut |bytes| widened(bytemuck::cast_slice(bytes), sink))
                        }),
                        None => column.data,
                    };
                    self.add("Connectivity", n_entries, wide, data);
                    let offsets = offsets(mesh, plan, wide);
                    self.add("Offsets", plan.n_cells() as u64 + 1, wide, offsets);
                    self.counts.push(("NumberOfConnectivityIds", n_entries));
                }
                "types" => self.cells.push(Block {
                    group: "",
                    column: Column {
                        name: "Types",
                        ..column
                    },
                }),
                _ => {}
            }
        }
    }

    /// Adds the datasets of the faces of polyhedra: every polyhedron has its own.
    fn add_faces(&mut self, mesh: &'a MeshView<'a>, plan: &VtkArrays) {
        let cells = mesh.cells;
        let (n_faces, n_entries) = polyhedra(cells).fold((0, 0), |(faces, entries), cell| {
            let (n, stream) = (cells.n_faces(cell), cells.face_stream(cell));
            let n_nodes = stream.unwrap_or(&[]).len().saturating_sub(1 + n);
            (faces + n as u64, entries + n_nodes as u64)
        });
        self.counts.extend([
            ("NumberOfFaces", n_faces),
            ("NumberOfFaceConnectivityIds", n_entries),
            ("NumberOfPolyhedronToFaceIds", n_faces),
        ]);
        let (n_cells, n_more) = (plan.n_cells() as u64, plan.repeated.len());
        let wide = is_wide(n_entries.max(mesh.points.len() as u64));
        let wide_faces = is_wide(n_faces);
        let nodes = Data::made(move |sink| {
            let nodes = faces(cells).flatten().map(|node| i64::from(*node));
            stream_integers(nodes, wide, sink)
        });
        let face_starts = Data::made(move |sink| {
            let lengths = faces(cells).map(<[u32]>::len);
            stream_integers(starts(lengths), wide, sink)
        });
        let numbers = move |sink: Sink| stream_integers(0..n_faces as i64, wide_faces, sink);
        let cell_starts = Data::made(move |sink| {
            let of_mesh = cells.runs().flat_map(|run| {
                let is_polyhedron = run.kind == CellKind::Polyhedron;
                let n = move |cell| is_polyhedron.then(|| cells.n_faces(cell));
                run.range().map(move |cell| n(cell).unwrap_or(0))
            });
            let lengths = of_mesh.chain(std::iter::repeat_n(0, n_more));
            stream_integers(starts(lengths), wide_faces, sink)
        });
        self.add("FaceConnectivity", n_entries, wide, nodes);
        self.add("FaceOffsets", n_faces + 1, wide, face_starts);
        self.add(
            "PolyhedronToFaces",
            n_faces,
            wide_faces,
            Data::made(numbers),
        );
        self.add("PolyhedronOffsets", n_cells + 1, wide_faces, cell_starts);
    }

    /// Adds a dataset of indices.
    fn add(&mut self, name: &'static str, n_rows: u64, wide: bool, data: Data<'a>) {
        let element = if wide { Element::Int64 } else { Element::Int32 };
        self.cells.push(Block {
            group: "",
            column: Column::scalar(name, element, n_rows as usize, data),
        });
    }
}

fn is_wide(largest: u64) -> bool {
    i32::try_from(largest).is_err()
}

fn widened(nodes: &[u32], sink: Sink) -> Result<()> {
    for some in nodes.chunks(BLOCK) {
        let wide = collect(some.len(), |i| i64::from(some[i]));
        sink(bytemuck::cast_slice(&wide))?;
    }
    Ok(())
}

/// Start of the nodes of each cell, and the end of the last.
fn offsets<'a>(mesh: &'a MeshView<'a>, plan: &VtkArrays, wide: bool) -> Data<'a> {
    let cells = mesh.cells;
    let mut end = cells.connectivity().len();
    let ends = plan.repeated.iter().map(|cell| {
        end += cells.get(*cell).nodes.len();
        end as i64
    });
    let ends: Vec<i64> = ends.collect();
    Data::Parts(vec![
        Data::integers(&[0], wide),
        Data::made(move |sink| stream_integers(ends_of(cells), wide, sink)),
        Data::integers(&ends, wide),
    ])
}

fn polyhedra(cells: &Cells) -> impl Iterator<Item = usize> {
    let runs = cells.runs().filter(|run| run.kind == CellKind::Polyhedron);
    runs.flat_map(|run| run.range())
}

fn faces(cells: &Cells) -> impl Iterator<Item = &[u32]> {
    polyhedra(cells).flat_map(|cell| cells.polyhedron_faces(cell))
}
