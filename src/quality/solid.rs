//! Tetrahedra, pyramids, wedges, hexahedra and polyhedra.
//!
//! Volumes are exact for faces that are bilinear patches (the same as Verdict's sums over
//! tetrahedra around face centres). A cell is positive in the order in which Verdict has it
//! positive: for a wedge that is a first triangle whose normal points at the second.

use super::angles::Angles;
use super::metrics::{Metrics, Span};
use super::plane::ratio;
use crate::geometry::vector::{Vector, add, cross, dot, scale, sub};
use std::f64::consts::SQRT_2;

/// `2 / sqrt(3)`: makes the right prism's scaled Jacobian one.
const TWO_OVER_SQRT_3: f64 = 1.154_700_538_379_251_7;

/// Faces of a hexahedron, outward.
const HEXAHEDRON_FACES: [[usize; 4]; 6] = [
    [0, 4, 7, 3],
    [1, 2, 6, 5],
    [0, 1, 5, 4],
    [3, 7, 6, 2],
    [0, 3, 2, 1],
    [4, 5, 6, 7],
];

/// `a . (b x c)`.
#[inline]
fn det(a: Vector, b: Vector, c: Vector) -> f64 {
    dot(a, cross(b, c))
}

/// Twelve times the volume between the origin and the bilinear patch over `a b c d`.
#[inline]
fn patch(a: Vector, b: Vector, c: Vector, d: Vector) -> f64 {
    det(a, c, sub(d, b)) + det(b, d, sub(a, c))
}

/// Jacobian at a corner and the product of the lengths of its three edges.
#[inline]
fn corner(at: Vector, to: [Vector; 3]) -> (f64, f64) {
    let [u, v, w] = to.map(|p| sub(p, at));
    (det(u, v, w), (dot(u, u) * dot(v, v) * dot(w, w)).sqrt())
}

#[inline]
fn edge_span<const N: usize, const E: usize>(p: &[Vector; N], edges: [[u8; 2]; E]) -> Span {
    Span::of(edges.map(|[a, b]| {
        let edge = sub(p[b as usize], p[a as usize]);
        dot(edge, edge)
    }))
}

/// Scaled Jacobian of a tetrahedron.
///
///     sqrt(2) J / max(|J|, largest product of the three edges at a corner), -1 to 1
#[inline]
fn tetrahedron_scaled(p: [Vector; 4]) -> (f64, f64) {
    let square = |a: usize, b: usize| {
        let edge = sub(p[b], p[a]);
        dot(edge, edge)
    };
    let [ab, ac, ad] = [square(0, 1), square(0, 2), square(0, 3)];
    let [bc, bd, cd] = [square(1, 2), square(1, 3), square(2, 3)];
    let products = (ab * ac * ad)
        .max(ab * bc * bd)
        .max(bc * ac * cd)
        .max(ad * bd * cd);
    let jacobian = det(sub(p[1], p[0]), sub(p[2], p[0]), sub(p[3], p[0]));
    let scaled = ratio(SQRT_2 * jacobian, products.sqrt().max(jacobian.abs()));
    (jacobian, scaled)
}

/// A tetrahedron: volume `J / 6`, scaled Jacobian as above.
#[inline]
pub(super) fn tetrahedron(p: &[Vector; 4]) -> Metrics {
    let (jacobian, scaled) = tetrahedron_scaled(*p);
    let mut angles = Angles::NONE;
    angles.add_tetrahedron(p);
    Metrics {
        volume: jacobian / 6.0,
        corner: Span {
            low: jacobian,
            high: jacobian,
        },
        scaled: Span {
            low: scaled,
            high: scaled,
        },
        edge: edge_span(p, [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]),
        angles,
    }
}

/// A pyramid. Its corners are the four tetrahedra of a base corner, the two next to it and the
/// apex.
///
///     q = sqrt(2) min over corners of the tetrahedron's scaled Jacobian
///     scaled Jacobian = q where q < 1, 2 - q above
///
/// VTK shows 0 where this is negative.
#[inline]
pub(super) fn pyramid(p: &[Vector; 5]) -> Metrics {
    let tets = [[0, 1, 2, 4], [0, 2, 3, 4], [0, 1, 3, 4], [1, 2, 3, 4]]
        .map(|nodes: [usize; 4]| tetrahedron_scaled(nodes.map(|i| p[i])));
    let scaled = Span::of(tets.map(|(_, scaled)| scaled * SQRT_2));
    let folded = |q: f64| if q < 1.0 { q } else { 2.0 - q };
    let [b, c, d, apex] = [1, 2, 3, 4].map(|i| sub(p[i], p[0]));
    let base = patch([0.0; 3], d, c, b);
    let sides = det(b, c, apex) + det(c, d, apex);
    let mut angles = Angles::NONE;
    angles.add_quadrilateral([p[0], p[1], p[2], p[3]]);
    for i in 0..4 {
        angles.add_triangle([p[i], p[(i + 1) % 4], p[4]]);
    }
    Metrics {
        volume: (2.0 * sides + base) / 12.0,
        corner: Span::of(tets.map(|(jacobian, _)| jacobian)),
        scaled: Span {
            low: folded(scaled.low),
            high: -folded(-scaled.high),
        },
        edge: edge_span(
            p,
            [
                [0, 1],
                [1, 2],
                [2, 3],
                [3, 0],
                [0, 4],
                [1, 4],
                [2, 4],
                [3, 4],
            ],
        ),
        angles,
    }
}

