//! `Phi (N, n) . W (n, r)` for millions of points, without storing `Phi`.
//!
//! Points are worked on in blocks, one to a task. The base points within reach of a block pass in
//! tiles that stay in the first cache, and each vector register of points takes a tile at a time:
//!
//! 1. Distances to the tile, the kernel, and the sums of the first eight columns, in one loop. The
//!    square root limits it: one register takes as long as the rest of the arithmetic together. So
//!    the roots run [`AHEAD`] base points in front of the kernel, which never waits for them.
//! 2. For more columns the kernel values of the tile, kept from 1, times their weights.
//!
//! Coordinates are scaled by `1 / R`, so that a distance is `xi` at once. The instruction set is
//! chosen at run time. Each sum runs over the base points in their order, on any number of threads.

use super::Basis;
use super::kernel::{C0, C2, C4, C6, Kernel, Radial};
use crate::geometry::Bounds;
use crate::geometry::vector::{Vector, scale};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Points that one task works on; their bounding box decides which base points they see.
const BLOCK: usize = 256;
/// Base points in a tile, a multiple of `AHEAD`.
const TILE: usize = 128;
/// Base points that the square roots run in front of the kernel.
const AHEAD: usize = 4;
/// Columns whose sums stay in registers.
const PANEL: usize = 8;
/// Numbers in the widest vector register.
const MOST_LANES: usize = 8;

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

    /// `add_at` with the instructions of `arch`, for measurements.
    pub fn add_at_with(&self, arch: Arch, points: &[Vector], out: &mut [f64]) {
        assert_eq!(out.len(), points.len() * self.n_columns);
        if self.n_columns == 0 || self.points.is_empty() {
            return;
        }
        out.par_chunks_mut(BLOCK * self.n_columns)
            .zip(points.par_chunks(BLOCK))
            .for_each_init(
                || Block::new(self.n_columns),
                |block, (out, points)| {
                    block.load(points, self.basis.radius);
                    for near in self.within_reach(points).chunks(TILE) {
                        block.load_tile(self, near);
                        self.add_tile(arch, block);
                    }
                    block.add_to(out, self.n_columns);
                },
            );
    }

    /// Base points at which the kernel does not vanish all over the box around `points`.
    fn within_reach(&self, points: &[Vector]) -> Vec<usize> {
        let bounds = Bounds::around(points);
        let squared = self.basis.radius * self.basis.radius;
        (0..self.points.len())
            .filter(|&j| bounds.distance_squared(&self.points[j]) < squared)
            .collect()
    }

    fn add_tile(&self, arch: Arch, block: &mut Block) {
        match self.basis.kernel {
            Kernel::WendlandC0 => add_tile::<C0>(arch, block),
            Kernel::WendlandC2 => add_tile::<C2>(arch, block),
            Kernel::WendlandC4 => add_tile::<C4>(arch, block),
            Kernel::WendlandC6 => add_tile::<C6>(arch, block),
        }
    }
}

fn add_tile<K: Radial>(arch: Arch, block: &mut Block) {
    macro_rules! for_width {
        ($($r:literal),*) => {
            match block.width {
                $($r => arch.dispatch(Tile::<K, $r> { block, kernel: PhantomData }),)*
                width => unreachable!("a panel of {width} columns"),
            }
        };
    }
    const { assert!(PANEL == 8) };
    for_width!(1, 2, 3, 4, 5, 6, 7, 8);
}

/// What one task holds: a block of points with their sums, and a tile of base points.
struct Block {
    /// Columns in a panel: r, or `PANEL` with zeros to fill the last panel.
    width: usize,
    n_panels: usize,
    /// Scaled coordinates, one axis after the other.
    coordinates: [[f64; BLOCK]; 3],
    n_points: usize,
    /// Register of points by register, column by column in each.
    sums: Vec<f64>,
    /// Points in a register.
    lanes: usize,
    /// Scaled base points, filled up to a multiple of `AHEAD`.
    base: Vec<Vector>,
    /// Panel by panel, by rows in each; zero for the filling.
    weights: Vec<f64>,
    /// Kernel between one register of points and the tile.
    phi: Vec<f64>,
}

impl Block {
    fn new(n_columns: usize) -> Self {
        let width = n_columns.min(PANEL);
        let n_panels = n_columns.div_ceil(width);
        Self {
            width,
            n_panels,
            coordinates: [[0.0; BLOCK]; 3],
            n_points: 0,
            sums: vec![0.0; BLOCK * n_panels * width],
            lanes: 1,
            base: Vec::with_capacity(TILE),
            weights: vec![0.0; TILE * n_panels * width],
            phi: vec![0.0; TILE * MOST_LANES],
        }
    }

    /// Takes points and clears the sums. Points beyond the last keep coordinates of an earlier
    /// block; their sums are not read.
    fn load(&mut self, points: &[Vector], radius: f64) {
        let inverse = 1.0 / radius;
        self.n_points = points.len();
        self.sums.fill(0.0);
        for (axis, coordinates) in self.coordinates.iter_mut().enumerate() {
            for (to, point) in coordinates.iter_mut().zip(points) {
                *to = point[axis] * inverse;
            }
        }
    }

