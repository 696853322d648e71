//! The constrained system factored once, for many right-hand sides, and its transpose.

use super::{Block, Expanded, System};
use crate::Basis;
use crate::constraint::Constraint;
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add};
use azimesh_core::linear::Cholesky;

/// Base points with the factors of their system.
///
/// With `N` the directions of the constraints, `M = N^T [sum_g phi R_g] N` the matrix and `X` the map from weights to the
/// turned weights of all images, the weights of values `d (n, 3)` are
///
/// ```text
/// w = X S d,     S = N M^-1 N^T,     w_(g, j) = R_g (S d)_j
/// ```
///
/// `M` is symmetric as the images are a group, so `S^T = S` and the transpose is `S X^T`.
#[derive(Debug, Clone)]
pub struct FactoredSystem {
    system: System,
    blocks: Vec<(Block, Cholesky)>,
}

impl FactoredSystem {
    /// Factors the system of these base points; `images` as in
    /// [`constrained_weights`](super::constrained_weights). `m^3 / 3` multiply-adds and `m^2` numbers
    /// for the m directions of each block.
    ///
    /// # Errors
    /// Like [`constrained_weights`](super::constrained_weights).
    pub fn new(
        basis: Basis,
        base: &[Vector],
        constraints: &[Constraint],
        images: &[Transform],
    ) -> Result<Self> {
        assert_eq!(constraints.len(), base.len(), "one constraint a base point");
        let system = System::new(basis, base, images)?;
        let blocks = system.distinct_blocks(constraints, |_| true);
        let blocks = blocks.into_iter().map(|block| {
            let factor = system.factor(&block)?;
            Ok((block, factor))
        });
        Ok(Self {
            blocks: blocks.collect::<Result<_>>()?,
            system,
        })
    }

    /// Returns weights of the base points and their images for which the field at every base point has the components of
    /// `values (n, 3)` along its constraint. `2 m^2` multiply-adds.
    pub fn weights(&self, values: &[Vector]) -> Expanded {
        let own = self.solve(values);
        self.system.expand(own.as_flattened(), 3)
    }

    /// Applies the transpose: `weights` are the derivatives of a function with respect to the weights of the base points and
    /// their images. Returns its derivatives with respect to the values at the base points.
    pub fn transposed(&self, weights: &[Vector]) -> Vec<Vector> {
        let n = self.system.base.len();
        let mut sums = vec![[0.0; 3]; n];
        for (g, weights) in self.system.group.iter().zip(weights.chunks_exact(n.max(1))) {
            let back = g.inverse();
            for (sum, w) in sums.iter_mut().zip(weights) {
                *sum = add(*sum, back.turn(*w));
            }
        }
        self.solve(&sums)
    }

    /// Every base point, then the first image of each, and so on.
    pub fn points(&self) -> Vec<Vector> {
        self.system.expand(&[], 3).points
    }

    fn solve(&self, values: &[Vector]) -> Vec<Vector> {
        let mut own = vec![[0.0; 3]; values.len()];
        for (block, factor) in &self.blocks {
            let (values, own) = (values.as_flattened(), own.as_flattened_mut());
            self.system.solve(block, factor, values, own);
        }
        own
    }
}
