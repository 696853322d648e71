//! A mesh that one process reads piece by piece and never holds as a whole: a slab of it with the cells around, and what is asked
//! for of its cells and nodes.

use super::from_slabs::{Slabs, mesh_of, nodes_of, own_cells, own_points, part_of};
use super::node_bits::NodeBits;
use super::numbering::{Numbering, among};
use super::part::{self, SLAB};
use super::{Cells, Mesh, faces_on_no_cell};
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::ranks::Ranks;
use std::ops::Range;

/// Cells that are read at once.
const CELLS: usize = 32 * SLAB;
/// Nodes that are read at once.
const NODES: usize = 1 << 20;

impl Slabs<'_> {
    /// Passes the cells of a range, some at a time, with the number of the first of them.
    pub fn each_cells(
        &self,
        range: Range<usize>,
        act: &mut dyn FnMut(usize, &Cells) -> Result<()>,
    ) -> Result<()> {
        for start in range.clone().step_by(CELLS) {
            let cells = own_cells(self, start..range.end.min(start + CELLS))?;
            act(start, &cells)?;
        }
        Ok(())
    }

    /// Passes the coordinates of the nodes of a range, some at a time, with the number of the first of them.
    pub fn each_points(
        &self,
        range: Range<usize>,
        act: &mut dyn FnMut(usize, &[Vector]) -> Result<()>,
    ) -> Result<()> {
        for start in range.clone().step_by(NODES) {
            let points = own_points(self, start..range.end.min(start + NODES))?;
            act(start, &points)?;
        }
        Ok(())
    }

    /// Where some nodes are, which ascend.
    pub fn places(&self, nodes: &[u32]) -> Result<Vec<Vector>> {
        let mut places = Vec::with_capacity(nodes.len());
        let mut rest = nodes;
        while let (Some(&first), Some(&last)) = (rest.first(), rest.last()) {
            let first = first as usize;
            let piece = first..(last as usize + 1).min(first + NODES);
            let here = among(rest, &piece);
            let end = here[here.len() - 1] as usize + 1;
            let points = own_points(self, first..end)?;
            places.extend(here.iter().map(|&node| points[node as usize - first]));
            rest = &rest[here.len()..];
        }
        Ok(places)
    }
}

impl Mesh {
    /// The part that rank `rank` of `n` has of a solid mesh, as [`from_slabs`](Self::from_slabs) makes it, read without the others;
    /// `ranks` is for what it tells them.
    ///
    /// # Errors
    /// Where the file cannot be read or its nodes and cells are not valid.
    pub(crate) fn part_by_pieces(
        slabs: &Slabs,
        (rank, n): (usize, usize),
        ranks: &Ranks,
    ) -> Result<Self> {
        const DIMENSION: u8 = 3;
        let own = part::slab(slabs.n_cells, rank, n);
        let own_nodes = part::node_slab(slabs.n_nodes, rank, n);
        let mut cells = own_cells(slabs, own.clone())?;
        let here = NodeBits::new(&(0..slabs.n_nodes));
        here.add(&nodes_of(&cells, 0..0));
        let mut numbers: Vec<u32> = Vec::new();
        let around = |range: Range<usize>, numbers: &mut Vec<u32>| {
            let mut found = Cells::new();
            slabs.each_cells(range, &mut |first, cells| {
                let near = near(cells, DIMENSION, &here);
                found.append(&cells.select(near.iter().map(|&cell| cell as usize)));
                numbers.extend(near.iter().map(|cell| cell + first as u32));
                Ok(())
            })?;
            Ok::<_, Error>(found)
        };
        let before = around(0..own.start, &mut numbers)?;
        let first = numbers.len();
        numbers.extend(own.start as u32..own.end as u32);
        let after = around(own.end..slabs.n_cells, &mut numbers)?;
        cells.prepend(&before);
        cells.append(&after);
        let numbered = (numbers, first..first + own.len());
        let part = part_of(&mut cells, numbered, own_nodes, slabs.n_nodes, ranks);
        let points = slabs.places(&part.nodes)?;
        Ok(mesh_of(points, cells, DIMENSION, part))
    }

    /// Those of some of the boundary faces of this outline, ascending, that are a side of no cell.
    pub(crate) fn loose_faces_by_pieces(&self, slabs: &Slabs, faces: &[u32]) -> Result<Vec<u32>> {
        let faces_alone = self.cells.select(faces.iter().map(|&face| face as usize));
        let nodes = nodes_of(&faces_alone, 0..0);
        let at_faces = NodeBits::new(&(0..slabs.n_nodes));
        at_faces.add(&nodes);
        let mut loose = faces.to_vec();
        slabs.each_cells(0..slabs.n_cells, &mut |_, cells| {
            let near = parallel::concat_blocks(cells.len(), SLAB, &|range| {
                let mut near = Vec::new();
                for run in cells.runs_in(range).filter(|run| run.kind.dimension() == 3) {
                    let touches = |nodes: &[u32]| nodes.iter().any(|&node| at_faces.has(node));
                    let cells = (run.first_cell..).zip(run.cells());
                    near.extend(cells.filter(|of| touches(of.1)).map(|of| of.0));
                }
                near
            });
            if near.is_empty() || loose.is_empty() {
                return Ok(());
            }
            let mut together = self.cells.select(loose.iter().map(|&face| face as usize));
            together.append(&cells.select(near));
            let nodes = nodes_of(&together, 0..0);
            let numbering = Numbering::new(&nodes);
            together.renumber_nodes_by(|node| numbering.of(node));
            let mesh = mesh_of(
                vec![[0.0; 3]; nodes.len()],
                together,
                3,
                part::Part::default(),
            );
            let left = faces_on_no_cell(&mesh, &(0..loose.len() as u32).collect::<Vec<_>>());
            loose = left.into_iter().map(|at| loose[at as usize]).collect();
            Ok(())
        })?;
        Ok(loose)
    }
}

/// The cells that have so many nodes among those `here` that a part with these holds them, ascending.
fn near(cells: &Cells, dimension: u8, here: &NodeBits) -> Vec<u32> {
    parallel::concat_blocks(cells.len(), SLAB, &|range| {
        let mut near = Vec::new();
        for run in cells.runs_in(range) {
            let Some(wanted) = part::nodes_to_share(run.kind, dimension) else {
                continue;
            };
            let shares = |nodes: &[u32]| {
                let shared = nodes.iter().filter(|&&node| here.has(node));
                shared.count() as u32 >= wanted
            };
            let found = (run.first_cell as u32..).zip(run.cells());
            near.extend(found.filter(|of| shares(of.1)).map(|of| of.0));
        }
        near
    })
}
