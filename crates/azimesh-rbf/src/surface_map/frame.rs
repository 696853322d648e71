//! The rotation of a surface at a point, from its slopes along two directions.

use crate::Vector;
use azimesh_core::geometry::vector::{add, cross, dot, norm, scale, sub, unit};

/// Slopes of a vector along two directions of a surface.
pub(super) type Slopes = [Vector; 2];

/// The tangents of a surface at rest, and the orthonormal directions along them.
pub(super) struct Frame {
    tangents: Slopes,
    axes: [Vector; 3],
    /// `e1 = f11 t1`, `e2 = f21 t1 + f22 t2`.
    factors: [f64; 3],
}

impl Frame {
    /// Builds the frame of tangents; if the second is zero, as on an edge in the plane, it is z.
    pub fn new(tangents: Slopes) -> Self {
        let [t1, t2] = tangents;
        let is_edge = dot(t2, t2) == 0.0 || norm(cross(t1, t2)) == 0.0;
        let axes = axes(if is_edge { [t1, Z] } else { tangents });
        let first = 1.0 / norm(t1);
        let second = 1.0 / dot(t2, axes[1]);
        let factors = [first, -dot(t2, axes[0]) * first * second, second];
        Self {
            tangents: if is_edge { [t1, Z] } else { tangents },
            axes,
            factors: if is_edge { [first, 0.0, 0.0] } else { factors },
        }
    }

    /// Returns `(Q - 1) offset`, with the rotation `Q` of the frame by displacements of these slopes.
    pub fn turned(&self, slopes: Slopes, offset: Vector) -> Vector {
        let slopes = if self.factors[2] == 0.0 {
            [slopes[0], [0.0; 3]]
        } else {
            slopes
        };
        let moved = axes([
            add(self.tangents[0], slopes[0]),
            add(self.tangents[1], slopes[1]),
        ]);
        let parts = self.axes.map(|axis| dot(axis, offset));
        let at_rest = combined(&self.axes, parts);
        sub(combined(&moved, parts), at_rest)
    }

    /// Converts a moment at rest to couples on the slopes: `moment . rotation = sum_k couple_k . slope_k`.
    pub fn couple(&self, moment: Vector) -> Slopes {
        let [e1, e2, n] = self.axes;
        let first = sub(scale(e2, dot(moment, n)), scale(n, dot(moment, e2)));
        let second = scale(n, dot(moment, e1));
        let [f11, f21, f22] = self.factors;
        [
            add(scale(first, f11), scale(second, f21)),
            scale(second, f22),
        ]
    }
}

const Z: Vector = [0.0, 0.0, 1.0];

/// Orthonormal directions: along the first tangent, in the plane of both, across it.
fn axes([t1, t2]: Slopes) -> [Vector; 3] {
    let e1 = unit(t1).unwrap_or([1.0, 0.0, 0.0]);
    let across = cross(e1, t2);
    let n = unit(across).unwrap_or_else(|| {
        // Any direction across where the surface has collapsed to a line.
        let other = if e1[2].abs() < 0.9 {
            Z
        } else {
            [1.0, 0.0, 0.0]
        };
        unit(cross(e1, other)).expect("not parallel")
    });
    [e1, cross(n, e1), n]
}

fn combined(axes: &[Vector; 3], parts: [f64; 3]) -> Vector {
    add(
        add(scale(axes[0], parts[0]), scale(axes[1], parts[1])),
        scale(axes[2], parts[2]),
    )
}
