//! Nodes that are not where fields move them. A rank itself places those at rest and those of rigid bodies; of the others the
//! first rank tells it one by one.

use crate::geometry::Transform;
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::ranks::raw;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Stands for the body of a node at rest.
const AT_REST: u16 = u16::MAX;

/// Where a node goes that is not where fields move it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Placing {
    /// To a place that the first rank tells.
    Told,
    /// It stays.
    AtRest,
    /// With a rigid body.
    Body(u16),
}

/// What ends the move of all nodes to a step.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Maps {
    /// The map of each rigid body from the reference mesh; none of one that stays there.
    pub bodies: Vec<Option<Transform>>,
    /// Turns nodes that deform, before bodies are placed.
    pub to_inertial: Option<Transform>,
    /// Whether each node keeps its z.
    pub in_plane: bool,
}

/// Some nodes of a rank, by their place there, ascending, that are not where fields move them.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Apart {
    /// Those of which the first rank tells.
    #[serde(with = "raw")]
    pub told: Vec<u32>,
    /// Those that the rank places, and the body of each.
    #[serde(with = "raw")]
    placed: Vec<u32>,
    #[serde(with = "raw")]
    bodies: Vec<u16>,
}

impl Apart {
    fn push(&mut self, at: u32, placing: Placing) {
        let body = match placing {
            Placing::Told => return self.told.push(at),
            Placing::AtRest => AT_REST,
            Placing::Body(body) => body,
        };
        self.placed.push(at);
        self.bodies.push(body);
    }

    /// Those of ascending `apart` that are among ascending `nodes`.
    pub fn among(nodes: &[u32], apart: &[(u32, Placing)]) -> Self {
        let mut own = Self::default();
        let mut apart = apart.iter().peekable();
        for (at, node) in (0..).zip(nodes) {
            while apart.next_if(|(other, _)| other < node).is_some() {}
            if let Some((_, placing)) = apart.next_if(|(other, _)| other == node) {
                own.push(at, *placing);
            }
        }
        own
    }

    /// Those of ascending `apart` that are in a slab.
    pub fn within(slab: &Range<usize>, apart: &[(u32, Placing)]) -> Self {
        let before = |end: usize| apart.partition_point(|(node, _)| (*node as usize) < end);
        let mut own = Self::default();
        for (node, placing) in &apart[before(slab.start)..before(slab.end)] {
            own.push(node - slab.start as u32, *placing);
        }
        own
    }

    /// Ends the move of nodes that are at `rest` in the reference mesh: puts those that the rank places where they belong, and
    /// turns those that deform.
    pub fn end_move(
        &self,
        maps: &Maps,
        deforms: impl Fn(usize) -> bool + Sync,
        rest: &[Vector],
        points: &mut [Vector],
    ) {
        let placed = || self.placed.iter().zip(&self.bodies);
        for (&at, _) in placed().filter(|(_, body)| **body == AT_REST) {
            points[at as usize] = rest[at as usize];
        }
        if let Some(to_inertial) = &maps.to_inertial {
            parallel::update(points, |at, x| {
                if deforms(at) {
                    *x = to_inertial.apply(*x);
                }
            });
        }
        for (&at, &body) in placed().filter(|(_, body)| **body != AT_REST) {
            let x = rest[at as usize];
            let map = maps.bodies[usize::from(body)];
            points[at as usize] = map.map_or(x, |map| map.apply(x));
        }
        if maps.in_plane {
            parallel::update(points, |at, x| x[2] = rest[at][2]);
        }
    }

    /// Puts nodes where the first rank says.
    pub fn take(&self, places: &[Vector], points: &mut [Vector]) {
        for (&at, &place) in self.told.iter().zip(places) {
            points[at as usize] = place;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_placed_by_their_numbers() {
        let apart = [
            (2, Placing::Told),
            (5, Placing::AtRest),
            (7, Placing::Body(1)),
        ];
        let own = Apart::among(&[1, 2, 4, 5, 7, 9], &apart);
        assert_eq!(
            (&own.told, &own.placed, &own.bodies),
            (&vec![1], &vec![3, 4], &vec![AT_REST, 1])
        );
        let own = Apart::within(&(3..8), &apart);
        assert_eq!((&own.told, &own.placed), (&vec![], &vec![2, 4]));
        let maps = Maps {
            bodies: vec![None, Some(Transform::translation([0.0, 1.0, 0.0]))],
            to_inertial: Some(Transform::translation([10.0, 0.0, 0.0])),
            in_plane: false,
        };
        let rest: Vec<Vector> = (3..8).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let mut points = vec![[0.5; 3]; 5];
        own.end_move(&maps, |at| at != 1, &rest, &mut points);
        let moved = [10.5, 0.5, 0.5];
        let wanted = [moved, [0.5; 3], [15.0, 0.0, 0.0], moved, [7.0, 1.0, 0.0]];
        assert_eq!(points, wanted);
    }
}
