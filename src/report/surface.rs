//! The surfaces that are shown in space: those of the bodies, and other boundaries around them, with few enough
//! triangles.

use super::decimate::{Labelled, decimate};
use crate::record::BodyRecord;
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_core::geometry::{Bounds, curve};
use azimesh_io::mesh::facets::facets;
use azimesh_io::mesh::{CellKind, Mesh};
use std::collections::BTreeMap;

/// Triangles of a page, at most.
pub const TRIANGLES: usize = 100_000;
/// Of these, triangles of boundaries that belong to no body.
const OTHERS: usize = 20_000;
/// Other boundaries that are named; the rest of them are one.
const NAMED: usize = 12;

/// Corners that tell poses apart.
const LANDMARKS: usize = 400;

/// A node of the mesh by its place in a cell: meshes of steps have the cells of the reference mesh in their order, but
/// may have further nodes.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    cell: usize,
    place: usize,
}

impl Corner {
    /// Where it is in a mesh.
    pub fn place(&self, mesh: &Mesh) -> Vector {
        mesh.points[mesh.cells.get(self.cell).nodes[self.place] as usize]
    }
}

/// A body or a boundary.
#[derive(Debug, Clone)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Around its nodes in the reference mesh.
    pub bounds: Bounds,
    /// Where it begins and ends among the vertices of its surface.
    pub vertices: std::ops::Range<usize>,
}

/// Triangles over vertices that are nodes of the mesh. Vertices lie part by part, in each along a curve through space.
#[derive(Debug, Clone, Default)]
pub struct Surface {
    /// The vertices.
    pub vertices: Vec<Corner>,
    /// Where they are in the reference mesh.
    pub points: Vec<Vector>,
    /// The triangles; labels are indices of parts.
    pub triangles: Vec<Labelled>,
    /// Triangles that there were at first.
    pub n_given: usize,
    /// What they belong to.
    pub parts: Vec<Part>,
}

/// What is shown of a mesh in space.
#[derive(Debug, Clone, Default)]
pub struct Surfaces {
    /// The bodies.
    pub bodies: Surface,
    /// What does not move, or is not known to.
    pub others: Surface,
}

impl Surfaces {
    /// Of a mesh in space; `n_bodies` triangles of the bodies at most. `None` where no body has a surface.
    pub fn new(mesh: &Mesh, bodies: &[BodyRecord], n_bodies: usize) -> Option<Self> {
        let faces = faces_of(mesh, bodies);
        if mesh.space_dimension() != 3 || faces.is_empty() {
            return None;
        }
        let (names, other_faces) = other_faces(mesh, &faces);
        let others = Surface::of(mesh, &other_faces, names, OTHERS).unwrap_or_default();
        let names = bodies.iter().map(|body| body.name.clone()).collect();
        let room = TRIANGLES - others.triangles.len();
        let bodies = Surface::of(mesh, &faces, names, n_bodies.min(room))?;
        Some(Self { bodies, others })
    }
}

/// Faces of the bodies, each once: the cell and the body, ascending. Of a mesh of faces alone all belong to the first
/// body.
fn faces_of(mesh: &Mesh, bodies: &[BodyRecord]) -> Vec<(usize, u32)> {
    if mesh.dimension() == 2 && !bodies.is_empty() {
        let runs = mesh.volume_runs();
        return runs
            .flat_map(|run| run.first_cell..run.first_cell + run.n_cells())
            .map(|cell| (cell, 0))
            .collect();
    }
    let mut faces = Vec::new();
    for (label, body) in (0..).zip(bodies) {
        for tag in mesh
            .boundary_tags()
            .filter(|tag| body.tags.contains(&tag.name))
        {
            faces.extend(tag.cells.iter().map(|cell| (cell, label)));
        }
    }
    faces.sort_unstable();
    faces.dedup_by_key(|(cell, _)| *cell);
    faces
}

