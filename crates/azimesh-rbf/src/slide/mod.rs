//! Sliding surfaces: the constraint of every sliding point, and its projection.
//!
//! The surface is cut into smooth patches. A point inside a patch keeps to it, a point where two
//! patches or two tags meet keeps to their common edge, a point where such edges end or turn by more
//! than 20 degrees stays. On planes and straight edges between planes that is a linear condition,
//! kept exactly; elsewhere points are projected to the original surface or edge.
//!
//! `constrained` and `select` apply the constraints in the interpolation.

mod patches;
mod rims;
mod shape;

use super::constraint::Constraint;
use super::images::Images;
use azimesh_core::geometry::vector::{Vector, cross, distance, dot, norm, scale, sub, unit};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_core::parallel::{self, SMALL_BLOCK};
use patches::{Patches, SHARP, Sector, UnionFind};
pub use shape::{CurvedFace, FaceMap};
use shape::{FacePiece, Polynomial, Shape};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Directions of creases closer than this cosine are one crease.
const ONE_WAY: f64 = 0.999;
/// An edge is straight while its points leave its line by this part of its length at most.
const STRAIGHT: f64 = 1e-6;
/// Not a sliding point.
const NONE: u32 = u32::MAX;

/// The facets of sliding boundaries.
#[derive(Debug, Clone, Default)]
pub struct SlidingFacets {
    /// Triangles; in the plane edges, with the second corner repeated.
    pub corners: Vec<[u32; 3]>,
    /// A number for the tag of each.
    pub tags: Vec<u32>,
    /// The curved face that each is a part of, or `u32::MAX`.
    pub faces: Vec<u32>,
    /// Curved faces.
    pub curved: Vec<CurvedFace>,
}

impl SlidingFacets {
    /// Facets of flat faces.
    pub fn flat(corners: Vec<[u32; 3]>, tags: Vec<u32>) -> Self {
        Self {
            faces: vec![NONE; corners.len()],
            corners,
            tags,
            curved: Vec::new(),
        }
    }
}

/// The sliding points of a surface.
#[derive(Debug, Clone)]
pub struct Sliding {
    /// For each surface point its position in `points`.
    index: Vec<u32>,
    points: Vec<SlidingPoint>,
    /// Curved patches and edges to project to.
    shapes: Vec<Shape>,
    /// The maps of the images of continued shapes, with their inverses.
    images: Vec<(Transform, Transform)>,
    #[cfg(test)]
    n_patches: usize,
    /// Points of planar patches that do not slide themselves, with the normals of the planes.
    rims: Vec<(u32, Vector)>,
    /// True if all of it is in a plane mesh.
    in_plane: bool,
}

#[derive(Debug, Clone, Copy)]
struct SlidingPoint {
    reference: Vector,
    constraint: Constraint,
    path: Path,
}

/// Constraint of a sliding point.
#[derive(Debug, Clone, Copy)]
enum Path {
    /// Its constraint alone.
    Plane,
    /// A curved patch, or an edge that is curved or has a curved side; then the planes of the edge.
    Shape { shape: u32, planes: Constraint },
}

/// A path before the shapes are built.
enum Track {
    Plane(Constraint),
    Patch(u32, Vector),
    Edge(Edge),
}

/// A point within an edge between patches.
struct Edge {
    tangent: Vector,
    ends: Vec<u32>,
    sectors: Vec<Sector>,
}

