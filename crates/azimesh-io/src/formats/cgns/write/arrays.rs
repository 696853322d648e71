//! Arrays of a mesh as solutions at nodes and at cells.

use super::super::FULL_NAME;
use super::draft::{DataType, Draft, NodeIndex};
use super::names::{Names, RULE};
use crate::formats::Notes;
use crate::formats::column::Data;
use crate::mesh::arrays::with_numbers;
use crate::mesh::{BoundedCells, CellKind, DataArray, MeshView, NumbersApart, Values};
use azimesh_core::diagnostic::formats::ArrayWritten;
use azimesh_core::parallel::collect;
use std::cell::LazyCell;
use std::ops::Range;

/// Name of the solution at the nodes.
pub(super) const AT_NODES: &str = "PointArrays";
/// Name of the solution at the cells.
pub(super) const AT_CELLS: &str = "CellArrays";
/// Values converted at a time.
const BLOCK: usize = 1 << 20;

/// One scalar array of a solution: a component of an array of the mesh.
pub(super) struct Scalar<'a> {
    /// Name in the file.
    pub name: String,
    /// Full name, where that is too long for CGNS.
    pub full_name: Option<String>,
    pub kind: DataType,
    pub n: usize,
    /// The values, where they are elsewhere.
    apart: Option<NumbersApart<'a>>,
    array: &'a DataArray,
    component: usize,
    /// Tuples that are written.
    tuples: Vec<Range<usize>>,
}

/// The scalars of arrays at nodes or, where `cells` gives them, at cells.
pub(super) fn scalars<'a>(
    mesh: &MeshView<'a>,
    arrays: &[&'a DataArray],
    tuples: &[Range<usize>],
    notes: &mut Notes,
) -> Vec<Scalar<'a>> {
    let mut scalars = Vec::new();
    for array in arrays {
        if matches!(array.values, Values::Text(_)) {
            let (format, name) = ("CGNS", array.name.clone());
            notes.push(ArrayWritten::TextLeftOut { format, name });
            continue;
        }
        if !fits(&array.values) {
            let name = array.name.clone();
            notes.push(ArrayWritten::IntegersTooLarge { name });
            continue;
        }
        if ![1, 3].contains(&array.n_components) {
            notes.push(ArrayWritten::ComponentsApart {
                name: array.name.clone(),
                n: array.n_components,
            });
        }
        for component in 0..array.n_components {
            let full_name = match array.n_components {
                1 => array.name.clone(),
                3 => format!("{}{}", array.name, ["X", "Y", "Z"][component]),
                _ => format!("{}_{}", array.name, component + 1),
            };
            scalars.push(Scalar {
                full_name: None,
                name: full_name,
                kind: kind(&array.values),
                n: tuples.iter().map(Range::len).sum(),
                apart: mesh.values_apart(array, Some(component)),
                array,
                component,
                tuples: tuples.to_vec(),
            });
        }
    }
    let names: Vec<&str> = scalars.iter().map(|scalar| scalar.name.as_str()).collect();
    let names = Names::with(["GridLocation"]).give_all(&names);
    for (scalar, name) in scalars.iter_mut().zip(names) {
        let full_name = std::mem::replace(&mut scalar.name, name);
        notes.extend(RULE.note("array", &full_name, &scalar.name));
        scalar.full_name = (scalar.name != full_name).then_some(full_name);
    }
    scalars
}

/// Whether integers are within the 63 bits of those of CGNS.
pub(super) fn fits(values: &Values) -> bool {
    match values {
        Values::U64(v) => v.iter().all(|x| i64::try_from(*x).is_ok()),
        _ => true,
    }
}

/// Cells of the mesh's own dimension.
pub(super) fn volume_cells(mesh: &MeshView) -> Vec<Range<usize>> {
    let runs = mesh.volume_runs();
    let ranges = runs.map(|run| run.first_cell..run.first_cell + run.n_cells());
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => joined.push(range),
        }
    }
    joined
}