/// A wedge.
///
///     scaled Jacobian = 2 / sqrt(3) min over 6 corners of J / (|L0| |L1| |L2|), at most 2 / sqrt(3)
#[inline]
pub(super) fn wedge(p: &[Vector; 6]) -> Metrics {
    const NEXT: [[usize; 3]; 6] = [
        [1, 2, 3],
        [2, 0, 4],
        [0, 1, 5],
        [5, 4, 0],
        [3, 5, 1],
        [4, 3, 2],
    ];
    let corners: [(f64, f64); 6] = std::array::from_fn(|i| corner(p[i], NEXT[i].map(|j| p[j])));
    let [b, c, d, e, f] = [1, 2, 3, 4, 5].map(|i| sub(p[i], p[0]));
    let zero = [0.0; 3];
    let sides = patch(zero, b, e, d) + patch(b, c, f, e) + patch(c, zero, d, f);
    let mut angles = Angles::NONE;
    angles.add_triangle([p[0], p[1], p[2]]);
    angles.add_triangle([p[3], p[4], p[5]]);
    for i in 0..3 {
        let j = (i + 1) % 3;
        angles.add_quadrilateral([p[i], p[j], p[j + 3], p[i + 3]]);
    }
    Metrics {
        volume: (2.0 * det(d, e, f) + sides) / 12.0,
        corner: Span::of(corners.map(|(jacobian, _)| jacobian)),
        scaled: Span::of(corners.map(|(jacobian, l)| TWO_OVER_SQRT_3 * ratio(jacobian, l))),
        edge: edge_span(
            p,
            [
                [0, 1],
                [1, 2],
                [2, 0],
                [3, 4],
                [4, 5],
                [5, 3],
                [0, 3],
                [1, 4],
                [2, 5],
            ],
        ),
        angles,
    }
}

/// A hexahedron.
///
///     scaled Jacobian = min over 8 corners and the centre of J / (|L0| |L1| |L2|), -1 to 1
///
/// At the centre the `L` are the principal axes. Only corners decide whether it is inverted.
#[inline]
pub(super) fn hexahedron(p: &[Vector; 8]) -> Metrics {
    const NEXT: [[usize; 3]; 8] = [
        [1, 3, 4],
        [2, 0, 5],
        [3, 1, 6],
        [0, 2, 7],
        [7, 5, 0],
        [4, 6, 1],
        [5, 7, 2],
        [6, 4, 3],
    ];
    let corners: [(f64, f64); 8] = std::array::from_fn(|i| corner(p[i], NEXT[i].map(|j| p[j])));
    let axis = |plus: [usize; 4], minus: [usize; 4]| {
        let sum = |nodes: [usize; 4]| nodes.into_iter().fold([0.0; 3], |s, i| add(s, p[i]));
        sub(sum(plus), sum(minus))
    };
    let axes = [
        axis([1, 2, 5, 6], [0, 3, 4, 7]),
        axis([2, 3, 6, 7], [0, 1, 4, 5]),
        axis([4, 5, 6, 7], [0, 1, 2, 3]),
    ];
    let (jacobian, lengths) = corner([0.0; 3], axes);
    let mut scaled = Span::of(corners.map(|(jacobian, l)| ratio(jacobian, l)));
    scaled.include(ratio(jacobian, lengths));
    let mut angles = Angles::NONE;
    for face in HEXAHEDRON_FACES {
        angles.add_quadrilateral(face.map(|i| p[i]));
    }
    Metrics {
        volume: hexahedron_volume(p),
        corner: Span::of(corners.map(|(jacobian, _)| jacobian)),
        scaled,
        edge: edge_span(
            p,
            [
                [0, 1],
                [1, 2],
                [2, 3],
                [3, 0],
                [4, 5],
                [5, 6],
                [6, 7],
                [7, 4],
                [0, 4],
                [1, 5],
                [2, 6],
                [3, 7],
            ],
        ),
        angles,
    }
}

/// Sum over the six faces, seen from the first corner.
#[inline]
fn hexahedron_volume(p: &[Vector; 8]) -> f64 {
    let from_first = p.map(|x| sub(x, p[0]));
    let faces = HEXAHEDRON_FACES.map(|face| {
        let [a, b, c, d] = face.map(|i| from_first[i]);
        patch(a, b, c, d)
    });
    faces.iter().sum::<f64>() / 12.0
}

/// A polyhedron: its volume alone, by the divergence theorem with each face a fan of triangles
/// around the mean of its nodes. Faces are taken in the orientation of the file, which must be
/// the same for all (all outward, or all inward: then the volume is negative).
pub(super) fn polyhedron<'a>(
    faces: impl Iterator<Item = &'a [u32]>,
    points: &[Vector],
    origin: Vector,
) -> Metrics {
    let at = |node: u32| sub(points[node as usize], origin);
    let volume = faces
        .map(|face| {
            let sum = face.iter().fold([0.0; 3], |s, &node| add(s, at(node)));
            let centre = scale(sum, 1.0 / face.len() as f64);
            let fan = (0..face.len()).map(|i| {
                let (a, b) = (at(face[i]), at(face[(i + 1) % face.len()]));
                det(centre, a, b) / 6.0
            });
            fan.sum::<f64>()
        })
        .sum();
    Metrics {
        volume,
        corner: Span {
            low: volume,
            high: volume,
        },
        scaled: Span::UNDEFINED,
        edge: Span::UNDEFINED,
        angles: Angles::NONE,
    }
}