impl Sliding {
    /// Finds the sliding points among `points`, for which `sliding` holds. A sliding point without a facet of positive area
    /// stays at rest. Periodic `images` continue the surface.
    ///
    /// `O(n log n)` for n facets.
    pub fn new(
        points: &[Vector],
        facets: &SlidingFacets,
        sliding: &[bool],
        images: &Images,
    ) -> Self {
        let continued = images.around(points, &facets.corners);
        let patches = Patches::new(&continued, &facets.tags);
        let points = &*continued.points;
        let nodes: Vec<u32> = (0..sliding.len() as u32)
            .filter(|&i| sliding[i as usize])
            .collect();
        let tracks = parallel::concat_blocks(nodes.len(), SMALL_BLOCK, &|range| {
            let nodes = nodes[range].iter();
            nodes.map(|&i| track(&patches, points, i)).collect()
        });
        let mut build = Build {
            points,
            patches: &patches,
            facets: patches.by_patch(),
            given: facets,
            polynomials: BTreeMap::new(),
            curves: Curves::new(points, &nodes, &tracks, images, sliding.len()),
            shapes: Vec::new(),
            shape_of_patch: BTreeMap::new(),
            shape_of_curve: BTreeMap::new(),
        };
        let mut index = vec![NONE; sliding.len()];
        let mut sliding_points = Vec::with_capacity(nodes.len());
        for (&node, track) in nodes.iter().zip(tracks) {
            index[node as usize] = sliding_points.len() as u32;
            let (constraint, path) = build.path(node, track);
            sliding_points.push(SlidingPoint {
                reference: points[node as usize],
                constraint,
                path,
            });
        }
        Self {
            index,
            points: sliding_points,
            shapes: build.shapes,
            images: images
                .maps
                .iter()
                .map(|map| (*map, map.inverse()))
                .collect(),
            #[cfg(test)]
            n_patches: patches.planes.len(),
            rims: patches.rims(sliding),
            in_plane: patches.in_plane,
        }
    }

    /// The directions in which a surface point is held; all of them for one that does not slide.
    pub fn constraint(&self, point: usize) -> Constraint {
        self.get(point)
            .map_or(Constraint::ALL, |point| point.constraint)
    }

    /// Returns the directions in which the rotation vector of a surface point is held: a point that slides on a plane may turn
    /// about the normal. In a plane mesh, which only turns about the third axis, always all.
    pub fn rotation_constraint(&self, point: usize) -> Constraint {
        match self.get(point) {
            Some(point) if !self.in_plane && matches!(point.path, Path::Plane) => {
                point.constraint.of_rotation()
            }
            _ => Constraint::ALL,
        }
    }

    /// Projects a sliding point that the interpolation has put at `x`. On planes and straight edges
    /// its coordinates along an axis that is a normal equal the reference to the last bit; a
    /// point that has not moved stays so. A point that does not slide goes to `x`.
    pub fn place(&self, point: usize, x: Vector) -> Vector {
        let Some(point) = self.get(point) else {
            return x;
        };
        match point.path {
            Path::Plane => point.constraint.hold(point.reference, x),
            _ if x == point.reference => x,
            Path::Shape { shape, planes } => {
                // The reference is on the shape, so the nearest point is not farther.
                let within = 1.001 * distance(x, point.reference);
                let on_shape = self.nearest(&self.shapes[shape as usize], x, within);
                planes.hold(point.reference, on_shape.unwrap_or(point.reference))
            }
        }
    }

    /// The nearest point of a shape with its images.
    fn nearest(&self, shape: &Shape, x: Vector, within: f64) -> Option<Vector> {
        let own = shape.nearest(&x, within);
        let images = self.images.iter().filter(|_| shape.is_continued);
        let of_images = images.filter_map(|(map, back)| {
            let (distance, foot) = shape.nearest(&back.apply(x), within)?;
            Some((distance, map.apply(foot)))
        });
        let all = own.into_iter().chain(of_images);
        all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    }

    /// Returns whether points must be projected at every step, since a sliding surface or edge is curved.
    pub fn has_curved(&self) -> bool {
        !self.shapes.is_empty()
    }

    /// Returns whether a point slides and its constraint is sufficient: on planes and straight edges.
    pub fn is_linear(&self, point: usize) -> bool {
        let point = self.get(point);
        point.is_some_and(|point| matches!(point.path, Path::Plane))
    }

    /// The first sliding point that keeps to a curved surface or edge.
    pub fn first_curved(&self) -> Option<usize> {
        let curved = |at: &u32| {
            let point = self.points.get(*at as usize);
            point.is_some_and(|point| matches!(point.path, Path::Shape { .. }))
        };
        self.index.iter().position(curved)
    }

