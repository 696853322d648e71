//! Sections of elements: connectivity in CGNS's node order, counted from 1.

use super::super::element::{ElementType, MIXED, NFACE_N, NGON_N};
use super::draft::Draft;
use super::faces::FaceTable;
use super::plan::{Form, Planned};
use crate::formats::column::{Data, Sink, starts, stream_integers};
use crate::formats::hdf5::{Element, Id};
use crate::mesh::{CellKind, CellRun, Cells, Listing, MeshView, NodesOfCells};
use azimesh_core::error::Result;
use azimesh_core::parallel::for_blocks;
use std::ops::Range;

/// Cells made into elements at a time.
const BLOCK: usize = 1 << 16;

/// A section of a file.
struct Section<'a> {
    /// Number of the element type, and number of boundary elements.
    kind: [i64; 2],
    /// Number of the first element, and number of elements.
    elements: (usize, usize),
    /// Start of each element and the end of the last, where elements have different sizes.
    starts: Option<Data<'a>>,
    n_entries: usize,
    entries: Data<'a>,
}

impl<'a> Section<'a> {
    fn add(self, draft: &mut Draft<'a>, zone: Id, name: &str, integer: Element) {
        let name = (name, "Elements_t");
        let section = draft.integers(zone, name, (Element::Int32, &[2]), &self.kind);
        let (first, n) = self.elements;
        let range = [first as i64, (first + n) as i64 - 1];
        let name = ("ElementRange", "IndexRange_t");
        draft.integers(section, name, (integer, &[2]), &range);
        let lists = [
            ("ElementStartOffset", n + 1, self.starts),
            ("ElementConnectivity", self.n_entries, Some(self.entries)),
        ];
        for (name, n, data) in lists {
            if let Some(data) = data {
                draft.data(section, (name, "DataArray_t"), (integer, &[n as u64]), data);
            }
        }
    }
}

/// Adds a section to a zone, with the number of its first element.
pub(super) fn add<'a>(
    draft: &mut Draft<'a>,
    zone: Id,
    (planned, first): (&Planned, usize),
    mesh: &'a MeshView<'a>,
    faces: &'a FaceTable,
    integer: Element,
) {
    let (is_wide, cells) = (integer == Element::Int64, planned.cells.clone());
    let number = match planned.form {
        Form::Fixed(element) => element.number,
        Form::Mixed => MIXED,
        Form::Polygons => NGON_N,
        Form::Polyhedra => NFACE_N,
    };
    let is_boundary = number == NGON_N && mesh.cells.has_polyhedra();
    let n_boundary = if is_boundary { cells.len() } else { 0 };
    let (starts, n_entries) = match planned.form {
        Form::Fixed(element) => (None, cells.len() * element.n_nodes),
        _ => {
            let of = cells.clone();
            let starts = Data::made(move |sink| {
                stream_integers(starts(sizes(mesh, of.clone(), number)), is_wide, sink)
            });
            (Some(starts), sizes(mesh, cells.clone(), number).sum())
        }
    };
    let listing = if number == MIXED {
        Listing::CgnsMixed
    } else {
        Listing::Cgns
    };
    let elements = (first, cells.len());
    let remote = mesh.nodes_apart(NodesOfCells::new(cells.clone(), listing, is_wide));
    let own = |node| node;
    let entries = match (remote, planned.form) {
        (Some(numbers), _) => Data::Remote(numbers),
        (_, Form::Mixed) => {
            Data::made(move |sink| list_mixed(mesh.cells, cells.clone(), is_wide, &own, sink))
        }
        (_, Form::Polyhedra) => Data::made(move |sink| {
            let of_cells = cells
                .clone()
                .flat_map(|cell| faces.of_polyhedron(mesh, cell));
            stream_integers(of_cells.copied(), is_wide, sink)
        }),
        _ => Data::made(move |sink| list_elements(mesh.cells, cells.clone(), is_wide, &own, sink)),
    };
    let section = Section {
        kind: [number, n_boundary as i64],
        elements,
        starts,
        n_entries,
        entries,
    };
    section.add(draft, zone, &planned.name, integer);
}

