//! Tetrahedra, pyramids, wedges and hexahedra, in the order in which Verdict has them positive.

use super::super::size_skew::inverse_cube_root;
use super::plane::quadrilateral;
use super::{Detail, over};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, norm, scale, sub};
use azimesh_io::mesh::corners::{HEXAHEDRON, WEDGE};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

const SQRT_3: f64 = 1.732_050_807_568_877_2;
const SQRT_6: f64 = 2.449_489_742_783_178;

/// Verdict's divisor of a wedge's condition: the ideal wedge has 1.0000034.
const WEDGE_CONDITION: f64 = 1.164_77;

/// Three edges from one corner.
struct Corner {
    edges: [Vector; 3],
    /// `a . (b x c)`.
    jacobian: f64,
    /// Sum of their squared lengths.
    squares: f64,
}

impl Corner {
    #[inline(always)]
    fn new(edges: [Vector; 3]) -> Self {
        let [a, b, c] = edges;
        Self {
            edges,
            jacobian: dot(a, cross(b, c)),
            squares: dot(a, a) + dot(b, b) + dot(c, c),
        }
    }

    #[inline(always)]
    fn at(p: &[Vector], [at, a, b, c]: [u8; 4]) -> Self {
        let [at, a, b, c] = [at as usize, a as usize, b as usize, c as usize];
        Self::new([sub(p[a], p[at]), sub(p[b], p[at]), sub(p[c], p[at])])
    }

    /// `|A| |A^-1| / 3` in Frobenius norms for the matrix `A` of the edges; infinite where the
    /// Jacobian is not positive.
    fn condition(&self) -> f64 {
        over((self.squares * self.minors()).sqrt(), 3.0 * self.jacobian)
    }

    /// Sum of the squares of all cofactors.
    fn minors(&self) -> f64 {
        let [a, b, c] = self.edges;
        let (ab, bc, ca) = (cross(a, b), cross(b, c), cross(c, a));
        dot(ab, ab) + dot(bc, bc) + dot(ca, ca)
    }

    /// `3 (f J)^(2/3) / (|a|^2 + |b|^2 + |c|^2)`, at least 0.
    fn mean_ratio(&self, factor: f64) -> f64 {
        if self.jacobian > 0.0 {
            3.0 * two_thirds_power(factor * self.jacobian) / self.squares
        } else {
            0.0
        }
    }

    /// Sum of squares of the matrix that maps the regular tetrahedron to the one with these edges,
    /// times 2: `1.5 (|a|^2 + |b|^2 + |c|^2) - (a . b + b . c + c . a)`.
    fn against_regular(&self) -> f64 {
        let [a, b, c] = self.edges;
        1.5 * self.squares - (dot(a, b) + dot(b, c) + dot(c, a))
    }
}

#[inline]
fn two_thirds_power(x: f64) -> f64 {
    x * inverse_cube_root(x)
}

/// A tetrahedron with edges `L` from its first corner, `C` the matrix that takes the regular
/// tetrahedron to it and `A` the areas of its faces.
///
/// ```text
/// jacobian     L0 . (L1 x L2)
/// aspect ratio sqrt(6) / 6 max |edge| (A0 + A1 + A2 + A3) / |jacobian|
/// condition    |C| |C^-1| / 3 in Frobenius norms, with the sign of the Jacobian
/// shape        3 (sqrt(2) J)^(2/3) / (3/2 (|L0|^2 + |L1|^2 + |L2|^2) - (L0 . L1 + L1 . L2 + L2 . L0))
/// ```
pub(super) fn tetrahedron(p: &[Vector; 4]) -> Detail {
    let corner = Corner::at(p, [0, 1, 2, 3]);
    let [ab, ac, ad] = corner.edges;
    let [bc, bd, cd] = [sub(ac, ab), sub(ad, ab), sub(ad, ac)];
    let area = |a: Vector, b: Vector| norm(cross(a, b));
    let areas = area(ab, bc) + area(ab, ad) + area(ac, ad) + area(bc, cd);
    let mut longest = 0.0;
    for edge in [ab, ac, ad, bc, bd, cd] {
        longest = f64::max(longest, dot(edge, edge));
    }
    let longest = longest.sqrt();
    let regular = Corner::new([
        ab,
        scale(sub(scale(ac, 2.0), ab), 1.0 / SQRT_3),
        scale(sub(sub(scale(ad, 3.0), ac), ab), 1.0 / SQRT_6),
    ]);
    let norms = (regular.squares * regular.minors()).sqrt();
    let shape =
        3.0 * two_thirds_power(SQRT_2 * corner.jacobian.max(0.0)) / corner.against_regular();
    Detail {
        jacobian: corner.jacobian,
        aspect_ratio: over(SQRT_6 / 12.0 * longest * areas, corner.jacobian.abs()),
        condition: if regular.jacobian == 0.0 {
            f64::INFINITY
        } else {
            norms / (3.0 * regular.jacobian)
        },
        shape: shape.max(0.0),
        ..Detail::NONE
    }
}

