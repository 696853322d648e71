//! Rigid transforms that change with time.

use super::transform::Transform;
use super::vector::{Vector, add, cross, scale, sub};
use serde::{Deserialize, Serialize};

/// A rigid transform at an instant, with the velocity that it gives to the points it places:
///
/// ```text
/// x' = R x + t,   v' = R v + omega x x' + shift
/// ```
///
/// for a point at `x` that itself moves with `v`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Moving {
    /// The transform at the instant.
    pub map: Transform,
    /// Angular velocity, in radians a second.
    pub omega: Vector,
    /// Velocity of the place that is at the origin, in mesh units a second.
    pub shift: Vector,
}

impl Moving {
    /// A transform that does not change.
    pub fn still(map: Transform) -> Self {
        Self {
            map,
            omega: [0.0; 3],
            shift: [0.0; 3],
        }
    }

    /// A rotation by `angle` radians about the unit vector `axis` through `origin`, which grows by
    /// `rate` radians a second.
    pub fn rotation(axis: Vector, origin: Vector, angle: f64, rate: f64) -> Self {
        let map = Transform::rotation(axis, origin, angle);
        Self::turning(map, origin, scale(axis, rate))
    }

    /// A transform that leaves `origin` where it is, and turns by `omega` radians a second.
    pub fn turning(map: Transform, origin: Vector, omega: Vector) -> Self {
        Self {
            map,
            omega,
            shift: cross(origin, omega),
        }
    }

    /// A translation that grows by `rate` a second.
    pub fn translation(by: Vector, rate: Vector) -> Self {
        Self {
            map: Transform::translation(by),
            omega: [0.0; 3],
            shift: rate,
        }
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        let omega = next.map.turn(self.omega);
        let shift = add(next.shift, next.map.turn(self.shift));
        Self {
            map: self.map.then(&next.map),
            omega: add(omega, next.omega),
            shift: sub(shift, cross(omega, next.map.translation)),
        }
    }

    /// The velocity of a point at `x` that itself moves with `v`.
    pub fn velocity(&self, x: Vector, v: Vector) -> Vector {
        let turned = cross(self.omega, self.map.apply(x));
        add(self.map.turn(v), add(turned, self.shift))
    }

    /// Maps a point at `x` that moves with `v`: its new place, and its velocity there.
    pub fn carry(&self, (x, v): (Vector, Vector)) -> (Vector, Vector) {
        (self.map.apply(x), self.velocity(x, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{distance, unit};

    /// Three moves one after another at time `t`.
    fn at(t: f64) -> Moving {
        let axis = unit([1.0, 2.0, -0.5]).expect("a direction");
        let turn = Moving::rotation(axis, [0.3, -1.0, 0.2], 0.7 + 1.3 * t, 1.3);
        let shift = Moving::translation([0.1 + t, -2.0 * t, 0.3], [1.0, -2.0, 0.0]);
        let second = Moving::rotation([0.0, 0.0, 1.0], [-2.0, 0.5, 0.0], 0.2 - 0.8 * t, -0.8);
        turn.then(&shift).then(&second)
    }

    #[test]
    fn velocities_are_the_differences_of_places() {
        let h = 1e-6;
        for x in [[0.0; 3], [1.0, 2.0, -3.0]] {
            let v = [0.4, -0.1, 0.2];
            let place = |t: f64| at(t).map.apply(add(x, scale(v, t)));
            let difference = scale(sub(place(h), place(-h)), 0.5 / h);
            let found = at(0.0).velocity(x, v);
            assert!(
                distance(found, difference) < 1e-9,
                "{found:?} {difference:?}"
            );
        }
    }

    #[test]
    fn what_stays_has_no_velocity() {
        let still = Moving::still(at(0.0).map);
        assert_eq!(still.velocity([1.0, 2.0, 3.0], [0.0; 3]), [0.0; 3]);
    }
}
