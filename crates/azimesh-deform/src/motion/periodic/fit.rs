//! Rigid maps that may take one side of a periodic pair to the other, from the positions of their nodes only.

use super::{Axis, SNAP, Sides, Symmetry};
use azimesh_core::geometry::vector::{Vector, add, cross, distance, dot, norm, scale, sub, unit};

/// Largest number of rotations, found from the nodes, that are tried.
const MOST_TRIED: usize = 64;
/// Relative tolerance within which an angle is a whole part of a circle.
const PART_OF_CIRCLE: f64 = 1e-6;

impl Sides {
    /// Returns the maps to try: a translation, and rotations about `axis` and about axes found from the nodes.
    pub(super) fn candidates(&self, axis: Option<Axis>) -> Vec<Symmetry> {
        let mut candidates = Vec::new();
        let by = sub(self.b.centre(), self.a.centre());
        if norm(by) > self.tolerance {
            let size = by.iter().fold(0.0, |m, x| f64::max(m, x.abs()));
            let by = by.map(|x| if x.abs() <= SNAP * size { 0.0 } else { x });
            candidates.push(Symmetry::Translation(by));
        }
        candidates.extend(axis.and_then(|axis| self.about(axis)));
        candidates.extend(self.rotations());
        candidates
    }

    /// Returns the rotation about an axis that maps the centre of one side to the centre of the other.
    pub(super) fn about(&self, axis: Axis) -> Option<Symmetry> {
        let (a, b) = (self.a.centre(), self.b.centre());
        let near = |x: Vector| norm(from_axis(&axis, x)) <= self.tolerance;
        let angle = part_of_circle(angle_about(&axis, a, b));
        (angle != 0.0 && !near(a) && !near(b)).then_some(Symmetry::Rotation { axis, angle })
    }

    /// Finds rotations about any axis. Two nodes and the centre of the first side determine a rotation when their
    /// counterparts are known: nodes of the second side with the same distances.
    fn rotations(&self) -> Vec<Symmetry> {
        let (centre_a, centre_b) = (self.a.centre(), self.b.centre());
        let to_a: Vec<Vector> = self.a.at.iter().map(|x| sub(*x, centre_a)).collect();
        let to_b: Vec<Vector> = self.b.at.iter().map(|x| sub(*x, centre_b)).collect();
        let first = farthest(&to_a, norm);
        let Some(along) = unit(first) else {
            return Vec::new();
        };
        let second = farthest(&to_a, |v| norm(cross(along, v)));
        let near = |x: f64, y: f64| (x - y).abs() <= 2.0 * self.tolerance;
        let counterparts = to_b.iter().filter(|q| near(norm(**q), norm(first)));
        let mut found = Vec::new();
        if norm(cross(along, second)) <= 2.0 * self.tolerance {
            // A straight side of a plane mesh turns in the plane.
            let in_plane = |x: &Vector| (x[2] - centre_a[2]).abs() <= self.tolerance;
            if self.a.at.iter().chain(&self.b.at).all(in_plane) {
                for q in counterparts {
                    let angle = cross(first, *q)[2].atan2(dot(first, *q));
                    let turned = in_the_plane(angle, centre_a, centre_b);
                    found.extend(turned.map(|(axis, angle)| Symmetry::Rotation { axis, angle }));
                }
            }
            return found;
        }
        let frame_a = frame(first, second);
        let as_far = |p: &&Vector| near(norm(**p), norm(second));
        let as_far: Vec<Vector> = to_b.iter().filter(as_far).copied().collect();
        for q in counterparts {
            let others = as_far
                .iter()
                .filter(|p| near(distance(**p, *q), distance(second, first)));
            for p in others {
                if found.len() == MOST_TRIED {
                    return found;
                }
                let (Some(from), Some(to)) = (frame_a, frame(*q, *p)) else {
                    continue;
                };
                found.extend(self.rotation(from, to, centre_a, centre_b));
            }
        }
        found
    }

