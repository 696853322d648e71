//! Meshes made of arrays.

use crate::arguments;
use crate::error::{input, raised};
use crate::kinds;
use crate::mesh::data_arrays;
use azimesh::{CellKind, Cells, Mesh};
use azimesh_io::mesh::{CellSet, Group};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// What a mesh is made of, besides points and cells.
#[derive(Default)]
pub struct Parts<'a, 'py> {
    pub tags: Option<&'a Bound<'py, PyDict>>,
    pub zones: Option<&'a Bound<'py, PyDict>>,
    pub point_data: Option<&'a Bound<'py, PyDict>>,
    pub cell_data: Option<&'a Bound<'py, PyDict>>,
    pub field_data: Option<&'a Bound<'py, PyDict>>,
}

/// A mesh of points (n, 3), and blocks of cells `(type, connectivity)` in order.
pub fn make(
    points: &Bound<'_, PyAny>,
    cells: &Bound<'_, PyAny>,
    parts: &Parts<'_, '_>,
) -> PyResult<Mesh> {
    let mut mesh = Mesh {
        points: arguments::vectors(points, "points")?,
        cells: blocks(cells)?,
        point_arrays: data_arrays(parts.point_data)?,
        cell_arrays: data_arrays(parts.cell_data)?,
        field_arrays: data_arrays(parts.field_data)?,
        ..Mesh::default()
    };
    let dimension = mesh.dimension();
    mesh.groups = groups(parts.zones, dimension)?;
    mesh.groups
        .extend(groups(parts.tags, dimension.saturating_sub(1))?);
    mesh.validate()
        .map_err(|error| raised(points.py(), &error))?;
    Ok(mesh)
}

fn groups(given: Option<&Bound<'_, PyDict>>, dimension: u8) -> PyResult<Vec<Group>> {
    let mut groups = Vec::new();
    for (name, cells) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        let cells = arguments::indices(&cells, &format!("the cells of \"{name}\""))?;
        groups.push(Group {
            dimension,
            name,
            number: None,
            condition: None,
            cells: cells
                .into_iter()
                .map(|cell| cell as usize)
                .collect::<CellSet>(),
        });
    }
    Ok(groups)
}

fn blocks(given: &Bound<'_, PyAny>) -> PyResult<Cells> {
    let py = given.py();
    let items = match given.cast::<PyDict>() {
        Ok(dict) => dict.items().into_any(),
        Err(_) if given.hasattr("items")? => given.call_method0("items")?,
        Err(_) => given.clone(),
    };
    let mut cells = Cells::new();
    for item in items.try_iter()? {
        let (name, block): (String, Bound<'_, PyAny>) = item?.extract()?;
        let kind = kinds::kind(&name).ok_or_else(|| {
            input(
                py,
                format!(
                    "there is no type of cells \"{name}\"; names are those of meshio, such as tetra"
                ),
            )
        })?;
        match kind {
            CellKind::Polygon | CellKind::Polyhedron => push_ragged(&mut cells, kind, &block)?,
            _ => push_table(&mut cells, kind, &name, &block)?,
        }
    }
    Ok(cells)
}

fn push_table(
    cells: &mut Cells,
    kind: CellKind,
    name: &str,
    block: &Bound<'_, PyAny>,
) -> PyResult<()> {
    let (nodes, n_nodes) = arguments::table(block, &format!("the cells \"{name}\""))?;
    if !kind.can_have(n_nodes) {
        let message = format!("the cells \"{name}\" have {n_nodes} nodes each");
        let message = match kind.n_nodes() {
            Some(n) => format!("{message}; it must be {n}"),
            None => message,
        };
        return Err(input(block.py(), message));
    }
    check_room(block.py(), cells, nodes.len() / n_nodes)?;
    cells.push_run(kind, n_nodes, &nodes);
    Ok(())
}

/// Refuses more cells than their numbers can tell apart.
fn check_room(py: Python<'_>, cells: &Cells, more: usize) -> PyResult<()> {
    if cells.len() + more < u32::MAX as usize {
        Ok(())
    } else {
        Err(input(
            py,
            format!("there are more than {} cells", u32::MAX - 1),
        ))
    }
}

/// Polygons as `(nodes, offsets)`, polyhedra as `(faces, offsets)`: those of cell i are `values[offsets[i]:offsets[i + 1]]`.
fn push_ragged(cells: &mut Cells, kind: CellKind, block: &Bound<'_, PyAny>) -> PyResult<()> {
    let py = block.py();
    let pair = block.cast::<PyTuple>().ok().filter(|pair| pair.len() == 2);
    let Some(pair) = pair else {
        let name = kinds::name(kind);
        return Err(input(
            py,
            format!("the cells \"{name}\" must be a tuple (values, offsets)"),
        ));
    };
    let values = arguments::indices(&pair.get_item(0)?, "nodes and faces")?;
    let offsets = arguments::indices(&pair.get_item(1)?, "offsets")?;
    check_room(py, cells, offsets.len())?;
    for ends in offsets.windows(2) {
        let Some(cell) = values.get(ends[0] as usize..ends[1] as usize) else {
            let message = format!(
                "offsets go from {} to {}; they must rise up to {}",
                ends[0],
                ends[1],
                values.len()
            );
            return Err(input(py, message));
        };
        if kind == CellKind::Polyhedron {
            let pushed = cells.push_polyhedron(cell);
            pushed.map_err(|error| raised(py, &error))?;
        } else if kind.can_have(cell.len()) {
            cells.push(kind, cell);
        } else {
            return Err(input(
                py,
                format!("a polygon cannot have {} nodes", cell.len()),
            ));
        }
    }
    Ok(())
}
