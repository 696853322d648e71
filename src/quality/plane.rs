//! Triangles, quadrilaterals and polygons, seen along a given direction.

use super::angles::Angles;
use super::metrics::{Metrics, Span};
use crate::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};

/// `2 / sqrt(3)`: makes the equilateral triangle's scaled Jacobian one.
const TWO_OVER_SQRT_3: f64 = 1.154_700_538_379_251_7;

/// Vector area: half the sum of `p_i x p_(i+1)`, taken from the first corner.
#[inline]
pub(super) fn vector_area(n: usize, corner: impl Fn(usize) -> Vector) -> Vector {
    let first = corner(0);
    let mut sum = [0.0; 3];
    for i in 1..n.saturating_sub(1) {
        let wedge = cross(sub(corner(i), first), sub(corner(i + 1), first));
        sum = add(sum, wedge);
    }
    scale(sum, 0.5)
}

/// A triangle with edges `L`.
///
///     area = |n| / 2, n = L0 x L1
///     scaled Jacobian = 2 / sqrt(3) |n| / max(|L0||L1|, |L1||L2|, |L2||L0|), 0 to 1
///
/// Both with the sign of `n . facing`.
#[inline]
pub(super) fn triangle(p: &[Vector; 3], facing: Vector) -> Metrics {
    let edges = [sub(p[1], p[0]), sub(p[2], p[1]), sub(p[0], p[2])];
    let squares = edges.map(|e| dot(e, e));
    let normal = cross(edges[0], edges[1]);
    let along = dot(normal, facing);
    let jacobian = norm(normal);
    let longest = (squares[0] * squares[1])
        .max(squares[1] * squares[2])
        .max(squares[2] * squares[0])
        .sqrt();
    let quality = ratio(TWO_OVER_SQRT_3 * jacobian, longest);
    let mut angles = Angles::NONE;
    angles.add_triangle(*p);
    Metrics {
        volume: (0.5 * jacobian).copysign(along),
        corner: Span {
            low: along,
            high: along,
        },
        scaled: facing_span(quality, along),
        edge: Span::of(squares),
        angles,
    }
}

/// A quadrilateral with edges `L` and unit normal `m` of `(L0 - L2) x (L1 - L3)`.
///
///     a_i = m . (L_(i-1) x L_i)
///     area = (a_0 + a_1 + a_2 + a_3) / 4
///     scaled Jacobian = min over i of a_i / (|L_(i-1)| |L_i|), -1 to 1
///
/// The area has the sign of `m . facing`; a cell that faces the other way has minus the magnitude
/// of its scaled Jacobian. With the last two corners in one place it is a triangle, as in Verdict.
#[inline]
pub(super) fn quadrilateral(p: &[Vector; 4], facing: Vector) -> Metrics {
    let edges: [Vector; 4] = std::array::from_fn(|i| sub(p[(i + 1) % 4], p[i]));
    let squares = edges.map(|e| dot(e, e));
    let across = cross(sub(edges[0], edges[2]), sub(edges[1], edges[3]));
    let length = norm(across);
    let normals: [Vector; 4] = std::array::from_fn(|i| cross(edges[(i + 3) % 4], edges[i]));
    let areas = normals.map(|n| ratio(dot(n, across), length));
    let along = dot(across, facing);
    let quality = if p[2] == p[3] {
        triangle(&[p[0], p[1], p[2]], facing).scaled.high.abs()
    } else {
        Span::of((0..4).map(|i| ratio(areas[i], (squares[(i + 3) % 4] * squares[i]).sqrt()))).low
    };
    let mut angles = Angles::NONE;
    angles.add_quadrilateral(*p);
    Metrics {
        volume: (0.25 * areas.iter().sum::<f64>()).copysign(along),
        corner: Span::of(normals.map(|n| dot(n, facing))),
        scaled: facing_span(quality, along),
        edge: Span::of(squares),
        angles,
    }
}

/// A polygon: its area with the sign of its vector area along `facing`, and its edges. Other
/// metrics are not defined.
pub(super) fn polygon(n: usize, corner: impl Fn(usize) -> Vector, facing: Vector) -> Metrics {
    let area = vector_area(n, &corner);
    let along = dot(area, facing);
    let squares = (0..n).map(|i| {
        let edge = sub(corner((i + 1) % n), corner(i));
        dot(edge, edge)
    });
    Metrics {
        volume: norm(area).copysign(along),
        corner: Span {
            low: along,
            high: along,
        },
        scaled: Span::UNDEFINED,
        edge: Span::of(squares),
        angles: Angles::NONE,
    }
}

/// `quality` for the orientation that `along` has, minus its magnitude for the other.
#[inline]
fn facing_span(quality: f64, along: f64) -> Span {
    if along > 0.0 {
        Span {
            low: quality,
            high: quality.abs(),
        }
    } else {
        Span {
            low: -quality.abs(),
            high: -quality,
        }
    }
}

/// `a / b`, and 0 where `b` vanishes.
#[inline]
pub(super) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
