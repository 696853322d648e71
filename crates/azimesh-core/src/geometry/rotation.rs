//! Rotations as vectors: axis times angle in radians, of any number of turns.

use super::transform::Matrix;
use super::vector::{Vector, add, cross, dot, norm, scale, sub, unit};
use std::f64::consts::PI;

/// A unit quaternion whose vector part is at most this long stands for whole turns: the direction
/// of its axis is lost to rounding.
const NO_AXIS: f64 = 1e-14;

/// `exp(theta) v`: the vector `v` turned by the rotation vector `theta` (radians).
///
/// ```text
/// v' = v + 2 a c (theta x v) + 2 a^2 theta x (theta x v),   a = sin(t/2) / t,  c = cos(t/2),  t = |theta|
/// ```
///
/// Rodrigues' formula in half angles, in which nothing cancels: right to round-off for every
/// length of `theta`, zero included. One square root, one division, one sine and cosine.
#[inline]
pub fn rotate_by(theta: Vector, v: Vector) -> Vector {
    let t = norm(theta);
    let (sin, cos) = (0.5 * t).sin_cos();
    let a = if t > 0.0 { sin / t } else { 0.5 };
    let once = cross(theta, v);
    let twice = cross(theta, once);
    let (first, second) = (2.0 * a * cos, 2.0 * a * a);
    [
        v[0] + (first * once[0] + second * twice[0]),
        v[1] + (first * once[1] + second * twice[1]),
        v[2] + (first * once[2] + second * twice[2]),
    ]
}

/// The rotation vector of a rotation matrix, with `|theta| <= pi`: the inverse of [`rotate_by`].
///
/// Right to round-off for tiny rotations, whose vector is small, and near half a turn, where of two
/// opposite vectors either may come out at exactly half a turn.
#[cfg(test)]
pub fn rotation_vector(rotation: &Matrix) -> Vector {
    let q = Quaternion::of_matrix(rotation);
    let q = if q.w < 0.0 { q.negative() } else { q };
    q.rotation_vector_near([0.0; 3])
}

/// Of all rotation vectors of a rotation matrix, which differ by turns about its axis, the one nearest
/// to `previous`.
pub fn rotation_vector_near(rotation: &Matrix, previous: Vector) -> Vector {
    Quaternion::of_matrix(rotation).nearest_vector(previous)
}

/// A unit quaternion `w + v`: a rotation by `theta` has `w = cos(|theta|/2)` and
/// `v = sin(|theta|/2) theta/|theta|`, so that the signs distinguish one turn from two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quaternion {
    /// Scalar part.
    pub w: f64,
    /// Vector part.
    pub v: Vector,
}

impl Quaternion {
    /// Turns nothing.
    pub const IDENTITY: Self = Self {
        w: 1.0,
        v: [0.0; 3],
    };

    /// The rotation by `angle` radians about a unit axis.
    pub fn rotation(axis: Vector, angle: f64) -> Self {
        let (sin, cos) = (0.5 * angle).sin_cos();
        Self {
            w: cos,
            v: scale(axis, sin),
        }
    }

