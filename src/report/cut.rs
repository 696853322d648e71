//! A mesh in a plane: the cells that a plane cuts, or the cells of a plane mesh, as polygons in the
//! coordinates of the plane.

use super::section::{Crossed, Scratch};
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add, dot, scale, sub};
use azimesh_core::parallel;
use azimesh_io::mesh::{CellRef, Mesh};
use std::ops::Range;

/// Cells looked at by one thread at a time.
const CHUNK: usize = 1 << 14;

/// Coordinates in a plane.
pub type Flat = [f64; 2];

/// A plane with axes in it.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// A point of it.
    pub origin: Vector,
    /// Unit normal.
    pub normal: Vector,
    /// Unit vector to the right.
    pub right: Vector,
    /// Unit vector upward.
    pub up: Vector,
}

/// A rectangle of the plane.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// Its middle.
    pub centre: Flat,
    /// Half of its width and of its height.
    pub half: Flat,
}

/// A cell, or the part of it, that is in the plane.
#[derive(Debug, Clone)]
pub struct Piece {
    /// The cell.
    pub cell: usize,
    /// Corners in order.
    pub corners: Vec<Flat>,
}

impl Piece {
    /// Returns the mean of its corners.
    pub fn centre(&self) -> Flat {
        let n = self.corners.len() as f64;
        [0, 1].map(|axis| self.corners.iter().map(|corner| corner[axis]).sum::<f64>() / n)
    }
}

impl Plane {
    /// Returns the distance of a point along the normal.
    pub fn height(&self, x: Vector) -> f64 {
        dot(sub(x, self.origin), self.normal)
    }

    /// Coordinates of a point's foot in the plane.
    pub fn flat(&self, x: Vector) -> Flat {
        let arm = sub(x, self.origin);
        [dot(arm, self.right), dot(arm, self.up)]
    }

    /// Coordinates in the plane and along its normal.
    pub fn place(&self, x: Vector) -> Vector {
        let [right, up] = self.flat(x);
        [right, up, self.height(x)]
    }

    /// The plane turned with everything else.
    pub fn carried(&self, by: &Transform) -> Self {
        Self {
            origin: by.apply(self.origin),
            normal: by.turn(self.normal),
            right: by.turn(self.right),
            up: by.turn(self.up),
        }
    }
}

impl Window {
    /// Returns the place a little inside of it that is nearest to a point.
    pub fn nearest(&self, x: Flat) -> Flat {
        [0, 1].map(|axis| {
            let (middle, half) = (self.centre[axis], 0.97 * self.half[axis]);
            x[axis].max(middle - half).min(middle + half)
        })
    }

    /// Tests if the box around some corners reaches into it.
    pub fn holds(&self, corners: &[Flat]) -> bool {
        (0..2).all(|axis| {
            let along = || {
                corners
                    .iter()
                    .map(|corner| corner[axis] - self.centre[axis])
            };
            along().fold(f64::INFINITY, f64::min) <= self.half[axis]
                && along().fold(f64::NEG_INFINITY, f64::max) >= -self.half[axis]
        })
    }
}

/// A mesh with the distances of its nodes to a plane; without them where it is plane itself.
pub struct Cut<'a> {
    mesh: &'a Mesh,
    plane: Plane,
    height: Option<Vec<f64>>,
}

impl<'a> Cut<'a> {
    /// Measures the distances of all nodes.
    pub fn new(mesh: &'a Mesh, plane: Plane) -> Self {
        let is_solid = mesh.dimension() == 3;
        let height = is_solid
            .then(|| parallel::collect(mesh.points.len(), |i| plane.height(mesh.points[i])));
        Self {
            mesh,
            plane,
            height,
        }
    }

    /// The volume cells in the plane that reach into a window, in the order of the cells.
    pub fn pieces(&self, window: &Window) -> Vec<Piece> {
        let n_cells = self.mesh.cells.len();
        let pieces = |range| self.pieces_of(range, window);
        let blocks = parallel::map_blocks(n_cells, CHUNK, &pieces);
        blocks.into_iter().flatten().collect()
    }

