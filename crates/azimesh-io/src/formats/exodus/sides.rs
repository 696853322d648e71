//! Side sets: sides of elements, as boundary faces in tags.

use super::super::Notes;
use super::super::netcdf::{File, Variable};
use super::blocks::{Block, check_number, named};
use super::element::Side;
use crate::mesh::sides::{flat, for_each_side, side, side_corners};
use crate::mesh::{CellKind, CellRef, Cells, Group};
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};

/// Faces that side sets added to the cells.
#[derive(Default)]
pub(super) struct Faces {
    /// The first of these cells.
    pub first: usize,
    /// The cell that each bounds.
    pub of_cells: Vec<u32>,
}

/// Appends the faces of all side sets; gives their groups, one for each dimension.
pub(super) fn read(
    file: &File,
    blocks: &[Block],
    cells: &mut Cells,
    notes: &mut Notes,
) -> Result<(Vec<Group>, Faces)> {
    let n = file.length("num_side_sets")?.unwrap_or(0);
    check_number(n, "num_side_sets", file)?;
    let mut faces = Faces {
        first: cells.len(),
        of_cells: Vec::new(),
    };
    let sets = Sets {
        blocks,
        dimension: cells.dimension(),
        n_elements: cells.len(),
    };
    let mut groups = Vec::new();
    let of_blocks: BTreeSet<&str> = blocks.iter().map(|block| &*block.named.name).collect();
    for (place, named) in (1..).zip(named(file, n, ["ss_prop1", "ss_names"], notes)?) {
        let Some(elements) = file.variable(&format!("elem_ss{place}"))? else {
            continue;
        };
        let sides = file.need(&format!("side_ss{place}"))?;
        let members = sets.read(&elements, &sides, cells, &mut faces.of_cells)?;
        for (dimension, cells) in members {
            let mut named = named.clone();
            // A set without a name is named by its number, which may be a block's too.
            if named.name == named.id.to_string() && of_blocks.contains(&*named.name) {
                named.name = format!("side set {}", named.id);
            }
            groups.push(named.group(dimension, cells.into_iter().collect()));
        }
    }
    Ok((groups, faces))
}

/// The elements that side sets refer to.
struct Sets<'a> {
    blocks: &'a [Block],
    dimension: u8,
    n_elements: usize,
}

impl Sets<'_> {
    /// Appends the faces of a set; gives its cells by their dimension.
    fn read(
        &self,
        elements: &Variable,
        sides: &Variable,
        cells: &mut Cells,
        of_cells: &mut Vec<u32>,
    ) -> Result<BTreeMap<u8, Vec<usize>>> {
        let (of, numbers) = (elements.integers()?, sides.integers()?);
        if of.len() != numbers.len() {
            return Err(sides.refuse(format!(
                "it has {} values, but there are {} elements in the side set",
                numbers.len(),
                of.len()
            )));
        }
        let space = cells.check_space(of.len());
        space.map_err(|e| elements.refuse(e.message))?;
        let mut members: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
        for (i, (element, number)) in of.into_iter().zip(numbers).enumerate() {
            let cell = usize::try_from(element)
                .ok()
                .filter(|e| (1..=self.n_elements).contains(e));
            let cell = cell.ok_or_else(|| {
                let n = self.n_elements;
                elements.refuse(format!("value {i} names element {element}; there are {n}"))
            })? - 1;
            let block = self.blocks.partition_point(|block| block.cells.end <= cell);
            let side = self.side(block, cell, number, cells).ok_or_else(|| {
                let kind = cells.get(cell).kind.name();
                sides.refuse(format!(
                    "value {i} names side {number} of element {element}, a {kind}"
                ))
            })?;
            let index = match side {
                None => cell,
                Some((kind, nodes)) => {
                    cells.push(kind, &nodes);
                    of_cells.push(cell as u32);
                    cells.len() - 1
                }
            };
            let dimension = cells.get(index).kind.dimension();
            members.entry(dimension).or_default().push(index);
        }
        Ok(members)
    }

    /// A side of an element as a cell of its own, `None` inside where it is the element itself.
    fn side(
        &self,
        block: usize,
        cell: usize,
        number: i64,
        cells: &Cells,
    ) -> Option<Option<(CellKind, Vec<u32>)>> {
        let cell = cells.get(cell);
        let mut n_faces = 0;
        for_each_side(cells, &cell, |_, _| n_faces += 1);
        let shape = self.blocks.get(block)?.shape;
        match Side::of(shape, number, n_faces, self.dimension)? {
            Side::Whole => Some(None),
            Side::Face(face) => Some(Some(
                side(cells, &cell, face).or_else(|| of_corners(cells, &cell, face))?,
            )),
        }
    }
}

/// A face of a cell by its corners, where the other nodes on it are not known.
fn of_corners(cells: &Cells, cell: &CellRef, wanted: usize) -> Option<(CellKind, Vec<u32>)> {
    let corners = side_corners(cells, cell, wanted, <[u32]>::to_vec);
    (!corners.is_empty()).then(|| (flat(corners.len()), corners))
}
