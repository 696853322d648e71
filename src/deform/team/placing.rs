//! Which nodes fields move, and which are not where these move them. A rank itself places those at rest and those of rigid bodies;
//! of the others the first rank tells it one by one.

use super::nodes::OfNodes;
use crate::geometry::vector::Vector;
use crate::geometry::{Moving, Transform};
use crate::mesh::{CellSet, among, among_by, node_slab};
use crate::parallel;
use crate::ranks::Ranks;
use crate::ranks::raw::List;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Stands for the body of a node at rest.
const AT_REST: u16 = u16::MAX;
/// Stands for the body of a node of which the first rank tells.
const TOLD: u32 = u32::MAX;

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

/// The velocities at a step that fields do not give, and what turns all of them.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Rates {
    /// What each rigid body does, one transform after another; none of others.
    pub bodies: Vec<Option<Vec<Moving>>>,
    /// Turns nodes that deform.
    pub to_inertial: Option<Moving>,
}

/// Some nodes of a rank, by their place there, ascending, that are not where fields move them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct NotByFields {
    /// Those of which the first rank tells.
    pub told: Vec<u32>,
    /// Those that the rank places, and the body of each.
    placed: Vec<u32>,
    bodies: Vec<u16>,
}

/// A node with what [`Placing`] it has, as it is sent.
type Coded = [u32; 2];

fn coded((node, placing): &(u32, Placing)) -> Coded {
    let code = match placing {
        Placing::Told => TOLD,
        Placing::AtRest => u32::from(AT_REST),
        Placing::Body(body) => u32::from(*body),
    };
    [*node, code]
}

/// The nodes of a rank by their numbers in the whole mesh.
pub(super) struct Numbered<'a> {
    /// How many the whole mesh has.
    pub n_nodes: usize,
    /// All of them, ascending; none where the rank has its own ones alone.
    pub all: Option<&'a [u32]>,
}

impl Numbered<'_> {
    fn slab(&self, rank: usize, ranks: &Ranks) -> Range<usize> {
        node_slab(self.n_nodes, rank, ranks.n())
    }

    /// What is coded of the own nodes of each rank, ascending, and what other ranks have of those that this one has of theirs; by the
    /// places of the nodes here.
    fn with_others(&self, own: Vec<Coded>, ranks: &Ranks) -> Vec<Coded> {
        let rank = ranks.rank();
        let Some(numbers) = self.all else {
            let first = self.slab(rank, ranks).start as u32;
            return own
                .iter()
                .map(|[node, code]| [node - first, *code])
                .collect();
        };
        let of_owner = |owner: usize| match owner == rank {
            true => Vec::new(),
            false => among(numbers, &self.slab(owner, ranks)).to_vec(),
        };
        let asked = ranks.exchange((0..ranks.n()).map(of_owner).collect());
        let answers = asked.iter().map(|asked| common(asked, &own)).collect();
        let mut found = ranks.exchange(answers);
        found[rank] = own;
        let mut found = found.concat();
        let mut at = 0;
        for [node, _] in &mut found {
            at += numbers[at..].partition_point(|other| *other < *node);
            *node = at as u32;
        }
        found
    }

    /// Those of the nodes that deform, by their places here, ascending; none for all.
    pub fn deforming(&self, of_first: Option<&OfNodes<'_>>, ranks: &Ranks) -> Option<Arc<[u32]>> {
        let own = ranks.scatter(&mut |rank| {
            let ends = |range: Range<usize>| [range.start as u32, range.end as u32];
            let here = |all: &CellSet| {
                let ranges = all.ranges_in(self.slab(rank, ranks));
                List(ranges.map(ends).collect::<Vec<_>>())
            };
            Some(of_first?.deforming.map(here))
        });
        let List(ranges) = own?;
        let own = ranges.iter().flat_map(|&[start, end]| start..end);
        let all = self.with_others(own.map(|node| [node, 0]).collect(), ranks);
        Some(all.into_iter().map(|[at, _]| at).collect())
    }
}

impl NotByFields {
    /// Of the nodes of each rank those that are in `all`, ascending, which the first rank has. It tells each rank of its own nodes,
    /// and ranks tell each other of the rest.
    pub fn share(all: Option<&[(u32, Placing)]>, nodes: &Numbered<'_>, ranks: &Ranks) -> Self {
        let List(own) = ranks.scatter(&mut |rank| {
            let of_slab = among_by(all?, |of| of.0, &nodes.slab(rank, ranks));
            Some(List(of_slab.iter().map(coded).collect::<Vec<_>>()))
        });
        let mut apart = Self::default();
        for [at, code] in nodes.with_others(own, ranks) {
            if code == TOLD {
                apart.told.push(at);
            } else {
                apart.placed.push(at);
                apart.bodies.push(code as u16);
            }
        }
        apart
    }