    /// Points of planar patches that do not slide themselves, with the normals of the planes.
    pub fn rims(&self) -> &[(u32, Vector)] {
        &self.rims
    }

    /// Number of smooth patches of the sliding surfaces.
    #[cfg(test)]
    pub fn n_patches(&self) -> usize {
        self.n_patches
    }

    fn get(&self, point: usize) -> Option<&SlidingPoint> {
        match self.index[point] {
            NONE => None,
            at => Some(&self.points[at as usize]),
        }
    }
}

/// Constraint of a point, from the patches and creases that meet there.
fn track(patches: &Patches, points: &[Vector], point: u32) -> Track {
    let sectors = patches.sectors(point);
    let (ends, ways) = crease_ways(patches, points, point);
    let plane_of = |sector: &Sector| patches.planes[sector.patch as usize];
    let planes: Vec<Vector> = sectors.iter().filter_map(plane_of).collect();
    match (&sectors[..], &ways[..]) {
        ([], _) => Track::Plane(Constraint::ALL),
        ([one], _) => match planes.first() {
            Some(plane) => Track::Plane(Constraint::of_normals(&[*plane])),
            None => Track::Patch(patches.whole[one.patch as usize], one.normal),
        },
        (_, []) if !patches.in_plane && planes.len() == sectors.len() => {
            Track::Plane(Constraint::of_normals(&planes))
        }
        (_, &[way]) => Track::Edge(Edge {
            tangent: way,
            ends,
            sectors,
        }),
        (_, &[a, b]) if -dot(a, b) > SHARP => Track::Edge(Edge {
            tangent: unit(sub(a, b)).expect("the two are nearly opposite"),
            ends,
            sectors,
        }),
        _ => Track::Plane(Constraint::ALL),
    }
}

/// The creases at a point: their other ends and distinct directions.
fn crease_ways(patches: &Patches, points: &[Vector], point: u32) -> (Vec<u32>, Vec<Vector>) {
    let mut ways: Vec<Vector> = Vec::new();
    let ends = patches.creases(point);
    for &end in &ends {
        let way = unit(sub(points[end as usize], points[point as usize]));
        let way = way.filter(|way| ways.iter().all(|other| dot(*way, *other) < ONE_WAY));
        ways.extend(way);
    }
    (ends, ways)
}

/// The curves that edges make, end to end.
struct Curves {
    /// Edges as facets, with the curve of each; by curve.
    edges: Vec<(u32, [u32; 3])>,
    /// The curve of each point within one.
    of_point: BTreeMap<u32, u32>,
    /// Direction of each curve that is straight.
    straight: BTreeMap<u32, Vector>,
    /// Curves that images continue.
    continued: BTreeSet<u32>,
}

