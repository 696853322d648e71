//! Closest points on a surface of triangles or, in the plane, of edges.

use super::bounds::Bounds;
use super::curve;
use super::oriented::{Group, LANES, OrientedBox};
use super::vector::{Vector, add, dot, scale, sub};
use multiversion::multiversion;
use rayon::prelude::*;
use std::borrow::Cow;

/// Facets of a leaf.
const LEAF: usize = 4;
/// Points that are asked for from one front; longer lists are cut into `PARTS`.
const TOGETHER: usize = 16;
const PARTS: usize = 4;
/// Most groups that a front is walked down to.
const MOST_GROUPS: usize = 24;
/// Boxes that wait in a search: those of a front, and three for each of at most 16 levels.
const DEPTH: usize = MOST_GROUPS * LANES + 48;
/// The component of a tree node that holds facets of several.
const MIXED: u32 = u32::MAX;

/// Facets in a tree of oriented boxes, ready for closest-point queries.
#[derive(Debug, Clone)]
pub struct ClosestSurface<'a> {
    points: Cow<'a, [Vector]>,
    /// Corners of each facet, along a space-filling curve. An edge repeats its second.
    facets: Vec<[u32; 3]>,
    /// Position of each facet in the list it was built from.
    origin: Vec<u32>,
    /// Boxes by level, in groups; the first is of the leaves, and a box of the next holds a group.
    levels: Vec<Vec<Group>>,
    /// The connected surface of each point, called by its lowest point.
    components: Vec<u32>,
    /// The component of each box, by level; empty where there is one alone.
    owners: Vec<Vec<u32>>,
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
        let place = |i: u32| points[i as usize];
        let centre = |facet: &[u32; 3]| {
            let [a, b, c] = facet.map(place);
            scale(add(add(a, b), c), 1.0 / 3.0)
        };
        let centres: Vec<Vector> = facets.par_iter().map(centre).collect();
        let origin = curve::order(&centres);
        drop(centres);
        let facets: Vec<[u32; 3]> = origin.par_iter().map(|&i| facets[i as usize]).collect();
        let around = |leaf: &[[u32; 3]]| {
            let corners: Vec<Vector> = leaf.iter().flatten().map(|&i| place(i)).collect();
            OrientedBox::around(&corners)
        };
        let mut boxes: Vec<OrientedBox> = facets.par_chunks(LEAF).map(around).collect();
        let mut levels = Vec::new();
        while !boxes.is_empty() {
            levels.push(boxes.par_chunks(LANES).map(Group::new).collect());
            if boxes.len() <= LANES {
                break;
            }
            boxes = boxes.par_chunks(LANES).map(OrientedBox::joined).collect();
        }
        let components = components(points.len(), &facets);
        let owners = owners(&facets, &components);
        Self {
            points,
            facets,
            origin,
            levels,
            components,
            owners,
        }
    }

    /// The closest point of the surface, if it is nearer than `limit`; of facets that are equally
    /// near the first.
    pub fn nearest(&self, point: &Vector, limit: f64) -> Option<Foot> {
        let query = self.query(point, None);
        let found = search(&query, &self.root(), limit, None, &mut Stack::new());
        found.map(|(_, foot)| foot)
    }

    /// The closest point of the facets that are not connected with the surface point `node`, if it
    /// is nearer to that than `limit`.
    pub fn nearest_apart(&self, node: usize, limit: f64) -> Option<Foot> {
        if self.owners.is_empty() {
            return None;
        }
        let query = self.query(&self.points[node], Some(self.components[node]));
        let found = search(&query, &self.root(), limit, None, &mut Stack::new());
        found.map(|(_, foot)| foot)
    }

    /// Calls `found(i, foot)` for each of `points` that the surface is nearer to than `limit`, as
    /// [`nearest`](Self::nearest) finds it. Where neighbours in the list are neighbours in space the
    /// tree is walked down once for many, and a search looks at little more than one leaf.
    pub fn nearest_each(&self, points: &[Vector], limit: f64, found: &mut dyn FnMut(usize, &Foot)) {
        if points.is_empty() || self.levels.is_empty() {
            return;
        }
        let mut block = Block {
            surface: self,
            limit,
            hint: None,
            waiting: Stack::new(),
            found,
        };
        block.visit(points, 0, &self.root());
    }

    /// Where a foot lies.
    pub fn point(&self, foot: &Foot) -> Vector {
        let corners = foot.corners.iter().zip(foot.weights);
        corners.fold([0.0; 3], |sum, (&corner, weight)| {
            add(sum, scale(self.points[corner as usize], weight))
        })
    }

    /// The box around the surface.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(
            self.facets
                .iter()
                .flatten()
                .map(|&i| &self.points[i as usize]),
        )
    }

    fn query<'q>(&'q self, point: &'q Vector, apart: Option<u32>) -> Query<'q> {
        Query {
            surface: self,
            points: &self.points,
            point,
            apart,
        }
    }

    fn root(&self) -> Front {
        Front {
            level: self.levels.len().saturating_sub(1),
            groups: match self.levels.is_empty() {
                true => Vec::new(),
                false => vec![0],
            },
        }
    }
}

