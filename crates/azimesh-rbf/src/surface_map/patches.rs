//! Overlapping patches of the given points, and the smooth weights that blend them at each wall point.
//!
//! ```text
//! d(y) = sum_p b_p(y) d_p(y),    b_p(y) ~ phi(sqrt(|y - c_p|^2 - m(y)^2) / r_p),    sum_p b_p = 1
//! m(y)^2 = max(0, min_p (|y - c_p|^2 - r_p^2 / 4))
//! ```
//!
//! `m` is zero near the given points. Farther away it is the distance that all patches share, so that patches below the wall
//! point count, not patches around it.

use super::in_plane;
use super::patch::{FLAT, Patch};
use crate::{Error, Kernel, Result, Vector};
use azimesh_core::geometry::vector::{add, dot, scale, sub};
use azimesh_core::geometry::{Bounds, curve};
use azimesh_core::parallel;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Number of points of a patch, and number of them next to the centre that need no patch of their own.
const POINTS: usize = 48;
const INNER: usize = 12;
/// Least ratio of the second extent of all points to the longest; below it they are on a line.
const LINE: f64 = 1e-6;
/// Points or patches of a box.
const BOX: usize = 64;

/// The patches, and the wall points that each of them serves.
#[derive(Debug, Clone)]
pub(super) struct Patches {
    patches: Vec<Patch>,
    /// Wall points of each patch with their blending weights.
    served: Vec<Vec<(u32, f64)>>,
    /// Points at the place of an earlier one, and that.
    twins: Vec<(u32, u32)>,
}

impl Patches {
    /// Patches of the given points that serve all wall points.
    pub fn new(given: &[Vector], wall: &[Vector]) -> Result<Self> {
        let in_plane = in_plane(given, wall);
        let (order, twins) = distinct(given);
        let places: Vec<Vector> = order.iter().map(|&i| given[i as usize]).collect();
        let boxes = boxes(&places);
        let mut patches: Vec<Patch> = Vec::new();
        let mut is_inner = vec![false; places.len()];
        for (at, place) in places.iter().enumerate() {
            if is_inner[at] {
                continue;
            }
            let mut n = POINTS;
            let patch = loop {
                let near = nearest(place, n, &places, &boxes);
                near.iter()
                    .take(INNER)
                    .for_each(|&i| is_inner[i as usize] = true);
                let points = near.iter().map(|&i| order[i as usize]).collect();
                let is_all = n >= places.len();
                let line = if is_all { LINE } else { FLAT };
                if let Some(patch) = Patch::new(*place, points, given, in_plane, line) {
                    break patch;
                }
                if is_all {
                    return Err(Error::input(
                        "the given points are on a line, or fewer than 3: they do not determine a rotation about it",
                    ));
                }
                n *= 2;
            };
            patches.push(patch);
        }
        let served = served(&patches, wall);
        Ok(Self {
            patches,
            served,
            twins,
        })
    }

    /// The displacements of the wall points.
    pub fn displacements(
        &self,
        given: &[Vector],
        wall: &[Vector],
        displacements: &[Vector],
    ) -> Result<Vec<Vector>> {
        if let Some((i, first)) = self
            .twins
            .iter()
            .find(|(i, first)| displacements[*i as usize] != displacements[*first as usize])
        {
            return Err(Error::input(format!(
                "the given points {first} and {i} are at one place and have different displacements"
            )));
        }
        let parts = parallel::try_map(self.patches.len(), &|p| {
            let system = self.patches[p].system(given)?;
            let solution = system.through(given, Some(displacements));
            let of = |&(i, weight): &(u32, f64)| {
                scale(system.displacement(&solution, &wall[i as usize]), weight)
            };
            Ok(self.served[p].iter().map(of).collect::<Vec<_>>())
        })?;
        let mut sums = vec![[0.0; 3]; wall.len()];
        for (served, part) in self.served.iter().zip(parts) {
            for ((i, _), value) in served.iter().zip(part) {
                sums[*i as usize] = add(sums[*i as usize], value);
            }
        }
        Ok(sums)
    }