    /// Returns the rotation that takes one frame at a centre to another at another centre; `None` if that also needs
    /// a shift along the axis.
    fn rotation(
        &self,
        from: [Vector; 3],
        to: [Vector; 3],
        centre_a: Vector,
        centre_b: Vector,
    ) -> Option<Symmetry> {
        // Columns of the rotation: the images of the axes.
        let image = |k: usize| (0..3).fold([0.0; 3], |sum, i| add(sum, scale(to[i], from[i][k])));
        let columns = [image(0), image(1), image(2)];
        let (direction, angle) = axis_and_angle(columns)?;
        let direction = unit(direction.map(|x| if x.abs() < SNAP { 0.0 } else { x }))?;
        let angle = part_of_circle(angle);
        let shift = sub(centre_b, centre_a);
        if dot(direction, shift).abs() > 2.0 * self.tolerance {
            return None;
        }
        let axis = Axis {
            origin: fixed_point(direction, angle, centre_a, centre_b).map(|x| {
                if x.abs() <= 0.1 * self.tolerance {
                    0.0
                } else {
                    x
                }
            }),
            direction,
        };
        Some(Symmetry::Rotation { axis, angle })
    }
}

/// Returns the vector from the axis to a point, at a right angle.
fn from_axis(axis: &Axis, x: Vector) -> Vector {
    let v = sub(x, axis.origin);
    sub(v, scale(axis.direction, dot(axis.direction, v)))
}

/// Returns the angle about an axis from `a` to `b`; zero for a point on it.
pub(super) fn angle_about(axis: &Axis, a: Vector, b: Vector) -> f64 {
    let (a, b) = (from_axis(axis, a), from_axis(axis, b));
    dot(axis.direction, cross(a, b)).atan2(dot(a, b))
}

fn farthest(vectors: &[Vector], length: impl Fn(Vector) -> f64) -> Vector {
    let longer = |far: Vector, v: &Vector| if length(*v) > length(far) { *v } else { far };
    vectors.iter().fold([0.0; 3], longer)
}

/// Returns a right-handed orthonormal frame along `a` and towards `b`.
fn frame(a: Vector, b: Vector) -> Option<[Vector; 3]> {
    let x = unit(a)?;
    let z = unit(cross(x, b))?;
    Some([x, cross(z, x), z])
}

/// Returns the unit axis and the angle in (0, pi] of the rotation with these columns; `None` for the identity.
fn axis_and_angle(columns: [Vector; 3]) -> Option<(Vector, f64)> {
    let [x, y, z] = columns;
    let twist = [y[2] - z[1], z[0] - x[2], x[1] - y[0]];
    let trace = x[0] + y[1] + z[2];
    let angle = (0.5 * norm(twist)).atan2(0.5 * (trace - 1.0));
    if angle < 1e-9 {
        return None;
    }
    if trace > -0.9 {
        return Some((unit(twist)?, angle));
    }
    // Near half a turn R + R^T - (trace - 1) I = (3 - trace) u u^T; its largest column is along u.
    let symmetric =
        |i: usize, j: usize| columns[i][j] + columns[j][i] - if i == j { trace - 1.0 } else { 0.0 };
    let column = |i: usize| -> Vector { std::array::from_fn(|j| symmetric(i, j)) };
    let largest = (0..3).fold(0, |k, i| {
        if symmetric(i, i) > symmetric(k, k) {
            i
        } else {
            k
        }
    });
    let along = unit(column(largest))?;
    let sense = if dot(along, twist) < 0.0 { -1.0 } else { 1.0 };
    Some((scale(along, sense), angle))
}

/// Returns the point of the axis halfway between `a` and `b`, where a rotation by `angle` takes `a` to `b`.
fn fixed_point(direction: Vector, angle: f64, a: Vector, b: Vector) -> Vector {
    let shift = sub(b, a);
    let across = sub(shift, scale(direction, dot(direction, shift)));
    let middle = scale(add(a, b), 0.5);
    add(
        middle,
        scale(cross(direction, across), 0.5 / (0.5 * angle).tan()),
    )
}

/// Returns a rotation about z that takes `a` to `b`.
fn in_the_plane(angle: f64, a: Vector, b: Vector) -> Option<(Axis, f64)> {
    let angle = part_of_circle(angle);
    let direction = [0.0, 0.0, 1.0];
    (angle.abs() > 1e-9).then(|| {
        let origin = fixed_point(direction, angle, a, b);
        (Axis { origin, direction }, angle)
    })
}

/// Rounds an angle to an exact whole part of a circle if it is nearly one.
pub(super) fn part_of_circle(angle: f64) -> f64 {
    let parts = std::f64::consts::TAU / angle.abs();
    let whole = parts.round();
    if (parts - whole).abs() <= PART_OF_CIRCLE * whole {
        (std::f64::consts::TAU / whole).copysign(angle)
    } else {
        angle
    }
}
