//! The surface of a morph: the roles of its nodes, the facets between them, and the displacements that moving nodes
//! prescribe at its points.

use super::options::{MorphOptions, Nodes};
use super::pairs::Pairs;
use crate::motion::{Role, Surface, SurfaceFaces, SurfaceNodes};
use crate::plan::checks::check_length;
use crate::plan::surface::SurfacePoints;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::transform::Matrix;
use azimesh_core::geometry::vector::{Vector, add, distance};
use azimesh_core::geometry::{Bounds, Transform};
use azimesh_io::mesh::sides::side;
use azimesh_io::mesh::{Boundary, Cells, Faces, Mesh};
use azimesh_rbf::constraint::Constraint;

/// Allowed difference of displacements at nodes that must move identically, as a part of the mesh's diagonal.
const ALIKE: f64 = 1e-9;
/// The role of every moving node.
const MOVING: Role = Role::Moving(0);

/// The surface points with their prescribed displacements.
#[derive(Debug, Clone)]
pub struct MorphSurface {
    /// Distinct positions of the surface nodes.
    pub points: SurfacePoints,
    /// The moving nodes, in the order of the displacements.
    pub moving: Vec<u32>,
    /// The point of each.
    pub point_of_moving: Vec<u32>,
    /// Nodes that stay.
    pub fixed: Vec<u32>,
    /// Nodes that slide, with the point of each.
    pub sliding: Vec<(u32, u32)>,
    /// The source of each moving point's displacement among the moving nodes.
    moved: Vec<MovedPoint>,
    /// True if the mesh is plane, and must stay in its plane.
    pub in_plane: bool,
    /// Diagonal of the mesh.
    pub diagonal: f64,
}

/// A moving point: its displacement is `turn` times the displacement in a row.
#[derive(Debug, Clone, Copy)]
struct MovedPoint {
    point: u32,
    row: u32,
    turn: Matrix,
}

impl MorphSurface {
    /// The surface of a mesh and its periodic pairs.
    pub fn new(mesh: &Mesh, options: &MorphOptions) -> Result<(Self, Pairs)> {
        let moving = options.moving.find("moving", mesh)?;
        if moving.is_empty() {
            return Err(Error::input("`moving` has no nodes, so nothing would move"));
        }
        let roles = roles(mesh, options, &moving)?;
        let (surface, bare) = surface(mesh, options, &roles)?;
        let mut boundary = Boundary::of(mesh);
        let nodes = &surface.nodes.nodes;
        let places: Vec<Vector> = nodes
            .iter()
            .map(|&node| mesh.points[node as usize])
            .collect();
        boundary.add_nodes(nodes, &places);
        let mut points = SurfacePoints::new(&boundary, &surface, Some(&bare))?;
        check_sliding(&points, &surface.nodes, mesh.space_dimension() == 2)?;
        add_lone_points(&mut points);
        let SurfaceNodes { nodes, roles } = surface.nodes;
        let pairs = Pairs::find(mesh, &options.periodic, &points, (&nodes, &roles))?;
        let point_of = |node: u32| {
            let at = nodes.binary_search(&node);
            points.point_of[at.expect("it is a surface node")]
        };
        let of_role = |wanted: Role| {
            let all = nodes.iter().zip(&roles).zip(&points.point_of);
            all.filter(move |((_, role), _)| **role == wanted)
                .map(|((&node, _), &point)| (node, point))
        };
        let moved = moved_points(mesh, &moving, &points, &pairs, point_of);
        let surface = Self {
            point_of_moving: moving.iter().map(|&node| point_of(node)).collect(),
            fixed: of_role(Role::Fixed).map(|(node, _)| node).collect(),
            sliding: of_role(Role::Sliding).collect(),
            moved,
            in_plane: mesh.space_dimension() == 2,
            diagonal: Bounds::around(&mesh.points).diagonal(),
            moving,
            points,
        };
        Ok((surface, pairs))
    }

    /// Returns the displacement of every surface point: as prescribed at moving points, zero elsewhere.
    ///
    /// # Errors
    /// A wrong number of displacements; one that is not finite or leaves the plane; different ones at nodes of one position
    /// or of a periodic pair.
    pub fn values(&self, displacements: &[Vector]) -> Result<Vec<Vector>> {
        self.check(displacements)?;
        let mut values = vec![[0.0; 3]; self.points.points.len()];
        for moved in &self.moved {
            values[moved.point as usize] =
                turned(&moved.turn, self.in_mesh(displacements[moved.row as usize]));
        }
        for ((d, &point), node) in displacements
            .iter()
            .zip(&self.point_of_moving)
            .zip(&self.moving)
        {
            if distance(self.in_mesh(*d), values[point as usize]) > ALIKE * self.diagonal {
                return Err(Error::input(format!(
                    "node {node} has the displacement {d:?}, but it must be {:?}, that of a node at the same \
                     place or of its periodic image",
                    values[point as usize]
                )));
            }
        }
        Ok(values)
    }

