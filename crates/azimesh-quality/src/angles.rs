//! Edges, faces and equiangle skew from extreme angles, kept as squares of cosines with the sign of
//! the cosine, so that a sweep over cells needs neither roots nor arc cosines.
//!
//! Free of branches, so that a loop over cells becomes vector instructions.

use super::span::{Span, greater, lesser};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, sub};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

/// The three classes of angles and the ideal of each in radians: angles of triangles, angles of
/// quadrilaterals, dihedral angles of tetrahedra (`acos(1/3)`).
const IDEALS: [f64; N_CLASSES] = [FRAC_PI_3, FRAC_PI_2, 1.230_959_417_340_774_7];

/// Number of classes of angles.
pub(super) const N_CLASSES: usize = 3;

const TRIANGLE: usize = 0;
const QUADRILATERAL: usize = 1;
const DIHEDRAL: usize = 2;

/// A vector with what is needed of its length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub along: Vector,
    pub square: f64,
    /// One over `square`; not a number for an edge of no length, whose angles are then left out.
    pub inverse: f64,
}

impl Edge {
    #[inline(always)]
    pub(super) fn new(along: Vector) -> Self {
        let square = dot(along, along);
        let inverse = 1.0 / square;
        Self {
            along,
            square,
            inverse: if square > 0.0 { inverse } else { f64::NAN },
        }
    }

    #[inline(always)]
    pub(super) fn between(from: Vector, to: Vector) -> Self {
        Self::new(sub(to, from))
    }

    #[inline(always)]
    pub(super) fn reversed(self) -> Self {
        let [x, y, z] = self.along;
        Self {
            along: [-x, -y, -z],
            ..self
        }
    }

    /// Signed square of the cosine of the angle between two edges.
    #[inline(always)]
    fn cosine(&self, other: &Self) -> f64 {
        let product = dot(self.along, other.along);
        (product * self.inverse) * (product.abs() * other.inverse)
    }
}

/// A quadrilateral as a patch with two coordinates: `a[0]` leads from corner 0 to 1, `a[1]` from 3
/// to 2, `b[0]` from 0 to 3, `b[1]` from 1 to 2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub a: [Edge; 2],
    pub b: [Edge; 2],
}

impl Patch {
    /// `a x b` at each corner. Their sum is the cross product of the principal axes.
    #[inline(always)]
    pub(super) fn normals(&self) -> [Vector; 4] {
        let (a, b) = (&self.a, &self.b);
        [
            cross(a[0].along, b[0].along),
            cross(a[0].along, b[1].along),
            cross(a[1].along, b[1].along),
            cross(a[1].along, b[0].along),
        ]
    }

    /// Returns whether the last two corners are in one place: then it is a triangle, as in Verdict.
    #[inline(always)]
    pub(super) fn is_triangle(&self) -> bool {
        self.a[1].square == 0.0
    }
}

/// Extreme angles of each class, as signed squares of cosines. An angle above 180 degrees continues
/// below -1, as -2 minus its value, so that the order is kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Angles {
    pub classes: [Span; N_CLASSES],
}

impl Angles {
    pub(super) const NONE: Self = Self {
        classes: [Span::EMPTY; N_CLASSES],
    };

    /// Equiangle skew; `None` without an angle.
    ///
    /// ```text
    /// max over classes of max((largest - ideal) / (180 - ideal), (ideal - smallest) / ideal)
    /// ```
    ///
    /// 0 for the ideal cell, 1 for a flat one, more where a quadrilateral is concave.
    pub(super) fn skew(&self) -> Option<f64> {
        self.classes
            .iter()
            .zip(IDEALS)
            .filter(|(span, _)| span.low <= span.high)
            .map(|(span, ideal)| {
                let (smallest, largest) = (angle(span.high), angle(span.low));
                ((largest - ideal) / (PI - ideal)).max((ideal - smallest) / ideal)
            })
            .reduce(f64::max)
    }

    /// Smallest and largest angle of the faces in degrees; not numbers without one.
    pub(super) fn of_faces(&self) -> Span {
        let mut span = self.classes[TRIANGLE];
        span.merge(self.classes[QUADRILATERAL]);
        degrees(span)
    }

    /// Smallest and largest angle between the faces of a tetrahedron in degrees; not numbers
    /// without one.
    pub(super) fn between_faces(&self) -> Span {
        degrees(self.classes[DIHEDRAL])
    }

    /// Takes in the angles of a triangle, its edges head to tail.
    #[inline(always)]
    pub(super) fn add_triangle(&mut self, edges: [Edge; 3]) {
        let span = &mut self.classes[TRIANGLE];
        span.include(-edges[0].cosine(&edges[1]));
        span.include(-edges[1].cosine(&edges[2]));
        span.include(-edges[2].cosine(&edges[0]));
    }

    /// Takes in the angles of a quadrilateral.
    #[inline(always)]
    pub(super) fn add_patch(&mut self, a: [Edge; 2], b: [Edge; 2]) {
        let patch = Patch { a, b };
        self.add_quadrilateral(&patch, &patch.normals());
    }

