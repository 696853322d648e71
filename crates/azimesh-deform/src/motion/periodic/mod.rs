//! Periodic pairs of sides: the rigid map from one side to the other, the partner of every node, and
//! the images that the interpolation needs.
//!
//! The map is a rotation about a given axis, a translation, or a rotation about an axis found from the
//! nodes. It maps every node of one side to a node of the other, and inward normals of one side to outward normals
//! of the other. Other modules move paired nodes identically.

mod fit;
mod followers;
mod images;

pub use followers::{Follower, followers};
pub use images::images;

use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_core::geometry::vector::{Vector, add, dot, scale, sub};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::numbers::{in_digits, point, short};
use std::collections::BTreeMap;
use std::fmt;

/// Largest distance of partners, as a part of the extent of both sides.
const TOLERANCE: f64 = 1e-6;
/// Components of a translation or an axis below this part are round-off of the file.
const SNAP: f64 = 1e-7;

/// A side of a pair: its tag, and the nodes of its faces.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    /// Name of the tag, for messages.
    pub name: &'a str,
    /// Nodes of the mesh, in any order; duplicates are allowed.
    pub nodes: &'a [u32],
    /// Inward normal at each of them, of any length; zero if it is unknown.
    pub inward: &'a [Vector],
}

/// An axis of rotation of a side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// A point on it.
    pub origin: Vector,
    /// Its direction, of unit length.
    pub direction: Vector,
}

/// Map from one side to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Symmetry {
    /// A translation by this vector.
    Translation(Vector),
    /// A right-handed rotation.
    Rotation {
        /// About this axis.
        axis: Axis,
        /// By this angle, in radians.
        angle: f64,
    },
}

impl Symmetry {
    /// The map itself.
    pub fn transform(&self) -> Transform {
        self.power(1)
    }

    /// Returns the map applied `times` times, backwards when negative. Quarter and half turns about the
    /// coordinate axes have exact entries.
    pub fn power(&self, times: i32) -> Transform {
        match self {
            Self::Translation(by) => Transform::translation(scale(*by, f64::from(times))),
            Self::Rotation { axis, angle } => {
                let turn = Transform::rotation(axis.direction, [0.0; 3], angle * f64::from(times));
                let rotation = turn.rotation.map(|row| row.map(snapped));
                let turn = Transform { rotation, ..turn };
                Transform {
                    translation: sub(axis.origin, turn.turn(axis.origin)),
                    ..turn
                }
            }
        }
    }
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation(by) => write!(f, "a translation by {}", point(by)),
            Self::Rotation { axis, angle } => write!(
                f,
                "a rotation by {} degrees about the direction {} through {}",
                short(angle.to_degrees()),
                point(&axis.direction),
                point(&axis.origin)
            ),
        }
    }
}

/// Returns an entry of a rotation, with -1, 0 and 1 exact.
fn snapped(entry: f64) -> f64 {
    let whole = entry.round() + 0.0;
    if (entry - whole).abs() < 1e-14 {
        whole
    } else {
        entry
    }
}

/// Two sides that a rigid map makes equal.
#[derive(Debug, Clone, PartialEq)]
pub struct Periodic {
    /// Nodes of the first side with their partners on the second, ascending. A node on the axis of a rotation is its
    /// own partner. Of several nodes at one position, each is in a pair.
    pub pairs: Vec<(u32, u32)>,
    /// Map from the first side to the second.
    pub symmetry: Symmetry,
    /// Its map.
    pub transform: Transform,
    /// Largest distance between the image of a node and its partner, in mesh units.
    pub mismatch: f64,
}

impl Periodic {
    /// Pairs the nodes of side `a` with the nodes of side `b`. A rotation about `axis` is preferred.
    ///
    /// # Errors
    /// If a side has no nodes, or the sides differ in their number of nodes or share nodes. Also if no map, or more
    /// than one, brings every node of `a` within 1e-6 of the extent of a node of `b` with the mesh on its other side.
    pub fn find(
        place: &dyn Fn(u32) -> Vector,
        a: Side<'_>,
        b: Side<'_>,
        axis: Option<Axis>,
    ) -> Result<Self> {
        let [places_a, places_b] = [&a, &b].map(|side| Places::new(place, side));
        let sides = Sides {
            tolerance: TOLERANCE
                * Bounds::around(places_a.at.iter().chain(&places_b.at)).diagonal(),
            target: target(&places_b.at),
            a: places_a,
            b: places_b,
        };
        sides.check(&a, &b)?;
        if let Some(rough) = axis.and_then(|axis| sides.about(axis)) {
            let (found, symmetry) = sides.refined(rough);
            if found.n_apart == 0 && sides.face_each_other(&found, &symmetry) {
                return Ok(sides.paired(&found, symmetry));
            }
        }
        let mut nearest: Option<(Match, Symmetry)> = None;
        let mut right: Option<(Match, Symmetry)> = None;
        let mut turned_in: Option<Symmetry> = None;
        for rough in sides.candidates(axis) {
            let (found, symmetry) = sides.refined(rough);
            if found.n_apart == 0 {
                match &right {
                    _ if !sides.face_each_other(&found, &symmetry) => turned_in = Some(symmetry),
                    None => right = Some((found, symmetry)),
                    Some((same, _)) if same.pairs_as(&found) => {}
                    Some((_, other)) => return Err(several(&a, &b, [other, &symmetry])),
                }
                continue;
            }
            let better = |(best, _): &(Match, Symmetry)| found.n_apart < best.n_apart;
            if nearest.as_ref().is_none_or(better) {
                nearest = Some((found, symmetry));
            }
        }
        match right {
            Some((found, symmetry)) => Ok(sides.paired(&found, symmetry)),
            None => Err(sides.no_map(&a, &b, nearest, turned_in)),
        }
    }
}

