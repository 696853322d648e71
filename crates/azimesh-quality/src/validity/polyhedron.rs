//! Polyhedra, and prisms on five or six corners: cut into tetrahedra of edge, face mean and cell mean.

use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, sub};
use azimesh_io::mesh::{CellRef, Cells};

/// The least and the largest of six times the volumes of the tetrahedra, positive where faces are listed outward.
/// A triangular face makes one of them. No faces give zeros.
pub fn least_tetrahedron(cells: &Cells, cell: &CellRef<'_>, points: &[Vector]) -> (f64, f64) {
    let centre = mean(cell.nodes.iter().copied(), points);
    let at = |node: u32| sub(points[node as usize], centre);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut add_face = |face: &[u32]| {
        let n = face.len();
        let middle = sub(mean(face.iter().copied(), points), centre);
        let mut include = |a: Vector, b: Vector, c: Vector| {
            let volume = dot(a, cross(b, c));
            least = if volume < least || volume.is_nan() {
                volume
            } else {
                least
            };
            most = if volume > most { volume } else { most };
        };
        if n == 3 {
            return include(at(face[0]), at(face[1]), at(face[2]));
        }
        for i in 0..n {
            include(middle, at(face[i]), at(face[(i + 1) % n]));
        }
    };
    for_each_face(cells, cell, &mut add_face);
    if least <= most {
        (least, most)
    } else {
        (0.0, 0.0)
    }
}

/// Calls `visit` with the corners of each face of a polyhedron or a prism.
fn for_each_face(cells: &Cells, cell: &CellRef<'_>, visit: &mut dyn FnMut(&[u32])) {
    for face in cells.polyhedron_faces(cell.index) {
        visit(face);
    }
    for corners in cell.kind.faces() {
        let mut nodes = [0; 8];
        for (node, &corner) in nodes.iter_mut().zip(*corners) {
            *node = cell.nodes[usize::from(corner)];
        }
        visit(&nodes[..corners.len()]);
    }
}

fn mean(nodes: impl ExactSizeIterator<Item = u32>, points: &[Vector]) -> Vector {
    let n = nodes.len().max(1) as f64;
    let sum = nodes.fold([0.0; 3], |sum, node| add(sum, points[node as usize]));
    scale(sum, 1.0 / n)
}
