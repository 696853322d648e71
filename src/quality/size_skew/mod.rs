//! Size and skew of cells against the reference mesh, by Knupp's algebraic metrics.
//!
//! ```text
//! tau = sum of alpha_k / that sum in the reference mesh,   f_size = min(tau, 1 / tau)
//! size-skew = sqrt(f_size) f_skew, 0 where a corner is flat or turned over
//! ```
//!
//! 1 for a cell of ideal angles that has kept its size. Not defined for polygons, polyhedra, prisms on
//! more corners, and cells whose corners are not all valid in the reference mesh.

mod shapes;
#[cfg(test)]
mod tests;

use super::reference::Reference;
use super::summary::Extreme;
use crate::geometry::vector::Vector;
use crate::mesh::{CellKind, CellRun, DataArray, Mesh, Values};
use crate::parallel;
use multiversion::multiversion;
use shapes::{Corners, Shape};

/// Cells that are folded into one part of the sums.
const CHUNK: usize = 4096;
/// Cells side by side in vectors.
const BLOCK: usize = 64;

/// Least and mean size-skew of the volume cells of a mesh; `None` where no cell has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SizeSkew {
    /// The least.
    pub min: Option<Extreme>,
    /// The mean.
    pub mean: Option<f64>,
}

impl SizeSkew {
    /// Names and values for lists of results.
    pub fn columns(&self) -> [(&'static str, Option<f64>); 2] {
        [
            ("min_size_skew", self.min.map(|e| e.value)),
            ("mean_size_skew", self.mean),
        ]
    }
}

/// Positions of the nodes now and in the reference mesh.
#[derive(Clone, Copy)]
struct Positions<'a> {
    now: &'a [Vector],
    before: &'a [Vector],
    reference: &'a Reference,
}

/// Size-skew of the cells of `mesh` with nodes at `points`, relative to those at `before` that `reference` was
/// made from.
///
/// One parallel pass; the same on any number of threads.
///
/// # Panics
/// When there are fewer positions than nodes, or `reference` is of a mesh with fewer cells.
pub fn assess(
    mesh: &Mesh,
    points: &[Vector],
    before: &[Vector],
    reference: &Reference,
) -> SizeSkew {
    let positions = Positions {
        now: points,
        before,
        reference,
    };
    let parts = parallel::map_blocks(mesh.cells.len(), CHUNK, &|cells| {
        let mut part = SizeSkewTotals::default();
        for run in mesh.volume_runs_in(cells) {
            positions.visit(&run, &mut |first, values| part.take(first, values));
        }
        part
    });
    let mut whole = SizeSkewTotals::default();
    for part in &parts {
        whole.sum += part.sum;
        whole.n += part.n;
        if let Some(least) = part.least {
            whole.include(least);
        }
    }
    SizeSkew {
        min: whole.least,
        mean: (whole.n > 0).then(|| whole.sum / whole.n as f64),
    }
}

/// Size-skew of every cell as a cell array `SizeSkew`; NaN where it is not defined.
///
/// # Panics
/// As [`assess`].
pub fn per_cell(
    mesh: &Mesh,
    points: &[Vector],
    before: &[Vector],
    reference: &Reference,
) -> DataArray {
    let positions = Positions {
        now: points,
        before,
        reference,
    };
    let mut all = vec![f64::NAN; mesh.cells.len()];
    parallel::for_blocks(&mut all, CHUNK, &|start, own| {
        for run in mesh.volume_runs_in(start..start + own.len()) {
            positions.visit(&run, &mut |first, values| {
                own[first - start..][..values.len()].copy_from_slice(values);
            });
        }
    });
    DataArray::scalar("SizeSkew", Values::F64(all))
}

/// Sum, count and least value over a chunk of cells.
#[derive(Default)]
struct SizeSkewTotals {
    sum: f64,
    n: usize,
    least: Option<Extreme>,
}

impl SizeSkewTotals {
    fn take(&mut self, first: usize, values: &[f64]) {
        let mut sum = 0.0;
        for (cell, &value) in (first..).zip(values) {
            if value.is_nan() {
                continue;
            }
            sum += value;
            self.n += 1;
            self.include(Extreme { value, cell });
        }
        self.sum += sum;
    }

    #[inline]
    fn include(&mut self, found: Extreme) {
        if self.least.is_none_or(|least| found.value < least.value) {
            self.least = Some(found);
        }
    }
}

