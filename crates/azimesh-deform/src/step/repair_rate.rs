//! Rate of change of the repair of a step: its contribution to the velocities of the nodes.
//!
//! ```text
//! x = p + r,   v = p' + r'
//! ```
//!
//! `p` are the positions by the motion, whose velocities are exact; `r` is the displacement by the repair. Its derivative
//! is the derivative of the parabola through the step and its neighbours. Outside windows `r` is zero.

use super::positions::{Positions, Stepper};
use crate::motion::Step;
use azimesh_core::error::Result;
use azimesh_core::geometry::Transform;
use azimesh_core::geometry::vector::{Vector, add, sub};
use azimesh_core::parallel;

impl Stepper<'_> {
    /// Completes the velocities `found` of the nodes, at `points` at a step, if the schedule asks for velocities.
    ///
    /// # Errors
    /// Like positions of the step and its neighbours.
    pub fn velocities(
        &self,
        step: &Step,
        found: &Positions,
        points: &[Vector],
    ) -> Result<Option<Vec<Vector>>> {
        let velocities = self.interval.velocities_at(step, points);
        let Some(mut out) = velocities else {
            return Ok(None);
        };
        if found.repair.is_none() {
            return Ok(Some(out));
        }
        let to_inertial = self.plan.motion.to_inertial(step);
        for (neighbour, factor) in self.factors(step) {
            if factor == 0.0 {
                continue;
            }
            let Some(added) = self.added(&self.plan.motion.steps[neighbour])? else {
                continue;
            };
            parallel::update(&mut out, |node, v| {
                let mut rate = added[node];
                let number = self.part.mesh.number_of_node(node as u32);
                if let Some(turn) = to_inertial.as_ref().and_then(|to| to.of_node(number)) {
                    rate = turn.turn(rate);
                }
                *v = add(*v, rate.map(|x| factor * x));
            });
        }
        Ok(Some(out))
    }

    /// Returns the derivative at a step as a sum over steps: the factor of each.
    fn factors(&self, step: &Step) -> Vec<(usize, f64)> {
        let time = |index: usize| self.plan.motion.steps[index].time_s.unwrap_or(0.0);
        let (at, steps) = (step.index, self.interval.steps());
        let before = (at > steps.start).then(|| (at - 1, time(at - 1) - time(at)));
        let after = (at + 1 < steps.end).then(|| (at + 1, time(at + 1) - time(at)));
        derivative(at, [before, after])
    }

    /// Returns the displacement by the repair of a step, in the rotating frame; `None` if it is not repaired.
    pub fn added(&self, step: &Step) -> Result<Option<Vec<Vector>>> {
        if step.index < self.segment.steps.start {
            return Ok(self.segment.seam().map(<[Vector]>::to_vec));
        }
        let mut points = vec![[0.0; 3]; self.part.mesh.points.len()];
        let found = self.at(step, &mut points)?;
        if found.repair.is_none() {
            return Ok(None);
        }
        let mut plain = vec![[0.0; 3]; points.len()];
        self.interval.points_at(step, &mut plain)?;
        self.rounding.apply(&mut plain);
        let back = self.plan.motion.to_inertial(step);
        let back = back.as_ref().map(|to| to.map(Transform::inverse));
        parallel::update(&mut points, |node, x| {
            let added = sub(*x, plain[node]);
            let number = self.part.mesh.number_of_node(node as u32);
            let back = back.as_ref().and_then(|back| back.of_node(number));
            *x = back.map_or(added, |back| back.turn(added));
        });
        Ok(Some(points))
    }
}

/// Returns the factors of the derivative of the parabola through a step and its neighbours, with their times relative
/// to the step. If a neighbour is missing or at the same time as another step, a line replaces the parabola.
fn derivative(at: usize, neighbours: [Option<(usize, f64)>; 2]) -> Vec<(usize, f64)> {
    let [before, after] = neighbours.map(|neighbour| neighbour.filter(|(_, time)| *time != 0.0));
    match (before, after) {
        (Some((i, a)), Some((j, b))) if a != b => {
            vec![
                (i, b / (a * (b - a))),
                (at, -(a + b) / (a * b)),
                (j, -a / (b * (b - a))),
            ]
        }
        (Some((i, a)), _) | (None, Some((i, a))) => vec![(i, 1.0 / a), (at, -1.0 / a)],
        (None, None) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::derivative;

    #[test]
    fn a_parabola_has_its_own_derivative_and_a_line_without_a_neighbour() {
        let f = |t: f64| 3.0 + 2.0 * t - 5.0 * t * t;
        let times = [0.2, 0.5, 0.9];
        let sum = |factors: Vec<(usize, f64)>| -> f64 {
            factors
                .iter()
                .map(|(i, factor)| factor * f(times[*i]))
                .sum()
        };
        let (before, after) = (Some((0, 0.2 - 0.5)), Some((2, 0.9 - 0.5)));
        assert!((sum(derivative(1, [before, after])) - (2.0 - 10.0 * 0.5)).abs() < 1e-12);
        let line = |i: usize| (f(times[i]) - f(0.5)) / (times[i] - 0.5);
        assert!((sum(derivative(1, [before, None])) - line(0)).abs() < 1e-12);
        assert!((sum(derivative(1, [None, after])) - line(2)).abs() < 1e-12);
        assert!((sum(derivative(1, [Some((0, 0.0)), after])) - line(2)).abs() < 1e-12);
        assert!(derivative(1, [None, Some((2, 0.0))]).is_empty());
    }
}
