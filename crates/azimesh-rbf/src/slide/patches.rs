//! Cuts a surface into smooth patches, and the facets round a point into sectors.
//!
//! Facets of one tag that meet at a hinge (an edge; a point in the plane) belong together while they
//! fold by less than 20 degrees there. A wall that a flow solver can use turns by a few degrees from
//! facet to facet, less than 20 even with 18 of them round a circle; an edge that must stay sharp
//! turns by more. The fold is measured from the facets' own sides of the hinge, so that neither
//! their orientation nor two planes at a small angle matter.

use crate::images::Continued;
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, scale, sub, unit};
use azimesh_core::parallel;

/// Cosine of the fold from which a hinge is a crease: 20 degrees.
pub(super) const SHARP: f64 = 0.939_692_620_785_908_4;
/// A facet is flat to a line when its height is at most this part of the surface's size.
const FLAT: f64 = 1e-12;
/// A patch is planar while its nodes leave its plane by this part of its size at most.
const PLANAR: f64 = 1e-6;
/// More facets than this at a hinge are no smooth surface in any pairing.
const MOST_AT_HINGE: usize = 64;
/// Components of a plane's normal below this are round-off.
const ZERO: f64 = 1e-9;
/// No joint.
const NONE: u32 = u32::MAX;

/// A surface in smooth patches. Facets without an area are left out, but the facets on either side of
/// them is still joined.
pub(super) struct Patches {
    /// Corners of each facet, own ones first, then periodic images; an edge of the plane repeats its second.
    pub facets: Vec<[u32; 3]>,
    /// The position of each facet in the given list.
    given: Vec<u32>,
    /// For each facet the own facet that it is an image of; itself for own ones.
    source: Vec<u32>,
    /// Number of own facets.
    n_own: usize,
    /// True if the facets are edges of a plane mesh.
    pub in_plane: bool,
    /// Unit normals; their sense is arbitrary.
    normals: Vec<Vector>,
    /// Area of each facet, in the plane its length.
    areas: Vec<f64>,
    /// Patch of each facet.
    pub patch: Vec<u32>,
    /// Normal of each patch that is planar, with all patches that images join to it.
    pub planes: Vec<Option<Vector>>,
    /// For each patch the first of those that images join to it.
    pub whole: Vec<u32>,
    /// For each patch whether images continue it smoothly.
    pub continued: Vec<bool>,
    /// For each side of each facet what is smoothly joined there.
    joints: Vec<[u32; 3]>,
    /// For each side of each facet whether it is a crease.
    creased: Vec<[bool; 3]>,
    /// Facets of each point, `first[i]..first[i + 1]` of `around`.
    first: Vec<u32>,
    around: Vec<u32>,
}

/// Facets at a point that are joined smoothly round it.
pub(super) struct Sector {
    /// The patch they belong to.
    pub patch: u32,
    /// Their area-weighted normal, on a planar patch the plane's; of unit length.
    pub normal: Vector,
}

impl Patches {
    /// Cuts facets with the tags of their own ones into patches. `O(n log n)`.
    pub fn new(surface: &Continued<'_>, tags: &[u32]) -> Self {
        let (points, facets) = (&*surface.points, &*surface.facets);
        let in_plane = facets.iter().all(|[_, b, c]| b == c);
        let bounds = Bounds::around(facets.iter().flatten().map(|&i| &points[i as usize]));
        let far = largest_coordinate(&bounds);
        let thin = FLAT * (bounds.diagonal() + far);
        let mut patches = Self {
            facets: Vec::new(),
            given: Vec::new(),
            source: Vec::new(),
            n_own: 0,
            in_plane,
            normals: Vec::new(),
            areas: Vec::new(),
            patch: Vec::new(),
            planes: Vec::new(),
            whole: Vec::new(),
            continued: Vec::new(),
            joints: Vec::new(),
            creased: Vec::new(),
            first: Vec::new(),
            around: Vec::new(),
        };
        let mut kept_tags = Vec::new();
        let mut place = vec![NONE; tags.len()];
        let mut flat = Vec::new();
        for at in without_repeats(facets) {
            let facet = facets[at];
            match shape(points, &facet, in_plane, thin) {
                Some((normal, area)) => {
                    patches.facets.push(facet);
                    patches.normals.push(normal);
                    patches.areas.push(area);
                    patches.given.push(at as u32);
                    let own = match at.checked_sub(tags.len()) {
                        None => at,
                        Some(image) => surface.of_facets[image] as usize,
                    };
                    if at == own {
                        place[own] = patches.n_own as u32;
                        patches.n_own += 1;
                    }
                    patches.source.push(place[own]);
                    kept_tags.push(tags[own]);
                }
                None => flat.push(facet),
            }
        }
        patches.join(points, &kept_tags, &flat);
        patches.find_planes(points);
        patches.join_images();
        patches.list_around(points.len());
        patches
    }

