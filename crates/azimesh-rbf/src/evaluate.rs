//! `Phi (N, n) . W (n, r)` for millions of points, without storing `Phi`.
//!
//! A block of points is cut into groups of one vector register; each group keeps its sums in
//! registers while the base points stream by. The instruction set is chosen at run time.
//! Coordinates are scaled by `1 / R`, so that a distance is `xi` at once.

use super::Basis;
use super::kernel::{C0, C2, C4, C6, Kernel, Radial};
use azimesh_core::geometry::Bounds;
use azimesh_core::geometry::vector::{Vector, scale};
use azimesh_core::linear;
use azimesh_core::parallel::{self, Scratch};
use pulp::{Arch, Simd, WithSimd};
use std::marker::PhantomData;

/// Points that one task works on; their bounding box decides which base points they see.
const BLOCK: usize = 256;
/// Numbers in the widest vector register.
const MOST_LANES: usize = 8;
/// Above this many columns the kernel is evaluated once into a tile and multiplied as a matrix.
const MOST_FUSED: usize = 8;
/// Base points in a tile of that matrix.
const TILE: usize = 128;
/// Smaller tiles are filled with points of weight zero: products over so few may be rounded differently.
const LEAST_TILE: usize = 3;
/// Square roots under way or waiting for their kernel value.
const ROOTS: usize = 8;
/// Base points that have entered the pipeline when the first leaves it: two wait for their root.
const DEPTH: usize = ROOTS + 2;
/// Base points that all points of a block see before the next ones; they stay in the cache.
const NEAR: usize = 50 * DEPTH;

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
    /// Uses all threads. The result at a point does not depend on the other points. `N n` kernel evaluations; base points
    /// beyond the support radius of a block's bounding box are skipped, which is effective if neighbours in memory are neighbours
    /// in space.
    pub fn add_at(&self, points: &[Vector], out: &mut [f64]) {
        self.add_at_with(Arch::new(), points, out);
    }

    /// `add_at` with the instructions of `arch`, to compare their speed.
    pub fn add_at_with(&self, arch: Arch, points: &[Vector], out: &mut [f64]) {
        assert_eq!(out.len(), points.len() * self.n_columns);
        let r = self.n_columns;
        if r == 0 || self.points.is_empty() {
            return;
        }
        let scratch = Scratch::new(NearbyBase::default);
        parallel::for_blocks(out, BLOCK * r, &|first, out| {
            let points = &points[first / r..][..out.len() / r];
            scratch.with(|nearby| {
                nearby.gather(self, points);
                self.add_block(arch, nearby, points, out);
            });
        });
    }

    fn add_block(&self, arch: Arch, nearby: &mut NearbyBase, points: &[Vector], out: &mut [f64]) {
        match self.basis.kernel {
            Kernel::WendlandC0 => self.add_with::<C0>(arch, nearby, points, out),
            Kernel::WendlandC2 => self.add_with::<C2>(arch, nearby, points, out),
            Kernel::WendlandC4 => self.add_with::<C4>(arch, nearby, points, out),
            Kernel::WendlandC6 => self.add_with::<C6>(arch, nearby, points, out),
        }
    }

    fn add_with<K: Radial>(
        &self,
        arch: Arch,
        nearby: &mut NearbyBase,
        points: &[Vector],
        out: &mut [f64],
    ) {
        macro_rules! fused {
            ($($r:literal),*) => {
                match self.n_columns {
                    $($r => arch.dispatch(Fused::<K, $r> {
                        points,
                        base: nearby,
                        inverse: 1.0 / self.basis.radius,
                        out,
                        kernel: PhantomData,
                    }),)*
                    r => self.add_tiles::<K>(arch, nearby, points, r, out),
                }
            };
        }
        const { assert!(MOST_FUSED == 8) };
        fused!(1, 2, 3, 4, 5, 6, 7, 8);
    }

    fn add_tiles<K: Radial>(
        &self,
        arch: Arch,
        nearby: &mut NearbyBase,
        points: &[Vector],
        n_columns: usize,
        out: &mut [f64],
    ) {
        if points.len() < BLOCK {
            // A product of few rows may be summed in another order.
            let last = points[points.len() - 1];
            let mut full = points.to_vec();
            full.resize(BLOCK, last);
            let mut rows = out.to_vec();
            rows.resize(BLOCK * n_columns, 0.0);
            self.add_tiles::<K>(arch, nearby, &full, n_columns, &mut rows);
            out.copy_from_slice(&rows[..out.len()]);
            return;
        }
        let mut start = 0;
        for &end in &nearby.tile_ends {
            let base = &nearby.points[start..end];
            let weights = &nearby.weights[start * n_columns..end * n_columns];
            start = end;
            nearby.tile.resize(points.len() * base.len(), 0.0);
            arch.dispatch(Tile::<K> {
                points,
                base,
                inverse: 1.0 / self.basis.radius,
                tile: &mut nearby.tile,
                kernel: PhantomData,
            });
            linear::add_product(out, &nearby.tile, weights, base.len(), n_columns);
        }
    }
}

