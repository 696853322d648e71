//! A .vtu file by slabs: parts of its arrays of raw values. Odd and damaged files are left to the reader of the whole.

use super::super::number::Chunk;
use super::super::slabs::{Refusal, Slabs, overlapping, points_of, whole};
use super::super::vtk::cells::CellTable;
use super::super::vtk::number::Element;
use super::super::vtk::polyhedra::PieceNodes;
use super::super::vtk::split::{is_collection, kind, type_name};
use super::super::vtk::structured::Grid;
use super::super::vtk::{ghosts, order, tags};
use super::document::{self, Document, Piece};
use super::read::{FIRST_WITH_PRESENT_ORDER, add_arrays};
use super::stored::Stored;
use super::values::count;
use super::xml::{Array, DataEncoding, as_utf8};
use crate::formats::{Compression, Notes, ReadOptions};
use crate::mesh::{CellKind, Cells, Mesh};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use std::borrow::Cow;
use std::ops::Range;

/// Cells that are looked at together.
const BLOCK: usize = 1 << 14;

type Found<T> = std::result::Result<T, Refusal>;

struct Pieces<'a> {
    document: Document<'a>,
    /// The array of boundary tags, where the user has chosen one.
    tag_array: Option<String>,
    pieces: Vec<Values<'a>>,
    /// True if hexahedra of high order have VTK's old order of nodes.
    has_old_order: bool,
}

struct Values<'a> {
    nodes: Range<usize>,
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
    if document.times.len() > 1 {
        return Err(whole("it has several steps"));
    }
    let mut arrays =
        (document.pieces.iter()).flat_map(|of| of.point_data.iter().chain(&of.cell_data));
    if arrays.any(|array| ghosts::is_mark(&array.name)) {
        return Err(whole("it may have ghost cells"));
    }
    if document.layout.compression != Compression::None {
        return Err(whole("its arrays are compressed"));
    }
    let mut pieces: Vec<Values> = Vec::new();
    for piece in &document.pieces {
        let last = pieces.last();
        let (node, cell) = last.map_or((0, 0), |last| (last.nodes.end, last.cells.end));
        pieces.push(Values::of(piece, node, cell)?);
    }
    if !document.has_marked_wedges && pieces.iter().any(Values::has_wedges) {
        let why = "all volumes say which order of nodes its wedges have";
        return Err(whole(why));
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

/// The values of an array that the file has as they are.
fn raw<'a>(array: &Array<'a>) -> Found<Chunk<'a>> {
    let encoded = || whole(format!("array \"{}\" is text or base64", array.name));
    if array.encoding != DataEncoding::Raw {
        return Err(encoded());
    }
    Stored::open(array)?.plain().ok_or_else(encoded)
}

/// The values of the integers of this name.
fn integers<'a>(arrays: &[Array<'a>], name: &str) -> Found<Chunk<'a>> {
    let array = arrays.iter().find(|array| array.name == name);
    let array = array.filter(|array| array.element.is_integer());
    raw(array.ok_or_else(|| whole(format!("it has no integers \"{name}\"")))?)
}

