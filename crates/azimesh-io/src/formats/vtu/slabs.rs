//! A .vtu file by slabs: parts of its arrays, which lie in the file as raw values.
//!
//! What is odd or damaged is left to the reader of the whole file.

use super::super::slabs::{Refusal, Slabs, overlapping, points_of, whole};
use super::super::vtk::cells::CellTable;
use super::super::vtk::chunk::Chunk;
use super::super::vtk::number::Element;
use super::super::vtk::split::{is_collection, kind, type_name};
use super::super::vtk::{order, tags};
use super::arrays::{data, field};
use super::cells::not_a_node;
use super::collect::count;
use super::document::{self, Document, Grid, Piece};
use super::read::{self, FIRST_WITH_PRESENT_ORDER};
use super::stored::Stored;
use super::xml::{Array, DataEncoding, Layout, as_utf8};
use crate::formats::{Compression, Notes, ReadOptions};
use crate::mesh::{CellKind, Cells, Mesh};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::borrow::Cow;
use std::ops::Range;

/// Cells that are looked at together.
const BLOCK: usize = 1 << 14;

type Found<T> = std::result::Result<T, Refusal>;

/// The arrays of all pieces.
struct Pieces<'a> {
    document: Document<'a>,
    /// The array of boundary tags, where the user has chosen one.
    tag_array: Option<String>,
    pieces: Vec<Values<'a>>,
    /// Whether hexahedra of high order have VTK's old order of nodes.
    has_old_order: bool,
}

/// The arrays of one piece.
struct Values<'a> {
    /// Its nodes in the mesh.
    nodes: Range<usize>,
    /// Its cells in the mesh.
    cells: Range<usize>,
    points: Chunk<'a>,
    types: Chunk<'a>,
    offsets: Chunk<'a>,
    connectivity: Chunk<'a>,
}

/// Finds the arrays of a file.
pub(super) fn open<'a>(bytes: &'a [u8], options: &ReadOptions) -> Found<impl Slabs + use<'a>> {
    let Cow::Borrowed(bytes) = as_utf8(bytes, &mut Notes::default()) else {
        return Err(whole("its XML is not UTF-8"));
    };
    let mut document = document::parse(bytes)?;
    let mut notes = Notes::default();
    document.tell_arrays_apart(&mut notes);
    if !notes.is_empty() {
        return Err(whole("arrays share a name"));
    }
    if document.grid != Grid::Unstructured {
        return Err(whole("it is no unstructured grid"));
    }
    if document.layout.compression != Compression::None {
        return Err(whole("its arrays are compressed"));
    }
    let mut pieces: Vec<Values> = Vec::new();
    for piece in &document.pieces {
        let last = pieces.last();
        let (node, cell) = last.map_or((0, 0), |last| (last.nodes.end, last.cells.end));
        pieces.push(Values::of(piece, &document.layout, node, cell)?);
    }
    if !document.has_marked_wedges && pieces.iter().any(Values::has_wedges) {
        return Err(whole(
            "all volumes say which order of nodes its wedges have",
        ));
    }
    if options.tag_array.is_none() {
        check_tags(&document, &pieces)?;
    }
    Ok(Pieces {
        pieces,
        has_old_order: document.version < FIRST_WITH_PRESENT_ORDER,
        document,
        tag_array: options.tag_array.clone(),
    })
}

/// The values of an array as they lie in the file.
fn raw<'a>(array: &Array<'a>, layout: &Layout) -> Found<Chunk<'a>> {
    let encoded = || whole(format!("array \"{}\" is text or base64", array.name));
    if array.encoding != DataEncoding::Raw {
        return Err(encoded());
    }
    Stored::open(array, layout)?.plain().ok_or_else(encoded)
}

/// The values of the integers of this name.
fn integers<'a>(arrays: &[Array<'a>], name: &str, layout: &Layout) -> Found<Chunk<'a>> {
    let array = arrays.iter().find(|array| array.name == name);
    let array = array.filter(|array| array.element.is_integer());
    let array = array.ok_or_else(|| whole(format!("it has no integers \"{name}\"")))?;
    raw(array, layout)
}

