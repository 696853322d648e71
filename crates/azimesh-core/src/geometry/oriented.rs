//! Boxes turned with what they hold: thin around flat pieces, narrow around long ones, in any
//! direction. Four are adjacent in memory, so that one pass over registers tests all of them.

use super::bounds::Bounds;
use super::vector::{Vector, add, dot, norm, scale, sub};

/// Boxes of a group.
pub const LANES: usize = 4;
/// Sweeps of rotations after which a matrix of three rows is diagonal to round-off.
const SWEEPS: usize = 8;
/// Round-off of a lower bound, in squared distances to the centre of a box.
const SLACK: f64 = 1e-14;

/// A box with axes of its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OrientedBox {
    /// Its middle.
    pub centre: Vector,
    /// Three unit vectors at right angles.
    pub axes: [Vector; 3],
    /// Half of its extent along each axis, round-off included.
    pub half: Vector,
}

impl OrientedBox {
    /// A box around points, along the principal axes of their scatter.
    ///
    /// # Panics
    /// Without points.
    pub fn around(points: &[Vector]) -> Self {
        let origin = points[0];
        let sum = points
            .iter()
            .fold([0.0; 3], |sum, p| add(sum, sub(*p, origin)));
        let mean = add(origin, scale(sum, 1.0 / points.len() as f64));
        let mut scatter = [[0.0; 3]; 3];
        for point in points {
            let away = sub(*point, mean);
            for i in 0..3 {
                for j in 0..=i {
                    scatter[i][j] += away[i] * away[j];
                }
            }
        }
        let axes = principal_axes(scatter);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points {
            let away = sub(*point, mean);
            for k in 0..3 {
                let along = dot(axes[k], away);
                low[k] = f64::min(low[k], along);
                high[k] = f64::max(high[k], along);
            }
        }
        let shift = |k: usize| scale(axes[k], 0.5 * (low[k] + high[k]));
        let half: Vector = std::array::from_fn(|k| 0.5 * (high[k] - low[k]));
        let round_off = 4e-15 * norm(half);
        Self {
            centre: (0..3).fold(mean, |centre, k| add(centre, shift(k))),
            axes,
            half: half.map(|half| half + round_off),
        }
    }

    /// A box around boxes.
    ///
    /// # Panics
    /// Without boxes.
    pub fn joined(boxes: &[Self]) -> Self {
        let corners: Vec<Vector> = boxes.iter().flat_map(Self::corners).collect();
        Self::around(&corners)
    }

    /// Its eight corners.
    pub fn corners(&self) -> [Vector; 8] {
        std::array::from_fn(|corner| {
            (0..3).fold(self.centre, |sum, k| {
                let sign = if corner >> k & 1 == 0 { -1.0 } else { 1.0 };
                add(sum, scale(self.axes[k], sign * self.half[k]))
            })
        })
    }
}

/// Eigenvectors of a symmetric matrix, by its lower triangle, by cyclic Jacobi
/// rotations: right to round-off for the smallest eigenvalue too.
///
/// Source: Golub and Van Loan, Matrix Computations, section 8.5.
fn principal_axes(lower: [[f64; 3]; 3]) -> [Vector; 3] {
    let mut a: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| lower[i.max(j)][i.min(j)]));
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() <= f64::EPSILON * 0.1 * (a[p][p] * a[q][q]).abs().sqrt() {
                continue;
            }
            turned = true;
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                (axes[p][k], axes[q][k]) = (
                    c * axes[p][k] - s * axes[q][k],
                    s * axes[p][k] + c * axes[q][k],
                );
            }
        }
        if !turned {
            break;
        }
    }
    axes
}

/// At most four boxes, side by side.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct Group {
    centre: [[f64; LANES]; 3],
    axes: [[[f64; LANES]; 3]; 3],
    half: [[f64; LANES]; 3],
}

impl Group {
    /// At most four boxes; lanes that are left are infinitely far from everywhere.
    ///
    /// # Panics
    /// With more than four.
    pub fn new(boxes: &[OrientedBox]) -> Self {
        let mut group = Self {
            centre: [[0.0; LANES]; 3],
            axes: [[[0.0; LANES]; 3]; 3],
            half: [[f64::NEG_INFINITY; LANES]; 3],
        };
        for (lane, of) in boxes.iter().enumerate() {
            for k in 0..3 {
                group.centre[k][lane] = of.centre[k];
                group.half[k][lane] = of.half[k];
                for i in 0..3 {
                    group.axes[k][i][lane] = of.axes[k][i];
                }
            }
        }
        group
    }

