//! A VTK XML file as a mesh: nodes and arrays of all pieces, one after another. Structured grids, rectilinear grids and
//! images are read as the cells that they imply.

use super::super::vtk::number::Element;
use super::super::vtk::structured::Grid;
use super::super::vtk::{ghosts, order, structured, tags};
use super::cells;
use super::document::{self, Document};
use super::values::{all, data, field, points};
use super::xml::{Array, as_utf8};
use crate::formats::{Notes, ReadOptions};
use crate::mesh::Mesh;
use crate::mesh::arrays::select_tuples;
use azimesh_core::error::{Error, Result};

/// XML of this version on has hexahedra of high order in VTK's present order of nodes.
pub(super) const FIRST_WITH_PRESENT_ORDER: (u32, u32) = (2, 1);

/// Reads a mesh. Pieces share no nodes; arrays that not all pieces have are left out.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let raw = raw(bytes, options.step, notes)?;
    let mut mesh = raw.mesh;
    ghosts::leave_out([&mut mesh], notes);
    order::turn_wedges(&mut mesh, raw.has_marked_wedges, notes);
    tags::extract(&mut mesh, options.tag_array.as_deref())?;
    Ok(mesh)
}

/// The mesh of a file with every array and the nodes of wedges as stored, and the names of the arrays with global numbers.
pub(in crate::formats) struct Raw {
    pub mesh: Mesh,
    /// True if it has no wedges but in the order of VTK up to 9.6, as the file is marked.
    pub has_marked_wedges: bool,
    /// Point array with the number of each node in a mesh of several files.
    pub global_nodes: Option<String>,
    /// Cell array with the number of each cell in a mesh of several files.
    pub global_cells: Option<String>,
}

/// Reads a step of a file, by default the last one, without interpreting its arrays.
pub(in crate::formats) fn raw(bytes: &[u8], step: Option<usize>, notes: &mut Notes) -> Result<Raw> {
    let bytes = &*as_utf8(bytes, notes);
    let mut document = document::parse(bytes)?;
    document.keep_step(step)?;
    document.tell_arrays_apart(notes);
    let (mut mesh, mut origin) = (Mesh::default(), None);
    match document.grid {
        Grid::Unstructured | Grid::Poly => {
            mesh.points = points(&document.pieces)?;
            let is_poly = document.grid == Grid::Poly;
            let built = cells::read(&mut document.pieces, is_poly, notes);
            let built = built.map_err(|error| error.dataset("Cells"))?;
            (mesh.cells, origin) = (built.cells, built.origin);
        }
        _ => {
            let block = block(&mut document, bytes.len());
            mesh = block.map_err(|error| error.dataset("Extent"))?;
        }
    }
    add_arrays(&document, &mut mesh, notes)?;
    if let Some(origin) = &origin {
        select_tuples(&mut mesh.cell_arrays, origin);
    }
    if document.version < FIRST_WITH_PRESENT_ORDER {
        order::swap(&mut mesh, notes);
    }
    let first = document.pieces.iter().find(|piece| piece.n_points > 0);
    Ok(Raw {
        has_marked_wedges: document.has_marked_wedges || !order::has_wedges(&mesh.cells),
        mesh,
        global_nodes: first.and_then(|piece| piece.global_nodes.clone()),
        global_cells: first.and_then(|piece| piece.global_cells.clone()),
    })
}

/// Reads the arrays at nodes, at cells and of the whole.
pub(super) fn add_arrays(document: &Document, mesh: &mut Mesh, notes: &mut Notes) -> Result<()> {
    let pieces = &document.pieces;
    mesh.point_arrays = data(pieces, "point", |p| (p.n_points, &p.point_data), notes)?;
    mesh.cell_arrays = data(pieces, "cell", |p| (p.n_cells, &p.cell_data), notes)?;
    let fields = document.field_data.iter().map(|array| field(array, notes));
    mesh.field_arrays = fields.collect::<Result<_>>()?;
    Ok(())
}

/// Nodes and cells of a structured grid, a rectilinear grid or an image; sets their numbers in the piece.
fn block(document: &mut Document, n_bytes: usize) -> Result<Mesh> {
    let [piece] = document.pieces.as_mut_slice() else {
        let n = document.pieces.len();
        return Err(Error::input(format!(
            "the structured grid has {n} pieces; only grids of one piece are read"
        )));
    };
    let missing = || Error::input("the piece has no Extent");
    let extent = piece.extent.ok_or_else(missing)?;
    let dimensions = dimensions(extent)?;
    let n_points = structured::n_points(dimensions)?;
    structured::check_implied(n_points, n_bytes)?;
    piece.n_points = n_points as u64;
    piece.n_cells = structured::n_cells(dimensions) as u64;
    let points = match document.grid {
        Grid::Structured => points(&document.pieces)?,
        Grid::Rectilinear => {
            let axes = axes(&document.pieces[0].cells, dimensions)?;
            structured::points([&axes[0], &axes[1], &axes[2]])
        }
        _ => image(document, extent, dimensions),
    };
    Ok(Mesh {
        points,
        cells: structured::cells(dimensions, 0),
        ..Mesh::default()
    })
}

fn dimensions(extent: [i64; 6]) -> Result<[usize; 3]> {
    let mut dimensions = [0; 3];
    for (i, n) in dimensions.iter_mut().enumerate() {
        let (first, last) = (extent[2 * i], extent[2 * i + 1]);
        let along = last.checked_sub(first).and_then(|n| n.checked_add(1));
        let along = along.and_then(|n| usize::try_from(n).ok());
        *n = along.ok_or_else(|| {
            Error::input(format!(
                "the Extent along axis {i} goes from {first} to {last}; it must not end before it starts"
            ))
        })?;
    }
    Ok(dimensions)
}

fn axes(arrays: &[Array], dimensions: [usize; 3]) -> Result<[Vec<f64>; 3]> {
    let [x, y, z] = arrays else {
        let found = arrays.len();
        let message = format!("there must be 3 arrays of coordinates, found {found}");
        return Err(Error::input(message).dataset("Coordinates"));
    };
    let read = |array: &Array, n| match array.element {
        Element::String => Err(Error::input("coordinates must be numbers").dataset("Coordinates")),
        _ => all(array, Some(n), |chunk, out| chunk.reals(out)),
    };
    let [n_x, n_y, n_z] = dimensions;
    Ok([read(x, n_x)?, read(y, n_y)?, read(z, n_z)?])
}

fn image(document: &Document, extent: [i64; 6], dimensions: [usize; 3]) -> Vec<[f64; 3]> {
    let (origin, spacing) = (document.origin, document.spacing);
    let along = |i: usize, start: f64| -> Vec<f64> {
        let steps = (0..dimensions[i]).map(|k| (extent[2 * i] + k as i64) as f64);
        steps.map(|k| start + k * spacing[i]).collect()
    };
    let grid = |[x, y, z]: [f64; 3]| structured::points([&along(0, x), &along(1, y), &along(2, z)]);
    let unit = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let Some(direction) = document.direction.filter(|axes| *axes != unit) else {
        return grid(origin);
    };
    let mut points = grid([0.0; 3]);
    for point in &mut points {
        let [a, b, c] = *point;
        for ((x, row), origin) in point.iter_mut().zip(direction.chunks(3)).zip(origin) {
            *x = origin + row[0] * a + row[1] * b + row[2] * c;
        }
    }
    points
}
