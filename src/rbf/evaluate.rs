//! `Phi (N, n) . W (n, r)` for millions of points, without storing `Phi`.
//!
//! A block of points is cut into groups of as many as the processor's vectors hold well; each group
//! keeps its sums in registers while the base points stream by. One compiled version per
//! instruction set is chosen at run time.

use super::Basis;
use super::kernel::{C0, C2, C4, C6, Kernel, Radial};
use crate::geometry::{Bounds, vector::Vector};
use crate::linear;
use multiversion::multiversion;
use rayon::prelude::*;

/// Points that one task works on; their bounding box decides which base points they see.
const BLOCK: usize = 256;
/// Points in a group, in registers together.
const LANES: usize = 8;
/// Above this many columns the kernel is evaluated once into a tile and multiplied as a matrix.
const MOST_FUSED: usize = 8;
/// Base points in a tile.
const TILE: usize = 128;

/// Base points with the weights of each, `r` columns.
#[derive(Debug, Clone)]
pub struct WeightedBase<'a> {
    /// Kernel and support radius.
    pub basis: Basis,
    /// Base points, n of them.
    pub points: &'a [Vector],
    /// Weights (n, r), by rows.
    pub weights: &'a [f64],
    /// Number of columns, r.
    pub n_columns: usize,
}

impl WeightedBase<'_> {
    /// Adds to `out (N, r)`, by rows, the interpolant at `points (N)`:
    ///
    /// ```text
    /// out(i) += sum_j phi(|x_i - b_j| / R) w_j
    /// ```
    ///
    /// On all threads. `N n` kernel evaluations; base points out of reach of a block's bounding box
    /// are skipped, which pays when neighbours in memory are neighbours in space.
    pub fn add_at(&self, points: &[Vector], out: &mut [f64]) {
        assert_eq!(out.len(), points.len() * self.n_columns);
        if self.n_columns == 0 || self.points.is_empty() {
            return;
        }
        out.par_chunks_mut(BLOCK * self.n_columns)
            .zip(points.par_chunks(BLOCK))
            .for_each_init(Reach::default, |reach, (out, points)| {
                reach.gather(self, points);
                self.add_block(reach, points, out);
            });
    }

    fn add_block(&self, reach: &mut Reach, points: &[Vector], out: &mut [f64]) {
        match self.basis.kernel {
            Kernel::WendlandC0 => self.add_with::<C0>(reach, points, out),
            Kernel::WendlandC2 => self.add_with::<C2>(reach, points, out),
            Kernel::WendlandC4 => self.add_with::<C4>(reach, points, out),
            Kernel::WendlandC6 => self.add_with::<C6>(reach, points, out),
        }
    }

    fn add_with<K: Radial>(&self, reach: &mut Reach, points: &[Vector], out: &mut [f64]) {
        let inverse = 1.0 / self.basis.radius;
        macro_rules! fused {
            ($($r:literal),*) => {
                match self.n_columns {
                    $($r => fused_block::<K, $r>(points, &reach.points, &reach.weights, inverse, out),)*
                    r => tiled_block::<K>(points, reach, r, inverse, out),
                }
            };
        }
        const { assert!(MOST_FUSED == 8) };
        fused!(1, 2, 3, 4, 5, 6, 7, 8);
    }
}

/// Base points within reach of a block, with their weights.
#[derive(Default)]
struct Reach {
    points: Vec<Vector>,
    weights: Vec<f64>,
    tile: Vec<f64>,
}

impl Reach {
    fn gather(&mut self, base: &WeightedBase<'_>, block: &[Vector]) {
        let bounds = Bounds::around(block);
        let squared = base.basis.radius * base.basis.radius;
        let r = base.n_columns;
        self.points.clear();
        self.weights.clear();
        for (j, point) in base.points.iter().enumerate() {
            if bounds.distance_squared(point) < squared {
                self.points.push(*point);
                self.weights.extend_from_slice(&base.weights[j * r..][..r]);
            }
        }
    }
}