/// Faces of boundaries that belong to no body, and the names of these; small boundaries beyond the first few are one.
fn other_faces(mesh: &Mesh, of_bodies: &[(usize, u32)]) -> (Vec<String>, Vec<(usize, u32)>) {
    let is_free = |cell: &usize| {
        of_bodies
            .binary_search_by_key(cell, |(cell, _)| *cell)
            .is_err()
    };
    let tags = mesh.boundary_tags().filter(|_| mesh.dimension() == 3);
    let cells = tags.map(|tag| (tag, tag.cells.iter().filter(is_free).count()));
    let mut tags: Vec<_> = cells.filter(|(_, n)| *n > 0).collect();
    tags.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let mut names: Vec<String> = tags
        .iter()
        .take(NAMED)
        .map(|(tag, _)| tag.name.clone())
        .collect();
    if tags.len() > NAMED {
        names.push(format!("{} other boundaries", tags.len() - NAMED));
    }
    let mut faces = Vec::new();
    for (label, (tag, _)) in tags.iter().enumerate() {
        let label = label.min(NAMED) as u32;
        faces.extend(tag.cells.iter().filter(is_free).map(|cell| (cell, label)));
    }
    faces.sort_unstable();
    faces.dedup_by_key(|(cell, _)| *cell);
    (names, faces)
}

impl Surface {
    /// Of some faces; `None` where they have no triangles.
    fn of(mesh: &Mesh, faces: &[(usize, u32)], names: Vec<String>, target: usize) -> Option<Self> {
        let mut index = vec![u32::MAX; mesh.points.len()];
        let (mut vertices, mut points, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        let mut known: BTreeMap<(CellKind, usize), Vec<[usize; 3]>> = BTreeMap::new();
        for &(cell, label) in faces {
            let face = mesh.cells.get(cell);
            let pieces = known.entry((face.kind, face.nodes.len()));
            for piece in pieces.or_insert_with(|| facets(face.kind, face.nodes.len())) {
                let corners = piece.map(|place| {
                    let node = face.nodes[place] as usize;
                    if index[node] == u32::MAX {
                        index[node] = vertices.len() as u32;
                        vertices.push(Corner { cell, place });
                        points.push(mesh.points[node]);
                    }
                    index[node]
                });
                let [a, b, c] = corners;
                if a != b && b != c && c != a {
                    triangles.push(Labelled { corners, label });
                }
            }
        }
        let n_given = triangles.len();
        let triangles = decimate(&points, &triangles, target);
        let mut surface = Self {
            vertices,
            points,
            triangles,
            n_given,
            parts: Vec::new(),
        };
        surface.sort(names);
        (n_given > 0).then_some(surface)
    }

    /// Keeps the vertices that triangles have, part by part along a curve; a vertex of two parts belongs to the first.
    fn sort(&mut self, names: Vec<String>) {
        let mut part = vec![u32::MAX; self.points.len()];
        for triangle in &self.triangles {
            for corner in triangle.corners {
                let part = &mut part[corner as usize];
                *part = triangle.label.min(*part);
            }
        }
        let mut order: Vec<u32> = curve::order(&self.points);
        order.retain(|&vertex| part[vertex as usize] != u32::MAX);
        order.sort_by_key(|&vertex| part[vertex as usize]);
        let mut place = vec![0u32; self.points.len()];
        for (at, &vertex) in (0..).zip(&order) {
            place[vertex as usize] = at;
        }
        for triangle in &mut self.triangles {
            let [a, b, c] = triangle.corners.map(|corner| place[corner as usize]);
            // The lowest first, turning as before.
            let least = a.min(b).min(c);
            triangle.corners = if least == a {
                [a, b, c]
            } else if least == b {
                [b, c, a]
            } else {
                [c, a, b]
            };
        }
        self.triangles
            .sort_unstable_by_key(|triangle| (triangle.label, triangle.corners));
        self.vertices = order
            .iter()
            .map(|&vertex| self.vertices[vertex as usize])
            .collect();
        self.points = order
            .iter()
            .map(|&vertex| self.points[vertex as usize])
            .collect();
        for (label, name) in (0..).zip(names) {
            let of = |at: usize| part[order[at] as usize];
            let first = (0..order.len())
                .find(|&at| of(at) >= label)
                .unwrap_or(order.len());
            let end = (first..order.len())
                .find(|&at| of(at) > label)
                .unwrap_or(order.len());
            let bounds = Bounds::around(&self.points[first..end]);
            self.parts.push(Part {
                name,
                bounds,
                vertices: first..end,
            });
        }
    }

    /// Around everything in the reference mesh.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(&self.points)
    }
}