    /// Square of the distance from a point to each box, or a little less: never more than to
    /// anything inside.
    #[inline(always)]
    pub fn distances_squared(&self, point: &Vector) -> [f64; LANES] {
        self.separations(point, &[0.0; 3])
    }

    /// Square of the distance from an axis-aligned box to each box, or less.
    #[inline(always)]
    pub fn distances_to(&self, block: &Bounds) -> [f64; LANES] {
        let (mut middle, mut half) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            middle[i] = 0.5 * (block.low[i] + block.high[i]);
            half[i] = 0.5 * (block.high[i] - block.low[i]);
        }
        self.separations(&middle, &half)
    }

    /// The gaps along the axes of each box, squared and summed. Plain loops over the lanes, so that
    /// each line is one instruction for all.
    #[inline(always)]
    fn separations(&self, middle: &Vector, half: &Vector) -> [f64; LANES] {
        let mut away = [[0.0; LANES]; 3];
        let mut sum = [0.0; LANES];
        for i in 0..3 {
            for lane in 0..LANES {
                away[i][lane] = middle[i] - self.centre[i][lane];
                sum[lane] -= SLACK * (away[i][lane] * away[i][lane]);
            }
        }
        for k in 0..3 {
            let axis = &self.axes[k];
            for lane in 0..LANES {
                let along = axis[0][lane] * away[0][lane]
                    + axis[1][lane] * away[1][lane]
                    + axis[2][lane] * away[2][lane];
                let reach = axis[0][lane].abs() * half[0]
                    + axis[1][lane].abs() * half[1]
                    + axis[2][lane].abs() * half[2];
                let gap = along.abs() - self.half[k][lane] - reach;
                let gap = if gap > 0.0 { gap } else { 0.0 };
                sum[lane] += gap * gap;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_tilted_piece_has_a_box_without_thickness() {
        let (u, v) = ([0.6, 0.0, 0.8], [0.48, 0.8, -0.36]);
        let points: Vec<Vector> = (0..40)
            .map(|i| {
                let (s, t) = (f64::from(i % 8) * 0.01, f64::from(i / 8) * 0.002);
                add([5.0, -3.0, 2.0], add(scale(u, s), scale(v, t)))
            })
            .collect();
        let mut half = OrientedBox::around(&points).half;
        half.sort_by(f64::total_cmp);
        assert!(half[0] < 1e-14, "{half:?}");
        assert!((half[1] - 0.004).abs() < 1e-9 && (half[2] - 0.035).abs() < 1e-9);
    }

    #[test]
    fn no_point_of_a_box_is_nearer_than_its_distance() {
        let value = |i: usize| ((i as f64) * 12.9898).sin();
        let cloud = |seed: usize, size: f64| -> Vec<Vector> {
            (0..12)
                .map(|i| {
                    [
                        value(seed + i),
                        size * value(seed + 2 * i),
                        value(seed + 5 * i),
                    ]
                })
                .collect()
        };
        for seed in 0..50 {
            let points = cloud(7 * seed, [1.0, 1e-9, 0.0][seed % 3]);
            let group = Group::new(&[OrientedBox::around(&points)]);
            let asked = cloud(1000 + seed, 3.0);
            let block = Bounds::around(&asked);
            let least = |q: &Vector| {
                let squares = points.iter().map(|p| dot(sub(*p, *q), sub(*p, *q)));
                squares.fold(f64::INFINITY, f64::min)
            };
            for q in asked.iter().chain(&points) {
                assert!(group.distances_squared(q)[0] <= least(q));
                assert!(group.distances_to(&block)[0] <= least(q));
                assert_eq!(group.distances_squared(q)[1], f64::INFINITY);
            }
        }
    }

    #[test]
    fn corners_span_the_box() {
        let one = OrientedBox::around(&[[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]]);
        assert!(
            one.corners()
                .iter()
                .all(|c| norm(sub(*c, [1.0, 2.0, 3.0])) < 1e-12)
        );
    }
}
