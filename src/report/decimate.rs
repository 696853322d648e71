//! A surface with fewer triangles, of which every corner is a corner of the given one, so that it can follow the
//! motion of these.
//!
//! Edges are collapsed onto one of their ends, cheapest first. The cost of moving a node `u` onto `v` is
//!
//! ```text
//! cost = Q_u(v) + Q_v(v) + EVEN a_u |u - v|^2
//! ```
//!
//! `Q` is the sum of `area * distance^2` to the planes of the triangles around a node (Garland and Heckbert, SIGGRAPH
//! 1997), added up as nodes are merged, and `a` the area of these triangles. The last term leaves nodes evenly spread
//! where a surface is flat, since it may bend later. Borders, and edges between triangles of different labels, are
//! collapsed only along themselves. Ties go to the lower node, so that the same input gives the same triangles.

use azimesh_core::geometry::vector::{Vector, cross, dot, norm, scale, sub};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Weight of the length of a collapsed edge: a hundredth of it counts like a distance from the surface.
const EVEN: f64 = 1e-4;
/// Weight of the distance from the line of a border.
const BORDER: f64 = 4.0;
/// Cosine of the angle by which a triangle may turn in one collapse.
const TURN: f64 = 0.3;

/// A triangle and what it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Labelled {
    /// Its corners, as indices of points.
    pub corners: [u32; 3],
    /// What it belongs to.
    pub label: u32,
}

/// At most `target` of the triangles, in their order; those that were left are as they were or have corners moved to
/// other corners. O(n log n) for `n` triangles.
pub fn decimate(points: &[Vector], triangles: &[Labelled], target: usize) -> Vec<Labelled> {
    if triangles.len() <= target {
        return triangles.to_vec();
    }
    let mut work = Work::new(points, triangles);
    work.collapse(target, true);
    // What borders and corners have kept.
    work.collapse(target, false);
    work.triangles.into_iter().flatten().collect()
}

/// `x^T A x + 2 b^T x + c`, with the upper triangle of `A` by rows.
#[derive(Debug, Clone, Copy, Default)]
struct Quadric([f64; 10]);

impl Quadric {
    /// Weighted squared distance to a plane through `point`.
    fn plane(normal: Vector, point: Vector, weight: f64) -> Self {
        let [x, y, z] = normal;
        let d = -dot(normal, point);
        let terms = [
            x * x,
            x * y,
            x * z,
            y * y,
            y * z,
            z * z,
            x * d,
            y * d,
            z * d,
            d * d,
        ];
        Self(terms.map(|term| weight * term))
    }

    fn add(&mut self, other: &Self) {
        for (mine, other) in self.0.iter_mut().zip(&other.0) {
            *mine += other;
        }
    }

    fn at(&self, [x, y, z]: Vector) -> f64 {
        let [xx, xy, xz, yy, yz, zz, xd, yd, zd, dd] = self.0;
        let squares =
            x * (xx * x + 2.0 * (xy * y + xz * z + xd)) + y * (yy * y + 2.0 * (yz * z + yd));
        (squares + z * (zz * z + 2.0 * zd) + dd).max(0.0)
    }
}

/// A collapse of `from` onto `to`: cost, nodes, and the versions of these that it was computed for.
type Candidate = Reverse<(u64, u32, u32, u32, u32)>;

struct Work<'a> {
    points: &'a [Vector],
    /// Subtracted from points, so that quadrics lose no digits.
    origin: Vector,
    triangles: Vec<Option<Labelled>>,
    n_left: usize,
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    areas: Vec<f64>,
    versions: Vec<u32>,
    /// Of each node on borders its neighbours along them.
    borders: BTreeMap<u32, Vec<u32>>,
}

impl<'a> Work<'a> {
    fn new(points: &'a [Vector], triangles: &[Labelled]) -> Self {
        let origin = triangles
            .first()
            .map_or([0.0; 3], |t| points[t.corners[0] as usize]);
        let mut work = Self {
            points,
            origin,
            triangles: triangles.iter().copied().map(Some).collect(),
            n_left: triangles.len(),
            around: vec![Vec::new(); points.len()],
            quadrics: vec![Quadric::default(); points.len()],
            areas: vec![0.0; points.len()],
            versions: vec![0; points.len()],
            borders: BTreeMap::new(),
        };
        for (index, triangle) in (0..).zip(triangles) {
            let [a, b, c] = triangle.corners.map(|node| work.point(node));
            let normal = cross(sub(b, a), sub(c, a));
            let area = 0.5 * norm(normal);
            let unit = if area > 0.0 {
                scale(normal, 0.5 / area)
            } else {
                normal
            };
            let quadric = Quadric::plane(unit, a, area);
            for node in triangle.corners.map(|node| node as usize) {
                work.around[node].push(index);
                work.quadrics[node].add(&quadric);
                work.areas[node] += area;
            }
        }
        work.find_borders(triangles);
        work
    }

    fn point(&self, node: u32) -> Vector {
        sub(self.points[node as usize], self.origin)
    }

