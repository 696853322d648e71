//! Lines of nodes from a wall to the outer boundary.

use super::spacing::{growth, height};
use azimesh_core::geometry::vector::{Vector, add, distance, norm, scale, sub};

/// Part of the distance to the outer boundary that a ray starts with; a smaller one bends earlier.
pub const START: f64 = 0.5;

/// A line from a wall node, along its normal, bending towards a node of the outer boundary.
///
/// Hermite's cubic `x(u)` with `x(0) = wall`, `x'(0) = D normal`, `x(1) = outer`,
/// `x'(1) = outer - wall`, `D = start |outer - wall|`. Nodes are at `u = first height(layer) / D`, so
/// the first cell is `first` high to `O(first / D)`.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    wall: Vector,
    outer: Vector,
    n_layers: usize,
    /// Coefficients of `u`, `u^2`, `u^3`.
    cubic: [Vector; 3],
    first: f64,
    growth: f64,
}

impl Ray {
    /// The ray from `wall` along `normal`, of length one, to `outer` in `n_layers` layers; it starts with a part `start`
    /// of the distance.
    pub fn new(
        [wall, normal, outer]: [Vector; 3],
        start: f64,
        first: f64,
        n_layers: usize,
    ) -> Self {
        let length = distance(wall, outer);
        let chord = sub(outer, wall);
        let speed = start * length;
        let along = scale(normal, speed);
        // x = wall + u a + u^2 b + u^3 c with b = 2 (chord - a) and c = a - chord.
        let bend = sub(chord, along);
        Self {
            wall,
            outer,
            n_layers,
            cubic: [along, scale(bend, 2.0), scale(bend, -1.0)],
            first: first / speed,
            growth: growth(first / speed, 1.0, n_layers),
        }
    }

    /// A straight ray of `n_layers` layers from this one's last node, the first of them as high as
    /// this one's last, to the point that `far` gives.
    pub fn onward(&self, far: impl Fn(Vector) -> Vector, n_layers: usize) -> Self {
        let first = distance(self.outer, self.node(self.n_layers - 1));
        let outer = far(self.outer);
        let along = sub(outer, self.outer);
        let length = norm(along);
        Self {
            wall: self.outer,
            outer,
            n_layers,
            cubic: [along, [0.0; 3], [0.0; 3]],
            first: first / length,
            growth: growth(first / length, 1.0, n_layers),
        }
    }

    /// The node of a layer; layer zero is the wall, the last one the outer boundary.
    #[inline]
    pub fn node(&self, layer: usize) -> Vector {
        if layer == self.n_layers {
            return self.outer;
        }
        let u = self.first * height(self.growth, layer);
        let [a, b, c] = self.cubic;
        let bend = add(b, scale(c, u));
        add(self.wall, scale(add(a, scale(bend, u)), u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_starts_along_the_normal_with_the_first_cell_and_ends_outside() {
        let outer = [2.0, 1.0, 0.5];
        let ray = Ray::new([[0.0; 3], [0.0, 1.0, 0.0], outer], START, 1e-5, 40);
        assert_eq!(ray.node(0), [0.0; 3]);
        assert!((ray.node(1)[1] - 1e-5).abs() < 1e-9);
        assert_eq!(ray.node(40), outer);
    }
}
