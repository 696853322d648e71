//! The values that base points should reproduce, and the base points of a selection in progress.

use super::criterion::Criterion;
use super::interpolant::Interpolant;
use super::space::Space;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::linear::{GrowingCholesky, Matrix};

/// A candidate whose power function has fallen below this adds nothing but noise.
pub(super) const LEAST_POWER: f64 = 1e-13;

/// Points and values that the base points should reproduce, and the error that is allowed to remain.
///
/// Points are in the order of a space-filling curve ([`order`](azimesh_core::geometry::curve::order)), no two
/// at the same place.
#[derive(Debug, Clone, Copy)]
pub struct Targets<'a> {
    /// Surface nodes, N of them.
    pub points: &'a [Vector],
    /// Values of the modes there (N, r), by rows.
    pub values: &'a [f64],
    /// The error over all steps.
    pub criterion: &'a Criterion,
    /// Points that never become base points, since one of their images does; none when empty.
    pub images: &'a [bool],
    /// Displacement for a residual of one at each point, by parts of the criterion (N, parts); 1 everywhere
    /// when empty.
    pub lever_arms: &'a [f64],
}

impl<'a> Targets<'a> {
    /// These targets with another criterion.
    pub(super) fn seen_by<'b>(self, criterion: &'b Criterion) -> Targets<'b>
    where
        'a: 'b,
    {
        Targets { criterion, ..self }
    }

    /// Values of the modes at some points, by rows.
    pub(super) fn values_at(&self, nodes: &[usize]) -> Vec<f64> {
        let r = self.criterion.n_modes();
        nodes
            .iter()
            .flat_map(|&i| &self.values[i * r..(i + 1) * r])
            .copied()
            .collect()
    }
}

/// A selection under way.
#[derive(Default)]
pub(super) struct Chosen {
    /// Indices into the points of the targets, in the order chosen.
    pub base: Vec<usize>,
    /// Error that each had when it was chosen.
    pub picked: Vec<f64>,
    /// Factor of the kernel matrix of the base points.
    pub factor: GrowingCholesky,
    /// Number of base points and largest error at each sweep.
    pub history: Vec<(usize, f64)>,
    /// Candidates that are too close to base points.
    pub skipped: usize,
}

impl Chosen {
    /// Base points chosen before, with their factor.
    pub fn of_base(space: &Space, points: &[Vector], base: Vec<usize>) -> Self {
        let mut factor = GrowingCholesky::default();
        for (n, &new) in base.iter().enumerate() {
            let new = &points[new];
            let mut row = Matrix::from_fn(n, 1, |i, _| space.between(&points[base[i]], new));
            factor.solve_lower(&mut row);
            let squares: f64 = row.column(0).iter().map(|v| v * v).sum();
            let power = (space.between(new, new) - squares).max(LEAST_POWER);
            factor.push(row.column(0), power.sqrt());
        }
        Self {
            base,
            factor,
            ..Self::default()
        }
    }

    /// The interpolant of the base points chosen so far, by the growing factor where that is possible.
    pub fn interpolant(&self, space: &Space, targets: &Targets<'_>) -> Result<Interpolant> {
        let values = targets.values_at(&self.base);
        if !space.is_plain() {
            return space.interpolant(targets.points, &self.base, &values);
        }
        let r = targets.criterion.n_modes();
        let mut solution = Matrix::from_fn(self.base.len(), r, |i, j| values[i * r + j]);
        self.factor.solve_lower(&mut solution);
        self.factor.solve_transposed(&mut solution);
        Ok(Interpolant {
            basis: space.basis,
            points: self.base.iter().map(|&i| targets.points[i]).collect(),
            weights: (0..values.len())
                .map(|at| solution[(at / r, at % r)])
                .collect(),
            n_columns: r,
            polynomial: None,
        })
    }

    /// Returns the interpolant as any later run from the same base points computes it.
    pub fn final_interpolant(&self, space: &Space, targets: &Targets<'_>) -> Result<Interpolant> {
        space.interpolant(targets.points, &self.base, &targets.values_at(&self.base))
    }
}
