//! Closest points on a surface of triangles or, in the plane, of edges.

use super::bounds::Bounds;
use super::curve;
use super::facet::closest_weights;
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

#[cfg(test)]
mod tests;
