//! Structured grids, rectilinear grids and images in XML, as the cells that they imply.

use super::super::vtk::number::Element;
use super::super::vtk::structured;
use super::collect::{collect, points};
use super::document::{Document, Grid, Piece};
use super::xml::{Array, Layout};
use crate::mesh::Mesh;
use azimesh_core::error::{Error, Result};

/// Nodes and cells; sets the numbers of them of the piece.
pub(super) fn read(document: &mut Document, n_bytes: usize) -> Result<Mesh> {
    let [piece] = document.pieces.as_mut_slice() else {
        let n = document.pieces.len();
        return Err(Error::input(format!(
            "the structured grid has {n} pieces; only grids of one piece are read"
        )));
    };
    let extent = piece.extent;
    let extent = extent.ok_or_else(|| Error::input("the piece has no Extent"))?;
    let dimensions = dimensions(extent)?;
    let n_points = structured::n_points(dimensions)?;
    structured::check_implied(n_points, n_bytes)?;
    piece.n_points = n_points as u64;
    piece.n_cells = structured::n_cells(dimensions) as u64;
    let layout = &document.layout;
    let points = match document.grid {
        Grid::Structured => points(&document.pieces, layout)?,
        Grid::Rectilinear => {
            let axes = axes(&document.pieces[0], dimensions, layout)?;
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

fn axes(piece: &Piece, dimensions: [usize; 3], layout: &Layout) -> Result<[Vec<f64>; 3]> {
    let [x, y, z] = piece.cells.as_slice() else {
        let found = piece.cells.len();
        let message = format!("there must be 3 arrays of coordinates, found {found}");
        return Err(Error::input(message).dataset("Coordinates"));
    };
    let read = |array: &Array, n| -> Result<Vec<f64>> {
        if array.element == Element::String {
            return Err(Error::input("coordinates must be numbers").dataset("Coordinates"));
        }
        let mut out = Vec::new();
        collect(array, layout, 1, Some(n), &mut out, &|chunk, out| {
            chunk.reals(out);
            Ok(())
        })?;
        Ok(out)
    };
    let [n_x, n_y, n_z] = dimensions;
    Ok([read(x, n_x)?, read(y, n_y)?, read(z, n_z)?])
}

fn image(document: &Document, extent: [i64; 6], dimensions: [usize; 3]) -> Vec<[f64; 3]> {
    let (origin, spacing) = (document.origin, document.spacing);
    let turned = document
        .direction
        .filter(|d| *d != [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let axis = |i: usize, start: f64| -> Vec<f64> {
        let steps = (0..dimensions[i]).map(|k| (extent[2 * i] + k as i64) as f64);
        steps.map(|k| start + k * spacing[i]).collect()
    };
    let Some(direction) = turned else {
        let [x, y, z] = [0, 1, 2].map(|i| axis(i, origin[i]));
        return structured::points([&x, &y, &z]);
    };
    let [x, y, z] = [0, 1, 2].map(|i| axis(i, 0.0));
    let mut points = structured::points([&x, &y, &z]);
    for point in &mut points {
        let along = *point;
        for (i, x) in point.iter_mut().enumerate() {
            let row = &direction[3 * i..3 * i + 3];
            *x = origin[i] + row[0] * along[0] + row[1] * along[1] + row[2] * along[2];
        }
    }
    points
}
