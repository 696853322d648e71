//! The outline of a mesh whose cells lie with several ranks: what the first rank knows of the whole.
//!
//! An outline has the kind of every cell, the nodes of the cells of lower dimension, which are the boundary faces, and where these
//! nodes are. Nodes and cells have the numbers of the whole mesh. The arrays of coordinates and of the nodes of cells are as long as
//! those of the whole, but what is not known was never written: the system gives no memory for it.

use super::{Apart, Cells, Mesh};
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;
use crate::mesh::CellKind;
use crate::ranks::Ranks;
use crate::ranks::raw;
use crate::sparse;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What an outline knows of the mesh but its arrays.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The box around all nodes.
    pub bounds: Bounds,
    /// The ranks that have the mesh.
    pub by: Arc<dyn Apart>,
}

impl PartialEq for Outline {
    fn eq(&self, other: &Self) -> bool {
        self.bounds == other.bounds
    }
}

/// What a rank tells the first one of its own cells and nodes.
#[derive(Default, Serialize, Deserialize)]
struct Sketch {
    /// Kind, nodes of each and number of consecutive cells.
    runs: Vec<(CellKind, u32, u32)>,
    /// Nodes of the cells of lower dimension, by their numbers in the whole mesh.
    #[serde(with = "raw")]
    faces: Vec<u32>,
    /// These nodes, each once, ascending, and where they are.
    #[serde(with = "raw")]
    nodes: Vec<u32>,
    #[serde(with = "raw")]
    places: Vec<Vector>,
    bounds: Option<Bounds>,
}

impl Sketch {
    fn of(part: &Mesh) -> Self {
        let dimension = part.dimension();
        let whole = part.part.as_ref().expect("it is a part of a mesh");
        let mut sketch = Self {
            bounds: Some(Bounds::around(&part.points[whole.own_nodes.clone()])),
            ..Self::default()
        };
        let mut here = Vec::new();
        for run in part.cells.runs_in(part.own_cells()) {
            let n_cells = run.n_cells() as u32;
            sketch.runs.push((run.kind, run.n_nodes as u32, n_cells));
            if run.kind.dimension() < dimension {
                here.extend_from_slice(run.connectivity);
            }
        }
        let number = |&node: &u32| whole.nodes[node as usize];
        sketch.faces = here.iter().map(number).collect();
        here.sort_unstable();
        here.dedup();
        sketch.nodes = here.iter().map(number).collect();
        let place = |&node: &u32| part.points[node as usize];
        sketch.places = here.iter().map(place).collect();
        sketch
    }
}

impl Mesh {
    /// The outline of the mesh of which each rank has a part, on the first rank, without groups and arrays. All ranks call it; on
    /// the first `by` gives what they write together.
    pub(crate) fn outline_of(
        part: &Self,
        n_nodes: usize,
        ranks: &Ranks,
        by: Option<Arc<dyn Apart>>,
    ) -> Option<Self> {
        let mut to_each: Vec<Sketch> = (0..ranks.n()).map(|_| Sketch::default()).collect();
        to_each[0] = Sketch::of(part);
        let sketches = ranks.exchange_values(to_each);
        let by = by?;
        let runs = sketches.iter().flat_map(|sketch| &sketch.runs);
        let kinds = runs.map(|&(kind, n_nodes, n)| (kind, n_nodes as usize, n as usize));
        // In tests it shows when something computes with what is not known, which takes the memory of the whole mesh.
        let (coordinate, node) = match ranks.are_threads() {
            true => (f64::NAN, u32::MAX),
            false => (0.0, 0),
        };
        let mut mesh = Self {
            points: sparse::zeros(n_nodes, [coordinate; 3]),
            cells: Cells::of_kinds(kinds, node),
            space: part.space,
            ..Self::default()
        };
        let faces = sketches.iter().flat_map(|sketch| &sketch.faces);
        mesh.cells.set_nodes_below(mesh.dimension(), faces.copied());
        let mut bounds = Bounds::EMPTY;
        for sketch in &sketches {
            mesh.take_places(&sketch.nodes, &sketch.places);
            let of_rank = sketch.bounds.iter();
            bounds = of_rank.fold(bounds, Bounds::union);
        }
        mesh.outline = Some(Outline { bounds, by });
        Some(mesh)
    }

    /// Takes where some nodes are, of which the outline did not know.
    pub(crate) fn take_places(&mut self, nodes: &[u32], places: &[Vector]) {
        for (&node, place) in nodes.iter().zip(places) {
            self.points[node as usize] = *place;
        }
    }

    /// The box around all nodes, those of the whole mesh where this is its outline.
    pub fn extent(&self) -> Bounds {
        match &self.outline {
            Some(outline) => outline.bounds,
            None => Bounds::around(&self.points),
        }
    }
}