impl Curves {
    /// Two edges form one curve when a sliding point is within it where they meet, and where an image continues one by the other.
    fn new(
        points: &[Vector],
        nodes: &[u32],
        tracks: &[Track],
        images: &Images,
        n_own: usize,
    ) -> Self {
        let is_image = |point: u32| point as usize >= n_own;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        let mut within = vec![false; points.len()];
        let mut through = Vec::new();
        for (&node, track) in nodes.iter().zip(tracks) {
            if let Track::Edge(edge) = track {
                within[node as usize] = true;
                if edge.ends.iter().any(|&end| is_image(end)) {
                    through.push(node);
                }
                pairs.extend(edge.ends.iter().map(|&e| (e.min(node), e.max(node))));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut curve = UnionFind::new(points.len());
        for &(a, b) in &pairs {
            if within[a as usize] && within[b as usize] {
                curve.join(a, b);
            }
        }
        for &node in &through {
            curve.join(node, images.leaders[node as usize]);
        }
        let inner = |(a, b): (u32, u32)| if within[a as usize] { a } else { b };
        let mut edges: Vec<(u32, [u32; 3])> = pairs
            .iter()
            .map(|&(a, b)| (curve.root(inner((a, b))), [a, b, b]))
            .collect();
        edges.sort_unstable();
        let inner = nodes.iter().filter(|&&node| within[node as usize]);
        let straight = edges
            .chunk_by(|a, b| a.0 == b.0)
            .filter_map(|edges| Some((edges[0].0, line(points, edges)?)));
        let straight = straight.collect();
        edges.retain(|(_, edge)| !edge.iter().any(|&end| is_image(end)));
        Self {
            of_point: inner.map(|&node| (node, curve.root(node))).collect(),
            continued: through.iter().map(|&node| curve.root(node)).collect(),
            straight,
            edges,
        }
    }
}

/// The facets of one patch or curve, of a list by patch or curve.
fn facets_of(sorted: &[(u32, [u32; 3])], of: u32) -> Vec<[u32; 3]> {
    let first = sorted.partition_point(|entry| entry.0 < of);
    let end = sorted.partition_point(|entry| entry.0 <= of);
    sorted[first..end].iter().map(|entry| entry.1).collect()
}

/// The direction of the common line of these edges, if there is one; components along which it does
/// not extend are zero.
fn line(points: &[Vector], edges: &[(u32, [u32; 3])]) -> Option<Vector> {
    let places = || {
        edges
            .iter()
            .flat_map(|(_, [a, b, _])| [a, b])
            .map(|&i| points[i as usize])
    };
    let origin = points[edges[0].1[0] as usize];
    let from_origin = places().map(|x| sub(x, origin));
    let farthest = from_origin.fold([0.0; 3], |far, v| if norm(v) > norm(far) { v } else { far });
    let direction = unit(farthest)?;
    let tolerance = STRAIGHT * norm(farthest);
    let on_line = places().all(|x| norm(cross(direction, sub(x, origin))) <= tolerance);
    if !on_line {
        return None;
    }
    let bounds = Bounds::around(&places().collect::<Vec<_>>());
    let extends = |k: usize| bounds.high[k] - bounds.low[k] > tolerance;
    unit(std::array::from_fn(|k| {
        if extends(k) { direction[k] } else { 0.0 }
    }))
}

/// Turns tracks into paths, and builds the shapes these need.
struct Build<'a> {
    points: &'a [Vector],
    patches: &'a Patches,
    /// Facets with the patch of each, by patch.
    facets: Vec<(u32, [u32; 3])>,
    given: &'a SlidingFacets,
    /// Curved faces at their positions.
    polynomials: BTreeMap<u32, Arc<Polynomial>>,
    curves: Curves,
    shapes: Vec<Shape>,
    shape_of_patch: BTreeMap<u32, u32>,
    shape_of_curve: BTreeMap<u32, u32>,
}

impl Build<'_> {
    fn path(&mut self, node: u32, track: Track) -> (Constraint, Path) {
        match track {
            Track::Plane(constraint) => (constraint, Path::Plane),
            Track::Patch(patch, normal) => {
                let shape = self.patch(patch);
                let planes = Constraint::of_normals(&[]);
                let path = Path::Shape { shape, planes };
                (Constraint::of_normals(&[normal]), path)
            }
            Track::Edge(edge) => self.edge(node, &edge),
        }
    }

    fn edge(&mut self, node: u32, edge: &Edge) -> (Constraint, Path) {
        let curve = self.curves.of_point[&node];
        let sectors = edge.sectors.iter();
        let normals: Vec<Vector> = sectors
            .filter_map(|sector| self.patches.planes[sector.patch as usize])
            .collect();
        let planes = Constraint::of_normals(&normals);
        if planes.rank() > 1 {
            return (planes, Path::Plane);
        }
        let straight = self.curves.straight.get(&curve);
        if let Some(&line) = straight.filter(|_| normals.len() == edge.sectors.len()) {
            return (across(&planes, line), Path::Plane);
        }
        let shape = self.curve(curve);
        let path = Path::Shape { shape, planes };
        (across(&planes, edge.tangent), path)
    }