/// Groups of one level that hold all that may be closest to some point.
#[derive(Debug, Clone)]
struct Front {
    level: usize,
    groups: Vec<u32>,
}

/// Neighbouring points that are asked for together.
struct Block<'a> {
    surface: &'a ClosestSurface<'a>,
    limit: f64,
    /// Where the last foot was found: the next search starts from there.
    hint: Option<usize>,
    /// Room for the searches.
    waiting: Stack,
    found: &'a mut dyn FnMut(usize, &Foot),
}

impl Block<'_> {
    /// Narrows the front to what may be closest to one of `points`, and asks for parts of them or,
    /// in the end, for each.
    fn visit(&mut self, points: &[Vector], first: usize, front: &Front) {
        let bounds = Bounds::around(points);
        let limit = self.limit_of(points, front);
        let front = narrowed(self.surface, front, &bounds, limit * limit);
        if front.groups.is_empty() {
            return;
        }
        if points.len() <= TOGETHER {
            for (i, point) in points.iter().enumerate() {
                let found = self.search(&front, point);
                if let Some((at, foot)) = found {
                    self.hint = Some(at);
                    (self.found)(first + i, &foot);
                }
            }
            return;
        }
        let part = points.len().div_ceil(PARTS).max(TOGETHER);
        for (i, points) in points.chunks(part).enumerate() {
            self.visit(points, first + i * part, &front);
        }
    }

    /// No point has its foot beyond this: the triangle inequality by way of one of them.
    fn limit_of(&mut self, points: &[Vector], front: &Front) -> f64 {
        let middle = &points[points.len() / 2];
        let Some((_, foot)) = self.search(front, middle) else {
            return self.limit;
        };
        let from_middle = |p: &Vector| dot(sub(*p, *middle), sub(*p, *middle));
        let spread = points.iter().map(from_middle).fold(0.0, f64::max);
        let limit = foot.distance_squared.sqrt() + spread.sqrt();
        self.limit.min(limit * (1.0 + 1e-12))
    }

    fn search(&mut self, front: &Front, point: &Vector) -> Option<(usize, Foot)> {
        let query = self.surface.query(point, None);
        search(&query, front, self.limit, self.hint, &mut self.waiting)
    }
}

/// The part of the front that may be nearer to the block than `limit`, squared, walked down while
/// it stays small.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn narrowed(surface: &ClosestSurface<'_>, front: &Front, block: &Bounds, limit: f64) -> Front {
    let mut front = front.clone();
    loop {
        let level = &surface.levels[front.level];
        let mut children = Vec::new();
        let mut groups = Vec::with_capacity(front.groups.len());
        for &group in &front.groups {
            let before = children.len();
            let distances = level[group as usize].distances_to(block);
            for lane in 0..LANES {
                if distances[lane] <= limit && distances[lane] < f64::INFINITY {
                    children.push((LANES * group as usize + lane) as u32);
                }
            }
            if children.len() > before {
                groups.push(group);
            }
        }
        front.groups = groups;
        if front.level == 0 || children.is_empty() || children.len() > MOST_GROUPS {
            return front;
        }
        front = Front {
            level: front.level - 1,
            groups: children,
        };
    }
}

/// A box that waits in a search; at level 0 that of a leaf.
#[derive(Clone, Copy)]
struct Waiting {
    distance_squared: f64,
    level: u32,
    node: u32,
}