/// Base points within the support radius of a block, scaled by `1 / R`, with their weights; filled up to a
/// multiple of `DEPTH` by points of weight zero.
#[derive(Default)]
struct NearbyBase {
    points: Vec<Vector>,
    weights: Vec<f64>,
    /// For more columns than are fused: the end of each group of `TILE` base points with any point near. The groups, and so
    /// the order of summation, do not depend on the number of near points.
    tile_ends: Vec<usize>,
    tile: Vec<f64>,
}

impl NearbyBase {
    fn gather(&mut self, base: &WeightedBase<'_>, block: &[Vector]) {
        let bounds = Bounds::around(block);
        let squared = base.basis.radius * base.basis.radius;
        let inverse = 1.0 / base.basis.radius;
        let r = base.n_columns;
        self.points.clear();
        self.weights.clear();
        self.tile_ends.clear();
        for (tile, points) in base.points.chunks(TILE).enumerate() {
            let n_before = self.points.len();
            for (j, point) in (tile * TILE..).zip(points) {
                if bounds.distance_squared(point) < squared {
                    self.points.push(scale(*point, inverse));
                    self.weights.extend_from_slice(&base.weights[j * r..][..r]);
                }
            }
            if self.points.len() > n_before && r > MOST_FUSED {
                let n_filled = self.points.len().max(n_before + LEAST_TILE);
                self.points.resize(n_filled, [0.0; 3]);
                self.weights.resize(n_filled * r, 0.0);
                self.tile_ends.push(self.points.len());
            }
        }
        let n_filled = self.points.len().next_multiple_of(DEPTH);
        self.points.resize(n_filled, [0.0; 3]);
        self.weights.resize(n_filled * r, 0.0);
    }
}

/// Scaled coordinates of at most a register of points; the last point is repeated to fill it.
#[inline(always)]
fn load_points<S: Simd>(simd: S, points: &[Vector], inverse: f64) -> [S::f64s; 3] {
    let last = points.len() - 1;
    let mut lanes = [[0.0; MOST_LANES]; 3];
    for lane in 0..MOST_LANES {
        let point = points[lane.min(last)];
        for axis in 0..3 {
            lanes[axis][lane] = point[axis] * inverse;
        }
    }
    [
        simd.partial_load_f64s(&lanes[0][..S::F64_LANES]),
        simd.partial_load_f64s(&lanes[1][..S::F64_LANES]),
        simd.partial_load_f64s(&lanes[2][..S::F64_LANES]),
    ]
}

/// Squared distances of a register of points from a base point.
#[inline(always)]
fn squared_distance<S: Simd>(simd: S, x: &[S::f64s; 3], base: &Vector) -> S::f64s {
    let dx = simd.sub_f64s(x[0], simd.splat_f64s(base[0]));
    let dy = simd.sub_f64s(x[1], simd.splat_f64s(base[1]));
    let dz = simd.sub_f64s(x[2], simd.splat_f64s(base[2]));
    simd.mul_add_e_f64s(dz, dz, simd.mul_add_e_f64s(dy, dy, simd.mul_f64s(dx, dx)))
}