    fn patch(&mut self, patch: u32) -> u32 {
        if let Some(&known) = self.shape_of_patch.get(&patch) {
            return known;
        }
        let facets = facets_of(&self.facets, patch);
        let made = self.shape(facets, self.patches.continued[patch as usize]);
        self.shape_of_patch.insert(patch, made);
        made
    }

    fn curve(&mut self, curve: u32) -> u32 {
        if let Some(&known) = self.shape_of_curve.get(&curve) {
            return known;
        }
        let edges = facets_of(&self.curves.edges, curve);
        let made = self.shape(edges, self.curves.continued.contains(&curve));
        self.shape_of_curve.insert(curve, made);
        made
    }

    /// Makes a shape of these facets with their own points; returns its index.
    fn shape(&mut self, mut facets: Vec<[u32; 3]>, is_continued: bool) -> u32 {
        let faces: Vec<u32> = facets.iter().map(|facet| self.face(facet)).collect();
        let mut pieces = Vec::new();
        if faces.iter().any(|&face| face != NONE) {
            let with_face = facets.iter().zip(&faces);
            pieces = with_face
                .map(|(facet, &face)| self.piece(facet, face))
                .collect();
        }
        let mut used: Vec<u32> = facets.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        for corner in facets.iter_mut().flatten() {
            *corner = used.binary_search(corner).expect("it is used") as u32;
        }
        let own: Vec<Vector> = used.iter().map(|&i| self.points[i as usize]).collect();
        let made = Shape::new(own, &facets, pieces, is_continued);
        self.shapes.push(made);
        self.shapes.len() as u32 - 1
    }

    /// The first curved face with all corners of a facet or an edge.
    fn face(&self, [a, b, c]: &[u32; 3]) -> u32 {
        let mut around = self.patches.given_at(*a).filter(|&at| {
            let corners = self.given.corners[at as usize];
            corners.contains(b) && corners.contains(c) && self.given.faces[at as usize] != NONE
        });
        around
            .next()
            .map_or(NONE, |at| self.given.faces[at as usize])
    }

    /// The piece of a curved face, or the flat one, above a facet.
    fn piece(&mut self, facet: &[u32; 3], face: u32) -> FacePiece {
        let place = |nodes: &[u32], map: &FaceMap| {
            let at = facet.map(|corner| nodes.iter().position(|&node| node == corner));
            at.map(|at| map.places[at.expect("it is a node of the face")])
        };
        let Some(curved) = self.given.curved.get(face as usize) else {
            let corners = facet.map(|corner| self.points[corner as usize]);
            let map = Arc::new(FaceMap::flat());
            return FacePiece {
                corners: place(facet, &map),
                polynomial: Arc::new(Polynomial::new(&map, &corners)),
            };
        };
        let points = self.points;
        let polynomial = self.polynomials.entry(face).or_insert_with(|| {
            let nodes = curved.nodes.iter().map(|&node| points[node as usize]);
            Arc::new(Polynomial::new(&curved.map, &nodes.collect::<Vec<_>>()))
        });
        FacePiece {
            polynomial: polynomial.clone(),
            corners: place(&curved.nodes, &curved.map),
        }
    }
}

/// The two directions across an edge, a plane's normal among them where it has one.
fn across(planes: &Constraint, tangent: Vector) -> Constraint {
    let beside = |axis: usize| {
        let mut e = [0.0; 3];
        e[axis] = 1.0;
        sub(e, scale(tangent, tangent[axis]))
    };
    match planes.columns() {
        [normal, ..] => Constraint::of_normals(&[*normal, cross(*normal, tangent)]),
        [] => {
            let least = (0..3).fold(0, |least, k| {
                if tangent[k].abs() < tangent[least].abs() {
                    k
                } else {
                    least
                }
            });
            let one = beside(least);
            Constraint::of_normals(&[one, cross(one, tangent)])
        }
    }
}

#[cfg(test)]
mod tests;
