//! Moves nodes until the least scaled Jacobian has the wanted value, or cannot be raised.
//!
//! Cells below are given regular targets, with a weight that grows from round to round; a patch in which the least scaled
//! Jacobian does not rise, or a cell becomes invalid, is put back.

use super::nearby::Nearby;
use super::regions::{self, Region};
use super::solve::{PatchTargets, Solved, solve};
use super::{Limits, PatchLog, Task, still_invalid};
use crate::scaled_jacobians;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, distance};
use azimesh_core::progress::Stop;
use std::collections::BTreeSet;

/// Largest number of rounds.
const ROUNDS: usize = 8;
/// Rings of neighbours around low cells.
const RINGS: usize = 2;
/// The weight of low cells grows by this factor.
const GROWTH: f64 = 3.0;
/// A round that lifts the least value by less than this part of what is missing is the last.
const LEAST_GAIN: f64 = 0.01;

/// Improves the checked cells whose scaled Jacobian is below `wanted`; a log for each patch of the last round that
/// improved one. The result is the same on any number of threads.
///
/// # Errors
/// If `stop` was requested.
pub fn improve(
    task: Task<'_>,
    points: &mut [Vector],
    wanted: f64,
    limits: Limits,
    stop: &Stop,
) -> Result<Vec<PatchLog>> {
    let mut logs = Vec::new();
    if super::refused(task.mesh).is_some() {
        return Ok(logs);
    }
    let nearby = Nearby::new(task.mesh);
    let mut weight = 1.0;
    let mut last = f64::NEG_INFINITY;
    for round in 0..ROUNDS {
        let values = scaled_jacobians(task.mesh, points, task.reference);
        let low: Vec<u32> = (0..)
            .zip(&values)
            .filter(|(_, value)| **value < wanted)
            .map(|(cell, _)| cell)
            .collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        if low.is_empty() || least - last < LEAST_GAIN * (wanted - least) {
            break;
        }
        last = if round == 0 { last } else { least };
        let set: BTreeSet<u32> = low.iter().copied().collect();
        let (regions, _) = regions::around(&nearby, task.freedom, &low, RINGS + round);
        let solved = azimesh_core::parallel::try_map(regions.len(), &|i| {
            let between = low.iter().copied().collect();
            let wishes = PatchTargets {
                between: &between,
                low: &set,
                weight,
            };
            solve(task, &regions[i], points, wishes, limits.most_steps, stop)
        })?;
        let before = place(&solved, points);
        let now = scaled_jacobians(task.mesh, points, task.reference);
        let mut accepted = Vec::new();
        for ((region, solved), before) in regions.iter().zip(&solved).zip(before) {
            let rises = least_of(region, &now) > least_of(region, &values);
            if rises && still_invalid(task, &region.cells, points).is_empty() {
                accepted.push(log(region, solved, &before, RINGS + round));
                continue;
            }
            for (&(node, _), place) in solved.moved.iter().zip(before) {
                points[node as usize] = place;
            }
        }
        if !accepted.is_empty() {
            logs = accepted;
        }
        weight *= GROWTH;
    }
    Ok(logs)
}

/// Puts the nodes of all regions at their new positions; returns their old ones.
fn place(solved: &[Solved], points: &mut [Vector]) -> Vec<Vec<Vector>> {
    let mut before = Vec::with_capacity(solved.len());
    for solved in solved {
        let moved = solved.moved.iter();
        before.push(
            moved
                .map(|&(node, place)| std::mem::replace(&mut points[node as usize], place))
                .collect(),
        );
    }
    before
}

/// The least scaled Jacobian of a region.
fn least_of(region: &Region, values: &[f64]) -> f64 {
    let own = region.cells.iter().map(|&cell| values[cell as usize]);
    own.filter(|value| !value.is_nan())
        .fold(f64::INFINITY, f64::min)
}

fn log(region: &Region, solved: &Solved, before: &[Vector], rings: usize) -> PatchLog {
    let moves = solved
        .moved
        .iter()
        .zip(before)
        .map(|((_, place), before)| distance(*place, *before));
    PatchLog {
        first_cell: region.seeds.first().map_or(0, |&cell| cell as usize),
        n_cells: region.cells.len(),
        n_nodes: region.moving.len(),
        rings,
        steps: solved.course.steps,
        iterations: solved.course.iterations,
        least_before: solved.least_before,
        least: solved.course.state.least,
        largest_move: moves.fold(0.0, f64::max),
        ..PatchLog::default()
    }
}