/// Returns the error of two maps that both take one side to the other.
fn several(a: &Side<'_>, b: &Side<'_>, maps: [&Symmetry; 2]) -> Error {
    let [first, second] = maps;
    Error::input(format!(
        "the periodic sides \"{}\" and \"{}\" match by {first} and by {second}; set rotor.hub and rotor.shaft_axis to \
         the axis of the rotation that is meant, or name sides that match in one way",
        a.name, b.name
    ))
}

/// The distinct positions of a side.
struct Places {
    at: Vec<Vector>,
    /// Nodes of each, ascending.
    nodes: Vec<Vec<u32>>,
    /// Inward normal at each, of any length.
    inward: Vec<Vector>,
}

impl Places {
    fn new(place: &dyn Fn(u32) -> Vector, side: &Side<'_>) -> Self {
        let key = |node: u32| place(node).map(|x| (x + 0.0).to_bits());
        let nodes = side.nodes.iter().copied();
        let directions: BTreeMap<u32, Vector> = nodes.zip(side.inward.iter().copied()).collect();
        let inward = |nodes: &Vec<u32>| {
            let of_nodes = nodes.iter().filter_map(|node| directions.get(node));
            of_nodes.fold([0.0; 3], |sum, direction| add(sum, *direction))
        };
        let mut sorted = side.nodes.to_vec();
        sorted.sort_unstable_by_key(|&node| (key(node), node));
        sorted.dedup();
        let mut groups: Vec<Vec<u32>> = sorted
            .chunk_by(|&a, &b| key(a) == key(b))
            .map(<[u32]>::to_vec)
            .collect();
        groups.sort_unstable();
        Self {
            at: groups.iter().map(|nodes| place(nodes[0])).collect(),
            inward: groups.iter().map(inward).collect(),
            nodes: groups,
        }
    }

    fn centre(&self) -> Vector {
        let sum = self.at.iter().fold([0.0; 3], |sum, x| add(sum, *x));
        scale(sum, 1.0 / self.at.len().max(1) as f64)
    }
}

/// Points as facets of one corner each.
fn target(at: &[Vector]) -> ClosestSurface<'static> {
    let facets: Vec<[u32; 3]> = (0..at.len() as u32).map(|i| [i; 3]).collect();
    ClosestSurface::new(at.to_vec(), &facets)
}

/// Both sides, ready to be compared.
struct Sides {
    a: Places,
    b: Places,
    target: ClosestSurface<'static>,
    tolerance: f64,
}

/// Result of applying a map to the positions of `a`, compared with the positions of `b`.
struct Match {
    /// The nearest position of `b` to the image of each position of `a`, and the distance.
    partners: Vec<(u32, f64)>,
    /// Number of positions without a partner, or with a partner that is taken.
    n_apart: usize,
    /// The first of them.
    first_apart: Option<usize>,
    mismatch: f64,
}

impl Match {
    fn pairs_as(&self, other: &Self) -> bool {
        let partners = |of: &Self| {
            of.partners
                .iter()
                .map(|(partner, _)| *partner)
                .collect::<Vec<_>>()
        };
        partners(self) == partners(other)
    }
}

impl Sides {
    fn check(&self, a: &Side<'_>, b: &Side<'_>) -> Result<()> {
        for (side, places) in [(a, &self.a), (b, &self.b)] {
            if places.at.is_empty() {
                return Err(Error::input(format!(
                    "the periodic side \"{}\" has no nodes",
                    side.name
                )));
            }
        }
        let (n_a, n_b) = (self.a.at.len(), self.b.at.len());
        if n_a != n_b {
            return Err(Error::input(format!(
                "the periodic sides \"{}\" and \"{}\" have {n_a} and {n_b} nodes; they must match by a \
                 translation or a rotation",
                a.name, b.name
            )));
        }
        if self.a.nodes == self.b.nodes {
            return Err(Error::input(format!(
                "the periodic sides \"{}\" and \"{}\" have the same nodes; name two different sides",
                a.name, b.name
            )));
        }
        Ok(())
    }