/// Some corners spread over the faces of the bodies, or over all cells where these have none: enough to tell poses
/// apart.
pub fn landmarks(mesh: &Mesh, bodies: &[BodyRecord]) -> Vec<Corner> {
    let faces = faces_of(mesh, bodies);
    let n = if faces.is_empty() {
        mesh.cells.len()
    } else {
        faces.len()
    };
    let every = n.div_ceil(LANDMARKS).max(1);
    let cell = |at: usize| faces.get(at).map_or(at, |(cell, _)| *cell);
    let cells = (0..n).step_by(every).map(cell);
    let with_nodes = cells.filter(|&cell| !mesh.cells.get(cell).nodes.is_empty());
    with_nodes.map(|cell| Corner { cell, place: 0 }).collect()
}

/// Whether a part is seen at first: not where it lies around the bodies, or is large beside them.
pub fn is_near(part: &Part, bodies: &Bounds) -> bool {
    let holds = (0..3).all(|axis| {
        let extent = sub(bodies.high, bodies.low)[axis];
        part.bounds.low[axis] <= bodies.low[axis] + 0.1 * extent
            && part.bounds.high[axis] >= bodies.high[axis] - 0.1 * extent
    });
    !holds && part.bounds.diagonal() <= 2.5 * bodies.diagonal()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn body(tag: &str) -> BodyRecord {
        BodyRecord {
            name: format!("the {tag}"),
            tags: vec![tag.to_owned()],
            ..BodyRecord::default()
        }
    }

    #[test]
    fn a_wing_is_shown_with_every_triangle_and_what_lies_around_it_is_not_near() {
        let mesh = Mesh::read(Path::new("testdata/wing_on_plane.vtu")).expect("it is good");
        let shown = Surfaces::new(&mesh, &[body("wing")], TRIANGLES).expect("it has a wing");
        assert_eq!(
            (shown.bodies.triangles.len(), shown.bodies.n_given),
            (494, 494)
        );
        assert_eq!(shown.bodies.parts[0].name, "the wing");
        assert_eq!(shown.others.n_given, 396 + 348);
        let near: Vec<bool> = shown
            .others
            .parts
            .iter()
            .map(|part| is_near(part, &shown.bodies.bounds()))
            .collect();
        assert_eq!(near, [false, false]);
        for surface in [&shown.bodies, &shown.others] {
            let end = surface.parts.last().map(|part| part.vertices.end);
            assert_eq!(end, Some(surface.vertices.len()));
            for (corner, x) in surface.vertices.iter().zip(&surface.points) {
                assert_eq!(corner.place(&mesh), *x);
            }
        }
        let few = Surfaces::new(&mesh, &[body("wing")], 200).expect("it has a wing");
        assert!(few.bodies.triangles.len() <= 200);
        for x in &few.bodies.points {
            assert!(
                shown.bodies.points.contains(x),
                "corners are nodes of the mesh"
            );
        }
    }

    #[test]
    fn nothing_is_shown_in_space_of_a_plane_mesh_or_of_a_body_without_a_surface() {
        let plane = Mesh::read(Path::new("testdata/naca0012.vtu")).expect("it is good");
        assert!(Surfaces::new(&plane, &[body("airfoil")], 10).is_none());
        let wing = Mesh::read(Path::new("testdata/wing_on_plane.vtu")).expect("it is good");
        assert!(Surfaces::new(&wing, &[body("flap")], 10).is_none());
        assert!(!landmarks(&plane, &[body("airfoil")]).is_empty());
    }
}
