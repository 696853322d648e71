//! Solutions of a zone, as arrays at its nodes and cells.

use super::builder::MeshBuilder;
use super::node::Node;
use super::time::Step;
use super::zone::{Zone, rind};
use crate::mesh::{DataArray, Values};
use azimesh_core::diagnostic::formats::ArrayRead;
use azimesh_core::error::Result;
use std::ops::Range;

/// Adds the arrays of the solutions of a zone that belong to this step. `cells` are its cells.
pub(super) fn read(
    zone: &Zone,
    cells: &[Range<usize>],
    step: &Step,
    found: &mut MeshBuilder,
) -> Result<()> {
    for label in ["FlowSolution_t", "DiscreteData_t"] {
        let all = zone.node.labelled(label)?.collect();
        for solution in step.solutions(zone.node, all)? {
            read_solution(zone, solution, cells, found)?;
        }
    }
    Ok(())
}

/// The arrays of the mesh as a whole that azimesh has put into a base, and
/// that belong to this step.
pub(super) fn field_arrays(base: &Node, step: &Step) -> Result<Vec<DataArray>> {
    let name = step.field_arrays(base)?;
    let node = name.map(|name| base.child(&name)).transpose()?;
    let Some(node) = node.flatten() else {
        return Ok(Vec::new());
    };
    let mut arrays = Vec::new();
    for array in node.labelled("DataArray_t")? {
        let full_name = array.full_name()?;
        let name = full_name.unwrap_or_else(|| array.name().to_owned());
        let (n_components, values) = match array.values()? {
            Values::I8(_) | Values::U8(_) | Values::Text(_) => (1, Values::Text(array.strings()?)),
            values => match array.sizes()?[..] {
                [n, _] if n >= 1 && (values.len() as u64).is_multiple_of(n) => (n as usize, values),
                _ => (1, values),
            },
        };
        arrays.push(DataArray::tuples(name, n_components, values));
    }
    Ok(arrays)
}

fn read_solution(
    zone: &Zone,
    solution: &Node,
    cells: &[Range<usize>],
    found: &mut MeshBuilder,
) -> Result<()> {
    let location = solution.child_text("GridLocation")?;
    let n = zone.total_nodes()?;
    let nodes = zone.first_node..zone.first_node + n;
    let (sizes, places) = match location.as_deref() {
        None | Some("Vertex") => (&zone.n_nodes, vec![nodes]),
        Some("CellCenter") => (&zone.n_cells, cells.to_vec()),
        Some(other) => {
            found.leave_named(&format!("solutions at {other}"), solution.name());
            return Ok(());
        }
    };
    if solution.child("PointRange")?.is_some() || solution.child("PointList")?.is_some() {
        found.leave_named("solutions on a part of a zone", solution.name());
        return Ok(());
    }
    let rind = rind(solution)?;
    let n: usize = places.iter().map(Range::len).sum();
    for array in solution.labelled("DataArray_t")? {
        let values = zone.core(array, sizes, &rind)?;
        if matches!(values, Values::Text(_) | Values::I8(_) | Values::U8(_)) {
            found.leave_named("solution arrays of text", array.name());
        } else if values.len() != n {
            return Err(array.refuse(format!(
                "it has {} values; the zone has {n} {}",
                values.len(),
                if location.as_deref() == Some("CellCenter") {
                    "cells"
                } else {
                    "nodes"
                }
            )));
        } else {
            let arrays = match location.as_deref() {
                Some("CellCenter") => &mut found.cell_arrays,
                _ => &mut found.point_arrays,
            };
            let full_name = array.full_name()?;
            let name = full_name.as_deref().unwrap_or(array.name());
            let names = [solution.name(), name];
            let given = arrays.add(zone.number, names, places.clone(), values);
            if given != name {
                let note = ArrayRead::OfSolutionRenamed {
                    solution: solution.name().to_owned(),
                    name: name.to_owned(),
                    here: given,
                };
                found.remarks.push(note.into());
            }
        }
    }
    Ok(())
}