    /// Joins facets at their hinges and numbers the patches.
    fn join(&mut self, points: &[Vector], tags: &[u32], flat: &[[u32; 3]]) {
        let hinges = self.hinges(flat);
        let n = self.facets.len();
        self.joints = vec![[NONE; 3]; n];
        self.creased = vec![[false; 3]; n];
        let mut patch = UnionFind::new(n);
        let mut n_joints = 0;
        for hinge in hinges.chunk_by(|a, b| a.0 == b.0) {
            let group = self.groups(points, tags, hinge);
            let one = group.iter().all(|&g| g == 0);
            for (&(_, facet, side), &g) in hinge.iter().zip(&group) {
                let (at, first) = (facet as usize, hinge[g as usize].1);
                self.joints[at][side as usize] = n_joints + g;
                self.creased[at][side as usize] = !one;
                patch.join(facet, first);
            }
            n_joints += hinge.len() as u32;
        }
        let mut number = vec![NONE; n];
        let mut n_patches = 0;
        for facet in 0..n as u32 {
            let root = patch.root(facet) as usize;
            if number[root] == NONE {
                number[root] = n_patches;
                n_patches += 1;
            }
            self.patch.push(number[root]);
        }
        self.planes = vec![None; n_patches as usize];
    }

    /// Every side of every facet as (hinge, facet, side), by hinge. The sides of a facet without area
    /// are one hinge.
    fn hinges(&self, flat: &[[u32; 3]]) -> Vec<(u32, u32, u32)> {
        let n = self.facets.len() as u32;
        let all = self.facets.iter().chain(flat).zip(0..);
        let mut keyed: Vec<[u32; 4]> = all
            .flat_map(|(facet, at)| {
                let sides = sides(facet, self.in_plane).zip(0..);
                sides.map(move |((a, b), side)| [a, b, at, side])
            })
            .collect();
        parallel::sort(&mut keyed);
        let mut hinges: Vec<(u32, u32, u32)> = Vec::with_capacity(keyed.len());
        let mut n_hinges = 0;
        for same in keyed.chunk_by(|a, b| a[..2] == b[..2]) {
            hinges.extend(same.iter().map(|&[_, _, at, side]| (n_hinges, at, side)));
            n_hinges += 1;
        }
        if flat.is_empty() {
            return hinges;
        }
        let mut same = UnionFind::new(n_hinges as usize);
        let mut first = vec![NONE; flat.len()];
        for &(hinge, at, _) in hinges.iter().filter(|side| side.1 >= n) {
            let first = &mut first[(at - n) as usize];
            match *first {
                NONE => *first = hinge,
                first => same.join(first, hinge),
            }
        }
        hinges.retain(|side| side.1 < n);
        for (hinge, ..) in &mut hinges {
            *hinge = same.root(*hinge);
        }
        hinges.sort_unstable();
        hinges
    }

    /// For each facet at a hinge the first of those it is smoothly joined to there.
    fn groups(&self, points: &[Vector], tags: &[u32], hinge: &[(u32, u32, u32)]) -> Vec<u32> {
        let mut group = UnionFind::new(hinge.len());
        if hinge.len() <= MOST_AT_HINGE {
            let ways: Vec<Vector> = hinge
                .iter()
                .map(|&(_, facet, side)| self.inward(points, facet, side))
                .collect();
            for i in 0..hinge.len() {
                for j in 0..i {
                    let same_tag = tags[hinge[i].1 as usize] == tags[hinge[j].1 as usize];
                    if same_tag && -dot(ways[i], ways[j]) > SHARP {
                        group.join(i as u32, j as u32);
                    }
                }
            }
        }
        (0..hinge.len() as u32).map(|i| group.root(i)).collect()
    }

    /// Unit direction from a side of a facet into it, across the side.
    fn inward(&self, points: &[Vector], facet: u32, side: u32) -> Vector {
        let corners = self.facets[facet as usize].map(|i| points[i as usize]);
        let side = side as usize;
        let into = if self.in_plane {
            sub(corners[1 - side], corners[side])
        } else {
            let along = sub(corners[(side + 1) % 3], corners[side]);
            let to = sub(corners[(side + 2) % 3], corners[side]);
            sub(to, scale(along, dot(along, to) / dot(along, along)))
        };
        unit(into).expect("the facet has an area")
    }

