//! Proves that the fixed nodes of the boundary leave no valid mesh.
//!
//! If all cells are positive, the cells that cover a point are as many as its winding number: the times that the boundary
//! goes round it. The cell of a boundary face covers points next to that face, on its inner side. So no valid mesh has a
//! face of fixed nodes where, on the inner side, the winding number is not positive: one that a body has passed
//! over, or that is in another body. Undecided faces, within rounding, are not infeasible.

use super::{Partner, Task};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, cross, distance, dot, norm, scale, sub};
use azimesh_core::parallel;
use azimesh_io::mesh::CellRef;
use azimesh_io::mesh::sides::for_each_side;
use std::f64::consts::TAU;

/// Largest number of pairs of faces to check.
const MOST_PAIRS: usize = 50_000_000;
/// Rounding of a position, as a part of the largest coordinate.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// A winding number farther than this from a whole one decides nothing.
const WHOLE: f64 = 1e-3;
/// Shares of the corners in the points of a face that are tried.
const SHARES: [Vector; 3] = [[0.31, 0.27, 0.42], [0.45, 0.34, 0.21], [0.23, 0.52, 0.25]];

/// A face of the boundary on whose inner side no valid cell is possible.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrossedFace {
    /// The cell of the face.
    pub cell: usize,
    /// The nodes of the face.
    pub nodes: Vec<u32>,
}

/// A triangle of the boundary seen from outside, or an edge with the inside to its left, whose last corner is its second.
#[derive(Clone, Copy)]
struct Facet {
    at: [Vector; 3],
    /// Distance of the other corners of its face from its plane.
    warp: f64,
}

/// The outer faces of a mesh where they are now.
pub(super) struct Boundary {
    facets: Vec<Facet>,
    is_solid: bool,
    /// Largest effect of rounding.
    near: f64,
}

impl Boundary {
    /// `None` where nothing can be proven: nodes of the boundary move with others elsewhere, faces are curved, or not all cells are checked.
    pub(super) fn of(task: Task<'_>, points: &[Vector]) -> Option<Self> {
        let mesh = task.mesh;
        let reference = task.reference;
        // Cells of the boundary have no sign.
        let unjudged = |cell: usize| {
            let judged = reference.is_valid(cell) && !reference.is_doubtful(cell);
            reference.sign(cell) != 0 && !judged
        };
        // Copies of a node at one place close the boundary as one node does.
        let is_copy = |of: &Partner| {
            let [x, y] = [of.leader, of.node].map(|node| mesh.points[node as usize]);
            of.map == Transform::IDENTITY && distance(x, y) <= ROUNDING * norm(x)
        };
        if !task.freedom.partners().iter().all(is_copy)
            || !reference.maps().is_empty()
            || parallel::any(mesh.cells.len(), unjudged)
        {
            return None;
        }
        let is_solid = mesh.dimension() == 3;
        let mut facets = Vec::new();
        for &(cell, side) in task.freedom.outer() {
            let cell = mesh.cells.get(cell as usize);
            with_side(task, &cell, side, |nodes, outward| {
                facets.extend(facets_of(nodes, outward, points));
            });
        }
        let coordinates = facets.iter().flat_map(|facet| facet.at).flatten();
        Some(Self {
            near: ROUNDING * coordinates.fold(0.0, |most: f64, x| most.max(x.abs())),
            facets,
            is_solid,
        })
    }

    /// The faces of these cells, ascending, next to which no valid cell is possible. The faces of `first` come first, in
    /// case that there are too many.
    pub(super) fn overtaken(
        &self,
        task: Task<'_>,
        points: &[Vector],
        cells: &[u32],
        first: &[u32],
    ) -> Vec<CrossedFace> {
        let has = |cells: &[u32], side: &(u32, u16)| cells.binary_search(&side.0).is_ok();
        let sides = task.freedom.outer().iter();
        let mut sides: Vec<(u32, u16)> = sides.filter(|side| has(cells, side)).copied().collect();
        sides.sort_by_key(|side| !has(first, side));
        sides.truncate(MOST_PAIRS / self.facets.len().max(1));
        sides.sort_unstable();
        let found = parallel::map(sides.len(), &|i| {
            let (cell, side) = sides[i];
            let cell = task.mesh.cells.get(cell as usize);
            let mut found = None;
            with_side(task, &cell, side, |nodes, outward| {
                let fixed = nodes.iter().all(|&node| task.freedom.is_fixed(node));
                let proven = |facet: Facet| {
                    facet.warp <= self.near && self.winding(&facet).is_some_and(|w| w <= 0)
                };
                if fixed && facets_of(nodes, outward, points).any(proven) {
                    found = Some(CrossedFace {
                        cell: cell.index,
                        nodes: nodes.to_vec(),
                    });
                }
            });
            found
        });
        found.into_iter().flatten().collect()
    }

