//! Tetrahedra, pyramids, wedges, hexahedra and polyhedra.
//!
//! Volumes are exact for faces that are bilinear patches (the same as Verdict's sums over
//! tetrahedra around face centres). A cell is positive in the order in which Verdict has it
//! positive: for a wedge that is a first triangle whose normal points at the second.

use super::angles::{Angles, Edge, Patch, signed_root};
use super::metrics::{Knupp, Metrics};
use super::plane::{or_zero, ratio};
use super::size_skew::inverse_cube_root;
use super::span::{Span, greater};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale, sub};
use std::f64::consts::SQRT_2;

/// `2 / sqrt(3)`: makes the right prism's scaled Jacobian one.
const TWO_OVER_SQRT_3: f64 = 1.154_700_538_379_251_7;

/// The cube root of 3/4: makes the right prism's `f_skew` one.
const CUBE_ROOT_OF_3_4: f64 = 0.908_560_296_416_069_8;

/// `a . (b x c)`.
#[inline(always)]
fn det(a: Vector, b: Vector, c: Vector) -> f64 {
    dot(a, cross(b, c))
}

/// Twelve times the volume between the origin and the bilinear patch over `a b c d`.
#[inline(always)]
fn patch(a: Vector, b: Vector, c: Vector, d: Vector) -> f64 {
    det(a, c, sub(d, b)) + det(b, d, sub(a, c))
}

#[inline(always)]
fn squares<const N: usize>(edges: &[Edge; N]) -> [f64; N] {
    let mut squares = [0.0; N];
    for i in 0..N {
        squares[i] = edges[i].square;
    }
    squares
}

/// Scaled Jacobian of a tetrahedron with Jacobian `J` and the squared lengths of its edges 01, 02,
/// 03, 12, 13, 23, as its square with its sign.
///
/// ```text
/// sqrt(2) J / max(|J|, largest product of the three edges at a corner), -1 to 1
/// ```
#[inline(always)]
fn tetrahedron_scaled(jacobian: f64, squares: [f64; 6]) -> f64 {
    let [ab, ac, ad, bc, bd, cd] = squares;
    let largest = greater(
        greater(ab * ac * ad, ab * bc * bd),
        greater(bc * ac * cd, ad * bd * cd),
    );
    let square = jacobian * jacobian.abs();
    ratio(2.0 * square, greater(square.abs(), largest))
}

/// Both ends of a span of signed squares.
#[inline(always)]
fn roots(squares: Span, factor: f64) -> Span {
    Span {
        low: factor * signed_root(squares.low),
        high: factor * signed_root(squares.high),
    }
}

/// A tetrahedron: volume `J / 6`, scaled Jacobian as above.
#[inline(always)]
pub(super) fn tetrahedron(p: &[Vector; 4]) -> Metrics {
    let edges = [
        Edge::between(p[0], p[1]),
        Edge::between(p[0], p[2]),
        Edge::between(p[0], p[3]),
        Edge::between(p[1], p[2]),
        Edge::between(p[1], p[3]),
        Edge::between(p[2], p[3]),
    ];
    let squares = squares(&edges);
    let jacobian = det(edges[0].along, edges[1].along, edges[2].along);
    let mut angles = Angles::NONE;
    angles.add_tetrahedron(edges);
    let corner = Span::at(jacobian);
    let lengths = (squares[0] + squares[1] + squares[2]) + (squares[3] + squares[4] + squares[5]);
    let cube = 2.0 * jacobian * jacobian;
    let root = inverse_cube_root(cube);
    let skew = 6.0 * (cube * root * root) / lengths;
    Metrics {
        volume: jacobian / 6.0,
        corner,
        scaled: Span::at(signed_root(tetrahedron_scaled(jacobian, squares))),
        edge: Span::of_array(squares),
        angles,
        knupp: Knupp::new(jacobian, corner, skew),
    }
}