/// Coordinates of a group of points, one array an axis; the last points are repeated to fill it.
#[inline(always)]
fn lanes(points: &[Vector]) -> [[f64; LANES]; 3] {
    let last = points.len() - 1;
    std::array::from_fn(|axis| std::array::from_fn(|lane| points[lane.min(last)][axis]))
}

#[inline(always)]
fn kernel_lanes<K: Radial>(x: &[[f64; LANES]; 3], base: &Vector, inverse: f64) -> [f64; LANES] {
    let mut phi = [0.0; LANES];
    for lane in 0..LANES {
        let dx = x[0][lane] - base[0];
        let dy = x[1][lane] - base[1];
        let dz = x[2][lane] - base[2];
        phi[lane] = K::value((dx * dx + dy * dy + dz * dz).sqrt() * inverse);
    }
    phi
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn fused_block<K: Radial, const R: usize>(
    points: &[Vector],
    base: &[Vector],
    weights: &[f64],
    inverse: f64,
    out: &mut [f64],
) {
    let (weights, _) = weights.as_chunks::<R>();
    for (points, out) in points.chunks(LANES).zip(out.chunks_mut(LANES * R)) {
        let x = lanes(points);
        let mut sums = [[0.0; LANES]; R];
        for (base, weights) in base.iter().zip(weights) {
            let phi = kernel_lanes::<K>(&x, base, inverse);
            for column in 0..R {
                for lane in 0..LANES {
                    sums[column][lane] += phi[lane] * weights[column];
                }
            }
        }
        for (lane, out) in out.chunks_exact_mut(R).enumerate() {
            for column in 0..R {
                out[column] += sums[column][lane];
            }
        }
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn fill_tile<K: Radial>(points: &[Vector], base: &[Vector], inverse: f64, tile: &mut [f64]) {
    let n_points = points.len();
    for (group, points) in points.chunks(LANES).enumerate() {
        let x = lanes(points);
        for (base, column) in base.iter().zip(tile.chunks_exact_mut(n_points)) {
            let phi = kernel_lanes::<K>(&x, base, inverse);
            let start = group * LANES;
            column[start..start + points.len()].copy_from_slice(&phi[..points.len()]);
        }
    }
}

fn tiled_block<K: Radial>(
    points: &[Vector],
    reach: &mut Reach,
    n_columns: usize,
    inverse: f64,
    out: &mut [f64],
) {
    let weights = reach.weights.chunks(TILE * n_columns);
    for (base, weights) in reach.points.chunks(TILE).zip(weights) {
        reach.tile.resize(points.len() * base.len(), 0.0);
        fill_tile::<K>(points, base, inverse, &mut reach.tile);
        linear::add_product(out, &reach.tile, weights, base.len(), n_columns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(n: usize, seed: f64) -> Vec<Vector> {
        (0..n)
            .map(|i| std::array::from_fn(|k| ((i * 3 + k) as f64 * 12.9898 + seed).sin() * 3.0))
            .collect()
    }

    #[test]
    fn evaluation_equals_the_double_sum_for_every_kernel_and_width() {
        let (points, base) = (cloud(531, 0.1), cloud(300, 0.7));
        for kernel in [
            Kernel::WendlandC0,
            Kernel::WendlandC2,
            Kernel::WendlandC4,
            Kernel::WendlandC6,
        ] {
            for r in [1, 2, 4, 8, 9, 30] {
                let basis = Basis {
                    kernel,
                    radius: 2.5,
                };
                let weights: Vec<f64> = (0..base.len() * r).map(|i| (i as f64).cos()).collect();
                let weighted = WeightedBase {
                    basis,
                    points: &base,
                    weights: &weights,
                    n_columns: r,
                };
                let mut out = vec![0.0; points.len() * r];
                weighted.add_at(&points, &mut out);
                for (i, x) in points.iter().enumerate() {
                    for column in 0..r {
                        let sum: f64 = base
                            .iter()
                            .enumerate()
                            .map(|(j, b)| basis.between(x, b) * weights[j * r + column])
                            .sum();
                        assert!((out[i * r + column] - sum).abs() < 1e-12, "{kernel:?} {r}");
                    }
                }
            }
        }
    }
}