    /// Adds the forces of the wall points to the given ones.
    pub fn pull_back(
        &self,
        given: &[Vector],
        wall: &[Vector],
        forces: &[Vector],
        sums: &mut [Vector],
    ) -> Result<()> {
        let parts = parallel::try_map(self.patches.len(), &|p| {
            let system = self.patches[p].system(given)?;
            let at_rest = system.through(given, None);
            let served = self.served[p].iter();
            let loads =
                served.map(|&(i, weight)| (wall[i as usize], scale(forces[i as usize], weight)));
            Ok(system.pull_back(&at_rest, loads))
        })?;
        for (patch, part) in self.patches.iter().zip(parts) {
            for (&i, force) in patch.points.iter().zip(part) {
                sums[i as usize] = add(sums[i as usize], force);
            }
        }
        Ok(())
    }
}

/// Points along a space-filling curve, and those at the place of an earlier one.
fn distinct(given: &[Vector]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let mut first: HashMap<[u64; 3], u32> = HashMap::new();
    let (mut order, mut twins) = (Vec::new(), Vec::new());
    for i in curve::order(given) {
        let place = given[i as usize].map(|x| (x + 0.0).to_bits());
        match first.entry(place) {
            Entry::Occupied(found) => twins.push((i, *found.get())),
            Entry::Vacant(free) => {
                free.insert(i);
                order.push(i);
            }
        }
    }
    (order, twins)
}

/// Boxes around each [`BOX`] consecutive places.
fn boxes(places: &[Vector]) -> Vec<Bounds> {
    places.chunks(BOX).map(Bounds::around).collect()
}

/// The `n` places nearest to a point, by distance.
fn nearest(point: &Vector, n: usize, places: &[Vector], boxes: &[Bounds]) -> Vec<u32> {
    let away = boxes
        .iter()
        .enumerate()
        .map(|(i, bounds)| (bounds.distance_squared(point), i));
    let mut away: Vec<(f64, usize)> = away.collect();
    away.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<(f64, u32)> = Vec::new();
    for (nearer_than, i) in away {
        if found.len() == n && found[n - 1].0 < nearer_than {
            break;
        }
        let block = parallel::block(places.len(), BOX, i);
        found.extend(block.map(|i| (squared(point, &places[i]), i as u32)));
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(n);
    }
    found.into_iter().map(|(_, i)| i).collect()
}

/// The wall points of each patch, with the weights of the patch there.
fn served(patches: &[Patch], wall: &[Vector]) -> Vec<Vec<(u32, f64)>> {
    let centres: Vec<Vector> = patches.iter().map(|patch| patch.centre).collect();
    let boxes: Vec<(Bounds, f64)> = boxes(&centres)
        .into_iter()
        .zip(patches.chunks(BOX))
        .map(|(bounds, block)| {
            (
                bounds,
                block
                    .iter()
                    .map(|patch| patch.radius * patch.radius)
                    .fold(0.0, f64::max),
            )
        })
        .collect();
    let weights = parallel::map(wall.len(), &|i| {
        let y = &wall[i];
        let block = |at: usize| patches[parallel::block(patches.len(), BOX, at)].iter();
        let mut shared = f64::INFINITY;
        for (at, (bounds, largest)) in boxes.iter().enumerate() {
            if bounds.distance_squared(y) - 0.25 * largest < shared {
                let powers = block(at)
                    .map(|patch| squared(y, &patch.centre) - 0.25 * patch.radius * patch.radius);
                shared = powers.fold(shared, f64::min);
            }
        }
        let shared = shared.max(0.0);
        let mut weights = Vec::new();
        for (at, (bounds, largest)) in boxes.iter().enumerate() {
            if bounds.distance_squared(y) - shared >= *largest {
                continue;
            }
            for (k, patch) in block(at).enumerate() {
                let beside = (squared(y, &patch.centre) - shared).max(0.0).sqrt();
                let weight = Kernel::WendlandC2.value(beside / patch.radius);
                if weight > 0.0 {
                    weights.push(((at * BOX + k) as u32, weight));
                }
            }
        }
        weights
    });
    let mut served = vec![Vec::new(); patches.len()];
    for (i, weights) in weights.iter().enumerate() {
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        for (p, weight) in weights {
            served[*p as usize].push((i as u32, weight / sum));
        }
    }
    served
}

fn squared(a: &Vector, b: &Vector) -> f64 {
    let away = sub(*a, *b);
    dot(away, away)
}