    /// The winding number next to a facet, on its inner side; `None` where it is undecided.
    fn winding(&self, facet: &Facet) -> Option<i64> {
        let [a, b, c] = facet.at;
        SHARES.iter().find_map(|share| {
            let x: Vector = if self.is_solid {
                [0, 1, 2].map(|k| share[0] * a[k] + share[1] * b[k] + share[2] * c[k])
            } else {
                [0, 1, 2].map(|k| share[0] * a[k] + (1.0 - share[0]) * b[k])
            };
            let mut sum = 0.0;
            for other in &self.facets {
                sum += if self.is_solid {
                    self.solid_angle(other, x, normal(facet))?
                } else {
                    self.angle(other, x, sub(b, a))?
                };
            }
            let turns = sum / if self.is_solid { 2.0 * TAU } else { TAU };
            let whole = turns.round();
            ((turns - whole).abs() < WHOLE).then_some(whole as i64)
        })
    }

    /// The angle of an edge seen from the left side of a point `x` of one with the direction `along`; `None` if rounding
    /// decides.
    fn angle(&self, edge: &Facet, x: Vector, along: Vector) -> Option<f64> {
        let (a, b) = (sub(edge.at[0], x), sub(edge.at[1], x));
        let own = sub(b, a);
        let length = norm(own);
        let (turn, between) = (a[0] * b[1] - a[1] * b[0], dot(a, b));
        if norm(a) <= self.near || norm(b) <= self.near {
            return None;
        }
        if turn.abs() > self.near * length || between > 0.0 {
            return Some(turn.atan2(between));
        }
        beside(own, along).map(|side| side * 0.5 * TAU)
    }

    /// The solid angle of a triangle seen from the inner side of a point `x` of one with the normal `up`; `None` if
    /// rounding decides.
    fn solid_angle(&self, triangle: &Facet, x: Vector, up: Vector) -> Option<f64> {
        let [a, b, c] = triangle.at.map(|corner| sub(corner, x));
        let n = cross(sub(b, a), sub(c, a));
        let (size, volume) = (norm(n), dot(a, cross(b, c)));
        let (la, lb, lc) = (norm(a), norm(b), norm(c));
        let reach = la.min(lb).min(lc);
        if triangle.warp > self.near
            && volume.abs() <= 2.0 * triangle.warp * size
            && reach <= distance(a, b).max(distance(b, c)).max(distance(c, a))
        {
            return None;
        }
        if volume.abs() <= self.near * size {
            let parts = [cross(a, b), cross(b, c), cross(c, a)].map(|part| dot(part, n));
            let margin = 1e-9 * size * size;
            if parts.iter().any(|part| *part < -margin) {
                return Some(0.0);
            }
            let inside = parts.iter().all(|part| *part > margin);
            return inside
                .then(|| beside(n, up))
                .flatten()
                .map(|side| side * TAU);
        }
        let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        Some(2.0 * volume.atan2(below))
    }
}

/// 1 for parallel directions, -1 for opposite ones, `None` for others.
fn beside(a: Vector, b: Vector) -> Option<f64> {
    let cosine = dot(a, b) / (norm(a) * norm(b)).max(f64::MIN_POSITIVE);
    (cosine.abs() > 1.0 - 1e-9).then(|| cosine.signum())
}

fn normal(facet: &Facet) -> Vector {
    let [a, b, c] = facet.at;
    cross(sub(b, a), sub(c, a))
}

/// Calls `act` with the nodes of a side of a cell, and whether they turn as seen from outside, or have the inside to
/// their left.
fn with_side(task: Task<'_>, cell: &CellRef<'_>, side: u16, act: impl FnOnce(&[u32], bool)) {
    let upright = task.reference.sign(cell.index) > 0;
    let mut act = Some(act);
    for_each_side(&task.mesh.cells, cell, |face, nodes| {
        if face == usize::from(side)
            && let Some(act) = act.take()
        {
            act(nodes, upright);
        }
    });
}

