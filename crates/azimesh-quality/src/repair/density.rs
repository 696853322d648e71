//! The functional of one simplex: its value, its slope, and a positive approximation of its curvature.
//!
//! ```text
//! f = (1 - theta) |J|^2 / (d chi^(2/d)) + theta (D^2 + 1) / (2 chi),   D = det J,
//! chi(D) = (D + sqrt(eps^2 + D^2)) / 2
//! ```
//!
//! `J` takes the simplex from its target shape to where it is; `d` is the dimension. In a plane `J` has the last row
//! and column of the identity, which count neither in `|J|` nor in `d`.
//!
//! Sources: V. Garanzha, I. Kaporin, L. Kudryavtseva, F. Protais, N. Ray, D. Sokolov, Foldover-free maps in 50 lines
//! of code, ACM TOG 40(4), 2021; the eigenvectors of the curvature are from B. Smith, F. de Goes, T. Kim, Analytic
//! eigensystems for isotropic distortion energies, ACM TOG 38(1), 2019.

use super::singular::{Columns, decompose, decompose_plane, positive_part};
use azimesh_core::geometry::vector::{Vector, add, cross, dot, scale};

/// Eigenvalues are raised to this part of the largest.
const LEAST: f64 = 1e-8;

/// The space of the simplices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Space {
    /// Triangles in a plane of constant z.
    Plane,
    /// Tetrahedra.
    Solid,
}

/// `chi(D)`.
#[inline(always)]
pub(super) fn chi(eps: f64, d: f64) -> f64 {
    let root = (eps * eps + d * d).sqrt();
    if d > 0.0 {
        0.5 * (d + root)
    } else {
        0.5 * eps * eps / (root - d)
    }
}

/// Determinant and squared size of `J`.
#[inline(always)]
fn invariants(space: Space, j: &Columns) -> (f64, f64) {
    let square = dot(j[0], j[0]) + dot(j[1], j[1]);
    match space {
        Space::Plane => (j[0][0] * j[1][1] - j[0][1] * j[1][0], square),
        Space::Solid => (dot(j[0], cross(j[1], j[2])), square + dot(j[2], j[2])),
    }
}

/// `chi^(-2/d)`.
#[inline(always)]
fn shrink(space: Space, chi: f64) -> f64 {
    match space {
        Space::Plane => 1.0 / chi,
        Space::Solid => {
            let root = chi.cbrt();
            1.0 / (root * root)
        }
    }
}

/// The value, and the determinant.
#[inline(always)]
pub(super) fn value(space: Space, theta: f64, eps: f64, j: &Columns) -> (f64, f64) {
    let (d, square) = invariants(space, j);
    let c = chi(eps, d);
    let shape = (1.0 - theta) / space.dimension() * square * shrink(space, c);
    (shape + 0.5 * theta * (d * d + 1.0) / c, d)
}

impl Space {
    #[inline(always)]
    pub(super) fn dimension(self) -> f64 {
        match self {
            Self::Plane => 2.0,
            Self::Solid => 3.0,
        }
    }

    /// Edges of a simplex at its corner.
    #[inline(always)]
    pub(super) fn n_edges(self) -> usize {
        match self {
            Self::Plane => 2,
            Self::Solid => 3,
        }
    }
}

/// Value, slope and curvature of `f` at `J`.
pub(super) struct Density {
    /// `f`.
    pub value: f64,
    /// `det J`.
    pub determinant: f64,
    /// `df/dJ`, by columns.
    pub slope: Columns,
    u: Columns,
    v: Columns,
    /// Of the pairs (1, 2), (2, 0), (0, 1): half the sum of the eigenvalues that belong to them, and half the
    /// difference.
    sums: Vector,
    differences: Vector,
    /// Curvature along the singular values.
    along: [[f64; 3]; 3],
}

impl Density {
    /// At `j`.
    #[inline(always)]
    pub(super) fn new(space: Space, theta: f64, eps: f64, j: &Columns) -> Self {
        let (d, square) = invariants(space, j);
        let (p, a) = (2.0 / space.dimension(), (1.0 - theta) / space.dimension());
        let c = chi(eps, d);
        let root = (eps * eps + d * d).sqrt();
        let c1 = c / root;
        let c2 = 0.5 * eps * eps / (root * root * root);
        let power = shrink(space, c);
        let (r1, r2) = (c1 / c, c2 / c);
        // Derivatives with respect to |J|^2 and D.
        let f_i = a * power;
        let f_id = -p * f_i * r1;
        let size = 0.5 * theta * (d * d + 1.0) / c;
        let f_d = square * f_id + theta * d / c - size * r1;
        let f_dd = square * f_i * p * ((p + 1.0) * r1 * r1 - r2)
            + theta * (1.0 - 2.0 * d * r1) / c
            + size * (2.0 * r1 * r1 - r2);
        let found = match space {
            Space::Plane => decompose_plane(j),
            Space::Solid => decompose(j),
        };
        let mut density = Self {
            value: f_i * square + size,
            determinant: d,
            slope: slope(space, j, f_i, f_d),
            u: found.u,
            v: found.v,
            sums: [0.0; 3],
            differences: [0.0; 3],
            along: [[0.0; 3]; 3],
        };
        density.add_curvature(space, found.s, [f_i, f_d, f_id, f_dd]);
        density
    }

