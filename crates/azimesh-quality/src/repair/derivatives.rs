//! Value and derivatives of the functional of one cell: sums over its simplices.
//!
//! Leaves to `elements` which simplices those are, and to `patch` where the derivatives go.

use super::density::{Density, Space, value};
use super::elements::{Sample, Simplex, edge};
use super::singular::Columns;
use crate::validity::Samples;
use azimesh_core::geometry::vector::{Vector, add, scale};
use azimesh_core::linear::blocks::Block;
use multiversion::multiversion;

/// Sums over the simplices.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sum {
    /// The functional of `density`.
    Shapes {
        /// Its eps.
        eps: f64,
    },
    /// `|J|^2 / 2`.
    Squares,
}

/// Derivatives of the functional of one cell with respect to its nodes, and memory for making them.
#[derive(Debug, Clone, Default)]
pub(super) struct Derivatives {
    /// The value.
    pub value: f64,
    /// The least determinant.
    pub least: f64,
    /// Simplices that are not positive.
    pub n_folded: usize,
    /// Of each node.
    pub slope: Vec<Vector>,
    /// Of nodes `a <= b` at [`pair`].
    pub blocks: Vec<Block>,
    pub places: Vec<Vector>,
}

/// Index of the block of points `a <= b` of `n`.
#[inline(always)]
pub(super) fn pair(n: usize, a: usize, b: usize) -> usize {
    a * (2 * n - a + 1) / 2 + b - a
}

/// `J = sum_k d_k g_k^T` by columns, of edges `d` and rows `g` of the inverse of the target's.
#[inline(always)]
fn jacobian(space: Space, simplex: &Simplex, places: &[Vector]) -> Columns {
    let mut d = [[0.0; 3]; 3];
    for k in 0..space.n_edges() {
        d[k] = edge(simplex.edges[k], places);
    }
    of_target(space, &d, &simplex.inverse)
}

#[inline(always)]
fn of_target(space: Space, d: &Columns, inverse: &Columns) -> Columns {
    let n = space.n_edges();
    let mut j = [[0.0; 3]; 3];
    for k in 0..n {
        for column in 0..3 {
            let g = inverse[k][column];
            for axis in 0..3 {
                j[column][axis] += d[k][axis] * g;
            }
        }
    }
    if n == 2 {
        j[0][2] = 0.0;
        j[1][2] = 0.0;
        j[2] = [0.0, 0.0, 1.0];
    }
    j
}

/// `dx/ds` by columns, of the derivatives of the functions of nodes; in a plane the third is upright.
#[inline(always)]
pub(super) fn columns(space: Space, slopes: &[Vector], places: &[Vector]) -> Columns {
    let mut d = [[0.0; 3]; 3];
    for (slope, place) in slopes.iter().zip(places) {
        for k in 0..space.n_edges() {
            for axis in 0..3 {
                d[k][axis] += slope[k] * place[axis];
            }
        }
    }
    if space == Space::Plane {
        d[0][2] = 0.0;
        d[1][2] = 0.0;
        d[2] = [0.0, 0.0, 1.0];
    }
    d
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn values(
    space: Space,
    eps: f64,
    simplices: &[Simplex],
    places: &[Vector],
) -> (f64, f64, usize) {
    let (mut sum, mut least, mut n_folded) = (0.0, f64::INFINITY, 0);
    for simplex in simplices {
        let j = jacobian(space, simplex, places);
        let (value, determinant) = value(space, simplex.theta, eps, &j);
        sum += simplex.weight * value;
        least = f64::min(least, determinant);
        n_folded += usize::from(determinant <= 0.0);
    }
    (sum, least, n_folded)
}

/// [`values`] of the samples of a curved cell.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn sample_values(
    space: Space,
    eps: f64,
    samples: &[Sample],
    table: &Samples,
    places: &[Vector],
) -> (f64, f64, usize) {
    let (mut sum, mut least, mut n_folded) = (0.0, f64::INFINITY, 0);
    for sample in samples {
        let d = columns(space, table.of_nodes(sample.point as usize), places);
        let j = of_target(space, &d, &sample.inverse);
        let (value, determinant) = value(space, sample.theta, eps, &j);
        sum += sample.weight * value;
        least = f64::min(least, determinant);
        n_folded += usize::from(determinant <= 0.0);
    }
    (sum, least, n_folded)
}

