//! Element blocks: cells, in the order of the elements, and a group of each block. Names of blocks and sets.

use super::super::Notes;
use super::super::cgns::permute;
use super::super::names::text_of;
use super::super::netcdf::{File, Variable};
use super::element::{Element, Shape};
use super::polyhedra::{self, FaceBlocks};
use crate::mesh::{CellSet, Cells, Group};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;
use std::collections::BTreeMap;
use std::ops::Range;

/// An element block.
pub(super) struct Block {
    /// Its place in the file, from 1, which is part of the names of its variables.
    pub place: usize,
    pub named: Named,
    /// Its elements, which are its cells.
    pub cells: Range<usize>,
    pub shape: Shape,
}

/// Reads the blocks that have elements.
pub(super) fn read(
    file: &File,
    points: &[[f64; 3]],
    n_coordinates: usize,
    cells: &mut Cells,
    notes: &mut Notes,
) -> Result<Vec<Block>> {
    let n = file.length("num_el_blk")?.unwrap_or(0);
    check_number(n, "num_el_blk", file)?;
    let n_nodes = points.len();
    let mut blocks: Vec<Block> = Vec::new();
    let mut fewer = Fewer::new();
    let mut faces = None;
    let all = named(file, n, ["eb_prop1", "eb_names"], notes)?;
    for (place, named) in (1..).zip(all) {
        if file.length(&format!("num_el_in_blk{place}"))? == Some(0) {
            continue;
        }
        let first = cells.len();
        let Some((variable, name)) = connectivity(file, place)? else {
            continue;
        };
        let per_element = variable.shape().get(1).copied().unwrap_or(0);
        let Some(shape) = Shape::of(&name, per_element, n_coordinates) else {
            return Err(variable.refuse(format!(
                "element block {} has elements of type \"{name}\", which are not read",
                named.id
            )));
        };
        match shape {
            Shape::NSided => polyhedra::polygons(file, place, &variable, n_nodes, cells)?,
            Shape::NFaced => {
                let faces: &FaceBlocks = match &faces {
                    Some(read) => read,
                    None => faces.insert(polyhedra::face_blocks(file, n_nodes)?),
                };
                polyhedra::polyhedra(file, place, &variable, (faces, points), cells)?;
            }
            _ => elements(&variable, (&name, shape), n_nodes, cells, &mut fewer)?,
        }
        blocks.push(Block {
            place,
            named,
            cells: first..cells.len(),
            shape,
        });
    }
    for ((element, n_nodes, n_kept), n) in fewer {
        notes.push(note!(
            "fewer_nodes",
            "{} of type {element} {} {n_kept} of {n_nodes} nodes: no kind of cell has the others",
            counted(n, "element"),
            if n == 1 { "keeps" } else { "keep" }
        ));
    }
    Ok(blocks)
}

/// Elements with nodes that are not kept: type, nodes, nodes that are kept, and how many there are.
type Fewer = BTreeMap<(String, usize, usize), usize>;

/// Refuses more blocks or sets than the file can name.
pub(super) fn check_number(n: usize, dimension: &str, file: &File) -> Result<()> {
    // Empty ones have no variables.
    let most = file.names()?.len();
    if n > most.max(1 << 16) {
        return Err(Error::input(format!(
            "there are {n} of them, but the file has {most} variables"
        ))
        .dataset(dimension));
    }
    Ok(())
}

/// The variable of the nodes, or of the faces of polyhedra, of a block, with the type of its elements.
fn connectivity<'a>(file: &File<'a>, place: usize) -> Result<Option<(Variable<'a>, String)>> {
    for name in ["connect", "facconn"] {
        if let Some(variable) = file.variable(&format!("{name}{place}"))?
            && let Some(of) = variable.text("elem_type")?
        {
            return Ok(Some((variable, of)));
        }
    }
    match file.length(&format!("num_el_in_blk{place}"))? {
        None => Ok(None),
        Some(n) => Err(Error::input(format!(
            "the {n} elements of the block have neither nodes nor a type (attribute elem_type)"
        ))
        .dataset(&format!("connect{place}"))),
    }
}