    /// A quaternion of a rotation matrix; the other one is its negative. The largest component is
    /// taken from the diagonal, the others divided by it (Shepperd 1978), so that nothing cancels.
    pub fn of_matrix(m: &Matrix) -> Self {
        let [x, y, z] = [m[0][0], m[1][1], m[2][2]];
        let squares = [
            1.0 + x + y + z,
            1.0 + x - y - z,
            1.0 - x + y - z,
            1.0 - x - y + z,
        ];
        let odd = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]];
        let even = [m[2][1] + m[1][2], m[0][2] + m[2][0], m[1][0] + m[0][1]];
        let largest = (1..4).fold(
            0,
            |best, i| if squares[i] > squares[best] { i } else { best },
        );
        let twice = squares[largest].sqrt();
        let rest = 0.5 / twice;
        match largest {
            0 => Self {
                w: 0.5 * twice,
                v: scale(odd, rest),
            },
            i => {
                let mut v = [0.0; 3];
                for (j, component) in v.iter_mut().enumerate() {
                    *component = match i - 1 == j {
                        true => 0.5 * twice,
                        // The third axis names the pair of the other two.
                        false => rest * even[3 - (i - 1) - j],
                    };
                }
                Self {
                    w: rest * odd[i - 1],
                    v,
                }
            }
        }
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        let crossed = add(scale(next.v, self.w), cross(next.v, self.v));
        Self {
            w: next.w * self.w - dot(next.v, self.v),
            v: add(scale(self.v, next.w), crossed),
        }
    }

    /// The rotation that undoes this one.
    #[must_use]
    pub fn inverse(self) -> Self {
        Self {
            w: self.w,
            v: scale(self.v, -1.0),
        }
    }

    fn negative(self) -> Self {
        Self {
            w: -self.w,
            v: scale(self.v, -1.0),
        }
    }

    /// Of all rotation vectors of this quaternion and its negative, which are one rotation and differ by turns about
    /// its axis, the one nearest to `previous`.
    pub fn nearest_vector(self, previous: Vector) -> Vector {
        let [a, b] = [self, self.negative()].map(|q| q.rotation_vector_near(previous));
        if norm(sub(a, previous)) <= norm(sub(b, previous)) {
            a
        } else {
            b
        }
    }

    /// Of the rotation vectors of this quaternion, which differ by two turns about its axis, the one
    /// nearest to `previous`.
    ///
    /// At whole turns the axis is lost: there the vector keeps the direction of `previous`.
    pub fn rotation_vector_near(self, previous: Vector) -> Vector {
        let sin = norm(self.v);
        let (axis, angle) = match unit(previous) {
            _ if sin > NO_AXIS => (scale(self.v, 1.0 / sin), 2.0 * sin.atan2(self.w)),
            Some(axis) => (axis, if self.w < 0.0 { 2.0 * PI } else { 0.0 }),
            None => return scale(self.v, 2.0 / self.w),
        };
        let turns = ((dot(axis, previous) - angle) / (4.0 * PI)).round();
        match angle + 4.0 * PI * turns {
            0.0 => scale(self.v, 2.0 / self.w),
            angle => scale(axis, angle),
        }
    }
}

/// A rigid motion about a centre `c`: `x' = c + tau + exp(theta) (x - c)`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Twist {
    /// Rotation vector in radians, of any number of turns.
    pub theta: Vector,
    /// Displacement of the centre, in mesh units.
    pub tau: Vector,
}

impl Twist {
    /// Moves `x` by the part `weight` of the motion: `c + w tau + exp(w theta) (x - c)`.
    #[inline]
    pub fn apply(&self, centre: Vector, weight: f64, x: Vector) -> Vector {
        let arm = [x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]];
        let turned = rotate_by(scale(self.theta, weight), arm);
        add(centre, add(scale(self.tau, weight), turned))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Transform;
    use super::super::vector::{distance, sub};
    use super::*;
    use proptest::prelude::*;

