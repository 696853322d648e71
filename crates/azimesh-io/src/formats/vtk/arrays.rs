//! The arrays of a mesh that VTK's formats write, by section of the file, and notes on what is left out. Their layout
//! in the file is left to the format.

use super::number::Element;
use super::order;
use super::tags::{self, BOUNDARY, LOWER, Labels, Numbers, ZONE};
use crate::formats::Notes;
use crate::formats::column::{BLOCK, Column, Data, Sink, stream, stream_integers};
use crate::formats::names::{Rule, UniqueNames};
use crate::formats::number::DType;
use crate::formats::{Precision, WriteOptions};
use crate::mesh::{
    CellKind, Cells, Coordinates, DataArray, Group, Listing, MeshView, NodesOfCells, Values,
};
use azimesh_core::error::Result;
use azimesh_core::{Note, note};

/// The arrays of each part of a file.
pub struct Sections<'a> {
    /// Arrays of the mesh as a whole.
    pub fields: Vec<Column<'a>>,
    /// Arrays with one tuple a node.
    pub point_data: Vec<Column<'a>>,
    /// Arrays with one tuple a cell.
    pub cell_data: Vec<Column<'a>>,
    /// Node coordinates.
    pub points: Vec<Column<'a>>,
    /// Node indices, ends, types; of polyhedra faces and their ends.
    pub cells: Vec<Column<'a>>,
}

impl<'a> Sections<'a> {
    /// Every array, in the order of an XML file.
    pub fn all(&self) -> impl Iterator<Item = &Column<'a>> {
        let of_piece = [&self.point_data, &self.cell_data, &self.points, &self.cells];
        self.fields.iter().chain(of_piece.into_iter().flatten())
    }
}

