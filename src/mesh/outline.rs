//! The outline of a mesh whose cells lie with several ranks, or in a file that is read piece by piece: what the first rank, or the
//! one process, knows of the whole.
//!
//! An outline has the kind of every cell, the nodes of the cells of lower dimension, which are the boundary faces, and where these
//! nodes are; where zones alone deform also the nodes between them and the rest, with their copies where zones turn ([`super::doubled`]).
//! Nodes and cells have the numbers of the whole mesh. The arrays of coordinates and of the nodes of cells are as long as
//! those of the whole, but what is not known was never written: the system gives no memory for it. Coordinates that are known
//! come first, in the order of their nodes, so that they take no more memory where these are far apart in the mesh:
//! [`Slots`] says which of an array are those of a node.

use super::from_slabs::MeshByRanges;
use super::numbering::{Numbering, among};
use super::{Apart, Cells, Mesh};
use crate::error::{Error, Result};
use crate::geometry::Bounds;
use crate::geometry::vector::Vector;
use crate::mesh::CellKind;
use crate::parallel;
use crate::ranks::Ranks;
use crate::ranks::raw;
use crate::sparse;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// The dimension of solid cells.
const SOLID: u8 = 3;

/// What an outline knows of the mesh but its arrays.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The box around all nodes.
    pub bounds: Bounds,
    /// The nodes of which it is known where they are.
    known: Arc<Numbering<'static>>,
    /// What stands for coordinates that are not known.
    unknown: f64,
    /// Who has the mesh.
    pub by: Arc<dyn Apart>,
}

impl PartialEq for Outline {
    fn eq(&self, other: &Self) -> bool {
        self.bounds == other.bounds
    }
}

/// Which entry of an array of positions is that of a node.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Slots<'a> {
    /// It has all nodes.
    All,
    /// It has those first that the outline of a mesh knows.
    Known(&'a Arc<Numbering<'static>>),
}

impl Slots<'_> {
    /// The entry of a node.
    ///
    /// # Panics
    /// Where it is not known where the node is.
    #[inline]
    pub fn of(self, node: u32) -> usize {
        match self {
            Self::All => node as usize,
            Self::Known(known) => known.place(node).expect("it is known where the node is"),
        }
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
        sketch.take_cells(&part.cells, part.own_cells(), dimension);
        let mut here = sketch.nodes_of_faces();
        let number = |node: &mut u32| *node = whole.nodes[*node as usize];
        let place = |&node: &u32| part.points[node as usize];
        sketch.places = here.iter().map(place).collect();
        here.iter_mut().for_each(number);
        sketch.nodes = here;
        sketch.faces.iter_mut().for_each(number);
        sketch
    }

    /// Takes in some cells of a mesh of this dimension.
    fn take_cells(&mut self, cells: &Cells, range: Range<usize>, dimension: u8) {
        for run in cells.runs_in(range) {
            let n_cells = run.n_cells() as u32;
            self.runs.push((run.kind, run.n_nodes as u32, n_cells));
            if run.kind.dimension() < dimension {
                self.faces.extend_from_slice(run.connectivity);
            }
        }
    }

    /// The nodes of the cells of lower dimension, each once, ascending.
    fn nodes_of_faces(&self) -> Vec<u32> {
        let mut nodes = self.faces.clone();
        parallel::sort(&mut nodes);
        nodes.dedup();
        nodes
    }

    /// The outline of a mesh of `n_nodes`, with `unknown` coordinates and nodes where it knows none.
    fn outline(
        sketches: &[Self],
        n_nodes: usize,
        space: Option<u8>,
        unknown: (f64, u32),
        by: Arc<dyn Apart>,
    ) -> Mesh {
        let runs = sketches.iter().flat_map(|sketch| &sketch.runs);
        let kinds = runs.map(|&(kind, n_nodes, n)| (kind, n_nodes as usize, n as usize));
        let mut mesh = Mesh {
            points: sparse::zeros(n_nodes, [unknown.0; 3]),
            cells: Cells::of_kinds(kinds, unknown.1),
            space,
            ..Mesh::default()
        };
        let faces = sketches.iter().flat_map(|sketch| &sketch.faces);
        mesh.cells.set_nodes_below(mesh.dimension(), faces.copied());
        let of_ranks = sketches.iter().flat_map(|sketch| &sketch.bounds);
        mesh.outline = Some(Outline {
            bounds: of_ranks.fold(Bounds::EMPTY, |all, own| all.union(own)),
            known: Arc::default(),
            unknown: unknown.0,
            by,
        });
        match sketches {
            [alone] => mesh.take_places(&alone.nodes, &alone.places),
            _ => {
                let nodes: Vec<u32> = sketches.iter().flat_map(|of| &of.nodes).copied().collect();
                let places: Vec<Vector> =
                    sketches.iter().flat_map(|of| &of.places).copied().collect();
                mesh.take_places(&nodes, &places);
            }
        }
        mesh
    }
}

