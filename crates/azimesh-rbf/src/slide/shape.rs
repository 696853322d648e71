//! Curved patches and edges of a sliding surface, and their nearest points.
//!
//! A face with more nodes than corners is divided into facets between its nodes, and each facet stands for a piece of the face.
//! The nearest facet is found first. Gauss-Newton steps in the reference coordinates then give the nearest point of the polynomial,
//! for each piece that shares a corner with this facet; the nearest of these points is the result.

use azimesh_core::geometry::closest::ClosestSurface;
use azimesh_core::geometry::vector::{Vector, add, distance, dot, scale, sub};
use std::sync::Arc;

/// Gauss-Newton steps at most, and halvings of one.
const STEPS: usize = 50;
const HALVINGS: usize = 12;
/// A step of this size, as a part of a facet, is the last.
const LAST: f64 = 1e-14;
/// Steps go this far beyond a facet, as a part of it.
const BEYOND: f64 = 0.25;

/// A place on a face, in its reference coordinates; the second one of an edge is 0.
type FaceCoordinates = [f64; 2];

/// The map of a kind of face or edge: `x(s) = sum_m s^m sum_i shares[m][i] x_i`.
#[derive(Debug)]
pub struct FaceMap {
    /// The reference coordinates of each node.
    pub places: Vec<FaceCoordinates>,
    /// The exponents `m`.
    pub exponents: Vec<[i32; 2]>,
    /// The share of each node in each coefficient (terms, nodes).
    pub shares: Vec<f64>,
}

impl FaceMap {
    /// The map of a flat triangle.
    pub(super) fn flat() -> Self {
        Self {
            places: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            exponents: vec![[0, 0], [1, 0], [0, 1]],
            shares: vec![1.0, 0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 0.0, 1.0],
        }
    }
}

/// A face with a polynomial map.
#[derive(Debug, Clone)]
pub struct CurvedFace {
    /// Its nodes, as indices of surface points.
    pub nodes: Vec<u32>,
    /// The map of its kind.
    pub map: Arc<FaceMap>,
}

/// A curved patch or edge.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    surface: ClosestSurface<'static>,
    /// A piece for each facet; empty if the facets are the surface.
    pieces: Vec<FacePiece>,
    /// The pieces at each point.
    around: Vec<Vec<u32>>,
    /// True if its periodic images belong to it.
    pub is_continued: bool,
}

/// A face at its position.
#[derive(Debug)]
pub(super) struct Polynomial {
    map: Arc<FaceMap>,
    coefficients: Vec<Vector>,
}

/// The part of a face above a facet: corners in its reference coordinates. An edge repeats its second.
#[derive(Debug, Clone)]
pub(super) struct FacePiece {
    pub polynomial: Arc<Polynomial>,
    pub corners: [FaceCoordinates; 3],
}

impl Shape {
    /// Builds a shape of facets between points, with a piece for each facet or without pieces.
    pub fn new(
        points: Vec<Vector>,
        facets: &[[u32; 3]],
        pieces: Vec<FacePiece>,
        is_continued: bool,
    ) -> Self {
        let mut around = vec![Vec::new(); if pieces.is_empty() { 0 } else { points.len() }];
        if !pieces.is_empty() {
            for (facet, at) in facets.iter().zip(0..) {
                facet
                    .iter()
                    .for_each(|&corner| around[corner as usize].push(at));
            }
        }
        Self {
            surface: ClosestSurface::new(points, facets),
            pieces,
            around,
            is_continued,
        }
    }

