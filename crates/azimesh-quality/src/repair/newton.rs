//! Minimises the functional of a patch by Newton steps, and lowers eps until every simplex is positive.
//!
//! Each step solves with the positive part of the curvature by preconditioned conjugate gradients, with what earlier steps
//! have shown of the curvature ([`History`]), and is halved until the functional falls. eps follows the rule of the paper that `density` names: with it finitely many steps
//! untangle a patch if each of them lowers the functional by a tenth.

use super::density::chi;
use super::derivatives::Sum;
use super::history::History;
use super::patch::{Patch, State};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, add, distance, dot, sub};
use azimesh_core::linear::blocks::{Incomplete, solve};
use azimesh_core::progress::Stop;

/// eps once all simplices are positive.
const LEAST_EPS: f64 = 1e-9;
/// Residual of the linear systems, relative to their right sides.
const TOLERANCE: f64 = 0.03;
/// Iterations of a linear system at most.
const MOST_ITERATIONS: usize = 150;
/// Part of the slope by which the functional must fall.
const ARMIJO: f64 = 1e-4;
/// Steps shorter than this are none.
const SHORTEST: f64 = 1e-6;
/// A patch without folded simplices is finished when a step lowers the functional by less than this part.
const SETTLED: f64 = 0.002;
/// The least determinant that is sought, and steps that are spent on it once the functional has settled.
const ENOUGH: f64 = 0.02;
const POLISH: usize = 4;
/// The least determinant for curved cells, which are less between their samples.
const ENOUGH_OF_CURVED: f64 = 0.2;
/// Steps without progress after which a folded patch is given up.
const PATIENCE: usize = 6;

/// The same for the start that follows from the rim.
const TOLERANCE_OF_START: f64 = 1e-4;
const MOST_ITERATIONS_OF_START: usize = 400;

/// Course of the minimisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SolveStats {
    /// Newton steps.
    pub steps: usize,
    /// Iterations of the linear systems, all steps together.
    pub iterations: usize,
    /// The functional at the end.
    pub state: State,
}

/// Moves the nodes of a patch for at most so many steps, until one lowers the functional by less than the part `settled`. Only
/// with that do steps remember earlier ones: gains are less even then, and a patch that may stop early would.
pub(super) fn minimise(
    patch: &mut Patch,
    most: usize,
    settled: Option<f64>,
    stop: &Stop,
) -> Result<SolveStats> {
    let n = patch.n_unknowns();
    let (mut slope, mut step) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
    let mut trial = patch.places.clone();
    let mut state = patch.state(LEAST_EPS, &patch.places);
    let mut course = SolveStats {
        steps: 0,
        iterations: 0,
        state,
    };
    let mut eps = if state.least > 0.0 {
        LEAST_EPS
    } else {
        (1e-6 + 0.04 * state.least * state.least).sqrt()
    };
    let mut progress = Progress {
        settled: settled.unwrap_or(SETTLED),
        enough: if patch.elements.are_curved() {
            ENOUGH_OF_CURVED
        } else {
            ENOUGH
        },
        best: state,
        waiting: 0,
        polished: 0,
    };
    let mut history = History::default();
    while course.steps < most {
        stop.check()?;
        let before = patch.derive(Sum::Shapes { eps }, &mut slope);
        history.arrive(&slope);
        let limits = (TOLERANCE, MOST_ITERATIONS);
        let Some(iterations) = direction(patch, &slope, &history, &mut step, limits) else {
            break;
        };
        course.iterations += iterations;
        course.steps += 1;
        let Some(descent) = descend(patch, eps, before, &slope, &step, &mut trial) else {
            if !history.is_empty() {
                history.clear();
            } else if progress.gives_up(&before) {
                break;
            } else {
                // Nothing can be won at this eps.
                eps = 0.5 * eps.max(LEAST_EPS);
            }
            continue;
        };
        state = descent.after;
        let won = 1.0 - state.value / before.value;
        if progress.is_over(&state, won) {
            break;
        }
        let next = lowered(eps, state.least, won);
        if next == eps && settled.is_some() {
            history.leave(&step, descent.length, &slope)
        } else {
            history.clear()
        }
        eps = next;
    }
    course.state = state;
    Ok(course)
}

/// Decides whether a minimisation continues.
struct Progress {
    settled: f64,
    enough: f64,
    best: State,
    /// Steps without progress.
    waiting: usize,
    /// Steps without folds that have won next to nothing.
    polished: usize,
}