impl Mesh {
    /// The outline of the mesh of which each rank has a part, on the first rank, without groups and arrays. All ranks call it; on
    /// the first `by` gives what they write together.
    pub(crate) fn outline_of(
        part: &Self,
        ranks: &Ranks,
        by: Option<Arc<dyn Apart>>,
    ) -> Option<Self> {
        let mut to_each: Vec<Sketch> = (0..ranks.n()).map(|_| Sketch::default()).collect();
        to_each[0] = Sketch::of(part);
        let sketches = ranks.exchange_values(to_each);
        // In tests it shows when something computes with what is not known, which takes the memory of the whole mesh.
        let unknown = match ranks.are_threads() {
            true => (f64::NAN, u32::MAX),
            false => (0.0, 0),
        };
        let n_nodes = part.n_nodes_of_all();
        Some(Sketch::outline(
            &sketches, n_nodes, part.space, unknown, by?,
        ))
    }

    /// The outline of a solid mesh that one process reads piece by piece, without groups and arrays; `by` gives the rest of it.
    ///
    /// # Errors
    /// As [`from_slabs`](Self::from_slabs), and where the mesh is not solid.
    pub(crate) fn outline_by_pieces(
        slabs: &MeshByRanges,
        faces_once: bool,
        by: Arc<dyn Apart>,
    ) -> Result<Self> {
        let mut sketch = Sketch::default();
        let mut dimension = 0;
        slabs.each_cells(&mut |_, cells| {
            dimension = dimension.max(cells.dimension());
            sketch.take_cells(cells, 0..cells.len(), SOLID);
            Ok(())
        })?;
        if dimension < SOLID {
            return Err(Error::input("it has no solid cells"));
        }
        sketch.nodes = sketch.nodes_of_faces();
        let mut bounds = Bounds::EMPTY;
        let (nodes, places) = (&sketch.nodes, &mut sketch.places);
        slabs.each_points(&mut |first, points| {
            bounds = bounds.union(&Bounds::around(points));
            let here = among(nodes, &(first..first + points.len())).iter();
            places.extend(here.map(|&node| points[node as usize - first]));
            Ok(())
        })?;
        sketch.bounds = Some(bounds);
        let unknown = match cfg!(debug_assertions) {
            true => (f64::NAN, u32::MAX),
            false => (0.0, 0),
        };
        let mesh = Sketch::outline(&[sketch], slabs.n_nodes, slabs.space, unknown, by);
        match faces_once {
            true => mesh.check_faces_once().map(|()| mesh),
            false => Ok(mesh),
        }
    }

    /// Which entries of its coordinates are those of its nodes.
    pub(crate) fn slots(&self) -> Slots<'_> {
        match &self.outline {
            None => Slots::All,
            Some(outline) => Slots::Known(&outline.known),
        }
    }

    /// Where a node is, which an outline has to know.
    ///
    /// # Panics
    /// Where it does not.
    #[doc(hidden)]
    pub fn place(&self, node: u32) -> Vector {
        self.points[self.slots().of(node)]
    }

    /// Takes where some nodes are, of which the outline did not know.
    pub(crate) fn take_places(&mut self, nodes: &[u32], places: &[Vector]) {
        let outline = self.outline.as_mut().expect("this is an outline");
        let is_new = |&(node, _): &(u32, u32)| outline.known.place(node).is_none();
        let mut new: Vec<(u32, u32)> = nodes.iter().copied().zip(0..).filter(is_new).collect();
        parallel::sort(&mut new);
        new.dedup_by_key(|of| of.0);
        let mut known = outline.known.sorted().to_vec();
        let mut n_before = known.len();
        known.resize(n_before + new.len(), 0);
        // From the last on, so that none is overwritten before it has its new entry.
        for slot in (0..known.len()).rev() {
            let last = new.last().copied();
            let comes_last = |&(node, _): &(u32, u32)| n_before == 0 || node > known[n_before - 1];
            match last.filter(comes_last) {
                Some((node, at)) => {
                    new.pop();
                    (known[slot], self.points[slot]) = (node, places[at as usize]);
                }
                None => {
                    n_before -= 1;
                    (known[slot], self.points[slot]) = (known[n_before], self.points[n_before]);
                }
            }
        }
        outline.known = Arc::new(Numbering::new(known));
    }

    /// Adds nodes to an outline of which nothing is known.
    pub(super) fn add_unknown_nodes(&mut self, n: usize) {
        let outline = self.outline.as_ref().expect("this is an outline");
        let n_known = outline.known.sorted().len();
        let unknown = [outline.unknown; 3];
        let mut points = sparse::zeros(self.points.len() + n, unknown);
        points[..n_known].copy_from_slice(&self.points[..n_known]);
        self.points = points;
    }

    /// The box around all nodes, those of the whole mesh where this is its outline.
    pub fn extent(&self) -> Bounds {
        match &self.outline {
            Some(outline) => outline.bounds,
            None => Bounds::around(&self.points),
        }
    }
}