/// A face as triangles, or an edge.
fn facets_of<'a>(
    nodes: &'a [u32],
    outward: bool,
    points: &'a [Vector],
) -> impl Iterator<Item = Facet> + 'a {
    let at = move |i: usize| points[nodes[i] as usize];
    let n = nodes.len();
    let first = if n == 2 { 1 } else { 2 };
    (first..n.max(first)).map(move |i| {
        let mut corners = [at(0), at(i - 1), at(i)];
        if n == 2 {
            corners = [at(0), at(1), at(1)];
        }
        if !outward {
            corners = match n {
                2 => [at(1), at(0), at(0)],
                _ => [corners[0], corners[2], corners[1]],
            };
        }
        let flat = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let up = scale(flat, 1.0 / norm(flat).max(f64::MIN_POSITIVE));
        let heights = (0..n).map(|k| dot(sub(at(k), corners[0]), up).abs());
        Facet {
            at: corners,
            warp: if n > 3 {
                heights.fold(0.0, f64::max)
            } else {
                0.0
            },
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Reference;
    use crate::repair::Freedom;
    use crate::repair::shape::regular;
    use azimesh_io::mesh::{Adjacency, CellKind, Coincident, Mesh};

    /// Proofs for the first cell's faces with the nodes at `points`.
    fn proven(mesh: &Mesh, points: &[Vector]) -> Vec<CrossedFace> {
        let (reference, freedom) = (
            Reference::new(mesh),
            Freedom::inner(mesh, &Adjacency::of(mesh), &Coincident::default()),
        );
        let task = Task {
            mesh,
            reference: &reference,
            freedom: &freedom,
        };
        let all: Vec<u32> = (0..mesh.cells.len() as u32).collect();
        let boundary = Boundary::of(task, points).expect("all cells are checked");
        boundary.overtaken(task, points, &all, &[])
    }

    #[test]
    fn the_boundary_goes_round_the_inside_of_every_kind_once() {
        for (kind, n) in [
            (CellKind::Triangle, 3),
            (CellKind::Quadrilateral, 4),
            (CellKind::Tetrahedron, 4),
            (CellKind::Pyramid, 5),
            (CellKind::Wedge, 6),
            (CellKind::Hexahedron, 8),
        ] {
            for sign in [1.0, -1.0] {
                let points = regular(kind, &vec![[0.0; 3]; n], sign, 1.0).expect("it has a shape");
                let mut mesh = Mesh {
                    points,
                    ..Mesh::default()
                };
                mesh.cells.push(kind, &(0..n as u32).collect::<Vec<_>>());
                let (reference, freedom) = (
                    Reference::new(&mesh),
                    Freedom::inner(&mesh, &Adjacency::of(&mesh), &Coincident::default()),
                );
                let task = Task {
                    mesh: &mesh,
                    reference: &reference,
                    freedom: &freedom,
                };
                let boundary = Boundary::of(task, &mesh.points).expect("all cells are checked");
                assert!(boundary.facets.len() >= 3);
                for facet in &boundary.facets {
                    assert_eq!(boundary.winding(facet), Some(1), "{kind:?} {sign}");
                }
                // In a mirrored mesh, the outside is on the inner side of every face.
                let mirrored = mesh.points.iter().map(|x| [-x[0], x[1], x[2]]);
                let mirrored: Vec<Vector> = mirrored.collect();
                assert!(!proven(&mesh, &mirrored).is_empty(), "{kind:?} {sign}");
            }
        }
    }

    #[test]
    fn a_node_that_is_passed_along_a_straight_side_is_named_and_one_that_is_not_is_not() {
        let mesh = crate::repair::tests::grid(CellKind::Quadrilateral, 6);
        let mut points = mesh.points.clone();
        points[2][0] = 0.45;
        assert_eq!(proven(&mesh, &points), []);
        points[2][0] = 0.6;
        let found = proven(&mesh, &points);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].cell, &found[0].nodes[..]), (2, &[2, 3][..]));
    }

    #[test]
    fn a_boundary_that_covers_itself_is_not_called_infeasible() {
        // A strip bent by more than a turn: its ends cover each other, all of its cells are valid.
        let mut mesh = Mesh::default();
        for i in 0..40 {
            for r in [1.0, 2.0] {
                mesh.points.push([f64::from(i), r, 0.0]);
            }
        }
        for i in 0..39 {
            let a = 2 * i;
            mesh.cells
                .push(CellKind::Quadrilateral, &[a, a + 2, a + 3, a + 1]);
        }
        let bent = mesh.points.iter().map(|x| {
            let (s, c) = (-0.2 * x[0]).sin_cos();
            [x[1] * c, x[1] * s, 0.0]
        });
        let bent: Vec<Vector> = bent.collect();
        let reference = Reference::new(&mesh);
        assert_eq!(crate::validity::invalid(&mesh, &bent, &reference), []);
        assert_eq!(proven(&mesh, &bent), []);
    }
}