    /// Returns the nearest point of the shape with its distance, if a facet is within a distance.
    pub fn nearest(&self, x: &Vector, within: f64) -> Option<(f64, Vector)> {
        if self.surface.bounds().distance_squared(x) > within * within {
            return None;
        }
        let foot = self.surface.nearest(x, within)?;
        if self.pieces.is_empty() {
            return Some((foot.distance_squared.sqrt(), self.surface.point(&foot)));
        }
        let mut near: Vec<u32> = Vec::new();
        for corner in foot.corners {
            near.extend(&self.around[corner as usize]);
        }
        near.sort_unstable();
        near.dedup();
        let feet = near.iter().map(|&piece| {
            let foot = self.pieces[piece as usize].nearest(x);
            (distance(foot, *x), foot)
        });
        feet.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Polynomial {
    /// Puts a face at the positions of its nodes.
    pub fn new(map: &Arc<FaceMap>, nodes: &[Vector]) -> Self {
        let rows = map.shares.chunks_exact(nodes.len());
        let coefficient = |shares: &[f64]| {
            let terms = shares.iter().zip(nodes);
            terms.fold([0.0; 3], |sum, (share, x)| add(sum, scale(*x, *share)))
        };
        Self {
            coefficients: rows.map(coefficient).collect(),
            map: map.clone(),
        }
    }

    /// The position at a place, and its derivatives.
    fn at(&self, [s, t]: FaceCoordinates) -> [Vector; 3] {
        let mut all = [[0.0; 3]; 3];
        for ([i, j], c) in self.map.exponents.iter().zip(&self.coefficients) {
            let slope = |x: f64, n: i32| {
                if n == 0 {
                    0.0
                } else {
                    f64::from(n) * x.powi(n - 1)
                }
            };
            let values = [
                s.powi(*i) * t.powi(*j),
                slope(s, *i) * t.powi(*j),
                s.powi(*i) * slope(t, *j),
            ];
            for (sum, value) in all.iter_mut().zip(values) {
                *sum = add(*sum, scale(*c, value));
            }
        }
        all
    }
}

impl FacePiece {
    /// The nearest point of the piece: inside, or on one of its sides.
    fn nearest(&self, x: &Vector) -> Vector {
        let [a, b, c] = self.corners;
        let way = |from: FaceCoordinates, to: FaceCoordinates| [to[0] - from[0], to[1] - from[1]];
        let on_side = |(from, to): (FaceCoordinates, FaceCoordinates)| {
            let clamp = |[u, _]: FaceCoordinates| [u.clamp(0.0, 1.0), 0.0];
            self.descend(x, from, [way(from, to), [0.0; 2]], [0.5, 0.0], clamp)
                .1
        };
        if b == c {
            return on_side((a, b));
        }
        let clamp = |at: FaceCoordinates| at.map(|u| u.clamp(-BEYOND, 1.0 + BEYOND));
        let ways = [way(a, b), way(a, c)];
        let ([u, v], foot) = self.descend(x, a, ways, [1.0 / 3.0; 2], clamp);
        if u >= -LAST && v >= -LAST && u + v <= 1.0 + LAST {
            return foot;
        }
        let sides = [(a, b), (b, c), (c, a)].map(on_side);
        let nearest = sides.into_iter();
        let nearest = nearest.min_by(|a, b| distance(*a, *x).total_cmp(&distance(*b, *x)));
        nearest.unwrap_or(foot)
    }

    /// Descends to the nearest point of the face over `origin + u ways[0] + v ways[1]` from a start `[u, v]`; `clamp` keeps
    /// these within limits.
    fn descend(
        &self,
        x: &Vector,
        origin: FaceCoordinates,
        ways: [FaceCoordinates; 2],
        start: FaceCoordinates,
        clamp: impl Fn(FaceCoordinates) -> FaceCoordinates,
    ) -> (FaceCoordinates, Vector) {
        let at = |[u, v]: FaceCoordinates| {
            let place = |k: usize| origin[k] + u * ways[0][k] + v * ways[1][k];
            let [x, by_s, by_t] = self.polynomial.at([place(0), place(1)]);
            let along = |way: FaceCoordinates| add(scale(by_s, way[0]), scale(by_t, way[1]));
            (x, ways.map(along))
        };
        let mut here = start;
        let (mut foot, mut slopes) = at(here);
        for _ in 0..STEPS {
            let step = gauss_newton(slopes, sub(*x, foot));
            let mut part = 1.0;
            let mut size = 0.0;
            for _ in 0..HALVINGS {
                let next = clamp([here[0] + part * step[0], here[1] + part * step[1]]);
                let (moved, turned) = at(next);
                if distance(moved, *x) <= distance(foot, *x) {
                    size = f64::max((next[0] - here[0]).abs(), (next[1] - here[1]).abs());
                    (here, foot, slopes) = (next, moved, turned);
                    break;
                }
                part *= 0.5;
            }
            if size <= LAST {
                break;
            }
        }
        (here, foot)
    }
}

/// The step that brings a point linearly nearest to a way from it; along the first slope alone if the second is none.
fn gauss_newton([a, b]: [Vector; 2], way: Vector) -> FaceCoordinates {
    let [aa, ab, bb] = [dot(a, a), dot(a, b), dot(b, b)];
    let [ra, rb] = [dot(a, way), dot(b, way)];
    let det = aa * bb - ab * ab;
    if det > 1e-12 * aa * bb {
        return [(bb * ra - ab * rb) / det, (aa * rb - ab * ra) / det];
    }
    [if aa > 0.0 { ra / aa } else { 0.0 }, 0.0]
}