    /// Of `|J|^2 / 2` in place of `f`, whose curvature is the identity.
    #[inline(always)]
    pub(super) fn of_square(space: Space, j: &Columns) -> Self {
        let (determinant, square) = invariants(space, j);
        let mut slope = *j;
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut along = unit;
        // In a plane the last edge is no unknown.
        if space == Space::Plane {
            slope[2] = [0.0; 3];
            along[2][2] = 0.0;
        }
        Self {
            value: 0.5 * square,
            determinant,
            slope,
            u: unit,
            v: unit,
            sums: match space {
                Space::Plane => [0.0, 0.0, 1.0],
                Space::Solid => [1.0; 3],
            },
            differences: [0.0; 3],
            along,
        }
    }

    #[inline(always)]
    fn add_curvature(&mut self, space: Space, s: Vector, [f_i, f_d, f_id, f_dd]: [f64; 4]) {
        let n = space.n_edges();
        let cofactors = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
        let mut along = [[0.0; 3]; 3];
        for i in 0..n {
            for k in 0..n {
                along[i][k] = 2.0 * f_id * (s[i] * cofactors[k] + cofactors[i] * s[k])
                    + f_dd * cofactors[i] * cofactors[k];
                if i == k {
                    along[i][k] += 2.0 * f_i;
                } else {
                    along[i][k] += f_d * s[3 - i - k];
                }
            }
        }
        if n == 2 {
            along[2][2] = 1.0;
        }
        self.along = positive_part(&along);
        let trace = self.along[0][0] + self.along[1][1] + self.along[2][2];
        let largest = trace.max(2.0 * f_i);
        for k in 0..n {
            self.along[k][k] += LEAST * largest;
        }
        let pairs = if n == 2 { 2..3 } else { 0..3 };
        for pair in pairs {
            let turn = f_d * s[pair];
            let floor = LEAST * largest;
            let (twist, flip) = ((2.0 * f_i + turn).max(floor), (2.0 * f_i - turn).max(floor));
            self.sums[pair] = 0.5 * (twist + flip);
            self.differences[pair] = 0.5 * (flip - twist);
        }
        if n == 2 {
            self.along[2][2] = 0.0;
        }
    }

    /// A vector of the target in the frame of the right singular vectors.
    #[inline(always)]
    pub(super) fn right(&self, g: Vector) -> Vector {
        [dot(self.v[0], g), dot(self.v[1], g), dot(self.v[2], g)]
    }

    /// The curvature between two edges, whose vectors of the target are `g` and `h` in the frame of the right
    /// singular vectors; by rows.
    #[inline(always)]
    pub(super) fn block(&self, g: Vector, h: Vector) -> [f64; 9] {
        let mut m = self.along;
        for i in 0..3 {
            for k in 0..3 {
                m[i][k] *= g[i] * h[k];
            }
        }
        for (pair, (i, k)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
            let (sum, difference) = (self.sums[pair], self.differences[pair]);
            m[i][i] += sum * g[k] * h[k];
            m[k][k] += sum * g[i] * h[i];
            m[i][k] += difference * g[k] * h[i];
            m[k][i] += difference * g[i] * h[k];
        }
        self.turned(&m)
    }

    /// `U m U^T`.
    #[inline(always)]
    fn turned(&self, m: &[[f64; 3]; 3]) -> [f64; 9] {
        let u = &self.u;
        let mut left = [[0.0; 3]; 3];
        for i in 0..3 {
            for k in 0..3 {
                left[i][k] = u[0][i] * m[0][k] + u[1][i] * m[1][k] + u[2][i] * m[2][k];
            }
        }
        let mut whole = [0.0; 9];
        for i in 0..3 {
            for k in 0..3 {
                whole[3 * i + k] =
                    left[i][0] * u[0][k] + left[i][1] * u[1][k] + left[i][2] * u[2][k];
            }
        }
        whole
    }
}