/// The arrays that VTK's formats write of a mesh.
pub struct VtkArrays<'a> {
    mesh: &'a MeshView<'a>,
    options: &'a WriteOptions,
    /// Arrays of nodes, of cells and of the whole that are written, with their names in the file.
    arrays: [Vec<(&'a DataArray, String)>; 3],
    /// Groups as numbers, for those pairs of arrays that the mesh needs; the numbers of the repeated cells.
    labels: Vec<(Labels<'static>, Numbers, Values)>,
    /// Cells written again because they are in several tags.
    pub repeated: Vec<usize>,
    /// The repeated cells.
    again: Cells,
    /// The cell arrays of those cells.
    repeated_arrays: Vec<Values>,
    /// Notes on content that is not in the file.
    pub notes: Notes,
}

impl<'a> VtkArrays<'a> {
    /// Chooses the arrays; `rule` says what their names may be.
    pub fn new(mesh: &'a MeshView<'a>, options: &'a WriteOptions, rule: &Rule) -> Self {
        let dimension = mesh.dimension();
        let mut labels = Vec::new();
        let mut notes = Notes::default();
        let mut repeated = Vec::new();
        let mut of_several = Vec::new();
        for pair in [BOUNDARY, ZONE, LOWER] {
            let (array, is_boundary) = (pair.array, pair.array == BOUNDARY.array);
            let of_pair = |group: &&Group| match array {
                "BoundaryTag" => group.dimension + 1 == dimension,
                "Zone" => group.dimension == dimension,
                _ => group.dimension + 1 < dimension,
            };
            let groups: Vec<&Group> = mesh.groups.iter().filter(of_pair).collect();
            if groups.is_empty() {
                continue;
            }
            let mut numbers = tags::number(&groups, mesh.cells.len(), !options.tag_names);
            notes.extend(numbers.fit_names(&TEXT));
            if is_boundary {
                repeated.extend(numbers.further.iter().map(|(cell, _)| *cell));
            } else if let Some(&(cell, _)) = numbers.further.first() {
                let n = numbers.further.len();
                of_several.push(note!(
                    "several_groups",
                    "cells are in more than one group ({n}, the first is cell {cell}); the array {array} holds the first group of each"
                ));
            }
            let more = numbers.repeated(&repeated, is_boundary);
            labels.push((pair, numbers, more));
        }
        notes.extend(of_several);
        let mut plan = Self {
            mesh,
            options,
            arrays: Default::default(),
            labels,
            again: Cells::new(),
            repeated_arrays: Vec::new(),
            repeated,
            notes,
        };
        for &cell in &plan.repeated {
            let cell = mesh.cells.get(cell);
            plan.again.push(cell.kind, cell.nodes);
        }
        plan.note_dropped();
        plan.name_arrays(rule);
        let arrays = plan.arrays[1].iter();
        let again =
            arrays.map(|(array, _)| array.values.select(array.n_components, &plan.repeated));
        plan.repeated_arrays = again.collect();
        plan
    }

    /// Chooses the arrays that are written, and their names in the file.
    fn name_arrays(&mut self, rule: &Rule) {
        let mesh = self.mesh;
        let all = [&mesh.point_arrays, &mesh.cell_arrays, &mesh.field_arrays];
        for (place, arrays) in all.into_iter().enumerate() {
            let taken = self.labels.iter();
            let taken = taken.flat_map(|(pair, ..)| [pair.array, pair.names]);
            let kept = arrays.iter().copied().filter(|array| self.is_kept(array));
            let kept: Vec<&DataArray> = kept.collect();
            let before: Vec<&str> = kept.iter().map(|array| array.name.as_str()).collect();
            let written = UniqueNames::with(taken).give_all(&before, rule);
            for (before, written) in before.into_iter().zip(&written) {
                self.notes.extend(rule.note("array", before, written));
            }
            self.arrays[place] = kept.into_iter().zip(written).collect();
        }
    }

    fn note_dropped(&mut self) {
        let mesh = self.mesh;
        if !self.options.tag_names && !self.labels.is_empty() {
            self.notes.push(note!(
                "names_not_written",
                "names of tags are not written, as requested"
            ));
        }
        self.notes.conditions_left_out("VTK", mesh);
        let arrays = mesh.arrays();
        let dropped = arrays.clone().filter(|array| !self.is_kept(array));
        let dropped = dropped.map(|array| {
            note!(
                "array_not_written",
                "the array \"{}\" is not written",
                array.name
            )
            .with("name", &*array.name)
        });
        let dropped: Vec<Note> = dropped.collect();
        self.notes.extend(dropped);
        let has_zero = |array: &&DataArray| match &array.values {
            Values::Text(texts) => texts.iter().any(|text| text.contains('\0')),
            _ => false,
        };
        for array in arrays.filter(has_zero) {
            let name = &array.name;
            self.notes.push(note!(
                "zeros_in_text",
                "zero bytes in the text of \"{name}\" are written as \"_\""
            ));
        }
    }

    /// Returns whether an array of the mesh is written: its name is not taken by tags, and strings only with names of tags.
    fn is_kept(&self, array: &DataArray) -> bool {
        let with_text = self.options.tag_names;
        let mut pairs = self.labels.iter().map(|(pair, ..)| pair);
        let name = array.name.as_str();
        let is_taken = pairs.any(|of| of.array == name || (of.names == name && with_text));
        !is_taken && (with_text || !matches!(array.values, Values::Text(_)))
    }

    /// Number of cells that are written.
    pub fn n_cells(&self) -> usize {
        self.mesh.cells.len() + self.repeated.len()
    }

    /// The arrays.
    pub fn sections(&self) -> Sections<'_> {
        let [at_nodes, _, fields] = self.arrays.each_ref().map(|arrays| arrays.iter());
        let names = self.labels.iter().filter(|_| self.options.tag_names);
        let names = names.map(|(pair, n, _)| {
            let (n, text) = (n.names.len(), Data::text(&n.names));
            Column::scalar(pair.names, Element::String, n, text)
        });
        let at_nodes = at_nodes.map(|(array, name)| {
            let mut column = column(array, name);
            if let Some(numbers) = self.mesh.values_apart(array, None) {
                column.data = Data::Remote(numbers);
            }
            column
        });
        let fields = fields.map(|(array, name)| column(array, name));
        Sections {
            fields: fields.chain(names).collect(),
            point_data: at_nodes.collect(),
            cell_data: self.cell_data(),
            points: vec![self.points()],
            cells: self.cells(),
        }
    }

    fn cell_data(&self) -> Vec<Column<'_>> {
        let n_cells = self.n_cells();
        let labels = self.labels.iter().map(|(pair, numbers, more)| {
            let data = Data::Parts(vec![Data::of(&numbers.of_cells), Data::of(more)]);
            Column::scalar(pair.array, Element::of(more), n_cells, data)
        });
        let arrays = self.arrays[1].iter().zip(&self.repeated_arrays);
        let arrays = arrays.map(|((array, name), more)| Column {
            data: Data::Parts(vec![Data::of(&array.values), Data::of(more)]),
            n_tuples: n_cells,
            ..column(array, name)
        });
        labels.chain(arrays).collect()
    }

    fn points(&self) -> Column<'_> {
        let coordinates = self.mesh.points.as_flattened();
        let is_single = self.options.precision == Precision::F32;
        let element = DType::real(if is_single { 4 } else { 8 }, false).element;
        let numbers = Coordinates::new(None, is_single);
        let data = match self.mesh.coordinates_apart(numbers) {
            Some(numbers) => Data::Remote(numbers),
            None if is_single => {
                Data::made(|sink| stream(coordinates.iter().map(|x| *x as f32), sink))
            }
            None => Data::slice(coordinates),
        };
        Column {
            n_components: 3,
            ..Column::scalar("Points", element, self.mesh.points.len(), data)
        }
    }

    fn cells(&self) -> Vec<Column<'_>> {
        let (cells, again) = (self.mesh.cells, &self.again);
        let (n_cells, n_own) = (self.n_cells(), cells.connectivity().len());
        let n_entries = n_own + again.connectivity().len();
        let index = index_type(self.mesh.points.len());
        let numbers = NodesOfCells::new(0..cells.len(), Listing::Vtk, false);
        let node_data = match self.mesh.nodes_apart(numbers) {
            Some(numbers) => {
                assert!(again.is_empty(), "cells with other ranks are written once");
                Data::Remote(numbers)
            }
            None => {
                let own = Data::made(|sink| nodes(cells, sink));
                Data::Parts(vec![own, Data::slice(again.connectivity())])
            }
        };
        let (offset, is_wide) = narrowest(n_entries);
        let ends = [(cells, 0), (again, n_own as i64)].map(|(cells, first)| {
            let ends = move || ends_of(cells).map(move |end| first + end);
            Data::made(move |sink| stream_integers(ends(), is_wide, sink))
        });
        let types = [cells, again].map(|cells| Data::made(|sink| stream(types_of(cells), sink)));
        let mut arrays = vec![
            Column::scalar("connectivity", index, n_entries, node_data),
            Column::scalar("offsets", offset, n_cells, Data::Parts(ends.into())),
            Column::scalar("types", Element::UInt8, n_cells, Data::Parts(types.into())),
        ];
        if cells.has_polyhedra() {
            let n_entries = cells.face_streams().len();
            let (offset, is_wide) = narrowest(n_entries);
            let repeated = vec![-1; again.len()];
            let own = Data::made(move |sink| stream_integers(face_ends(cells), is_wide, sink));
            let ends = Data::Parts(vec![own, Data::integers(&repeated, is_wide)]);
            let faces = Data::made(|sink| faces(cells, sink));
            arrays.push(Column::scalar("faces", index, n_entries, faces));
            arrays.push(Column::scalar("faceoffsets", offset, n_cells, ends));
        }
        arrays
    }
}