    fn load_tile(&mut self, base: &WeightedBase<'_>, near: &[usize]) {
        let inverse = 1.0 / base.basis.radius;
        let n_filled = near.len().next_multiple_of(AHEAD);
        self.base.clear();
        self.base
            .extend(near.iter().map(|&j| scale(base.points[j], inverse)));
        self.base.resize(n_filled, [0.0; 3]);
        self.weights.fill(0.0);
        let panels = self.weights.chunks_exact_mut(n_filled * self.width);
        for (panel, rows) in panels.take(self.n_panels).enumerate() {
            let start = panel * self.width;
            let end = base.n_columns.min(start + self.width);
            for (row, &j) in rows.chunks_exact_mut(self.width).zip(near) {
                let weights = &base.weights[j * base.n_columns..][start..end];
                row[..weights.len()].copy_from_slice(weights);
            }
        }
    }

    /// Adds the sums to the rows of `out`.
    fn add_to(&self, out: &mut [f64], n_columns: usize) {
        let n_filled = self.n_panels * self.width;
        let lanes = self.lanes;
        for (i, row) in out.chunks_exact_mut(n_columns).enumerate() {
            let sums = &self.sums[i / lanes * lanes * n_filled + i % lanes..];
            for (value, sum) in row.iter_mut().zip(sums.iter().step_by(lanes)) {
                *value += sum;
            }
        }
    }
}

/// Adds the contribution of a tile of base points to the sums of a block.
struct Tile<'a, K, const R: usize> {
    block: &'a mut Block,
    kernel: PhantomData<K>,
}

impl<K: Radial, const R: usize> WithSimd for Tile<'_, K, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let block = self.block;
        block.lanes = S::F64_LANES;
        let [x, y, z] = block
            .coordinates
            .each_ref()
            .map(|axis| S::as_simd_f64s(axis).0);
        let (base, _) = block.base.as_chunks::<AHEAD>();
        let (rows, _) = block.weights.as_chunks::<R>();
        let (phi, _) = S::as_mut_simd_f64s(&mut block.phi)
            .0
            .as_chunks_mut::<AHEAD>();
        let (sums, _) = S::as_mut_simd_f64s(&mut block.sums).0.as_chunks_mut::<R>();
        let n_groups = block.n_points.div_ceil(S::F64_LANES);
        for (group, panels) in sums
            .chunks_exact_mut(block.n_panels)
            .take(n_groups)
            .enumerate()
        {
            let at = [x[group], y[group], z[group]];
            let mut weights = rows.as_chunks::<AHEAD>().0.chunks_exact(base.len());
            let (first, rest) = panels.split_at_mut(1);
            let first_weights = weights.next().expect("weights of a panel");
            add_first::<K, S, R>(simd, at, base, first_weights, phi, &mut first[0]);
            for (sums, weights) in rest.iter_mut().zip(weights) {
                add_product(simd, phi, weights, sums);
            }
        }
    }
}

/// Keeps the kernel between a register of points and a tile in `phi`, and adds its product with
/// the weights to the sums.
#[inline(always)]
fn add_first<K: Radial, S: Simd, const R: usize>(
    simd: S,
    at: [S::f64s; 3],
    base: &[[Vector; AHEAD]],
    weights: &[[[f64; R]; AHEAD]],
    phi: &mut [[S::f64s; AHEAD]],
    sums: &mut [S::f64s; R],
) {
    let Some(first) = base.first() else { return };
    let mut xi = first.each_ref().map(|b| distance(simd, &at, b));
    let mut totals = *sums;
    for (step, (weights, phi)) in weights.iter().zip(phi).enumerate() {
        let next = base.get(step + 1).unwrap_or(first);
        for k in 0..AHEAD {
            let value = K::value(simd, xi[k]);
            xi[k] = distance(simd, &at, &next[k]);
            phi[k] = value;
            add_row(simd, value, &weights[k], &mut totals);
        }
    }
    *sums = totals;
}

/// Adds the product of kept kernel values with the weights of a panel to its sums.
#[inline(always)]
fn add_product<S: Simd, const R: usize>(
    simd: S,
    phi: &[[S::f64s; AHEAD]],
    weights: &[[[f64; R]; AHEAD]],
    sums: &mut [S::f64s; R],
) {
    let mut totals = *sums;
    for (weights, phi) in weights.iter().zip(phi) {
        for k in 0..AHEAD {
            add_row(simd, phi[k], &weights[k], &mut totals);
        }
    }
    *sums = totals;
}

#[inline(always)]
fn add_row<S: Simd, const R: usize>(
    simd: S,
    phi: S::f64s,
    weights: &[f64; R],
    totals: &mut [S::f64s; R],
) {
    for column in 0..R {
        let weight = simd.splat_f64s(weights[column]);
        totals[column] = simd.mul_add_e_f64s(phi, weight, totals[column]);
    }
}

/// Scaled distance of a register of points from a base point.
#[inline(always)]
fn distance<S: Simd>(simd: S, at: &[S::f64s; 3], base: &Vector) -> S::f64s {
    let [dx, dy, dz] =
        std::array::from_fn(|axis| simd.sub_f64s(at[axis], simd.splat_f64s(base[axis])));
    simd.sqrt_f64s(simd.mul_add_e_f64s(dz, dz, simd.mul_add_e_f64s(dy, dy, simd.mul_f64s(dx, dx))))
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