/// A pyramid: its smallest Jacobian is the smallest of the tetrahedra of [`super::super::solid::pyramid`].
///
/// ```text
/// shape  shape of the base x cos(t) x min(h / e, e / h)
/// ```
///
/// `h` is the height of the apex over the base's centre, along the cross product of the base's diagonals, `t` the angle
/// between that and the line to the apex, `e` the longest edge / sqrt(2); 0 where a corner is flat or inverted. VTK (9.7)
/// leaves out the longer of the first two edges, and takes the normal at the first corner of the base, which of a warped base
/// is another one for each numbering.
pub(super) fn pyramid(p: &[Vector; 5]) -> Detail {
    let tetrahedra = [[0, 1, 2, 4], [0, 2, 3, 4], [0, 1, 3, 4], [1, 2, 3, 4]];
    let mut jacobian = f64::INFINITY;
    for corner in tetrahedra {
        jacobian = f64::min(jacobian, Corner::at(p, corner).jacobian);
    }
    Detail {
        jacobian,
        shape: if jacobian > 0.0 {
            pyramid_shape(p)
        } else {
            0.0
        },
        ..Detail::NONE
    }
}

fn pyramid_shape(p: &[Vector; 5]) -> f64 {
    let [a, b, c, d, apex] = *p;
    let normal = area_direction(&[a, b, c, d]);
    let centre = scale(add(add(a, b), add(c, d)), 0.25);
    let up = sub(apex, centre);
    let height = dot(up, normal) / norm(normal);
    if height.is_nan() || height <= 0.0 {
        return 0.0;
    }
    let edges = [
        (a, b),
        (b, c),
        (c, d),
        (d, a),
        (a, apex),
        (b, apex),
        (c, apex),
        (d, apex),
    ];
    let lengths = edges.iter().map(|&(from, to)| norm(sub(to, from)));
    let ideal = lengths.fold(0.0, f64::max) * FRAC_1_SQRT_2;
    let base = quadrilateral(&[a, b, c, d], normal).shape;
    base * (height / norm(up)) * (height / ideal).min(ideal / height)
}

/// The direction that a quadrilateral faces.
fn area_direction(p: &[Vector; 4]) -> Vector {
    cross(sub(p[2], p[0]), sub(p[3], p[1]))
}

/// A wedge.
///
/// ```text
/// jacobian   min over 6 corners of J
/// condition  max over 6 corners of F / 1.16477, at least 1
///            F = (3/2 (|a|^2 + |b|^2 + |c|^2) - (a . b + b . c + c . a)) / (3 (2 J^2)^(1/3))
/// shape      min over 6 corners of 3 (2 / sqrt(3) J)^(2/3) / (|a|^2 + |b|^2 + |c|^2), 0 to 1
/// ```
pub(super) fn wedge(p: &[Vector; 6]) -> Detail {
    let (mut jacobian, mut frobenius, mut shape) = (f64::INFINITY, 0.0, 1.0);
    for k in 0..6 {
        let corner = Corner::at(p, WEDGE[k]);
        jacobian = f64::min(jacobian, corner.jacobian);
        shape = f64::min(shape, corner.mean_ratio(2.0 / SQRT_3));
        let volume = two_thirds_power(SQRT_2 * corner.jacobian.abs());
        frobenius = f64::max(frobenius, over(corner.against_regular(), 3.0 * volume));
    }
    Detail {
        jacobian,
        condition: (frobenius / WEDGE_CONDITION).max(1.0),
        shape,
        ..Detail::NONE
    }
}

/// A hexahedron with principal axes `X`, `Y`, `Z`.
///
/// ```text
/// jacobian   min over 8 corners of J and of X . (Y x Z) / 64
/// condition  max over 8 corners of |A| |A^-1| / 3 in Frobenius norms, A the matrix of the edges
/// shape      min over 8 corners of 3 J^(2/3) / (|a|^2 + |b|^2 + |c|^2), 0 to 1
/// skew       largest cosine between two of X, Y, Z
/// ```
pub(super) fn hexahedron(p: &[Vector; 8]) -> Detail {
    let (mut jacobian, mut condition, mut shape) = (f64::INFINITY, 0.0, 1.0);
    for k in 0..8 {
        let corner = Corner::at(p, HEXAHEDRON[k]);
        jacobian = f64::min(jacobian, corner.jacobian);
        condition = f64::max(condition, corner.condition());
        shape = f64::min(shape, corner.mean_ratio(1.0));
    }
    let axis = |to: [usize; 4], from: [usize; 4]| {
        let edge = |i: usize| sub(p[to[i]], p[from[i]]);
        add(add(edge(0), edge(1)), add(edge(2), edge(3)))
    };
    let x = axis([1, 2, 5, 6], [0, 3, 4, 7]);
    let y = axis([2, 3, 6, 7], [1, 0, 5, 4]);
    let z = axis([4, 5, 6, 7], [0, 1, 2, 3]);
    let cosine = |a: Vector, b: Vector| over(dot(a, b).abs(), norm(a) * norm(b));
    let centre = dot(x, cross(y, z)) / 64.0;
    Detail {
        jacobian: jacobian.min(centre),
        condition,
        shape,
        skew: cosine(x, y).max(cosine(y, z)).max(cosine(z, x)),
        ..Detail::NONE
    }
}
