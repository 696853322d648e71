//! Results at a step, and global numbers of nodes and elements, as arrays of the mesh.

use super::super::Notes;
use super::super::netcdf::{File, Variable};
use super::blocks::Block;
use super::blocks::lines;
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
        scalars.push((name, values));
    }
    arrays.extend(joined(scalars));
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
        let mut parts = Vec::new();
        for block in blocks {
            let variable = format!("vals_elem_var{}eb{}", i + 1, block.place);
            let Some(variable) = file.variable(&variable)? else {
                continue;
            };
            let values = at_step(&variable, step, block.cells.len())?;
            parts.push((block.cells.start, values));
        }
        if !parts.is_empty() {
            scalars.push((name, placed(parts, faces)));
        }
    }
    arrays.extend(joined(scalars));
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
    match values.len() == n {
        true => Ok(values),
        false => Err(variable.refuse(format!("it has {} values at a time, not {n}", values.len()))),
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

/// Values of elements from the blocks that have them, each with its first element; elsewhere there is no number.
fn placed(mut parts: Vec<(usize, Values)>, faces: &Faces) -> Values {
    let n = faces.first;
    let are_f32 = parts
        .iter()
        .all(|(_, values)| matches!(values, Values::F32(_)));
    if are_f32 {
        let mut all = vec![f32::NAN; n];
        for (first, values) in &parts {
            if let Values::F32(values) = values {
                all[*first..first + values.len()].copy_from_slice(values);
            }
        }
        all.extend(of_faces(&all, faces, f32::NAN));
        return Values::F32(all);
    }
    let mut all = match &mut parts[..] {
        [(0, Values::F64(values))] if values.len() == n => std::mem::take(values),
        parts => {
            let mut all = vec![f64::NAN; n];
            for (first, values) in parts {
                let values = reals(values);
                all[*first..*first + values.len()].copy_from_slice(&values);
            }
            all
        }
    };
    all.extend(of_faces(&all, faces, f64::NAN));
    Values::F64(all)
}

fn reals(values: &Values) -> Vec<f64> {
    match values {
        Values::F64(values) => values.clone(),
        Values::F32(values) => values.iter().map(|&x| x.into()).collect(),
        other => {
            let integers = other.to_integers().unwrap_or_default();
            integers.into_iter().map(|x| x as f64).collect()
        }
    }
}

/// The values of the elements that faces are sides of.
fn of_faces<T: Copy>(values: &[T], faces: &Faces, none: T) -> Vec<T> {
    let of = |cell: &u32| values.get(*cell as usize).copied().unwrap_or(none);
    faces.of_cells.iter().map(of).collect()
}

/// Scalars, of which three that are named by axes become vectors: `displ_x`, `displ_y` and `displ_z` become `displ`.
fn joined(scalars: Vec<(String, Values)>) -> Vec<DataArray> {
    let mut scalars: Vec<Option<(String, Values)>> = scalars.into_iter().map(Some).collect();
    let mut arrays = Vec::new();
    for i in 0..scalars.len() {
        let Some((name, values)) = scalars[i].take() else {
            continue;
        };
        arrays.push(match others(&name, &values, &scalars) {
            Some((stem, others)) => {
                let others = others.map(|i| scalars[i].take().expect("it was just found").1);
                vector(stem, &values, others)
            }
            None => DataArray::scalar(name, values),
        });
    }
    arrays
}

/// The name of a vector, and where its other components are, where this is the first.
fn others<'a>(
    name: &'a str,
    values: &Values,
    scalars: &[Option<(String, Values)>],
) -> Option<(&'a str, [usize; 2])> {
    let (axis, axes) = match name.as_bytes().last()? {
        b'x' => ('x', ['y', 'z']),
        b'X' => ('X', ['Y', 'Z']),
        _ => return None,
    };
    // Two axes are a component of a tensor.
    let is_axis = |c: char| "xyzXYZ".contains(c);
    let start = name
        .strip_suffix(axis)
        .filter(|start| !start.ends_with(is_axis))?;
    let find = |axis: char| {
        scalars.iter().position(|scalar| {
            scalar.as_ref().is_some_and(|(other, of)| {
                other.strip_suffix(axis) == Some(start)
                    && std::mem::discriminant(of) == std::mem::discriminant(values)
            })
        })
    };
    let stem = start.strip_suffix('_').unwrap_or(start);
    (!stem.is_empty()).then_some((stem, [find(axes[0])?, find(axes[1])?]))
}

fn vector(name: &str, x: &Values, [y, z]: [Values; 2]) -> DataArray {
    macro_rules! interleaved {
        ($($variant:ident),*) => {
            match (x, y, z) {
                $((Values::$variant(x), Values::$variant(y), Values::$variant(z)) => Values::$variant(
                    x.iter().zip(y).zip(z).flat_map(|((&x, y), z)| [x, y, z]).collect(),
                ),)*
                _ => unreachable!("the three are of one type"),
            }
        };
    }
    let values = interleaved!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64);
    DataArray::tuples(name, 3, values)
}