impl<'a> Values<'a> {
    /// The arrays of a piece whose first node and first cell are these.
    fn of(piece: &Piece<'a>, layout: &Layout, node: usize, cell: usize) -> Found<Self> {
        let n_nodes = count(piece.n_points)?;
        let n_cells = count(piece.n_cells)?;
        count((node + n_nodes) as u64)?;
        count((cell + n_cells) as u64)?;
        let points = piece.points.first();
        let of_cells = |name| match n_cells {
            0 => Ok(NO_VALUES),
            _ => integers(&piece.cells, name, layout),
        };
        let values = Self {
            nodes: node..node + n_nodes,
            cells: cell..cell + n_cells,
            points: points.map_or(Ok(NO_VALUES), |array| raw(array, layout))?,
            types: of_cells("types")?,
            offsets: of_cells("offsets")?,
            connectivity: of_cells("connectivity")?,
        };
        let has_points = match &piece.points[..] {
            [] => n_nodes == 0,
            [array] => array.n_components == 3 && array.element != Element::String,
            _ => false,
        };
        match has_points && values.are_complete() {
            true => Ok(values),
            false => Err(whole("its arrays are not as long as they should be")),
        }
    }

    /// Whether the arrays have as many values as the nodes and cells need.
    fn are_complete(&self) -> bool {
        let n_cells = self.cells.len();
        let has = |chunk: &Chunk, n| chunk.bytes.len() == n * chunk.element.size();
        let end = n_cells.checked_sub(1);
        has(&self.points, 3 * self.nodes.len())
            && has(&self.types, n_cells)
            && has(&self.offsets, n_cells)
            && has(&self.connectivity, self.connectivity.n_values())
            && end.is_none_or(|last| {
                self.offsets.integer(last) as u64 == self.connectivity.n_values() as u64
            })
    }

    /// Appends some of the cells, counted from the first of the piece, which are at least one.
    fn append(
        &self,
        cells: Range<usize>,
        has_old_order: bool,
        table: &mut CellTable,
    ) -> Result<()> {
        let types = self.types_of(cells.clone());
        if let Some(vtk) = types.iter().find(|vtk| needs_all(**vtk, has_old_order)) {
            let name = type_name(*vtk);
            let message = format!("a cell is a {name}, which is not read by slabs");
            return Err(Error::input(message).dataset("types"));
        }
        let start = cells.start.checked_sub(1);
        let start = start.map_or(0, |before| self.offsets.integer(before));
        let end = self.offsets.integer(cells.end - 1);
        let ends = self.offsets.part(cells);
        let entries = self.entries(start, end)?;
        let added = table.append_ends(&types, ends, entries.start as u64);
        added.map_err(|error| error.dataset("offsets"))?;
        let first = table.connectivity.len();
        table.connectivity.resize(first + entries.len(), 0);
        let nodes = &mut table.connectivity[first..];
        let n = self.nodes.len() as u64;
        let listed = self.connectivity.part(entries.clone());
        let converted = listed.indices(nodes, (0, n), self.nodes.start as u32);
        converted.map_err(|(at, value)| {
            not_a_node(entries.start + at, &value, n).dataset("connectivity")
        })
    }

    /// The entries of cells between two offsets.
    fn entries(&self, start: i64, end: i64) -> Result<Range<usize>> {
        let n = self.connectivity.n_values();
        let place = |offset| usize::try_from(offset).ok().filter(|at| *at <= n);
        match (place(start), place(end)) {
            (Some(start), Some(end)) if start <= end => Ok(start..end),
            _ => Err(Error::input(format!(
                "cells lie from {start} to {end}; there are {n} node indices"
            ))
            .dataset("offsets")),
        }
    }

    fn types_of(&self, cells: Range<usize>) -> Vec<u8> {
        let mut types = vec![0; cells.len()];
        self.types.part(cells).types(&mut types);
        types
    }

    fn has_wedges(&self) -> bool {
        (0..self.cells.len()).step_by(BLOCK).any(|start| {
            let types = self.types_of(start..self.cells.len().min(start + BLOCK));
            types.contains(&CellKind::Wedge.vtk())
        })
    }

