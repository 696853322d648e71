//! Arrays to be written: solutions at nodes and at cells, and arrays of the mesh as a whole, which are user-defined data
//! of the base.

use super::super::{FIELD_ARRAYS, FULL_NAME};
use super::RULE;
use super::draft::Draft;
use crate::formats::Notes;
use crate::formats::column::{Data, Sink};
use crate::formats::hdf5::{Element, Id, Payload};
use crate::formats::names::UniqueNames;
use crate::mesh::arrays::with_numbers;
use crate::mesh::{BoundedCells, CellKind, DataArray, MeshView, Values};
use azimesh_core::error::Result;
use azimesh_core::note;
use azimesh_core::parallel::collect;
use std::cell::LazyCell;
use std::ops::Range;
use std::slice::from_ref;

/// The node for arrays of one kind.
pub(super) struct Kind {
    pub name: &'static str,
    label: &'static str,
    location: Option<&'static str>,
}

/// The solution at the nodes.
pub(super) const AT_NODES: Kind = Kind {
    name: "PointArrays",
    label: "FlowSolution_t",
    location: Some("Vertex"),
};
/// The solution at the cells.
pub(super) const AT_CELLS: Kind = Kind {
    name: "CellArrays",
    label: "FlowSolution_t",
    location: Some("CellCenter"),
};
/// Arrays of the mesh as a whole.
pub(super) const OF_MESH: Kind = Kind {
    name: FIELD_ARRAYS,
    label: "UserDefinedData_t",
    location: None,
};
/// Values converted at a time.
const BLOCK: usize = 1 << 20;

/// An array to be written: a component of an array of a solution, or an array of the mesh as a whole.
#[derive(Clone, PartialEq)]
pub(super) struct Array<D> {
    /// Name in the file.
    pub name: String,
    /// Full name, where that is too long for CGNS.
    pub full_name: Option<String>,
    pub element: Element,
    /// Sizes, the first index running fastest.
    pub sizes: Vec<u64>,
    pub data: D,
}

/// Gives the arrays of the mesh as a whole, at nodes and at cells of the mesh's own dimension; adds a note for each that
/// is left out.
pub(super) fn all<'a>(mesh: &MeshView<'a>, notes: &mut Notes) -> [Vec<Array<Data<'a>>>; 3] {
    let (nodes, cells) = (0..mesh.points.len(), volume_cells(mesh));
    [
        fields(&mesh.field_arrays, notes),
        scalars(mesh, &mesh.point_arrays, from_ref(&nodes), notes),
        scalars(mesh, &mesh.cell_arrays, &cells, notes),
    ]
}

/// Gives the scalars of arrays at nodes or cells, restricted to the tuples that are written.
fn scalars<'a>(
    mesh: &MeshView<'a>,
    arrays: &[&'a DataArray],
    tuples: &[Range<usize>],
    notes: &mut Notes,
) -> Vec<Array<Data<'a>>> {
    let mut scalars = Vec::new();
    for &array in arrays {
        let n_components = array.n_components;
        if matches!(array.values, Values::Text(_)) {
            let name = &array.name;
            notes.push(
                note!("text_left_out", "array \"{name}\" of text is not written")
                    .with("name", &**name),
            );
            continue;
        }
        if !fits(array, notes) {
            continue;
        }
        if ![1, 3].contains(&n_components) {
            let (name, n) = (&array.name, n_components);
            notes.push(note!(
                "components_apart",
                "array \"{name}\" of {n} components is written as {n} arrays"
            ));
        }
        for component in 0..n_components {
            let name = match n_components {
                1 => array.name.clone(),
                3 => format!("{}{}", array.name, ["X", "Y", "Z"][component]),
                _ => format!("{}_{}", array.name, component + 1),
            };
            let data = match mesh.values_apart(array, Some(component)) {
                Some(numbers) => Data::Remote(numbers),
                None => {
                    let tuples = tuples.to_vec();
                    Data::made(move |sink| list_component(array, component, &tuples, sink))
                }
            };
            scalars.push(Array {
                name,
                full_name: None,
                element: element(&array.values),
                sizes: vec![tuples.iter().map(|range| range.len() as u64).sum()],
                data,
            });
        }
    }
    fit_names(&mut scalars, UniqueNames::with(["GridLocation"]), notes);
    scalars
}

/// The arrays of the mesh as a whole that CGNS can hold; a note for each other. Strings have a zero after each.
fn fields<'a>(arrays: &[&'a DataArray], notes: &mut Notes) -> Vec<Array<Data<'a>>> {
    let mut fields = Vec::new();
    for array in arrays {
        if array.n_components == 0 || array.n_tuples() == 0 {
            let name = &array.name;
            notes.push(note!(
                "without_values",
                "field array \"{name}\" is not written: it has no values"
            ));
            continue;
        }
        if !fits(array, notes) {
            continue;
        }
        let mut sizes = vec![array.n_components as u64, array.n_tuples() as u64];
        let element = element(&array.values);
        let data = match &array.values {
            Values::F64(v) => Data::slice(v),
            Values::F32(v) => Data::slice(v),
            Values::Text(lines) => {
                let ended = lines.iter().flat_map(|line| [line.as_bytes(), b"\0"]);
                let bytes: Vec<u8> = ended.flatten().copied().collect();
                sizes = vec![bytes.len() as u64];
                Data::Bytes(bytes.into())
            }
            values => {
                let numbers = values.to_integers().unwrap_or_default();
                Data::integers(&numbers, element == Element::Int64)
            }
        };
        fields.push(Array {
            name: array.name.clone(),
            full_name: None,
            element,
            sizes,
            data,
        });
    }
    fit_names(&mut fields, UniqueNames::default(), notes);
    fields
}

