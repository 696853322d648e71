//! Steps of a minimisation that correct the next ones: limited-memory BFGS around Newton's direction.
//!
//! The positive part of the curvature is stiffer than the curvature itself, so that Newton's steps are too short along
//! some directions, always the same ones. With `s` a step and `y` the change of the slope over it,
//!
//! ```text
//! d = -(V_m^T ... V_1^T  H^-1  V_1 ... V_m + ...) g,   V = I - y s^T / (y . s)
//! ```
//!
//! is the direction that the last `m` of them demand. Source: D. C. Liu, J. Nocedal, On the limited memory BFGS method for large
//! scale optimization, Mathematical Programming 45, 1989.

use azimesh_core::geometry::vector::{Vector, dot, scale, sub};
use std::collections::VecDeque;

/// Steps that are remembered.
const MOST: usize = 8;

/// The last steps of a minimisation, the newest at the end.
#[derive(Debug, Default)]
pub(super) struct History {
    pairs: VecDeque<Pair>,
    /// A step that is under way, with the slope where it began.
    begun: Option<(Vec<Vector>, Vec<Vector>)>,
}

#[derive(Debug)]
struct Pair {
    step: Vec<Vector>,
    change: Vec<Vector>,
    /// `y . s`
    product: f64,
}

impl History {
    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// A step of `length` along `step` begins, where the slope is `slope`.
    pub(super) fn leave(&mut self, step: &[Vector], length: f64, slope: &[Vector]) {
        let step = step.iter().map(|step| scale(*step, length)).collect();
        self.begun = Some((step, slope.to_vec()));
    }

    /// The step that has begun ends where the slope is `to`; one along which the functional is not convex is ignored.
    pub(super) fn arrive(&mut self, to: &[Vector]) {
        let Some((step, from)) = self.begun.take() else {
            return;
        };
        let change: Vec<Vector> = std::iter::zip(to, &from)
            .map(|(to, from)| sub(*to, *from))
            .collect();
        let product = product(&step, &change);
        let is_convex = product > 1e-12 * (norm(&step) * norm(&change));
        if is_convex {
            self.pairs.push_back(Pair {
                step,
                change,
                product,
            });
        }
        if self.pairs.len() > MOST {
            self.pairs.pop_front();
        }
    }

    /// Takes out of a right side what the remembered steps account for; gives their parts, for [`Self::put_back`].
    pub(super) fn take_out(&self, right: &mut [Vector]) -> Vec<f64> {
        let mut parts = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let part = product(&pair.step, right) / pair.product;
            add(right, -part, &pair.change);
            parts.push(part);
        }
        parts
    }

    /// Adds to the solution of the rest what [`Self::take_out`] has taken.
    pub(super) fn put_back(&self, parts: &[f64], solution: &mut [Vector]) {
        for (pair, part) in self.pairs.iter().zip(parts.iter().rev()) {
            let own = product(&pair.change, solution) / pair.product;
            add(solution, part - own, &pair.step);
        }
    }
}

fn product(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum()
}

fn norm(a: &[Vector]) -> f64 {
    product(a, a).sqrt()
}

fn add(to: &mut [Vector], factor: f64, by: &[Vector]) {
    for (to, by) in to.iter_mut().zip(by) {
        for axis in 0..3 {
            to[axis] += factor * by[axis];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Minimises `x A x / 2` with `A` diagonal and steps along `H^-1 g`, `H` twenty times too stiff along one axis.
    #[test]
    fn a_direction_that_is_too_short_is_made_longer() {
        let (a, h) = ([1.0, 3.0, 10.0], [20.0, 3.0, 10.0]);
        let steps = |remembers: bool| {
            let mut x = [[1.0, -2.0, 0.5]];
            let mut history = History::default();
            let mut slope = [[0, 1, 2].map(|k| a[k] * x[0][k])];
            for n in 1.. {
                let mut right = slope.map(|g| g.map(|g| -g));
                let parts = history.take_out(&mut right);
                let mut step = [[0, 1, 2].map(|k| right[0][k] / h[k])];
                history.put_back(&parts, &mut step);
                x = [[0, 1, 2].map(|k| x[0][k] + step[0][k])];
                let after = [[0, 1, 2].map(|k| a[k] * x[0][k])];
                if norm(&after) < 1e-10 {
                    return n;
                }
                if remembers {
                    history.leave(&step, 1.0, &slope);
                    history.arrive(&after);
                }
                slope = after;
            }
            unreachable!("it converges")
        };
        assert!(steps(false) > 400);
        assert!(steps(true) < 12, "{}", steps(true));
    }
}