    /// Edges that do not lie between two triangles of one label.
    fn find_borders(&mut self, triangles: &[Labelled]) {
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for (index, triangle) in (0..).zip(triangles) {
            let [a, b, c] = triangle.corners;
            edges.extend([(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), index)));
        }
        edges.sort_unstable();
        for same in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            let label = |edge: &(u32, u32, u32)| triangles[edge.2 as usize].label;
            if same.len() == 2 && label(&same[0]) == label(&same[1]) {
                continue;
            }
            let (a, b, _) = same[0];
            self.borders.entry(a).or_default().push(b);
            self.borders.entry(b).or_default().push(a);
            for &(_, _, triangle) in same {
                self.add_border(a, b, &triangles[triangle as usize]);
            }
        }
    }

    /// A plane through an edge, across its triangle, for both of its ends.
    fn add_border(&mut self, a: u32, b: u32, triangle: &Labelled) {
        let normal = self.normal(triangle.corners);
        let along = sub(self.point(b), self.point(a));
        let across = cross(along, normal);
        let length = norm(across);
        if length > 0.0 {
            let weight = BORDER * dot(along, along);
            let quadric = Quadric::plane(scale(across, 1.0 / length), self.point(a), weight);
            self.quadrics[a as usize].add(&quadric);
            self.quadrics[b as usize].add(&quadric);
        }
    }

    fn normal(&self, corners: [u32; 3]) -> Vector {
        let [a, b, c] = corners.map(|node| self.point(node));
        cross(sub(b, a), sub(c, a))
    }

    /// Collapses edges until few enough triangles are left; without `careful` also where the shape suffers.
    fn collapse(&mut self, target: usize, careful: bool) {
        let mut heap: BinaryHeap<Candidate> = BinaryHeap::new();
        for node in 0..self.points.len() as u32 {
            if self.n_left > target {
                self.push_all(node, false, &mut heap);
            }
        }
        while self.n_left > target {
            let Some(Reverse((_, from, to, from_version, to_version))) = heap.pop() else {
                return;
            };
            let versions = [from, to].map(|node| self.versions[node as usize]);
            if versions != [from_version, to_version] || careful && !self.is_allowed(from, to) {
                continue;
            }
            self.merge(from, to);
            self.push_all(to, true, &mut heap);
        }
    }

    /// Candidates of the edges from a node, and those towards it.
    fn push_all(&self, node: u32, both: bool, heap: &mut BinaryHeap<Candidate>) {
        for other in self.neighbours(node) {
            heap.push(self.candidate(node, other));
            if both {
                heap.push(self.candidate(other, node));
            }
        }
    }

    fn candidate(&self, from: u32, to: u32) -> Candidate {
        let place = self.point(to);
        let arm = sub(place, self.point(from));
        let [u, v] = [from as usize, to as usize];
        let bent = self.quadrics[u].at(place) + self.quadrics[v].at(place);
        let cost = bent + EVEN * self.areas[u] * dot(arm, arm);
        // Numbers that are not negative have the order of their bits.
        Reverse((cost.to_bits(), from, to, self.versions[u], self.versions[v]))
    }

    fn around(&self, node: u32) -> impl Iterator<Item = Labelled> {
        let around = self.around[node as usize].iter();
        around.filter_map(|&index| self.triangles[index as usize])
    }

    /// Ascending.
    fn neighbours(&self, node: u32) -> Vec<u32> {
        let corners = self.around(node).flat_map(|triangle| triangle.corners);
        let mut others: Vec<u32> = corners.filter(|corner| *corner != node).collect();
        others.sort_unstable();
        others.dedup();
        others
    }

    /// Whether the surface stays a surface, keeps its borders, and no triangle turns far.
    fn is_allowed(&self, from: u32, to: u32) -> bool {
        if let Some(along) = self.borders.get(&from)
            && (along.len() != 2 || !along.contains(&to))
        {
            return false;
        }
        let shared = self
            .around(from)
            .filter(|triangle| triangle.corners.contains(&to))
            .count();
        let (mine, others) = (self.neighbours(from), self.neighbours(to));
        let common = mine
            .iter()
            .filter(|node| others.binary_search(node).is_ok());
        if common.count() != shared {
            return false;
        }
        let stays = |triangle: &Labelled| !triangle.corners.contains(&to);
        self.around(from).filter(stays).all(|triangle| {
            let before = self.normal(triangle.corners);
            let after = self.normal(moved(triangle.corners, from, to));
            dot(before, after) > TURN * norm(before) * norm(after) || norm(before) == 0.0
        })
    }

    fn merge(&mut self, from: u32, to: u32) {
        let [u, v] = [from as usize, to as usize];
        for index in std::mem::take(&mut self.around[u]) {
            let slot = &mut self.triangles[index as usize];
            let Some(triangle) = slot else { continue };
            if triangle.corners.contains(&to) {
                *slot = None;
                self.n_left -= 1;
            } else {
                triangle.corners = moved(triangle.corners, from, to);
                self.around[v].push(index);
            }
        }
        let triangles = &self.triangles;
        self.around[v].retain(|&index| triangles[index as usize].is_some());
        let quadric = self.quadrics[u];
        self.quadrics[v].add(&quadric);
        self.areas[v] += self.areas[u];
        self.versions[u] += 1;
        self.versions[v] += 1;
        self.merge_borders(from, to);
    }

    fn merge_borders(&mut self, from: u32, to: u32) {
        for other in self.borders.remove(&from).unwrap_or_default() {
            let Some(along) = self.borders.get_mut(&other) else {
                continue;
            };
            along.retain(|node| *node != from);
            if other != to {
                if !along.contains(&to) {
                    along.push(to);
                }
                let own = self.borders.entry(to).or_default();
                if !own.contains(&other) {
                    own.push(other);
                }
            }
        }
    }
}

