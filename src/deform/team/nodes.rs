//! The nodes of a rank: where they are at rest and at a step, and which of them are not placed by fields.
//!
//! A rank has the nodes of its part of the mesh, its own nodes among them; where cells are not judged there are no parts, and it
//! has its own nodes alone. Own nodes are consecutive in the whole mesh, and each node belongs to one rank.

use super::placing::{Apart, Maps};
use crate::deform::step_memory::Rounding;
use crate::geometry::vector::Vector;
use crate::mesh::{Mesh, Part};
use std::ops::Range;
use std::sync::Arc;

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
    pub apart: Apart,
}

impl Nodes {
    /// Those of a part of a mesh of `n_nodes`.
    pub fn of_part(n_nodes: usize, apart: Apart) -> Self {
        Self {
            n_nodes,
            apart,
            ..Self::default()
        }
    }

    /// The own nodes, without a part; `first` is the number of the first in the whole mesh.
    pub fn alone((first, n_nodes): (usize, usize), rest: Vec<Vector>, apart: Apart) -> Self {
        Self {
            alone: rest,
            first,
            ..Self::of_part(n_nodes, apart)
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
