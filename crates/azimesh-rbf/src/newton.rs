//! The exact greedy on a few thousand candidates, by the Newton basis.
//!
//! The Newton basis function `v_n` is one at the n-th base point's place in the factor and zero at
//! all base points before it; a new base point costs one new value at each candidate. With sliding
//! With sliding points, periodic images or a polynomial this is the greedy of the plain kernel, with residuals kept along the
//! constraints: it selects the points to try, but the errors come from the full system.

use super::criterion::Criterion;
use super::space::Space;
use super::targets::{Chosen, LEAST_POWER, Targets};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::linear::{GrowingCholesky, Matrix};
use azimesh_core::parallel;
use multiversion::multiversion;

/// Candidates that one task keeps up to date.
const CHUNK: usize = 256;

/// The candidates of one round.
pub struct Candidates<'a> {
    space: &'a Space,
    criterion: &'a Criterion,
    chunks: Vec<Chunk>,
    skipped: usize,
}

/// Some candidates, with all that is known of them.
struct Chunk {
    nodes: Vec<usize>,
    points: Vec<Vector>,
    /// Mode residuals (m, r).
    residuals: Vec<f64>,
    /// Newton basis (n, m): one row of m values for each base point.
    newton: Vec<f64>,
    /// Power function, squared.
    power: Vec<f64>,
    /// Displacement that a residual of one makes, by parts (m, parts); 1 when empty.
    lever_arms: Vec<f64>,
    /// Chosen or skipped.
    done: Vec<bool>,
    worst: Worst,
}

/// The worst candidate of a chunk.
#[derive(Debug, Clone, Copy)]
struct Worst {
    error: f64,
    at: usize,
}

/// The new base point as every chunk needs it.
struct NewPoint {
    point: Vector,
    /// Newton basis there (n).
    row: Vec<f64>,
    /// Root of its power function.
    diagonal: f64,
    /// Mode residual there (r).
    residual: Vec<f64>,
}

impl<'a> Candidates<'a> {
    /// Candidates at `nodes`, where the residuals (m, r) are these, with the base points that are chosen already.
    pub fn new(
        space: &'a Space,
        targets: Targets<'a>,
        chosen: &Chosen,
        residuals: &[f64],
        nodes: &[usize],
    ) -> Self {
        let criterion = targets.criterion;
        let r = criterion.n_modes();
        let base: Vec<Vector> = chosen.base.iter().map(|&i| targets.points[i]).collect();
        let chunks = parallel::map_blocks(nodes.len(), CHUNK, &|range| {
            let residuals = residuals[range.start * r..range.end * r].to_vec();
            let nodes = &nodes[range];
            let mut chunk = Chunk::new(space, nodes, &targets, residuals);
            chunk.start(space, &base, &chosen.factor);
            chunk.find_worst(criterion);
            chunk
        });
        Self {
            space,
            criterion,
            chunks,
            skipped: 0,
        }
    }

    /// Adds the worst candidate to the base, again and again, until the worst error is at or below
    /// `stop`, the base has `max_points`, or no candidate is left.
    pub fn pick(&mut self, stop: f64, max_points: usize, chosen: &mut Chosen) {
        while chosen.base.len() < max_points {
            let Some((chunk, worst)) = self.worst().filter(|(_, worst)| worst.error > stop) else {
                return;
            };
            // Written so that a NaN power is skipped too.
            let serves = self.chunks[chunk].power[worst.at] >= LEAST_POWER;
            if !serves {
                self.skipped += 1;
                self.chunks[chunk].done[worst.at] = true;
                self.chunks[chunk].find_worst(self.criterion);
                continue;
            }
            let new =
                self.chunks[chunk].take(worst.at, chosen.factor.n(), self.criterion.n_modes());
            chosen.picked.push(worst.error);
            chosen.base.push(self.chunks[chunk].nodes[worst.at]);
            chosen.factor.push(&new.row, new.diagonal);
            let (space, criterion) = (self.space, self.criterion);
            parallel::for_items(&mut self.chunks, &|_, chunk| {
                chunk.add(space, &new);
                chunk.find_worst(criterion);
            });
        }
    }

    /// Candidates skipped so far.
    pub fn skipped(&self) -> usize {
        self.skipped
    }

    /// The worst candidate of all; ties to the first chunk.
    fn worst(&self) -> Option<(usize, Worst)> {
        let mut found: Option<(usize, Worst)> = None;
        for (i, chunk) in self.chunks.iter().enumerate() {
            if chunk.worst.error > found.map_or(0.0, |(_, worst)| worst.error) {
                found = Some((i, chunk.worst));
            }
        }
        found
    }
}

impl Chunk {
    fn new(space: &Space, nodes: &[usize], targets: &Targets<'_>, residuals: Vec<f64>) -> Self {
        let points: Vec<Vector> = nodes.iter().map(|&i| targets.points[i]).collect();
        Self {
            // One, but for the images.
            power: points.iter().map(|x| space.between(x, x)).collect(),
            points,
            lever_arms: nodes
                .iter()
                .flat_map(|&i| targets.criterion.arms_of(i, targets.lever_arms))
                .copied()
                .collect(),
            done: vec![false; nodes.len()],
            newton: Vec::new(),
            worst: Worst { error: 0.0, at: 0 },
            nodes: nodes.to_vec(),
            residuals,
        }
    }

