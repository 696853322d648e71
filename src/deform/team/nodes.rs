//! The nodes of a rank: where they are at rest and at a step, and which of them are not placed by fields.
//!
//! A rank has the nodes of its part of the mesh, its own nodes among them; where cells are not judged there are no parts, and it
//! has its own nodes alone. Own nodes are consecutive in the whole mesh, and each node belongs to one rank.

use super::placing::{Maps, NotByFields, Numbered, Placing};
use crate::deform::step_memory::Rounding;
use crate::geometry::vector::Vector;
use crate::mesh::{CellSet, Mesh, Part};
use crate::ranks::Ranks;
use std::ops::Range;
use std::sync::Arc;

/// What the first rank knows of the nodes of the whole mesh.
pub(super) struct OfNodes<'a> {
    /// Those that are not where fields move them, ascending.
    pub apart: &'a [(u32, Placing)],
    /// Those that deform; none for all.
    pub deforming: Option<&'a CellSet>,
}

/// Nodes without a part of the mesh, and the places of all nodes.
#[derive(Default)]
pub(super) struct Nodes {
    /// How many the whole mesh has.
    pub n_nodes: usize,
    /// Where the own nodes are at rest, and the number of the first in the whole mesh; those of a part are known from there.
    alone: Vec<Vector>,
    first: usize,
    /// Where the nodes are at a step.
    pub places: Vec<Vector>,
    /// Those that are not where fields move them.
    pub apart: NotByFields,
    /// Those that deform, ascending; none for all.
    pub deforming: Option<Arc<[u32]>>,
}

impl Nodes {
    /// Those of a rank, of which the first rank knows more. All ranks call it.
    pub fn share(of_first: Option<&OfNodes<'_>>, numbered: &Numbered<'_>, ranks: &Ranks) -> Self {
        Self {
            n_nodes: numbered.n_nodes,
            apart: NotByFields::share(of_first.map(|of| of.apart), numbered, ranks),
            deforming: numbered.deforming(of_first, ranks),
            ..Self::default()
        }
    }

    /// The own nodes, without a part; `first` is the number of the first in the whole mesh.
    pub fn alone(self, first: usize, rest: Vec<Vector>) -> Self {
        Self {
            alone: rest,
            first,
            ..self
        }
    }

    /// Where all are at rest.
    pub fn rest<'a>(&'a self, part: Option<&'a Mesh>) -> &'a [Vector] {
        part.map_or(&self.alone, |part| &part.points)
    }

    /// The own ones among them.
    pub fn own(&self, part: Option<&Mesh>) -> Range<usize> {
        let of_part = part.and_then(|part| part.part.as_ref());
        of_part.map_or(0..self.alone.len(), |part| part.own_nodes.clone())
    }

    /// The number of the first own node in the whole mesh.
    pub fn first(&self, part: Option<&Mesh>) -> usize {
        let of_part = part.and_then(|part| part.part.as_ref());
        let number = |part: &Arc<Part>| {
            let first = part.nodes.get(part.own_nodes.start);
            first.map_or(0, |&node| node as usize)
        };
        of_part.map_or(self.first, number)
    }

    /// The nodes of which the first rank tells, by their numbers in the whole mesh.
    pub fn told(&self, part: Option<&Mesh>) -> Vec<u32> {
        let of_part = part.and_then(|part| part.part.as_ref());
        let number = |&at: &u32| match of_part {
            Some(part) => part.nodes[at as usize],
            None => self.first as u32 + at,
        };
        self.apart.told.iter().map(number).collect()
    }

    /// Ends the move to a step: `turned` are those that turn with the rotor, ascending; none where all do.
    pub fn end_move(
        &mut self,
        maps: &Maps,
        turned: Option<&[u32]>,
        rounding: Rounding,
        part: Option<&Mesh>,
    ) {
        let mut places = std::mem::take(&mut self.places);
        self.apart
            .end_move(maps, turned, self.rest(part), &mut places);
        rounding.apply(&mut places);
        self.places = places;
    }
}