/// Adds the section of those faces of polyhedra that are no cells.
pub(super) fn add_faces<'a>(
    draft: &mut Draft<'a>,
    zone: Id,
    name: &str,
    faces: &'a FaceTable,
    integer: Element,
) {
    let is_wide = integer == Element::Int64;
    let starts = Data::made(move |sink| {
        stream_integers(faces.starts.iter().map(|at| *at as i64), is_wide, sink)
    });
    let entries = Data::made(move |sink| {
        let numbers = faces.nodes.iter().map(|node| i64::from(*node) + 1);
        stream_integers(numbers, is_wide, sink)
    });
    let section = Section {
        kind: [NGON_N, 0],
        elements: (faces.first_element, faces.len()),
        starts: Some(starts),
        n_entries: faces.nodes.len(),
        entries,
    };
    section.add(draft, zone, name, integer);
}

/// Entries of each element.
fn sizes<'a>(
    mesh: &'a MeshView<'a>,
    cells: Range<usize>,
    number: i64,
) -> impl Iterator<Item = usize> + 'a {
    mesh.cells.runs_in(cells).flat_map(move |run| {
        run.range().map(move |cell| match number {
            NFACE_N => mesh.cells.n_faces(cell),
            MIXED => run.n_nodes + 1,
            _ => run.n_nodes,
        })
    })
}

/// The nodes of elements, a block at a time on all threads; `number` gives the number of a node from 0.
pub fn list_elements(
    cells: &Cells,
    range: Range<usize>,
    is_wide: bool,
    number: &(dyn Fn(u32) -> u32 + Sync),
    sink: Sink,
) -> Result<()> {
    for run in cells.runs_in(range) {
        let (order, n) = (order(&run), run.n_nodes);
        let order = order.as_deref();
        for block in run.connectivity.chunks(BLOCK * 8 * n) {
            if is_wide {
                let numbers = numbers(block, order, n, |node| i64::from(number(node)) + 1);
                sink(bytemuck::cast_slice(&numbers))?;
            } else {
                let numbers = numbers(block, order, n, |node| (number(node) + 1) as i32);
                sink(bytemuck::cast_slice(&numbers))?;
            }
        }
    }
    Ok(())
}

/// Position in the cell of each node of an element, if not the same.
fn order(run: &CellRun) -> Option<Vec<usize>> {
    match run.kind {
        CellKind::Polygon => None,
        kind => ElementType::of(kind, run.n_nodes)?.cgns_from_vtk(),
    }
}

fn numbers<T: Send + Copy + Default>(
    nodes: &[u32],
    order: Option<&[usize]>,
    n_nodes: usize,
    number: impl Fn(u32) -> T + Sync,
) -> Vec<T> {
    let mut numbers = vec![T::default(); nodes.len()];
    let chunk = BLOCK / n_nodes.max(1) * n_nodes;
    let chunk = chunk.max(n_nodes);
    for_blocks(&mut numbers, chunk, &|first, numbers| {
        let nodes = &nodes[first..first + numbers.len()];
        let Some(order) = order else {
            let places = numbers.iter_mut().zip(nodes);
            return places.for_each(|(to, &node)| *to = number(node));
        };
        let cells = numbers
            .chunks_exact_mut(n_nodes)
            .zip(nodes.chunks_exact(n_nodes));
        for (numbers, nodes) in cells {
            for (to, &from) in numbers.iter_mut().zip(order) {
                *to = number(nodes[from]);
            }
        }
    });
    numbers
}

/// Elements with their types, as [`list_elements`].
pub fn list_mixed(
    cells: &Cells,
    range: Range<usize>,
    is_wide: bool,
    number: &(dyn Fn(u32) -> u32 + Sync),
    sink: Sink,
) -> Result<()> {
    let mut numbers: Vec<i64> = Vec::with_capacity(BLOCK);
    for run in cells.runs_in(range) {
        let element = ElementType::of(run.kind, run.n_nodes).expect("the plan has looked at it");
        let order = element.cgns_from_vtk();
        let order = order.unwrap_or_else(|| (0..run.n_nodes).collect());
        for nodes in run.cells() {
            numbers.push(element.number);
            numbers.extend(order.iter().map(|&from| i64::from(number(nodes[from])) + 1));
            if numbers.len() >= BLOCK {
                stream_integers(numbers.drain(..), is_wide, sink)?;
            }
        }
    }
    stream_integers(numbers.drain(..), is_wide, sink)
}