/// A pyramid. Its corners are the four tetrahedra of a base corner, the two next to it and the
/// apex.
///
/// ```text
/// q = sqrt(2) min over corners of the tetrahedron's scaled Jacobian
/// scaled Jacobian = q where q < 1, 2 - q above
/// ```
///
/// VTK shows 0 where this is negative.
#[inline(always)]
pub(super) fn pyramid(p: &[Vector; 5]) -> Metrics {
    let around = [
        Edge::between(p[0], p[1]),
        Edge::between(p[1], p[2]),
        Edge::between(p[2], p[3]),
        Edge::between(p[3], p[0]),
    ];
    let up = [
        Edge::between(p[0], p[4]),
        Edge::between(p[1], p[4]),
        Edge::between(p[2], p[4]),
        Edge::between(p[3], p[4]),
    ];
    let patch_edges = Patch {
        a: [around[0], around[2].reversed()],
        b: [around[3].reversed(), around[1]],
    };
    let (a, u) = (squares(&around), squares(&up));
    let [ac, bd] = [sub(p[2], p[0]), sub(p[3], p[1])];
    let [diagonal_ac, diagonal_bd] = [dot(ac, ac), dot(bd, bd)];
    let [b, c, d, apex] = [sub(p[1], p[0]), ac, sub(p[3], p[0]), up[0].along];
    let tets = [
        (det(b, c, apex), [a[0], diagonal_ac, u[0], a[1], u[1], u[2]]),
        (det(c, d, apex), [diagonal_ac, a[3], u[0], a[2], u[2], u[3]]),
        (det(b, d, apex), [a[0], a[3], u[0], diagonal_bd, u[1], u[3]]),
        (
            det(around[1].along, bd, up[1].along),
            [a[1], diagonal_bd, u[1], a[2], u[2], u[3]],
        ),
    ];
    let (mut corner, mut scaled) = (Span::EMPTY, Span::EMPTY);
    for i in 0..4 {
        let (jacobian, squares) = tets[i];
        corner.include(jacobian);
        scaled.include(tetrahedron_scaled(jacobian, squares));
    }
    let badness = pyramid_badness(tets[2].0, around[0], around[3], up[0])
        + pyramid_badness(tets[0].0, around[1], around[0], up[1])
        + pyramid_badness(tets[3].0, around[2], around[1], up[2])
        + pyramid_badness(tets[1].0, around[3], around[2], up[3]);
    let size = (tets[0].0 + tets[1].0) + (tets[2].0 + tets[3].0);
    let scaled = roots(scaled, SQRT_2);
    let base = patch([0.0; 3], d, c, b);
    let sides = tets[0].0 + tets[1].0;
    let mut angles = Angles::NONE;
    angles.add_quadrilateral(&patch_edges, &patch_edges.normals());
    angles.add_triangle([around[0], up[1], up[0].reversed()]);
    angles.add_triangle([around[1], up[2], up[1].reversed()]);
    angles.add_triangle([around[2], up[3], up[2].reversed()]);
    angles.add_triangle([around[3], up[0], up[3].reversed()]);
    let mut edge = Span::of_array(a);
    edge.merge(Span::of_array(u));
    Metrics {
        volume: (2.0 * sides + base) / 12.0,
        corner,
        scaled: Span {
            low: folded(scaled.low),
            high: -folded(-scaled.high),
        },
        edge,
        angles,
        knupp: Knupp::new(size, corner, 12.0 / badness),
    }
}

/// `|S|^2 / det(S)^(2/3)` at a corner of the base with the edges to the next and from the last corner; `S` takes the
/// corner from the pyramid whose edges are all equal.
///
/// ```text
/// det S = sqrt(2) alpha,   |S|^2 = |e_1|^2 + |e_2|^2 + |2 e_3 - e_1 - e_2|^2 / 2
/// ```
#[inline(always)]
fn pyramid_badness(alpha: f64, next: Edge, last: Edge, up: Edge) -> f64 {
    let leaning = add(scale(up.along, 2.0), sub(last.along, next.along));
    let squares = next.square + last.square + 0.5 * dot(leaning, leaning);
    squares * inverse_cube_root(2.0 * alpha * alpha)
}

#[inline(always)]
fn folded(q: f64) -> f64 {
    if q < 1.0 { q } else { 2.0 - q }
}

