//! Triangles and quadrilaterals. A cell that has turned over against the reference has a negative
//! Jacobian, no condition and no shape, as a solid cell.

use super::{Detail, over};
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, sub, unit};
use std::array::from_fn;

const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// A triangle with edges `L`, `n = L0 x L1`.
///
/// ```text
/// jacobian     |n|
/// aspect ratio sqrt(3) / 6 max |L| (|L0| + |L1| + |L2|) / |n|
/// condition    (|L0|^2 + |L2|^2 + L0 . L2) / (sqrt(3) |n|)
/// shape        1 / condition
/// ```
pub(super) fn triangle(p: &[Vector; 3], facing: Vector) -> Detail {
    let [ab, ac, bc] = [sub(p[1], p[0]), sub(p[2], p[0]), sub(p[2], p[1])];
    let normal = cross(ab, ac);
    let along = dot(normal, facing);
    let jacobian = norm(normal);
    let lengths = [norm(ab), norm(ac), norm(bc)];
    let stretch = longest(&lengths) * lengths.iter().sum::<f64>();
    let squares = dot(ab, ab) + dot(ac, ac) - dot(ab, ac);
    let condition = if along > 0.0 {
        over(squares, SQRT_3 * jacobian)
    } else {
        f64::INFINITY
    };
    Detail {
        jacobian: jacobian.copysign(along),
        aspect_ratio: over(SQRT_3 / 6.0 * stretch, jacobian),
        condition,
        shape: 1.0 / condition,
        ..Detail::NONE
    }
}

/// A quadrilateral with edges `L`, principal axes `X = L0 - L2` and `Y = L1 - L3`, `m` the unit
/// vector of `X x Y` and `a_i = m . (L_(i-1) x L_i)`.
///
/// ```text
/// jacobian     min a_i
/// aspect ratio max |L| (|L0| + |L1| + |L2| + |L3|) / (a_0 + a_1 + a_2 + a_3)
/// condition    max (|L_(i-1)|^2 + |L_i|^2) / (2 a_i)
/// shape        min 2 a_i / (|L_(i-1)|^2 + |L_i|^2), not below 0
/// skew         |X . Y| / (|X||Y|)
/// ```
///
/// With its last two corners in one place it has the Jacobian and condition of a triangle, as in
/// Verdict.
pub(super) fn quadrilateral(p: &[Vector; 4], facing: Vector) -> Detail {
    let edges: [Vector; 4] = from_fn(|i| sub(p[(i + 1) % 4], p[i]));
    let axes = [sub(edges[0], edges[2]), sub(edges[1], edges[3])];
    let across = cross(axes[0], axes[1]);
    let upright = dot(across, facing) > 0.0;
    let normal = unit(across).unwrap_or_default();
    let squares: [f64; 4] = from_fn(|i| dot(edges[i], edges[i]));
    let areas: [f64; 4] = from_fn(|i| dot(normal, cross(edges[(i + 3) % 4], edges[i])));
    let pairs: [f64; 4] = from_fn(|i| squares[(i + 3) % 4] + squares[i]);
    let lengths = squares.map(f64::sqrt);
    let stretch = longest(&lengths) * lengths.iter().sum::<f64>();
    let mut detail = Detail {
        jacobian: areas.into_iter().fold(f64::INFINITY, f64::min),
        aspect_ratio: over(stretch, areas.iter().sum()),
        condition: longest(&from_fn::<f64, 4, _>(|i| over(pairs[i], 2.0 * areas[i]))),
        shape: 0.0,
        skew: cosine(axes[0], axes[1]),
        ..Detail::NONE
    };
    if squares[2] == 0.0 {
        let corners = [p[0], p[1], p[2]];
        let whole = triangle(&corners, facing);
        (detail.jacobian, detail.condition) = (whole.jacobian, whole.condition);
    } else if squares.iter().all(|square| *square > 0.0) {
        let ratios = (0..4).map(|i| 2.0 * areas[i] / pairs[i]);
        detail.shape = ratios.fold(f64::INFINITY, f64::min).max(0.0);
    }
    if !upright {
        detail.jacobian = -detail.jacobian.abs();
        detail.condition = f64::INFINITY;
        detail.shape = 0.0;
    }
    detail
}

/// Magnitude of the cosine between two axes; 0 where one has no length.
fn cosine(a: Vector, b: Vector) -> f64 {
    let lengths = norm(a) * norm(b);
    if lengths > 0.0 {
        dot(a, b).abs() / lengths
    } else {
        0.0
    }
}

fn longest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}
