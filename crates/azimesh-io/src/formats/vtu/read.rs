//! A .vtu file as a mesh: nodes and arrays of all pieces, one after another.

use super::super::vtk::cells::repeat_tuples;
use super::super::vtk::{order, tags};
use super::arrays::{data, field};
use super::collect::points;
use super::document::{self, Document, Grid, Piece};
use super::xml::{Array, as_utf8};
use super::{cells, structured};
use crate::formats::{Notes, ReadOptions};
use crate::mesh::Mesh;
use azimesh_core::error::Result;

/// XML of this version on has hexahedra of high order in VTK's present order of nodes.
pub(super) const FIRST_WITH_PRESENT_ORDER: (u32, u32) = (2, 1);

/// Reads a mesh. Pieces share no nodes; arrays that not all pieces have are left out.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let raw = raw(bytes, notes)?;
    let mut mesh = raw.mesh;
    order::turn_wedges(&mut mesh, raw.has_marked_wedges, notes);
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    Ok(mesh)
}

/// The mesh of a file with every array and the nodes of wedges as stored, and the names of the arrays with global numbers.
pub(in crate::formats) struct Raw {
    /// The mesh, without groups.
    pub mesh: Mesh,
    /// Whether it has no wedges but in the order of VTK up to 9.6, as the file is marked.
    pub has_marked_wedges: bool,
    /// Point array with the number of each node in a mesh of several files.
    pub global_nodes: Option<String>,
    /// Cell array with the number of each cell in a mesh of several files.
    pub global_cells: Option<String>,
}

/// Reads a file without interpreting its arrays.
pub(in crate::formats) fn raw(bytes: &[u8], notes: &mut Notes) -> Result<Raw> {
    let bytes = &*as_utf8(bytes, notes);
    let mut document = document::parse(bytes)?;
    document.tell_arrays_apart(notes);
    let (mut mesh, origin) = match document.grid {
        Grid::Unstructured | Grid::Poly => unstructured(&mut document, notes)?,
        _ => {
            let mesh = structured::read(&mut document, bytes.len());
            (mesh.map_err(|error| error.dataset("Extent"))?, None)
        }
    };
    let (pieces, layout) = (&document.pieces, &document.layout);
    mesh.point_arrays = data(pieces, layout, "point", point_data, notes)?;
    mesh.cell_arrays = data(pieces, layout, "cell", cell_data, notes)?;
    for array in &document.field_data {
        mesh.field_arrays.push(field(array, layout, notes)?);
    }
    if let Some(origin) = &origin {
        repeat_tuples(&mut mesh.cell_arrays, origin);
    }
    if document.version < FIRST_WITH_PRESENT_ORDER {
        order::swap(&mut mesh, notes);
    }
    let first = pieces.iter().find(|piece| piece.n_points > 0);
    Ok(Raw {
        has_marked_wedges: document.has_marked_wedges || !order::has_wedges(&mesh.cells),
        mesh,
        global_nodes: first.and_then(|piece| piece.global_nodes.clone()),
        global_cells: first.and_then(|piece| piece.global_cells.clone()),
    })
}

/// Points and cells that are listed; where each cell comes from, unless all are as listed.
fn unstructured(document: &mut Document, notes: &mut Notes) -> Result<(Mesh, Option<Vec<usize>>)> {
    let points = points(&document.pieces, &document.layout)?;
    let built = match document.grid {
        Grid::Poly => cells::read_lists(&mut document.pieces, &document.layout, notes),
        _ => cells::read(&document.pieces, &document.layout, notes),
    };
    let built = built.map_err(|error| error.dataset("Cells"))?;
    let mesh = Mesh {
        points,
        cells: built.cells,
        ..Mesh::default()
    };
    Ok((mesh, built.origin))
}

pub(super) fn point_data<'d, 'a>(piece: &'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>) {
    (piece.n_points, &piece.point_data)
}

pub(super) fn cell_data<'d, 'a>(piece: &'d Piece<'a>) -> (u64, &'d Vec<Array<'a>>) {
    (piece.n_cells, &piece.cell_data)
}
