//! Chooses base points greedily, in rounds. Knows surface nodes and modes; nothing of rotors or
//! files.
//!
//! A sweep finds the residual at every node; the worst node of each run along a space-filling curve
//! is a candidate; the exact greedy picks among the candidates until their worst error has fallen
//! to a part of the round's first. The last sweep has verified the tolerance on every node.
//!
//! Source: Sheng and Allen, AIAA Journal 51(3), 2013 (one point a sweep); the rounds, the Newton
//! basis (Mueller and Schaback, J. Approx. Theory 161, 2009) and the criterion over all steps go
//! beyond it.

use super::Basis;
use super::criterion::Criterion;
use super::interpolant::Interpolant;
use super::newton::Candidates;
use super::space::Space;
use super::sweeps::{LocalSweeps, Over, Sweeps};
use super::system::check_data;
use super::targets::{Chosen, Targets};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::curve;
use azimesh_core::geometry::vector::Vector;
use azimesh_core::numbers::short;

/// The error that has to be at or below the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// The largest at any node and step.
    Max,
    /// The mean over the nodes, at the step where that is largest.
    Mean,
}

/// Conditions that end a selection, and the size of its rounds.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Displacement error allowed, in mesh units.
    pub tolerance: f64,
    /// The error that is compared with it.
    pub measure: Measure,
    /// Most base points.
    pub max_points: usize,
    /// Candidates of a round; 1 is the plain greedy, a sweep for every point.
    pub candidates: usize,
    /// A round ends when the candidates' worst error is this part of its first.
    pub fall: f64,
}

impl Limits {
    /// Sets a candidate for every 16 of `n_nodes`, 512 to 2048 of them; rounds that end at 0.4 of their
    /// first error.
    pub fn in_rounds(tolerance: f64, max_points: usize, n_nodes: usize) -> Self {
        Self {
            tolerance,
            measure: Measure::Max,
            max_points,
            candidates: (n_nodes / 16).clamp(512, 2048),
            fall: 0.4,
        }
    }
}

/// Chosen base points, their interpolant, and its residuals at every node.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Indices into the targets' points, in the order chosen.
    pub base: Vec<usize>,
    /// The interpolant of the modes.
    pub interpolant: Interpolant,
    /// Residual of the modes at every node (N, r), by rows.
    pub residuals: Vec<f64>,
    /// Largest error at any node and step, in mesh units.
    pub error: f64,
    /// The error of the selection's measure, in mesh units.
    pub measured: f64,
    /// Number of base points and largest error at each sweep over all nodes.
    pub history: Vec<(usize, f64)>,
    /// Error that each base point had when it was chosen: the largest among the candidates.
    pub picked: Vec<f64>,
    /// Candidates skipped because they are too close to base points.
    pub skipped: usize,
}