/// A wedge.
///
/// ```text
/// scaled Jacobian = 2 / sqrt(3) min over 6 corners of J / (|L0| |L1| |L2|), at most 2 / sqrt(3)
/// ```
#[inline(always)]
pub(super) fn wedge(p: &[Vector; 6]) -> Metrics {
    let ring = |i: usize, j: usize, k: usize| {
        [
            Edge::between(p[i], p[j]),
            Edge::between(p[j], p[k]),
            Edge::between(p[k], p[i]),
        ]
    };
    let (bottom, top) = (ring(0, 1, 2), ring(3, 4, 5));
    let up = [
        Edge::between(p[0], p[3]),
        Edge::between(p[1], p[4]),
        Edge::between(p[2], p[5]),
    ];
    let corners = [
        jacobian([bottom[2], bottom[0], up[0]]),
        jacobian([bottom[0], bottom[1], up[1]]),
        jacobian([bottom[1], bottom[2], up[2]]),
        jacobian([top[2], top[0], up[0]]),
        jacobian([top[0], top[1], up[1]]),
        jacobian([top[1], top[2], up[2]]),
    ];
    let (mut corner, mut scaled) = (Span::EMPTY, Span::EMPTY);
    let (mut size, mut badness) = (0.0, 0.0);
    for i in 0..6 {
        let (jacobian, square) = corners[i];
        corner.include(jacobian);
        scaled.include(square);
        size += jacobian;
        badness += inverse_cube_root(square.abs());
    }
    let mut angles = Angles::NONE;
    angles.add_triangle(bottom);
    angles.add_triangle(top);
    angles.add_patch([bottom[0], top[0]], [up[0], up[1]]);
    angles.add_patch([bottom[1], top[1]], [up[1], up[2]]);
    angles.add_patch([bottom[2], top[2]], [up[2], up[0]]);
    let mut edge = Span::of_array(squares(&bottom));
    edge.merge(Span::of_array(squares(&top)));
    edge.merge(Span::of_array(squares(&up)));
    Metrics {
        volume: wedge_volume(p),
        corner,
        scaled: roots(scaled, TWO_OVER_SQRT_3),
        edge,
        angles,
        knupp: Knupp::new(size, corner, 6.0 / (CUBE_ROOT_OF_3_4 * badness)),
    }
}

#[inline(always)]
fn wedge_volume(p: &[Vector; 6]) -> f64 {
    let [b, c, d, e, f] = [
        sub(p[1], p[0]),
        sub(p[2], p[0]),
        sub(p[3], p[0]),
        sub(p[4], p[0]),
        sub(p[5], p[0]),
    ];
    let zero = [0.0; 3];
    let sides = patch(zero, b, e, d) + patch(b, c, f, e) + patch(c, zero, d, f);
    (2.0 * det(d, e, f) + sides) / 12.0
}

/// Jacobian of three edges, and of the same divided by their lengths the square with its sign: 0
/// where one has no length.
#[inline(always)]
fn jacobian(edges: [Edge; 3]) -> (f64, f64) {
    let [u, v, w] = edges;
    let jacobian = det(w.along, u.along, v.along);
    (jacobian, over_lengths(jacobian, u, v, w))
}

#[inline(always)]
fn over_lengths(jacobian: f64, u: Edge, v: Edge, w: Edge) -> f64 {
    or_zero((jacobian * (u.inverse * v.inverse)) * (jacobian.abs() * w.inverse))
}

