//! The surface nodes as the interpolation sees them: in the order of a space-filling curve, no two
//! at the same place, with the facets between them.

use crate::error::{Error, Result};
use crate::geometry::{curve, vector::Vector};
use crate::mesh::{CellKind, Cells, Mesh};
use crate::modes::RigidSurface;
use crate::motion::{Motion, Role};
use crate::rbf::constraint::Constraint;
use crate::rbf::slide::Sliding;
use std::sync::Arc;

/// Distinct surface points with the body each moves with.
#[derive(Debug, Clone, Default)]
pub struct SurfacePoints {
    /// Mesh node of each point; of several at one place the lowest.
    pub nodes: Vec<u32>,
    /// Their places in the reference mesh.
    pub points: Vec<Vector>,
    /// The body each moves with; `None` stays.
    pub body: Vec<Option<usize>>,
    /// Triangles between the points; in the plane edges, with the second corner repeated.
    pub facets: Vec<[u32; 3]>,
    /// Surface nodes that lie where another does.
    pub n_coincident: usize,
    /// For each surface node of the motion its point.
    pub point_of: Vec<u32>,
    /// Facets of sliding boundaries, and the tag of each.
    pub sliding_facets: (Vec<[u32; 3]>, Vec<u32>),
    /// Where sliding points may go; `None` when none slides.
    pub sliding: Option<Sliding>,
}

impl SurfacePoints {
    /// The surface of a motion on its mesh.
    pub fn new(mesh: &Mesh, motion: &Motion) -> Result<Self> {
        let nodes = &motion.surface.nodes.nodes;
        let places: Vec<Vector> = nodes.iter().map(|&i| mesh.points[i as usize]).collect();
        let same = first_at_each_place(&places);
        check_roles(nodes, &motion.surface.nodes.roles, &same)?;
        let mut surface = Self::default();
        let mut point_of = vec![u32::MAX; nodes.len()];
        for at in curve::order(&places) {
            let at = at as usize;
            if same[at] != at {
                continue;
            }
            point_of[at] = surface.nodes.len() as u32;
            surface.nodes.push(nodes[at]);
            surface.points.push(places[at]);
            surface.body.push(match motion.surface.nodes.roles[at] {
                Role::Moving(body) => Some(usize::from(body)),
                Role::Fixed | Role::Sliding => None,
            });
        }
        surface.n_coincident = nodes.len() - surface.nodes.len();
        surface.point_of = same.iter().map(|&first| point_of[first]).collect();
        let point = |node: u32| {
            let at = nodes.binary_search(&node).ok()?;
            Some(point_of[same[at]])
        };
        surface.add_facets(mesh, motion, point);
        surface.sliding = surface.find_sliding(motion, &surface.points);
        Ok(surface)
    }

    /// The sliding points with the surface points at given places; `None` when none slides.
    pub fn find_sliding(&self, motion: &Motion, points: &[Vector]) -> Option<Sliding> {
        let mut slides = vec![false; points.len()];
        for (role, &point) in motion.surface.nodes.roles.iter().zip(&self.point_of) {
            slides[point as usize] |= *role == Role::Sliding;
        }
        let (facets, tags) = &self.sliding_facets;
        slides
            .contains(&true)
            .then(|| Sliding::new(points, facets, tags, &slides))
    }

    fn add_facets(&mut self, mesh: &Mesh, motion: &Motion, point: impl Fn(u32) -> Option<u32>) {
        let mut add = |kind: CellKind, nodes: &[u32], slides_on: Option<u32>| {
            for triangle in triangles(kind, nodes) {
                if let [Some(a), Some(b), Some(c)] = triangle.map(&point) {
                    self.facets.push([a, b, c]);
                    if let Some(tag) = slides_on {
                        self.sliding_facets.0.push([a, b, c]);
                        self.sliding_facets.1.push(tag);
                    }
                }
            }
        };
        let faces = &motion.surface.faces;
        for ((&cell, role), &tag) in faces.cells.iter().zip(&faces.roles).zip(&faces.tags) {
            let face = mesh.cells.get(cell as usize);
            let slides_on = (*role == Role::Sliding).then_some(tag);
            add(face.kind, face.nodes, slides_on);
        }
        let none = Cells::new();
        let interface = motion
            .zone
            .as_ref()
            .map_or(&none, |zone| &zone.interface_faces);
        for face in interface.iter() {
            add(face.kind, face.nodes, None);
        }
    }

