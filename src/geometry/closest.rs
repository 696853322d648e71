//! Closest points on a surface of triangles or, in the plane, of edges.

use super::bounds::Bounds;
use super::curve;
use super::vector::{Vector, add, dot, scale, sub};
use std::borrow::Cow;

/// Children of a tree node, and facets of a leaf.
const FAN: usize = 4;

/// Facets in a tree of boxes, ready for closest-point queries.
#[derive(Debug, Clone)]
pub struct ClosestSurface<'a> {
    points: Cow<'a, [Vector]>,
    /// Corners of each facet, along a space-filling curve. An edge repeats its second.
    facets: Vec<[u32; 3]>,
    /// Position of each facet in the list it was built from.
    origin: Vec<u32>,
    /// Boxes by level; the first is of the leaves.
    levels: Vec<Vec<Bounds>>,
}

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// Index of the facet in the list that the surface was built from.
    pub facet: usize,
    /// Corners of the facet.
    pub corners: [u32; 3],
    /// Barycentric weights of the corners.
    pub weights: [f64; 3],
    /// Square of the distance from the asking point.
    pub distance_squared: f64,
}

impl<'a> ClosestSurface<'a> {
    /// Builds the tree over borrowed or owned points. `O(n log n)`.
    pub fn new(points: impl Into<Cow<'a, [Vector]>>, facets: &[[u32; 3]]) -> Self {
        let points = points.into();
        let centre = |facet: &[u32; 3]| {
            let corners = facet.map(|i| points[i as usize]);
            scale(add(add(corners[0], corners[1]), corners[2]), 1.0 / 3.0)
        };
        let centres: Vec<Vector> = facets.iter().map(centre).collect();
        let origin = curve::order(&centres);
        let facets: Vec<[u32; 3]> = origin.iter().map(|&i| facets[i as usize]).collect();
        let corners = |facet: &[u32; 3]| facet.map(|i| points[i as usize]);
        let around = |group: &[[u32; 3]]| {
            Bounds::around(group.iter().flat_map(corners).collect::<Vec<_>>().iter())
        };
        let mut levels: Vec<Vec<Bounds>> = vec![facets.chunks(FAN).map(around).collect()];
        while levels.last().is_some_and(|level| level.len() > 1) {
            let below = &levels[levels.len() - 1];
            let join = |group: &[Bounds]| group.iter().fold(Bounds::EMPTY, |all, b| all.union(b));
            levels.push(below.chunks(FAN).map(join).collect());
        }
        Self {
            points,
            facets,
            origin,
            levels,
        }
    }

    /// The closest point of the facets for which `wanted` holds, if any is nearer than `limit`.
    pub fn nearest_where(
        &self,
        point: &Vector,
        limit: f64,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<Foot> {
        self.search(point, limit, wanted, &mut None)
    }

    /// The closest point of the surface, if it is nearer than `limit`. `hint` remembers where the
    /// last one was found: for points that are asked for one after another as neighbours lie, the
    /// search starts from there and looks at little else.
    pub fn nearest(&self, point: &Vector, limit: f64, hint: &mut Option<usize>) -> Option<Foot> {
        self.search(point, limit, |_| true, hint)
    }

    /// Where a foot lies.
    pub fn point(&self, foot: &Foot) -> Vector {
        let corners = foot.corners.iter().zip(foot.weights);
        corners.fold([0.0; 3], |sum, (&corner, weight)| {
            add(sum, scale(self.points[corner as usize], weight))
        })
    }

    fn search(
        &self,
        point: &Vector,
        limit: f64,
        wanted: impl Fn(usize) -> bool,
        hint: &mut Option<usize>,
    ) -> Option<Foot> {
        let mut search = Search {
            surface: self,
            points: &self.points,
            point,
            wanted,
            best: None,
            limit: limit * limit,
        };
        if let Some(at) = *hint {
            search.consider(at);
        }
        if !self.facets.is_empty() {
            search.descend(self.levels.len() - 1, 0);
        }
        let (at, foot) = search.best?;
        *hint = Some(at);
        Some(foot)
    }

    /// Whether any part of the surface may be nearer than `limit` to a point of the box.
    pub fn may_reach(&self, block: &Bounds, limit: f64) -> bool {
        self.levels
            .last()
            .and_then(|top| top.first())
            .is_some_and(|bounds| {
                (0..3).all(|i| {
                    bounds.low[i] - limit <= block.high[i] && block.low[i] <= bounds.high[i] + limit
                })
            })
    }
}

struct Search<'a, W> {
    surface: &'a ClosestSurface<'a>,
    points: &'a [Vector],
    point: &'a Vector,
    wanted: W,
    /// Position among the facets, and the foot on it.
    best: Option<(usize, Foot)>,
    limit: f64,
}