    fn pair(&self, symmetry: &Symmetry) -> Match {
        let map = symmetry.transform();
        let mut taken = vec![false; self.b.at.len()];
        let mut found = Match {
            partners: Vec::with_capacity(self.a.at.len()),
            n_apart: 0,
            first_apart: None,
            mismatch: 0.0,
        };
        for (i, x) in self.a.at.iter().enumerate() {
            let foot = self.target.nearest(&map.apply(*x), f64::INFINITY);
            let foot = foot.expect("the second side has nodes");
            let (partner, away) = (foot.corners[0], foot.distance_squared.sqrt());
            let taken = &mut taken[partner as usize];
            if away > self.tolerance || *taken {
                found.n_apart += 1;
                found.first_apart.get_or_insert(i);
            }
            *taken = true;
            found.mismatch = f64::max(found.mismatch, away);
            found.partners.push((partner, away));
        }
        found
    }

    /// Returns a map with the median translation or angle of the partners, if it is at least as good as the map
    /// itself, and the pairs it gives. Nodes without a partner have no influence on the median.
    fn refined(&self, rough: Symmetry) -> (Match, Symmetry) {
        let first = self.pair(&rough);
        let symmetry = self.median(&first, rough);
        let second = self.pair(&symmetry);
        if second.n_apart == 0 || second.n_apart < first.n_apart {
            (second, symmetry)
        } else {
            (first, rough)
        }
    }

    fn median(&self, found: &Match, rough: Symmetry) -> Symmetry {
        let partner = |i: usize| self.b.at[found.partners[i].0 as usize];
        let median = |of: &dyn Fn(Vector, Vector) -> f64| {
            let nodes = self.a.at.iter().enumerate();
            let mut values: Vec<f64> = nodes.map(|(i, x)| of(*x, partner(i))).collect();
            let middle = values.len() / 2;
            *values.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        match rough {
            Symmetry::Translation(by) => {
                let component = |k: usize| {
                    if by[k] == 0.0 {
                        0.0
                    } else {
                        median(&|x, y| y[k] - x[k])
                    }
                };
                Symmetry::Translation(std::array::from_fn(component))
            }
            Symmetry::Rotation { axis, angle } => {
                let map = rough.transform();
                let rest = median(&|x, y| fit::angle_about(&axis, map.apply(x), y));
                let angle = fit::part_of_circle(angle + rest);
                Symmetry::Rotation { axis, angle }
            }
        }
    }

    /// Returns whether a map turns normals into the mesh at the first side into normals out of it at the second. True
    /// if no normals are known.
    fn face_each_other(&self, found: &Match, symmetry: &Symmetry) -> bool {
        let map = symmetry.transform();
        let inward = self.a.inward.iter().zip(&found.partners);
        let along = inward.map(|(a, (b, _))| dot(map.turn(*a), self.b.inward[*b as usize]));
        along.sum::<f64>() <= 0.0
    }

    fn paired(&self, found: &Match, symmetry: Symmetry) -> Periodic {
        Periodic {
            pairs: self.node_pairs(found),
            symmetry,
            transform: symmetry.transform(),
            mismatch: found.mismatch,
        }
    }

    fn node_pairs(&self, found: &Match) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for (own, (partner, _)) in self.a.nodes.iter().zip(&found.partners) {
            let theirs = &self.b.nodes[*partner as usize];
            for i in 0..own.len().max(theirs.len()) {
                let node = |of: &[u32]| of[i.min(of.len() - 1)];
                pairs.push((node(own), node(theirs)));
            }
        }
        pairs.sort_unstable();
        pairs
    }

    fn no_map(
        &self,
        a: &Side<'_>,
        b: &Side<'_>,
        nearest: Option<(Match, Symmetry)>,
        turned_in: Option<Symmetry>,
    ) -> Error {
        let turned_in = turned_in.map_or(String::new(), |symmetry| {
            format!(
                "; {symmetry} matches their nodes, but leaves the mesh on the same side of both"
            )
        });
        let Some((found, symmetry)) = nearest else {
            return Error::input(format!(
                "the periodic sides \"{}\" and \"{}\" do not match by a translation or a rotation{turned_in}",
                a.name, b.name
            ));
        };
        let apart = found.first_apart.unwrap_or(0);
        let (partner, away) = found.partners[apart];
        let map = match symmetry {
            Symmetry::Translation(by) => format!("moved by {}", point(&by)),
            Symmetry::Rotation { angle, .. } => {
                format!("turned by {} degrees", short(angle.to_degrees()))
            }
        };
        let taken = if away <= self.tolerance {
            ", which is the partner of another node"
        } else {
            ""
        };
        Error::input(format!(
            "node {} of the periodic side \"{}\" has no partner on \"{}\": {map}, it is {} from the \
             nearest node there, {}{taken}; at most {} is allowed{turned_in}",
            self.a.nodes[apart][0],
            a.name,
            b.name,
            in_digits(away, 4),
            self.b.nodes[partner as usize][0],
            in_digits(self.tolerance, 4)
        ))
    }
}

#[cfg(test)]
mod tests;