impl Positions<'_> {
    /// Calls `visit(first_cell, size_skews)` for the cells of a run, some at a time; not for kinds that
    /// do not have it.
    fn visit(&self, run: &CellRun<'_>, visit: &mut impl FnMut(usize, &[f64])) {
        match run.kind.linear() {
            CellKind::Triangle => self.measure::<shapes::Triangle, 3>(run, visit),
            CellKind::Quadrilateral => self.measure::<shapes::Quadrilateral, 4>(run, visit),
            CellKind::Tetrahedron => self.measure::<shapes::Tetrahedron, 4>(run, visit),
            CellKind::Pyramid => self.measure::<shapes::Pyramid, 5>(run, visit),
            CellKind::Wedge => self.measure::<shapes::Wedge, 6>(run, visit),
            CellKind::Hexahedron => self.measure::<shapes::Hexahedron, 8>(run, visit),
            _ => {}
        }
    }

    fn measure<S: Shape<N>, const N: usize>(
        &self,
        run: &CellRun<'_>,
        visit: &mut impl FnMut(usize, &[f64]),
    ) {
        let mut block = Block::<N>::EMPTY;
        let mut values = [0.0; BLOCK];
        let mut first = run.first_cell;
        for cells in run.connectivity.chunks(BLOCK * run.n_nodes) {
            let n = cells.len() / run.n_nodes;
            for i in 0..n {
                let facing = self.reference.facing().of(first + i);
                for axis in 0..3 {
                    block.facing[axis][i] = facing[axis];
                }
                block.sign[i] = if self.reference.is_valid(first + i) {
                    f64::from(self.reference.sign(first + i))
                } else {
                    f64::NAN
                };
            }
            measure::<S, N>(
                cells,
                run.n_nodes,
                self.now,
                self.before,
                &mut block,
                &mut values,
            );
            visit(first, &values[..n]);
            first += n;
        }
    }
}

type Column = [f64; BLOCK];

/// Corners of some cells now and in the reference mesh, one column a coordinate.
struct Block<const N: usize> {
    now: [[Column; 3]; N],
    before: [[Column; 3]; N],
    facing: [Column; 3],
    /// Orientation in the reference mesh; NaN for a cell that is not valid there.
    sign: Column,
}

impl<const N: usize> Block<N> {
    const EMPTY: Self = Self {
        now: [[[0.0; BLOCK]; 3]; N],
        before: [[[0.0; BLOCK]; 3]; N],
        facing: [[0.0; BLOCK]; 3],
        sign: [0.0; BLOCK],
    };
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn measure<S: Shape<N>, const N: usize>(
    cells: &[u32],
    n_nodes: usize,
    now: &[Vector],
    before: &[Vector],
    block: &mut Block<N>,
    values: &mut Column,
) {
    for (i, nodes) in cells.chunks_exact(n_nodes).take(BLOCK).enumerate() {
        let nodes = nodes.first_chunk::<N>().expect("a cell has its corners");
        for k in 0..N {
            let (point, reference) = (now[nodes[k] as usize], before[nodes[k] as usize]);
            for axis in 0..3 {
                block.now[k][axis][i] = point[axis];
                block.before[k][axis][i] = reference[axis];
            }
        }
    }
    for i in 0..BLOCK {
        let vector = |columns: &[Column; 3]| [columns[0][i], columns[1][i], columns[2][i]];
        let (mut p, mut q) = ([[0.0; 3]; N], [[0.0; 3]; N]);
        for k in 0..N {
            p[k] = vector(&block.now[k]);
            q[k] = vector(&block.before[k]);
        }
        let facing = vector(&block.facing);
        let reference = S::corners(&q, facing).sum;
        values[i] = size_skew(&S::corners(&p, facing), reference, block.sign[i]);
    }
}

#[inline(always)]
fn size_skew(corners: &Corners, reference: f64, sign: f64) -> f64 {
    let least = if sign < 0.0 {
        -corners.high
    } else {
        corners.low
    };
    let tau = corners.sum / reference;
    let size = if tau < 1.0 { tau } else { 1.0 / tau };
    let product = size.sqrt() * corners.skew;
    let value = if least > 0.0 && product.is_finite() {
        product
    } else {
        0.0
    };
    // Not a number for a cell that is not judged.
    if sign.is_nan() { f64::NAN } else { value }
}
