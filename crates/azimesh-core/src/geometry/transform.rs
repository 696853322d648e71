//! Rigid transforms: a rotation and a translation.

use super::vector::{Vector, add, cross, dot, scale, sub, unit};
use serde::{Deserialize, Serialize};

/// Rows of a 3 by 3 matrix.
pub type Matrix = [[f64; 3]; 3];

/// `x' = rotation x + translation`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Rotation matrix, by rows.
    pub rotation: Matrix,
    /// Added after the rotation, in mesh units.
    pub translation: Vector,
}

impl Transform {
    /// Moves nothing.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// A translation.
    pub fn translation(by: Vector) -> Self {
        Self {
            translation: by,
            ..Self::IDENTITY
        }
    }

    /// A right-handed rotation by `angle` radians about the axis `direction` through `origin`.
    /// An axis of no length turns nothing.
    pub fn rotation(direction: Vector, origin: Vector, angle: f64) -> Self {
        let rotation = unit(direction).map_or(Self::IDENTITY.rotation, |u| axis_angle(u, angle));
        let turn = Self {
            rotation,
            translation: [0.0; 3],
        };
        Self {
            rotation,
            translation: sub(origin, turn.apply(origin)),
        }
    }

    /// The image of a point.
    #[inline]
    pub fn apply(&self, x: Vector) -> Vector {
        add(self.turn(x), self.translation)
    }

    /// The image of a direction: rotated only.
    #[inline]
    pub fn turn(&self, x: Vector) -> Vector {
        let [a, b, c] = self.rotation;
        [dot(a, x), dot(b, x), dot(c, x)]
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        let columns = transpose(self.rotation).map(|column| next.turn(column));
        Self {
            rotation: transpose(columns),
            translation: next.apply(self.translation),
        }
    }

    /// The transform that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let back = Self {
            rotation: transpose(self.rotation),
            translation: [0.0; 3],
        };
        Self {
            translation: scale(back.turn(self.translation), -1.0),
            ..back
        }
    }
}

fn transpose(m: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// Rodrigues' formula for a unit axis.
fn axis_angle(u: Vector, angle: f64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    let column = |e: Vector| {
        let along = scale(u, dot(u, e) * (1.0 - cos));
        add(add(scale(e, cos), scale(cross(u, e), sin)), along)
    };
    transpose([
        column([1.0, 0.0, 0.0]),
        column([0.0, 1.0, 0.0]),
        column([0.0, 0.0, 1.0]),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::vector::distance;
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turn = Transform::rotation([0.0, 0.0, 2.0], [0.0; 3], std::f64::consts::FRAC_PI_2);
        assert!(distance(turn.apply([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]) < 1e-15);
    }

    #[test]
    fn the_inverse_undoes_and_the_origin_stays() {
        let origin = [0.3, -2.0, 1.0];
        let turn = Transform::rotation([1.0, 2.0, -0.5], origin, 0.7);
        assert!(distance(turn.apply(origin), origin) < 1e-15);
        let both = turn.then(&Transform::translation([1.0, 2.0, 3.0]));
        let x = [0.1, 0.2, 0.3];
        assert!(distance(both.then(&both.inverse()).apply(x), x) < 1e-15);
    }
}