impl<W: Fn(usize) -> bool> Search<'_, W> {
    /// Looks at the node's children, nearest box first.
    fn descend(&mut self, level: usize, node: usize) {
        if level == 0 {
            return self.leaf(node);
        }
        let boxes = &self.surface.levels[level - 1];
        let children = FAN * node..(FAN * node + FAN).min(boxes.len());
        let mut order = [(f64::INFINITY, usize::MAX); FAN];
        for (n, child) in children.enumerate() {
            let mut next = (boxes[child].distance_squared(self.point), child);
            for slot in &mut order[..=n] {
                if next.0 < slot.0 {
                    std::mem::swap(slot, &mut next);
                }
            }
        }
        for (distance, child) in order {
            if distance >= self.limit {
                return;
            }
            self.descend(level - 1, child);
        }
    }

    fn leaf(&mut self, node: usize) {
        let n_facets = self.surface.facets.len();
        for at in FAN * node..(FAN * node + FAN).min(n_facets) {
            self.consider(at);
        }
    }

    fn consider(&mut self, at: usize) {
        let facet = self.surface.origin[at] as usize;
        if !(self.wanted)(facet) {
            return;
        }
        let corners = self.surface.facets[at].map(|i| self.points[i as usize]);
        let weights = closest_weights(self.point, &corners);
        let foot = (0..3).fold([0.0; 3], |sum, i| add(sum, scale(corners[i], weights[i])));
        let away = sub(*self.point, foot);
        let distance_squared = dot(away, away);
        if distance_squared < self.limit {
            self.limit = distance_squared;
            let foot = Foot {
                facet,
                corners: self.surface.facets[at],
                weights,
                distance_squared,
            };
            self.best = Some((at, foot));
        }
    }
}

/// Barycentric weights of the point of a triangle closest to `p`. A triangle whose last two corners
/// coincide is an edge.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5: the Voronoi regions of
/// corners and edges are tried in turn.
fn closest_weights(p: &Vector, [a, b, c]: &[Vector; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (sub(*b, *a), sub(*c, *a), sub(*p, *a));
    if b == c {
        let square = dot(ab, ab);
        let t = if square > 0.0 {
            dot(ap, ab) / square
        } else {
            0.0
        };
        let t = t.clamp(0.0, 1.0);
        return [1.0 - t, t, 0.0];
    }
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(*p, *b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = ratio(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = sub(*p, *c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = ratio(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = ratio(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let total = va + vb + vc;
    let (v, w) = (ratio(vb, total), ratio(vc, total));
    [1.0 - v - w, v, w]
}

/// `a / b`, zero for a degenerate facet.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closest point by sampling the triangle finely.
    fn sampled_distance(p: &Vector, corners: &[Vector; 3]) -> f64 {
        let n = 200;
        let mut best = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (v, w) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let x = add(
                    scale(corners[0], 1.0 - v - w),
                    add(scale(corners[1], v), scale(corners[2], w)),
                );
                let away = sub(*p, x);
                best = f64::min(best, dot(away, away));
            }
        }
        best.sqrt()
    }

    #[test]
    fn the_foot_is_the_closest_point_of_all_triangles() {
        let value = |i: usize| ((i as f64) * 12.9898).sin();
        let points: Vec<Vector> = (0..60)
            .map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)])
            .collect();
        let facets: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let surface = ClosestSurface::new(&points, &facets);
        let mut hint = None;
        for q in 0..40 {
            let p = [
                2.0 * value(500 + 3 * q),
                2.0 * value(501 + 3 * q),
                2.0 * value(502 + 3 * q),
            ];
            let brute = facets
                .iter()
                .map(|f| sampled_distance(&p, &f.map(|i| points[i as usize])))
                .fold(f64::INFINITY, f64::min);
            let foot = surface
                .nearest(&p, f64::INFINITY, &mut hint)
                .expect("there is one");
            assert!((foot.distance_squared.sqrt() - brute).abs() < 0.02);
            assert!(foot.distance_squared.sqrt() <= brute + 1e-12);
            assert!(
                surface
                    .nearest(&p, 0.99 * foot.distance_squared.sqrt(), &mut hint)
                    .is_none()
            );
        }
    }

    #[test]
    fn an_edge_of_the_plane_has_its_foot_by_projection() {
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let surface = ClosestSurface::new(&points, &[[0, 1, 1]]);
        let foot = surface
            .nearest(&[0.5, 3.0, 0.0], 10.0, &mut None)
            .expect("it is near");
        assert_eq!(foot.weights, [0.75, 0.25, 0.0]);
        assert_eq!(foot.distance_squared, 9.0);
    }
}