    /// Ends the move of nodes that are at `rest` in the reference mesh: puts those that the rank places where they belong, and
    /// turns those that are `turned`, or with none all.
    pub fn end_move(
        &self,
        maps: &Maps,
        turned: Option<&[u32]>,
        rest: &[Vector],
        points: &mut [Vector],
    ) {
        let placed = || self.placed.iter().zip(&self.bodies);
        for (&at, _) in placed().filter(|(_, body)| **body == AT_REST) {
            points[at as usize] = rest[at as usize];
        }
        if let Some(to_inertial) = &maps.to_inertial {
            let turn = |x: &mut Vector| *x = to_inertial.apply(*x);
            match turned {
                Some(nodes) => nodes.iter().for_each(|&at| turn(&mut points[at as usize])),
                None => parallel::update(points, |_, x| turn(x)),
            }
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

    /// Sets velocities in the frame of the rotor of nodes that are at `rest` in the reference mesh: those of nodes that the rank
    /// places, and of those of which the first rank has `told`.
    pub fn set_velocities(
        &self,
        rates: &Rates,
        told: &[Vector],
        rest: &[Vector],
        out: &mut [Vector],
    ) {
        for (&at, &body) in self.placed.iter().zip(&self.bodies) {
            let links = match body {
                AT_REST => None,
                body => rates.bodies[usize::from(body)].as_ref(),
            };
            let still = (rest[at as usize], [0.0; 3]);
            let moving = links.into_iter().flatten();
            out[at as usize] = moving.fold(still, |state, link| link.carry(state)).1;
        }
        self.take(told, out);
    }

    /// Puts nodes where the first rank says.
    pub fn take(&self, places: &[Vector], points: &mut [Vector]) {
        for (&at, &place) in self.told.iter().zip(places) {
            points[at as usize] = place;
        }
    }
}

/// Those of ascending `own` that are among ascending `nodes`.
fn common(nodes: &[u32], own: &[Coded]) -> Vec<Coded> {
    let mut own = own.iter().peekable();
    let of = |&node: &u32| {
        while own.next_if(|other| other[0] < node).is_some() {}
        own.next_if(|other| other[0] == node).copied()
    };
    nodes.iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranks::on_threads;

    #[test]
    fn each_rank_knows_which_of_its_nodes_are_placed_and_how() {
        // Two ranks with 256 own nodes each; the first has two of the second as well.
        let all = [
            (5, Placing::Told),
            (255, Placing::AtRest),
            (256, Placing::Body(3)),
            (300, Placing::Told),
        ];
        let shared = on_threads(2, |ranks| {
            let own = node_slab(512, ranks.rank(), 2);
            let mut numbers: Vec<u32> = (own.start as u32..own.end as u32).collect();
            if ranks.is_first() {
                numbers.extend([256, 299]);
            }
            let all = ranks.is_first().then_some(&all[..]);
            let nodes = |numbers| Numbered {
                n_nodes: 512,
                all: numbers,
            };
            let with_others = NotByFields::share(all, &nodes(Some(&numbers)), &ranks);
            (with_others, NotByFields::share(all, &nodes(None), &ranks))
        });
        let apart = |told: &[u32], placed: &[u32], bodies: &[u16]| NotByFields {
            told: told.to_vec(),
            placed: placed.to_vec(),
            bodies: bodies.to_vec(),
        };
        assert_eq!(shared[0].0, apart(&[5], &[255, 256], &[AT_REST, 3]));
        assert_eq!(shared[0].1, apart(&[5], &[255], &[AT_REST]));
        assert_eq!(shared[1].0, apart(&[44], &[0], &[3]));
        assert_eq!(shared[1].0, shared[1].1);
    }

    #[test]
    fn nodes_at_rest_and_those_of_bodies_are_placed_and_others_turned() {
        let apart = NotByFields {
            told: Vec::new(),
            placed: vec![2, 4],
            bodies: vec![AT_REST, 1],
        };
        let maps = Maps {
            bodies: vec![None, Some(Transform::translation([0.0, 1.0, 0.0]))],
            to_inertial: Some(Transform::translation([10.0, 0.0, 0.0])),
            in_plane: false,
        };
        let rest: Vec<Vector> = (3..8).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let mut points = vec![[0.5; 3]; 5];
        apart.end_move(&maps, Some(&[0, 2, 3, 4]), &rest, &mut points);
        let moved = [10.5, 0.5, 0.5];
        let wanted = [moved, [0.5; 3], [15.0, 0.0, 0.0], moved, [7.0, 1.0, 0.0]];
        assert_eq!(points, wanted);
        let mut points = vec![[0.5; 3]; 5];
        apart.end_move(&maps, None, &rest, &mut points);
        assert_eq!(points[1], moved);
    }
}