    /// The Newton basis of the base points chosen so far: `L v = phi`.
    fn start(&mut self, space: &Space, base: &[Vector], factor: &GrowingCholesky) {
        let (n, m) = (base.len(), self.points.len());
        let mut columns = Matrix::from_fn(n, m, |i, j| space.between(&base[i], &self.points[j]));
        factor.solve_lower(&mut columns);
        self.newton.resize(n * m, 0.0);
        for j in 0..m {
            for (i, v) in columns.column(j).iter().enumerate() {
                self.newton[i * m + j] = *v;
                self.power[j] -= v * v;
            }
        }
    }

    fn find_worst(&mut self, criterion: &Criterion) {
        let mut worst = Worst { error: 0.0, at: 0 };
        let residuals = self.residuals.chunks_exact(criterion.n_modes());
        for (at, (residual, done)) in residuals.zip(&self.done).enumerate() {
            let lever_arms = criterion.arms_of(at, &self.lever_arms);
            if !done && criterion.bound(residual, lever_arms) > worst.error {
                let error = criterion.sampled(residual, lever_arms);
                if error > worst.error {
                    worst = Worst { error, at };
                }
            }
        }
        self.worst = worst;
    }

    /// Candidate `at` as the next base point.
    fn take(&mut self, at: usize, n: usize, r: usize) -> NewPoint {
        let m = self.points.len();
        self.done[at] = true;
        NewPoint {
            point: self.points[at],
            row: (0..n).map(|i| self.newton[i * m + at]).collect(),
            diagonal: self.power[at].sqrt(),
            residual: self.residuals[at * r..(at + 1) * r].to_vec(),
        }
    }

    /// Brings every candidate up to date with a new base point:
    /// `v(c) = (phi(c, p) - sum_j v_j(c) v_j(p)) / diagonal`.
    fn add(&mut self, space: &Space, new: &NewPoint) {
        let mut values: Vec<f64> = self
            .points
            .iter()
            .map(|point| space.between(point, &new.point))
            .collect();
        subtract_rows(&mut values, &self.newton, &new.row);
        let r = new.residual.len();
        let residuals = self.residuals.chunks_exact_mut(r);
        let candidates = values.iter_mut().zip(&mut self.power).zip(residuals);
        for (((value, power), residual), node) in candidates.zip(&self.nodes) {
            *value /= new.diagonal;
            *power -= *value * *value;
            let factor = *value / new.diagonal;
            for (e, at_new) in residual.iter_mut().zip(&new.residual) {
                *e -= factor * at_new;
            }
            space.project(*node, residual);
        }
        self.newton.extend_from_slice(&values);
    }
}

/// `values (m) -= rows^T (m, n) . factors (n)`, four rows at a time.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn subtract_rows(values: &mut [f64], rows: &[f64], factors: &[f64]) {
    let m = values.len();
    let four = factors.len() / 4 * 4;
    for (rows, f) in rows.chunks_exact(4 * m).zip(factors.chunks_exact(4)) {
        let (a, rest) = rows.split_at(m);
        let (b, rest) = rest.split_at(m);
        let (c, d) = rest.split_at(m);
        for i in 0..m {
            values[i] -= a[i] * f[0] + b[i] * f[1] + (c[i] * f[2] + d[i] * f[3]);
        }
    }
    for (row, f) in rows[four * m..].chunks_exact(m).zip(&factors[four..]) {
        for i in 0..m {
            values[i] -= row[i] * f;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::Constraint;
    use crate::{Basis, Kernel};
    use std::sync::Arc;

    #[test]
    fn residuals_of_sliding_points_are_along_their_constraints() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let held = Constraint::of_normals(&[[0.6, 0.8, 0.0]]);
        let constraints = vec![Constraint::ALL, held, held];
        let basis = Basis {
            kernel: Kernel::WendlandC2,
            radius: 3.0,
        };
        let space = Space {
            constraints: Some(Arc::new(constraints)),
            ..Space::radial(basis)
        };
        let criterion =
            Criterion::new(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]).expect("it is good");
        let values = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let targets = Targets {
            points: &points,
            values: &values,
            criterion: &criterion,
            images: &[],
            lever_arms: &[],
        };
        let mut chosen = Chosen::default();
        let mut candidates = Candidates::new(&space, targets, &chosen, &values, &[0, 1, 2]);
        candidates.pick(0.0, 1, &mut chosen);
        assert_eq!(chosen.base, [0]);
        for row in candidates.chunks[0].residuals.as_chunks::<3>().0[1..].iter() {
            assert!(row.iter().any(|e| e.abs() > 0.1));
            let free = held.remove(*row);
            assert!(free.iter().all(|e| e.abs() < 1e-15), "{row:?}");
        }
    }
}
