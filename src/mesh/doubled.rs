//! Nodes of a mesh of which some cells get copies, so that these cells share no node with the others: what a zone needs to turn
//! against the rest.

use super::numbering::Numbering;
use super::zone_sides::ZoneSides;
use super::{CellRef, CellSet, Cells, Mesh};
use crate::error::{Error, Result};
use crate::geometry::vector::Vector;
use crate::ranks::raw;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Nodes with copies, which follow all other nodes in the order of their originals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Doubled {
    /// How many nodes the mesh has without copies.
    n_nodes: usize,
    /// The originals, ascending, and where they are.
    #[serde(with = "raw")]
    nodes: Vec<u32>,
    #[serde(with = "raw")]
    places: Vec<Vector>,
    /// The cells that have the copies.
    cells: CellSet,
}

impl Doubled {
    /// The nodes between the volume cells of a mesh that are marked and the others. Marked cells get the copies, and so do boundary
    /// faces that have a node inside or lie on marked cells alone.
    ///
    /// # Errors
    /// Where there would be too many nodes.
    pub fn between(mesh: &Mesh, marked: &CellSet, sides: &ZoneSides) -> Result<Self> {
        let n_nodes = mesh.points.len();
        if n_nodes + sides.interface_nodes.len() > u32::MAX as usize {
            return Err(Error::input(
                "the mesh would have more than 4294967295 nodes",
            ));
        }
        let interface = Numbering::new(&sides.interface_nodes);
        let is_inside = |nodes: &[u32]| {
            nodes.iter().all(|&node| sides.nodes.has(node))
                && nodes.iter().any(|&node| interface.place(node).is_none())
        };
        let dimension = mesh.dimension();
        let mut cells = CellSet::new();
        let goes = |cell: &CellRef<'_>| {
            let is_on_rim = || sides.rim_faces.binary_search(&(cell.index as u32)).is_ok();
            is_inside(cell.nodes) || is_on_rim()
        };
        for run in mesh.cells.runs() {
            // An outline does not know the nodes of volume cells.
            if run.kind.dimension() < dimension {
                let faces = run.cell_refs().filter(goes);
                faces.for_each(|face| cells.push(face.index));
                continue;
            }
            let own = run.first_cell..run.first_cell + run.n_cells();
            marked
                .ranges_in(own)
                .for_each(|range| cells.push_range(range));
        }
        Ok(Self {
            n_nodes,
            nodes: sides.interface_nodes.clone(),
            places: sides.interface_places.clone(),
            cells,
        })
    }

    /// How many nodes there are with the copies.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes + self.nodes.len()
    }

    /// Gives the number of the copy of a node, or that of the node where it has none.
    pub fn copies(&self) -> impl Fn(u32) -> u32 + Sync {
        let numbering = Numbering::new(&self.nodes);
        move |node| match numbering.place(node) {
            Some(at) => (self.n_nodes + at) as u32,
            None => node,
        }
    }

    /// Where the copies are that are among some nodes.
    pub fn places(&self, nodes: &Range<usize>) -> &[Vector] {
        let place = |node: usize| node.saturating_sub(self.n_nodes).min(self.places.len());
        &self.places[place(nodes.start)..place(nodes.end)]
    }

    /// Gives consecutive cells of the mesh, of which the first has the number `first`, their copies.
    pub fn give(&self, cells: &mut Cells, first: usize) {
        let copy = self.copies();
        for range in self.cells.ranges_in(first..first + cells.len()) {
            cells.renumber_nodes_of(range.start - first..range.end - first, &copy);
        }
    }

    /// Gives a whole mesh the copies, or an outline those that it knows of.
    pub fn apply(&self, mesh: &mut Mesh) {
        let nodes: Vec<usize> = self.nodes.iter().map(|node| *node as usize).collect();
        for array in &mut mesh.point_arrays {
            let copies = array.values.select(array.n_components, &nodes);
            array.values.append(&copies);
        }
        if mesh.outline.is_none() {
            self.give(&mut mesh.cells, 0);
            mesh.points.extend_from_slice(&self.places);
            return;
        }
        mesh.add_unknown_nodes(self.nodes.len());
        mesh.take_places(&self.nodes, &self.places);
        let copies: Vec<u32> = (self.n_nodes as u32..self.n_nodes() as u32).collect();
        mesh.take_places(&copies, &self.places);
        let dimension = mesh.dimension();
        let runs = mesh.cells.runs();
        let faces = runs.filter(|run| run.kind.dimension() < dimension);
        let faces: Vec<Range<usize>> = faces
            .map(|run| run.first_cell..run.first_cell + run.n_cells())
            .collect();
        let copy = self.copies();
        for range in faces.into_iter().flat_map(|run| self.cells.ranges_in(run)) {
            mesh.cells.renumber_nodes_of(range, &copy);
        }
    }
}