    fn find_planes(&mut self, points: &[Vector]) {
        let mut facets: Vec<u32> = (0..self.facets.len() as u32).collect();
        facets.sort_by_key(|&at| self.patch[at as usize]);
        for facets in facets.chunk_by(|&a, &b| self.patch[a as usize] == self.patch[b as usize]) {
            let patch = self.patch[facets[0] as usize] as usize;
            self.planes[patch] = self.plane(points, facets);
        }
    }

    /// The normal of the common plane of these facets, if there is one. Where an axis will do, it is
    /// the axis.
    fn plane(&self, points: &[Vector], facets: &[u32]) -> Option<Vector> {
        let corners = || {
            let facets = facets.iter().map(|&at| &self.facets[at as usize]);
            facets.flatten().map(|&i| &points[i as usize])
        };
        let bounds = Bounds::around(corners());
        let single = f64::from(f32::EPSILON) * largest_coordinate(&bounds);
        let tolerance = PLANAR * bounds.diagonal() + single;
        let normal = self.mean_normal(facets);
        let height = |point: &Vector| dot(normal, sub(*point, bounds.low));
        let (low, high) = corners().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(height(x)), high.max(height(x)))
        });
        if high - low > 2.0 * tolerance {
            return None;
        }
        let thin =
            |&k: &usize| bounds.high[k] - bounds.low[k] <= 2.0 * tolerance && normal[k].abs() > 0.9;
        if let Some(k) = (0..3).find(thin) {
            let mut axis = [0.0; 3];
            axis[k] = 1.0;
            return Some(axis);
        }
        unit(normal.map(|x| if x.abs() < ZERO { 0.0 } else { x }))
    }

    /// Finds the patches that are parts of one, by their images. It is planar if each of them is.
    fn join_images(&mut self) {
        let n = self.planes.len();
        let mut whole = UnionFind::new(n);
        let mut has_own = vec![false; n];
        self.patch[..self.n_own]
            .iter()
            .for_each(|&patch| has_own[patch as usize] = true);
        let images = self.n_own..self.facets.len();
        let mut continued = vec![false; n];
        for image in images.filter(|&image| self.source[image] != NONE) {
            let patch = self.patch[image];
            whole.join(patch, self.patch[self.source[image] as usize]);
            continued[patch as usize] |= has_own[patch as usize];
        }
        self.whole = (0..n as u32).map(|patch| whole.root(patch)).collect();
        let mut is_planar = vec![true; n];
        self.continued = vec![false; n];
        for (patch, &whole) in self.whole.iter().enumerate() {
            is_planar[whole as usize] &= self.planes[patch].is_some();
            self.continued[whole as usize] |= continued[patch];
        }
        for (plane, &whole) in self.planes.iter_mut().zip(&self.whole) {
            plane.take_if(|_| !is_planar[whole as usize]);
        }
    }

    /// Area-weighted mean of the normals of these facets, in the sense of the largest.
    fn mean_normal(&self, facets: &[u32]) -> Vector {
        let area = |at: u32| self.areas[at as usize];
        let larger = |a: u32, &b: &u32| if area(b) > area(a) { b } else { a };
        let largest = self.normals[facets.iter().fold(facets[0], larger) as usize];
        let mut sum = [0.0; 3];
        for &at in facets {
            let normal = self.normals[at as usize];
            let weight = area(at).copysign(dot(normal, largest));
            for k in 0..3 {
                sum[k] += weight * normal[k];
            }
        }
        unit(sum).unwrap_or(largest)
    }

    fn list_around(&mut self, n_points: usize) {
        let distinct = if self.in_plane { 2 } else { 3 };
        self.first = vec![0; n_points + 1];
        for facet in &self.facets {
            for &point in &facet[..distinct] {
                self.first[point as usize + 1] += 1;
            }
        }
        for i in 0..n_points {
            self.first[i + 1] += self.first[i];
        }
        let mut next = self.first.clone();
        self.around = vec![0; self.first[n_points] as usize];
        for (at, facet) in self.facets.iter().enumerate() {
            for &point in &facet[..distinct] {
                let slot = &mut next[point as usize];
                self.around[*slot as usize] = at as u32;
                *slot += 1;
            }
        }
    }

    /// Own facets with the whole patch of each, by patch.
    pub fn by_patch(&self) -> Vec<(u32, [u32; 3])> {
        let whole = self.patch.iter().map(|&patch| self.whole[patch as usize]);
        let mut facets: Vec<_> = whole.zip(self.own().iter().copied()).collect();
        facets.sort_by_key(|entry| entry.0);
        facets
    }

    /// The facets that are no images.
    pub fn own(&self) -> &[[u32; 3]] {
        &self.facets[..self.n_own]
    }

    /// The positions of the own facets at a point in the given list.
    pub fn given_at(&self, point: u32) -> impl Iterator<Item = u32> {
        let facets = self.facets_at(point).iter();
        let own = facets.filter(|&&at| (at as usize) < self.n_own);
        own.map(|&at| self.given[at as usize])
    }

    fn facets_at(&self, point: u32) -> &[u32] {
        let range = self.first[point as usize] as usize..self.first[point as usize + 1] as usize;
        &self.around[range]
    }

    /// The sectors round a point, by their first facet.
    pub fn sectors(&self, point: u32) -> Vec<Sector> {
        let facets = self.facets_at(point);
        let mut joined: Vec<(u32, u32)> = Vec::new();
        for (local, &at) in facets.iter().enumerate() {
            for (side, (a, b)) in sides(&self.facets[at as usize], self.in_plane).enumerate() {
                if a == point || b == point {
                    joined.push((self.joints[at as usize][side], local as u32));
                }
            }
        }
        joined.sort_unstable();
        let mut sector = UnionFind::new(facets.len());
        for pair in joined.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            sector.join(pair[0].1, pair[1].1);
        }
        let roots: Vec<u32> = (0..facets.len() as u32).map(|i| sector.root(i)).collect();
        let firsts = (0..roots.len()).filter(|&i| roots[i] == i as u32);
        firsts
            .map(|first| {
                let of = (0..roots.len()).filter(|&i| roots[i] == first as u32);
                let of: Vec<u32> = of.map(|i| facets[i]).collect();
                let patch = self.patch[of[0] as usize];
                let plane = self.planes[patch as usize];
                Sector {
                    patch,
                    normal: plane.unwrap_or_else(|| self.mean_normal(&of)),
                }
            })
            .collect()
    }

    /// Other ends of the creases that meet at a point, ascending. None in the plane, where a crease
    /// is a point.
    pub fn creases(&self, point: u32) -> Vec<u32> {
        let mut ends = Vec::new();
        for &at in self.facets_at(point) {
            for (side, (a, b)) in sides(&self.facets[at as usize], self.in_plane).enumerate() {
                if self.creased[at as usize][side] && a != b && (a == point || b == point) {
                    ends.push(if a == point { b } else { a });
                }
            }
        }
        ends.sort_unstable();
        ends.dedup();
        ends
    }
}