/// The nearest boxes first, from those of a front and facet `hint` where there is one.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn search(
    query: &Query<'_>,
    front: &Front,
    limit: f64,
    hint: Option<usize>,
    waiting: &mut Stack,
) -> Option<(usize, Foot)> {
    let surface = query.surface;
    let mut best = Best {
        limit: limit * limit,
        found: None,
    };
    if let Some(at) = hint {
        best.consider(query, at);
    }
    waiting.n = 0;
    for &group in &front.groups {
        waiting.open(query, front.level, group as usize, best.limit, 0);
    }
    while let Some(next) = waiting.pop() {
        if next.distance_squared > best.limit {
            continue;
        }
        let (level, node) = (next.level as usize, next.node as usize);
        if level > 0 {
            let first = waiting.n;
            waiting.open(query, level - 1, node, best.limit, first);
            continue;
        }
        let end = (LEAF * node + LEAF).min(surface.facets.len());
        for at in LEAF * node..end {
            let owner = || surface.components[surface.facets[at][0] as usize];
            if query.apart.is_none_or(|own| owner() != own) {
                best.consider(query, at);
            }
        }
    }
    best.found
}

/// What a search is for.
struct Query<'a> {
    surface: &'a ClosestSurface<'a>,
    /// Those of the surface.
    points: &'a [Vector],
    point: &'a Vector,
    /// The component that is left out.
    apart: Option<u32>,
}

/// The boxes that wait in a search.
struct Stack {
    boxes: [Waiting; DEPTH],
    n: usize,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        let boxes = [Waiting {
            distance_squared: 0.0,
            level: 0,
            node: 0,
        }; DEPTH];
        Self { boxes, n: 0 }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Waiting> {
        self.n = self.n.checked_sub(1)?;
        Some(self.boxes[self.n])
    }

    /// Adds the boxes of a group that may be near enough; those from `first` on stay in order, the
    /// nearest last.
    #[inline(always)]
    fn open(&mut self, query: &Query<'_>, level: usize, group: usize, limit: f64, first: usize) {
        let surface = query.surface;
        let distances = surface.levels[level][group].distances_squared(query.point);
        for lane in 0..LANES {
            let distance_squared = distances[lane];
            if distance_squared > limit || distance_squared == f64::INFINITY {
                continue;
            }
            let node = LANES * group + lane;
            if query
                .apart
                .is_some_and(|own| surface.owners[level][node] == own)
            {
                continue;
            }
            let mut at = self.n;
            while at > first && self.boxes[at - 1].distance_squared < distance_squared {
                self.boxes[at] = self.boxes[at - 1];
                at -= 1;
            }
            self.boxes[at] = Waiting {
                distance_squared,
                level: level as u32,
                node: node as u32,
            };
            self.n += 1;
        }
    }
}

/// What is found so far: position among the facets, and the foot on it.
struct Best {
    limit: f64,
    found: Option<(usize, Foot)>,
}

impl Best {
    #[inline(always)]
    fn consider(&mut self, query: &Query<'_>, at: usize) {
        let surface = query.surface;
        let corners = surface.facets[at];
        let [a, b, c] = corners.map(|i| sub(query.points[i as usize], *query.point));
        let weights = closest_weights(&[a, b, c]);
        let away = add(
            add(scale(a, weights[0]), scale(b, weights[1])),
            scale(c, weights[2]),
        );
        let distance_squared = dot(away, away);
        if distance_squared > self.limit {
            return;
        }
        let facet = surface.origin[at] as usize;
        let first = |(_, found): &(usize, Foot)| facet < found.facet;
        if distance_squared == self.limit && !self.found.as_ref().is_some_and(first) {
            return;
        }
        self.limit = distance_squared;
        let foot = Foot {
            facet,
            corners,
            weights,
            distance_squared,
        };
        self.found = Some((at, foot));
    }
}

