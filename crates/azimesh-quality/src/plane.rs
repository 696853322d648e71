//! Triangles, quadrilaterals and polygons, seen along a given direction.

use super::angles::{Angles, Edge, Patch, signed_root};
use super::metrics::{Knupp, Metrics};
use super::span::{Span, greater};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};

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
/// ```text
/// area = |n| / 2, n = L0 x L1
/// scaled Jacobian = 2 / sqrt(3) |n| / max(|L0||L1|, |L1||L2|, |L2||L0|), 0 to 1
/// ```
///
/// Both with the sign of `n . facing`.
#[inline(always)]
pub(super) fn triangle(p: &[Vector; 3], facing: Vector) -> Metrics {
    let edges = [
        Edge::between(p[0], p[1]),
        Edge::between(p[1], p[2]),
        Edge::between(p[2], p[0]),
    ];
    let normal = cross(edges[0].along, edges[1].along);
    let along = dot(normal, facing);
    let jacobian = norm(normal);
    let squares = [edges[0].square, edges[1].square, edges[2].square];
    let mut angles = Angles::NONE;
    angles.add_triangle(edges);
    let alpha = jacobian.copysign(along);
    let skew = 2.0 * 3f64.sqrt() * jacobian / (squares[0] + squares[1] + squares[2]);
    Metrics {
        volume: 0.5 * alpha,
        corner: Span::at(along),
        scaled: facing_span(triangle_scaled(jacobian, squares), along),
        edge: Span::of_array(squares),
        angles,
        knupp: Knupp::new(alpha, Span::at(alpha), skew),
    }
}

#[inline(always)]
fn triangle_scaled(jacobian: f64, squares: [f64; 3]) -> f64 {
    let [a, b, c] = squares;
    let longest = greater(a * b, greater(b * c, c * a)).sqrt();
    ratio(TWO_OVER_SQRT_3 * jacobian, longest)
}

/// A quadrilateral with edges `L` and unit normal `m` of `(L0 - L2) x (L1 - L3)`.
///
/// ```text
/// a_i = m . (L_(i-1) x L_i)
/// area = (a_0 + a_1 + a_2 + a_3) / 4
/// scaled Jacobian = min over i of a_i / (|L_(i-1)| |L_i|), -1 to 1
/// ```
///
/// The area has the sign of `m . facing`; a cell that faces the other way has minus the magnitude
/// of its scaled Jacobian. With the last two corners in one place it is a triangle, as in Verdict.
#[inline(always)]
pub(super) fn quadrilateral(p: &[Vector; 4], facing: Vector) -> Metrics {
    let patch = Patch {
        a: [Edge::between(p[0], p[1]), Edge::between(p[3], p[2])],
        b: [Edge::between(p[0], p[3]), Edge::between(p[1], p[2])],
    };
    let normals = patch.normals();
    let across = add(add(normals[0], normals[2]), add(normals[1], normals[3]));
    let length = norm(across);
    let along = dot(across, facing);
    let (a, b) = (patch.a, patch.b);
    let inverse_squares = [
        a[0].inverse * b[0].inverse,
        a[0].inverse * b[1].inverse,
        a[1].inverse * b[1].inverse,
        a[1].inverse * b[0].inverse,
    ];
    let (mut area, mut corner, mut scaled) = (0.0, Span::EMPTY, Span::EMPTY);
    let (mut parts, mut badness) = (Span::EMPTY, 0.0);
    let shrink = ratio(1.0, length);
    for i in 0..4 {
        let part = dot(normals[i], across) * shrink;
        area += part;
        parts.include(part);
        corner.include(dot(normals[i], facing));
        let square = or_zero(part * (part.abs() * inverse_squares[i]));
        scaled.include(square);
        badness += 1.0 / square.abs().sqrt();
    }
    let as_triangle = triangle_scaled(norm(normals[1]), [a[0].square, b[1].square, b[0].square]);
    let quality = if patch.is_triangle() {
        as_triangle
    } else {
        signed_root(scaled.low)
    };
    let mut angles = Angles::NONE;
    angles.add_quadrilateral(&patch, &normals);
    Metrics {
        volume: (0.25 * area).copysign(along),
        corner,
        scaled: facing_span(quality, along),
        edge: Span::of_array([a[0].square, b[1].square, a[1].square, b[0].square]),
        angles,
        knupp: Knupp::new(area.copysign(along), parts, 4.0 / badness),
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
        corner: Span::at(along),
        scaled: Span::UNDEFINED,
        edge: Span::of(squares),
        angles: Angles::NONE,
        knupp: Knupp::UNDEFINED,
    }
}

/// `quality` for the orientation that `along` has, minus its magnitude for the other.
#[inline(always)]
fn facing_span(quality: f64, along: f64) -> Span {
    let (upright, size) = (along > 0.0, quality.abs());
    Span {
        low: if upright { quality } else { -size },
        high: if upright { size } else { -quality },
    }
}

/// `a / b`, and 0 where `b` vanishes.
#[inline(always)]
pub(super) fn ratio(a: f64, b: f64) -> f64 {
    let quotient = a / b;
    if b > 0.0 { quotient } else { 0.0 }
}

/// `a`, and 0 where an edge of no length has made it not a number.
#[inline(always)]
pub(super) fn or_zero(a: f64) -> f64 {
    if a.is_nan() { 0.0 } else { a }
}
