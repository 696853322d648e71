//! A ring around the rotation axis of a body, free of all other surfaces, such as the gap between a body and a fixed
//! circle or cylinder around it; and the weight of the rotation at nodes in it.
//!
//! ```text
//! s = ln(r / r_0) / ln(R / r_0),    w = 1 - 4/3 s^2  up to s = 1/2,  4/3 (1 - s)  beyond;   1 within r_0,  0 beyond R
//! ```
//!
//! In space the weight also decreases along the axis, linearly from the ends of the body to the surfaces before and
//! behind it. A rotation about the axis by `w theta` keeps every circle about the axis for any `w`, so it folds only cells
//! that are too coarse for its shear `theta r dw/dr`. The shear starts at zero at the body: thin radial cells, such as those
//! of a boundary layer behind an edge, would not survive a jump. In the outer half it is the same at every radius.

use super::layer::Turning;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, scale, sub, unit};
use azimesh_core::parallel;
use azimesh_rbf::modes::{Modes, RigidSurface};
use serde::{Deserialize, Serialize};

/// Least ratio of the radii of a ring.
const LEAST_RATIO: f64 = 1.5;
/// Sines of angles below this count as parallel rotation vectors.
const PARALLEL: f64 = 1e-9;
/// Points closer to the axis than this part of the outer radius do not belong to the wall around the ring.
const WALL: f64 = 0.99;

/// The ring of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ring {
    /// The axis: a point of it, and its direction.
    centre: Vector,
    axis: Vector,
    /// `r_0`, the radius of the body.
    pub inner: f64,
    /// `R`, within which there is no other surface.
    pub outer: f64,
    /// The ends of the body along the axis.
    body: [f64; 2],
    /// The nearest other surfaces before and behind it along the axis; infinite if there are none.
    free: [f64; 2],
}

impl Ring {
    /// Finds the ring of a body with the rotation vectors `theta` about `centre`; `None` if they have no common axis, or if
    /// another surface is too close. Points that `may_turn` about an axis are not obstacles: points of a sliding plane across
    /// the axis, for example.
    pub fn around(
        surface: RigidSurface<'_>,
        body: usize,
        centre: Vector,
        theta: &[Vector],
        may_turn: impl Fn(usize, Vector) -> bool,
    ) -> Option<Self> {
        let axis = common_axis(theta)?;
        let mut ring = Self {
            centre,
            axis,
            inner: 0.0,
            outer: f64::INFINITY,
            body: [f64::INFINITY, f64::NEG_INFINITY],
            free: [f64::NEG_INFINITY, f64::INFINITY],
        };
        let mut others = Vec::new();
        for (at, (point, of)) in surface.points.iter().zip(surface.body).enumerate() {
            let (r, z) = ring.cylindrical(*point);
            if of.map(usize::from) == Some(body) {
                ring.inner = ring.inner.max(r);
                ring.body = [ring.body[0].min(z), ring.body[1].max(z)];
            } else if !may_turn(at, axis) {
                others.push((r, z));
            }
        }
        ring.find_room(&others);
        let is_wide = ring.outer.is_finite() && ring.outer >= LEAST_RATIO * ring.inner;
        (is_wide && ring.inner > 0.0).then_some(ring)
    }

    /// Finds the extent of the ring between other surface points, given by radius and axial position.
    fn find_room(&mut self, others: &[(f64, f64)]) {
        // Includes the body's axial range, extended by its radius at both ends.
        let [from, to] = [self.body[0] - self.inner, self.body[1] + self.inner];
        let beside = others.iter().filter(|(_, z)| (from..=to).contains(z));
        let wall = beside.map(|(r, _)| *r).fold(f64::INFINITY, f64::min);
        for &(r, z) in others {
            if r < WALL * wall && z < from {
                self.free[0] = self.free[0].max(z);
            } else if r < WALL * wall && z > to {
                self.free[1] = self.free[1].min(z);
            }
        }
        let within = others
            .iter()
            .filter(|(_, z)| self.free[0] < *z && *z < self.free[1]);
        self.outer = within.map(|(r, _)| *r).fold(f64::INFINITY, f64::min);
    }

