//! Solutions of zones, put together into arrays of the mesh at nodes and at cells.

use super::super::names::Places;
use super::builder::{MeshBuilder, free_name};
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
        let here = arrays.add(zone.number, names, places.clone(), values);
        if here != name {
            let [solution, name] = names.map(str::to_owned);
            let note = ArrayRead::OfSolutionRenamed {
                solution,
                name,
                here,
            };
            found.remarks.push(note.into());
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
    pieces: Vec<ArrayPiece>,
}

/// Values of some consecutive nodes, or of the cells in some ranges, in order.
struct ArrayPiece {
    zone: usize,
    at: Vec<Range<usize>>,
    values: Values,
}

impl Arrays {
    /// Adds the values that an array has in the given places of a zone. An array that the zone has
    /// already under this name gets the name of its solution too. Gives the name that it has then.
    pub fn add(
        &mut self,
        zone: usize,
        [solution, name]: [&str; 2],
        at: Vec<Range<usize>>,
        values: Values,
    ) -> String {
        let is_taken = |place: usize| {
            let pieces = &self.found[place].pieces;
            pieces.last().is_some_and(|piece| piece.zone == zone)
        };
        let is_taken = |name: &str| self.places.get(&name.to_owned()).is_some_and(is_taken);
        let full_name = free_name(name, solution, is_taken);
        let new = || FoundArray {
            name: full_name.clone(),
            pieces: Vec::new(),
        };
        let found = (self.places).entry(full_name.clone(), &mut self.found, new);
        found.pieces.push(ArrayPiece { zone, at, values });
        full_name
    }

    /// Makes the arrays, each with `n` values. Missing values are NaN, or zero in an array of integers. Three arrays
    /// named by axes become one array of vectors.
    pub fn into_data_arrays(self, n: usize) -> Vec<DataArray> {
        let found = self.found.into_iter();
        let scalars = found.map(|found| DataArray::scalar(found.name, joined(found.pieces, n)));
        let mut scalars: Vec<Option<DataArray>> = scalars.map(Some).collect();
        let mut arrays = Vec::new();
        for i in 0..scalars.len() {
            let Some(first) = scalars[i].take() else {
                continue;
            };
            arrays.push(match other_axes(&first, &scalars, &self.places) {
                Some(others) => {
                    let [y, z] = others.map(|i| scalars[i].take().expect("it was just found"));
                    vector(&first, &y, &z)
                }
                None => first,
            });
        }
        arrays
    }
}

/// Finds the arrays of the second and third axis that belong to the array of the first.
fn other_axes(
    first: &DataArray,
    scalars: &[Option<DataArray>],
    places: &Places<String>,
) -> Option<[usize; 2]> {
    let stem = first.name.strip_suffix('X')?;
    let same_type = std::mem::discriminant(&first.values);
    let find = |axis: char| {
        let place = places.get(&format!("{stem}{axis}"))?;
        let array = scalars[place].as_ref()?;
        (std::mem::discriminant(&array.values) == same_type).then_some(place)
    };
    (!stem.is_empty()).then_some([find('Y')?, find('Z')?])
}

fn vector(x: &DataArray, y: &DataArray, z: &DataArray) -> DataArray {
    macro_rules! interleaved {
        ($($variant:ident),*) => {
            match (&x.values, &y.values, &z.values) {
                $((Values::$variant(x), Values::$variant(y), Values::$variant(z)) => {
                    Values::$variant(
                        x.iter().zip(y).zip(z).flat_map(|((&x, &y), &z)| [x, y, z]).collect(),
                    )
                })*
                _ => unreachable!("the three are of one type"),
            }
        };
    }
    let values = interleaved!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64);
    let stem = x.name.strip_suffix('X').unwrap_or(&x.name);
    DataArray::tuples(stem, 3, values)
}

fn joined(mut pieces: Vec<ArrayPiece>, n: usize) -> Values {
    let covers = |piece: &ArrayPiece| piece.at.len() == 1 && piece.at[0] == (0..n);
    if let [piece] = &mut pieces[..]
        && covers(piece)
    {
        return std::mem::replace(&mut piece.values, Values::U8(Vec::new()));
    }
    let type_of = |piece: &ArrayPiece| std::mem::discriminant(&piece.values);
    let one_type = pieces
        .iter()
        .all(|piece| type_of(piece) == type_of(&pieces[0]));
    macro_rules! placed {
        ($variant:ident, $nothing:expr) => {{
            let mut all = vec![$nothing; n];
            for piece in &pieces {
                let Values::$variant(values) = &piece.values else {
                    unreachable!("all pieces are of one type");
                };
                place(&mut all, &piece.at, values);
            }
            Values::$variant(all)
        }};
    }
    match &pieces[0].values {
        Values::I32(_) if one_type => placed!(I32, 0),
        Values::I64(_) if one_type => placed!(I64, 0),
        Values::F32(_) if one_type => placed!(F32, f32::NAN),
        _ => {
            let mut all = vec![f64::NAN; n];
            for piece in &pieces {
                let values = piece.values.to_f64().unwrap_or_default();
                place(&mut all, &piece.at, &values);
            }
            Values::F64(all)
        }
    }
}

fn place<T: Copy>(all: &mut [T], at: &[Range<usize>], values: &[T]) {
    let mut rest = values;
    for range in at {
        let n = range.len().min(rest.len());
        let (head, tail) = rest.split_at(n);
        all[range.start..range.start + n].copy_from_slice(head);
        rest = tail;
    }
}
