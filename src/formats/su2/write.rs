//! Writing SU2: cells of the mesh's dimension, nodes, boundary tags as markers.

use super::super::WriteOptions;
use super::super::records::{left_out, push_integer, push_real, write_all, write_records};
use super::holds;
use crate::error::{Error, Result};
use crate::mesh::{CellRun, Group, Mesh};
use std::io::Write;

/// Writes the mesh; returns a sentence for each thing that is left out.
pub(super) fn write(
    mesh: &Mesh,
    out: &mut dyn Write,
    options: &WriteOptions,
) -> Result<Vec<String>> {
    let dimension = usize::from(mesh.dimension());
    check(mesh, dimension)?;
    let n_cells: usize = mesh.volume_runs().map(|run| run.n_cells()).sum();
    let mut notes = left_out("SU2", mesh, options);
    if dimension == 2 {
        notes.extend(height(mesh)?);
    }
    notes.extend(dropped(mesh));
    write_all(
        out,
        format!("NDIME= {dimension}\nNELEM= {n_cells}\n").as_bytes(),
    )?;
    let mut index = 0;
    for run in mesh.volume_runs() {
        write_cells(&run, Some(index), out)?;
        index += run.n_cells();
    }
    write_points(mesh, dimension, out)?;
    let n_tags = mesh.boundary_tags().count();
    write_all(out, format!("NMARK= {n_tags}\n").as_bytes())?;
    for tag in mesh.boundary_tags() {
        let name = marker_name(tag, &mut notes);
        let n = tag.cells.len();
        write_all(
            out,
            format!("MARKER_TAG= {name}\nMARKER_ELEMS= {n}\n").as_bytes(),
        )?;
        for range in tag.cells.ranges() {
            for run in mesh.cells.runs_in(range) {
                write_cells(&run, None, out)?;
            }
        }
    }
    Ok(notes)
}

/// Refuses what SU2 cannot hold.
fn check(mesh: &Mesh, dimension: usize) -> Result<()> {
    if !matches!(dimension, 2 | 3) {
        return Err(Error::input(format!(
            "SU2 holds meshes of triangles and quadrilaterals or of solid cells; \
             this one's cells have dimension {dimension}"
        )));
    }
    let boundary = mesh.boundary_tags().flat_map(|tag| tag.cells.ranges());
    let boundary = boundary.flat_map(|range| mesh.cells.runs_in(range));
    if let Some(run) = mesh
        .volume_runs()
        .chain(boundary)
        .find(|run| !holds(run.kind))
    {
        return Err(Error::input(format!(
            "cell {} is a {}, which SU2 cannot hold",
            run.first_cell,
            run.kind.name()
        )));
    }
    Ok(())
}

/// Plane meshes are written without z: refuses one that is not plane, to round-off; a sentence
/// about the height of one that is.
fn height(mesh: &Mesh) -> Result<Option<String>> {
    let Some([low, high]) = mesh.bounds() else {
        return Ok(None);
    };
    let size = (high[0] - low[0]).max(high[1] - low[1]);
    if high[2] - low[2] > 1e-12 * size {
        return Err(Error::input(format!(
            "z goes from {} to {}; SU2 holds surface meshes only in a plane of constant z",
            low[2], high[2]
        )));
    }
    let lies_flat = low[2] == 0.0 && high[2] == 0.0;
    Ok((!lies_flat).then(|| format!("SU2 holds no z of a plane mesh; left out: z = {}", high[2])))
}

/// Sentences about cells and groups that are not written.
fn dropped(mesh: &Mesh) -> Vec<String> {
    let dimension = mesh.dimension();
    let mut notes = Vec::new();
    let names = |groups: Vec<&Group>| {
        let names = groups.iter().map(|group| format!("\"{}\"", group.name));
        names.collect::<Vec<_>>().join(", ")
    };
    let zones: Vec<&Group> = mesh.zones().collect();
    if !zones.is_empty() {
        notes.push(format!("SU2 holds no zones; left out: {}", names(zones)));
    }
    let lower = |group: &&Group| group.dimension + 1 < dimension;
    let lower: Vec<&Group> = mesh.groups.iter().filter(lower).collect();
    if !lower.is_empty() {
        let names = names(lower);
        notes.push(format!(
            "SU2 holds boundary tags only; groups left out: {names}"
        ));
    }
    let mut is_tagged = vec![false; mesh.cells.len()];
    for cell in mesh.boundary_tags().flat_map(|tag| tag.cells.iter()) {
        is_tagged[cell] = true;
    }
    let mut n_faces = 0;
    let mut n_lower = 0;
    for run in mesh.cells.runs() {
        let of = run.kind.dimension();
        if of + 1 == dimension {
            let cells = &is_tagged[run.first_cell..run.first_cell + run.n_cells()];
            n_faces += cells.iter().filter(|tagged| !**tagged).count();
        } else if of < dimension {
            n_lower += run.n_cells();
        }
    }
    if n_faces > 0 {
        notes.push(format!(
            "{n_faces} boundary elements without a tag are left out"
        ));
    }
    if n_lower > 0 {
        notes.push(format!("{n_lower} cells of lower dimension are left out"));
    }
    notes
}

/// The tag's name on one line; SU2 ends a name at white space.
fn marker_name(tag: &Group, notes: &mut Vec<String>) -> String {
    let name: String = tag
        .name
        .chars()
        .map(|c| {
            if c.is_whitespace() || c.is_control() {
                '_'
            } else {
                c
            }
        })
        .collect();
    if name != tag.name {
        notes.push(format!(
            "tag {:?} is written as \"{name}\": SU2's names have no spaces",
            tag.name
        ));
    }
    name
}

/// Type and nodes of each cell, and its index where `first_index` is given.
fn write_cells(run: &CellRun, first_index: Option<usize>, out: &mut dyn Write) -> Result<()> {
    let kind = u64::from(run.kind.vtk());
    write_records(out, run.n_cells(), |range, buffer| {
        for i in range {
            push_integer(buffer, kind);
            for node in &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes] {
                buffer.push(b' ');
                push_integer(buffer, (*node).into());
            }
            if let Some(first) = first_index {
                buffer.push(b' ');
                push_integer(buffer, (first + i) as u64);
            }
            buffer.push(b'\n');
        }
    })
}

fn write_points(mesh: &Mesh, dimension: usize, out: &mut dyn Write) -> Result<()> {
    write_all(out, format!("NPOIN= {}\n", mesh.points.len()).as_bytes())?;
    write_records(out, mesh.points.len(), |range, buffer| {
        for i in range {
            for x in &mesh.points[i][..dimension] {
                push_real(buffer, *x);
                buffer.push(b' ');
            }
            push_integer(buffer, i as u64);
            buffer.push(b'\n');
        }
    })
}