    /// The directions in which each point is held; `None` when none slides.
    pub fn constraints(&self, sliding: Option<&Sliding>) -> Option<Arc<Vec<Constraint>>> {
        let sliding = sliding?;
        let points = 0..self.points.len();
        Some(Arc::new(points.map(|i| sliding.constraint(i)).collect()))
    }

    /// The points with the body of each.
    pub fn rigid(&self) -> RigidSurface<'_> {
        RigidSurface {
            points: &self.points,
            body: &self.body,
        }
    }

    /// Positions among the surface points of given mesh nodes.
    pub fn find(&self, nodes: &[u32]) -> Result<Vec<usize>> {
        let mut sorted: Vec<(u32, usize)> = self.nodes.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let find = |node: &u32| {
            let at = sorted
                .binary_search_by_key(node, |entry| entry.0)
                .map_err(|_| {
                    Error::input(format!(
                        "base point {node} is no surface node of this mesh and schedule"
                    ))
                })?;
            Ok(sorted[at].1)
        };
        nodes.iter().map(find).collect()
    }
}

/// For each place the first of the places that equals it.
fn first_at_each_place(places: &[Vector]) -> Vec<usize> {
    let key = |i: usize| places[i].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_unstable_by_key(|&i| (key(i), i));
    let mut first: Vec<usize> = (0..places.len()).collect();
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &i in group {
            first[i] = group[0];
        }
    }
    first
}

fn check_roles(nodes: &[u32], roles: &[Role], same: &[usize]) -> Result<()> {
    for (i, &first) in same.iter().enumerate() {
        if roles[i] != roles[first] {
            return Err(Error::input(format!(
                "nodes {} and {} lie at the same place, but one moves otherwise than the other; the \
                 mesh would tear there: merge the nodes or give their tags one role",
                nodes[first], nodes[i]
            )));
        }
    }
    Ok(())
}

/// The triangles of a boundary face through all of its nodes; an edge has its second node twice.
fn triangles(kind: CellKind, nodes: &[u32]) -> Vec<[u32; 3]> {
    let split: &[[usize; 3]] = match kind {
        CellKind::Line => &[[0, 1, 1]],
        CellKind::Line3 => &[[0, 2, 2], [2, 1, 1]],
        CellKind::Triangle => &[[0, 1, 2]],
        CellKind::Triangle6 => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        CellKind::Quadrilateral => &[[0, 1, 2], [0, 2, 3]],
        CellKind::Quadrilateral8 => &[
            [0, 4, 7],
            [4, 1, 5],
            [5, 2, 6],
            [6, 3, 7],
            [4, 5, 6],
            [4, 6, 7],
        ],
        CellKind::Quadrilateral9 => &[
            [0, 4, 8],
            [0, 8, 7],
            [4, 1, 5],
            [4, 5, 8],
            [8, 5, 2],
            [8, 2, 6],
            [7, 8, 6],
            [7, 6, 3],
        ],
        CellKind::Polygon => {
            return (2..nodes.len())
                .map(|i| [nodes[0], nodes[i - 1], nodes[i]])
                .collect();
        }
        _ => &[],
    };
    split
        .iter()
        .map(|corners| corners.map(|i| nodes[i]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_at_one_place_are_found_whatever_the_sign_of_zero() {
        let places = [[0.0, 1.0, 2.0], [5.0, 0.0, 0.0], [-0.0, 1.0, 2.0]];
        assert_eq!(first_at_each_place(&places), [0, 1, 0]);
    }

    #[test]
    fn triangles_of_a_face_use_every_node() {
        for kind in CellKind::ALL {
            let Some(n) = kind.n_nodes().filter(|_| matches!(kind.dimension(), 1 | 2)) else {
                continue;
            };
            let nodes: Vec<u32> = (0..n as u32).collect();
            let used = triangles(kind, &nodes).concat();
            assert!(nodes.iter().all(|node| used.contains(node)), "{kind:?}");
        }
    }
}