    /// Returns the distance from the axis, and the axial position.
    #[inline]
    fn cylindrical(&self, x: Vector) -> (f64, f64) {
        let arm = sub(x, self.centre);
        let z = dot(arm, self.axis);
        (norm(sub(arm, scale(self.axis, z))), z)
    }

    /// Returns the weight of the rotation at `x`: 1 on the body, 0 on every other surface.
    #[inline]
    pub fn weight(&self, x: Vector) -> f64 {
        let (r, z) = self.cylindrical(x);
        let across = match r {
            _ if r <= self.inner => 1.0,
            _ if r >= self.outer => 0.0,
            _ => fallen((r / self.inner).ln() / (self.outer / self.inner).ln()),
        };
        across * self.along(z)
    }

    fn along(&self, z: f64) -> f64 {
        let left = |end: f64, free: f64| ((free - z) / (free - end)).clamp(0.0, 1.0);
        match z {
            _ if z < self.body[0] && self.free[0].is_finite() => left(self.body[0], self.free[0]),
            _ if z > self.body[1] && self.free[1].is_finite() => left(self.body[1], self.free[1]),
            _ => 1.0,
        }
    }
}

/// Returns the weight at a fraction of the logarithm of the radius ratio.
#[inline]
fn fallen(s: f64) -> f64 {
    if s < 0.5 {
        1.0 - 4.0 / 3.0 * s * s
    } else {
        4.0 / 3.0 * (1.0 - s)
    }
}

/// Returns the direction of the longest of some vectors, if all are parallel to it.
fn common_axis(vectors: &[Vector]) -> Option<Vector> {
    let longest = vectors
        .iter()
        .copied()
        .reduce(|a, b| if norm(b) > norm(a) { b } else { a })?;
    let axis = unit(longest)?;
    let is_parallel = |v: &Vector| norm(cross(*v, axis)) <= PARALLEL * norm(longest);
    vectors.iter().all(is_parallel).then_some(axis)
}

/// Returns the values of rotations (N, r) at the surface without the contribution of rings; `None` without rings.
pub(crate) fn rest(points: &[Vector], bodies: &[Turning], modes: &Modes) -> Option<Vec<f64>> {
    bodies.iter().find(|body| body.ring.is_some())?;
    let mut rest = modes.values.clone();
    add_rings(bodies, -1.0, modes.n_modes, &mut rest, |row| points[row]);
    Some(rest)
}