/// Gives arrays names that CGNS takes.
fn fit_names<D>(arrays: &mut [Array<D>], mut taken: UniqueNames, notes: &mut Notes) {
    let names: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
    let names = taken.give_all(&names, &RULE);
    for (array, name) in arrays.iter_mut().zip(names) {
        let full_name = std::mem::replace(&mut array.name, name);
        notes.extend(RULE.note("array", &full_name, &array.name));
        array.full_name = (array.name != full_name).then_some(full_name);
    }
}

/// Tests if integers are within the 63 bits of CGNS; else adds a note.
fn fits(array: &DataArray, notes: &mut Notes) -> bool {
    let Values::U64(v) = &array.values else {
        return true;
    };
    let fits = v.iter().all(|x| i64::try_from(*x).is_ok());
    if !fits {
        let (name, most) = (&array.name, i64::MAX);
        notes.push(note!(
            "integers_too_large",
            "array \"{name}\" is not written: it has integers above {most}, the largest of CGNS"
        ));
    }
    fits
}

/// Cells of the mesh's own dimension.
fn volume_cells(mesh: &MeshView) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in mesh.volume_runs().map(|run| run.range()) {
        match joined.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => joined.push(range),
        }
    }
    joined
}

/// Adds a note for cell arrays whose boundary values differ from the values of the cells. CGNS does not keep these;
/// the reader gives faces the values of their cells.
pub(super) fn note_boundary_values(mesh: &MeshView, notes: &mut Notes) {
    let dimension = mesh.dimension();
    let is_other = |kind: CellKind| kind.dimension() != dimension && kind != CellKind::Polyhedron;
    let runs = mesh.cells.runs().filter(|run| is_other(run.kind));
    let bounded = LazyCell::new(|| BoundedCells::of_view(mesh));
    for array in &mesh.cell_arrays {
        let mut cells = runs.clone().flat_map(|run| run.range());
        if cells.any(|cell| says_more(array, cell, &bounded)) {
            let name = &array.name;
            notes.push(note!(
                "face_values",
                "values of the array \"{name}\" on boundary faces are not written: CGNS holds values of cells"
            ));
        }
    }
}

/// Tests if the value of a cell differs from the value of the cell that it bounds, and is not missing.
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

fn element(values: &Values) -> Element {
    match values {
        Values::F32(_) => Element::Float32,
        Values::F64(_) => Element::Float64,
        Values::U32(_) | Values::I64(_) | Values::U64(_) => Element::Int64,
        Values::Text(_) => Element::Int8,
        _ => Element::Int32,
    }
}

impl<D> Array<D> {
    /// The array with other values.
    pub fn with<E>(self, data: E) -> Array<E> {
        Array {
            name: self.name,
            full_name: self.full_name,
            element: self.element,
            sizes: self.sizes,
            data,
        }
    }
}

/// Adds a node with arrays of a kind; none without arrays.
pub(super) fn add<'a, D: Into<Payload<'a>>>(
    draft: &mut Draft<'a>,
    parent: Id,
    (name, kind): (&str, &Kind),
    arrays: impl IntoIterator<Item = Array<D>>,
) {
    let mut arrays = arrays.into_iter().peekable();
    if arrays.peek().is_none() {
        return;
    }
    let node = draft.group(parent, (name, kind.label));
    if let Some(location) = kind.location {
        draft.text(node, ("GridLocation", "GridLocation_t"), location);
    }
    for array in arrays {
        let name = (array.name.as_str(), "DataArray_t");
        let of = draft.data(node, name, (array.element, &array.sizes), array.data);
        if let Some(name) = array.full_name {
            draft.text(of, (FULL_NAME, "Descriptor_t"), &name);
        }
    }
}

/// One component of some tuples, in the type of [`element`].
fn list_component(
    array: &DataArray,
    component: usize,
    tuples: &[Range<usize>],
    sink: Sink,
) -> Result<()> {
    let n = array.n_components;
    macro_rules! each {
        ($values:expr, $type:ty, $as:expr) => {
            for range in tuples {
                for start in range.clone().step_by(BLOCK) {
                    let tuples = start..range.end.min(start + BLOCK);
                    let of_tuples = &$values[tuples.start * n..tuples.end * n];
                    let chosen: Vec<$type> =
                        collect(tuples.len(), |i| $as(of_tuples[i * n + component]));
                    sink(bytemuck::cast_slice(&chosen))?;
                }
            }
        };
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
        Values::Text(_) => {}
    }
    Ok(())
}