    /// Applies the transpose of [`values`](Self::values): from surface points to the moving nodes.
    pub fn pull_back(&self, at_points: &[Vector]) -> Vec<Vector> {
        let mut displacements = vec![[0.0; 3]; self.moving.len()];
        for moved in &self.moved {
            let back = Transform {
                rotation: moved.turn,
                ..Transform::IDENTITY
            };
            let value = back.inverse().turn(at_points[moved.point as usize]);
            let sum = &mut displacements[moved.row as usize];
            *sum = add(*sum, self.in_mesh(value));
        }
        displacements
    }

    /// Removes the component out of the plane of a plane mesh.
    pub fn in_mesh(&self, d: Vector) -> Vector {
        if self.in_plane { [d[0], d[1], 0.0] } else { d }
    }

    /// Returns the directions in which a surface point is held.
    pub fn constraint(&self, point: usize) -> Constraint {
        let sliding = self.points.sliding.as_ref();
        sliding.map_or(Constraint::ALL, |sliding| sliding.constraint(point))
    }

    /// Returns the moving nodes with the point of each.
    pub fn moving_points(&self) -> impl Iterator<Item = (u32, u32)> {
        let nodes = self.moving.iter().copied();
        nodes.zip(self.point_of_moving.iter().copied())
    }

    /// Returns all surface nodes.
    pub fn nodes(&self) -> impl Iterator<Item = u32> {
        let others = self
            .fixed
            .iter()
            .chain(self.sliding.iter().map(|(node, _)| node));
        self.moving.iter().chain(others).copied()
    }

    /// Returns whether the displacement of each surface point is given.
    pub fn is_moving(&self) -> Vec<bool> {
        self.points.body.iter().map(Option::is_some).collect()
    }

    fn check(&self, displacements: &[Vector]) -> Result<()> {
        check_length("displacement", displacements.len(), self.moving.len())?;
        for (d, node) in displacements.iter().zip(&self.moving) {
            check_finite("displacement", d, *node)?;
            if self.in_plane && d[2].abs() > ALIKE * self.diagonal {
                return Err(Error::input(format!(
                    "node {node} has the displacement {d:?}, which leaves the plane of the mesh; its third \
                     component must be 0"
                )));
            }
        }
        Ok(())
    }
}

/// # Errors
/// If a component is not a finite number.
pub fn check_finite(what: &str, value: &Vector, node: u32) -> Result<()> {
    if value.iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(Error::input(format!(
            "node {node} has the {what} {value:?}; its components must be finite numbers"
        )))
    }
}

fn turned(turn: &Matrix, d: Vector) -> Vector {
    let turn = Transform {
        rotation: *turn,
        ..Transform::IDENTITY
    };
    turn.turn(d)
}

/// Returns the role of every node of the mesh; `None` for nodes that are interpolated.
fn roles(mesh: &Mesh, options: &MorphOptions, moving: &[u32]) -> Result<Vec<Option<Role>>> {
    let mut roles = vec![None; mesh.points.len()];
    for &node in moving {
        roles[node as usize] = Some(MOVING);
    }
    let by_tags = |nodes: &Nodes| matches!(nodes, Nodes::Tags(_));
    let may_meet = by_tags(&options.moving) && by_tags(&options.fixed);
    for node in options.fixed.find("fixed", mesh)? {
        let role = &mut roles[node as usize];
        if role.is_some() && !may_meet {
            return Err(Error::input(format!(
                "node {node} is in `moving` and in `fixed`; remove it from one of them"
            )));
        }
        role.get_or_insert(Role::Fixed);
    }
    for node in options.slide.find("slide", mesh)? {
        roles[node as usize].get_or_insert(Role::Sliding);
    }
    Ok(roles)
}

/// Returns surface nodes and the faces between them, and faces that are not cells of the mesh.
fn surface(
    mesh: &Mesh,
    options: &MorphOptions,
    roles: &[Option<Role>],
) -> Result<(Surface, Cells)> {
    let with_role = roles.iter().zip(0..);
    let (nodes, known): (Vec<u32>, Vec<Role>) = with_role
        .filter_map(|(role, node)| Some((node, (*role)?)))
        .unzip();
    let mut surface = Surface {
        nodes: SurfaceNodes {
            nodes,
            roles: known,
        },
        faces: faces(mesh, roles),
        ..Surface::default()
    };
    mark_sliding(mesh, options, &mut surface.faces)?;
    let bare = bare_faces(mesh, roles, &surface);
    Ok((surface, bare))
}

/// Returns the boundary faces all of whose nodes have a role, with the first tag of each.
fn faces(mesh: &Mesh, roles: &[Option<Role>]) -> SurfaceFaces {
    let has_role = |node: &u32| roles[*node as usize].is_some();
    let dimension = mesh.dimension();
    let runs = mesh.cells.runs();
    let boundary = runs.filter(|run| run.kind.dimension() + 1 == dimension);
    let cells: Vec<u32> = boundary
        .flat_map(|run| {
            let cells = run.cells().enumerate();
            let known = cells.filter(|(_, nodes)| nodes.iter().all(has_role));
            known.map(move |(i, _)| (run.first_cell + i) as u32)
        })
        .collect();
    SurfaceFaces {
        roles: vec![Role::Fixed; cells.len()],
        tags: vec![u32::MAX; cells.len()],
        cells,
    }
}

