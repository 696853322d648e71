//! What the interpolant is made of: one place that knows which system gives its weights.

use super::interpolant::Interpolant;
use super::{Basis, system};
use crate::error::Result;
use crate::geometry::vector::Vector;

/// The functions that an interpolant is sought among.
#[derive(Debug, Clone)]
pub struct Space {
    /// Kernel and support radius.
    pub basis: Basis,
    /// Whether a linear polynomial stands beside the kernels.
    pub linear: bool,
}

impl Space {
    /// Radial functions alone.
    pub fn radial(basis: Basis) -> Self {
        Self {
            basis,
            linear: false,
        }
    }

    /// The same space for one value at a node instead of displacements.
    pub fn scalar(&self) -> Self {
        self.clone()
    }

    /// Whether the weights follow from the kernel matrix alone.
    pub fn is_plain(&self) -> bool {
        !self.linear
    }

    /// The kernel between two surface points.
    #[inline]
    pub fn between(&self, a: &Vector, b: &Vector) -> f64 {
        self.basis.between(a, b)
    }

    /// The interpolant that reproduces `values (n, r)`, by rows, at the base points, given by their
    /// positions among the surface `points`.
    pub fn interpolant(
        &self,
        points: &[Vector],
        base: &[usize],
        values: &[f64],
    ) -> Result<Interpolant> {
        let base: Vec<Vector> = base.iter().map(|&i| points[i]).collect();
        system::interpolant(self.basis, &base, values, self.linear)
    }
}
