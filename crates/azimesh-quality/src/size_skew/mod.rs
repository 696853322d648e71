//! Size and skew of cells against the reference mesh, by Knupp's algebraic metrics.
//!
//! ```text
//! tau = sum of alpha_k / that sum in the reference mesh,   f_size = min(tau, 1 / tau)
//! size-skew = sqrt(f_size) f_skew, 0 where a corner is flat or turned over
//! ```
//!
//! At corner `k` of a cell the edges to its neighbours are the columns of the Jacobian matrix `A_k`, and
//! `alpha_k = det A_k`. 1 for a cell of ideal angles that has kept its size. Not defined for polygons, polyhedra, prisms
//! on more corners, and cells whose corners are not all valid in the reference mesh.
//!
//! Source: P. M. Knupp, Algebraic mesh quality metrics for unstructured initial meshes, Finite Elements
//! in Analysis and Design 39, 2003. Pyramids and wedges, which it does not have, follow from the same
//! matrices.

#[cfg(test)]
mod tests;

use super::reference::Reference;
use super::summary::Extreme;
use super::visit::{self, CHUNK};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::parallel;
use azimesh_io::mesh::{DataArray, Mesh, Values};

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

/// The sum of the `alpha_k` of each cell in the reference mesh, 8 bytes a cell; NaN for cells that have no size-skew.
/// [`Reference::with_sizes`] makes them.
#[derive(Debug, Clone)]
pub struct ReferenceSizes(pub(super) Vec<f64>);

impl ReferenceSizes {
    /// Of the cells from `first` on.
    pub(super) fn from(&self, first: usize) -> &[f64] {
        &self.0[first..]
    }
}

/// Size-skew of every cell of `mesh` with nodes at `points` as a cell array `SizeSkew`; NaN where it is not defined.
///
/// # Panics
/// When there are fewer positions than nodes, or `reference` and `sizes` are of a mesh with fewer cells.
pub fn per_cell(
    mesh: &Mesh,
    points: &[Vector],
    reference: &Reference,
    sizes: &ReferenceSizes,
) -> DataArray {
    let mut all = vec![f64::NAN; mesh.cells.len()];
    parallel::for_blocks(&mut all, CHUNK, &|start, own| {
        let cells = start..start + own.len();
        visit::volume_cells(mesh, points, reference.facing(), cells, |first, block| {
            let before = &sizes.from(first)[..block.n];
            for (i, before) in before.iter().enumerate() {
                own[first + i - start] = size_skew(block.size[i], block.skew[i], *before);
            }
        });
    });
    DataArray::scalar("SizeSkew", Values::F64(all))
}

/// Of a cell with the sum `size` of its `alpha_k`, which is `before` in the reference mesh, and this `f_skew`.
#[inline(always)]
pub(super) fn size_skew(size: f64, skew: f64, before: f64) -> f64 {
    let tau = size / before;
    // Not a number for a cell that is turned over.
    let product = (if tau < 1.0 { tau } else { 1.0 / tau }).sqrt() * skew;
    let value = if product.is_finite() { product } else { 0.0 };
    if before.is_nan() { f64::NAN } else { value }
}

/// One over the cube root of a number that is not negative, to a few units in the last place, without branches and
/// divisions; of no meaning below 1e-290 and for what is not finite.
///
/// The exponent is divided by three. With `h = 1 - x r^3`, `r (1 - h)^(-1/3)` is exact. Two steps with four terms of the
/// series each multiply the number of correct digits by four.
#[inline(always)]
pub(super) fn inverse_cube_root(x: f64) -> f64 {
    let high = (x.to_bits() >> 32) as u32;
    let mut r = f64::from_bits(u64::from(0x553e_f0ff - high / 3) << 32);
    for _ in 0..2 {
        let h = 1.0 - x * (r * r * r);
        r += r * (h * (1.0 / 3.0 + h * (2.0 / 9.0 + h * (14.0 / 81.0))));
    }
    r
}
