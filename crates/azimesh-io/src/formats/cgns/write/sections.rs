//! Sections of elements: connectivity in CGNS's node order, counted from 1.

use super::super::element::{ElementType, MIXED, NFACE_N, NGON_N};
use super::draft::{DataType, Draft, NodeIndex};
use super::faces::FaceTable;
use super::plan::{Form, Planned};
use crate::formats::column::{Data, Sink, stream_integers};
use crate::mesh::{CellKind, CellRun, Cells, Listing, MeshView, NodesOfCells};
use azimesh_core::error::Result;
use azimesh_core::parallel::for_blocks;
use std::ops::Range;

/// Cells made into elements at a time.
const BLOCK: usize = 1 << 16;

/// Adds a section to a zone, with the number of its first element.
pub(super) fn add<'a>(
    draft: &mut Draft<'a>,
    zone: NodeIndex,
    (planned, first): (&Planned, usize),
    mesh: &'a MeshView<'a>,
    faces: &'a FaceTable,
    kind: DataType,
) {
    let cells = planned.cells.clone();
    let (number, n_boundary) = match planned.form {
        Form::Fixed(element) => (element.number, 0),
        Form::Mixed => (MIXED, 0),
        Form::Polygons if mesh.cells.has_polyhedra() => (NGON_N, cells.len() as i64),
        Form::Polygons => (NGON_N, 0),
        Form::Polyhedra => (NFACE_N, 0),
    };
    let range = [first as i64, (first + cells.len() - 1) as i64];
    let section = header(
        draft,
        zone,
        &planned.name,
        (number, n_boundary),
        range,
        kind,
    );
    let (n, offsets): (usize, Option<Data>) = match planned.form {
        Form::Fixed(element) => (cells.len() * element.n_nodes, None),
        _ => {
            let sizes = move |emit: &mut dyn FnMut(usize)| sizes(mesh, cells.clone(), number, emit);
            let mut n = 0;
            sizes(&mut |size| n += size);
            (n, Some(offsets(kind, sizes)))
        }
    };
    if let Some(offsets) = offsets {
        let name = ("ElementStartOffset", "DataArray_t");
        let sizes = [planned.cells.len() as u64 + 1];
        draft.data(section, name, kind, &sizes, offsets);
    }
    let name = ("ElementConnectivity", "DataArray_t");
    let cells = planned.cells.clone();
    let listing = match planned.form {
        Form::Mixed => Listing::CgnsMixed,
        _ => Listing::Cgns,
    };
    let is_wide = kind == DataType::I8;
    let numbers = NodesOfCells::new(cells.clone(), listing, is_wide);
    if let Some(numbers) = mesh.nodes_apart(numbers) {
        draft.data(section, name, kind, &[n as u64], Data::Remote(numbers));
        return;
    }
    let own = |node| node;
    let data = match planned.form {
        Form::Fixed(_) | Form::Polygons => {
            Data::made(move |sink| list_elements(mesh.cells, cells.clone(), is_wide, &own, sink))
        }
        Form::Mixed => {
            Data::made(move |sink| list_mixed(mesh.cells, cells.clone(), is_wide, &own, sink))
        }
        Form::Polyhedra => {
            Data::made(move |sink| polyhedra(mesh, cells.clone(), faces, kind, sink))
        }
    };
    draft.data(section, name, kind, &[n as u64], data);
}

/// Adds the section of those faces of polyhedra that are no cells.
pub(super) fn add_faces<'a>(
    draft: &mut Draft<'a>,
    zone: NodeIndex,
    name: &str,
    faces: &'a FaceTable,
    kind: DataType,
) {
    let first = faces.first_element() as i64;
    let range = [first, first + faces.len() as i64 - 1];
    let section = header(draft, zone, name, (NGON_N, 0), range, kind);
    let sizes = move |emit: &mut dyn FnMut(usize)| faces.iter().for_each(|face| emit(face.len()));
    let name = ("ElementStartOffset", "DataArray_t");
    let n = [faces.len() as u64 + 1];
    draft.data(section, name, kind, &n, offsets(kind, sizes));
    let nodes = Data::made(move |sink| {
        let mut buffer = Buffer::new(kind, sink);
        for face in faces.iter() {
            face.iter()
                .try_for_each(|&node| buffer.push(i64::from(node) + 1))?;
        }
        buffer.flush()
    });
    let name = ("ElementConnectivity", "DataArray_t");
    let n = [faces.n_entries() as u64];
    draft.data(section, name, kind, &n, nodes);
}

