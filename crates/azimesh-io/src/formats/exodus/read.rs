//! An Exodus file as a mesh: nodes, element blocks, side sets, node sets, results.

use super::super::netcdf::File;
use super::super::{Notes, ReadOptions, Source};
use super::{blocks, node_sets, sides, variables};
use crate::mesh::{BoundedCells, Cells, Mesh, too_many};
use azimesh_core::error::{Error, Result};

/// Tests if a netCDF file is one of Exodus.
pub(super) fn is_exodus(file: &File) -> bool {
    let has = |name: &str| matches!(file.length(name), Ok(Some(_)));
    has("num_dim") && (has("num_nodes") || has("num_el_blk") || has("len_string"))
}

/// Reads a file at one of its steps.
pub(super) fn read(source: &Source, options: &ReadOptions, notes: &mut Notes) -> Result<Mesh> {
    let file = File::open(source)?;
    if !is_exodus(&file) {
        return Err(Error::input(format!(
            "this {} file is no Exodus file: it has no dimension num_dim",
            file.title()
        ))
        .dataset("num_dim"));
    }
    refuse_piece(&file)?;
    let step = options.step_of(times(&file)?.len());
    let step = step.map_err(|error| error.dataset(TIMES))?;
    let points = nodes(&file)?;
    let n_nodes = points.len();
    let n_coordinates = file.length("num_dim")?.unwrap_or(3);
    let mut cells = Cells::new();
    let blocks = blocks::read(&file, &points, n_coordinates, &mut cells, notes)?;
    let mut groups = blocks::groups(&blocks, &cells);
    let (tags, mut faces) = sides::read(&file, &blocks, &mut cells, notes)?;
    let has_tags = !tags.is_empty();
    groups.extend(tags);
    groups.extend(node_sets::read(
        &file, n_nodes, has_tags, &mut cells, &mut faces, notes,
    )?);
    say_what_is_left(&file, notes)?;
    let mut mesh = Mesh {
        point_arrays: variables::at_nodes(&file, n_nodes, step, notes)?,
        cell_arrays: variables::at_cells(&file, &blocks, &faces, step, notes)?,
        field_arrays: variables::of_mesh(&file, step, notes)?,
        points,
        cells,
        groups,
        ..Mesh::default()
    };
    // Faces of node sets do not know the cell that they bound.
    if faces.of_cells.contains(&u32::MAX) && !mesh.cell_arrays.is_empty() {
        let bounded = BoundedCells::of(&mesh);
        mesh.cell_arrays
            .iter_mut()
            .for_each(|array| bounded.give_values(array));
    }
    Ok(mesh)
}

/// Refuses one of the files that a decomposed mesh is in.
fn refuse_piece(file: &File) -> Result<()> {
    let n = file.length("num_processors")?.unwrap_or(1);
    let n_here = file.length("num_procs_file")?.unwrap_or(n);
    if n <= n_here.max(1) {
        return Ok(());
    }
    Err(Error::input(format!(
        "this file has {n_here} of the {n} pieces of a decomposed mesh; only whole meshes are read, so join the pieces with epu, a tool of SEACAS"
    ))
    .dataset("num_processors"))
}

/// The coordinates, one variable for each axis or one for all.
fn nodes(file: &File) -> Result<Vec<[f64; 3]>> {
    let n = file.length("num_nodes")?.unwrap_or(0);
    if n >= u32::MAX as usize {
        return Err(Error::input(too_many("nodes")).dataset("num_nodes"));
    }
    let n_axes = file.length("num_dim")?.unwrap_or(3);
    if !(1..=3).contains(&n_axes) {
        let message = format!("nodes have {n_axes} coordinates; they must have 1 to 3");
        return Err(Error::input(message).dataset("num_dim"));
    }
    let mut points = Vec::new();
    if n == 0 {
        return Ok(points);
    }
    let together = file.variable("coord")?;
    for (axis, name) in ["coordx", "coordy", "coordz"]
        .iter()
        .enumerate()
        .take(n_axes)
    {
        let (variable, rows) = match &together {
            Some(all) => (all, axis..axis + 1),
            None => (&file.need(name)?, 0..n),
        };
        let data = variable.rows(rows)?;
        let numbers = data
            .chunk()
            .ok_or_else(|| variable.refuse("coordinates must be numbers"))?;
        if numbers.n_values() != n {
            let found = numbers.n_values();
            return Err(variable.refuse(format!("it has {found} values; there are {n} nodes")));
        }
        points.resize(n, [0.0; 3]);
        let is_odd = |point: &[f64; 3]| !point[axis].is_finite();
        if !numbers.axis(axis, &mut points)
            && let Some(at) = points.iter().position(is_odd)
        {
            return Err(variable.refuse(format!(
                "node {} has the coordinate {}; coordinates must be finite",
                at + 1,
                points[at][axis]
            )));
        }
    }
    Ok(points)
}

/// Notes what a mesh does not hold of the file.
fn say_what_is_left(file: &File, notes: &mut Notes) -> Result<()> {
    for (dimension, what) in [
        ("num_ed_blk", "edge blocks"),
        ("num_edge_sets", "edge sets"),
        ("num_face_sets", "face sets"),
        ("num_elem_sets", "element sets"),
        ("num_nset_var", "results of node sets"),
        ("num_sset_var", "results of side sets"),
    ] {
        notes.not_kept(what, file.length(dimension)?.unwrap_or(0));
    }
    let names = file.names()?;
    let n = names.iter().filter(|name| {
        let number = name.strip_prefix("attrib");
        number.is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()))
    });
    notes.not_kept("attributes of element blocks", n.count());
    Ok(())
}

/// Variable of the times.
const TIMES: &str = "time_whole";

/// Times of the steps; none where the file has no results.
pub(super) fn times(file: &File) -> Result<Vec<f64>> {
    file.variable(TIMES)?
        .map_or(Ok(Vec::new()), |times| times.reals())
}