/// `df/dJ = 2 f_I J + f_D cof J`, by columns.
#[inline(always)]
fn slope(space: Space, j: &Columns, f_i: f64, f_d: f64) -> Columns {
    let cofactors = match space {
        Space::Plane => [[j[1][1], -j[1][0], 0.0], [-j[0][1], j[0][0], 0.0], [0.0; 3]],
        Space::Solid => [cross(j[1], j[2]), cross(j[2], j[0]), cross(j[0], j[1])],
    };
    let mut slope = [[0.0; 3]; 3];
    for k in 0..space.n_edges() {
        slope[k] = add(scale(j[k], 2.0 * f_i), scale(cofactors[k], f_d));
    }
    slope
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn columns(e: &[f64; 9], space: Space) -> Columns {
        match space {
            Space::Plane => [[e[0], e[1], 0.0], [e[2], e[3], 0.0], [0.0, 0.0, 1.0]],
            Space::Solid => [[e[0], e[1], e[2]], [e[3], e[4], e[5]], [e[6], e[7], e[8]]],
        }
    }

    fn moved(j: &Columns, by: &Columns, t: f64) -> Columns {
        std::array::from_fn(|k| add(j[k], scale(by[k], t)))
    }

    fn form(density: &Density, by: &Columns) -> f64 {
        // Edges of a unit target: `J` has the edges as its columns.
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut sum = 0.0;
        for a in 0..3 {
            for b in 0..3 {
                let block = density.block(density.right(unit[a]), density.right(unit[b]));
                for i in 0..3 {
                    for k in 0..3 {
                        sum += by[a][i] * block[3 * i + k] * by[b][k];
                    }
                }
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn the_square_has_the_identity_as_its_curvature(e in prop::array::uniform9(-1.5f64..1.5), by in prop::array::uniform9(-1.0f64..1.0), plane: bool) {
            let space = if plane { Space::Plane } else { Space::Solid };
            let mut by = columns(&by, space);
            if plane {
                by[2] = [0.0; 3];
            }
            let j = columns(&e, space);
            let n = space.n_edges();
            let density = Density::of_square(space, &j);
            let square = |j: &Columns| (0..n).map(|k| 0.5 * dot(j[k], j[k])).sum::<f64>();
            prop_assert!((density.value - square(&j)).abs() < 1e-12);
            let slope: f64 = (0..3).map(|k| dot(density.slope[k], by[k])).sum();
            let wanted = square(&moved(&j, &by, 1.0)) - square(&j) - square(&by);
            prop_assert!((slope - wanted).abs() < 1e-12);
            prop_assert!((form(&density, &by) - 2.0 * square(&by)).abs() < 1e-12);
        }

        #[test]
        fn the_slope_is_that_of_the_value(e in prop::array::uniform9(-1.5f64..1.5), by in prop::array::uniform9(-1.0f64..1.0), plane: bool) {
            let space = if plane { Space::Plane } else { Space::Solid };
            let mut by = columns(&by, space);
            if plane {
                by[2] = [0.0; 3];
            }
            let (j, eps, t) = (columns(&e, space), 0.3, 1e-6);
            let at = |t: f64| value(space, 0.5, eps, &moved(&j, &by, t)).0;
            let density = Density::new(space, 0.5, eps, &j);
            prop_assert!((density.value - at(0.0)).abs() < 1e-10 * at(0.0));
            let wanted = (at(t) - at(-t)) / (2.0 * t);
            let found: f64 = (0..3).map(|k| dot(density.slope[k], by[k])).sum();
            prop_assert!((found - wanted).abs() < 1e-4 * wanted.abs().max(10.0), "{found} {wanted}");
        }

        #[test]
        fn the_curvature_is_positive_and_near_the_identity_exact(e in prop::array::uniform9(-1.0f64..1.0), by in prop::array::uniform9(-1.0f64..1.0), plane: bool, near: bool) {
            let space = if plane { Space::Plane } else { Space::Solid };
            let mut by = columns(&by, space);
            let mut j = columns(&e, space);
            if near {
                let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                j = moved(&unit, &j, 0.02);
            }
            if plane {
                by[2] = [0.0; 3];
                j[2] = [0.0, 0.0, 1.0];
            }
            let (eps, t) = (0.1, 1e-4);
            let found = form(&Density::new(space, 0.5, eps, &j), &by);
            prop_assert!(found >= 0.0);
            let at = |t: f64| value(space, 0.5, eps, &moved(&j, &by, t)).0;
            let wanted = (at(t) + at(-t) - 2.0 * at(0.0)) / (t * t);
            if near {
                // Rotations have next to none, which is cut off at zero.
                prop_assert!((found - wanted).abs() < 0.1, "{found} {wanted}");
            } else {
                prop_assert!(found >= wanted - 1e-3 * wanted.abs().max(1.0), "{found} {wanted}");
            }
        }
    }
}