/// A note for cell arrays with values on the boundary, which CGNS does not keep, other than those of the
/// cells, which faces get again when the file is read.
pub(super) fn note_boundary_values(mesh: &MeshView, notes: &mut Notes) {
    let dimension = mesh.dimension();
    let runs = mesh
        .cells
        .runs()
        .filter(|run| run.kind.dimension() != dimension && run.kind != CellKind::Polyhedron);
    let others: Vec<Range<usize>> = runs
        .map(|run| run.first_cell..run.first_cell + run.n_cells())
        .collect();
    let bounded = LazyCell::new(|| BoundedCells::of_view(mesh));
    for array in &mesh.cell_arrays {
        let mut cells = others.iter().cloned().flatten();
        if cells.any(|cell| says_more(array, cell, &bounded)) {
            let name = array.name.clone();
            notes.push(ArrayWritten::FaceValues { name });
        }
    }
}

/// Whether a cell has a value that is neither nothing nor that of the cell which it bounds.
#[allow(clippy::unnecessary_cast)] // one text for numbers of every type
fn says_more(
    array: &DataArray,
    cell: usize,
    bounded: &LazyCell<BoundedCells, impl FnOnce() -> BoundedCells>,
) -> bool {
    let n = array.n_components;
    with_numbers!(&array.values, v => (0..n).any(|i| {
        let value = v[cell * n + i];
        let is_nothing = (value as f64).is_nan() || value as f64 == 0.0;
        let is_given = || bounded.cell_of(cell).is_some_and(|of| v[of * n + i] == value);
        !is_nothing && !is_given()
    }), _text => false)
}

fn kind(values: &Values) -> DataType {
    match values {
        Values::F32(_) => DataType::R4,
        Values::F64(_) => DataType::R8,
        Values::U32(_) | Values::I64(_) | Values::U64(_) => DataType::I8,
        _ => DataType::I4,
    }
}

impl<'a> Scalar<'a> {
    /// Its values.
    pub fn data(&self) -> Data<'a> {
        if let Some(numbers) = &self.apart {
            return Data::Remote(numbers.clone());
        }
        let (array, component, tuples) = (self.array, self.component, self.tuples.clone());
        Data::made(move |sink| {
            for range in &tuples {
                let mut start = range.start;
                while start < range.end {
                    let end = (start + BLOCK).min(range.end);
                    sink(&bytes(array, component, start..end))?;
                    start = end;
                }
            }
            Ok(())
        })
    }

    /// Adds it to a solution.
    pub fn add(&self, draft: &mut Draft<'a>, solution: NodeIndex) {
        let name = (self.name.as_str(), "DataArray_t");
        let node = draft.data(solution, name, self.kind, &[self.n as u64], self.data());
        if let Some(full_name) = &self.full_name {
            draft.text(node, FULL_NAME, "Descriptor_t", full_name);
        }
    }
}

/// The bytes of one component of some tuples.
fn bytes(array: &DataArray, component: usize, tuples: Range<usize>) -> Vec<u8> {
    let n = array.n_components;
    macro_rules! each {
        ($values:expr, $type:ty, $as:expr) => {{
            let of_tuples = &$values[tuples.start * n..tuples.end * n];
            let chosen: Vec<$type> = collect(tuples.len(), |i| $as(of_tuples[i * n + component]));
            bytemuck::cast_slice(&chosen).to_vec()
        }};
    }
    match &array.values {
        Values::I8(v) => each!(v, i32, i32::from),
        Values::U8(v) => each!(v, i32, i32::from),
        Values::I16(v) => each!(v, i32, i32::from),
        Values::U16(v) => each!(v, i32, i32::from),
        Values::I32(v) => each!(v, i32, |x| x),
        Values::U32(v) => each!(v, i64, i64::from),
        Values::I64(v) => each!(v, i64, |x| x),
        Values::U64(v) => each!(v, i64, |x| x as i64),
        Values::F32(v) => each!(v, f32, |x| x),
        Values::F64(v) => each!(v, f64, |x| x),
        Values::Text(_) => Vec::new(),
    }
}