    /// Takes in the angles of a quadrilateral with these `normals`. Where a corner turns the other
    /// way the largest angle becomes 360 degrees less it, as Verdict has it.
    #[inline(always)]
    pub(super) fn add_quadrilateral(&mut self, patch: &Patch, normals: &[Vector; 4]) {
        let (a, b, is_triangle) = (patch.a, patch.b, patch.is_triangle());
        let mut span = Span::EMPTY;
        span.include(a[0].cosine(&b[0]));
        span.include(-a[0].cosine(&b[1]));
        span.include(a[1].cosine(&b[1]));
        span.include(-a[1].cosine(&b[0]));
        let third = b[0].cosine(&b[1]);
        span.include(if is_triangle { third } else { f64::NAN });
        let sum = add(add(normals[0], normals[2]), add(normals[1], normals[3]));
        let turn = lesser(
            lesser(dot(sum, normals[0]), dot(sum, normals[1])),
            lesser(dot(sum, normals[2]), dot(sum, normals[3])),
        );
        let beyond = -2.0 - greater(span.low, -1.0);
        let turns_back = (turn < 0.0) & !is_triangle;
        span.low = if turns_back { beyond } else { span.low };
        self.classes[QUADRILATERAL].merge(span);
    }

    /// Takes in the dihedral angles of a tetrahedron and the angles of its faces, from the edges
    /// 01, 02, 03, 12, 13, 23.
    #[inline(always)]
    pub(super) fn add_tetrahedron(&mut self, edges: [Edge; 6]) {
        let [ab, ac, ad, bc, bd, cd] = edges;
        let abc = Edge::new(cross(bc.along, ab.along));
        let abd = Edge::new(cross(ab.along, ad.along));
        let acd = Edge::new(cross(cd.along, ad.along));
        let bcd = Edge::new(cross(bc.along, cd.along));
        let dihedral = &mut self.classes[DIHEDRAL];
        dihedral.include(-abc.cosine(&abd));
        dihedral.include(-abc.cosine(&acd));
        dihedral.include(-abc.cosine(&bcd));
        dihedral.include(-abd.cosine(&acd));
        dihedral.include(-abd.cosine(&bcd));
        dihedral.include(-acd.cosine(&bcd));
        let plane = &mut self.classes[TRIANGLE];
        plane.include(-ab.cosine(&bc));
        plane.include(bc.cosine(&ac));
        plane.include(ac.cosine(&ab));
        plane.include(-ab.cosine(&bd));
        plane.include(bd.cosine(&ad));
        plane.include(ad.cosine(&ab));
        plane.include(-bc.cosine(&cd));
        plane.include(cd.cosine(&bd));
        plane.include(bd.cosine(&bc));
        plane.include(ad.cosine(&cd));
        plane.include(-cd.cosine(&ac));
        plane.include(ac.cosine(&ad));
    }
}

fn degrees(squares: Span) -> Span {
    if squares.low <= squares.high {
        Span {
            low: angle(squares.high).to_degrees(),
            high: angle(squares.low).to_degrees(),
        }
    } else {
        Span::UNDEFINED
    }
}

/// The angle in radians behind the signed square of a cosine that may go on below -1.
fn angle(square: f64) -> f64 {
    let within = |square: f64| signed_root(square.clamp(-1.0, 1.0)).acos();
    if square < -1.0 - 1e-12 {
        TAU - within(-2.0 - square)
    } else {
        within(square)
    }
}

/// The number whose square with its sign is `square`.
#[inline(always)]
pub(super) fn signed_root(square: f64) -> f64 {
    square.abs().sqrt().copysign(square)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quadrilateral(p: [Vector; 4]) -> Angles {
        let edge = |i: usize, j: usize| Edge::between(p[i], p[j]);
        let patch = Patch {
            a: [edge(0, 1), edge(3, 2)],
            b: [edge(0, 3), edge(1, 2)],
        };
        let mut angles = Angles::NONE;
        angles.add_quadrilateral(&patch, &patch.normals());
        angles
    }

    #[test]
    fn ideal_cells_have_no_skew() {
        let square = quadrilateral([[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
        assert!(square.skew().expect("it has angles").abs() < 1e-15);
        let p = [[1., 1., 1.], [-1., 1., -1.], [1., -1., -1.], [-1., -1., 1.]];
        let pairs = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        let mut regular = Angles::NONE;
        regular.add_tetrahedron(pairs.map(|[i, j]| Edge::between(p[i], p[j])));
        assert!(regular.skew().expect("it has angles").abs() < 1e-15);
        assert!(Angles::NONE.skew().is_none());
    }

    #[test]
    fn a_dart_is_worse_than_flat() {
        let dart = quadrilateral([[0., 0., 0.], [2., 0., 0.], [0.4, 0.4, 0.], [0., 2., 0.]]);
        assert!(dart.skew().expect("it has angles") > 1.0);
    }

    #[test]
    fn a_quadrilateral_with_its_last_corners_in_one_place_has_the_angles_of_a_triangle() {
        let p = [[0., 0., 0.], [3., 0., 0.], [0., 1., 0.], [0., 1., 0.]];
        let span = quadrilateral(p).classes[QUADRILATERAL];
        assert!(span.low.abs() < 1e-15);
        assert!((span.high - 0.9).abs() < 1e-15);
    }
}