    const AXES: [Vector; 4] = [
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.6, 0.8],
        [-0.48, 0.6, 0.64],
    ];
    const ANGLES: [f64; 9] = [
        1e-300,
        1e-160,
        1e-12,
        1e-5,
        1.0,
        2.0,
        3.0,
        PI - 1e-6,
        PI - 1e-12,
    ];

    #[test]
    fn a_rotation_vector_turns_as_the_matrix_does() {
        let v = [0.3, -2.0, 1.1];
        for axis in AXES {
            for angle in [0.0, 1e-9, 0.1, 3.0, PI, 4.0, 2.0 * PI, 20.0, -7.0] {
                let matrix = Transform::rotation(axis, [0.0; 3], angle);
                let found = rotate_by(scale(axis, angle), v);
                assert!(distance(found, matrix.turn(v)) < 3e-14, "{axis:?} {angle}");
            }
        }
    }

    #[test]
    fn tiny_rotations_move_by_their_cross_product() {
        for size in [1e-8, 1e-12, 1e-100, 1e-170] {
            let theta = [0.0, 0.0, size];
            let moved = rotate_by(theta, [1.0, 0.0, 0.0]);
            assert!((moved[1] / size - 1.0).abs() < 1e-15, "{size}");
        }
        assert_eq!(rotate_by([0.0; 3], [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn the_vector_of_a_matrix_has_its_axis_and_angle_from_tiny_to_half_a_turn() {
        for axis in AXES {
            for angle in ANGLES {
                let matrix = Transform::rotation(axis, [0.0; 3], angle).rotation;
                let found = rotation_vector(&matrix);
                let error = distance(found, scale(axis, angle)) / angle;
                assert!(error < 4e-15, "{axis:?} {angle}: {error:e}");
            }
            let half = rotation_vector(&Transform::rotation(axis, [0.0; 3], PI).rotation);
            let either = |sign: f64| distance(half, scale(axis, sign * PI)) < 1e-14;
            assert!(either(1.0) || either(-1.0), "{half:?}");
        }
        assert_eq!(rotation_vector(&Transform::IDENTITY.rotation), [0.0; 3]);
    }

    #[test]
    fn the_vector_near_another_has_its_number_of_turns() {
        for turns in [-1.0, 0.0, 0.6, 1.0, 1.7, 3.0] {
            let angle = 2.0 * PI * turns + 0.4;
            let matrix = Transform::rotation(AXES[3], [0.0; 3], angle).rotation;
            let near = scale(AXES[3], angle - 0.3);
            let found = rotation_vector_near(&matrix, near);
            assert!(distance(found, scale(AXES[3], angle)) < 1e-13, "{turns}");
        }
    }

    #[test]
    fn whole_turns_keep_the_direction_they_came_with() {
        let axis = AXES[3];
        for turns in [1.0, 2.0, 3.0] {
            let before = scale(axis, 2.0 * PI * turns - 0.3);
            let q = Quaternion::rotation(axis, 2.0 * PI * turns);
            let found = q.rotation_vector_near(before);
            let error = distance(found, scale(axis, 2.0 * PI * turns));
            assert!(error < 1e-13, "{turns} turns: {found:?}");
        }
    }

    #[test]
    fn quaternions_follow_one_another_as_matrices_do() {
        let (a, b) = ((AXES[2], 2.1), (AXES[3], -1.3));
        let turn = |(axis, angle): (Vector, f64)| Transform::rotation(axis, [0.0; 3], angle);
        let both = turn(a).then(&turn(b));
        let q = Quaternion::rotation(a.0, a.1).then(Quaternion::rotation(b.0, b.1));
        let theta = q.rotation_vector_near([0.0; 3]);
        let v = [0.1, 0.2, -0.3];
        assert!(distance(rotate_by(theta, v), both.turn(v)) < 1e-15);
        let back = q.then(q.inverse());
        assert!((back.w - 1.0).abs() < 1e-15 && norm(back.v) < 1e-15);
    }

    proptest! {
        #[test]
        fn vector_and_matrix_are_inverse(theta in prop::array::uniform3(-1.8..1.8)) {
            let matrix = Transform::rotation(theta, [0.0; 3], norm(theta)).rotation;
            let found = rotation_vector(&matrix);
            prop_assert!(distance(found, theta) < 4e-15 * norm(theta).max(1.0), "{found:?}");
        }

        #[test]
        fn lengths_are_kept(theta in prop::array::uniform3(-20.0..20.0), v in prop::array::uniform3(-1.0..1.0)) {
            let turned = rotate_by(theta, v);
            prop_assert!((norm(turned) - norm(v)).abs() < 4e-15);
            let back = rotate_by(scale(theta, -1.0), turned);
            prop_assert!(norm(sub(back, v)) < 1e-14);
        }
    }
}
