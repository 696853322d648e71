//! Equiangle skew from extreme angles, kept as cosines so that a sweep over cells needs no arc
//! cosine.

use super::metrics::Span;
use crate::geometry::vector::{Vector, cross, dot, norm, scale, sub};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

/// The three classes of angles and the ideal of each in radians: angles of triangles, angles of
/// quadrilaterals, dihedral angles of tetrahedra (`acos(1/3)`).
const IDEALS: [f64; 3] = [FRAC_PI_3, FRAC_PI_2, 1.230_959_417_340_774_7];

const TRIANGLE: usize = 0;
const QUADRILATERAL: usize = 1;
const DIHEDRAL: usize = 2;

/// Extreme angles of each class, as cosines. An angle above 180 degrees goes on below -1, as
/// `-2 - cos`, so that the order is kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Angles {
    classes: [Span; 3],
}

impl Angles {
    pub(super) const NONE: Self = Self {
        classes: [Span::EMPTY; 3],
    };

    /// Whether no angle of `other` is more extreme than those seen here.
    #[inline]
    pub(super) fn cover(&self, other: &Self) -> bool {
        self.classes
            .iter()
            .zip(&other.classes)
            .all(|(a, b)| a.low <= b.low && b.high <= a.high)
    }

    /// Takes the extremes of both.
    #[inline]
    pub(super) fn merge(&mut self, other: &Self) {
        for (a, b) in self.classes.iter_mut().zip(&other.classes) {
            a.low = a.low.min(b.low);
            a.high = a.high.max(b.high);
        }
    }

    /// Equiangle skew; `None` without an angle.
    ///
    ///     max over classes of max((largest - ideal) / (180 - ideal), (ideal - smallest) / ideal)
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

    /// Takes in the angles of a triangle.
    #[inline]
    pub(super) fn add_triangle(&mut self, p: [Vector; 3]) {
        let span = triangle_cosines(p);
        self.include(TRIANGLE, span);
    }

    /// Takes in the angles of a quadrilateral. Where a corner turns the other way the largest
    /// angle becomes 360 degrees less it, as Verdict has it; with the last two corners in one
    /// place it is a triangle.
    #[inline]
    pub(super) fn add_quadrilateral(&mut self, p: [Vector; 4]) {
        if p[2] == p[3] {
            let span = triangle_cosines([p[0], p[1], p[2]]);
            self.include(QUADRILATERAL, span);
            return;
        }
        let edges: [Vector; 4] = std::array::from_fn(|i| sub(p[(i + 1) % 4], p[i]));
        let units = edges.map(direction);
        let mut span = Span::of((0..4).map(|i| -dot(units[i], units[(i + 1) % 4])));
        let normal = cross(sub(edges[0], edges[2]), sub(edges[1], edges[3]));
        let turns_back = |i: usize| dot(normal, cross(edges[i], edges[(i + 1) % 4])) < 0.0;
        if (0..4).any(turns_back) {
            span.low = -2.0 - span.low.max(-1.0);
        }
        self.include(QUADRILATERAL, span);
    }

    /// Takes in the dihedral angles of a tetrahedron and the angles of its faces, from the unit
    /// vectors along its edges 01, 02, 03, 12, 13, 23.
    #[inline]
    pub(super) fn add_tetrahedron(&mut self, p: &[Vector; 4]) {
        let [ab, ac, ad] = [1, 2, 3].map(|i| direction(sub(p[i], p[0])));
        let [bc, bd] = [2, 3].map(|i| direction(sub(p[i], p[1])));
        let cd = direction(sub(p[3], p[2]));
        let abc = direction(cross(bc, ab));
        let abd = direction(cross(ab, ad));
        let acd = direction(cross(cd, ad));
        let bcd = direction(cross(bc, cd));
        let dihedral = [
            (abc, abd),
            (abc, acd),
            (abc, bcd),
            (abd, acd),
            (abd, bcd),
            (acd, bcd),
        ];
        self.include(DIHEDRAL, Span::of(dihedral.map(|(a, b)| -dot(a, b))));
        let plane = [
            -dot(ab, bc),
            dot(bc, ac),
            dot(ac, ab),
            -dot(ab, bd),
            dot(bd, ad),
            dot(ad, ab),
            -dot(bc, cd),
            dot(cd, bd),
            dot(bd, bc),
            dot(ad, cd),
            -dot(cd, ac),
            dot(ac, ad),
        ];
        self.include(TRIANGLE, Span::of(plane));
    }

    #[inline]
    fn include(&mut self, class: usize, span: Span) {
        let mine = &mut self.classes[class];
        mine.low = mine.low.min(span.low);
        mine.high = mine.high.max(span.high);
    }
}

#[inline]
fn triangle_cosines(p: [Vector; 3]) -> Span {
    let units: [Vector; 3] = std::array::from_fn(|i| direction(sub(p[(i + 1) % 3], p[i])));
    Span::of((0..3).map(|i| -dot(units[i], units[(i + 1) % 3])))
}

/// Unit vector; not a number for an edge of no length, whose angles are then left out.
#[inline]
fn direction(v: Vector) -> Vector {
    scale(v, 1.0 / norm(v))
}

/// The angle in radians behind a cosine that may go on below -1.
fn angle(cosine: f64) -> f64 {
    if cosine < -1.0 - 1e-12 {
        TAU - (-2.0 - cosine).clamp(-1.0, 1.0).acos()
    } else {
        cosine.clamp(-1.0, 1.0).acos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ideal_cells_have_no_skew() {
        let mut square = Angles::NONE;
        square.add_quadrilateral([[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
        assert!(square.skew().expect("it has angles").abs() < 1e-15);
        let mut regular = Angles::NONE;
        regular.add_tetrahedron(&[[1., 1., 1.], [-1., 1., -1.], [1., -1., -1.], [-1., -1., 1.]]);
        assert!(regular.skew().expect("it has angles").abs() < 1e-15);
        assert!(Angles::NONE.skew().is_none());
    }

    #[test]
    fn a_dart_is_worse_than_flat() {
        let mut dart = Angles::NONE;
        dart.add_quadrilateral([[0., 0., 0.], [2., 0., 0.], [0.4, 0.4, 0.], [0., 2., 0.]]);
        assert!(dart.skew().expect("it has angles") > 1.0);
    }
}