fn moved(corners: [u32; 3], from: u32, to: u32) -> [u32; 3] {
    corners.map(|node| if node == from { to } else { node })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A closed cylinder of radius 1 and length 3, its lid with another label.
    fn cylinder(n: u32, m: u32) -> (Vec<Vector>, Vec<Labelled>) {
        let mut points = Vec::new();
        for j in 0..=m {
            for i in 0..n {
                let angle = TAU * f64::from(i) / f64::from(n);
                points.push([angle.cos(), angle.sin(), 3.0 * f64::from(j) / f64::from(m)]);
            }
        }
        let mut triangles = Vec::new();
        let mut add = |corners, label| triangles.push(Labelled { corners, label });
        for j in 0..m {
            for i in 0..n {
                let [a, b] = [j * n + i, j * n + (i + 1) % n];
                add([a, b, b + n], 0);
                add([a, b + n, a + n], 0);
            }
        }
        for (ring, label) in [(0, 0), (m, 1)] {
            let centre = points.len() as u32;
            points.push([0.0, 0.0, 3.0 * f64::from(ring) / f64::from(m)]);
            for i in 0..n {
                let [a, b] = [ring * n + i, ring * n + (i + 1) % n];
                add(
                    if ring == 0 {
                        [b, a, centre]
                    } else {
                        [a, b, centre]
                    },
                    label,
                );
            }
        }
        (points, triangles)
    }

    fn volume(points: &[Vector], triangles: &[Labelled]) -> f64 {
        let of = |t: &Labelled| {
            let [a, b, c] = t.corners.map(|node| points[node as usize]);
            dot(a, cross(b, c)) / 6.0
        };
        triangles.iter().map(of).sum()
    }

    #[test]
    fn a_surface_with_fewer_triangles_keeps_its_shape_and_stays_closed() {
        let (points, triangles) = cylinder(96, 120);
        let few = decimate(&points, &triangles, 1500);
        assert!(few.len() <= 1500 && few.len() > 1490, "{}", few.len());
        let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for triangle in &few {
            let [a, b, c] = triangle.corners;
            for (a, b) in [(a, b), (b, c), (c, a)] {
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|times| *times == 0), "there is a hole");
        let (before, after) = (volume(&points, &triangles), volume(&points, &few));
        assert!((after / before - 1.0).abs() < 0.01, "{before}, {after}");
        let is_rim = |node: &u32| points[*node as usize][2] > 2.999 && *node < 97 * 121;
        for triangle in few.iter().filter(|triangle| triangle.label == 1) {
            let [a, b, c] = triangle.corners.map(|node| points[node as usize]);
            assert!([a, b, c].iter().all(|x| x[2] > 2.999), "the lid stays flat");
            assert!(triangle.corners.iter().any(is_rim));
        }
    }

    #[test]
    fn what_is_flat_keeps_nodes_that_can_bend() {
        let n = 60u32;
        let points: Vec<Vector> = (0..n * n)
            .map(|i| [f64::from(i % n), f64::from(i / n), 0.0])
            .collect();
        let corner = |i: u32, j: u32| j * n + i;
        let mut triangles = Vec::new();
        for j in 0..n - 1 {
            for i in 0..n - 1 {
                let [a, b, c, d] = [
                    corner(i, j),
                    corner(i + 1, j),
                    corner(i + 1, j + 1),
                    corner(i, j + 1),
                ];
                triangles.push(Labelled {
                    corners: [a, b, c],
                    label: 0,
                });
                triangles.push(Labelled {
                    corners: [a, c, d],
                    label: 0,
                });
            }
        }
        let few = decimate(&points, &triangles, 400);
        let longest = few.iter().flat_map(|t| {
            let [a, b, c] = t.corners.map(|node| points[node as usize]);
            [norm(sub(a, b)), norm(sub(b, c)), norm(sub(c, a))]
        });
        let longest = longest.fold(0.0, f64::max);
        assert!(longest < 15.0, "{longest}");
    }

    /// Triangles that share no node.
    #[test]
    fn there_are_never_more_triangles_than_asked_for() {
        let mut points = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..500u32 {
            let x = f64::from(i);
            points.extend([[x, 0.0, 0.0], [x + 0.5, 0.0, 0.0], [x, 0.5, 0.0]]);
            triangles.push(Labelled {
                corners: [3 * i, 3 * i + 1, 3 * i + 2],
                label: i % 2,
            });
        }
        assert!(decimate(&points, &triangles, 100).len() <= 100);
        assert_eq!(decimate(&points, &triangles, 500), triangles);
    }
}