fn largest_coordinate(bounds: &Bounds) -> f64 {
    let all = bounds.low.iter().chain(&bounds.high);
    all.filter(|x| x.is_finite())
        .fold(0.0, |m, x| f64::max(m, x.abs()))
}

/// Positions of the facets, of those with the same corners the first.
fn without_repeats(facets: &[[u32; 3]]) -> Vec<usize> {
    let keyed = facets.iter().zip(0..).map(|(corners, at)| {
        let mut corners = *corners;
        corners.sort_unstable();
        let [a, b, c] = corners;
        [a, b, c, at]
    });
    let mut keyed: Vec<[u32; 4]> = keyed.collect();
    parallel::sort(&mut keyed);
    keyed.dedup_by(|a, b| a[..3] == b[..3]);
    let mut kept: Vec<usize> = keyed.into_iter().map(|[.., at]| at as usize).collect();
    kept.sort_unstable();
    kept
}

/// Unit normal and area of a facet; `None` when its height is at most `thin`. An edge has its normal
/// in the plane.
fn shape(points: &[Vector], facet: &[u32; 3], in_plane: bool, thin: f64) -> Option<(Vector, f64)> {
    let [a, b, c] = facet.map(|i| points[i as usize]);
    if in_plane {
        let along = sub(b, a);
        let length = along[0].hypot(along[1]);
        return (length > thin).then(|| ([along[1] / length, -along[0] / length, 0.0], length));
    }
    let normal = cross(sub(b, a), sub(c, a));
    let twice_area = norm(normal);
    let lengths = [sub(b, a), sub(c, b), sub(a, c)].map(norm);
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    if shortest <= thin || twice_area <= thin * longest {
        return None;
    }
    Some((scale(normal, 1.0 / twice_area), 0.5 * twice_area))
}

/// The hinges of a facet: its edges in space, its ends in the plane.
fn sides(facet: &[u32; 3], in_plane: bool) -> impl Iterator<Item = (u32, u32)> + use<> {
    let [a, b, c] = *facet;
    let pair = |a: u32, b: u32| (a.min(b), a.max(b));
    let (sides, n) = if in_plane {
        ([(a, a), (b, b), (c, c)], 2)
    } else {
        ([pair(a, b), pair(b, c), pair(c, a)], 3)
    };
    sides.into_iter().take(n)
}

/// Disjoint sets, each called by its lowest member.
pub(super) struct UnionFind(Vec<u32>);

impl UnionFind {
    /// `n` sets of one.
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// The name of the set of `i`.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    /// Merges the sets of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