/// A hexahedron.
///
/// ```text
/// scaled Jacobian = min over 8 corners and the centre of J / (|L0| |L1| |L2|), -1 to 1
/// ```
///
/// At the centre the `L` are the principal axes. Only corners decide whether it is inverted.
#[inline(always)]
pub(super) fn hexahedron(p: &[Vector; 8]) -> Metrics {
    let edge = |i: usize, j: usize| Edge::between(p[i], p[j]);
    let x = [edge(0, 1), edge(3, 2), edge(4, 5), edge(7, 6)];
    let y = [edge(0, 3), edge(1, 2), edge(4, 7), edge(5, 6)];
    let z = [edge(0, 4), edge(1, 5), edge(2, 6), edge(3, 7)];
    // The second edge of `a` is between the last two corners of the face in Verdict's order.
    let mut angles = Angles::NONE;
    angles.add_patch([z[0], z[3]], [y[0], y[2]]);
    angles.add_patch([y[1], y[3]], [z[1], z[2]]);
    angles.add_patch([x[0], x[2]], [z[0], z[1]]);
    angles.add_patch([z[3], z[2]], [x[1], x[3]]);
    let bottom = Patch {
        a: [y[0], y[1]],
        b: [x[0], x[1]],
    };
    let top = Patch {
        a: [x[2], x[3]],
        b: [y[2], y[3]],
    };
    let (below, above) = (bottom.normals(), top.normals());
    angles.add_quadrilateral(&bottom, &below);
    angles.add_quadrilateral(&top, &above);
    let axis = |e: &[Edge; 4]| {
        let halves = [add(e[0].along, e[1].along), add(e[2].along, e[3].along)];
        Edge::new(add(halves[0], halves[1]))
    };
    let (mut corner, mut scaled) = (
        Span::EMPTY,
        Span::at(jacobian([axis(&x), axis(&y), axis(&z)]).1),
    );
    // Corners 0 to 3, then 4 to 7: z along the cross product that the face has there, and the other
    // two edges. The bottom is seen from below.
    let (mut size, mut badness) = (0.0, 0.0);
    let mut add_corner = |jacobian: f64, u: Edge, v: Edge, w: Edge| {
        let square = over_lengths(jacobian, u, v, w);
        corner.include(jacobian);
        scaled.include(square);
        size += jacobian;
        badness += inverse_cube_root(square.abs());
    };
    add_corner(-dot(z[0].along, below[0]), x[0], y[0], z[0]);
    add_corner(-dot(z[1].along, below[3]), x[0], y[1], z[1]);
    add_corner(-dot(z[2].along, below[2]), x[1], y[1], z[2]);
    add_corner(-dot(z[3].along, below[1]), x[1], y[0], z[3]);
    add_corner(dot(z[0].along, above[0]), x[2], y[2], z[0]);
    add_corner(dot(z[1].along, above[1]), x[2], y[3], z[1]);
    add_corner(dot(z[2].along, above[2]), x[3], y[3], z[2]);
    add_corner(dot(z[3].along, above[3]), x[3], y[2], z[3]);
    let mut edge = Span::of_array(squares(&x));
    edge.merge(Span::of_array(squares(&y)));
    edge.merge(Span::of_array(squares(&z)));
    Metrics {
        volume: hexahedron_volume(p),
        corner,
        scaled: roots(scaled, 1.0),
        edge,
        angles,
        knupp: Knupp::new(size, corner, 8.0 / badness),
    }
}

/// The sum over the six faces in three determinants.
///
/// Source: J. Grandy, Efficient computation of volume of hexahedral cells, Lawrence Livermore
/// National Laboratory, UCRL-ID-128886, 1997.
#[inline(always)]
fn hexahedron_volume(p: &[Vector; 8]) -> f64 {
    let d = |i: usize, j: usize| sub(p[i], p[j]);
    let sum = det(add(d(3, 1), d(7, 2)), d(6, 3), d(2, 0))
        + det(add(d(4, 3), d(5, 7)), d(6, 4), d(7, 0))
        + det(add(d(1, 4), d(2, 5)), d(6, 1), d(5, 0));
    sum / 12.0
}

/// A polyhedron: its volume alone, by the divergence theorem with each face a fan of triangles
/// around the mean of its nodes. Faces are taken in the orientation of the file, which must be
/// the same for all (all outward, or all inward: then the volume is negative).
pub(super) fn polyhedron<F>(
    faces: impl Iterator<Item = F>,
    points: &[Vector],
    origin: Vector,
) -> Metrics
where
    F: ExactSizeIterator<Item = u32> + Clone,
{
    let at = |node: u32| sub(points[node as usize], origin);
    let volume = faces
        .map(|face| {
            let n = face.len();
            let sum = face.clone().fold([0.0; 3], |s, node| add(s, at(node)));
            let centre = scale(sum, 1.0 / n as f64);
            let next = face.clone().cycle().skip(1);
            let sides = face.zip(next).take(n);
            let fan = sides.map(|(a, b)| det(centre, at(a), at(b)) / 6.0);
            fan.sum::<f64>()
        })
        .sum();
    Metrics {
        volume,
        corner: Span::at(volume),
        scaled: Span::UNDEFINED,
        edge: Span::UNDEFINED,
        angles: Angles::NONE,
        knupp: Knupp::UNDEFINED,
    }
}