/// Distances from base points, each delivered `DEPTH` base points after it was requested.
/// The unit for square roots takes longer for each than all other work on a pair, so it must never wait. A processor looks
/// only a few pairs ahead: if the kernel followed its root at once, work waiting for the root would fill that window, and the
/// next root would start late. The roots are in memory, indexed at run time, because a compiler that holds them in registers
/// moves them together again.
struct Pipeline<'a, S: Simd> {
    squares: [S::f64s; 2],
    roots: &'a mut CacheLines<[S::f64s; ROOTS]>,
    oldest: usize,
}

/// Starts at a cache line, so that no register is stored across two of them.
#[repr(align(64))]
struct CacheLines<T>(T);

impl<S: Simd> Pipeline<'_, S> {
    /// Adds the distances of `x` from `base` and returns those added `DEPTH` calls before.
    #[inline(always)]
    fn distance(&mut self, simd: S, x: &[S::f64s; 3], base: &Vector) -> S::f64s {
        let distance = self.roots.0[self.oldest];
        self.roots.0[self.oldest] = simd.sqrt_f64s(self.squares[0]);
        self.oldest = (self.oldest + 1) % ROOTS;
        self.squares = [self.squares[1], squared_distance(simd, x, base)];
        distance
    }
}

/// The kernel and its product with the weights in one pass, for few columns.
struct Fused<'a, K, const R: usize> {
    points: &'a [Vector],
    base: &'a NearbyBase,
    inverse: f64,
    out: &'a mut [f64],
    kernel: PhantomData<K>,
}

impl<K: Radial, const R: usize> WithSimd for Fused<'_, K, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (weights, _) = self.base.weights.as_chunks::<R>();
        let tiles = self.base.points.chunks(NEAR);
        for (base, weights) in tiles.zip(weights.chunks(NEAR)) {
            self.add_near(simd, base, weights);
        }
    }
}

impl<K: Radial, const R: usize> Fused<'_, K, R> {
    /// Adds the part of some base points. At the end of a register of points the pipeline already takes the first base points
    /// for the next register.
    #[inline(always)]
    fn add_near<S: Simd>(&mut self, simd: S, base: &[Vector], weights: &[[f64; R]]) {
        let zero = simd.splat_f64s(0.0);
        let mut pipeline = Pipeline {
            squares: [zero; 2],
            roots: &mut CacheLines([zero; ROOTS]),
            oldest: 0,
        };
        let (first, later) = base.split_at(DEPTH);
        let (early, late) = weights.split_at(later.len());
        let mut x = load_points(simd, self.points, self.inverse);
        for base in first {
            pipeline.distance(simd, &x, base);
        }
        for (group, out) in self.out.chunks_mut(S::F64_LANES * R).enumerate() {
            let mut sums = load_rows::<S, R>(simd, out);
            for (base, weights) in later.iter().zip(early) {
                let xi = pipeline.distance(simd, &x, base);
                add_row(simd, K::value(simd, xi), weights, &mut sums);
            }
            let next = ((group + 1) * S::F64_LANES).min(self.points.len() - 1);
            x = load_points(simd, &self.points[next..], self.inverse);
            for (base, weights) in first.iter().zip(late) {
                let xi = pipeline.distance(simd, &x, base);
                add_row(simd, K::value(simd, xi), weights, &mut sums);
            }
            store_rows(simd, &sums, out);
        }
    }
}

/// Adds the product of kernel values with the weights of one base point.
#[inline(always)]
fn add_row<S: Simd, const R: usize>(
    simd: S,
    phi: S::f64s,
    weights: &[f64; R],
    sums: &mut [S::f64s; R],
) {
    for column in 0..R {
        let weight = simd.splat_f64s(weights[column]);
        sums[column] = simd.mul_add_e_f64s(phi, weight, sums[column]);
    }
}

