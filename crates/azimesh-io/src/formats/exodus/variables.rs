//! Results at a step, and global numbers of nodes and elements, as arrays of the mesh.

use super::super::Notes;
use super::super::netcdf::{File, Variable};
use super::super::pieces::{Piece, joined, with_vectors};
use super::blocks::{Block, lines};
use super::sides::Faces;
use crate::mesh::{DataArray, Values};
use azimesh_core::error::Result;

/// Array of the global numbers of the nodes, as VTK calls it.
const NODE_IDS: &str = "GlobalNodeId";
/// Array of the global numbers of the elements.
const ELEMENT_IDS: &str = "GlobalElementId";

/// Arrays at the nodes.
pub(super) fn at_nodes(
    file: &File,
    n_nodes: usize,
    step: Option<usize>,
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let mut arrays = Vec::new();
    if let Some(ids) = ids(file, "node_num_map", n_nodes)? {
        arrays.push(DataArray::scalar(NODE_IDS, Values::I64(ids)));
    }
    let Some(step) = step else {
        return Ok(arrays);
    };
    let names = lines(file, "name_nod_var", notes)?;
    let mut scalars = Vec::new();
    // Files of before version 4 have all in one variable.
    let together = file.variable("vals_nod_var")?;
    for (i, name) in names.into_iter().enumerate() {
        let values = match &together {
            Some(all) => of_all(all, step, i, n_nodes)?,
            None => match file.variable(&format!("vals_nod_var{}", i + 1))? {
                Some(variable) => at_step(&variable, step, n_nodes)?,
                None => continue,
            },
        };
        scalars.push(DataArray::scalar(name, values));
    }
    arrays.extend(with_vectors(scalars, vector));
    Ok(arrays)
}

/// Arrays at the cells; a face of a side set has the values of the element that it is a side of.
pub(super) fn at_cells(
    file: &File,
    blocks: &[Block],
    faces: &Faces,
    step: Option<usize>,
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let mut arrays = Vec::new();
    if let Some(mut ids) = ids(file, "elem_num_map", faces.first)? {
        ids.extend(of_faces(&ids, faces, -1));
        arrays.push(DataArray::scalar(ELEMENT_IDS, Values::I64(ids)));
    }
    let Some(step) = step else {
        return Ok(arrays);
    };
    let mut scalars = Vec::new();
    for (i, name) in lines(file, "name_elem_var", notes)?.into_iter().enumerate() {
        let mut pieces = Vec::new();
        for block in blocks {
            let variable = format!("vals_elem_var{}eb{}", i + 1, block.place);
            let Some(variable) = file.variable(&variable)? else {
                continue;
            };
            let values = at_step(&variable, step, block.cells.len())?;
            let values = match values {
                Values::F32(_) | Values::F64(_) => values,
                other => Values::F64(other.to_f64().unwrap_or_default()),
            };
            let at = vec![block.cells.clone()];
            pieces.push(Piece { at, values });
        }
        if !pieces.is_empty() {
            scalars.push(DataArray::scalar(name, joined_with_faces(pieces, faces)));
        }
    }
    arrays.extend(with_vectors(scalars, vector));
    Ok(arrays)
}

/// Values of the mesh as a whole.
pub(super) fn of_mesh(
    file: &File,
    step: Option<usize>,
    notes: &mut Notes,
) -> Result<Vec<DataArray>> {
    let (Some(step), Some(variable)) = (step, file.variable("vals_glo_var")?) else {
        return Ok(Vec::new());
    };
    let names = lines(file, "name_glo_var", notes)?;
    let values = at_step(&variable, step, names.len())?;
    let single = |(i, name): (usize, String)| DataArray::scalar(name, values.select(1, &[i]));
    Ok(names.into_iter().enumerate().map(single).collect())
}

/// Global numbers, where they are other than the places in the file.
fn ids(file: &File, name: &str, n: usize) -> Result<Option<Vec<i64>>> {
    let Some(variable) = file.variable(name)? else {
        return Ok(None);
    };
    let ids = variable.integers()?;
    if ids.len() != n {
        return Err(variable.refuse(format!("it has {} values; there are {n}", ids.len())));
    }
    let differ = ids.iter().zip(1..).any(|(id, place)| *id != place);
    Ok(differ.then_some(ids))
}

/// The values of a variable of times at a step.
fn at_step(variable: &Variable, step: usize, n: usize) -> Result<Values> {
    let values = variable.rows(step..step + 1)?.into_values();
    let values = values.ok_or_else(|| variable.refuse("it must have numbers"))?;
    if values.len() == n {
        Ok(values)
    } else {
        Err(variable.refuse(format!("it has {} values at a time, not {n}", values.len())))
    }
}

/// The values of the variable of index `i` among all at the nodes.
fn of_all(all: &Variable, step: usize, i: usize, n_nodes: usize) -> Result<Values> {
    let n_variables = all.shape().get(1).copied().unwrap_or(0);
    let wrong = || {
        all.refuse(format!(
            "it has values of {n_variables} variables, not of {}",
            i + 1
        ))
    };
    if i >= n_variables {
        return Err(wrong());
    }
    let total = n_variables.checked_mul(n_nodes).ok_or_else(wrong)?;
    let values = at_step(all, step, total)?;
    let own: Vec<usize> = (i * n_nodes..(i + 1) * n_nodes).collect();
    Ok(values.select(1, &own))
}

/// Values of elements from the blocks that have them, and of the faces of elements; NaN elsewhere.
fn joined_with_faces(pieces: Vec<Piece>, faces: &Faces) -> Values {
    let mut values = joined(pieces, faces.first);
    match &mut values {
        Values::F32(values) => values.extend(of_faces(values, faces, f32::NAN)),
        Values::F64(values) => values.extend(of_faces(values, faces, f64::NAN)),
        _ => unreachable!("they are floating-point numbers"),
    }
    values
}

/// The values of the elements that faces are sides of.
fn of_faces<T: Copy>(values: &[T], faces: &Faces, none: T) -> Vec<T> {
    let of = |cell: &u32| values.get(*cell as usize).copied().unwrap_or(none);
    faces.of_cells.iter().map(of).collect()
}

/// The name of the vector whose first component is a scalar, and the names of the others: `displ_x`, `displ_y` and
/// `displ_z` are `displ`.
fn vector(first: &str) -> Option<(String, [String; 2])> {
    let axes = match first.as_bytes().last()? {
        b'x' => ["y", "z"],
        b'X' => ["Y", "Z"],
        _ => return None,
    };
    let start = &first[..first.len() - 1];
    // Two axes are a component of a tensor.
    let is_tensor = start.ends_with(|c: char| "xyzXYZ".contains(c));
    let stem = start.strip_suffix('_').unwrap_or(start);
    let names = || (stem.to_owned(), axes.map(|axis| format!("{start}{axis}")));
    (!is_tensor && !stem.is_empty()).then(names)
}
