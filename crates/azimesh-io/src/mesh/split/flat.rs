//! The parts of a polygon: a cell of a plane mesh, or a boundary face.

use super::inside::{Plane, inner_point};
use super::nodes::{FaceNodes, corners};
use super::{MIDDLE, Parts};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub, unit};

/// Parts of a polygon of a plane mesh: a triangle or quadrilateral where it has so many corners, else triangles
/// around a new node.
pub(super) fn split(nodes: &[u32], points: &[Vector]) -> Parts {
    let corners = corners(nodes);
    let (place, is_inside) = middle(&corners, points);
    let mut parts = around(&corners, MIDDLE);
    if corners.len() > 4 {
        parts.middle = Some(place);
        parts.is_positive = is_inside;
    } else {
        parts.is_positive = is_convex(&corners, points);
    }
    parts
}

/// Parts of a polygon on the boundary of a solid mesh: the parts of the cell's face behind it.
pub(super) fn split_face(nodes: &[u32], faces: &FaceNodes) -> Parts {
    let corners = corners(nodes);
    let middle = faces.get(&corners).unwrap_or(MIDDLE);
    around(&corners, middle)
}

fn around(corners: &[u32], middle: u32) -> Parts {
    let mut parts = Parts {
        is_positive: true,
        ..Parts::default()
    };
    match corners.len() {
        3 => parts.simplices = corners.to_vec(),
        4 => parts.others = corners.to_vec(),
        0..3 => {}
        _ => parts.simplices = fan(corners, middle).as_flattened().to_vec(),
    }
    parts
}

/// Triangles between the edges of a polygon and a node in its middle, turning as it does.
pub(super) fn fan(corners: &[u32], middle: u32) -> Vec<[u32; 3]> {
    let next = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(next);
    edges.map(|(&a, &b)| [a, b, middle]).collect()
}

/// Middle of a polygon, and whether it sees all edges from within: the mean of the corners, else a point that does.
/// Except for round-off, the first corner and the direction of the polygon do not matter.
pub(super) fn middle(corners: &[u32], points: &[Vector]) -> (Vector, bool) {
    let at: Vec<Vector> = corners.iter().map(|&node| points[node as usize]).collect();
    let mean = mean(&at);
    let area = area(&at, mean);
    let size = at.iter().map(|&x| norm(sub(x, mean))).fold(0.0, f64::max);
    let edges = at.iter().zip(at.iter().cycle().skip(1));
    let line = |(&a, &b): (&Vector, &Vector)| {
        Some(Plane {
            at: a,
            inward: unit(cross(area, sub(b, a)))?,
        })
    };
    let Some(lines) = edges.map(line).collect::<Option<Vec<Plane>>>() else {
        return (mean, false);
    };
    inner_point(&lines, &[mean], size)
}

/// Mean of some places, the same in whatever order they are but for round-off.
pub(super) fn mean(at: &[Vector]) -> Vector {
    let Some(&origin) = at.first() else {
        return [0.0; 3];
    };
    let sum = at.iter().fold([0.0; 3], |sum, &x| add(sum, sub(x, origin)));
    add(origin, scale(sum, 1.0 / at.len() as f64))
}

/// Area times normal.
fn area(at: &[Vector], mean: Vector) -> Vector {
    let edges = at.iter().zip(at.iter().cycle().skip(1));
    let twice = edges.fold([0.0; 3], |sum, (&a, &b)| {
        add(sum, cross(sub(a, mean), sub(b, mean)))
    });
    scale(twice, 0.5)
}

/// Returns whether all corners turn one way.
fn is_convex(corners: &[u32], points: &[Vector]) -> bool {
    let at: Vec<Vector> = corners.iter().map(|&node| points[node as usize]).collect();
    let n = at.len();
    let area = area(&at, mean(&at));
    let turn = |i: usize| {
        let (before, here, after) = (at[(i + n - 1) % n], at[i], at[(i + 1) % n]);
        dot(cross(sub(here, before), sub(after, here)), area)
    };
    n >= 3 && (0..n).all(|i| turn(i) > 0.0)
}
