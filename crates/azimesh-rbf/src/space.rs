//! The space of an interpolant: kernel, polynomial, constraints and images, and the system for its weights.

use super::constrained::constrained_weights;
use super::constraint::Constraint;
use super::interpolant::Interpolant;
use super::{Basis, system};
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::Vector;
use std::sync::Arc;

/// Kernel, polynomial, constraints and images: the functions that make up an interpolant.
#[derive(Debug, Clone)]
pub struct Space {
    /// Kernel and support radius.
    pub basis: Basis,
    /// True if a linear polynomial is added to the kernels.
    pub linear: bool,
    /// Directions in which each surface point is held, if some points slide. Values then belong to vector
    /// modes: column `3 m + a` is component `a` of mode `m`.
    pub constraints: Option<Arc<Vec<Constraint>>>,
    /// Periodic images of the base points, without the identity.
    pub images: Arc<Vec<Transform>>,
}

impl Space {
    /// Creates a space of radial functions only.
    pub fn radial(basis: Basis) -> Self {
        Self {
            basis,
            linear: false,
            constraints: None,
            images: Arc::default(),
        }
    }

    /// Makes the space of scalar fields with this kernel and polynomial, without constraints and images.
    pub fn scalar(&self) -> Self {
        Self {
            linear: self.linear,
            ..Self::radial(self.basis)
        }
    }

    /// Checks if the weights follow from the kernel matrix only.
    pub fn is_plain(&self) -> bool {
        !self.linear && self.constraints.is_none() && self.images.is_empty()
    }

    /// Evaluates the kernel between a surface point and another with its images.
    #[inline]
    pub fn between(&self, a: &Vector, b: &Vector) -> f64 {
        let images = self.images.iter();
        let images = images.map(|image| self.basis.between(a, &image.apply(*b)));
        self.basis.between(a, b) + images.sum::<f64>()
    }

    /// Returns the part of a residual that counts at a surface point: the part along its constraint.
    #[inline]
    pub fn project(&self, point: usize, residual: &mut [f64]) {
        let Some(constraints) = &self.constraints else {
            return;
        };
        let constraint = &constraints[point];
        if constraint.rank() < 3 {
            for mode in residual.as_chunks_mut::<3>().0 {
                *mode = constraint.project(*mode);
            }
        }
    }

    /// Solves for the interpolant that reproduces `values (n, r)`, by rows, at the base points. `base` has their
    /// indices among the surface `points`.
    pub fn interpolant(
        &self,
        points: &[Vector],
        base: &[usize],
        values: &[f64],
    ) -> Result<Interpolant> {
        let places: Vec<Vector> = base.iter().map(|&i| points[i]).collect();
        if base.is_empty() || self.constraints.is_none() && self.images.is_empty() {
            return system::interpolant(self.basis, &places, values, self.linear);
        }
        let constraint = |&i: &usize| {
            let constraints = self.constraints.as_ref();
            constraints.map_or(Constraint::ALL, |constraints| constraints[i])
        };
        let constraints: Vec<Constraint> = base.iter().map(constraint).collect();
        let expanded =
            constrained_weights(self.basis, &places, &constraints, &self.images, values)?;
        Ok(Interpolant {
            basis: self.basis,
            points: expanded.points,
            weights: expanded.weights,
            n_columns: values.len() / base.len(),
            polynomial: None,
        })
    }
}