/// Adds the contribution of the rings of bodies, times `sign`, to rows of values (N, r) at the positions `at`.
pub(crate) fn add_rings(
    bodies: &[Turning],
    sign: f64,
    r: usize,
    values: &mut [f64],
    at: impl Fn(usize) -> Vector + Sync,
) {
    for body in bodies {
        let Some((ring, own)) = &body.ring else {
            continue;
        };
        parallel::for_blocks(values, parallel::BLOCK * r, &|first, rows| {
            for (i, row) in rows.chunks_exact_mut(r).enumerate() {
                let weight = sign * ring.weight(at(first / r + i));
                if weight != 0.0 {
                    for (value, own) in row[body.modes.clone()].iter_mut().zip(own) {
                        *value += weight * own;
                    }
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::Transform;

    const Z: Vector = [0.0, 0.0, 1.0];

    fn circle(n: usize, radius: f64, z: f64) -> impl Iterator<Item = Vector> {
        (0..n).map(move |i| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
            [radius * c, radius * s, z]
        })
    }

    /// A rod of radius 0.5 between z = -1 and 1 in a cylinder of radius 4 between z = -6 and 8 with both ends closed.
    fn rod_in_cylinder() -> (Vec<Vector>, Vec<Option<u16>>) {
        let mut points: Vec<Vector> = [-1.0, 0.0, 1.0]
            .into_iter()
            .flat_map(|z| circle(12, 0.5, z))
            .collect();
        let n_body = points.len();
        points.extend((-12..=16).flat_map(|z| circle(40, 4.0, 0.5 * f64::from(z))));
        for z in [-6.0, 8.0] {
            points.extend((0..8).flat_map(|r| circle(8, 0.5 * f64::from(r), z)));
        }
        let body = (0..points.len()).map(|i| (i < n_body).then_some(0));
        let body = body.collect();
        (points, body)
    }

    fn ring_of(points: &[Vector], body: &[Option<u16>], theta: &[Vector]) -> Option<Ring> {
        Ring::around(RigidSurface { points, body }, 0, [0.0; 3], theta, |_, _| {
            false
        })
    }

    #[test]
    fn the_weight_is_one_on_the_body_and_zero_on_every_other_surface() {
        let (points, body) = rod_in_cylinder();
        let ring =
            ring_of(&points, &body, &[scale(Z, 0.1), scale(Z, -3.0)]).expect("there is room");
        for (x, of) in points.iter().zip(&body) {
            assert_eq!(
                ring.weight(*x),
                if of.is_some() { 1.0 } else { 0.0 },
                "{x:?}"
            );
        }
        assert!((ring.inner - 0.5).abs() < 1e-15 && (ring.outer - 4.0).abs() < 1e-14);
        // Half of the logarithm, half of the distance to an end, and both.
        let middle = (0.5f64 * 4.0).sqrt();
        assert!((ring.weight([middle, 0.0, 0.3]) - 2.0 / 3.0).abs() < 1e-14);
        assert!((ring.weight([0.0, 0.2, 4.5]) - 0.5).abs() < 1e-14);
        assert!((ring.weight([0.0, middle, -3.5]) - 1.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn the_shear_begins_at_zero_and_is_the_same_at_all_radii_of_the_outer_half() {
        let (points, body) = rod_in_cylinder();
        let ring = ring_of(&points, &body, &[scale(Z, 2.0)]).expect("there is room");
        let shear = |r: f64| {
            let h = 1e-6;
            r * (ring.weight([r - h, 0.0, 0.0]) - ring.weight([r + h, 0.0, 0.0])) / (2.0 * h)
        };
        let least = 1.0 / 8.0f64.ln();
        for r in [1.5, 2.0, 3.9] {
            assert!((shear(r) - 4.0 / 3.0 * least).abs() < 1e-8, "{r}");
        }
        assert!(shear(0.5 + 2e-6) < 1e-4);
        assert!((shear(0.5 * 8.0f64.powf(0.25)) - 2.0 / 3.0 * least).abs() < 1e-8);
    }

    #[test]
    fn there_is_no_ring_about_several_axes_nor_where_another_surface_is_near() {
        let (mut points, mut body) = rod_in_cylinder();
        assert_eq!(ring_of(&points, &body, &[Z, [0.0, 1.0, 1.0]]), None);
        assert_eq!(ring_of(&points, &body, &[[0.0; 3]]), None);
        points.push([0.7, 0.0, 0.0]);
        body.push(None);
        assert_eq!(ring_of(&points, &body, &[Z]), None);
        // A more distant obstacle makes the ring smaller.
        *points.last_mut().expect("one was added") = [0.0, 2.0, 0.5];
        let ring = ring_of(&points, &body, &[Z]).expect("there is room");
        assert_eq!(ring.outer, 2.0);
        // An obstacle just before the end of the body leaves no space along the axis.
        *points.last_mut().expect("one was added") = [0.1, 0.1, 1.2];
        assert_eq!(ring_of(&points, &body, &[Z]), None);
    }

    #[test]
    fn a_plane_across_the_axis_that_slides_is_no_obstacle() {
        let (mut points, mut body) = rod_in_cylinder();
        let n = points.len();
        points.extend((1..8).flat_map(|r| circle(16, 0.5 * f64::from(r), -1.0)));
        body.resize(points.len(), None);
        let turned = Transform::rotation([1.0, 0.0, 0.0], [0.0; 3], 0.4);
        let points: Vec<Vector> = points.iter().map(|x| turned.apply(*x)).collect();
        let surface = RigidSurface {
            points: &points,
            body: &body,
        };
        let theta = [turned.turn(Z)];
        let of = |slides: bool| {
            Ring::around(surface, 0, [0.0; 3], &theta, |at, axis| {
                slides && at >= n && norm(sub(axis, theta[0])) < 1e-12
            })
        };
        assert_eq!(of(false), None);
        assert!(of(true).is_some_and(|ring| (ring.outer - 4.0).abs() < 1e-12));
    }
}