    /// The volume cells that the plane cuts, or would cut if it were shifted by up to `margin`; all cells of a plane mesh.
    pub fn cells(&self, margin: f64) -> Vec<usize> {
        let is_near = |nodes: &[u32]| {
            self.height.as_ref().is_none_or(|height| {
                let heights = || nodes.iter().map(|&node| height[node as usize]);
                heights().any(|x| x <= margin) && heights().any(|x| x >= -margin)
            })
        };
        let dimension = self.mesh.dimension();
        let near = |cells: Range<usize>| {
            let runs = self.mesh.cells.runs_in(cells);
            let runs = runs.filter(|run| run.kind.dimension() == dimension);
            let cells =
                runs.flat_map(|run| (run.first_cell..).zip(run.cells()).collect::<Vec<_>>());
            let near = cells.filter(|(_, nodes)| is_near(nodes));
            near.map(|(cell, _)| cell).collect::<Vec<_>>()
        };
        parallel::map_blocks(self.mesh.cells.len(), CHUNK, &near).concat()
    }

    fn pieces_of(&self, cells: Range<usize>, window: &Window) -> Vec<Piece> {
        let mut scratch = Scratch::default();
        let mut found = Vec::new();
        let dimension = self.mesh.dimension();
        let runs = self.mesh.cells.runs_in(cells);
        for run in runs.filter(|run| run.kind.dimension() == dimension) {
            let n_corners = run.kind.n_corners(run.n_nodes);
            for (index, nodes) in (run.first_cell..).zip(run.cells()) {
                let Some(height) = &self.height else {
                    let corners = nodes[..n_corners]
                        .iter()
                        .map(|&node| self.flat(node))
                        .collect();
                    keep(&mut found, index, corners, window);
                    continue;
                };
                let is_up = |node: &u32| height[*node as usize] >= 0.0;
                if nodes.iter().all(is_up) || !nodes.iter().any(is_up) {
                    continue;
                }
                let cell = CellRef {
                    index,
                    kind: run.kind,
                    nodes,
                };
                scratch.polygons(&self.mesh.cells, &cell, height, |edges| {
                    let corners = edges
                        .iter()
                        .map(|edge| self.crossing(*edge, height))
                        .collect();
                    keep(&mut found, index, corners, window);
                });
            }
        }
        found
    }

    /// Segments of the boundary tags of these names in the plane.
    pub fn outline(&self, tags: &[String]) -> Vec<[Flat; 2]> {
        let mut scratch = Scratch::default();
        let mut segments = Vec::new();
        let named = |name: &String| tags.contains(name);
        for tag in self.mesh.boundary_tags().filter(|tag| named(&tag.name)) {
            for face in tag.cells.iter().map(|cell| self.mesh.cells.get(cell)) {
                let corners = &face.nodes[..face.kind.n_corners(face.nodes.len())];
                match &self.height {
                    None if corners.len() >= 2 => {
                        segments.push([self.flat(corners[0]), self.flat(corners[1])]);
                    }
                    None => {}
                    Some(height) => {
                        let cut = scratch.segments(corners, height).iter();
                        segments
                            .extend(cut.map(|ends| ends.map(|edge| self.crossing(edge, height))));
                    }
                }
            }
        }
        segments
    }

    fn flat(&self, node: u32) -> Flat {
        self.plane.flat(self.mesh.points[node as usize])
    }

    /// Returns the point at which an edge crosses the plane; the same in every cell that has the edge.
    fn crossing(&self, (a, b): Crossed, height: &[f64]) -> Flat {
        let [a, b] = [a as usize, b as usize];
        let part = height[a] / (height[a] - height[b]);
        let (from, to) = (self.mesh.points[a], self.mesh.points[b]);
        self.plane.flat(add(from, scale(sub(to, from), part)))
    }
}

fn keep(found: &mut Vec<Piece>, cell: usize, corners: Vec<Flat>, window: &Window) {
    if corners.len() > 2 && window.holds(&corners) {
        found.push(Piece { cell, corners });
    }
}
