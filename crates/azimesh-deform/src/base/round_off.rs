//! Round-off of the interpolation at volume nodes, compared with the height of the first cells.
//!
//! The interpolant is a sum of weights times kernels near one, and large weights of both signs cancel in it. The
//! round-off of the sum at the worst node is about
//!
//! ```text
//! noise = 4 epsilon max_k sqrt(sum_j |w_j C_k|^2)
//! ```
//!
//! (between 2 and 6 epsilon on airfoils and blades with wendland-c2, c4 and c6), with `w_j (r)` the weights of base point
//! `j` and `C_k (r, 3)` the coefficients of step `k`. Weights grow with the support radius and the smoothness of the kernel.
//! Surface nodes are set exactly, but their neighbours are not, so the noise changes the height of first cells.

use crate::plan::Plan;
use crate::plan::layer::Layer;
use azimesh_core::error::{Error, Result};
use azimesh_core::numbers::{in_digits, short};
use azimesh_core::{Note, note};
use azimesh_rbf::Basis;
use azimesh_rbf::interpolant::Interpolant;
use azimesh_rbf::select::Selection;
use azimesh_rbf::space::Space;

const PER_WEIGHT: f64 = 4.0;
/// Parts of the smallest first cell: round-off above the first gives a warning, above the second an error.
const TOLD: f64 = 0.01;
const REFUSED: f64 = 0.1;
/// Number of support radii tried for the advice: each is half of the previous one.
const TRIES: usize = 12;

/// Returns a warning if round-off may change first cells by more than 1%, and an error of kind `Check` above 10%. Both
/// name a support radius that was tried and works, if there is one.
///
/// # Errors
/// As above.
pub fn check(plan: &Plan, selections: &[Selection]) -> Result<Option<Note>> {
    let Some(first_cell) = plan.smallest_first_cell else {
        return Ok(None);
    };
    let layers = || plan.layers.iter().zip(selections);
    let noise: f64 = layers()
        .map(|(layer, own)| round_off(layer, &own.interpolant))
        .sum();
    if noise <= TOLD * first_cell {
        return Ok(None);
    }
    let works = |halvings: usize| {
        let part = 0.5_f64.powi(halvings as i32);
        let tried = layers()
            .map(|(layer, own)| with_radius(plan, layer, own, part))
            .sum::<Option<f64>>();
        let tried = tried.filter(|noise| *noise <= 0.5 * TOLD * first_cell)?;
        Some((part * plan.basis.radius, tried))
    };
    let works = (1..=TRIES).find_map(works);
    let part = |noise: f64| format!("{}%", in_digits(100.0 * noise / first_cell, 2));
    let advice = match works {
        Some((radius, noise)) => format!(
            "the same base points with `support_radius` = {} make it {}",
            in_digits(radius, 3),
            part(noise)
        ),
        None => "no smaller support radius was found that would help; a kernel of lower order may"
            .to_owned(),
    };
    let note = note!(
        "round_off",
        "round-off moves nodes by about {noise:.1e}, which is {} of the smallest first cell {}: the weights of {} \
         with a support radius of {} are large and cancel; {advice}",
        part(noise),
        in_digits(first_cell, 3),
        plan.basis.kernel.name(),
        short(plan.basis.radius)
    );
    if noise > REFUSED * first_cell {
        return Err(Error::check(note.text).file(&plan.schedule.path));
    }
    Ok(Some(note.with("works", works.map(|(radius, _)| radius))))
}

/// Returns the round-off at volume nodes due to the weights of a layer, in mesh units.
fn round_off(layer: &Layer, interpolant: &Interpolant) -> f64 {
    let criterion = &layer.criterion;
    let rows = interpolant.weights.chunks_exact(criterion.n_modes().max(1));
    let arms = longest(&layer.lever_arms, criterion.n_parts());
    let squares = rows.map(|row| criterion.exact(row, &arms).powi(2));
    PER_WEIGHT * f64::EPSILON * squares.sum::<f64>().sqrt()
}

/// Returns the longest lever arm of each part.
fn longest(lever_arms: &[f64], n_parts: usize) -> Vec<f64> {
    let mut longest = Vec::new();
    for arms in lever_arms.chunks_exact(n_parts.max(1)) {
        longest.resize(arms.len(), 0.0);
        for (most, arm) in longest.iter_mut().zip(arms) {
            *most = f64::max(*most, *arm);
        }
    }
    longest
}

/// Returns the round-off of the same base points with a part of the support radius; `None` if the system cannot be solved.
fn with_radius(plan: &Plan, layer: &Layer, selection: &Selection, part: f64) -> Option<f64> {
    let r = layer.criterion.n_modes();
    let basis = layer.space.basis;
    let space = Space {
        basis: Basis {
            radius: part * basis.radius,
            ..basis
        },
        ..layer.space.clone()
    };
    let rows = selection
        .base
        .iter()
        .flat_map(|&at| &layer.interpolated()[at * r..][..r]);
    let values: Vec<f64> = rows.copied().collect();
    let interpolant = space.interpolant(&plan.surface.points, &selection.base, &values);
    interpolant
        .ok()
        .map(|interpolant| round_off(layer, &interpolant))
}
