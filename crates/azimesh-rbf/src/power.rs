//! Base points by the power function alone, for data that are not known.
//!
//! The power function bounds the error of the interpolant at a point over all data of one size,
//!
//! ```text
//! |d(x) - s(x)| <= P(x) |d|,     P(x)^2 = phi(0) - sum_j v_j(x)^2
//! ```
//!
//! with `v_j` the Newton basis (`newton`). The point with the largest weighted value is the next base
//! point.
//!
//! Source: S. De Marchi, R. Schaback, H. Wendland, Near-optimal data-independent point locations for
//! radial basis function interpolation, Adv. Comput. Math. 23, 2005.

use super::newton::subtract_rows;
use super::space::Space;
use super::targets::LEAST_POWER;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;

/// Candidates that one task keeps up to date.
const CHUNK: usize = 256;

/// Positions among `points` of the base points, in the order chosen: always the one with the largest
/// `weight P`, until that is at or below `least` or there are `max_points`. Ties go to the first;
/// points of weight zero and those too close to base points are never chosen. One weight a point. The value that is left is
/// given too.
///
/// `N n^2 / 2` multiply-adds and `N n` numbers for `N` points.
pub fn by_power(
    space: &Space,
    points: &[Vector],
    weights: &[f64],
    least: f64,
    max_points: usize,
) -> (Vec<usize>, f64) {
    let mut chunks = parallel::map_blocks(points.len(), CHUNK, &|range| {
        Chunk::new(space, &points[range.clone()], &weights[range])
    });
    let mut base = Vec::new();
    loop {
        let largest = chunks.iter().enumerate().fold(None, larger);
        let left = largest.map_or(0.0, |(_, worst)| worst.value);
        let Some((at, worst)) = largest.filter(|_| left > least && base.len() < max_points) else {
            return (base, left);
        };
        base.push(CHUNK * at + worst.at);
        let new = chunks[at].take(worst.at);
        parallel::for_items(&mut chunks, &|_, chunk| chunk.add(space, &new));
    }
}

fn larger(
    found: Option<(usize, Worst)>,
    (at, chunk): (usize, &Chunk<'_>),
) -> Option<(usize, Worst)> {
    match found {
        Some((_, worst)) if worst.value >= chunk.worst.value => found,
        _ => Some((at, chunk.worst)),
    }
}

/// The point of a chunk with the largest weighted power function.
#[derive(Debug, Clone, Copy)]
struct Worst {
    value: f64,
    at: usize,
}

/// Some candidates.
struct Chunk<'a> {
    points: &'a [Vector],
    weights: &'a [f64],
    /// Newton basis (n, m): one row of m values for each base point.
    newton: Vec<f64>,
    /// Power function, squared.
    power: Vec<f64>,
    worst: Worst,
}

/// The new base point as every chunk needs it.
struct NewPoint {
    point: Vector,
    /// Newton basis there (n).
    row: Vec<f64>,
    /// Root of its power function.
    diagonal: f64,
}

impl<'a> Chunk<'a> {
    fn new(space: &Space, points: &'a [Vector], weights: &'a [f64]) -> Self {
        let mut chunk = Self {
            // One, but for the images.
            power: points.iter().map(|x| space.between(x, x)).collect(),
            points,
            weights,
            newton: Vec::new(),
            worst: Worst { value: 0.0, at: 0 },
        };
        chunk.find_worst();
        chunk
    }

    fn find_worst(&mut self) {
        let mut worst = Worst { value: 0.0, at: 0 };
        for (at, (power, weight)) in self.power.iter().zip(self.weights).enumerate() {
            // Written so that a NaN power is skipped too.
            let serves = *power >= LEAST_POWER;
            if serves && weight * power.sqrt() > worst.value {
                let value = weight * power.sqrt();
                worst = Worst { value, at };
            }
        }
        self.worst = worst;
    }

    fn take(&self, at: usize) -> NewPoint {
        let rows = self.newton.chunks_exact(self.points.len());
        NewPoint {
            point: self.points[at],
            row: rows.map(|row| row[at]).collect(),
            diagonal: self.power[at].sqrt(),
        }
    }

    fn add(&mut self, space: &Space, new: &NewPoint) {
        let points = self.points.iter();
        let mut values: Vec<f64> = points.map(|x| space.between(x, &new.point)).collect();
        subtract_rows(&mut values, &self.newton, &new.row);
        for (value, power) in values.iter_mut().zip(&mut self.power) {
            *value /= new.diagonal;
            *power -= *value * *value;
        }
        self.newton.extend_from_slice(&values);
        self.find_worst();
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Basis, Kernel};
    use super::*;
    use azimesh_core::linear::{Cholesky, Matrix};

    fn cloud(n: usize) -> Vec<Vector> {
        let value = |i: usize| (i as f64 * 12.9898).sin();
        (0..n)
            .map(|i| std::array::from_fn(|k| value(3 * i + k)))
            .collect()
    }

    const BASIS: Basis = Basis {
        kernel: Kernel::WendlandC2,
        radius: 2.5,
    };

    /// `P(x)^2 = phi(0) - k^T Phi^-1 k`, by a solve for each point.
    fn power(points: &[Vector], base: &[usize], x: &Vector) -> f64 {
        let at = |i: usize| &points[base[i]];
        let phi = Matrix::from_fn(base.len(), base.len(), |i, j| BASIS.between(at(i), at(j)));
        let k = Matrix::from_fn(base.len(), 1, |i, _| BASIS.between(at(i), x));
        let mut solved = k.clone();
        Cholesky::factor(phi).expect("definite").solve(&mut solved);
        let pairs = k.column(0).iter().zip(solved.column(0));
        1.0 - pairs.map(|(a, b)| a * b).sum::<f64>()
    }

    #[test]
    fn each_base_point_has_the_largest_weighted_power_function_of_all() {
        let points = cloud(700);
        let weights: Vec<f64> = points.iter().map(|x| 0.5 + x[0].abs()).collect();
        let space = Space::radial(BASIS);
        let (base, left) = by_power(&space, &points, &weights, 0.0, 25);
        assert_eq!(base.len(), 25);
        for n in 1..base.len() {
            let value = |i: usize| weights[i] * power(&points, &base[..n], &points[i]).sqrt();
            let chosen = value(base[n]);
            let largest = (0..points.len()).map(value).fold(0.0, f64::max);
            assert!(chosen > largest * (1.0 - 1e-6), "{n}: {chosen} {largest}");
        }
        let value = |i: usize| weights[i] * power(&points, &base, &points[i]).max(0.0).sqrt();
        let largest = (0..points.len()).map(value).fold(0.0, f64::max);
        assert!((left - largest).abs() < 1e-6 * largest, "{left} {largest}");
    }

    #[test]
    fn points_of_no_weight_and_points_at_one_place_are_passed_over() {
        let mut points = cloud(40);
        points[7] = points[3];
        let mut weights = vec![1.0; 40];
        weights[11] = 0.0;
        let (base, left) = by_power(&Space::radial(BASIS), &points, &weights, 0.0, 40);
        assert_eq!(left, 0.0);
        assert_eq!(base.len(), 38);
        assert!(!base.contains(&7) && !base.contains(&11));
        let (few, left) = by_power(&Space::radial(BASIS), &points, &weights, 0.5, 40);
        assert!(few.len() < 38 && base.starts_with(&few) && left <= 0.5);
    }
}