impl<'a> Values<'a> {
    /// The arrays of a piece whose first node and first cell are these.
    fn of(piece: &Piece<'a>, node: usize, cell: usize) -> Found<Self> {
        let n_nodes = count(piece.n_points)?;
        let n_cells = count(piece.n_cells)?;
        count((node + n_nodes) as u64)?;
        count((cell + n_cells) as u64)?;
        let of_cells = |name| match n_cells {
            0 => Ok(NO_VALUES),
            _ => integers(&piece.cells, name),
        };
        let values = Self {
            nodes: node..node + n_nodes,
            cells: cell..cell + n_cells,
            points: piece.points.first().map_or(Ok(NO_VALUES), raw)?,
            types: of_cells("types")?,
            offsets: of_cells("offsets")?,
            connectivity: of_cells("connectivity")?,
        };
        let has_points = match &piece.points[..] {
            [] => n_nodes == 0,
            [array] => array.n_components == 3 && array.element != Element::String,
            _ => false,
        };
        let n_entries = values.connectivity.n_values();
        let has = |chunk: &Chunk, n| chunk.bytes.len() == n * chunk.element.size();
        let are_complete = has_points
            && has(&values.points, 3 * n_nodes)
            && has(&values.types, n_cells)
            && has(&values.offsets, n_cells)
            && has(&values.connectivity, n_entries)
            && (n_cells == 0 || values.offsets.integer(n_cells - 1) as u64 == n_entries as u64);
        if are_complete {
            return Ok(values);
        }
        Err(whole("its arrays are not as long as they should be"))
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
        let n = self.connectivity.n_values();
        let place = |offset| usize::try_from(offset).ok().filter(|at| *at <= n);
        let entries = place(start)
            .zip(place(end))
            .filter(|(first, last)| first <= last);
        let (first, last) = entries.ok_or_else(|| {
            let message = format!("cells use entries {start} to {end}; there are {n} node indices");
            Error::input(message).dataset("offsets")
        })?;
        let added = table.append_ends(&types, self.offsets.part(cells), first as u64);
        added.map_err(|error| error.dataset("offsets"))?;
        let done = table.connectivity.len();
        table.connectivity.resize(done + last - first, 0);
        let nodes = PieceNodes {
            base: self.nodes.start as u32,
            limit: self.nodes.len() as u64,
        };
        let listed = self.connectivity.part(first..last);
        let added = nodes.indices(listed, first, &mut table.connectivity[done..]);
        added.map_err(|error| error.dataset("connectivity"))
    }

    fn types_of(&self, cells: Range<usize>) -> Vec<u8> {
        let mut types = vec![0; cells.len()];
        self.types.part(cells).narrow(&mut types, u8::MAX);
        types
    }

    /// Checks if any block of cells, whose types are passed too, has a property.
    fn any(&self, has: impl Fn(Range<usize>, Vec<u8>) -> bool) -> bool {
        let n = self.cells.len();
        (0..n).step_by(BLOCK).any(|start| {
            let cells = start..n.min(start + BLOCK);
            has(cells.clone(), self.types_of(cells))
        })
    }

    fn has_wedges(&self) -> bool {
        self.any(|_, types| types.contains(&CellKind::Wedge.vtk()))
    }

    /// Returns whether there is a cell of this dimension, with a tag other than 0 if there are tags.
    fn has_cell(&self, dimension: u8, tags: Option<Chunk>) -> bool {
        let is_of_dimension = |vtk: u8| kind(vtk).map(CellKind::dimension) == Some(dimension);
        self.any(|cells, types| {
            let mut numbers = vec![1; cells.len()];
            if let Some(tags) = tags {
                tags.part(cells).integers(&mut numbers);
            }
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

/// Returns whether cells of this type are not read by slabs: those that are several cells or none, polyhedra, and hexahedra of
/// which an array has the degrees.
fn needs_all(vtk: u8, has_old_order: bool) -> bool {
    let kind = kind(vtk);
    let is_old = has_old_order && kind.is_some_and(order::concerns);
    is_collection(vtk) || kind == Some(CellKind::Polyhedron) || is_old
}

/// Refuses a mesh without solid cells that has tags on surface cells and on no edges: it may be the boundary of a solid.
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
        let tags = integers(&piece.cell_data, tags::BOUNDARY.array)?;
        if tags.n_values() != values.cells.len() {
            return Err(whole("the boundary tags are not one for each cell"));
        }
        if values.has_cell(1, Some(tags)) {
            return Ok(());
        }
        has_surface |= values.has_cell(2, Some(tags));
    }
    if has_surface {
        return Err(whole("it may be the surface of a solid"));
    }
    Ok(())
}

impl Slabs for Pieces<'_> {
    fn complete(&self, mesh: &mut Mesh, notes: &mut Notes) -> Found<()> {
        add_arrays(&self.document, mesh, notes)?;
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
