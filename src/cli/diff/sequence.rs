//! Two sequences, step by step.

use super::told::{self, MeshDifference};
use super::{Context, DiffArgs, Differences, Input};
use azimesh_core::error::{Result, counted, one_line};
use azimesh_core::numbers::short;
use azimesh_io::mesh::Difference;
use serde::Serialize;

/// Tolerance of times, as a part of the last one.
const TIMES: f64 = 1e-9;

/// A step that both sequences have.
struct Compared {
    time: f64,
    difference: Difference,
}

/// Compares the steps that both have; returns whether all are equal.
pub fn compare(
    args: &DiffArgs,
    [(a, ours), (b, theirs)]: [(&Input, &[f64]); 2],
    context: &Context,
) -> Result<bool> {
    let mut steps = Vec::new();
    for (step, time) in ours.iter().enumerate().take(theirs.len()) {
        let meshes = [a, b].map(|input| input.mesh(Some(step), context));
        let [x, y] = meshes;
        steps.push(Compared {
            time: *time,
            difference: args.difference(&x?, &y?, context)?,
        });
    }
    let frame = frame_differences(ours, theirs);
    let same = frame.is_empty() && steps.iter().all(|step| step.difference.is_same());
    let summary = summary(&frame, &steps);
    if context.common.json {
        let found = as_json(same, summary, [ours, theirs], &steps);
        context.print_json(&Differences::Sequences(found))?;
        return Ok(same);
    }
    let mut text = String::new();
    if context.common.verbose > 0 {
        for (i, step) in different(&steps) {
            let what = step.difference.what_differs();
            text += &format!(
                "  step {i}, time {}: {}\n",
                short(step.time),
                one_line(&what)
            );
            text += &told::details(&step.difference, "    ");
        }
    }
    super::tell(&summary, &text, same, context)?;
    Ok(same)
}

/// Returns differences of the sequences themselves: number of steps, times.
fn frame_differences(ours: &[f64], theirs: &[f64]) -> Vec<String> {
    let mut found = Vec::new();
    if ours.len() != theirs.len() {
        found.push(format!("{} and {} steps", ours.len(), theirs.len()));
    }
    let largest = ours
        .iter()
        .fold(0.0, |largest: f64, time| largest.max(time.abs()));
    let differs = |(x, y): (&f64, &f64)| (x - y).abs() > TIMES * largest;
    if let Some(step) = ours.iter().zip(theirs).position(differs) {
        let [x, y] = [ours, theirs].map(|times| times[step]);
        found.push(format!("step {step} is at times {x} and {y}"));
    }
    found
}

fn different(steps: &[Compared]) -> impl Iterator<Item = (usize, &Compared)> {
    let numbered = steps.iter().enumerate();
    numbered.filter(|(_, step)| !step.difference.is_same())
}

/// Returns the step with the largest distance of nodes, the first of several; `None` if no node has moved.
fn worst(steps: &[Compared]) -> Option<(usize, &Compared)> {
    let moved = steps
        .iter()
        .enumerate()
        .filter(|(_, step)| step.difference.max_distance() > 0.0);
    moved.reduce(|worst, next| {
        let is_worse = next.1.difference.max_distance() > worst.1.difference.max_distance();
        if is_worse { next } else { worst }
    })
}

fn summary(frame: &[String], steps: &[Compared]) -> String {
    let mut parts = frame.to_vec();
    if let Some((first, step)) = different(steps).next() {
        let (n, of) = (different(steps).count(), steps.len());
        let what = step.difference.what_differs();
        parts.push(format!(
            "{n} of {}, the first is step {first}: {what}",
            counted(of, "step")
        ));
        if let Some((worst, step)) = worst(steps).filter(|(worst, _)| *worst != first) {
            let furthest = step.difference.max_distance();
            parts.push(format!(
                "the worst is step {worst}, nodes up to {} apart",
                short(furthest)
            ));
        }
    }
    if !parts.is_empty() {
        return format!("different: {}", parts.join("; "));
    }
    let apart = worst(steps).map_or(String::new(), |(at, step)| {
        let furthest = short(step.difference.max_distance());
        format!(", nodes at most {furthest} apart (step {at})")
    });
    let first = steps.first().map(|step| &step.difference);
    let [nodes, cells] = first.map_or([0; 2], |first| [first.n_nodes[0], first.n_cells[0]]);
    format!(
        "same: {}, {}, {}{apart}",
        counted(steps.len(), "step"),
        counted(nodes, "node"),
        counted(cells, "cell")
    )
}

fn as_json(
    same: bool,
    summary: String,
    times: [&[f64]; 2],
    steps: &[Compared],
) -> SequenceDifference {
    let worst = worst(steps);
    let step = |(step, found): (usize, &Compared)| StepDifference {
        step,
        time: found.time,
        difference: MeshDifference::of(&found.difference),
    };
    SequenceDifference {
        same,
        summary,
        times: times.map(<[f64]>::to_vec),
        max_distance: worst.map_or(0.0, |(_, step)| step.difference.max_distance()),
        worst_step: worst.map(|(at, _)| at),
        steps: steps.iter().enumerate().map(step).collect(),
    }
}

/// The difference of two sequences.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SequenceDifference {
    /// True if they are the same.
    same: bool,
    /// The line that is printed without `--json`.
    summary: String,
    /// Times of both sequences.
    times: [Vec<f64>; 2],
    /// Largest distance of two nodes at any step, mesh units.
    max_distance: f64,
    /// The step with that distance; null where no node differs.
    worst_step: Option<usize>,
    /// Every step.
    steps: Vec<StepDifference>,
}

/// A step.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct StepDifference {
    /// Its number, from 0.
    step: usize,
    /// Its time in the first sequence.
    time: f64,
    #[serde(flatten)]
    difference: MeshDifference,
}