/// Type of indices below `n`.
pub fn index_type(n: usize) -> Element {
    i32::try_from(n).map_or(Element::UInt32, |_| Element::Int32)
}

/// Type of offsets up to `n`; whether they have 64 bits.
fn narrowest(n: usize) -> (Element, bool) {
    match i32::try_from(n) {
        Ok(_) => (Element::Int32, false),
        Err(_) => (Element::Int64, true),
    }
}

/// Names of tags, which are text.
const TEXT: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name {
        "" => "_".to_owned(),
        name => name.replace('\0', "_"),
    },
    why: "names of tags in VTK files have at least one byte and no zero byte",
};

fn column<'a>(array: &'a DataArray, name: &'a str) -> Column<'a> {
    let element = Element::of(&array.values);
    Column {
        n_components: array.n_components,
        component_names: &array.component_names,
        ..Column::scalar(name, element, array.n_tuples(), Data::of(&array.values))
    }
}

/// Nodes of each cell.
fn nodes(cells: &Cells, sink: Sink) -> Result<()> {
    if !order::has_wedges(cells) {
        return sink(bytemuck::cast_slice(cells.connectivity()));
    }
    let mut values: Vec<u32> = Vec::new();
    for run in cells.runs() {
        let n_nodes = run.n_nodes.max(1);
        for some in run.connectivity.chunks(BLOCK / n_nodes * n_nodes) {
            values.extend_from_slice(&order::listed(run.kind, some));
            if values.len() >= BLOCK {
                sink(bytemuck::cast_slice(&values))?;
                values.clear();
            }
        }
    }
    sink(bytemuck::cast_slice(&values))
}

/// VTK type of each cell.
fn types_of(cells: &Cells) -> impl Iterator<Item = u8> {
    let runs = cells.runs();
    runs.flat_map(|run| std::iter::repeat_n(run.kind.vtk(), run.n_cells()))
}

/// End of each cell's nodes.
pub fn ends_of(cells: &Cells) -> impl Iterator<Item = i64> {
    let mut first = 0;
    cells.runs().flat_map(move |run| {
        let (start, step) = (first, run.n_nodes as i64);
        let n_cells = run.n_cells() as i64;
        first += n_cells * step;
        (1..=n_cells).map(move |i| start + i * step)
    })
}

/// Face streams of the polyhedra.
fn faces(cells: &Cells, sink: Sink) -> Result<()> {
    let polyhedra = cells.runs().filter(|run| run.kind == CellKind::Polyhedron);
    let mut indices = polyhedra.flat_map(|run| run.range());
    let stream = |cell| cells.face_stream(cell).unwrap_or(&[]);
    indices.try_for_each(|cell| sink(bytemuck::cast_slice(stream(cell))))
}

/// End of each polyhedron's face stream, -1 for other cells.
fn face_ends(cells: &Cells) -> impl Iterator<Item = i64> {
    let mut end = 0;
    let kinds = cells.runs();
    let kinds = kinds.flat_map(|run| run.range().map(move |cell| (cell, run.kind)));
    kinds.map(move |(cell, kind)| {
        let is_polyhedron = kind == CellKind::Polyhedron;
        let Some(stream) = is_polyhedron.then(|| cells.face_stream(cell)).flatten() else {
            return -1;
        };
        end += stream.len() as i64;
        end
    })
}
