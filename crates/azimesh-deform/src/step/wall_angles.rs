//! The angle between moving walls and their first cells, compared with the reference mesh.

use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};
use azimesh_core::parallel::{self, BLOCK};
use azimesh_io::mesh::sides::for_each_side;
use azimesh_io::mesh::{Across, Adjacency, CellRef, Mesh};

/// Faces of moving walls and the cells on them.
#[derive(Debug, Clone, Default)]
pub struct WallAngles {
    /// Boundary face and its cell.
    faces: Vec<(u32, u32)>,
}

impl WallAngles {
    /// Finds the own cells on the boundary faces `moving`, ascending.
    pub fn find(mesh: &Mesh, adjacency: &Adjacency, moving: &[u32]) -> Self {
        let dimension = mesh.dimension();
        let of_chunk = |chunk: usize| {
            let mut found = Vec::new();
            let (cells, mut sides) = adjacency.chunk(chunk);
            for run in mesh.cells.runs_in(cells) {
                if run.kind.dimension() != dimension {
                    continue;
                }
                for cell in run.cell_refs() {
                    for_each_side(&mesh.cells, &cell, |_, _| {
                        if let Across::Outside(Some(face)) = sides.across()
                            && moving.binary_search(&face).is_ok()
                        {
                            found.push((face, cell.index as u32));
                        }
                    });
                }
            }
            found
        };
        let own = adjacency.own_chunks();
        Self {
            faces: parallel::map(own.len(), &|i| of_chunk(own.start + i)).concat(),
        }
    }

    /// Returns the largest change of the angle between the wall's normal and the line from the wall to the first cell, in
    /// degrees; `None` without faces.
    ///
    /// ```text
    /// d = mean of the cell's corners - mean of the face's corners,   theta = angle between d and n
    /// change = max over faces of |theta - theta_reference|
    /// ```
    ///
    /// `n` is the normal of the deformed face, on the side of the cell in the reference mesh.
    pub fn largest_change(
        &self,
        mesh: &Mesh,
        points: &[Vector],
        reference: &[Vector],
    ) -> Option<f64> {
        let change = |&(face, cell): &(u32, u32)| {
            let [face, listed] = [face, cell].map(|index| mesh.cells.get(index as usize));
            let one = listed.uncollapsed();
            let cell = one.as_ref().map_or(listed, |one| one.get(0));
            let (now, before) = (lean(&face, &cell, points), lean(&face, &cell, reference));
            let side = 1f64.copysign(before.along);
            (now.angle(side) - before.angle(side)).abs().to_degrees()
        };
        let largest = parallel::map_blocks(self.faces.len(), BLOCK, &|range| {
            let changes = self.faces[range].iter().map(change);
            changes.max_by(f64::total_cmp)
        });
        largest.into_iter().flatten().max_by(f64::total_cmp)
    }
}

/// Components of the line along the normal and across it, times the face's area.
struct Lean {
    along: f64,
    across: f64,
}

impl Lean {
    fn angle(&self, side: f64) -> f64 {
        self.across.atan2(side * self.along)
    }
}

fn lean(face: &CellRef<'_>, cell: &CellRef<'_>, points: &[Vector]) -> Lean {
    let [on_wall, in_cell] = [face, cell].map(|of| {
        let n_corners = of.kind.n_corners(of.nodes.len());
        move |i: usize| points[of.nodes[i % n_corners] as usize]
    });
    let n_wall = face.kind.n_corners(face.nodes.len());
    let n_cell = cell.kind.n_corners(cell.nodes.len());
    let normal = match n_wall {
        2 => cross(vector_area(n_cell, in_cell), sub(on_wall(1), on_wall(0))),
        _ => vector_area(n_wall, on_wall),
    };
    let line = sub(mean(n_cell, in_cell), mean(n_wall, on_wall));
    Lean {
        along: dot(normal, line),
        across: norm(cross(normal, line)),
    }
}

fn mean(n: usize, point: impl Fn(usize) -> Vector) -> Vector {
    let sum = (0..n).fold([0.0; 3], |sum, i| add(sum, point(i)));
    scale(sum, 1.0 / n as f64)
}

/// Returns twice the vector area, computed from the first corner.
fn vector_area(n: usize, corner: impl Fn(usize) -> Vector) -> Vector {
    let from = |i: usize| sub(corner(i), corner(0));
    (1..n.saturating_sub(1)).fold([0.0; 3], |sum, i| add(sum, cross(from(i), from(i + 1))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_io::mesh::CellKind;

    /// A hexahedron on the wall z = 0, whose face is cell 1.
    fn on_wall() -> Mesh {
        let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        let at = |z: f64| corners.map(|[x, y]| [x, y, z]);
        let mut mesh = Mesh {
            points: [at(0.0), at(0.1)].concat(),
            ..Mesh::default()
        };
        mesh.cells
            .push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
        mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 2, 3]);
        mesh
    }

    #[test]
    fn a_sheared_first_cell_leans_by_the_angle_of_its_edges_however_the_wall_turns() {
        let mesh = on_wall();
        let walls = WallAngles::find(&mesh, &Adjacency::of(&mesh), &[1]);
        let change = |points: &[Vector]| walls.largest_change(&mesh, points, &mesh.points);
        assert_eq!(change(&mesh.points), Some(0.0));
        let sheared = |[x, y, z]: Vector| [x + z, y, z];
        let turned = |[x, y, z]: Vector| [-z + 3.0, y, x];
        let points: Vec<Vector> = mesh.points.iter().map(|&p| turned(sheared(p))).collect();
        assert!((change(&points).expect("it has a wall") - 45.0).abs() < 1e-12);
        let through = |[x, y, z]: Vector| [x, y, -z];
        let points: Vec<Vector> = mesh.points.iter().map(|&p| through(p)).collect();
        assert!((change(&points).expect("it has a wall") - 180.0).abs() < 1e-12);
        let none = WallAngles::find(&mesh, &Adjacency::of(&mesh), &[]);
        assert_eq!(none.largest_change(&mesh, &points, &points), None);
    }

    #[test]
    fn an_edge_is_a_wall_in_the_plane() {
        let mut mesh = Mesh {
            points: vec![[0., 0., 0.], [1., 0., 0.], [0.5, 1., 0.]],
            ..Mesh::default()
        };
        mesh.cells.push(CellKind::Line, &[1, 0]);
        mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
        let walls = WallAngles::find(&mesh, &Adjacency::of(&mesh), &[0]);
        let mut points = mesh.points.clone();
        points[2] = [1.5, 1.0, 0.0];
        let change = walls.largest_change(&mesh, &points, &mesh.points);
        assert!((change.expect("it has a wall") - 45.0).abs() < 1e-12);
    }
}