/// Elements with a fixed number of nodes.
fn elements(
    variable: &Variable,
    (name, shape): (&str, Shape),
    n_nodes: usize,
    cells: &mut Cells,
    fewer: &mut Fewer,
) -> Result<()> {
    let &[n, per_element] = variable.shape() else {
        return Err(variable.refuse(format!(
            "it has {} dimensions; it must have two: elements and their nodes",
            variable.shape().len()
        )));
    };
    let element = Element::of(shape, per_element).ok_or_else(|| {
        variable.refuse(format!(
            "its elements of type \"{name}\" have {per_element} nodes, which is no element that is read"
        ))
    })?;
    cells
        .check_space(n)
        .map_err(|e| variable.refuse(e.message))?;
    let mut nodes = indices(variable, n_nodes, "node")?;
    if let Some(order) = element.order.filter(|order| order.len() == per_element) {
        permute(&mut nodes, order);
    } else if element.n_kept < per_element {
        nodes = kept(&nodes, per_element, &element);
        let of = (name.to_owned(), per_element, element.n_kept);
        *fewer.entry(of).or_default() += n;
    }
    let block = Cells::from_connectivity(nodes, [(element.kind, element.n_kept, n)]);
    if cells.is_empty() {
        *cells = block
    } else {
        cells.append(&block)
    }
    Ok(())
}

/// The values as indices from 0 of one of `n` nodes or faces, which the file counts from 1.
pub(super) fn indices(variable: &Variable, n: usize, what: &str) -> Result<Vec<u32>> {
    let data = variable.data()?;
    let chunk = data.chunk().filter(|chunk| chunk.element.is_integer());
    let chunk = chunk.ok_or_else(|| variable.refuse("it must have integers"))?;
    let mut indices = vec![0; chunk.n_values()];
    chunk
        .indices(&mut indices, (1, n as u64), 0)
        .map_err(|(at, value)| {
            variable.refuse(format!(
                "value {at} names {what} {value}; there are {n}, counted from 1"
            ))
        })?;
    Ok(indices)
}

/// The nodes of elements that cells keep.
fn kept(nodes: &[u32], per_element: usize, element: &Element) -> Vec<u32> {
    let all: Vec<usize> = (0..element.n_kept).collect();
    let order = element.order.unwrap_or(&all);
    let elements = nodes.chunks_exact(per_element);
    let kept = elements.flat_map(|nodes| order.iter().map(|&i| nodes[i]));
    kept.collect()
}

/// The groups of the blocks: zones, or tags where their cells are faces of others.
pub(super) fn groups(blocks: &[Block], cells: &Cells) -> Vec<Group> {
    let group = |block: &Block| {
        let mut set = CellSet::new();
        set.push_range(block.cells.clone());
        let dimension = cells.get(block.cells.start).kind.dimension();
        block.named.group(dimension, set)
    };
    let with_cells = blocks.iter().filter(|block| !block.cells.is_empty());
    with_cells.map(group).collect()
}

/// A block or a set.
#[derive(Debug, Clone)]
pub(super) struct Named {
    /// Its number, by which applications know it.
    pub id: i64,
    /// Its name; its number where the file gives none.
    pub name: String,
}

impl Named {
    /// A group of its cells, of a dimension.
    pub fn group(&self, dimension: u8, cells: CellSet) -> Group {
        Group::new(
            dimension,
            self.name.clone(),
            i32::try_from(self.id).ok(),
            cells,
        )
    }
}

/// Names of `n` blocks or sets: their numbers are the property of this name, their names another variable's.
pub(super) fn named(
    file: &File,
    n: usize,
    [ids, names]: [&str; 2],
    notes: &mut Notes,
) -> Result<Vec<Named>> {
    let ids = match file.variable(ids)? {
        Some(ids) => ids.integers()?,
        None => Vec::new(),
    };
    let names = lines(file, names, notes)?;
    let of = |i: usize| {
        let id = ids.get(i).copied().unwrap_or(i as i64 + 1);
        let name = names.get(i).filter(|name| !name.is_empty());
        Named {
            id,
            name: name.cloned().unwrap_or_else(|| id.to_string()),
        }
    };
    Ok((0..n).map(of).collect())
}

/// The lines of text of a variable; none where there is no such variable.
pub(super) fn lines(file: &File, variable: &str, notes: &mut Notes) -> Result<Vec<String>> {
    let Some(variable) = file.variable(variable)? else {
        return Ok(Vec::new());
    };
    let lines = variable.lines()?;
    Ok(lines.iter().map(|line| text_of(line, notes)).collect())
}