fn header(
    draft: &mut Draft,
    zone: NodeIndex,
    name: &str,
    (number, n_boundary): (i64, i64),
    range: [i64; 2],
    kind: DataType,
) -> NodeIndex {
    let data = [number, n_boundary];
    let section = draft.integers(zone, (name, "Elements_t"), DataType::I4, &[2], &data);
    let name = ("ElementRange", "IndexRange_t");
    draft.integers(section, name, kind, &[2], &range);
    section
}

/// Entries of each element.
fn sizes(mesh: &MeshView, cells: Range<usize>, number: i64, emit: &mut dyn FnMut(usize)) {
    for run in mesh.cells.runs_in(cells) {
        for i in 0..run.n_cells() {
            emit(match number {
                NFACE_N => n_faces(mesh, run.first_cell + i),
                MIXED => run.n_nodes + 1,
                _ => run.n_nodes,
            });
        }
    }
}

fn n_faces(mesh: &MeshView, cell: usize) -> usize {
    let stream = mesh.cells.face_stream(cell);
    stream
        .and_then(|stream| stream.first())
        .map_or(0, |&n| n as usize)
}

fn offsets<'a>(
    kind: DataType,
    sizes: impl Fn(&mut dyn FnMut(usize)) + Send + Sync + 'a,
) -> Data<'a> {
    Data::made(move |sink| {
        let mut buffer = Buffer::new(kind, sink);
        buffer.push(0)?;
        let mut offset = 0;
        let mut pushed = Ok(());
        sizes(&mut |size| {
            offset += size as i64;
            if pushed.is_ok() {
                pushed = buffer.push(offset);
            }
        });
        pushed?;
        buffer.flush()
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
        let order = order(&run);
        let order = order.as_deref();
        for block in run.connectivity.chunks(BLOCK * 8 * run.n_nodes) {
            match is_wide {
                true => sink(bytemuck::cast_slice(&numbers(
                    block,
                    order,
                    run.n_nodes,
                    |n| i64::from(number(n)) + 1,
                )))?,
                false => sink(bytemuck::cast_slice(&numbers(
                    block,
                    order,
                    run.n_nodes,
                    |n| (number(n) + 1) as i32,
                )))?,
            }
        }
    }
    Ok(())
}

/// Where the nodes of an element come from in a cell, if not from the same place.
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
    let kind = match is_wide {
        true => DataType::I8,
        false => DataType::I4,
    };
    let mut buffer = Buffer::new(kind, sink);
    for run in cells.runs_in(range) {
        let element = ElementType::of(run.kind, run.n_nodes).expect("the plan has looked at it");
        let order = element.cgns_from_vtk();
        for nodes in run.cells() {
            buffer.push(element.number)?;
            for i in 0..nodes.len() {
                let from = order.as_ref().map_or(i, |order| order[i]);
                buffer.push(i64::from(number(nodes[from])) + 1)?;
            }
        }
    }
    buffer.flush()
}

fn polyhedra(
    mesh: &MeshView,
    cells: Range<usize>,
    faces: &FaceTable,
    kind: DataType,
    sink: Sink,
) -> Result<()> {
    let mut buffer = Buffer::new(kind, sink);
    for cell in cells {
        for &face in faces.of_polyhedron(mesh, cell) {
            buffer.push(face)?;
        }
    }
    buffer.flush()
}

/// Gathers integers into blocks of bytes.
struct Buffer<'s> {
    kind: DataType,
    numbers: Vec<i64>,
    sink: Sink<'s>,
}

impl<'s> Buffer<'s> {
    fn new(kind: DataType, sink: Sink<'s>) -> Self {
        Self {
            kind,
            numbers: Vec::with_capacity(BLOCK),
            sink,
        }
    }

    fn push(&mut self, number: i64) -> Result<()> {
        self.numbers.push(number);
        match self.numbers.len() {
            BLOCK => self.flush(),
            _ => Ok(()),
        }
    }

    fn flush(&mut self) -> Result<()> {
        stream_integers(self.numbers.drain(..), self.kind == DataType::I8, self.sink)
    }
}
