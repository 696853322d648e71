//! `Phi (N, n) . W (n, r)` for millions of points, without storing `Phi`.
//!
//! A block of points is cut into groups of one vector register; each group keeps its sums in
//! registers while the base points stream by. The instruction set is chosen at run time.
//! Coordinates are scaled by `1 / R`, so that a distance is `xi` at once.

use super::Basis;
use super::kernel::{C0, C2, C4, C6, Kernel, Radial};
use crate::geometry::Bounds;
use crate::geometry::vector::{Vector, scale};
use crate::linear;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Points that one task works on; their bounding box decides which base points they see.
const BLOCK: usize = 256;
/// Numbers in the widest vector register.
const MOST_LANES: usize = 8;
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
        self.add_at_with(Arch::new(), points, out);
    }

    /// `add_at` with the instructions of `arch`, to measure them beside each other.
    pub fn add_at_with(&self, arch: Arch, points: &[Vector], out: &mut [f64]) {
        assert_eq!(out.len(), points.len() * self.n_columns);
        if self.n_columns == 0 || self.points.is_empty() {
            return;
        }
        out.par_chunks_mut(BLOCK * self.n_columns)
            .zip(points.par_chunks(BLOCK))
            .for_each_init(Reach::default, |reach, (out, points)| {
                reach.gather(self, points);
                self.add_block(arch, reach, points, out);
            });
    }

    fn add_block(&self, arch: Arch, reach: &mut Reach, points: &[Vector], out: &mut [f64]) {
        match self.basis.kernel {
            Kernel::WendlandC0 => self.add_with::<C0>(arch, reach, points, out),
            Kernel::WendlandC2 => self.add_with::<C2>(arch, reach, points, out),
            Kernel::WendlandC4 => self.add_with::<C4>(arch, reach, points, out),
            Kernel::WendlandC6 => self.add_with::<C6>(arch, reach, points, out),
        }
    }

    fn add_with<K: Radial>(
        &self,
        arch: Arch,
        reach: &mut Reach,
        points: &[Vector],
        out: &mut [f64],
    ) {
        macro_rules! fused {
            ($($r:literal),*) => {
                match self.n_columns {
                    $($r => arch.dispatch(Fused::<K, $r> {
                        points,
                        base: reach,
                        inverse: 1.0 / self.basis.radius,
                        out,
                        kernel: PhantomData,
                    }),)*
                    r => self.add_tiles::<K>(arch, reach, points, r, out),
                }
            };
        }
        const { assert!(MOST_FUSED == 8) };
        fused!(1, 2, 3, 4, 5, 6, 7, 8);
    }

    fn add_tiles<K: Radial>(
        &self,
        arch: Arch,
        reach: &mut Reach,
        points: &[Vector],
        n_columns: usize,
        out: &mut [f64],
    ) {
        let weights = reach.weights.chunks(TILE * n_columns);
        for (base, weights) in reach.points.chunks(TILE).zip(weights) {
            reach.tile.resize(points.len() * base.len(), 0.0);
            arch.dispatch(Tile::<K> {
                points,
                base,
                inverse: 1.0 / self.basis.radius,
                tile: &mut reach.tile,
                kernel: PhantomData,
            });
            linear::add_product(out, &reach.tile, weights, base.len(), n_columns);
        }
    }
}

/// Base points within reach of a block, scaled by `1 / R`, with their weights.
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
        let inverse = 1.0 / base.basis.radius;
        let r = base.n_columns;
        self.points.clear();
        self.weights.clear();
        for (j, point) in base.points.iter().enumerate() {
            if bounds.distance_squared(point) < squared {
                self.points.push(scale(*point, inverse));
                self.weights.extend_from_slice(&base.weights[j * r..][..r]);
            }
        }
    }
}

/// Scaled coordinates of at most a register of points; the last point is repeated to fill it.
#[inline(always)]
fn load_points<S: Simd>(simd: S, points: &[Vector], inverse: f64) -> [S::f64s; 3] {
    let last = points.len() - 1;
    std::array::from_fn(|axis| {
        let lanes: [f64; MOST_LANES] =
            std::array::from_fn(|lane| points[lane.min(last)][axis] * inverse);
        simd.partial_load_f64s(&lanes[..S::F64_LANES])
    })
}

/// The kernel between a register of points and a base point.
#[inline(always)]
fn phi<K: Radial, S: Simd>(simd: S, x: &[S::f64s; 3], base: &Vector) -> S::f64s {
    let [dx, dy, dz] =
        std::array::from_fn(|axis| simd.sub_f64s(x[axis], simd.splat_f64s(base[axis])));
    let squared = simd.mul_add_e_f64s(dz, dz, simd.mul_add_e_f64s(dy, dy, simd.mul_f64s(dx, dx)));
    K::value(simd, simd.sqrt_f64s(squared))
}

/// Kernel and product with the weights in one go, for few columns.
struct Fused<'a, K, const R: usize> {
    points: &'a [Vector],
    base: &'a Reach,
    inverse: f64,
    out: &'a mut [f64],
    kernel: PhantomData<K>,
}

impl<K: Radial, const R: usize> WithSimd for Fused<'_, K, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (weights, _) = self.base.weights.as_chunks::<R>();
        let groups = self.points.chunks(S::F64_LANES);
        for (points, out) in groups.zip(self.out.chunks_mut(S::F64_LANES * R)) {
            let x = load_points(simd, points, self.inverse);
            let mut sums = [simd.splat_f64s(0.0); R];
            for (base, weights) in self.base.points.iter().zip(weights) {
                let phi = phi::<K, S>(simd, &x, base);
                for column in 0..R {
                    let weight = simd.splat_f64s(weights[column]);
                    sums[column] = simd.mul_add_e_f64s(phi, weight, sums[column]);
                }
            }
            for column in 0..R {
                let mut lanes = [0.0; MOST_LANES];
                simd.partial_store_f64s(&mut lanes[..S::F64_LANES], sums[column]);
                for (row, sum) in out.chunks_exact_mut(R).zip(lanes) {
                    row[column] += sum;
                }
            }
        }
    }
}

/// The kernel between all points and some base points, by columns.
struct Tile<'a, K> {
    points: &'a [Vector],
    base: &'a [Vector],
    inverse: f64,
    tile: &'a mut [f64],
    kernel: PhantomData<K>,
}

impl<K: Radial> WithSimd for Tile<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n_points = self.points.len();
        for (group, points) in self.points.chunks(S::F64_LANES).enumerate() {
            let x = load_points(simd, points, self.inverse);
            let start = group * S::F64_LANES;
            for (base, column) in self.base.iter().zip(self.tile.chunks_exact_mut(n_points)) {
                let phi = phi::<K, S>(simd, &x, base);
                simd.partial_store_f64s(&mut column[start..start + points.len()], phi);
            }
        }
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