/// Gives sliding faces their role and tag: faces of the tags, or faces between the nodes.
fn mark_sliding(mesh: &Mesh, options: &MorphOptions, faces: &mut SurfaceFaces) -> Result<()> {
    let listed = match &options.slide {
        Nodes::Tags(_) => None,
        Nodes::Numbers(numbers) => {
            let mut listed = vec![false; mesh.points.len()];
            for &node in numbers {
                listed[node as usize] = true;
            }
            Some(listed)
        }
    };
    let is_named = |tag: &str| match &options.slide {
        Nodes::Tags(tags) => tags.iter().any(|name| name == tag),
        Nodes::Numbers(_) => true,
    };
    let tags = || mesh.boundary_tags().zip(0..);
    for at in 0..faces.cells.len() {
        let cell = faces.cells[at] as usize;
        let mut of_cell = tags().filter(|(tag, _)| is_named(&tag.name) && tag.cells.contains(cell));
        let tag = of_cell.next().map(|(_, number)| number);
        let slides = match &listed {
            None => tag.is_some(),
            Some(listed) => {
                let nodes = mesh.cells.get(cell).nodes;
                nodes.iter().all(|&node| listed[node as usize])
            }
        };
        if slides {
            faces.roles[at] = Role::Sliding;
            faces.tags[at] = tag.unwrap_or(u32::MAX);
        }
    }
    Ok(())
}

/// Returns outer faces of cells between surface nodes that are on no boundary face.
fn bare_faces(mesh: &Mesh, roles: &[Option<Role>], surface: &Surface) -> Cells {
    let mut bare: Vec<bool> = roles.iter().map(Option::is_some).collect();
    for &cell in &surface.faces.cells {
        for &node in mesh.cells.get(cell as usize).nodes {
            bare[node as usize] = false;
        }
    }
    let mut found = Cells::new();
    if !bare.contains(&true) {
        return found;
    }
    let is_bare = |node: &u32| bare[*node as usize];
    let faces = Faces::of_cells(mesh, |cell| cell.nodes.iter().any(is_bare));
    for face in faces.bare() {
        let cell = mesh.cells.get(face.cell as usize);
        let Some((kind, nodes)) = side(&mesh.cells, &cell, face.face as usize) else {
            continue;
        };
        let has_role = |node: &u32| roles[*node as usize].is_some();
        if nodes.iter().all(has_role) && nodes.iter().any(is_bare) {
            found.push(kind, &nodes);
        }
    }
    found
}

/// # Errors
/// If nodes have nothing to slide on, or slide on a curved surface: that is not linear.
fn check_sliding(points: &SurfacePoints, nodes: &SurfaceNodes, in_plane: bool) -> Result<()> {
    let Some(sliding) = &points.sliding else {
        return Ok(());
    };
    let mut on_face = vec![false; points.points.len()];
    let is_face = |[_, b, c]: &&[u32; 3]| in_plane || b != c;
    for &corner in points
        .sliding_facets
        .corners
        .iter()
        .filter(is_face)
        .flatten()
    {
        on_face[corner as usize] = true;
    }
    let mut known = nodes.nodes.iter().zip(&nodes.roles).zip(&points.point_of);
    let stuck =
        known.find(|((_, role), point)| **role == Role::Sliding && !on_face[**point as usize]);
    if let Some(((node, _), _)) = stuck {
        return Err(Error::input(format!(
            "node {node} cannot slide: it is on no boundary face between sliding nodes"
        )));
    }
    match sliding.first_curved() {
        None => Ok(()),
        Some(point) => Err(Error::input(format!(
            "node {} slides on a curved boundary; a morph is linear in the displacements, so only planes and \
             straight edges can slide: fix the boundary or leave it free",
            points.nodes[point]
        ))),
    }
}

/// Creates facets for the points that have none.
fn add_lone_points(points: &mut SurfacePoints) {
    let mut lone = vec![true; points.points.len()];
    for &corner in points.facets.iter().flatten() {
        lone[corner as usize] = false;
    }
    let lone = (0..lone.len() as u32).filter(|&point| lone[point as usize]);
    points.facets.extend(lone.map(|point| [point; 3]));
}

/// Returns the source of every moving point's displacement: the lowest node at its position, or its leader, turned.
fn moved_points(
    mesh: &Mesh,
    moving: &[u32],
    points: &SurfacePoints,
    pairs: &Pairs,
    point_of: impl Fn(u32) -> u32,
) -> Vec<MovedPoint> {
    let mut row_of = vec![u32::MAX; mesh.points.len()];
    for (&node, row) in moving.iter().zip(0..) {
        row_of[node as usize] = row;
    }
    let moved = points.nodes.iter().zip(&points.body).zip(0..);
    moved
        .filter(|((_, body), _)| body.is_some())
        .map(|((&node, _), point)| {
            let (leader, turn) = pairs.leader(node);
            let source = points.nodes[point_of(leader) as usize];
            MovedPoint {
                point,
                row: row_of[source as usize],
                turn,
            }
        })
        .collect()
}