impl Progress {
    /// Returns whether a step that has lowered the functional by the part `won` is the last.
    fn is_over(&mut self, after: &State, won: f64) -> bool {
        self.polished += usize::from(after.least > 0.0 && won < self.settled);
        if (after.least > self.enough && self.polished > 0) || self.polished > POLISH {
            return true;
        }
        if is_progress(after, &self.best) {
            self.best = *after;
            self.waiting = 0;
        } else if after.least <= 0.0 && won < 0.05 {
            self.waiting += 1;
            return self.waiting >= PATIENCE;
        }
        false
    }

    /// Returns whether a step that has won nothing is the last.
    fn gives_up(&mut self, before: &State) -> bool {
        let is_last = before.least > 0.0 || self.waiting > PATIENCE;
        self.waiting += 2;
        is_last
    }
}

/// Moves the nodes of a patch to the positions determined by its fixed nodes only: the displacements from `reference`, by
/// nodes of the patch, minimise the sum of `|grad u|^2` over the simplices, in units of their targets. They are zero if no
/// fixed node has been displaced. Earlier displacements do not count.
pub(super) fn relax(patch: &mut Patch, reference: &[Vector]) {
    let is_displaced = (0..reference.len())
        .any(|at| !patch.moves(at) && distance(patch.places[at], reference[at]) > 0.0);
    let origin = |at: usize| {
        if is_displaced {
            reference[at]
        } else {
            [0.0; 3]
        }
    };
    let before = patch.places.clone();
    for (at, place) in before.iter().enumerate() {
        patch.places[at] = if patch.is_free(at) {
            [0.0; 3]
        } else {
            sub(*place, origin(at))
        };
    }
    let n = patch.n_unknowns();
    let (mut slope, mut step) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
    patch.derive(Sum::Squares, &mut slope);
    let limits = (TOLERANCE_OF_START, MOST_ITERATIONS_OF_START);
    if direction(patch, &slope, &History::default(), &mut step, limits).is_none() {
        patch.places = before;
        return;
    }
    let mut moved = before.clone();
    patch.moved(&step, 1.0, &mut moved);
    for (at, by) in moved.into_iter().enumerate() {
        let height = before[at][2];
        patch.places[at] = add(origin(at), by);
        if patch.is_plane() {
            patch.places[at][2] = height;
        }
    }
}

/// Returns whether a state is nearer to one without folds than the best so far.
fn is_progress(after: &State, best: &State) -> bool {
    after.n_folded < best.n_folded
        || (after.least > 0.0 && best.least <= 0.0)
        || (after.least <= 0.0 && after.least > 0.9 * best.least)
}

/// The next eps, after a step that has lowered the functional by the part `won` and left `least` as the least
/// determinant.
fn lowered(eps: f64, least: f64, won: f64) -> f64 {
    let rate = (1.0 - won.max(0.1)) * chi(eps, least);
    if least < rate {
        (2.0 * (rate * (rate - least)).sqrt()).max(LEAST_EPS)
    } else {
        LEAST_EPS
    }
}

/// Newton's direction; `None` where the curvature has no factors.
fn direction(
    patch: &Patch,
    slope: &[Vector],
    history: &History,
    step: &mut [Vector],
    (tolerance, most): (f64, usize),
) -> Option<usize> {
    let factors = Incomplete::new(patch.matrix())?;
    let mut right: Vec<Vector> = slope.iter().map(|s| s.map(|x| -x)).collect();
    let parts = history.take_out(&mut right);
    let solved = solve(patch.matrix(), &factors, &right, step, tolerance, most);
    history.put_back(&parts, step);
    patch.clean(step);
    Some(solved.iterations)
}

/// A step that has lowered the functional.
struct Descent {
    after: State,
    /// The part of the step that was taken.
    length: f64,
}

/// Moves the nodes along `step`, as far as the functional falls; `None` where it does not.
fn descend(
    patch: &mut Patch,
    eps: f64,
    before: State,
    slope: &[Vector],
    step: &[Vector],
    trial: &mut Vec<Vector>,
) -> Option<Descent> {
    let along: f64 = slope.iter().zip(step).map(|(a, b)| dot(*a, *b)).sum();
    if along.is_nan() || along >= 0.0 {
        return None;
    }
    let mut length = 1.0;
    while length > SHORTEST {
        patch.moved(step, length, trial);
        let after = patch.state(eps, trial);
        if after.value < before.value + ARMIJO * length * along {
            std::mem::swap(&mut patch.places, trial);
            return Some(Descent { after, length });
        }
        length *= 0.5;
    }
    None
}