/// [`derivatives`] of the samples of a curved cell.
#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn sample_derivatives(
    space: Space,
    sum: Sum,
    samples: &[Sample],
    table: &Samples,
    places: &[Vector],
    found: &mut Derivatives,
) {
    (found.value, found.least, found.n_folded) = (0.0, f64::INFINITY, 0);
    let n = places.len();
    let mut right = vec![[0.0; 3]; n];
    for sample in samples {
        let slopes = table.of_nodes(sample.point as usize);
        let d = columns(space, slopes, places);
        let j = of_target(space, &d, &sample.inverse);
        let density = Density::of(space, sample.theta, sum, &j);
        found.count(sample.weight, &density);
        for (a, slope) in slopes.iter().enumerate() {
            // The derivative of the node's function in the target.
            let mut g = [0.0; 3];
            for k in 0..space.n_edges() {
                g = add(g, scale(sample.inverse[k], slope[k]));
            }
            right[a] = density.right(g);
            for k in 0..3 {
                let by = scale(density.slope[k], sample.weight * g[k]);
                found.slope[a] = add(found.slope[a], by);
            }
        }
        let mut blocks = found.blocks.iter_mut();
        for a in 0..n {
            for (right_b, to) in right[a..].iter().zip(&mut blocks) {
                let block = density.block(right[a], *right_b);
                for m in 0..9 {
                    to[m] += sample.weight * block[m];
                }
            }
        }
    }
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn derivatives(
    space: Space,
    sum: Sum,
    simplices: &[Simplex],
    places: &[Vector],
    found: &mut Derivatives,
) {
    (found.value, found.least, found.n_folded) = (0.0, f64::INFINITY, 0);
    for simplex in simplices {
        let j = jacobian(space, simplex, places);
        let density = Density::of(space, simplex.theta, sum, &j);
        found.count(simplex.weight, &density);
        match space {
            Space::Plane => found.add::<2>(simplex, &density),
            Space::Solid => found.add::<3>(simplex, &density),
        }
    }
}

impl Density {
    #[inline(always)]
    fn of(space: Space, theta: f64, sum: Sum, j: &Columns) -> Self {
        match sum {
            Sum::Shapes { eps } => Self::new(space, theta, eps, j),
            Sum::Squares => Self::of_square(space, j),
        }
    }
}

impl Derivatives {
    #[inline(always)]
    fn count(&mut self, weight: f64, density: &Density) {
        self.value += weight * density.value;
        self.least = f64::min(self.least, density.determinant);
        self.n_folded += usize::from(density.determinant <= 0.0);
    }

    /// Adds the derivatives of a simplex.
    #[inline(always)]
    fn add<const N: usize>(&mut self, simplex: &Simplex, density: &Density) {
        let mut right = [[0.0; 3]; N];
        let w = simplex.weight;
        for k in 0..N {
            let g = simplex.inverse[k];
            right[k] = density.right(g);
            let mut slope = [0.0; 3];
            for axis in 0..3 {
                slope[axis] = w
                    * (density.slope[0][axis] * g[0]
                        + density.slope[1][axis] * g[1]
                        + density.slope[2][axis] * g[2]);
            }
            let [from, to] = simplex.edges[k].map(usize::from);
            for axis in 0..3 {
                self.slope[to][axis] += slope[axis];
                self.slope[from][axis] -= slope[axis];
            }
        }
        let mut blocks = [[[0.0; 9]; N]; N];
        for k in 0..N {
            for l in k..N {
                let mut block = density.block(right[k], right[l]);
                for value in &mut block {
                    *value *= w;
                }
                blocks[k][l] = block;
                if l > k {
                    blocks[l][k] = transposed(&block);
                }
            }
        }
        let from = simplex.edges[0][0];
        if simplex.edges[..N].iter().all(|edge| edge[0] == from) {
            self.add_corner(usize::from(from), simplex, &blocks);
        } else {
            self.add_crossing(simplex, &blocks);
        }
    }

    /// Of edges that leave one point.
    #[inline(always)]
    fn add_corner<const N: usize>(
        &mut self,
        from: usize,
        simplex: &Simplex,
        blocks: &[[Block; N]; N],
    ) {
        let mut own = [0.0; 9];
        for k in 0..N {
            let mut column = [0.0; 9];
            for l in 0..N {
                for m in 0..9 {
                    column[m] -= blocks[l][k][m];
                }
            }
            for m in 0..9 {
                own[m] -= column[m];
            }
            let to = usize::from(simplex.edges[k][1]);
            self.add_block(from, to, &column);
            self.add_block(to, to, &blocks[k][k]);
            for l in k + 1..N {
                let other = usize::from(simplex.edges[l][1]);
                self.add_block(to, other, &blocks[k][l]);
            }
        }
        self.add_block(from, from, &own);
    }

    /// Of edges in general.
    fn add_crossing<const N: usize>(&mut self, simplex: &Simplex, blocks: &[[Block; N]; N]) {
        for k in 0..N {
            for l in 0..N {
                let [a, b] = [simplex.edges[k], simplex.edges[l]];
                for (i, row) in a.into_iter().enumerate() {
                    for (j, column) in b.into_iter().enumerate() {
                        // All pairs are met in both orders: each is counted once.
                        if row <= column {
                            let sign = if i == j { 1.0 } else { -1.0 };
                            let block = blocks[k][l].map(|x| sign * x);
                            self.add_block(usize::from(row), usize::from(column), &block);
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_block(&mut self, row: usize, column: usize, block: &Block) {
        let n = self.slope.len();
        if row <= column {
            let to = &mut self.blocks[pair(n, row, column)];
            for m in 0..9 {
                to[m] += block[m];
            }
        } else {
            let to = &mut self.blocks[pair(n, column, row)];
            for (m, value) in transposed(block).into_iter().enumerate() {
                to[m] += value;
            }
        }
    }

    /// Hands what further points have on to the nodes that they are means of.
    pub(super) fn condense(&mut self, n_nodes: usize, means: &[Vec<u16>]) {
        let n = self.slope.len();
        // The whole symmetric matrix; rows of means go first to rows, then columns to columns.
        let mut whole = vec![[0.0; 9]; n * n];
        for a in 0..n {
            for b in a..n {
                let block = self.blocks[pair(n, a, b)];
                whole[a * n + b] = block;
                if b > a {
                    whole[b * n + a] = transposed(&block);
                }
            }
        }
        for (i, mean) in means.iter().enumerate() {
            let (from, share) = (n_nodes + i, 1.0 / mean.len().max(1) as f64);
            for &to in mean {
                let to = usize::from(to);
                self.slope[to] = add(self.slope[to], scale(self.slope[from], share));
                for column in 0..n {
                    let block = whole[from * n + column];
                    for m in 0..9 {
                        whole[to * n + column][m] += share * block[m];
                    }
                }
            }
        }
        for (i, mean) in means.iter().enumerate() {
            let (from, share) = (n_nodes + i, 1.0 / mean.len().max(1) as f64);
            for row in 0..n_nodes {
                let block = whole[row * n + from];
                for &to in mean {
                    for m in 0..9 {
                        whole[row * n + usize::from(to)][m] += share * block[m];
                    }
                }
            }
        }
        self.slope.truncate(n_nodes);
        self.blocks.clear();
        for a in 0..n_nodes {
            for b in a..n_nodes {
                self.blocks.push(whole[a * n + b]);
            }
        }
    }
}

/// `A^T`.
#[inline(always)]
pub(super) fn transposed(a: &Block) -> Block {
    [a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]]
}
