//! Solutions of zones, put together into arrays of the mesh at nodes and at cells.

use super::super::names::Places;
use super::super::pieces::{Piece, joined, with_vectors};
use super::builder::{MeshBuilder, free_name};
use super::node::Node;
use super::time::Step;
use super::zone::{Zone, rind};
use crate::mesh::{DataArray, Values};
use azimesh_core::error::Result;
use azimesh_core::note;
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

/// The arrays of the mesh as a whole that azimesh has put into a base, and that belong to this step.
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
    let zone_nodes = zone.first_node..zone.first_node + zone.total_nodes()?;
    let (arrays, sizes, places, noun) = match location.as_deref() {
        None | Some("Vertex") => {
            let places = vec![zone_nodes];
            (&mut found.point_arrays, &zone.n_nodes, places, "nodes")
        }
        Some("CellCenter") => {
            let places = cells.to_vec();
            (&mut found.cell_arrays, &zone.n_cells, places, "cells")
        }
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
    let mut text = Vec::new();
    for array in solution.labelled("DataArray_t")? {
        let values = zone.core(array, sizes, &rind)?;
        if matches!(values, Values::Text(_) | Values::I8(_) | Values::U8(_)) {
            text.push(array.name());
            continue;
        }
        if values.len() != n {
            return Err(array.refuse(format!(
                "it has {} values; the zone has {n} {noun}",
                values.len()
            )));
        }
        let full_name = array.full_name()?;
        let name = full_name.as_deref().unwrap_or(array.name());
        let names = [solution.name(), name];
        let at = places.clone();
        let here = arrays.add(zone.number, names, Piece { at, values });
        if here != name {
            let solution = solution.name();
            found.remarks.push(note!(
                "array_renamed",
                "several arrays are called \"{name}\"; the array of \"{solution}\" is read as \"{here}\""
            ));
        }
    }
    for name in text {
        found.leave_named("solution arrays of text", name);
    }
    Ok(())
}

/// Pieces of arrays at nodes or at cells.
#[derive(Default)]
pub(super) struct Arrays {
    found: Vec<FoundArray>,
    places: Places<String>,
}

struct FoundArray {
    name: String,
    /// The last zone that has it.
    zone: usize,
    pieces: Vec<Piece>,
}

impl Arrays {
    /// Adds the values that an array has in the given places of a zone. An array that the zone has
    /// already under this name gets the name of its solution too. Gives the name that it has then.
    pub fn add(&mut self, zone: usize, [solution, name]: [&str; 2], piece: Piece) -> String {
        let is_taken = |place: usize| self.found[place].zone == zone;
        let is_taken = |name: &str| self.places.get(&name.to_owned()).is_some_and(is_taken);
        let full_name = free_name(name, solution, is_taken);
        let new = || FoundArray {
            name: full_name.clone(),
            zone,
            pieces: Vec::new(),
        };
        let found = (self.places).entry(full_name.clone(), &mut self.found, new);
        found.zone = zone;
        found.pieces.push(piece);
        full_name
    }

    /// Makes the arrays, each with `n` values. Three arrays named by axes become one array of vectors.
    pub fn into_data_arrays(self, n: usize) -> Vec<DataArray> {
        let found = self.found.into_iter();
        let scalars = found.map(|found| DataArray::scalar(found.name, joined(found.pieces, n)));
        with_vectors(scalars.collect(), |first| {
            let stem = first.strip_suffix('X').filter(|stem| !stem.is_empty())?;
            Some((
                stem.to_owned(),
                ["Y", "Z"].map(|axis| format!("{stem}{axis}")),
            ))
        })
    }
}
