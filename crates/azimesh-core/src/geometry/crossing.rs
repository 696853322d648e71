//! Facets that cut through each other.

use super::vector::{Vector, cross, dot, sub};

/// Checks if two triangles cut through each other: an edge of one passes through the inside of the other.
/// Triangles that touch, or that are in one plane, do not.
pub fn triangles_cross(a: &[Vector; 3], b: &[Vector; 3]) -> bool {
    let edges = |t: &[Vector; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(a).iter().any(|edge| pierces(edge, b)) || edges(b).iter().any(|edge| pierces(edge, a))
}

/// Checks if two segments in the plane of x and y cross at a point inside both.
pub fn segments_cross(a: &[Vector; 2], b: &[Vector; 2]) -> bool {
    let side = |s: &[Vector; 2], p: Vector| {
        let (along, off) = (sub(s[1], s[0]), sub(p, s[0]));
        along[0] * off[1] - along[1] * off[0]
    };
    let apart = |s: &[Vector; 2], t: &[Vector; 2]| side(s, t[0]) * side(s, t[1]) < 0.0;
    apart(a, b) && apart(b, a)
}

/// Checks if a segment passes through the inside of a triangle.
fn pierces(segment: &[Vector; 2], triangle: &[Vector; 3]) -> bool {
    let [a, b, c] = *triangle;
    let normal = cross(sub(b, a), sub(c, a));
    let heights = segment.map(|p| dot(normal, sub(p, a)));
    if heights[0] * heights[1] >= 0.0 {
        return false;
    }
    // Signed volumes with the three edges have one sign inside.
    let along = sub(segment[1], segment[0]);
    let volume = |p: Vector, q: Vector| dot(along, cross(sub(p, segment[0]), sub(q, segment[0])));
    let volumes = [volume(a, b), volume(b, c), volume(c, a)];
    volumes.iter().all(|v| *v > 0.0) || volumes.iter().all(|v| *v < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: [Vector; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn upright(x: f64, low: f64) -> [Vector; 3] {
        [[x, 0.2, low], [x, 0.3, low], [x, 0.25, low + 1.0]]
    }

    #[test]
    fn triangles_cross_where_an_edge_passes_through() {
        assert!(triangles_cross(&FLAT, &upright(0.2, -0.5)));
        assert!(triangles_cross(&upright(0.2, -0.5), &FLAT));
        let [a, b, c] = FLAT;
        assert!(triangles_cross(&[a, c, b], &upright(0.2, -0.5)));
        for (x, low) in [(0.2, 0.1), (0.2, -2.0), (0.9, -0.5), (0.2, 0.0)] {
            assert!(!triangles_cross(&FLAT, &upright(x, low)), "{x} {low}");
        }
        let moved = FLAT.map(|[x, y, z]| [x + 0.1, y + 0.1, z]);
        assert!(!triangles_cross(&FLAT, &moved), "they are in one plane");
    }

    #[test]
    fn segments_cross_inside_both() {
        let a = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        assert!(segments_cross(&a, &[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]));
        assert!(!segments_cross(&a, &[[0.0, 1.0, 0.0], [0.4, 0.6, 0.0]]));
        assert!(!segments_cross(&a, &[[1.0, 1.0, 0.0], [2.0, 0.0, 0.0]]));
    }
}