    /// Whether a cell has a dimension and, where there are tags, one that is not 0.
    fn has_cell(&self, dimension: u8, tags: Option<Chunk>) -> bool {
        (0..self.cells.len()).step_by(BLOCK).any(|start| {
            let cells = start..self.cells.len().min(start + BLOCK);
            let mut numbers = vec![1; cells.len()];
            if let Some(tags) = tags {
                tags.part(cells.clone()).integers(&mut numbers);
            }
            let is_of_dimension = |vtk: u8| kind(vtk).map(CellKind::dimension) == Some(dimension);
            let types = self.types_of(cells);
            let mut cells = types.into_iter().zip(numbers);
            cells.any(|(vtk, number)| number != 0 && is_of_dimension(vtk))
        })
    }
}

/// An array that is not there.
const NO_VALUES: Chunk = Chunk {
    bytes: &[],
    element: Element::UInt8,
    swap: false,
};

/// Whether cells of this type are not read by slabs: those that are several cells or none, polyhedra, and hexahedra of
/// which an array has the degrees.
fn needs_all(vtk: u8, has_old_order: bool) -> bool {
    let kind = kind(vtk);
    let is_old = has_old_order && kind.is_some_and(order::concerns);
    is_collection(vtk) || kind == Some(CellKind::Polyhedron) || is_old
}

/// Refuses a mesh without solid cells that has tags on surface cells and on no edges: it may be the boundary of a solid,
/// which its flatness tells.
fn check_tags(document: &Document, pieces: &[Values]) -> Found<()> {
    let of_piece = |piece: &Piece| {
        let mut arrays = piece.cell_data.iter();
        arrays.any(|array| array.name == tags::BOUNDARY.array)
    };
    if !document.pieces.iter().any(of_piece) || pieces.iter().any(|piece| piece.has_cell(3, None)) {
        return Ok(());
    }
    let mut has_surface = false;
    for (piece, values) in document.pieces.iter().zip(pieces) {
        if values.cells.is_empty() {
            continue;
        }
        let tags = integers(&piece.cell_data, tags::BOUNDARY.array, &document.layout)?;
        if tags.n_values() != values.cells.len() {
            return Err(whole("the boundary tags are not one for each cell"));
        }
        if values.has_cell(1, Some(tags)) {
            return Ok(());
        }
        has_surface |= values.has_cell(2, Some(tags));
    }
    match has_surface {
        true => Err(whole("it may be the surface of a solid")),
        false => Ok(()),
    }
}

impl Slabs for Pieces<'_> {
    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        let (pieces, layout) = (&self.document.pieces, &self.document.layout);
        mesh.point_arrays = data(pieces, layout, "point", read::point_data, notes)?;
        mesh.cell_arrays = data(pieces, layout, "cell", read::cell_data, notes)?;
        for array in &self.document.field_data {
            let array = field(array, layout, notes)?;
            mesh.field_arrays.push(array);
        }
        Ok(tags::extract(mesh, self.tag_array.as_deref())?)
    }

    fn n_nodes(&self) -> usize {
        self.pieces.last().map_or(0, |last| last.nodes.end)
    }

    fn n_cells(&self) -> usize {
        self.pieces.last().map_or(0, |last| last.cells.end)
    }

    fn points(&self, nodes: Range<usize>) -> Result<Vec<Vector>> {
        let of_piece = |piece: &Values| piece.nodes.clone();
        points_of(&self.pieces, of_piece, nodes, |piece, own, out| {
            let values = piece.points.part(3 * own.start..3 * own.end);
            values.reals(out.as_flattened_mut());
            Ok(())
        })
    }

    fn cells(&self, cells: Range<usize>) -> Result<Cells> {
        let mut table = CellTable::new("types");
        for (piece, own) in overlapping(&self.pieces, |piece| piece.cells.clone(), cells) {
            piece.append(own, self.has_old_order, &mut table)?;
        }
        let mut cells = table.finish(&mut Notes::default())?.cells;
        cells.mirror_wedges();
        Ok(cells)
    }
}