/// The rows of `out`, one per lane: sums continue from the base points before.
#[inline(always)]
fn load_rows<S: Simd, const R: usize>(simd: S, out: &[f64]) -> [S::f64s; R] {
    let mut sums = [simd.splat_f64s(0.0); R];
    for column in 0..R {
        let mut lanes = [0.0; MOST_LANES];
        for (row, lane) in out.chunks_exact(R).zip(&mut lanes) {
            *lane = row[column];
        }
        sums[column] = simd.partial_load_f64s(&lanes[..S::F64_LANES]);
    }
    sums
}

/// Writes each lane of the sums to its row of `out`.
#[inline(always)]
fn store_rows<S: Simd, const R: usize>(simd: S, sums: &[S::f64s; R], out: &mut [f64]) {
    for column in 0..R {
        let mut lanes = [0.0; MOST_LANES];
        simd.partial_store_f64s(&mut lanes[..S::F64_LANES], sums[column]);
        for (row, sum) in out.chunks_exact_mut(R).zip(lanes) {
            row[column] = sum;
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
                let xi = simd.sqrt_f64s(squared_distance(simd, &x, base));
                let phi = K::value(simd, xi);
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
    #[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
    fn evaluation_equals_the_double_sum_for_every_kernel_and_width() {
        let (points, base) = (cloud(531, 0.1), cloud(2 * NEAR + 3, 0.7));
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

    #[test]
    #[cfg_attr(debug_assertions, ignore = "takes long without optimization")]
    fn what_a_point_gets_does_not_depend_on_the_others() {
        let (points, base) = (cloud(3000, 0.1), cloud(2 * NEAR + 3, 0.7));
        for r in [1, 3, 6, 8, 9, 12, 30] {
            let weights: Vec<f64> = (0..base.len() * r).map(|i| (i as f64).cos()).collect();
            for radius in [0.7, 2.5, 50.0] {
                let weighted = WeightedBase {
                    basis: Basis {
                        kernel: Kernel::WendlandC2,
                        radius,
                    },
                    points: &base,
                    weights: &weights,
                    n_columns: r,
                };
                let mut all = vec![0.0; points.len() * r];
                weighted.add_at(&points, &mut all);
                for (every, first) in [(1, 1300), (2, 0), (7, 3), (300, 11), (700, 5), (5000, 2)] {
                    let rows: Vec<usize> = (first..points.len()).step_by(every).collect();
                    let some: Vec<Vector> = rows.iter().map(|&row| points[row]).collect();
                    let mut found = vec![0.0; some.len() * r];
                    weighted.add_at(&some, &mut found);
                    for (row, found) in rows.iter().zip(found.chunks(r)) {
                        assert_eq!(found, &all[row * r..][..r], "{r} {radius} {every}");
                    }
                }
            }
        }
    }

    #[test]
    fn fewer_base_points_than_the_pipeline_holds_and_one_point_more_than_a_register() {
        for n_base in [1, DEPTH - 1, DEPTH, DEPTH + 1] {
            for n_points in [1, 3, 9] {
                let (points, base) = (cloud(n_points, 0.1), cloud(n_base, 0.7));
                let basis = Basis {
                    kernel: Kernel::WendlandC2,
                    radius: 12.0,
                };
                let weighted = WeightedBase {
                    basis,
                    points: &base,
                    weights: &vec![1.5; n_base],
                    n_columns: 1,
                };
                let mut out = vec![0.25; n_points];
                weighted.add_at(&points, &mut out);
                for (value, x) in out.iter().zip(&points) {
                    let sum: f64 = base.iter().map(|b| basis.between(x, b) * 1.5).sum();
                    assert!((value - 0.25 - sum).abs() < 1e-12, "{n_base} {n_points}");
                }
            }
        }
    }
}
