//! Reads files of node displacements, for mode shapes and surface motions alike: tables with a column that
//! names the node, and arrays of a mesh.

use super::nodes::At;
use crate::motion::table::{Column, Columns, Table};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::diagnostic::motion::MotionNote;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_io::mesh::Mesh;
use std::path::Path;

/// Columns that say which node a row belongs to: `node`, or `x`, `y`, `z`.
pub(super) enum PlaceColumns {
    Node(Column),
    Place([Option<Column>; 3]),
}

pub(super) fn place_columns(columns: &mut Columns<'_>, in_plane: bool) -> Result<PlaceColumns> {
    if !columns.has("x") {
        return Ok(PlaceColumns::Node(columns.require("node")?));
    }
    if columns.has("node") {
        return Err(columns.both("node", "x"));
    }
    Ok(PlaceColumns::Place(three(
        columns,
        ["x", "y", "z"],
        in_plane,
    )?))
}

/// Three columns, of which the last may be left out in the plane.
pub(super) fn three(
    columns: &mut Columns<'_>,
    [x, y, z]: [&str; 3],
    in_plane: bool,
) -> Result<[Option<Column>; 3]> {
    let [x, y] = [x, y].map(|name| columns.require(name));
    let z = if in_plane {
        columns.optional(z)
    } else {
        Some(columns.require(z)?)
    };
    Ok([Some(x?), Some(y?), z])
}

/// The values of three columns in a row; one left out is 0.
pub(super) fn vector(table: &Table, row: usize, axes: [Option<Column>; 3]) -> Vector {
    axes.map(|axis| axis.map_or(0.0, |axis| table.value(row, axis)))
}

impl PlaceColumns {
    pub fn at(&self, table: &Table, row: usize) -> Result<At> {
        Ok(match self {
            Self::Node(node) => At::Node(table.whole(row, *node)?),
            Self::Place(axes) => At::Place(vector(table, row, *axes)),
        })
    }
}

/// A point array of three components with its name.
pub(super) type NamedVectors = (String, Vec<Vector>);

/// The points of a mesh file and its point arrays of three components.
pub(super) fn arrays_of(path: &Path) -> Result<(Vec<Vector>, Vec<NamedVectors>)> {
    let mesh = Mesh::read(path)?;
    let mut arrays = Vec::new();
    for array in (mesh.point_arrays.iter()).filter(|array| array.n_components == 3) {
        if let Some(values) = array.values.to_f64() {
            let (vectors, _) = values.as_chunks::<3>();
            arrays.push((array.name.clone(), vectors.to_vec()));
        }
    }
    let finite = |(_, vectors): &NamedVectors| vectors.iter().flatten().all(|x| x.is_finite());
    if let Some((name, _)) = arrays.iter().find(|array| !finite(array)) {
        let message = "the array holds a value that is not a finite number";
        return Err(Error::input(message).dataset(name).file(path));
    }
    Ok((mesh.points, arrays))
}

/// A note on rows that are for nodes of others.
pub(super) fn unused(rows: usize, path: &Path, body: &str) -> Vec<Diagnostic> {
    let body = body.to_owned();
    let note = (rows > 0).then_some(MotionNote::OtherNodes { rows, body });
    note.map(|note| Diagnostic::new(note).file(path))
        .into_iter()
        .collect()
}