impl Selection {
    /// Chooses base points among `points (n)` until the interpolant is within `tolerance` of
    /// `values (n, n_columns)`, by rows, in every column at every point. No mesh, no motion: [`select`] with
    /// [`Criterion::of_columns`], along a space-filling curve. `base` and `residuals` are in the order of `points`.
    ///
    /// ```
    /// use azimesh_rbf::{Basis, Kernel, Selection};
    ///
    /// let points: Vec<[f64; 3]> = (0..10_000).map(|i| [f64::from(i % 100), f64::from(i / 100), 0.0]).collect();
    /// let values: Vec<f64> = points.iter().map(|[x, y, _]| (0.05 * x).sin() + 0.1 * (0.03 * y).cos()).collect();
    /// let basis = Basis { kernel: Kernel::WendlandC2, radius: 200.0 };
    /// let selection = Selection::to_tolerance(basis, &points, &values, 1, 1e-3)?;
    /// assert!(selection.error <= 1e-3 && selection.base.len() < 300);
    /// # Ok::<(), azimesh_rbf::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Interpolant::through`]; of kind `Check` if the tolerance cannot be met, as with different values
    /// at one place.
    pub fn to_tolerance(
        basis: Basis,
        points: &[Vector],
        values: &[f64],
        n_columns: usize,
        tolerance: f64,
    ) -> Result<Self> {
        check_data(basis, points, values, n_columns)?;
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(Error::input(format!(
                "the tolerance is {tolerance}; it should be positive"
            )));
        }
        let order = curve::order(points);
        let row = |i: u32| &values[i as usize * n_columns..][..n_columns];
        let ordered: Vec<Vector> = order.iter().map(|&i| points[i as usize]).collect();
        let rows: Vec<f64> = order.iter().flat_map(|&i| row(i)).copied().collect();
        let targets = Targets {
            points: &ordered,
            values: &rows,
            criterion: &Criterion::of_columns(n_columns)?,
            images: &[],
            lever_arms: &[],
        };
        let limits = Limits::in_rounds(tolerance, points.len(), points.len());
        let space = Space::radial(basis);
        let mut selection = select(&space, targets, limits, &mut |_, _| {})?;
        if selection.error > tolerance {
            return Err(Error::check(format!(
                "{} base points leave an error of {}, above the tolerance of {}; a larger tolerance or \
                 one value for each place would help",
                selection.base.len(),
                short(selection.error),
                short(tolerance)
            )));
        }
        let mut residuals = vec![0.0; rows.len()];
        for (at, &i) in order.iter().enumerate() {
            let residual = &selection.residuals[at * n_columns..][..n_columns];
            residuals[i as usize * n_columns..][..n_columns].copy_from_slice(residual);
        }
        selection.residuals = residuals;
        selection.base = selection
            .base
            .iter()
            .map(|&at| order[at] as usize)
            .collect();
        Ok(selection)
    }
}

