//! Closest points on a surface of triangles or, in the plane, of edges.

mod components;
mod front;
mod search;

use super::bounds::Bounds;
use super::curve;
use super::facet::{FacetPack, PACK};
use super::oriented::{Group, LANES, OrientedBox};
use super::vector::{Vector, add, scale};
use crate::parallel::{SMALL_BLOCK, block, collect, collect_in_blocks};
use components::{components, owners};
use front::Block;
use search::{Front, Query, Stack, is_leaf_within, search};
use std::borrow::Cow;

/// Facets of a leaf.
const LEAF: usize = PACK;

/// Facets in a tree of oriented boxes, ready for closest-point queries.
#[derive(Debug, Clone)]
pub struct ClosestSurface<'a> {
    points: Cow<'a, [Vector]>,
    /// Corners of each facet, along a space-filling curve. An edge repeats its second.
    facets: Vec<[u32; 3]>,
    /// Position of each facet in the list it was built from.
    origin: Vec<u32>,
    /// The same side by side, 72 bytes a facet.
    leaves: Vec<FacetPack>,
    /// Boxes by level, in groups; the first is of the leaves, and a box of the next holds a group.
    levels: Vec<Vec<Group>>,
    /// The connected surface of each point, called by its lowest point.
    components: Vec<u32>,
    /// The component of each box, by level; empty where there is one alone.
    owners: Vec<Vec<u32>>,
    bounds: Bounds,
}

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
    /// Index of the facet in the list that the surface was built from.
    pub facet: usize,
    /// Corners of the facet.
    pub corners: [u32; 3],
    /// Barycentric weights of the corners.
    pub weights: [f64; 3],
    /// Square of the distance from the asking point.
    pub distance_squared: f64,
}

/// `of` each group of `size` of the parts, in order.
fn of_groups<P: Sync, T: Copy + Default + Send>(
    parts: &[P],
    size: usize,
    of: impl Fn(&[P]) -> T + Sync,
) -> Vec<T> {
    let n = parts.len();
    collect_in_blocks(n.div_ceil(size), SMALL_BLOCK, |i| {
        of(&parts[block(n, size, i)])
    })
}

impl<'a> ClosestSurface<'a> {
    /// Builds the tree over borrowed or owned points. `O(n log n)`.
    pub fn new(points: impl Into<Cow<'a, [Vector]>>, facets: &[[u32; 3]]) -> Self {
        let points = points.into();
        let place = |i: u32| points[i as usize];
        let centres = collect(facets.len(), |i| {
            let [a, b, c] = facets[i];
            let [a, b, c] = [place(a), place(b), place(c)];
            scale(add(add(a, b), c), 1.0 / 3.0)
        });
        let origin = curve::order(&centres);
        drop(centres);
        let facets = collect(origin.len(), |at| facets[origin[at] as usize]);
        let around = |leaf: &[[u32; 3]]| {
            let corners: Vec<Vector> = leaf.iter().flatten().map(|&i| place(i)).collect();
            OrientedBox::around(&corners)
        };
        let mut boxes = of_groups(&facets, LEAF, around);
        let mut levels = Vec::new();
        while !boxes.is_empty() {
            levels.push(of_groups(&boxes, LANES, Group::new));
            if boxes.len() <= LANES {
                break;
            }
            boxes = of_groups(&boxes, LANES, OrientedBox::joined);
        }
        let leaves = of_groups(&facets, LEAF, |leaf| FacetPack::new(leaf, &points));
        let components = components(points.len(), &facets);
        let owners = owners(&facets, &components);
        let bounds = Bounds::around(facets.iter().flatten().map(|&i| &points[i as usize]));
        Self {
            bounds,
            points,
            facets,
            origin,
            leaves,
            levels,
            components,
            owners,
        }
    }

    /// The closest point of the surface, if it is nearer than `limit`; of facets that are equally
    /// near the first.
    pub fn nearest(&self, point: &Vector, limit: f64) -> Option<ClosestPoint> {
        let query = self.query(point, None);
        let found = search(&query, &self.root(), limit, None, &mut Stack::new());
        found.map(|(_, foot)| foot)
    }

    /// The closest point of the facets that are not connected with the surface point `node`, if it
    /// is nearer to that than `limit`.
    pub fn nearest_apart(&self, node: usize, limit: f64) -> Option<ClosestPoint> {
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
    pub fn nearest_each(
        &self,
        points: &[Vector],
        limit: f64,
        found: &mut dyn FnMut(usize, &ClosestPoint),
    ) {
        if points.is_empty() || self.levels.is_empty() {
            return;
        }
        Block::new(self, limit, found).visit(points, 0, &self.root());
    }

    /// Gives the place of a foot.
    pub fn point(&self, foot: &ClosestPoint) -> Vector {
        let corners = foot.corners.iter().zip(foot.weights);
        corners.fold([0.0; 3], |sum, (&corner, weight)| {
            add(sum, scale(self.points[corner as usize], weight))
        })
    }

    /// The box around the surface.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Checks if the surface may be within `limit` of a point of the box. It compares boxes around facets, not the facets: no
    /// is certain, yes is not.
    pub fn may_be_within(&self, limit: f64, block: &Bounds) -> bool {
        is_leaf_within(self, limit * limit, block)
    }

    fn query<'q>(&'q self, point: &'q Vector, apart: Option<u32>) -> Query<'q> {
        Query {
            surface: self,
            point,
            apart,
        }
    }

    /// The number of boxes in the groups of a level. A distance alone does not distinguish an empty place of a group from a box,
    /// where squares of coordinates overflow.
    #[inline(always)]
    fn n_boxes(&self, level: usize) -> usize {
        match level {
            0 => self.leaves.len(),
            _ => self.levels[level - 1].len(),
        }
    }

    fn root(&self) -> Front {
        Front {
            level: self.levels.len().saturating_sub(1),
            groups: if self.levels.is_empty() {
                Vec::new()
            } else {
                vec![0]
            },
        }
    }
}

#[cfg(test)]
mod tests;