/// The connected surface of each point, called by its lowest point.
fn components(n_points: usize, facets: &[[u32; 3]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..n_points as u32).collect();
    fn root(parent: &mut [u32], mut node: u32) -> u32 {
        while parent[node as usize] != node {
            parent[node as usize] = parent[parent[node as usize] as usize];
            node = parent[node as usize];
        }
        node
    }
    for [a, b, c] in facets {
        for (a, b) in [(*a, *b), (*b, *c)] {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    // A parent lies below its children, so one pass upward finds every root.
    for node in 0..n_points {
        parent[node] = parent[parent[node] as usize];
    }
    parent
}

/// The component of each box, by level; empty where all facets are of one.
fn owners(facets: &[[u32; 3]], components: &[u32]) -> Vec<Vec<u32>> {
    let of_facet = |facet: &[u32; 3]| components[facet[0] as usize];
    let join = |a: u32, b: u32| if a == b { a } else { MIXED };
    let leaf = |leaf: &[[u32; 3]]| leaf.iter().map(of_facet).reduce(join).unwrap_or(MIXED);
    let mut levels: Vec<Vec<u32>> = vec![facets.par_chunks(LEAF).map(leaf).collect()];
    while levels[levels.len() - 1].len() > LANES {
        let below = levels[levels.len() - 1].chunks(LANES);
        let group = |group: &[u32]| group.iter().copied().reduce(join).unwrap_or(MIXED);
        levels.push(below.map(group).collect());
    }
    let top = levels[levels.len() - 1].iter().copied().reduce(join);
    match top {
        Some(MIXED) => levels,
        _ => Vec::new(),
    }
}

/// Barycentric weights of the point of a triangle closest to the origin. A triangle whose last two
/// corners coincide is an edge.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5: the Voronoi regions of
/// corners and edges are tried in turn.
#[inline(always)]
fn closest_weights([a, b, c]: &[Vector; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (sub(*b, *a), sub(*c, *a), scale(*a, -1.0));
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
    let bp = scale(*b, -1.0);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = ratio(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = scale(*c, -1.0);
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
        let surface = ClosestSurface::new(&points[..], &facets);
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
            let foot = surface.nearest(&p, f64::INFINITY).expect("there is one");
            assert!((foot.distance_squared.sqrt() - brute).abs() < 0.02);
            assert!(foot.distance_squared.sqrt() <= brute + 1e-12);
            assert!(
                surface
                    .nearest(&p, 0.99 * foot.distance_squared.sqrt())
                    .is_none()
            );
        }
    }

    #[test]
    fn an_edge_of_the_plane_has_its_foot_by_projection() {
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let surface = ClosestSurface::new(&points[..], &[[0, 1, 1]]);
        let foot = surface.nearest(&[0.5, 3.0, 0.0], 10.0).expect("it is near");
        assert_eq!(foot.weights, [0.75, 0.25, 0.0]);
        assert_eq!(foot.distance_squared, 9.0);
    }

    /// The nearest facet by asking each, ties to the first.
    fn brute(points: &[Vector], facets: &[[u32; 3]], p: &Vector) -> (f64, usize) {
        let mut best = (f64::INFINITY, usize::MAX);
        for (facet, corners) in facets.iter().enumerate() {
            let corners = corners.map(|i| sub(points[i as usize], *p));
            let w = closest_weights(&corners);
            let away = add(
                add(scale(corners[0], w[0]), scale(corners[1], w[1])),
                scale(corners[2], w[2]),
            );
            if dot(away, away) < best.0 {
                best = (dot(away, away), facet);
            }
        }
        best
    }

    #[test]
    fn a_search_in_blocks_finds_what_asking_every_facet_finds() {
        let n = 14;
        let shapes: [fn(f64, f64) -> Vector; 4] = [
            |s, t| [s, t, 0.0],
            |s, t| [s + 5.0, 0.6 * t - 0.3 * s, 0.8 * t],
            |s, t| [s, 0.05 * t, 0.3 * (3.0 * s).sin()],
            |s, _| [s, 0.0, 0.0],
        ];
        for shape in shapes {
            let at = |k: usize| shape((k % n) as f64 / 9.0, (k / n) as f64 / 9.0);
            let mut points: Vec<Vector> = (0..n * n).map(at).collect();
            let below = points.iter().map(|p| [p[0], p[1], p[2] - 1e-4]);
            points.extend(below.collect::<Vec<_>>());
            let mut facets = Vec::new();
            for k in (0..2 * n * n).filter(|k| k % n < n - 1 && k % (n * n) < n * (n - 1)) {
                let [a, b, c, d] = [k, k + 1, k + n + 1, k + n].map(|i| i as u32);
                facets.extend([[a, b, c], [a, c, d], [a, b, b]]);
            }
            let surface = ClosestSurface::new(&points[..], &facets);
            let asked: Vec<Vector> = (0..400)
                .map(|i| {
                    let [x, y, z] = points[(i * 7) % points.len()];
                    [x, y + 1e-3 * (i % 3) as f64, z + 0.02 * (i as f64).sin()]
                })
                .collect();
            let mut found = vec![None; asked.len()];
            surface.nearest_each(&asked, 0.015, &mut |i, foot| found[i] = Some(*foot));
            for (p, foot) in asked.iter().zip(found) {
                let (square, facet) = brute(&points, &facets, p);
                let expected = (square < 0.015 * 0.015).then_some((square, facet));
                assert_eq!(
                    foot.map(|foot| (foot.distance_squared, foot.facet)),
                    expected
                );
            }
        }
    }
}