/// Chooses base points until the error is at or below the tolerance, `max_points` is reached or
/// nothing is left to add; `Selection::measured` is the error reached.
///
/// Rounds x N n kernel evaluations, candidates x n^2 multiply-adds. `progress` is called after every
/// sweep with (base points, error).
pub fn select(
    space: &Space,
    targets: Targets<'_>,
    limits: Limits,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<Selection> {
    let mut sweeps = LocalSweeps::new(space, targets, limits.candidates);
    select_by(&mut sweeps, space, targets, limits, progress)
}

/// Chooses as [`select`], with sweeps that are made elsewhere.
pub fn select_by(
    sweeps: &mut dyn Sweeps,
    space: &Space,
    targets: Targets<'_>,
    limits: Limits,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<Selection> {
    let chosen = Chosen::default();
    grow(sweeps, space, targets, limits, chosen, progress)
}

/// Chooses further base points, after those in `base`, as [`select`] does.
///
/// The cost of [`select`], and for the `n` given ones `n^3 / 3` multiply-adds.
pub fn extend(
    space: &Space,
    targets: Targets<'_>,
    base: Vec<usize>,
    limits: Limits,
) -> Result<Selection> {
    let chosen = Chosen::of_base(space, targets.points, base);
    let mut sweeps = LocalSweeps::new(space, targets, limits.candidates);
    grow(&mut sweeps, space, targets, limits, chosen, &mut |_, _| {})
}

fn grow(
    sweeps: &mut dyn Sweeps,
    space: &Space,
    targets: Targets<'_>,
    limits: Limits,
    mut chosen: Chosen,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<Selection> {
    if targets.criterion.n_modes() == 0 {
        return chosen.finish(sweeps, space, targets, limits.measure);
    }
    // The sample of steps grows where it misses the worst one.
    let mut criterion = targets.criterion.clone();
    let mut nearly_done = false;
    loop {
        let seen = targets.seen_by(&criterion);
        // The last sweep has the final weights, so that it need not be repeated.
        let is_final = nearly_done;
        let interpolant = if is_final {
            chosen.final_interpolant(space, &seen)?
        } else {
            chosen.interpolant(space, &seen)?
        };
        sweeps.sweep(&interpolant);
        let (largest, measured) = errors(sweeps, &seen, &limits);
        chosen.history.push((chosen.base.len(), largest));
        progress(chosen.base.len(), measured);
        let before = chosen.base.len();
        if measured > limits.tolerance && before < limits.max_points {
            // What is left of the largest error when the measured one is just met.
            let enough = 0.95 * limits.tolerance * largest / measured;
            let stop = (largest * limits.fall).max(enough);
            nearly_done = largest * limits.fall <= enough;
            while !pick(
                sweeps,
                space,
                targets.seen_by(&criterion),
                (limits, stop),
                &mut chosen,
            ) {
                let by_step = criterion.largest_by_step(sweeps.residuals(), targets.lever_arms);
                if !criterion.sample_more(&by_step, stop) {
                    break;
                }
            }
        }
        if chosen.base.len() == before {
            return if is_final {
                Ok(chosen.end(sweeps, targets, limits.measure, interpolant))
            } else {
                chosen.finish(sweeps, space, targets, limits.measure)
            };
        }
    }
}

/// Makes a round: the worst nodes are candidates, and the exact greedy picks among them down to `stop`.
/// True if one was above that.
fn pick(
    sweeps: &mut dyn Sweeps,
    space: &Space,
    targets: Targets<'_>,
    (limits, stop): (Limits, f64),
    chosen: &mut Chosen,
) -> bool {
    let before = chosen.base.len();
    let (nodes, residuals) = sweeps.worst(targets.criterion);
    let mut round = Candidates::new(space, targets, chosen, &residuals, &nodes);
    round.pick(stop, limits.max_points, chosen);
    chosen.skipped += round.skipped();
    chosen.base.len() > before || round.skipped() > 0
}

/// Solves for given base points: their weights, residuals and error.
pub fn from_base(
    space: &Space,
    targets: Targets<'_>,
    base: Vec<usize>,
    measure: Measure,
) -> Result<Selection> {
    let chosen = Chosen {
        base,
        ..Chosen::default()
    };
    let mut sweeps = LocalSweeps::new(space, targets, targets.points.len());
    chosen.finish(&mut sweeps, space, targets, measure)
}

impl Chosen {
    /// The selection with its final weights.
    fn finish(
        self,
        sweeps: &mut dyn Sweeps,
        space: &Space,
        targets: Targets<'_>,
        measure: Measure,
    ) -> Result<Selection> {
        let interpolant = self.final_interpolant(space, &targets)?;
        sweeps.sweep(&interpolant);
        Ok(self.end(sweeps, targets, measure, interpolant))
    }

    fn end(
        self,
        sweeps: &mut dyn Sweeps,
        targets: Targets<'_>,
        measure: Measure,
        interpolant: Interpolant,
    ) -> Selection {
        let error = largest_error(sweeps, targets.criterion, 0.0);
        let residuals = sweeps.take_residuals();
        let measured = match measure {
            Measure::Max => error,
            Measure::Mean => targets
                .criterion
                .largest_mean(&residuals, targets.lever_arms),
        };
        Selection {
            base: self.base,
            interpolant,
            residuals,
            error,
            measured,
            history: self.history,
            picked: self.picked,
            skipped: self.skipped,
        }
    }
}

/// The largest error and the one that is measured.
fn errors(sweeps: &mut dyn Sweeps, targets: &Targets<'_>, limits: &Limits) -> (f64, f64) {
    let criterion = targets.criterion;
    match limits.measure {
        Measure::Max => {
            let largest = largest_error(sweeps, criterion, limits.tolerance);
            (largest, largest)
        }
        Measure::Mean => (
            largest_error(sweeps, criterion, 0.0),
            criterion.largest_mean(sweeps.residuals(), targets.lever_arms),
        ),
    }
}

/// The largest error over all nodes and steps. Above `tolerance` an estimate over a sample of the
/// steps serves; at or below it the value is exact.
fn largest_error(sweeps: &mut dyn Sweeps, criterion: &Criterion, tolerance: f64) -> f64 {
    let estimate = sweeps.largest(criterion, Over::Sample, 0.0);
    if estimate > tolerance && tolerance > 0.0 {
        return estimate;
    }
    sweeps.largest(criterion, Over::Steps, estimate)
}

#[cfg(test)]
mod tests {
    use super::super::Kernel;
    use super::*;

    const BASIS: Basis = Basis {
        kernel: Kernel::WendlandC2,
        radius: 2.0,
    };

    #[test]
    fn base_points_among_scattered_points_meet_the_tolerance_in_every_column() {
        let cloud = |i: usize| [12.9898, 78.233, 37.719].map(|f| (i as f64 * f).sin());
        let points: Vec<Vector> = (0..3000).map(cloud).collect();
        let value = |x: &Vector| [(2.0 * x[0]).sin() + x[1], 0.3 * x[2] * x[0]];
        let values: Vec<f64> = points.iter().flat_map(value).collect();
        let found = Selection::to_tolerance(BASIS, &points, &values, 2, 0.01).expect("it is met");
        assert!(found.error <= 0.01 && found.base.len() < 500, "{found:?}");
        let chosen: Vec<Vector> = found.base.iter().map(|&i| points[i]).collect();
        assert_eq!(chosen, found.interpolant.points);
        let mut largest = 0.0_f64;
        let back = found.interpolant.at(&points);
        for (at, (value, back)) in values.iter().zip(&back).enumerate() {
            let residual = value - back;
            assert!((residual - found.residuals[at]).abs() < 1e-12);
            largest = largest.max(residual.abs());
        }
        assert!((largest - found.error).abs() < 1e-12);
    }

    #[test]
    fn different_values_at_one_place_are_an_error() {
        let points = [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]];
        let error = Selection::to_tolerance(BASIS, &points, &[0.0, 1.0, 0.0], 1, 0.1)
            .expect_err("no function has both");
        assert!(
            error.message.contains("above the tolerance of 0.1"),
            "{error}"
        );
        let equal = Selection::to_tolerance(BASIS, &points, &[1.0, 1.0, 0.0], 1, 0.1);
        assert_eq!(equal.expect("one place, one value").base.len(), 2);
        for tolerance in [0.0, -1.0, f64::NAN] {
            let error = Selection::to_tolerance(BASIS, &points, &[0.0; 3], 1, tolerance);
            assert!(
                error
                    .expect_err("it is refused")
                    .message
                    .contains("positive")
            );
        }
        let none = Selection::to_tolerance(BASIS, &[], &[], 1, 0.1).expect("nothing to meet");
        assert!(none.base.is_empty());
    }

    #[test]
    fn the_error_of_base_points_is_that_of_the_worst_step_though_a_search_takes_samples() {
        let cloud = |i: usize| [12.9898, 78.233, 37.719].map(|f| (i as f64 * f).sin());
        let points: Vec<Vector> = (0..60).map(cloud).collect();
        let points: Vec<Vector> = curve::order(&points)
            .iter()
            .map(|&i| points[i as usize])
            .collect();
        // Of 40 steps every other is in the sample; step 7 is the worst.
        let value =
            |x: &Vector, step: usize| (x[0] + x[1] * x[2]) * if step == 7 { 3.0 } else { 1.0 };
        let row = |x| (0..40).map(move |step| value(x, step));
        let values: Vec<f64> = points.iter().flat_map(row).collect();
        let targets = Targets {
            points: &points,
            values: &values,
            criterion: &Criterion::of_columns(40).expect("plain numbers"),
            images: &[],
            lever_arms: &[],
        };
        let found = from_base(&Space::radial(BASIS), targets, vec![0, 30], Measure::Max);
        let found = found.expect("two base points");
        let largest = found
            .residuals
            .iter()
            .fold(0.0, |most: f64, of| most.max(of.abs()));
        assert!(largest > 0.1 && (found.error - largest).abs() < 1e-12 * largest);
    }
}
